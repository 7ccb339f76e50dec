"""Edges of a mesh put on the curves that were drawn, and the checks of such edges."""

from collections.abc import Iterable, Sequence
from dataclasses import replace
from typing import TypeAlias

import numpy as np

from flangeway.errors import InputError, short
from flangeway.geometry.arrays import norms
from flangeway.geometry.outline import Contour
from flangeway.geometry.region import Region, Section
from flangeway.geometry.segments import Line, Segment, Spline
from flangeway.mesh.connectivity import EdgeCurves, entries_of, offsets_of, pairs_divided, places_among, shortest_edges
from flangeway.mesh.polymesh import PolyMesh
from flangeway.types import Floats, Indices, Ints

Curves: TypeAlias = Contour | Spline | Region | Section | Iterable[Contour | Spline]
"""What has curves: an outline or open chain, a spline, a region, a section, or several of the first two."""

MAX_CURVE_DISTANCE = 1.0
"""Distance from an arc, relative to the shorter boundary edge at the point, up to which the point belongs on it.

As large as that, since the middle of a coarse chord is far from its arc; the nearest curve decides.
"""

ON_CURVE = 1e-6  # distance of both ends of an edge from a curve, relative to its length, up to which it can lie on it
PIECES = 16  # of a curved edge as a polyline in pictures and files


def curved(mesh: PolyMesh, curves: Curves) -> PolyMesh:
    """Return the mesh with curved edges where curves were drawn: on its boundary, and between its cell sets.

    Points of the boundary near an arc or a spline are moved onto it, as by ``refined(..., outline=...)``. Then every
    edge with both ends on one of them follows it, unless a line of the curves is nearer to its middle. `dual` and
    `refined` put new points on the curves. Elements of order 2 or more use them: an edge of order k is the polynomial
    of degree k through its nodes, which are on the curve.

    Parameters
    ----------
    mesh
        Any mesh whose points on the boundary are on or near the curves.
    curves
        All curves of the boundary, lines among them.

    Raises
    ------
    InputError
        If no edge lies on a curve.
    """
    points = snapped_points(mesh, curves)
    sets = np.full(mesh.n_cells, -1, dtype=np.int64)
    for index, cells in enumerate(mesh.cell_sets.values()):
        sets[cells] = index
    one, other = mesh.edge_cells.T
    edges = np.flatnonzero((other < 0) | (sets[one] != sets[other]))
    pairs = mesh.edges[edges]
    start, end = points[pairs[:, 0]], points[pairs[:, 1]]
    lengths = norms(end - start)
    segments = _segments(curves)
    best, number, parameters = np.full(len(edges), np.inf), np.full(len(edges), -1), np.zeros((len(edges), 2))
    for which, segment in enumerate(segments):
        (at_start, off_start), (at_end, off_end) = segment.closest(start), segment.closest(end)
        near = np.flatnonzero(np.maximum(off_start, off_end) <= ON_CURVE * lengths)
        off = segment.closest((start[near] + end[near]) / 2.0)[1]
        nearer = near[off < best[near]]
        best[nearer], number[nearer] = off[off < best[near]], which
        parameters[nearer] = np.column_stack((at_start[nearer], at_end[nearer]))
    kept = [which for which, segment in enumerate(segments) if not isinstance(segment, Line)]
    rank = places_among(np.array(kept, dtype=np.int64), len(segments) + 1)
    on = rank[number] >= 0
    if not on.any():
        raise InputError(
            "curves on which no edge of the mesh lies",
            "the arcs and splines of the outline that was meshed",
            "give the outline in the frame of the mesh, or leave it out where all sides are straight",
        )
    ends = _unwrapped(segments, number, parameters)[on]
    table = EdgeCurves(pairs[on], tuple(segments[which] for which in kept), rank[number[on]], ends)
    return replace(mesh, points=points, curves=table)


def as_polylines(mesh: PolyMesh, pieces: int = PIECES, cells: Indices | None = None) -> PolyMesh:
    """Return the mesh, or some of its cells, with curved edges as straight ones between points of their curves.

    Behind its own points it has ``pieces - 1`` for each row of ``mesh.curves``, at equal steps of the parameter. Cells
    and edges keep their names. A mesh without curves is returned as it is.
    """
    curves, numbers = mesh.curves, np.arange(mesh.n_cells) if cells is None else cells
    if curves is None:
        return mesh
    inside = curves.points(np.arange(1, pieces) / pieces)
    counts, entries = mesh.cell_sizes[numbers], entries_of(mesh.cell_offsets, numbers)[0]
    first = mesh.cell_points[entries].astype(np.int64)
    rows = mesh.curve_rows[mesh.cell_edges[entries]]
    bent, added = np.flatnonzero(rows >= 0), _points_between(mesh, rows, first, pieces)
    more = np.bincount(np.repeat(np.arange(len(numbers)), counts)[bent], minlength=len(numbers))
    points = np.vstack((mesh.points, inside.reshape(-1, 2)))
    new_offsets = offsets_of(counts + (pieces - 1) * more)
    corners = np.insert(first, np.repeat(bent + 1, pieces - 1), added.ravel()).astype(np.int32)
    if cells is not None:
        return PolyMesh(points, new_offsets, corners)
    edge_sets = {}
    for name, pairs in mesh.edge_sets.items():
        rows = mesh.curve_rows[mesh.edge_numbers(pairs)]
        divided_pairs, added = (
            np.repeat(np.flatnonzero(rows >= 0), pieces - 1),
            _points_between(mesh, rows, pairs[:, 0], pieces),
        )
        edge_sets[name] = pairs_divided(pairs, divided_pairs, added.ravel())
    return PolyMesh(points, new_offsets, corners, mesh.cell_sets, edge_sets)


def _points_between(mesh: PolyMesh, rows: Ints, starts: Indices, pieces: int) -> Ints:
    """Numbers in `as_polylines` of the points inside the curved ones among edges (m, pieces - 1), in direction.

    - `rows`, `starts`: of all edges, the row in ``mesh.curves`` or -1 and the first point.
    """
    assert mesh.curves is not None
    bent = rows >= 0
    numbers = mesh.n_points + rows[bent, None] * (pieces - 1) + np.arange(pieces - 1)
    backwards = starts[bent] != mesh.curves.pairs[rows[bent], 0]
    numbers[backwards] = numbers[backwards, ::-1]
    return numbers


def _unwrapped(segments: Sequence[Segment | Spline], number: Ints, parameters: Floats) -> Floats:
    """Parameters (n, 2) of edges that pass the end of a closed spline, continued beyond it."""
    for which, segment in enumerate(segments):
        if isinstance(segment, Spline) and segment.closed:
            on_segment = number == which
            parameters[on_segment, 1] -= np.round(parameters[on_segment, 1] - parameters[on_segment, 0])
    return parameters


def _segments(curves: Curves) -> list[Segment | Spline]:
    """All lines, arcs and splines of curves."""
    if isinstance(curves, Section | Region):
        curves = curves.loops
    segments: list[Segment | Spline] = []
    for curve in curves if isinstance(curves, Iterable) else [curves]:
        if not isinstance(curve, Contour | Spline):
            raise InputError(
                f"{short(curve)} as a curve of the boundary",
                "outlines, chains and splines, one or several; or a region, or a section",
                "give what was meshed, or fw.geometry.Spline(points)",
            )
        segments += curve.segments if isinstance(curve, Contour) else [curve]
    return segments


def snapped_points(mesh: PolyMesh, curves: Curves) -> Floats:
    """Return the mesh's points (n_points, 2) with those of the boundary that are near an arc moved onto it.

    Points at the ends of arcs, and those nearer to a line, stay; so all curves of the boundary must be given. Near
    means within the length of the boundary edges there.
    """
    rim = np.unique(mesh.boundary_edges)
    points, rim_points = mesh.points.copy(), mesh.points[rim]
    nearest = MAX_CURVE_DISTANCE * shortest_edges(mesh.points, mesh.boundary_edges)[rim]
    for segment in _segments(curves):
        parameter, distance = segment.closest(rim_points)
        nearer = distance < nearest
        nearest[nearer] = distance[nearer]
        points[rim[nearer]] = rim_points[nearer]
        inside = nearer & (parameter > 1e-9) & (parameter < 1.0 - 1e-9)
        if not isinstance(segment, Line):
            points[rim[inside]] = segment.point(parameter[inside])
    return points


def with_names(mesh: PolyMesh, outlines: Sequence[Contour]) -> PolyMesh:
    """Return the mesh with each edge of its boundary in the set of the name of the segment that it is closest to."""
    middles = mesh.points[mesh.boundary_edges].mean(axis=1)
    names, best = np.full(len(middles), "", dtype=object), np.full(len(middles), np.inf)
    for outline in outlines:
        number, _, distance = outline.closest(middles)
        nearer = distance < best
        best[nearer] = distance[nearer]
        names[nearer] = np.array(outline.names, dtype=object)[number[nearer]]
    for name in sorted(set(names.tolist())):
        mesh = mesh.with_edge_set(name, mesh.boundary_edges[names == name])
    return mesh
