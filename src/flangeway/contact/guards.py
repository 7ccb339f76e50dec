"""Nodes and points of either side with a constraint each against the other one, in addition to those of the pairing.

A pairing measures the gap at the nodes of one side, or as an average. It misses a corner that lies within the other
body while the average is open, and a node of the primary side between two nodes of the secondary one. Such nodes are
found when the pairing's own equations are solved. From then on they are guarded by a constraint as in `NodeToSegment`,
whichever side the node is on. Its gap is invariant to rigid motions, so the forces on both sides are in equilibrium.

A curved edge may touch between its nodes: its deepest point is guarded as nodes are. It stays where it is on the edge
while the equations are solved, and is sought again afterwards. Guarded points of a side are numbered as its nodes, and
after these as its edges, see `Surface.guard_places`.
"""

from collections.abc import Sequence
from dataclasses import dataclass, fields

import numpy as np

from flangeway.contact.kinematics import (
    Taylor,
    as_vectors,
    closest_parameters,
    derivative,
    edge_series,
    horner,
    node_edge_gaps,
    shape_functions,
)
from flangeway.contact.node_to_segment import (
    CONCAVE_SLACK,
    FOOT_SLACK,
    OPEN_SLACK,
    NodePairs,
    facing_pairs,
    guarded_margins,
    node_terms,
)
from flangeway.contact.pairs import Constraints, Pairs
from flangeway.contact.search import behind, nearest_edges
from flangeway.contact.surface import Surface, node_normals
from flangeway.elements.quadrature import gauss_lobatto
from flangeway.geometry.arrays import (
    chords_of,
    diagonal,
    joined_columns,
    norms,
    quotients,
    root_parameters,
    turned_right,
)
from flangeway.types import Bools, Floats, Ints

GUARDED_DEPTH = 0.9
"""Depth relative to that which chords of curves explain from which a node is guarded: between nodes it may be
larger."""
DEPTH_TOLERANCE = 0.02
"""Difference of two depths, relative to the larger one, below which it is chance which of them is the smaller one."""

END_DISTANCE = 1e-4
"""Distance of a node from one of the other side, relative to the length of an edge, below which each guards both."""

JOINED_FIELDS = [field for field in fields(Constraints) if field.name != "rows"]

POINTS_OF_EDGES = np.linspace(0.0, 1.0, 7)
"""Points of a curved edge from which the search for its deepest one starts."""

PARAMETER_STEP = 1e-4
"""Difference of parameters for the derivatives of this search."""

Sides = tuple[Surface, Surface]
Positions = tuple[Floats, Floats]
Guards = tuple[Floats, Floats]
"""Of the points of both sides: 1 for guarded nodes, the parameter > 0 of guarded points of edges, 0 for the others."""


@dataclass(frozen=True, eq=False)
class PointPairs(NodePairs):
    """Points of edges of either side, and edges of the other one that they face: a constraint and a term each.

    Parameters
    ----------
    weights
        Each point by the points of its term, shape (m, w); the first of its slots means nothing.

    """

    weights: Floats

    def _variables(self, chosen: Ints, *, second: bool) -> Taylor:
        points, slots = self.points[chosen], self.slots[chosen, 1:]
        faced = Taylor.of_points(points, second=second, slots=slots)
        point = (Taylor.of_points(points, second=False) * self.weights[chosen]).sum()
        value = np.concatenate((point.value[:, None], faced.value), axis=1)
        return Taylor(value, np.concatenate((point.first[..., None], faced.first), axis=2), faced.second)

    def _at_slots(self, points: Floats) -> Floats:
        on_edges = np.einsum("mw,mwi->mi", self.weights, points)[:, None]
        return np.concatenate((on_edges, np.take_along_axis(points, self.slots[:, 1:, None], axis=1)), axis=1)

    def opposite_points(self, edges: Floats) -> Floats:
        """See `Pairs.opposite_points`."""
        of_primary, n = self.weights[:, -edges.shape[1] :], edges.shape[1]
        on_faced = shape_functions(n - 1, self.parameters, 0)[0] if len(self.parameters) else np.zeros((0, n))
        weights = np.where((of_primary != 0.0).any(axis=1, keepdims=True), of_primary, on_faced[:, :n])
        return np.einsum("na,nai->ni", weights, edges[self.primary_edges])


@dataclass(frozen=True, eq=False)
class GuardedPairs(Constraints):
    """Constraints of a pairing, then those of guarded nodes of the secondary and of the primary side.

    Every term has the points of a secondary and of a primary edge.
    """

    pairs: tuple[Pairs, ...]

    @property
    def parts(self) -> Sequence[Pairs]:
        """See `Constraints.parts`."""
        return self.pairs

    def opposite_points(self, edges: Floats) -> Floats:
        """See `Constraints.opposite_points`."""
        return np.concatenate([part.opposite_points(edges) for part in self.parts])


def guarded(
    base: Pairs,
    surfaces: Sides,
    positions: Positions,
    guarded_nodes: Guards,
    before: Constraints | None,
    *,
    settle: bool,
) -> GuardedPairs:
    """Add constraints of guarded nodes to those of a pairing.

    Parameters
    ----------
    base
        The pairing's constraints.
    surfaces
        Secondary and primary surface.
    positions
        Current positions of the points of their `Surface.contact_places`, each (n, 2).
    guarded_nodes
        Which of their points are guarded, each (n_nodes + n_edges,).
    before
        The constraints of the iteration before.
    settle
        See `NodeToSegment.pair`.

    """
    places = surfaces[0].guard_places, surfaces[1].guard_places
    edges = _edges_at(surfaces, positions)
    first_keys, kept = key_starts(*surfaces), _kept(before, surfaces)
    taken = np.full(len(guarded_nodes[0]), -1)
    if isinstance(base, NodePairs):
        taken[base.nodes] = base.primary_edges
    guards: list[NodePairs] = []
    for side, other in ((0, 1), (1, 0)):
        at = _guard_points(surfaces[side], edges[side], guarded_nodes[side])
        nodes, faced = _paired(at, places[side], edges[other], guarded_nodes[side], kept[side], settle=settle)
        node_gaps = node_edge_gaps(at[nodes], edges[other][faced])
        new = faced != taken[nodes] if side == 0 else ~_repeated(guards[0], places, nodes, faced, node_gaps.parameters)
        nodes, faced, gaps, feet = nodes[new], faced[new], node_gaps.gaps[new], node_gaps.parameters[new]
        guards.append(_guards(surfaces, edges, side, nodes, faced, gaps, feet, guarded_nodes[side], first_keys[side]))
    parts = (base, *guards)
    joined = {field.name: np.concatenate([getattr(part, field.name) for part in parts]) for field in JOINED_FIELDS}
    starts, width = np.cumsum([len(part.keys) for part in parts]), base.rows.shape[1]
    rows = [np.repeat(first + part.rows, width, axis=1) for first, part in zip(starts, guards, strict=False)]
    return GuardedPairs(**joined, rows=np.concatenate((base.rows, *rows)), pairs=parts)


def _edges_at(surfaces: Sides, positions: Positions) -> tuple[Floats, Floats]:
    """Points of the edges of both sides, each (n_edges, order + 1, 2)."""
    return positions[0][surfaces[0].contact_places], positions[1][surfaces[1].contact_places]


def _guards(
    surfaces: Sides,
    edges: tuple[Floats, Floats],
    side: int,
    nodes: Ints,
    faced: Ints,
    gaps: Floats,
    feet: Floats,
    guarded_nodes: Floats,
    first_key: int,
) -> NodePairs:
    """Constraints of guarded points of a side against edges of the other one, on which they have feet; each (m,)."""
    surface, n = surfaces[side], len(surfaces[side].nodes)
    points, slots, secondary_edges, primary_edges = node_terms(surface.guard_places, edges, nodes, faced, side)
    owners, widths = (secondary_edges, primary_edges)[side], [side_edges.shape[1] for side_edges in edges]
    places = surface.edge_places[owners]
    column = (places == nodes[:, None]).argmax(axis=1)
    at_nodes = gauss_lobatto(places.shape[1])[0]
    own = np.where(nodes < n, at_nodes[column], guarded_nodes[nodes])
    weights = np.zeros((len(nodes), sum(widths)))
    weights[:, side * widths[0] : side * widths[0] + widths[side]] = shape_functions(widths[side] - 1, own, 0)[0]
    ends = places[:, [0, -1]]
    owned = np.where(nodes < n, nodes, ends[np.arange(len(nodes)), (own > 0.5).astype(np.int64)])
    nearest = owned if side == 0 else surfaces[0].edge_places[faced, np.where(feet > 0.5, -1, 0)]
    areas = surface.tributary_areas[owned]
    keys, partners = first_key + nodes * len(edges[1 - side]) + faced, faced + side * len(edges[1])
    members, row = surfaces[0].contact_places[secondary_edges], np.arange(len(nodes))[:, None]
    return PointPairs(
        keys, partners, nearest, gaps, areas, areas, members, primary_edges, row, points, slots, feet, weights
    )


def _guard_points(surface: Surface, edges: Floats, guarded_nodes: Floats) -> Floats:
    """Points of `Surface.guard_places`: nodes, then a point of each of the edges (n_edges, order + 1, 2)."""
    n, width = len(surface.nodes), surface.edge_places.shape[1]
    at_nodes, at_points = np.zeros((n, 2)), shape_functions(edges.shape[1] - 1, guarded_nodes[n:], 0)[0]
    columns = np.rint(np.linspace(0, edges.shape[1] - 1, width)).astype(np.int64)
    at_nodes[surface.edge_places] = edges[:, columns]
    return np.concatenate((at_nodes, np.einsum("ea,eai->ei", at_points, edges)))


def _deepest(edges: Floats, other: Floats) -> Floats:
    """Parameters of the deepest points of curved edges (m, order + 1, 2) behind other ones, shape (m,)."""
    xi = np.tile(POINTS_OF_EDGES, (len(edges), 1))
    series = edge_series(edges)
    columns = [coefficient[:, None] for coefficient in series]
    at, slope = (as_vectors(horner(of, xi)).reshape(-1, 2) for of in (columns, derivative(columns)))
    faced = nearest_edges(at, turned_right(slope), other)
    gaps = np.where(faced >= 0, node_edge_gaps(at, other[faced]).gaps, np.inf).reshape(xi.shape)
    rows, first = np.arange(len(edges)), gaps.argmin(axis=1)
    faced, xi = faced.reshape(xi.shape)[rows, first], xi[rows, first]

    def rates(xi: Floats) -> Floats:
        """Derivatives of the gaps by the parameters: at the deepest point the tangents are parallel."""
        normals = node_edge_gaps(as_vectors(horner(series, xi)), other[faced]).normals
        return np.asarray((normals * as_vectors(horner(derivative(series), xi))).sum(axis=1))

    def change(xi: Floats) -> Floats:
        rate = rates(xi)
        bend = (rates(xi + PARAMETER_STEP) - rate) / PARAMETER_STEP
        return quotients(rate, bend)

    return root_parameters(change, xi, 0.25, END_DISTANCE, lambda xi: np.clip(xi, 0.0, 1.0))


def _repeated(
    secondary: NodePairs, contact_nodes: tuple[Ints, Ints], nodes: Ints, faced: Ints, parameters: Floats
) -> Bools:
    """Which primary nodes lie on a secondary one that is guarded against theirs: both constraints would be one.

    - `secondary`: guarded secondary nodes.
    - `nodes`, `faced`, `parameters`: primary nodes, secondary edges, and closest points of these, each (m,).
    """
    n = int(contact_nodes[1].max()) + 1
    met = _end_at(contact_nodes[1], secondary.primary_edges, secondary.parameters)
    secondary_ends = _end_at(contact_nodes[0], faced, parameters)
    return (secondary_ends >= 0) & np.isin(secondary_ends * n + nodes, (secondary.nodes * n + met)[met >= 0])


def _end_at(contact_nodes: Ints, edges: Ints, parameters: Floats) -> Ints:
    """Node at that end of edges where points on them are, -1 where they are at none."""
    first, last = contact_nodes[edges, 0], contact_nodes[edges, -1]
    return np.where(
        np.abs(parameters) < END_DISTANCE, first, np.where(np.abs(parameters - 1.0) < END_DISTANCE, last, -1)
    )


def key_starts(secondary: Surface, primary: Surface) -> tuple[int, int, int]:
    """First key of guarded nodes of the secondary and of the primary side, and the number of all keys.

    A guarded node and the edge that it faces have the key ``first + node * n_edges + edge``.
    """
    first = len(secondary.hats.nodes) + len(secondary.nodes)
    other = first + _n_points(secondary) * len(primary.edges)
    return first, other, other + _n_points(primary) * len(secondary.edges)


def _n_points(surface: Surface) -> int:
    """Number of the points of a surface that may be guarded."""
    return len(surface.nodes) + len(surface.edges)


def unguarded(surfaces: Sides) -> Guards:
    """No point of two surfaces."""
    return np.zeros(_n_points(surfaces[0])), np.zeros(_n_points(surfaces[1]))


def _kept(before: Constraints | None, surfaces: Sides) -> tuple[Ints, Ints]:
    """Edge that each node of either side was guarded against first; -1 for none."""
    kept = tuple(np.full(_n_points(surface), -1, dtype=np.int64) for surface in surfaces)
    if isinstance(before, GuardedPairs):
        firsts = key_starts(*surfaces)
        for side, part in enumerate(before.parts[1:]):
            nodes, edges = np.divmod(part.keys[::-1] - firsts[side], len(surfaces[1 - side].edges))
            kept[side][nodes] = edges
    return kept[0], kept[1]


def _paired(
    positions: Floats, edge_places: Ints, edges: Floats, guarded_nodes: Floats, kept: Ints, *, settle: bool
) -> tuple[Ints, Ints]:
    """Guarded nodes that face an edge of the other side, and those edges.

    At a concave joint the other body's outside is what is outside of both edges: a node has a constraint against each.
    """
    directions = node_normals(positions, edge_places, bisecting=True)
    given = positions, edge_places, edges, np.flatnonzero(guarded_nodes), directions, kept
    margins = guarded_margins(edges)
    stay = OPEN_SLACK if settle else FOOT_SLACK
    nodes, partners, gaps = facing_pairs(*given, stay, margins, FOOT_SLACK)
    pieces = [(nodes, partners)]
    for end, step in ((1, 1), (0, -1)):
        concave = margins[partners, end] == CONCAVE_SLACK
        both, beside = nodes[concave], (partners[concave] + step) % len(edges)
        # a node that is off this joint on one edge is in front of the other one
        near = step * (gaps.parameters[concave] - end) > 0.0
        near |= np.abs(closest_parameters(positions[both], edges[beside]) - 0.5) < 0.5 + FOOT_SLACK
        pieces.append((both[near], beside[near]))
    nodes, partners = joined_columns(pieces)
    return nodes, partners


def penetrating(
    surfaces: Sides, positions: Positions, guarded_nodes: Guards, explained: float, bent: float, *, follow: bool
) -> Guards:
    """Further nodes of two surfaces that lie behind the other one by more than curves and the law of contact explain.

    If sharp corners are among them, only these: they define the direction in which the other body moves, which may
    free the other nodes. Otherwise, if deepest points of curved edges are among them, only these, for the same reason.

    Parameters
    ----------
    surfaces
        Secondary and primary surface.
    positions
        Current positions of the points of their `Surface.contact_places`, each (n, 2).
    guarded_nodes
        Which of their points are guarded already, each (n_nodes + n_edges,).
    explained
        Penetration that the law of contact explains.
    bent
        Maximum depth that the deformation of edges explains on each side.
    follow
        Whether edges may follow their curves all along; else, as with friction, whose slip is that of nodes, they are
        chords between these.

    Returns
    -------
    tuple of Floats
        For the points of either surface, each (n_nodes + n_edges,); points of edges may have another parameter now.

    """
    edges = _edges_at(surfaces, positions)
    depth = min(diagonal(edge_points) for edge_points in edges) / 2.0
    counts = [len(surface.nodes) for surface in surfaces]
    through = list(unguarded(surfaces))
    points = [np.concatenate((positions[side][: counts[side]], edges[side].mean(axis=1))) for side in (0, 1)]
    near = [behind(at, other) for at, other in zip(points, edges[::-1], strict=True)]
    for side, surface in enumerate(surfaces):
        near[side][counts[side] :] &= surface.is_curved & follow
    if not (near[0].any() or near[1].any()):
        return through[0], through[1]
    sagittas = [
        surface.sagittas(edge_points, bent, surface.follows_curve & follow)
        for surface, edge_points in zip(surfaces, edges, strict=True)
    ]
    for side, other in ((0, 1), (1, 0)):
        places, parameters = surfaces[side].guard_places, np.ones(len(points[side]))
        at_edges = parameters[counts[side] :]
        chosen = near[side][counts[side] :]
        if chosen.any():
            at_edges[chosen] = _deepest(edges[side][chosen], edges[other])
        at = _guard_points(surfaces[side], edges[side], parameters)
        # at the ends of edges nodes have the constraint, and the deepest point may be the guarded one
        near[side][counts[side] :] &= np.abs(at_edges - 0.5) < 0.5 - END_DISTANCE
        near[side] &= np.abs(parameters - guarded_nodes[side]) > END_DISTANCE
        none, normals = np.full(len(at), -1), node_normals(at, places, bisecting=True)
        given = at, places, edges[other], np.flatnonzero(near[side]), normals, none
        secondary_depths = np.full(len(at), np.inf)
        for column in places.T:
            np.minimum.at(secondary_depths, column, sagittas[side])

        def allowed(nodes: Ints, partners: Ints, depths: Floats = secondary_depths, other: int = other) -> Floats:
            return GUARDED_DEPTH * (depths[nodes] + sagittas[other][partners]) + explained

        margins = guarded_margins(edges[other])
        nodes, faced, gaps = facing_pairs(*given, FOOT_SLACK, margins, FOOT_SLACK, allowed)
        again = (nodes >= counts[side]) & surfaces[other].is_curved[faced] if side == 1 else nodes < 0
        deep = nodes[(gaps.gaps > -depth) & ~again]
        through[side][deep] = parameters[deep]
    sharp = [guards * _sharp(surface) for guards, surface in zip(through, surfaces, strict=True)]
    deepest = [guards * (np.arange(len(guards)) >= count) for guards, count in zip(through, counts, strict=True)]
    first = next((masks for masks in (sharp, deepest) if masks[0].any() or masks[1].any()), through)
    return first[0], first[1]


def _sharp(surface: Surface) -> Bools:
    """Which nodes of a surface are at sharp convex corners of its body, shape (n,)."""
    result = np.zeros(_n_points(surface), dtype=np.bool_)
    result[surface.edge_places[surface.corners, -1]] = True
    return result


def corners_on_corners(surfaces: Sides, positions: Positions) -> Floats:
    """Points at which sharp corners of two surfaces meet so that either side may carry the load, shape (n, 2).

    Parameters
    ----------
    surfaces
        Secondary and primary surface.
    positions
        Of their nodes before the deformation, each (n, 2).

    """
    gaps = []
    for side, other in ((0, 1), (1, 0)):
        ends = surfaces[other].ends
        joints = np.flatnonzero(_sharp(surfaces[other])[ends[:, 1]])
        corners = np.flatnonzero(_sharp(surfaces[side]))
        if len(corners) == 0 or len(joints) == 0:
            continue
        pair = corners.repeat(len(joints)), np.tile(joints, len(corners))
        edges = positions[other][ends]
        into, out = edges[pair[1]], edges[(pair[1] + 1) % len(edges)]
        depths = -np.stack([node_edge_gaps(positions[side][pair[0]], edge).gaps for edge in (into, out)])
        lengths = np.minimum(*(norms(chords_of(edge)) for edge in (into, out)))
        similar = np.abs(depths[0] - depths[1]) <= DEPTH_TOLERANCE * depths.max(axis=0)
        similar &= (depths.min(axis=0) > 0.0) & (depths.max(axis=0) < lengths)
        gaps.append(positions[side][pair[0][similar]])
    return np.concatenate(gaps) if gaps else np.empty((0, 2))
