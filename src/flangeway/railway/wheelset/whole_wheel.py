"""Whole wheels as bodies of revolution held at their bores, and the bending of the axle between them."""

from dataclasses import replace

import numpy as np
from scipy.interpolate import CubicSpline

from flangeway.elements import Lagrange
from flangeway.errors import InputError
from flangeway.geometry import Outline, Placement
from flangeway.geometry.arrays import chain_lengths, nearest_on_segments
from flangeway.geometry.segments import segment_of
from flangeway.geometry.shapes import rounded_sides
from flangeway.mesh import Refinement, triangulate
from flangeway.problems import Elasticity, Harmonic
from flangeway.railway.profiles.bundled import WheelProfile
from flangeway.railway.track.supports import WholeWheel
from flangeway.solve import SurfaceCells
from flangeway.solve.surface_compliance import compliances
from flangeway.space import Space
from flangeway.system.disk_cache import Cache, cached
from flangeway.types import Floats

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


def whole_wheel(profile: WheelProfile, radius_mm: float, disc: WholeWheel | None = None) -> WheelProfile:
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
    disc = WholeWheel() if disc is None else disc
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
