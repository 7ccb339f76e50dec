"""Bodies of a contact patch and its grid: cells across on the first body, strips along z, and the gaps."""

from dataclasses import dataclass, field
from functools import cached_property
from typing import Any

import numpy as np
import scipy.ndimage
from numpy.typing import NDArray

from flangeway.contact.patch.normal_contact import Convolution, NormalContact, solve_normal
from flangeway.errors import InputError
from flangeway.exact import contact_modulus, half_space_influence
from flangeway.geometry import Contour, Placement, Point, crossing_shares
from flangeway.geometry.arrays import (
    chain_lengths,
    chain_points,
    longest_step,
    middles_of,
    norms,
    turned_right,
    units_of,
    vectors_at,
)
from flangeway.problems import Harmonic
from flangeway.types import Bools, Floats, Ints

# --- Bodies of a contact patch: prisms along z, and bodies of revolution, by their plane sections.


CHORD_TOLERANCE = 1e-8
"""Distance of the chords of drawn arcs relative to the size of the curve."""
YAWED_SPACING = 1e-3
"""Spacing of the drawn points of a body with yaw relative to the size of the curve."""
MAX_YAW = np.pi / 4.0
"""Yaw of an axis, beyond which the elasticity of the body is no longer that of a prism along z."""


@dataclass(frozen=True)
class Axis:
    """Axis of revolution in the frame of a body's section.

    Parameters
    ----------
    point
        A point of the axis.
    direction
        Its direction in the plane of the section.
    yaw_rad
        Rotation about the vertical y of the common axes through `point`, from x towards z, up to pi / 4. The axes of
        a cylinder and of a prism along z then cross at the angle pi / 2 - yaw.

    """

    point: Point
    direction: Point = (1.0, 0.0)
    yaw_rad: float = 0.0

    def __post_init__(self) -> None:
        if not abs(self.yaw_rad) <= MAX_YAW or not np.hypot(*self.direction) > 0.0:
            raise InputError(
                f"an axis along {self.direction} with a yaw of {self.yaw_rad:g}",
                "a direction, and a yaw between -pi/4 and pi/4",
                "exchange the bodies, so that the one whose axis is closer to z is the prism",
            )


@dataclass(frozen=True, eq=False)
class PatchBody:
    """A prism along z or a body of revolution in a contact patch.

    Its elasticity is that of the prism of its section. In a body of revolution the true surface goes into the gap, and
    waves around the axis are straightened, which changes the pressure on a wheel of 920 mm by 0.02 %.

    Parameters
    ----------
    problem
        Space, material, supports and foundations of the section.
    surface
        Edge set of the contact surface, or pairs of points of boundary edges (n_edges, 2): one chain.
    curve
        The drawn surface in the section's frame, from which gaps are measured. Left out: the mesh's edges.
    placement
        Position of the section in the common axes.
    axis
        Axis of a body of revolution in the section's frame; None for a prism.

    Raises
    ------
    InputError
        If the body is neither held nor on a foundation along x, y or z: long waves could then move it without force.

    """

    problem: Harmonic
    surface: str | Ints
    curve: Contour | None = None
    placement: Placement = field(default_factory=Placement)
    axis: Axis | None = None

    def __post_init__(self) -> None:
        supported = set("".join((self.problem.held or {}).values()))
        supported |= {
            axis for foundation in self.problem.foundations for axis in "xyz" if getattr(foundation, axis) > 0.0
        }
        if loose := "".join(sorted(set("xyz") - supported)):
            raise InputError(
                f"{self.name!r} without a support along {' and '.join(loose)}, free to move at the wavenumber 0",
                "a body that is held, or on a foundation, along x, y and z",
                "hold it along x, y and z, or give a foundation with a stiffness along each axis",
            )

    @property
    def name(self) -> str:
        """Name for messages."""
        return self.problem.elasticity.name

    @cached_property
    def edges(self) -> Ints:
        """Edges of the surface one after the other, body on the left, shape (n_edges, 2)."""
        mesh, name = self.problem.elasticity.space.mesh, self.surface
        if not isinstance(name, str):
            mesh, name = mesh.with_edge_set("contact surface", name), "contact surface"
        chain = mesh.chain(name).astype(np.int64)
        return pairs_of(chain)

    @cached_property
    def chain(self) -> Floats:
        """Corners of the meshed surface in the common axes, body on the left, shape (n_edges + 1, 2)."""
        chain = self.placement.points(self.problem.elasticity.space.mesh.points[chain_points(self.edges)])
        return chain[::-1] if self.placement.mirrored else chain

    @property
    def length(self) -> float:
        """Length of the meshed surface."""
        return float(chain_lengths(self.chain)[-1])

    def longest_edge(self, low: float, high: float) -> float:
        """Maximum length of the edges between two lengths along the chain."""
        return longest_step(chain_lengths(self.chain), low, high)

    @cached_property
    def drawn(self) -> Floats:
        """The drawn surface in the plane z = 0 of a body without yaw as a polyline, shape (n, 2)."""
        if self.curve is None:
            return self.chain
        # planes z = const cut straight lines of a yawed body in curves
        spacing = YAWED_SPACING * self.curve.size if self.axis is not None and self.axis.yaw_rad else None
        return self.placement.points(
            self.curve.sampled(spacing=spacing, max_deviation=CHORD_TOLERANCE * self.curve.size)
        )

    def section(self, z: float, part: slice = slice(None)) -> Floats:
        """The drawn surface in the plane of a z as a polyline, shape (n, 2); not-a-number where it does not reach.

        A point of a surface of revolution at the distance r from the axis a is turned by the angle t about it, so that
        ``xi a + r (cos t e1 + sin t e2)`` is at z; e1 is the axis' normal in the plane of the section. A part of the
        points of `drawn` saves time.
        """
        if self.axis is None:
            return self.drawn[part]
        centre = self.placement.points(np.array([self.axis.point]))[0]
        straight = self.placement.vectors(np.array([self.axis.direction]))[0]
        straight /= np.linalg.norm(straight)
        apart = self.drawn[part] - centre
        along, radii = apart @ straight, apart @ -turned_right(straight)
        axis = np.array([straight[0] * np.cos(self.axis.yaw_rad), straight[1]])
        out_of_plane = straight[0] * np.sin(self.axis.yaw_rad)
        level = np.sqrt(1.0 - out_of_plane**2)
        first, second = -turned_right(axis) / level, -out_of_plane * axis / level
        with np.errstate(invalid="ignore", divide="ignore"):
            sine = (z - along * out_of_plane) / (radii * level)
            cosine = np.sqrt(1.0 - sine**2)
        turned = cosine[:, None] * first + sine[:, None] * second
        return centre + along[:, None] * axis + radii[:, None] * turned


def points_along(chain: Floats, stations: Floats) -> tuple[Floats, Floats]:
    """Points and outward unit normals of a chain, body on its left, at lengths along it, each (n, 2)."""
    chords, ends = np.diff(chain, axis=0), chain_lengths(chain)
    points = vectors_at(stations, ends, chain)
    # normals of the edges belong to their middles, between which they turn
    middles = middles_of(ends)
    normals = turned_right(chords) / np.diff(ends)[:, None]
    return points, units_of(vectors_at(stations, middles, normals))


def cast(points: Floats, normals: Floats, chain: Floats) -> tuple[Floats, Floats]:
    """Signed distances from points along normals to a chain, and the lengths along it where they meet, each (n,).

    Infinite where they do not meet.
    """
    distance, share = crossing_shares(points[:, None], normals[:, None], chain[:-1], np.diff(chain, axis=0))
    distance = np.where((share >= 0.0) & (share <= 1.0), distance, np.inf)
    nearest = np.abs(distance).argmin(axis=1)
    rows, ends = np.arange(len(points)), chain_lengths(np.nan_to_num(chain))
    return distance[rows, nearest], ends[nearest] + share[rows, nearest] * np.diff(ends)[nearest]


# --- Grid of a contact patch: cells across on the first body, strips along z, and the gaps of two bodies on them.


MIN_ACROSS = 20
"""Cells across the patch from which semi-axes are within 0.3 % of Hertz's."""
USUAL_ACROSS = 26
"""Cells across the patch that are chosen."""
MAX_CELLS = 300
"""Cells across that are chosen at most: the influence coefficients need their square."""
MAX_CELL_RATIO = 3.0
"""Longer side over shorter side of a cell, at most."""
MARGIN = 0.25
"""Width of the window beyond the patch, on each side, relative to the patch."""
N_COARSE = 32
"""Cells of each direction while the window is sought."""
MIN_FILLED = 0.4
"""Part of the window that the patch must fill in both directions while it is sought."""
MAX_WINDOWS = 60
MIN_NORMAL_COMPONENT = 0.05
"""Component of the normal along the load, below which a cell is not where bodies touch first."""


@dataclass(frozen=True, eq=False)
class PatchGrid:
    """Cells of a contact patch.

    Parameters
    ----------
    bounds
        Ends of the cells as lengths along the first body's meshed surface in the common axes, rising, (n_cells + 1,).
    strip
        Width of the strips along z.
    n_strips
        Number of strips.
    middle
        z of the middle of all strips.

    Raises
    ------
    InputError
        If the ends do not rise, or there is no strip of a width above 0.

    """

    bounds: Floats
    strip: float
    n_strips: int
    middle: float = 0.0

    @classmethod
    def on_planes(cls, bounds: Floats, strip: float, first: int, last: int) -> "PatchGrid":
        """Strips whose middles are the multiples of their width from a first to a last one."""
        return cls(bounds, strip, last - first + 1, strip * (first + last) / 2.0)

    def __post_init__(self) -> None:
        bounds = np.asarray(self.bounds)
        n_strips = self.n_strips
        if (
            bounds.ndim != 1
            or len(bounds) < 2
            or not (np.diff(bounds) > 0.0).all()
            or not self.strip > 0.0
            or not n_strips >= 1
        ):
            raise InputError(
                f"cells between ends of shape {bounds.shape} and {n_strips} strips of {self.strip}",
                "rising ends, one strip or more of a width > 0",
                "give the ends of the cells",
            )

    @property
    def along(self) -> Floats:
        """Middles of the strips, shape (n_strips,)."""
        return self.middle + self.strip * (np.arange(self.n_strips, dtype=np.float64) - (self.n_strips - 1) / 2.0)

    @property
    def stations(self) -> Floats:
        """Middles of the cells along the surface, shape (n_cells,)."""
        return middles_of(self.bounds)

    @property
    def middles(self) -> tuple[Floats, Floats]:
        """`stations` and `along`."""
        return self.stations, self.along

    @property
    def widths(self) -> Floats:
        """Widths of the cells across, shape (n_cells,)."""
        return np.diff(self.bounds)

    @property
    def areas(self) -> Floats:
        """Areas of the cells, shape (n_cells, 1)."""
        return self.widths[:, None] * self.strip

    @property
    def strip_bounds(self) -> Floats:
        """Ends of the strips, shape (n_strips + 1,)."""
        return self.middle + self.strip * (np.arange(self.n_strips + 1, dtype=np.float64) - self.n_strips / 2.0)

    @property
    def cells(self) -> Floats:
        """Both ends of each cell across, shape (n_cells, 2)."""
        return pairs_of(self.bounds)

    @property
    def staggered(self) -> "PatchGrid":
        """Cells between the middles of these ones, along both axes; across, half cells at both ends."""
        bounds = np.concatenate((self.bounds[:1], self.stations, self.bounds[-1:]))
        return PatchGrid(bounds, self.strip, self.n_strips + 1, self.middle)

    def covers(self, other: "PatchGrid") -> bool:
        """Whether another grid of the same cells and strips reaches nowhere farther."""
        near = self.strip / 2.0 - np.array([self.along[0] - other.along[0], other.along[-1] - self.along[-1]])
        across = self.bounds[0] <= other.bounds[0] and self.bounds[-1] >= other.bounds[-1]
        return bool(across and (near > 0.0).all())

    def changed(self, larger: Floats, finer: float, length: float) -> "PatchGrid":
        """Even cells in a window larger by factors (2,) on a surface of a length, with cells smaller by one factor."""
        middle, half = (self.bounds[0] + self.bounds[-1]) / 2.0, larger[0] * np.ptp(self.bounds) / 2.0
        low, high = np.clip([middle - half, middle + half], 0.0, length)
        cell, strip = finer * np.ptp(self.bounds) / len(self.widths), finer * self.strip
        whole = larger[1] * self.strip * self.n_strips
        n_strips = int(np.ceil(whole / strip - 1e-9))
        return PatchGrid(
            np.linspace(low, high, int(np.ceil((high - low) / cell - 1e-9)) + 1), strip, n_strips, self.middle
        )


def pairs_of(bounds: NDArray[Any]) -> NDArray[Any]:
    """Both ends of each interval between neighbours in order (n + 1,), shape (n, 2)."""
    return np.stack((bounds[:-1], bounds[1:]), axis=1)


def separate_patches(loaded: Bools) -> list[Bools]:
    """Cells of each patch of loaded cells (n_cells, n_strips); cells that meet at a corner are of one patch."""
    labels, count = scipy.ndimage.label(loaded, structure=np.ones((3, 3)))
    return [labels == number for number in range(1, count + 1)]


def at_edge(loaded: Bools) -> Bools:
    """Whether loaded cells (n_cells, n_strips) reach the edge of their grid across, and along z, shape (2,)."""
    return np.array([loaded[[0, -1]].any(), loaded[:, [0, -1]].any()])


@dataclass(frozen=True, eq=False)
class GridGaps:
    """Gaps of two bodies on a grid.

    Parameters
    ----------
    points
        Middles of the cells, shape (n_cells, 2).
    normals
        Outward normals of the first body there, shape (n_cells, 2).
    values
        Gaps along the normals, positive where open, infinite where there is no second body, (n_cells, n_strips).
    others
        Ends of the cells as lengths along the second body's meshed surface in the common axes, shape (n_cells + 1,).

    """

    points: Floats
    normals: Floats
    values: Floats
    others: Floats

    @cached_property
    def first_touch(self) -> float:
        """Approach along y at which the rigid surfaces touch."""
        open_to_load = self.normals[:, 1] > MIN_NORMAL_COMPONENT
        return float((self.values[open_to_load] / self.normals[open_to_load, 1:]).min(initial=np.inf))


def gaps_of(first: PatchBody, second: PatchBody, grid: PatchGrid) -> GridGaps:
    """Gaps between the drawn surfaces of two bodies along the normals of the first one.

    Raises
    ------
    InputError
        If the grid is larger than the first body's surface.

    """
    length = first.length
    if grid.bounds[0] < 0.0 or grid.bounds[-1] > length:
        raise InputError(
            f"a window from {grid.bounds[0]:.4g} to {grid.bounds[-1]:.4g} on the contact surface of {first.name!r}, "
            f"which is {length:.4g} long",
            "a window within the surface",
            "give a narrower window, or a longer contact surface",
        )
    ends, end_normals = points_along(first.chain, grid.bounds)
    _, others = cast(ends, end_normals, second.chain)
    middles = middles_of(ends)
    normals = end_normals[1:] + end_normals[:-1]
    normals /= norms(normals)[:, None]
    values = np.empty((len(middles), grid.n_strips))
    bodies = (first, second)
    straight = all(body.axis is None or body.axis.yaw_rad == 0.0 for body in bodies)
    planes, numbers = np.unique(np.round(np.abs(grid.along) if straight else grid.along, 12), return_inverse=True)
    nearby = [_near(body, ends, end_normals, grid) for body in bodies]
    prisms = [
        cast(ends, end_normals, body.drawn[part])[0] if body.axis is None else None
        for body, part in zip(bodies, nearby, strict=True)
    ]
    for number, z in enumerate(planes.tolist()):
        low, high = (
            cast(ends, end_normals, body.section(z, part))[0] if prism is None else prism
            for body, prism, part in zip(bodies, prisms, nearby, strict=True)
        )
        met = np.isfinite(low) & np.isfinite(high)
        gaps = np.where(met, high, np.inf) - np.where(met, low, 0.0)
        values[:, numbers == number] = middles_of(gaps)[:, None]
    return GridGaps(middles, normals, values, others)


def _near(body: PatchBody, points: Floats, normals: Floats, grid: PatchGrid) -> slice:
    """Points of a drawn surface that the window's rays can meet in any of its planes."""
    distances, _ = cast(points, normals, body.drawn)
    met = np.isfinite(distances)
    if not met.any():
        return slice(None)
    hits = points[met] + distances[met, None] * normals[met]
    reach = float(np.ptp(grid.bounds) + np.abs(grid.along).max())
    inside = (body.drawn > hits.min(axis=0) - reach) & (body.drawn < hits.max(axis=0) + reach)
    at = np.flatnonzero(inside.all(axis=1))
    return slice(max(int(at[0]) - 1, 0), int(at[-1]) + 2) if len(at) else slice(None)


def grid_about(first: PatchBody, second: PatchBody, cell: float, window: tuple[float, float]) -> PatchGrid:
    """Square cells in a window, width and length along z, about the place where the sections are closest."""
    n_cells, n_strips = (int(np.ceil(length / cell)) for length in window)
    stations, apart = _apart(first, second)
    station = stations[apart.argmin()]
    bounds: Floats = station + cell * (np.arange(n_cells + 1, dtype=np.float64) - n_cells / 2.0)
    return PatchGrid(bounds, cell, n_strips)


def grid_of(
    first: PatchBody,
    second: PatchBody,
    *,
    force: float | None = None,
    approach: float | None = None,
) -> PatchGrid:
    """Window about the patch, and cells in it, from the contact of half-spaces with the bodies' gaps.

    There are `USUAL_ACROSS` cells across the patch in each direction, but for cells that are three times as long as
    wide.

    Parameters
    ----------
    first, second
        The bodies, the second one above.
    force, approach
        Force along y, or approach from first touch: one of them.

    Raises
    ------
    InputError
        If nothing touches, or the patch reaches the end of a surface.

    """
    limits = np.array([[0.0, first.length], [-np.inf, np.inf]])
    modulus = contact_modulus(plane_modulus(first), plane_modulus(second))
    reach = np.sqrt((force or 0.0) / modulus if approach is None else approach * first.length / 64.0)
    stations, apart = _apart(first, second)
    station = float(stations[apart.argmin()])
    window: Floats = np.array([[station - reach, station + reach], [-reach, reach]])
    count, widened = N_COARSE, False
    for _ in range(MAX_WINDOWS):
        window = np.clip(window, limits[:, :1], limits[:, 1:])
        sizes = np.ptp(window, axis=1)
        grid = PatchGrid(
            np.linspace(window[0, 0], window[0, 1], count + 1), sizes[1] / N_COARSE, N_COARSE, float(window[1].mean())
        )
        gaps = gaps_of(first, second, grid)
        contact = half_space_contact(grid, gaps, modulus, force=force, approach=approach)
        loaded = contact.forces > 0.0
        patch = np.array([_extent(used, side) for used, side in zip(_sides(loaded), window, strict=True)])
        cut = ((patch == window) & (window != limits)).any(axis=1)
        extents = np.ptp(patch, axis=1)
        small = (extents < MIN_FILLED * sizes) & [not widened, True]
        if (cut | small).any():
            half = np.where(cut, 0.75 * sizes, np.where(small, extents, sizes / 2.0))[:, None]
            centre = np.where(cut | small, patch.mean(axis=1), window.mean(axis=1))[:, None]
            window = centre + half * [-1.0, 1.0]
            continue
        # elsewhere the rigid bodies would overlap: there may be another patch
        overlaps = np.append(stations[apart < contact.approach], window[0])
        if widened or np.ptp(overlaps) <= sizes[0]:
            break
        widened, window = True, np.array([[overlaps.min() - reach, overlaps.max() + reach], window[1]])
        count = min(int(N_COARSE * np.ptp(window[0]) / sizes[0]) + 1, MAX_CELLS)
    return _fitted((first, second), window, grid.bounds, gaps, loaded)


def _fitted(
    bodies: tuple[PatchBody, PatchBody], window: Floats, bounds: Floats, gaps: GridGaps, loaded: Bools
) -> PatchGrid:
    """Window and cells for what is loaded on even cells of a window (2, 2), by their bounds; see `grid_of`."""
    (first, second), sides = bodies, _sides(loaded)
    patch = np.array([_extent(used, side) for used, side in zip(sides, window, strict=True)])
    extents = np.ptp(patch, axis=1)
    met = np.isfinite(gaps.values)
    free = met.min(axis=1), met.min(axis=0)
    room = np.array([_extent(_run(*part), side) for *part, side in zip(free, sides, window, strict=True)])
    if (patch <= room[:, :1]).any() or (patch >= room[:, 1:]).any():
        raise InputError(
            f"a contact patch of {extents[0]:.4g} by {extents[1]:.4g} that reaches the end of the contact surface of "
            f"{first.name!r} or {second.name!r}",
            "a patch inside of both surfaces",
            "lower the force, name more edges as contact surfaces, or check the positions of the bodies",
        )
    rows = [[inside.sum(axis=axis).max() for axis in (0, 1)] for inside in separate_patches(loaded)]
    narrowest = np.min(rows, axis=0) * np.ptp(window, axis=1) / loaded.shape
    # cells are not smaller than the edges below them, if enough of them fit
    low, high = np.clip(patch + MARGIN * extents[:, None] * [-1.0, 1.0], room[:, :1], room[:, 1:]).T
    others = np.interp([low[0], high[0]], bounds, gaps.others)
    longest = max(first.longest_edge(low[0], high[0]), second.longest_edge(*np.sort(others)))
    cells = np.maximum(narrowest / USUAL_ACROSS, [min(longest, narrowest[0] / (MIN_ACROSS + 2)), 0.0])
    cells = np.minimum(cells, MAX_CELL_RATIO * cells.min())
    counts = np.ceil((high - low) / cells - 1e-9).astype(int)
    if counts[0] > MAX_CELLS:
        raise InputError(
            f"{counts[0]} cells across: patches of {narrowest[0]:.3g} on {extents[0]:.3g}",
            f"up to {MAX_CELLS} cells",
            "give the grid of each patch by itself",
        )
    return PatchGrid(
        np.linspace(low[0], high[0], counts[0] + 1),
        float(high[1] - low[1]) / counts[1],
        int(counts[1]),
        float(high[1] + low[1]) / 2.0,
    )


def half_space_contact(
    grid: PatchGrid, gaps: GridGaps, modulus: float, *, force: float | None = None, approach: float | None = None
) -> NormalContact:
    """Contact on the cells if both bodies were half-spaces of a contact modulus.

    Raises
    ------
    InputError
        If nothing touches.

    """
    met = np.isfinite(gaps.values)
    if not met.any() or not np.isfinite(gaps.first_touch):
        raise InputError(
            "two bodies of which none is above the other",
            "contact surfaces that face each other along y",
            "move the bodies over each other, or name other contact surfaces",
        )
    far = 10.0 * np.ptp(gaps.values[met]) + np.ptp(gaps.points) + (approach or 0.0)
    values = np.where(met, gaps.values, gaps.values[met].max() + far)
    influence = Convolution(half_space_influence(modulus, 0.0, grid.bounds, grid.strip, grid.n_strips, (1,)))
    whole = None if approach is None else approach + gaps.first_touch
    return solve_normal(influence, values, force=force, approach=whole, share=gaps.normals[:, 1:], tolerance=1e-3)


def plane_modulus(body: PatchBody) -> float:
    """E / (1 - nu^2) of an isotropic body; of others that along y in the plane y, z."""
    compliance = np.linalg.inv(body.problem.elasticity.materials[0].full_matrix)
    return float(1.0 / (compliance[1, 1] - compliance[1, 2] ** 2 / compliance[2, 2]))


def _apart(first: PatchBody, second: PatchBody) -> tuple[Floats, Floats]:
    """Lengths along the first body's surface, and the distances of the sections there along y, each (n,)."""
    ends = chain_lengths(first.chain)
    stations = np.unique(np.concatenate((ends, np.linspace(0.0, ends[-1], 8 * N_COARSE))))
    points, normals = points_along(first.chain, stations)
    low, high = (cast(points, normals, body.drawn)[0] for body in (first, second))
    usable = np.isfinite(low) & np.isfinite(high) & (normals[:, 1] > MIN_NORMAL_COMPONENT)
    if not usable.any():
        raise InputError(
            f"{second.name!r} which is nowhere above {first.name!r}",
            "contact surfaces that face each other along y",
            "move the bodies over each other, or name other contact surfaces",
        )
    return stations[usable], ((high - low) / normals[:, 1])[usable]


def _extent(used: Bools, side: Floats) -> Floats:
    """Ends of the used ones of equal pieces of a side."""
    at = np.flatnonzero(used)
    return side[0] + (side[1] - side[0]) / len(used) * np.array([at[0], at[-1] + 1])


def _sides(cells: Bools) -> tuple[Bools, Bools]:
    """In which rows and in which strips there are some of the cells."""
    return cells.max(axis=1), cells.max(axis=0)


def _run(usable: Bools, loaded: Bools) -> Bools:
    """The run of usable rows about the loaded ones, these at least."""
    at = np.flatnonzero(loaded)
    gaps = np.flatnonzero(~usable)
    low, high = gaps[gaps < at[0]].max(initial=-1), gaps[gaps > at[-1]].min(initial=len(usable))
    numbers = np.arange(len(usable))
    return (numbers > low) & (numbers < high)
