"""Contact patches in three dimensions: ellipses, conforming bodies, and true profiles of a wheel and a rail."""

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from flangeway.contact.patch.normal_contact import Convolution, solve_normal
from flangeway.contact.patch.patch_contact import PatchContact, PatchPair, press_patch
from flangeway.contact.patch.patch_grid import Axis, PatchBody, grid_about
from flangeway.elements import Lagrange
from flangeway.exact import PointContact, contact_modulus, half_space_influence
from flangeway.geometry import Arc, Contour, Line, Outline, Placement
from flangeway.geometry.arrays import middles_of
from flangeway.materials import Elastic
from flangeway.mesh import Refinement, triangulate
from flangeway.problems import Elasticity, Harmonic
from flangeway.railway.profiles.bundled import wheel
from flangeway.railway.profiles.joining import pieces_between
from flangeway.railway.track.placements import Track
from flangeway.space import Space
from flangeway.types import Floats
from flangeway_studies.study import Row, Run, published_values

# --- Contact patches in three dimensions: Hertz's ellipses, and conforming bodies.


HERTZ_STEEL = Elastic(210e3, 0.3)
RADIUS, RATIOS = 300.0, (1.0, 2.0, 5.0, 20.0)
"""Radius in mm of the prism's crown, and those of the cylinders across it, over the crown's."""
SEMI_AXIS = 4.0
"""Smaller semi-axis in mm, which the force is chosen for."""
HALF_BLOCK, DEPTH = 200.0, 300.0
"""Half width and depth of the blocks in mm."""
LIMITS = {"a_mm": 3e-3, "b_mm": 3e-3, "p0_MPa": 2e-3, "approach_mm": 5e-3}

STEEL = Elastic(209920.0, 0.28)
"""G = 82000 MPa, as published for the conforming bodies."""
CONVEX, CONCAVE, ROLLING, ANGLE = 10.0, 10.2, 460.0, np.pi / 4.0
"""Radii across of rail and wheel, radius of the wheel at the contact, and the angle of the contact, as published."""
CONFORMAL_CELL = 0.2
CONFORMAL_WINDOW = (13.5, 17.0)
CONFORMAL_APPROACH = 0.09089
ARM = 50.0
"""Length of the flat sides of both bodies beyond their arcs in mm, and the wheel's depth behind them."""
HERTZ_SIZES, CONFORMAL_SIZES, BLOCK_SIZES = (0.25, 40.0), (0.35, 12.0), (0.3, 3.0)
"""Edges in the contact and elsewhere in mm."""
CONFORMAL_LIMITS = {"force": 5e-3, "p0": 5e-3, "area": 0.03}
BODIES_CELL, BODIES_WINDOW = 0.4, (14.4, 24.0)
BLOCK_MESHES = ("1", "0.7")
"""Edges of CalculiX's elements in mm."""
BODIES_LIMITS, BLOCK_LIMIT = {"p0": 0.03, "area": 0.06}, 0.01


@dataclass(frozen=True)
class Blocks:
    """Two conforming blocks, sectors of rings about one another: lengths in mm, angles from the vertical.

    The lower one is held at its inner arc. The upper one's surface turns about an axis at a distance `rolling` above
    the first touch; it is moved down at its outer arc.
    """

    inner: float = 4.0
    convex: float = 10.0
    concave: float = 10.2
    outer: float = 22.0
    rolling: float = 300.0
    lower_angle: float = np.pi / 2.0
    upper_angle: float = 1.3
    approach: float = 0.04


BLOCK = Blocks()


def hertz_rows(run: Run) -> Iterator[Row]:
    """Semi-axes, maximum pressure and approach of a crowned prism below cylinders of several radii."""
    modulus = contact_modulus(HERTZ_STEEL.plane_modulus, HERTZ_STEEL.plane_modulus)
    for ratio in RATIOS:
        code = f"hertz_{RADIUS:g}_{RADIUS * ratio:g}"
        unit = PointContact(1e3, RADIUS, RADIUS * ratio, modulus)
        force = round(1e3 * (SEMI_AXIS / min(unit.semi_axes)) ** 3, -2)
        contact = press_patch(crowned("prism", RADIUS), crowned("cylinder", None, RADIUS * ratio), force=force)
        run.check(code, contact.status)
        exact, patch = PointContact(force, RADIUS, RADIUS * ratio, modulus), contact.patches[0]
        correction = force * _block_constant(contact, HERTZ_STEEL)
        values = (
            (max(exact.semi_axes), patch.semi_axes[0]),
            (min(exact.semi_axes), patch.semi_axes[1]),
            (exact.max_pressure, patch.max_pressure),
            (exact.approach, contact.approach - correction),
        )
        note = f"{force:g} N; the finite blocks add {correction:.4f} mm to the approach"
        for (name, limit), (wanted, value) in zip(LIMITS.items(), values, strict=True):
            yield Row("Hertz", code, name, name.rpartition("_")[2], value, wanted, limit, note)


def _block_constant(contact: PatchContact, material: Elastic) -> float:
    """Displacement of both bodies by a unit force at the end of the window, less that of half-spaces."""
    grid = contact.pair.grid
    middle, last = len(grid.widths) // 2, grid.n_strips - 1
    exact = half_space_influence(material.young, material.poisson, grid.bounds, grid.strip, last + 1, (1,))
    total = sum(
        float(table.influence(grid.strip, last + 1, axes=(1,))[last, middle, middle]) for table in contact.pair.tables
    )
    return total - 2.0 * float(exact[last, middle, middle])


def crowned(name: str, crown: float | None, turning: float | None = None) -> PatchBody:
    """Return a prism below y = 0 with a round top, or a cylinder about an axis above y = 0, held at its other end."""
    half, up = HALF_BLOCK, -1.0 if crown is None else 1.0
    drop = 0.0 if crown is None else float(np.sqrt(crown**2 - half**2)) - crown
    first, second, *others = (half * up, drop), (-half * up, drop), (-half * up, -DEPTH * up), (half * up, -DEPTH * up)
    top = Line(first, second) if crown is None else Arc(first, second, (0.0, -crown), counter_clockwise=True)
    outline = Outline.closed([top], others, ["surface", "left", "held", "right"])
    zone = np.array([[-2.0 * SEMI_AXIS, 0.0], [2.0 * SEMI_AXIS, 0.0]])
    return patch_body(name, outline, HERTZ_STEEL, zone, HERTZ_SIZES, None if turning is None else Axis((0.0, turning)))


def patch_body(
    name: str, outline: Outline, material: Elastic, zone: Floats, sizes: tuple[float, float], axis: Axis | None = None
) -> PatchBody:
    """Mesh a body that is held at its sides ``held...`` and touched at ``surface...``."""
    mesh = triangulate(outline, size=sizes[1], refinements=[Refinement(zone, sizes[0], 0.3)])
    names = dict.fromkeys(outline.names)
    touched, held = ([name for name in names if name.startswith(what)] for what in ("surface", "held"))
    body = Elasticity(Space(mesh, Lagrange(2)), material, name=name)
    edges = np.vstack([mesh.edge_set(name) for name in touched]).astype(np.int64)
    return PatchBody(Harmonic(body, held=dict.fromkeys(held, "xyz")), edges, outline.part(touched), axis=axis)


# conforming bodies


def half_space_contact(gap: str) -> tuple[float, float, float]:
    """Sum of the forces, maximum pressure and area of the published bodies by the coefficients of half-spaces."""
    n_cells, n_strips = (round(length / CONFORMAL_CELL) for length in CONFORMAL_WINDOW)
    bounds: Floats = CONFORMAL_CELL * (np.arange(n_cells + 1, dtype=np.float64) - n_cells / 2.0)
    along: Floats = CONFORMAL_CELL * (np.arange(n_strips, dtype=np.float64) - (n_strips - 1) / 2.0)
    single = half_space_influence(STEEL.young, STEEL.poisson, bounds, CONFORMAL_CELL, n_strips, (1,))
    gaps, shares = published_gaps(bounds, along, gap)
    contact = solve_normal(Convolution(2.0 * single), gaps, approach=CONFORMAL_APPROACH, share=shares)
    pressures = contact.forces / CONFORMAL_CELL**2
    return contact.forces.sum(), pressures.max(), (pressures > 0.0).sum() * CONFORMAL_CELL**2


def published_gaps(bounds: Floats, along: Floats, gap: str) -> tuple[Floats, Floats]:
    """Gaps of the published bodies along the normals of the rail, and the normals' share along that of the contact.

    Parameters
    ----------
    bounds
        Ends of the cells as arc lengths on the rail from the contact.
    along
        Middles of the strips.
    gap
        ``"parabolic"``, or ``"half-space"``: arcs across, and along z the one curvature that the published numbers
        have. The wheel's is smaller on one side, where its surface is steeper.

    """
    middles = middles_of(bounds)
    if gap == "parabolic":
        across = middles**2 * (1.0 / CONVEX - 1.0 / CONCAVE) / 2.0
        return across[:, None] + along**2 * np.cos(ANGLE) / ROLLING / 2.0, np.ones((len(middles), 1))
    angles, apart = middles / CONVEX, CONCAVE - CONVEX
    # from the rail's centre; the wheel's is lower along the normal of the contact
    radii = np.sqrt(CONCAVE**2 - (apart * np.sin(angles)) ** 2) - apart * np.cos(angles)
    across, shares = (radii - CONVEX)[:, None], np.cos(angles)[:, None]
    return across + along**2 * np.cos(ANGLE) / ROLLING / 2.0, shares


def conforming_bodies() -> tuple[PatchBody, PatchBody]:
    """Rail and wheel with flat sides, turned so that the normal of the contact is along y."""
    sine, cosine = float(np.sin(ANGLE)), float(np.cos(ANGLE))
    bodies = []
    for name, radius, upper in (("rail", CONVEX, False), ("wheel", CONCAVE, True)):
        turn = -1.0 if upper else 1.0
        end = np.array([radius * sine, radius * (cosine - 1.0)])
        foot = end + ARM * np.array([cosine, -sine])
        beyond = foot + ARM * np.array([sine, cosine])
        right, far, out = ((float(turn * x), float(y)) for x, y in (end, foot, beyond))
        left, other, back = ((-x, y) for x, y in (right, far, out))
        arc = Arc(right, left, (0.0, -radius), counter_clockwise=not upper)
        others, names = (
            ([back, (0.0, out[1] + abs(out[0])), out], ["end", "held", "held too", "start"])
            if upper
            else ([], ["held"])
        )
        names = ["surface before", "surface", "surface after", *names]
        outline = Outline.closed([Line(far, right), arc, Line(left, other)], others, names)
        zone = _top_of_circle(radius, ANGLE, 41)
        axis = Axis((-ROLLING * sine, ROLLING * cosine), (cosine, sine)) if upper else None
        bodies.append(patch_body(name, outline, STEEL, zone, CONFORMAL_SIZES, axis))
    return bodies[0], bodies[1]


def _top_of_circle(radius: float, angle: float, n: int) -> Floats:
    """Points (n, 2) of a circle below the origin, up to an angle to both sides of its top there."""
    angles = np.linspace(-angle, angle, n)
    return radius * np.stack((np.sin(angles), np.cos(angles) - 1.0), axis=1)


def conforming_blocks() -> tuple[PatchBody, PatchBody]:
    """Both sectors of `BLOCK`, their first touch at the origin."""
    bodies = []
    for name, radius, held, half in (
        ("lower", BLOCK.convex, BLOCK.inner, BLOCK.lower_angle),
        ("upper", BLOCK.concave, BLOCK.outer, BLOCK.upper_angle),
    ):
        upper = held > radius
        centre = (0.0, -radius)
        turn = -1.0 if upper else 1.0
        sine, height = turn * float(np.sin(half)), float(np.cos(half))
        right, left, inside, back = (
            (x * distance, distance * height - radius)
            for x, distance in ((sine, radius), (-sine, radius), (-sine, held), (sine, held))
        )
        top = Arc(right, left, centre, counter_clockwise=not upper)
        bottom = Arc(inside, back, centre, counter_clockwise=upper)
        outline = Outline.from_segments(
            [top, Line(left, inside), bottom, Line(back, right)], ["surface", "left", "held", "right"]
        )
        zone = _top_of_circle(radius, 0.6, 31)
        axis = Axis((0.0, BLOCK.rolling)) if upper else None
        bodies.append(patch_body(name, outline, STEEL, zone, BLOCK_SIZES, axis))
    return bodies[0], bodies[1]


def conforming_rows(run: Run) -> Iterator[Row]:
    """Forces and pressures beside the published half-space, the published finite elements, and CalculiX."""
    first, second = conforming_bodies()
    bodies = PatchPair(first, second, grid_about(first, second, BODIES_CELL, BODIES_WINDOW))
    block = press_patch(*conforming_blocks(), approach=BLOCK.approach)
    run.check("block", block.status)
    published, units = published_values("spatial.csv", "conformal"), {"force": "N", "p0": "MPa", "area": "mm2"}
    for gap in ("parabolic", "half-space"):
        for (name, unit), value in zip(units.items(), half_space_contact(gap), strict=True):
            yield Row("Conformal", gap, name, unit, value, published[gap, name], CONFORMAL_LIMITS[name])
    # the published gap on the real bodies, with the published sum of forces
    grid, code = bodies.grid, "finite_elements"
    gaps, shares = published_gaps(grid.bounds - bodies.first.length / 2.0, grid.along, "half-space")
    total = published[code, "force"]
    trial = solve_normal(bodies.influence, gaps, force=total, share=shares)
    contact = solve_normal(bodies.influence, gaps, force=total**2 / trial.forces.sum(), share=shares)
    cells = grid.widths[:, None] * grid.strip
    values = (contact.forces / cells).max(), ((contact.forces > 0.0) * cells).sum()
    note = "by the real bodies at the published force; the published ones and their supports are not known"
    for name, value in zip(("p0", "area"), values, strict=True):
        yield Row("Conformal", code, name, units[name], value, published[code, name], BODIES_LIMITS[name], note)
    peer = calculix("block", BLOCK_MESHES)
    for name, value in (("force", block.force[1]), ("p0", block.pressures.max())):
        exact, note = peer[name]
        yield Row("Conformal", "block", name, units[name], value, exact, BLOCK_LIMIT, note)


def calculix(case: str, meshes: tuple[str, str]) -> dict[str, tuple[float, str]]:
    """What CalculiX found, extrapolated over the square of the elements' edges, and a note on it, by quantity."""
    values, ratio = published_values("spatial.csv", case), float(meshes[0]) / float(meshes[1])
    results = {}
    for name in dict.fromkeys(name for _, name in values):
        coarse, fine = (values[mesh, name] for mesh in meshes)
        note = f"by C3D20 of CalculiX, {fine:.6g} with edges of {meshes[1]} mm, extrapolated over their square"
        results[name] = fine + (fine - coarse) / (ratio**2 - 1.0), note
    return results


# --- A wheel S1002 on a rail 60E1: true profiles, cut to blocks, beside C3D20 of CalculiX.


GAUGE, GAUGE_DEPTH, INCLINATION, BACK_TO_BACK, WHEEL_RADIUS = 1435.0, 14.0, 1.0 / 40.0, 1360.0, 460.0
LATERAL = 2.0
"""Of the wheelset from the middle of the track in mm: the patch lies on two arcs of the rail's crown."""
HALF, BLOCK_DEPTH, LENGTH = 16.0, 25.0, 60.0
"""Half width of the blocks about the contact, their depth behind it, and their length along the rail in mm."""
APPROACH = 0.07
"""From first touch in mm."""
EDGES, CELL, WINDOW = (0.25, 3.0), 0.3, (16.8, 16.8)
"""Edges in the contact and elsewhere, cells, and window in mm."""
MESHES = ("1.2", "0.8")
"""Edges of CalculiX's elements in mm."""
LIMIT, PLACE = 0.02, 0.05
"""Largest relative difference, and distance of the centres of pressure in mm."""


def cut_surfaces() -> tuple[Contour, Contour, float]:
    """Surfaces of rail and wheel within the blocks, their first touch at the origin, and the height of the axle."""
    track = Track(rail="60E1", gauge_mm=GAUGE, inclination=INCLINATION, gauge_depth_mm=GAUGE_DEPTH)
    profile = wheel("S1002")
    placement = Placement(translation=(BACK_TO_BACK / 2.0 + profile.flange_back_mm + LATERAL, 0.0))
    lower = track.rail_of("right").running_surface.transformed(track.placement("right"))
    upper = profile.running_surface.transformed(placement)
    x = np.arange(lower.bounds()[0, 0] + 1.0, lower.bounds()[1, 0] - 1.0, 1e-3)
    low, high = heights(lower, x), heights(upper, x)
    first = int((high - low).argmin())
    moves = [Placement(translation=(-x[first], -float(heights_at[first]))) for heights_at in (low, high)]
    lower, upper = (_cut(surface.transformed(move)) for surface, move in zip((lower, upper), moves, strict=True))
    return lower, upper, WHEEL_RADIUS - float(high[first])


def heights(surface: Contour, x: Floats) -> Floats:
    """Heights of a surface at places x, to 1e-7 mm."""
    points = surface.sampled(spacing=2e-3)
    order = np.argsort(points[:, 0])
    return np.interp(x, points[order, 0], points[order, 1])


def _cut(surface: Contour) -> Contour:
    """The piece of a surface between -HALF and HALF."""
    points = np.array([[x, heights(surface, np.array([x]))[0]] for x in (-HALF, HALF)])
    segments = [segment for _, segment in pieces_between(surface, *sorted(surface.lengths_at(points).tolist()))]
    return Contour.from_segments(segments, ["surface"] * len(segments))


def profile_blocks() -> tuple[PatchBody, PatchBody]:
    """Rail held at its base, and wheel held on top, as prism and body of revolution."""
    *cut, axle = cut_surfaces()
    bodies = []
    for name, surface, level in zip(("rail", "wheel"), cut, (-BLOCK_DEPTH, BLOCK_DEPTH), strict=True):
        start, end = surface.ends
        corners, names = [(end[0], level), (start[0], level)], [*surface.names, "side", "held", "other side"]
        points = surface.sampled(spacing=0.2)
        zone = points[np.abs(points[:, 0]) < WINDOW[0] / 2.0 + 1.0]
        axis = Axis((0.0, axle)) if level > 0.0 else None
        outline = Outline.closed(surface.segments, corners, names)
        bodies.append(patch_body(name, outline, HERTZ_STEEL, zone, EDGES, axis))
    return bodies[0], bodies[1]


def pressed_profiles() -> PatchContact:
    """Both blocks under the force that CalculiX found."""
    bodies = profile_blocks()
    return press_patch(*bodies, force=calculix("profile", MESHES)["force"][0], grid=grid_about(*bodies, CELL, WINDOW))


def profile_numbers(contact: PatchContact) -> Iterator[Row]:
    """Maximum pressure, semi-axes, centre and approach beside CalculiX under the same force."""
    (patch,), peer = contact.patches, calculix("profile", MESHES)
    values = {"p0": patch.max_pressure, "along": patch.semi_axes[0], "across": patch.semi_axes[1]}
    for name, value in values.items():
        exact, note = peer[name]
        yield Row("S1002 on 60E1", "blocks", name, "MPa" if name == "p0" else "mm", value, exact, LIMIT, note)
    note = f"under {peer['force'][0]:.0f} N"
    yield Row("S1002 on 60E1", "blocks", "approach", "mm", contact.contact.approach, APPROACH, LIMIT, note)
    centre = peer["x"][0], patch.centre[0]
    words, note = f"{PLACE:g} mm", "centre of pressure from first touch"
    yield Row("S1002 on 60E1", "blocks", "x", "mm", centre[1], centre[0], words, note)
