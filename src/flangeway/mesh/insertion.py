"""Nodes inserted into the edges of a boundary, so that the boundaries of two bodies in contact match.

A point on an edge is a further corner of the cell there, with a straight angle, or on the curve of a curved edge.
Virtual elements take such cells as they are.
"""

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from flangeway.errors import InputError
from flangeway.geometry.arrays import (
    COLLINEAR,
    IntArray,
    as_point,
    as_points,
    chords_of,
    cross_product,
    extent,
    joined_columns,
    norms,
    point_text,
    turned_right,
    units_of,
)
from flangeway.geometry.segments import Line
from flangeway.mesh.connectivity import (
    EdgeCurves,
    edge_places,
    offsets_of,
    ordered_pairs,
    pairs_divided,
    row_numbers,
    shortest_edges,
    united,
)
from flangeway.mesh.polymesh import PolyMesh
from flangeway.types import Floats, Indices, Ints

MERGE = 1e-7
"""Distance of a point from a node relative to the shorter edge there, up to which it is the node."""
CORNER = math.radians(45.0)  # turn between straight lines above which each keeps its own normal
FACING = 0.5  # minus the product of the normals of points opposite each other, at least: within 60 degrees
MAX_OVERLAP = 0.05  # depth, relative to the smaller boundary's extent, up to which boundaries that overlap are opposite
MAX_PAIRS = 1_000_000  # of nodes and edges that are examined at a time

Edges = str | Indices


def divided(mesh: PolyMesh, edges: Indices, positions: Floats) -> PolyMesh:
    """Return the mesh with points on edges of its boundary; they are numbered behind its own, in the order given.

    Points, cells and sets keep their numbers and names; edge sets and curves get the pieces of their edges.

    Parameters
    ----------
    mesh
        Any mesh.
    edges
        Rows of ``mesh.boundary_edges``, one for each point, (n,).
    positions
        Where the points are on them, from 0 to 1, (n,); of an edge on a curve in parts of its parameter.
    """
    rim = mesh.boundary_edges.astype(np.int64)
    start, end = mesh.points[rim[edges, 0]], mesh.points[rim[edges, 1]]
    points = (1.0 - positions)[:, None] * start + positions[:, None] * end
    order = np.lexsort((positions, edges))
    at, numbers = edges[order].astype(np.int64), mesh.n_points + order
    # pieces of all boundary edges: the edge, both ends, and where these are on it
    owner = np.repeat(np.arange(len(rim)), 1 + np.bincount(at, minlength=len(rim)))
    pieces = pairs_divided(rim, at, numbers)
    spans = np.column_stack(
        (np.insert(np.zeros(len(rim)), at + 1, positions[order]), np.insert(np.ones(len(rim)), at, positions[order]))
    )
    curves = mesh.curves
    if curves is not None:
        rows = mesh.curve_rows[mesh.edge_numbers(rim)]
        on = rows[edges] >= 0
        ends = _curve_ends(curves, rim, rows)
        parameters = ends[edges, 0] + positions * (ends[edges, 1] - ends[edges, 0])
        for number, curve in enumerate(curves.curves):
            on_curve = on & (curves.number[rows[edges]] == number)
            points[on_curve] = curve.point(parameters[on_curve])
        curves = _divided_curves(curves, rows[owner], pieces, ends[owner], spans)
    sets = {}
    for name, pairs in mesh.edge_sets.items():
        rows, known = edge_places(pairs, mesh.boundary_edges, mesh.n_points)
        sets[name] = np.concatenate((pairs[~known], pieces[np.isin(owner, rows[known])]))
    return PolyMesh(
        np.concatenate((mesh.points, points)),
        *corners_added(mesh, at, numbers),
        mesh.cell_sets,
        sets,
        curves,
    )


def corners_added(mesh: PolyMesh, edges: Ints, points: Ints) -> tuple[IntArray, IntArray]:
    """Offsets and points of the cells with further corners on boundary edges, in their order along the boundary.

    - `edges`, `points`: rows of ``mesh.boundary_edges``, rising, and numbers of the corners, (n,).
    """
    count = np.bincount(mesh.cell_edges, minlength=mesh.n_edges)
    entries = np.flatnonzero(count[mesh.cell_edges] == 1)[edges]  # in the order of boundary_edges
    more = np.bincount(row_numbers(mesh.cell_offsets)[entries], minlength=mesh.n_cells)
    return offsets_of(mesh.cell_sizes + more), np.insert(mesh.cell_points, entries + 1, points)


def _curve_ends(curves: EdgeCurves, rim: Ints, rows: Ints) -> Floats:
    """Parameters of boundary edges at both ends in their direction; what straight ones have is not used."""
    ends = curves.ends[rows]
    return np.where((curves.pairs[rows, 0] == rim[:, 0])[:, None], ends, ends[:, ::-1])


def _divided_curves(curves: EdgeCurves, rows: Ints, pieces: IntArray, ends: Floats, spans: Floats) -> EdgeCurves:
    """Curved edges with the pieces of those at the boundary in their place."""
    inner = np.ones(len(curves.pairs), dtype=bool)
    inner[rows[rows >= 0]] = False
    on, kept = rows >= 0, curves.taken(inner)
    within = ends[:, :1] + spans * (ends[:, 1:] - ends[:, :1])
    outer = EdgeCurves(pieces[on], curves.curves, curves.number[rows[on]], within[on])
    return outer if kept is None else united([kept, outer])


def edges_halved(mesh: PolyMesh, edge_set: str) -> PolyMesh:
    """Return the mesh with a point in the middle of each edge of a set, which becomes a corner of the cell there.

    Cell sets ``"polygons"`` and ``"triangles"`` name the cells that have got one and the others.
    """
    rows = _rows(mesh, edge_set)
    halved = divided(mesh, rows, np.full(len(rows), 0.5))
    more = halved.cell_sizes > mesh.cell_sizes
    return halved.with_cell_set("polygons", more).with_cell_set("triangles", ~more)


def insert_nodes(mesh: PolyMesh, edges: Edges, points: ArrayLike) -> PolyMesh:
    """Return the mesh with nodes at the projections of points onto edges of its boundary.

    Each point is projected onto the closest of the edges; one whose projection is a node already, within `MERGE` of the
    shorter edge there, or that of a point before, gives none.

    Parameters
    ----------
    mesh
        Polygons; elements must take cells with any number of corners, as `Virtual` does.
    edges
        Edge set, or pairs of points (m, 2) in either direction.
    points
        Shape (n, 2).

    Raises
    ------
    InputError
        If an edge is not at the boundary.
    """
    rows, given = _rows(mesh, edges), as_points(points)
    distances, positions = np.full(len(given), np.inf), np.zeros(len(given))
    nearest = np.zeros(len(given), dtype=np.int64)
    on_curve = mesh.curve_rows[mesh.edge_numbers(mesh.boundary_edges[rows])]
    for row, bent in zip(rows.tolist(), on_curve.tolist(), strict=True):
        start, end = mesh.points[mesh.boundary_edges[row]]
        if bent < 0:
            parameter, distance = Line(as_point(start), as_point(end)).closest(given)
        else:
            assert mesh.curves is not None
            curve, ends = mesh.curves.curves[mesh.curves.number[bent]], mesh.curves.ends[bent]
            parameters = curve.closest(given)[0]
            parameters = parameters - np.round(parameters - ends.mean()) * getattr(curve, "closed", False)
            parameter = np.clip((parameters - ends[0]) / (ends[1] - ends[0]), 0.0, 1.0)
            distance = norms(given - curve.point(ends[0] + parameter * (ends[1] - ends[0])))
            if mesh.curves.pairs[bent, 0] != mesh.boundary_edges[row, 0]:
                parameter = 1.0 - parameter
        nearer = distance < distances
        distances[nearer], positions[nearer], nearest[nearer] = distance[nearer], parameter[nearer], row
    new = np.minimum(positions, 1.0 - positions) > MERGE
    order = np.flatnonzero(new)[np.lexsort((positions[new], nearest[new]))]
    apart = (np.diff(nearest[order], prepend=-1) != 0) | (np.diff(positions[order], prepend=-1.0) > MERGE)
    chosen = np.sort(order[apart])
    return divided(mesh, nearest[chosen], positions[chosen])


def match_boundaries(one: PolyMesh, edges: Edges, other: PolyMesh, other_edges: Edges) -> tuple[PolyMesh, PolyMesh]:
    """Return two meshes whose boundaries have nodes opposite each other: each gets those of the other one.

    Points are opposite each other along the mean of the normals of both boundaries, whose directions change linearly
    along the edges, from one mean direction of the edges at a node to the next (after B. Yang, T. A. Laursen and
    X. Meng, 2005, Int. J. Numer. Meth. Engng. 62), and jump at corners. So the order of the nodes is the same on both
    sides, whatever the gap is, as long as it is below the radii of the boundaries, and that of the arguments does not
    matter. Where the other boundary is not opposite, an edge stays as it is. A point within `MERGE` of a node, over the
    shorter edge there, is that node. For `NodeToNode` contact.

    Parameters
    ----------
    one, other
        Meshes in common axes, where the bodies are before the deformation.
    edges, other_edges
        Their boundaries in contact: edge sets, or pairs of points (m, 2) in either direction.

    Raises
    ------
    InputError
        If an edge is not at the boundary, or nowhere the boundaries are opposite each other.
    """
    sides = (one, _rows(one, edges)), (other, _rows(other, other_edges))
    pairs = [mesh.boundary_edges[rows] for mesh, rows in sides]
    onto = opposite_places((one.points, pairs[0]), (other.points, pairs[1]))
    if not (len(onto[0].points) or len(onto[1].points)):
        raise InputError(
            f"boundaries that are nowhere opposite each other, near {point_text(one.points[pairs[0][0, 0]])} and near "
            f"{point_text(other.points[pairs[1][0, 0]])}",
            "two boundaries that face each other, in common axes",
            "place the meshes where the bodies are before the deformation, and check the edges",
        )
    same = [np.zeros(mesh.n_points, dtype=bool) for mesh, _ in sides]  # nodes that have an opposite node
    for side, onto_edges in enumerate(onto):
        near = onto_edges.away <= MERGE
        same[side][onto_edges.nearest[near]] = True
        same[1 - side][onto_edges.points[near]] = True
    matched = []
    for side, onto_edges in enumerate(onto):
        new = ~same[1 - side][onto_edges.points]
        mesh, rows = sides[side]
        matched.append(divided(mesh, rows[onto_edges.edges[new]], onto_edges.places[new]))
    return matched[0], matched[1]


def match_all(meshes: Mapping[str, PolyMesh], pairs: Sequence[tuple[str, str, str, str]]) -> dict[str, PolyMesh]:
    """Return meshes by name with several pairs of matching boundaries, each of which may be in several pairs.

    - `pairs`: name of a mesh, of its edge set, and of another mesh and its edge set.

    Raises `InputError` as `match_boundaries`, or if the boundaries give each other ever more nodes.
    """
    matched = dict(meshes)
    for _ in range(1 + len(pairs)):
        before = {name: mesh.n_points for name, mesh in matched.items()}
        for one, edges, other, other_edges in pairs:
            matched[one], matched[other] = match_boundaries(matched[one], edges, matched[other], other_edges)
        if before == {name: mesh.n_points for name, mesh in matched.items()}:
            return matched
    raise InputError(
        f"{len(pairs)} pairs of boundaries that give each other ever more nodes",
        "boundaries that can match",
        "leave out edges that are in several pairs",
    )


@dataclass(frozen=True, eq=False)
class OppositePlaces:
    """Places on the edges of one boundary that are opposite the nodes of another one; k of them.

    Numbers of the nodes, rows of the edges, where on them from 0 to 1; the nearer end of the edge, and its distance
    over the shorter edge there. All of shape (k,).
    """

    points: Ints
    edges: Ints
    places: Floats
    nearest: Ints
    away: Floats


def opposite_places(
    one: tuple[Floats, Indices], other: tuple[Floats, Indices]
) -> tuple[OppositePlaces, OppositePlaces]:
    """Places on the first boundary opposite the nodes of the second one, and the other way; see `match_boundaries`.

    Each boundary is points (n_points, 2), and edges (m, 2) with the body on their left. Neither is before the other.
    """
    normals = [_normals(*boundary) for boundary in (one, other)]
    reach = MAX_OVERLAP * min(extent(points[np.unique(pairs)]) for points, pairs in (one, other))
    return _opposite(one, normals[0], other, normals[1], reach), _opposite(other, normals[1], one, normals[0], reach)


def _normals(points: Floats, pairs: Indices) -> Floats:
    """Outward directions at both ends of the edges of a boundary, linear along its straight lines (m, 2, 2).

    Where two lines meet the direction is the mean of their normals, that of the shorter line with the larger weight: on
    chords of a circle it is the circle's. Lines that meet at more than `CORNER` keep their own.
    """
    chain = ordered_pairs(np.asarray(pairs, dtype=np.int32), "boundary").astype(np.int64)
    chords = chords_of(points[chain])
    before = np.roll(chords, 1, axis=0)
    turns = np.abs(np.arctan2(cross_product(before, chords), np.einsum("mi,mi->m", before, chords)))
    turns[np.roll(chain[:, 1], 1) != chain[:, 0]] = np.pi
    bent = turns > COLLINEAR
    line = (np.cumsum(bent) - 1) % max(int(bent.sum()), 1)
    sums: Floats = np.stack([np.bincount(line, column) for column in chords.T], axis=1)
    squares = np.einsum("li,li->l", sums, sums)
    scaled = turned_right(sums) / squares[:, None]
    smooth = np.zeros(len(sums), dtype=bool)
    smooth[line[bent]] = turns[bent] <= CORNER  # of each line with the one before
    joint = scaled + np.roll(scaled, 1, axis=0)
    starts = np.where(smooth[:, None], joint, scaled)
    ends = np.where(np.roll(smooth, -1)[:, None], np.roll(joint, -1, axis=0), scaled)
    starts, ends = (units_of(directions) for directions in (starts, ends))
    first = np.zeros((len(sums), 2))
    first[line[bent]] = points[chain[bent, 0]]
    part = np.einsum("mei,mi->me", points[chain] - first[line][:, None], sums[line]) / squares[line][:, None]
    normals = np.empty((len(chain), 2, 2))
    # the edges came in another order
    normals[np.lexsort(np.asarray(pairs).T)] = (
        starts[line][:, None] + part[:, :, None] * (ends - starts)[line][:, None]
    )[np.lexsort(chain.T)]
    return normals


def _opposite(
    onto: tuple[Floats, Indices], at_ends: Floats,
    other: tuple[Floats, Indices], normals: Floats, reach: float,
) -> OppositePlaces:  # fmt: skip
    """Places on one boundary opposite the nodes of another one, along the mean of the normals of both at both points.

    - `reach`: depth of an overlap up to which boundaries face each other.
    """
    points, pairs = onto
    # a node at a corner has the directions of both lines
    candidates = np.unique(np.column_stack((np.ravel(other[1]), normals.reshape(-1, 2))), axis=0)
    nodes, directions = candidates[:, 0].astype(np.int64), candidates[:, 1:]
    edges = points[pairs]
    chords, lengths = chords_of(edges), norms(chords_of(edges))
    pieces = []
    for some in np.array_split(np.arange(len(nodes)), 1 + len(nodes) * len(edges) // MAX_PAIRS):
        apart = other[0][nodes[some]][:, None, None] - edges  # (n, m, 2, 2)
        along = at_ends[None] - directions[some][:, None, None]
        ends = cross_product(apart, along)  # behind the normal at the start, before that at the end
        slack = 2.0 * MERGE * lengths
        which, at = np.nonzero((ends[..., 0] <= slack) & (ends[..., 1] >= -slack))
        first, chord = ends[which, at, 0], chords[at]
        square = -cross_product(chord, at_ends[at, 1] - at_ends[at, 0])
        slope = ends[which, at, 1] - first - square
        root = slope + np.sqrt(np.maximum(slope**2 - 4.0 * square * first, 0.0))
        parameters = np.clip(-2.0 * first / np.where(root > 0.0, root, np.inf), 0.0, 1.0)
        steps = apart[which, at, 0] - parameters[:, None] * chord
        own, facing = at_ends[at, 0] + parameters[:, None] * (at_ends[at, 1] - at_ends[at, 0]), directions[some[which]]
        gaps = np.einsum("ki,ki->k", steps, own - facing) / 2.0
        rising = (root > 0.0) & (gaps >= -reach) & (np.einsum("ki,ki->k", own, facing) < -FACING)
        pieces.append((nodes[some[which[rising]]], at[rising], parameters[rising], norms(steps[rising])))
    which, at, parameters, distances = joined_columns(pieces)
    order = np.lexsort((distances, which))
    order = order[np.diff(which[order], prepend=-1) != 0]
    which, at, parameters = which[order], at[order], parameters[order]
    nearest = pairs[at, (parameters > 0.5).astype(np.int64)].astype(np.int64)
    away = np.minimum(parameters, 1.0 - parameters) * lengths[at] / shortest_edges(points, pairs)[nearest]
    return OppositePlaces(which, at, parameters, nearest, away)


def _rows(mesh: PolyMesh, edges: Edges) -> Ints:
    """Rows of ``mesh.boundary_edges``."""
    return mesh.boundary_rows(mesh.edge_set(edges) if isinstance(edges, str) else edges, "nodes on the edge")
