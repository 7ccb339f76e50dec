"""Nodes inserted into the edges of a boundary, so that the boundaries of two bodies in contact match.

A point on an edge is a further corner of the cell there, with a straight angle, or on the curve of a curved edge.
Virtual elements take such cells as they are.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from flangeway.errors import InputError
from flangeway.geometry.arrays import IntArray, as_point, as_points, cross_product, norms, point_text
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
COLLINEAR = 1e-6  # turn between edges, in rad, below which they are one straight line
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

    Points are opposite each other along the normals of the second boundary, whose directions change linearly along its
    edges, from one mean direction of the edges at a node to the next (B. Yang, T. A. Laursen and X. Meng, 2005, Int. J.
    Numer. Meth. Engng. 62). So the order of the nodes is the same on both sides, whatever the gap is, as long as it is
    below the radii of the second boundary. Where the other boundary is not opposite, an edge stays as it is. A point
    within `MERGE` of a node, over the shorter edge there, is that node. For `NodeToNode` contact.

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

    Each boundary is points (n_points, 2), and edges (m, 2) with the body on their left.
    """
    normals = [_normals(*boundary) for boundary in (one, other)]
    return _opposite(one, normals[0], other, normals[1], own=False), _opposite(other, normals[1], one, normals[0])


def _normals(points: Floats, pairs: Indices) -> Floats:
    """Outward directions at the points of a boundary, linear along its straight lines, zero elsewhere (n_points, 2).

    At the end of a line the direction is the mean of the normals, that of the shorter line with the larger weight: on
    chords of a circle it is the circle's.
    """
    chain = ordered_pairs(np.asarray(pairs, dtype=np.int32), "boundary").astype(np.int64)
    chords = points[chain[:, 1]] - points[chain[:, 0]]
    before = np.roll(chords, 1, axis=0)
    lengths = norms(chords)
    bent = np.abs(cross_product(before, chords)) > COLLINEAR * lengths * np.roll(lengths, 1)
    bent |= (np.roll(chain[:, 1], 1) != chain[:, 0]) | (np.einsum("mi,mi->m", before, chords) < 0.0)
    line = (np.cumsum(bent) - 1) % max(int(bent.sum()), 1)
    sums = np.stack([np.bincount(line, column) for column in chords.T], axis=1)
    scaled = np.column_stack((sums[:, 1], -sums[:, 0])) / np.einsum("li,li->l", sums, sums)[:, None]
    normals = np.zeros_like(points)
    first, last = bent, np.roll(bent, -1)  # edges at the start and at the end of their lines
    np.add.at(normals, chain[first, 0], scaled[line[first]])
    np.add.at(normals, chain[last, 1], scaled[line[last]])
    sizes = norms(normals)
    normals /= np.where(sizes > 0.0, sizes, 1.0)[:, None]
    ends = np.zeros((2, len(sums)), dtype=np.int64)
    ends[0, line[first]], ends[1, line[last]] = chain[first, 0], chain[last, 1]
    inner, line_of_inner = chain[~bent, 0], line[~bent]
    start = points[ends[0, line_of_inner]]
    part = np.einsum("mi,mi->m", points[inner] - start, sums[line_of_inner]) / np.einsum(
        "mi,mi->m", sums[line_of_inner], sums[line_of_inner]
    )
    normals[inner] = (1.0 - part)[:, None] * normals[ends[0, line_of_inner]] + part[:, None] * normals[
        ends[1, line_of_inner]
    ]
    return normals


def _opposite(
    onto: tuple[Floats, Indices], own_normals: Floats,
    other: tuple[Floats, Indices], normals: Floats, *, own: bool = True,
) -> OppositePlaces:  # fmt: skip
    """Places on one boundary opposite the nodes of another one, along the normals of the first or of the second."""
    (points, pairs), nodes = onto, np.unique(other[1])
    edges, at_ends = points[pairs], own_normals[pairs]
    lengths = norms(edges[:, 1] - edges[:, 0])
    pieces = []
    for some in np.array_split(nodes, 1 + len(nodes) * len(edges) // MAX_PAIRS):
        apart = other[0][some][:, None, None] - edges  # (n, m, 2, 2)
        along = at_ends[None] if own else np.broadcast_to(-normals[some][:, None, None], apart.shape)
        ends = cross_product(apart, along)  # behind the normal at the start, before that at the end
        which, at = np.nonzero((ends[..., 0] <= MERGE * lengths) & (ends[..., 1] >= -MERGE * lengths))
        facing = np.einsum("ki,ki->k", normals[some[which]], at_ends[at].sum(axis=1)) < 0.0
        which, at = which[facing], at[facing]
        first, chord = ends[which, at, 0], edges[at, 1] - edges[at, 0]
        square = -cross_product(chord, at_ends[at, 1] - at_ends[at, 0]) if own else np.zeros(len(at))
        slope = ends[which, at, 1] - first - square
        root = slope + np.sqrt(np.maximum(slope**2 - 4.0 * square * first, 0.0))
        rising = root > 0.0
        which, at, chord = which[rising], at[rising], chord[rising]
        parameters = np.clip(-2.0 * first[rising] / root[rising], 0.0, 1.0)
        distances = norms(apart[which, at, 0] - parameters[:, None] * chord)
        order = np.lexsort((distances, which))
        order = order[np.diff(which[order], prepend=-1) != 0]
        pieces.append((some[which[order]], at[order], parameters[order]))
    which, at, parameters = (np.concatenate(column) for column in zip(*pieces, strict=True))
    nearest = pairs[at, (parameters > 0.5).astype(np.int64)].astype(np.int64)
    away = np.minimum(parameters, 1.0 - parameters) * lengths[at] / shortest_edges(points, pairs)[nearest]
    return OppositePlaces(which.astype(np.int64), at, parameters, nearest, away)


def _rows(mesh: PolyMesh, edges: Edges) -> Ints:
    """Rows of ``mesh.boundary_edges``."""
    return mesh.boundary_rows(mesh.edge_set(edges) if isinstance(edges, str) else edges, "nodes on the edge")
