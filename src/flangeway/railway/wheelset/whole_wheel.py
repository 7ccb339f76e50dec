"""Whole wheels as bodies of revolution held at their bores, and the bending of the axle between them."""

from dataclasses import dataclass, fields, replace

import numpy as np
from scipy.interpolate import CubicSpline

from flangeway.checks import as_numbers, check_finite, check_positive
from flangeway.elements import Lagrange
from flangeway.elements.quadrature import gauss
from flangeway.errors import InputError
from flangeway.geometry import Outline, Placement
from flangeway.geometry.arrays import chain_lengths, nearest_on_segments
from flangeway.geometry.segments import segment_of
from flangeway.geometry.shapes import rounded_sides
from flangeway.mesh import Refinement, triangulate
from flangeway.problems import Elasticity, Harmonic
from flangeway.railway.profiles.bundled import WheelProfile
from flangeway.solve import SurfaceCells
from flangeway.solve.surface_compliance import compliances
from flangeway.space import Space
from flangeway.system.disk_cache import Cache, cached
from flangeway.types import Floats

# --- Bending of a wheelset's axle by the forces on its wheels, by beam theory.


INCH = 25.4  # mm

CLASS_F = (
    (0.0, 7.375), (23.625, 7.875), (23.625, 8.75), (31.25, 8.75), (31.25, 7.53), (34.25, 7.53), (34.25, 6.19),
    (44.8, 6.19),
)  # fmt: skip
"""Half of an axle of class F (6 1/2 x 12) of the AAR: distance from the middle and diameter in inches."""


@dataclass(frozen=True)
class Axle:
    """An axle, symmetric about its middle, on two journals that carry the load.

    Class F of the AAR (Manual of Standards, Section G-II, table of axle journal dimensions) by default: journals 79 in
    apart and of 6.19 in, wheel seats of 8.75 in, a body of 7.875 in that tapers to 7.375 in. The ends of the wheel
    seats are inferred from 62.5 in between their outer ends and their length of 7.625 in.

    Parameters
    ----------
    journals_mm
        Distance between the middles of the journals; less than that of the wheels for inside journals.
    diameters_mm
        Distances from the middle, from 0 on and not falling, and diameters there; linear between them.
    young
        Young's modulus in MPa.

    Raises
    ------
    InputError
        If a dimension is not positive, or the distances fall.

    """

    journals_mm: float = 79.0 * INCH
    diameters_mm: tuple[tuple[float, float], ...] = tuple((INCH * x, INCH * d) for x, d in CLASS_F)
    young: float = 210e3

    def __post_init__(self) -> None:
        for name in ("journals_mm", "young"):
            check_positive("Axle", name, getattr(self, name))
        drawn = as_numbers("Axle: diameters_mm", self.diameters_mm)
        if drawn.ndim != 2 or drawn.shape[1] != 2 or drawn[0, 0] != 0.0 or (np.diff(drawn[:, 0]) < 0.0).any():
            raise InputError(
                f"Axle: diameters_mm of shape {drawn.shape}", "pairs (distance, diameter) from 0", "order them"
            )
        if not (np.isfinite(drawn).all() and (drawn[:, 1] > 0.0).all()):
            raise InputError("Axle: diameters_mm that are not all positive", "positive diameters", "correct them")

    def tilts(self, positions: Floats, forces: Floats) -> Floats:
        """Rotations of both wheel seats against the line through them, in rad, counter-clockwise.

        Parameters
        ----------
        positions
            Positions of the left and the right wheel along the axle from its middle, in mm, (2,); rising.
        forces
            What acts on each at the axle's centre line: the force upwards in N, and the counter-clockwise moment in
            N mm; (2, 2). Forces along the axle do not bend it. The journals keep the equilibrium.

        Raises
        ------
        InputError
            If the wheels are not left and right of each other on the axle.

        """
        drawn = np.array(self.diameters_mm)
        left, right = (float(position) for position in positions)
        if not -drawn[-1, 0] <= left < right <= drawn[-1, 0]:
            raise InputError(
                f"wheels at {left:g} and {right:g} mm on an axle that ends at {drawn[-1, 0]:g} mm",
                "the left wheel before the right one, both on the axle",
                "correct the positions, or give a longer axle",
            )
        half = self.journals_mm / 2.0
        up, moments = forces.T
        turning = float(up @ positions + moments.sum()) / half
        journals = np.array([turning - up.sum(), -turning - up.sum()]) / 2.0
        ends = np.unique(np.clip([left, right, half, -half, *drawn[:, 0], *-drawn[:, 0]], left, right))
        points, weights = gauss(8)
        x = ends[:-1, None] + np.diff(ends)[:, None] * points
        # of what acts on the right of x
        bending = sum(np.maximum(at - x, 0.0) * force for at, force in zip((-half, half), journals, strict=True))
        bending = bending + (right - x) * up[1] + moments[1]
        diameter = np.interp(abs(x), drawn[:, 0], drawn[:, 1])
        turned = np.diff(ends)[:, None] * weights * bending / (self.young * np.pi * diameter**4 / 64.0)
        share = (x - left) / (right - left)
        return np.array([-((1.0 - share) * turned).sum(), (share * turned).sum()])


# --- Whole wheels, rim, web and hub, as bodies of revolution held at their bores.
#
# Contact takes the prism of a wheel's rim, held at its cut. What the whole wheel gives more is almost the same for all
# strips of a patch: it is added as one matrix for the row of cells across. Waves around the wheel are summed one by one
# for n <= 8 and by a spline over log n beyond, each less that of the prism of the same length along the surface.


N_SINGLE_HARMONICS = 8
"""Harmonics that are computed each."""
HARMONICS_PER_DECADE = 4
"""Those beyond for each decade."""
SHORTEST_MM = 20.0
"""Wave along the surface beyond which prism and wheel are the same."""
BODY_MM = 7.0
"""Edges of the mesh of a whole wheel away from its cells."""
EDGES_A_CELL = 3.0
"""Those at the cells for each of them; for the shortest wave `EDGES_A_WAVE`."""
EDGES_A_WAVE = 8.0
GROWTH = 0.3
OFF_MM = 0.5
"""Distance of cells from a wheel's outline that is more than a chord's."""
FACES = ("outer_face", "cut", "back_face")
RUNNING = "running surface"
"""Side of the polygon of the parts in whose place the running surface is."""


@dataclass(frozen=True)
class WheelDisc:
    """Dimensions of a monobloc wheel inside of its running surface, in mm, x from the tape line.

    Those by default are assumed: a wheel of 920 mm of usual proportions, with a straight conical web and a wheel seat
    of 200 mm. No public source gives a drawing.

    Parameters
    ----------
    rim_mm
        Thickness of the rim above the tape line.
    web_mm
        Thickness of the web at the rim and at the hub.
    web_middle_mm
        Place x of the web's middle at the rim and at the hub.
    fillet_mm
        Radius of the four fillets between the web, rim and hub.
    hub_mm
        Places x of the hub's inner and outer face.
    hub_radius_mm, bore_radius_mm
        Radii of the hub and of its bore.

    Raises
    ------
    InputError
        If a length is not positive, or the hub has no thickness or length.

    """

    rim_mm: float = 65.0
    web_mm: tuple[float, float] = (22.0, 30.0)
    web_middle_mm: tuple[float, float] = (0.0, -25.0)
    fillet_mm: float = 35.0
    hub_mm: tuple[float, float] = (-115.0, 65.0)
    hub_radius_mm: float = 140.0
    bore_radius_mm: float = 100.0

    def __post_init__(self) -> None:
        for dimension in fields(self):
            value = getattr(self, dimension.name)
            for number in value if isinstance(value, tuple) else (value,):
                if dimension.name in ("web_middle_mm", "hub_mm"):
                    check_finite("WheelDisc", dimension.name, number)
                else:
                    check_positive("WheelDisc", dimension.name, number, "positive lengths", "give it in mm")
        if not (self.hub_mm[0] < self.hub_mm[1] and self.bore_radius_mm < self.hub_radius_mm):
            raise InputError(
                f"a hub from {self.hub_mm[0]:g} to {self.hub_mm[1]:g} mm and radii of {self.bore_radius_mm:g} "
                f"and {self.hub_radius_mm:g} mm",
                "an inner face left of the outer one, and a bore smaller than the hub",
                "exchange or correct them",
            )


def whole_wheel(profile: WheelProfile, radius_mm: float, disc: WheelDisc | None = None) -> WheelProfile:
    """Put rim, web and hub on the running surface of a wheel.

    Parameters
    ----------
    profile
        A bundled or measured wheel. What it has above its running surface is replaced.
    radius_mm
        Radius at the tape line.
    disc
        Dimensions; those of `WheelDisc` by default.

    Returns
    -------
    WheelProfile
        In the same frame. Its cut is the bore.

    Raises
    ------
    InputError
        If the parts do not fit each other.

    """
    disc = WheelDisc() if disc is None else disc
    kept = [(n, s) for n, s in zip(profile.outline.names, profile.outline.segments, strict=True) if n not in FACES]
    first = next(i for i in range(len(kept)) if kept[i][1].start != kept[i - 1][1].end)
    kept = [*kept[first:], *kept[:first]]
    back, outer = kept[0][1].start, kept[-1][1].end
    hub, bore = radius_mm - disc.hub_radius_mm, radius_mm - disc.bore_radius_mm
    (low, high), (at_rim, at_hub) = disc.web_mm, disc.web_middle_mm
    corners = [
        (outer, "outer_face", 0.0),
        ((outer[0], disc.rim_mm), "rim", 0.0),
        ((at_rim + low / 2.0, disc.rim_mm), "web", disc.fillet_mm),
        ((at_hub + high / 2.0, hub), "hub", disc.fillet_mm),
        ((disc.hub_mm[1], hub), "hub", 0.0),
        ((disc.hub_mm[1], bore), "cut", 0.0),
        ((disc.hub_mm[0], bore), "hub", 0.0),
        ((disc.hub_mm[0], hub), "hub", 0.0),
        ((at_hub - high / 2.0, hub), "web", disc.fillet_mm),
        ((at_rim - low / 2.0, disc.rim_mm), "rim", disc.fillet_mm),
        ((back[0], disc.rim_mm), "back_face", 0.0),
        (back, RUNNING, 0.0),
    ]
    positions, names, radii = zip(*corners, strict=True)
    heights = [positions[i][1] for i in (0, 1, 3, 5)]
    if (np.diff(heights) <= 0.0).any() or back[1] >= disc.rim_mm:
        raise InputError(
            f"a wheel of the radius {radius_mm:g} mm, its running surface up to {max(back[1], outer[1]):.4g} "
            f"mm above the tape line, its rim up to {disc.rim_mm:g} mm, its hub from {hub:.4g} to {bore:.4g} mm",
            "parts that follow each other",
            "correct the radii or the rim's thickness",
        )
    try:
        sides = rounded_sides(positions, radii, names)
    except InputError as error:
        raise InputError(
            "fillets of the web: " + error.given,
            "fillets that fit between the rim and the hub",
            "give a smaller fillet_mm, a thinner web, or another web_middle_mm",
        ) from error
    kept += [(side[4] if side[2] is None else "web", segment_of(*side[:4])) for side in sides if side[4] != RUNNING]
    outline = Outline.named(kept)
    return replace(
        profile,
        title=f"{profile.title} with web and hub",
        outline=outline,
        certainty=f"{profile.certainty} Rim, web and hub: dimensions as given, those by default assumed.",
    )


def wheel_correction(whole: WheelProfile, radius_mm: float, cells: SurfaceCells, cache: Cache | None = None) -> Floats:
    """What a whole wheel, held at its bore, gives more than the prism of its rim at the place of the force.

    Parameters
    ----------
    whole
        The wheel with web and hub; its ``cut`` is the bore.
    radius_mm
        Radius at the tape line.
    cells
        Cells of the prism, in the wheel's frame.
    cache
        Where results are kept from one process to the next.

    Returns
    -------
    Floats
        Mean displacements of cells by unit forces on cells, in mm/N, both in the cells' frames: (n, 3, n, 3).

    Raises
    ------
    InputError
        If the cells are not on the wheel's surface.

    """
    correction = cached(
        cache,
        lambda: {"values": _correction(revolved(whole, radius_mm, cells), cells)},
        "wheel",
        *cells.content,
        (whole.outline.segments, whole.outline.names, radius_mm, _SETTINGS),
    )
    return correction["values"]


_SETTINGS = (N_SINGLE_HARMONICS, HARMONICS_PER_DECADE, SHORTEST_MM, BODY_MM, EDGES_A_CELL, EDGES_A_WAVE, GROWTH)


def revolved(whole: WheelProfile, radius_mm: float, cells: SurfaceCells) -> SurfaceCells:
    """Cells at the same places of a running surface on the whole wheel as a body of revolution held at its bore.

    An `InputError` if they are not on it, or the material is not isotropic.
    """
    if cells.material is None:
        raise InputError("a wheel of several or anisotropic materials", "one isotropic material", "leave its web out")
    off = float(whole.outline.closest(cells.ends)[2].max())
    if off > OFF_MM:
        raise InputError(
            f"cells {off:.3g} mm from the outline of {whole.title}",
            "cells on the wheel's running surface, in its frame",
            "take the profile that the rim was meshed from",
        )
    size = min(SHORTEST_MM / EDGES_A_WAVE, float(cells.widths.min()) / EDGES_A_CELL)
    turned = Placement(np.pi / 2.0, (radius_mm, 0.0))  # x the radius, y along the axle
    zone = Refinement(turned.points(cells.ends), size, GROWTH)
    mesh = triangulate(whole.outline.transformed(turned), size=BODY_MM, refinements=[zone])
    chain = mesh.chain(*(name for name in dict.fromkeys(whole.outline.names) if name != "cut")).astype(np.int64)
    points, ends = mesh.points[chain], turned.points(cells.ends)
    lengths = chain_lengths(points)
    nearest, shares, _ = nearest_on_segments(ends, points[:-1], points[1:])
    bounds = lengths[nearest] + shares * np.diff(lengths)[nearest]
    material, name = replace(cells.material, hypothesis="axisymmetric"), cells.problem.elasticity.name
    problem = Harmonic(Elasticity(Space(mesh, Lagrange(2)), material, name=name), held={"cut": "xyz"})
    return SurfaceCells(problem, np.stack((chain[:-1], chain[1:]), axis=1), bounds)


def _correction(wheel: SurfaceCells, prism: SurfaceCells) -> Floats:
    """Sum of the harmonics of a wheel less those of a prism closed to a ring of the same length."""
    radii = wheel.middles[:, 0]
    mean = float(radii.mean())
    top = 2.0 * np.pi * mean / SHORTEST_MM
    steps = int(np.ceil(HARMONICS_PER_DECADE * np.log10(top / N_SINGLE_HARMONICS))) + 1
    numbers: Floats = np.append(np.arange(N_SINGLE_HARMONICS), np.geomspace(N_SINGLE_HARMONICS, round(top), steps))
    computed = compliances(wheel, numbers)
    more = computed - compliances(prism, numbers / mean) / mean
    # n times the difference is a spline over log n; the first and the last term count half
    weights = (numbers <= N_SINGLE_HARMONICS).astype(np.float64)
    weights[0] = 0.5
    between = np.arange(N_SINGLE_HARMONICS + 1, round(top) + 1)
    shares = np.where(between == between[-1], 0.5, 1.0) / between
    weights[1:] += shares @ CubicSpline(np.log(numbers[1:]), np.eye(len(numbers) - 1))(np.log(between)) * numbers[1:]
    result = np.tensordot(weights, more, axes=1).reshape(len(radii), 3, len(radii), 3)
    # cells at other radii reach the length of the last wave at another number
    last = (numbers[-1] * computed[-1]).reshape(result.shape)
    result += last * np.log((radii[:, None, None] + radii[:, None]) / (2.0 * mean))[:, None]
    result[:, 2, :, :2] = result[:, :2, :, 2] = 0.0  # odd around the place of the force
    return result / np.pi
