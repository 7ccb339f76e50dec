"""Checks of a mesh's geometry, each with a message that names the place."""

from collections.abc import Collection, Iterable, Mapping
from dataclasses import dataclass
from typing import Any
from weakref import WeakSet

import numpy as np
import shapely

from flangeway.checks import check_positive
from flangeway.errors import InputError
from flangeway.geometry.arrays import IntArray, chords_of, extent, norms, point_text
from flangeway.mesh.connectivity import edge_places, first_connected, places_among, row_numbers
from flangeway.mesh.curved import as_polylines
from flangeway.mesh.insertion import corners_added
from flangeway.mesh.polyhedral_mesh import PolyhedralMesh
from flangeway.mesh.polymesh import PolyMesh
from flangeway.types import Bools, Floats, Indices, Ints

# --- Segments that touch or cross.


TOUCH_TOLERANCE = 1e-6
"""Distance of a point from a segment, relative to the shorter of it and the point's own, up to which they touch."""

ROUND_OFF = 1e-9
"""Distance relative to the size of the mesh up to which they touch where the segments are short, by files' few
digits."""


def touching_distance(lengths: Floats, points: Floats) -> Floats:
    """Distance up to which segments of some lengths (n,) touch in a mesh of points (n_points, 2)."""
    rounding = ROUND_OFF * extent(points)
    return np.clip(rounding, TOUCH_TOLERANCE * lengths, 0.01 * lengths)


@dataclass(frozen=True, eq=False)
class Meeting:
    """Where segments come together other than at a common end.

    Segments ``on`` which a point of another one lies, the other segments ``of``, and these points, each (n_touches,);
    pairs (n_crossings, 2) of segments that cross and do not touch.
    """

    on: Ints
    of: Ints
    points: Ints
    crossing: Ints


def meeting(points: Floats, segments: IntArray) -> Meeting:
    """Find the segments, numbers of start and end (n, 2) among points (n_points, 2), that touch or cross.

    They may meet at a point that is an end of both.
    """
    reach = touching_distance(norms(chords_of(points[segments])), points)
    lines = shapely.linestrings(points[segments])
    i, j = shapely.STRtree(lines).query(lines, predicate="dwithin", distance=reach)
    i, j = np.stack((i, j))[:, i < j]
    touched, touching = np.zeros(len(i), dtype=bool), []
    for on, of in ((i, j), (j, i)):
        for p in segments[of].T:
            distances = shapely.distance(lines[on], shapely.points(points[p]))
            touches = (distances <= np.minimum(reach[i], reach[j])) & (segments[on] != p[:, None]).all(axis=1)
            touched |= touches
            touching.append((on[touches], of[touches], p[touches]))
    shared = (segments[i][:, :, None] == segments[j][:, None]).any(axis=(1, 2))
    crosses = shapely.crosses(lines[i], lines[j]) & ~touched & ~shared
    on, of, met = (np.concatenate(part).astype(np.int64) for part in zip(*touching, strict=True))
    return Meeting(on, of, met, np.column_stack([i[crosses], j[crosses]]))


# --- Checks of a mesh's geometry, each with a message that names the place.


MIN_CELL_AREA = 1e-14
"""Area of a cell relative to the sum of its squared distances from its middle, up to which it counts as flat."""

MIN_SIDE = 1e-9
"""Area between a side and the middle of a cell, relative to the cell's, below which the side is looked at more
closely; and length of a side relative to the cell's size below which its ends count as one point."""

OFF_CURVE = 1e-5  # distance of an edge's end from its curve, relative to its length, up to which it lies on it

CELLS_AT_A_TIME = 10_000  # their corners stay in cache

_sound: WeakSet[PolyMesh] = WeakSet()


def check(
    mesh: PolyMesh,
    *,
    cracks: Collection[str] = (),
    region_area: float | None = None,
    area_tolerance: float = 1e-9,
    allow_hanging: bool = False,
    allow_coincident: bool = False,
    bodies_alone: bool = False,
) -> None:
    """Check that cells are simple, positive, and fit together without gap or overlap.

    Cells that are simple and counter-clockwise, with at most one of them on each side of an edge, lie on each other
    only where their boundary crosses itself or encloses itself more than once. So beyond cells and edges the boundary
    is looked at, and every fault is found. A `Space` checks its mesh so; a mesh is checked once.

    Bodies may touch at a point that they share, which is a hinge. Different points at one place, and points on edges
    of other cells, are faults of merging, except along the faces of closed cracks, which are named.

    Parameters
    ----------
    mesh
        What to check.
    cracks
        Edge sets, along which the boundary may touch itself.
    region_area
        Area that the cells must fill, if known.
    area_tolerance
        Largest relative difference from it. Where the region has arcs, cells with straight edges
        miss some of it.
    allow_hanging
        Whether points may lie inside edges of other cells.
    allow_coincident
        Whether several points may be at the same place.
    bodies_alone
        Whether cells may lie on others that no chain of cells with common points connects with them.

    Raises
    ------
    InputError
        If a point is unused or there twice; a cell passes a point twice, crosses itself or has no
        positive area; an edge has two cells on one side; cells lie on each other; the areas do not sum up; a point
        hangs on an edge; or an edge set leaves the boundary. The message names the cell or point and where it is.
    """
    if mesh not in _sound:
        _check_points(mesh)
        _check_cells(mesh)
        _check_sides(mesh)
        _check_edge_sets(mesh)
        bodies = first_connected(mesh.edges, mesh.n_points) if bodies_alone else np.zeros(mesh.n_points, dtype=np.int64)
        _check_boundary(mesh, cracks, bodies, allow_hanging=allow_hanging, allow_coincident=allow_coincident)
        if not (cracks or allow_hanging or allow_coincident or bodies_alone):
            _sound.add(mesh)
    if region_area is not None:
        _check_sum(mesh, region_area, area_tolerance)


def _cell(mesh: PolyMesh, cell: int) -> str:
    return f"cell {cell} near {point_text(mesh.points[mesh.corners(cell)].mean(axis=0))}"


def _check_points(mesh: PolyMesh) -> None:
    used = np.bincount(mesh.cell_points, minlength=mesh.n_points)
    if used.min() == 0:
        point = int(used.argmin())
        raise InputError(
            f"point {point} at {point_text(mesh.points[point])} of no cell", "points that a cell uses", "remove it"
        )


def _check_cells(mesh: PolyMesh) -> None:
    """Refuse flat and clockwise cells, and those that cross themselves.

    A cell whose sides all turn counter-clockwise about its middle, once in total, is simple; few are not like that.
    """
    others = []
    x_of, y_of = np.ascontiguousarray(mesh.points.T)
    sizes = mesh.batches()
    for n_vertices, batch in sizes:
        rows = mesh.batch_points(n_vertices, batch) if len(sizes) > 1 else mesh.cell_points.reshape(-1, n_vertices)
        for start in range(0, len(batch), CELLS_AT_A_TIME):
            cells = batch[start : start + CELLS_AT_A_TIME]
            corners = np.ascontiguousarray(rows[start : start + CELLS_AT_A_TIME].T)
            x, y = x_of[corners], y_of[corners]
            if n_vertices == 3:  # about the first corner, where two sides have no area
                x, y = x[1:] - x[0], y[1:] - y[0]
                areas = x[0] * y[1] - x[1] * y[0]
            else:
                x -= x.mean(axis=0)
                y -= y.mean(axis=0)
                following = [*range(1, n_vertices), 0]
                twice = x * y[following] - x[following] * y  # area of side and middle
                areas = twice.sum(axis=0)
            flat = areas <= 2.0 * MIN_CELL_AREA * (x * x + y * y).sum(axis=0)
            if flat.any():
                cell = int(cells[flat.argmax()])
                if n_vertices > 3:
                    _check_sides_of(mesh, cells[flat][:1])  # a crossing says more
                raise InputError(
                    f"{_cell(mesh, cell)} with area {0.5 * areas[flat.argmax()]:.3g}",
                    "counter-clockwise cells with positive areas",
                    "reverse its points, or remove it if it is flat",
                )
            if n_vertices > 3:  # a triangle is simple
                once = ((y < 0.0) & (y[following] >= 0.0)).sum(axis=0) == 1
                star = once & (twice.min(axis=0) > MIN_SIDE * areas)
                others.append(cells[~star])
    if others:
        _check_sides_of(mesh, np.sort(np.concatenate(others)))


def _check_sides_of(mesh: PolyMesh, cells: IntArray) -> None:
    """Refuse cells that pass a point twice or cross themselves."""
    polygons = mesh.polygons(cells)
    lengths = shapely.length(polygons)  # a side that touches another one is nearer to it than this
    doubtful = ~shapely.is_valid(polygons) | (shapely.minimum_clearance(polygons) <= TOUCH_TOLERANCE * lengths)
    # the clearance leaves out a corner that is repeated
    doubtful |= shapely.get_num_coordinates(shapely.remove_repeated_points(polygons)) < shapely.get_num_coordinates(
        polygons
    )
    for cell in cells[doubtful].tolist():
        corners = mesh.corners(cell)
        numbers, times = np.unique(corners, return_counts=True)
        if times.max() > 1:
            raise InputError(
                f"{_cell(mesh, cell)} passes point {numbers[times.argmax()]} twice",
                "polygons that pass a point once",
                "divide the cell there",
            )
        sides = np.column_stack([corners, np.roll(corners, -1)])
        lengths = norms(chords_of(mesh.points[sides]))
        if lengths.min() <= MIN_SIDE * lengths.max():
            raise _same_place(mesh, *sides[lengths.argmin()])
        meets = meeting(mesh.points, sides)
        pairs = np.vstack([np.column_stack([meets.on, meets.of]), meets.crossing])
        if len(pairs):
            i, j = np.sort(pairs[0])
            raise InputError(
                f"{_cell(mesh, cell)}: its sides {i} and {j} cross",
                "polygons that do not cross themselves",
                "reorder its points",
            )


def _same_place(mesh: PolyMesh, one: int, other: int) -> InputError:
    return InputError(
        f"points {one} and {other} at the same place {point_text(mesh.points[one])}",
        "points that differ, or both on faces of a crack",
        "use one point for both, as read_mesh does; for a crack name its faces, Space(..., cracks=['face', ...])",
    )


def _check_sides(mesh: PolyMesh) -> None:
    """Refuse an edge that two cells travel in the same direction: they overlap."""
    if len(mesh.doubled_edges):
        edge = int(mesh.doubled_edges[0])
        cells = row_numbers(mesh.cell_offsets)[mesh.cell_edges == edge]
        a, b = mesh.edges[edge]
        raise InputError(
            f"cells {cells.tolist()} on the same side of edge ({a}, {b}) near {point_text(mesh.points[a])}",
            "one cell on each side of an edge",
            "remove the cell that overlaps",
        )


def _check_sum(mesh: PolyMesh, region_area: float, tolerance: float) -> None:
    total = float(mesh.cell_areas.sum())
    if not abs(total - region_area) <= tolerance * abs(region_area):
        raise InputError(
            f"cells with {total:.12g} of area in a region of {region_area:.12g}",
            f"a relative difference up to {tolerance:g}",
            "look for gaps and overlaps; allow for arcs that straight edges cut short",
        )


def hanging_points(mesh: PolyMesh) -> tuple[Ints, Ints]:
    """Return rows of ``mesh.boundary_edges`` and the points (n,) that lie inside them.

    Of two cells that meet along an edge with a hanging point, both have edges with one cell only:
    so it is enough to look at boundary edges and their points.
    """
    touching = meeting(mesh.points, mesh.boundary_edges)
    inside = ~_at_end(mesh, touching)[0]
    _, first = np.unique(touching.on[inside] * mesh.n_points + touching.points[inside], return_index=True)
    return touching.on[inside][first], touching.points[inside][first]


def _at_end(mesh: PolyMesh, touching: Meeting) -> tuple[Bools, Ints]:
    """Whether each touching point lies at an end of the edge, and that end."""
    rim = mesh.boundary_edges
    ends = rim[touching.on]
    apart = norms(mesh.points[ends] - mesh.points[touching.points][:, None])
    lengths = norms(np.diff(mesh.points[rim], axis=1)[:, 0])
    reach = touching_distance(lengths, mesh.points)
    at_end: Bools = apart.min(axis=1) <= np.minimum(reach[touching.on], reach[touching.of])
    return at_end, ends[np.arange(len(ends)), apart.argmin(axis=1)].astype(np.int64)


def _check_boundary(
    mesh: PolyMesh, cracks: Iterable[str], bodies: Ints, *, allow_hanging: bool, allow_coincident: bool
) -> None:
    """Refuse a boundary of a body that touches itself where it is not meant to, crosses itself or encloses itself.

    - `bodies`: number of the body of each point (n_points,).
    """
    rim = mesh.boundary_edges
    touching = meeting(mesh.points, rim)
    crossing = touching.crossing[np.ptp(bodies[rim[touching.crossing, 0]], axis=1) == 0]
    if len(crossing):
        (a, b), (c, d) = rim[crossing[0]]
        raise InputError(
            f"the boundary edges ({a}, {b}) and ({c}, {d}) near {point_text(mesh.points[a])} cross",
            "cells that do not lie on each other",
            "remove or move the cells that overlap",
        )
    if len(touching.on):
        at_end, ends = _at_end(mesh, touching)
        meant = _meant(mesh, touching, at_end, ends, cracks) | np.where(at_end, allow_coincident, allow_hanging)
        # both ends of a short edge touch the edges beside it
        meant |= at_end & edge_places(np.column_stack((touching.points, ends)), mesh.edges, mesh.n_points)[1]
        if not meant.all():
            row = int(np.argmin(meant))
            point = int(touching.points[row])
            if at_end[row]:
                raise _same_place(mesh, *sorted((point, int(ends[row]))))
            start, end = rim[touching.on[row]]
            raise InputError(
                f"point {point} at {point_text(mesh.points[point])} hangs on the edge ({start}, {end})",
                "points at the ends of edges",
                "add the point to the cell of that edge, which may be a polygon with one side more; see `conforming`",
            )
    _refuse_inner_boundary(mesh, rim, bodies)


def _refuse_inner_boundary(mesh: PolyMesh, rim: IntArray, bodies: Ints) -> None:
    """Refuse a boundary that lies inside of cells of its body; it does not cross itself.

    Cells that are positive and fit together edge by edge cover a place as many times as the boundary goes around it,
    and this number is constant along a chain of edges. So one point beside each chain, on its left, shows it.
    """
    following = places_among(rim[:, 0], mesh.n_points)[rim[:, 1]]
    simple = np.flatnonzero(np.bincount(rim[:, 0], minlength=mesh.n_points)[rim[:, 1]] == 1)
    links = np.column_stack((simple, following[simple]))
    _, chain = np.unique(first_connected(links, len(rim)), return_inverse=True)
    n_chains = int(chain.max()) + 1
    if n_chains == 1:  # one closed curve, which positive cells fill once
        return
    steps = chords_of(mesh.points[rim])
    longest = np.lexsort((-norms(steps), chain))
    rows = longest[np.searchsorted(chain[longest], np.arange(n_chains))]
    beside = touching_distance(norms(steps[rows]), mesh.points) / norms(steps[rows])
    left = np.column_stack((-steps[rows, 1], steps[rows, 0])) * beside[:, None]
    points = mesh.points[rim[rows]].mean(axis=1) + left
    x, abscissae = np.sort(points[:, 0]), mesh.points[mesh.cell_points, 0]
    low, high = (end.reduceat(abscissae, mesh.cell_offsets[:-1]) for end in (np.minimum, np.maximum))
    cells = np.flatnonzero(np.searchsorted(x, high, side="right") > np.searchsorted(x, low))
    inside, around = shapely.STRtree(mesh.polygons(cells)).query(shapely.points(points), predicate="intersects")
    own = bodies[rim[rows[inside], 0]] == bodies[mesh.cell_points[mesh.cell_offsets[cells[around]]]]
    times = np.bincount(inside[own], minlength=n_chains)
    if times.max() > 1:
        a, b = rim[rows[times.argmax()]]
        raise InputError(
            f"the boundary edge ({a}, {b}) near {point_text(mesh.points[a])} lies inside another part of the mesh",
            "cells that do not lie on each other",
            "remove or move the cells that overlap",
        )


def _meant(mesh: PolyMesh, touching: Meeting, at_end: Bools, ends: Ints, cracks: Iterable[str]) -> Bools:
    """Whether a point may touch an edge or another point: both have an edge of a crack's face."""
    faces = np.zeros(len(mesh.boundary_edges), dtype=bool)
    for name in cracks:
        faces[mesh.boundary_rows(mesh.edge_set(name), "the edge of a crack")] = True
    # a touch is found once for each pair of edges there, of which one is enough
    low, high = np.minimum(touching.points, ends), np.maximum(touching.points, ends)
    keys = np.where(at_end, low * mesh.n_points + high, -1 - (touching.on * mesh.n_points + touching.points))
    _, touch = np.unique(keys, return_inverse=True)
    return np.bincount(touch, weights=faces[touching.on] & faces[touching.of])[touch] > 0


def _keys(mesh: PolyMesh, pairs: IntArray) -> Ints:
    return pairs[:, 0].astype(np.int64) * mesh.n_points + pairs[:, 1]


def _check_edge_sets(mesh: PolyMesh) -> None:
    allowed = _keys(mesh, mesh.boundary_edges)
    for name, pairs in mesh.edge_sets.items():
        wrong = ~np.isin(_keys(mesh, pairs), allowed)
        if wrong.any():
            a, b = pairs[wrong.argmax()]
            raise InputError(
                f"edge set '{name}': ({a}, {b}) near {point_text(mesh.points[a])} is inside the body, or no edge",
                "edges of the boundary",
                "choose among boundary_edges",
            )


def conforming(mesh: PolyMesh) -> PolyMesh:
    """Return the mesh with every point that hangs on an edge of a cell added to that cell.

    So meshes of other programs with hanging nodes become polygons that fit together: a square with a hanging point is a
    pentagon. Points and cells keep their numbers. Edge sets keep the edges that are at the boundary still. It is an
    `InputError` if a point hangs on the chord of a curved edge.
    """
    edges, points = hanging_points(mesh)
    if not len(points):
        return mesh
    pairs = mesh.boundary_edges
    bent = mesh.curve_rows[mesh.edge_numbers(pairs[edges])] >= 0
    if bent.any():
        point = int(points[bent.argmax()])
        raise InputError(
            f"point {point} at {point_text(mesh.points[point])}, which hangs on the chord of a curved edge",
            "points that hang on straight edges",
            "take conforming(mesh.straight()), then curved(mesh, outline) again",
        )
    along = norms(mesh.points[points] - mesh.points[pairs[edges, 0]])
    order = np.lexsort((along, edges))
    whole = PolyMesh(mesh.points, *corners_added(mesh, edges[order], points[order]), mesh.cell_sets, curves=mesh.curves)
    outer = set(map(tuple, whole.boundary_edges.tolist()))
    for name, given in mesh.edge_sets.items():
        kept = [pair for pair in given.tolist() if tuple(pair) in outer]
        whole = whole.with_edge_set(name, np.array(kept)) if kept else whole
    return whole


def check_curved_cells(mesh: PolyMesh, cells: Indices, order: int) -> None:
    """Refuse cells with curved edges that cross themselves, or are turned inside out; see `check`.

    - `cells`: cells with curved edges.
    - `order`: of the elements: the more points of a curve belong to an edge.
    """
    assert mesh.curves is not None
    ends = mesh.points[mesh.curves.pairs]
    apart = norms(mesh.curves.points([0.0, 1.0]) - ends).max(axis=1)
    off = apart > OFF_CURVE * norms(chords_of(ends))
    if off.any():
        a, b = mesh.curves.pairs[off.argmax()]
        raise InputError(
            f"the edge ({a}, {b}) near {point_text(mesh.points[a])} that ends {apart.max():.3g} from its curve",
            "edges with both ends on their curves",
            "put the points there, or let flangeway.mesh.curved do so",
        )
    try:
        _check_cells(as_polylines(mesh, 4 * order, cells))
    except InputError as error:
        if len(cells) > 1:  # which of them
            for cell in cells:
                check_curved_cells(mesh, np.array([cell]), order)
        raise InputError(
            f"{_cell(mesh, int(cells[0]))} with a curved edge that leaves it: between its points it crosses another "
            "edge, or turns the cell inside out",
            "arcs and splines that stay inside the cells beside them",
            "refine the mesh at the curve, or take mesh.straight()",
        ) from error


def positive_by_cells(mesh: PolyMesh, owner: str, name: str, given: float | Mapping[str, float]) -> Floats:
    """Return the positive number of each cell, (n_cells,): the same for all, or by named cell sets, see `set_numbers`.

    - `owner`, `name`: the class or function and its argument, for the `InputError` of another number.
    """
    if not isinstance(given, Mapping):
        return np.full(mesh.n_cells, check_positive(owner, name, given))
    values = [check_positive(owner, f"{name} of {key}", value) for key, value in given.items()]
    return np.array(values)[set_numbers(mesh, given, name.replace("_", " "))]


def items_by_cells(given: Any) -> tuple[Any, ...]:
    """Return what a user gives for the cells: one item for all, or those of named cell sets."""
    return tuple(given.values()) if isinstance(given, Mapping) else (given,)


def set_numbers(mesh: PolyMesh | PolyhedralMesh, names: Iterable[str], what: str) -> Ints:
    """Return which of the named cell sets each cell is in, numbers from 0, shape (n_cells,).

    Parameters
    ----------
    mesh
        The mesh.
    names
        Names of cell sets that cover the mesh once.
    what
        What a set has for its cells, such as "material", for messages.

    Raises
    ------
    InputError
        If a name is unknown, or a cell is in none of the sets or in several.

    """
    numbers, times = np.zeros(mesh.n_cells, dtype=np.int64), np.zeros(mesh.n_cells, dtype=np.int64)
    for number, name in enumerate(names):
        cells = mesh.cell_set(name)
        numbers[cells] = number
        times[cells] += 1
    if (times != 1).any():
        cell = int(np.argmax(times != 1))
        place = point_text(mesh.points[mesh.corners(cell)].mean(axis=0))
        raise InputError(
            f"cell {cell} at {place} in {times[cell]} of the given cell sets",
            f"one {what} for each cell",
            "give cell sets that cover the mesh once",
        )
    return numbers
