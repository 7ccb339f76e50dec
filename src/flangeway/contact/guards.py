"""Nodes of either side with a constraint each against the other side, in addition to those of the pairing.

A pairing measures the gap at the nodes of one side, or as an average. It misses a corner that lies within the other
body while the average is open, and a node of the primary side between two nodes of the secondary one. Such nodes are
found when the pairing's own equations are solved. From then on they are guarded by a constraint as in `NodeToSegment`,
whichever side the node is on. Its gap is invariant to rigid motions, so the forces on both sides are in equilibrium.
"""

from collections.abc import Sequence
from dataclasses import dataclass, fields

import numpy as np

from flangeway.contact.kinematics import closest_parameters, node_edge_gaps
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
from flangeway.contact.search import behind
from flangeway.contact.surface import Surface, node_normals
from flangeway.types import Bools, Floats, Ints

GUARDED_DEPTH = 0.9
"""Depth relative to that which chords of curves explain from which a node is guarded: between nodes it may be
larger."""
DEPTH_TOLERANCE = 0.02
"""Difference of two depths, relative to the larger one, below which it is chance which of them is the smaller one."""

END_DISTANCE = 1e-3
"""Distance of a node from one of the other side, relative to the length of an edge, below which each guards both."""

JOINED_FIELDS = [field for field in fields(Constraints) if field.name != "rows"]

Sides = tuple[Surface, Surface]
Positions = tuple[Floats, Floats]
Guards = tuple[Bools, Bools]


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
        Which of their nodes are guarded, each (n_nodes,).
    before
        The constraints of the iteration before.
    settle
        See `NodeToSegment.pair`.

    """
    places = surfaces[0].contact_places, surfaces[1].contact_places
    edges = positions[0][places[0]], positions[1][places[1]]
    first_keys, kept = key_starts(*surfaces), _kept(before, surfaces)
    taken = np.full(len(surfaces[0].nodes), -1)
    if isinstance(base, NodePairs):
        taken[base.nodes] = base.primary_edges
    guards: list[NodePairs] = []
    for side, other in ((0, 1), (1, 0)):
        nodes, faced = _paired(
            positions[side], places[side], edges[other], guarded_nodes[side], kept[side], settle=settle
        )
        node_gaps = node_edge_gaps(positions[side][nodes], edges[other][faced])
        new = faced != taken[nodes] if side == 0 else ~_repeated(guards[0], places, nodes, faced, node_gaps.parameters)
        nodes, faced, gaps, parameters = nodes[new], faced[new], node_gaps.gaps[new], node_gaps.parameters[new]
        points, slots, secondary_edges, primary_edges = node_terms(places[side], edges, nodes, faced, side)
        nearest = places[0][faced, np.where(parameters > 0.5, -1, 0)] if side == 1 else nodes
        areas = surfaces[side].tributary_areas[nodes]
        keys = first_keys[side] + nodes * len(edges[other]) + faced
        partners, members = faced + side * len(edges[1]), places[0][secondary_edges]
        row = np.arange(len(nodes))[:, None]
        guards.append(
            NodePairs(
                keys, partners, nearest, gaps, areas, areas, members, primary_edges, row, points, slots, parameters
            )
        )  # fmt: skip
    parts = (base, *guards)
    joined = {field.name: np.concatenate([getattr(part, field.name) for part in parts]) for field in JOINED_FIELDS}
    starts, width = np.cumsum([len(part.keys) for part in parts]), base.rows.shape[1]
    rows = [np.repeat(first + part.rows, width, axis=1) for first, part in zip(starts, guards, strict=False)]
    return GuardedPairs(**joined, rows=np.concatenate((base.rows, *rows)), pairs=parts)


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


def corners_under_force(pairs: Constraints, surfaces: Sides, forces: Floats) -> Guards:
    """Which nodes of either side are sharp corners whose guards carry a force, each (n_nodes,)."""
    under_force = [np.zeros(len(surface.nodes), dtype=np.bool_) for surface in surfaces]
    if isinstance(pairs, GuardedPairs):
        ends, firsts = np.cumsum([len(part.keys) for part in pairs.parts]), key_starts(*surfaces)
        for side, (part, part_forces) in enumerate(zip(pairs.parts[1:], np.split(forces, ends[:-1])[1:], strict=True)):
            under_force[side][(part.keys[part_forces > 0.0] - firsts[side]) // len(surfaces[1 - side].edges)] = True
            under_force[side] &= _sharp(surfaces[side])
    return under_force[0], under_force[1]


def key_starts(secondary: Surface, primary: Surface) -> tuple[int, int, int]:
    """First key of guarded nodes of the secondary and of the primary side, and the number of all keys.

    A guarded node and the edge that it faces have the key ``first + node * n_edges + edge``.
    """
    first = len(secondary.hats.nodes) + len(secondary.nodes)
    other = first + len(secondary.nodes) * len(primary.edges)
    return first, other, other + len(primary.nodes) * len(secondary.edges)


def _kept(before: Constraints | None, surfaces: Sides) -> tuple[Ints, Ints]:
    """Edge that each node of either side was guarded against first; -1 for none."""
    kept = tuple(np.full(len(surface.nodes), -1, dtype=np.int64) for surface in surfaces)
    if isinstance(before, GuardedPairs):
        firsts = key_starts(*surfaces)
        for side, part in enumerate(before.parts[1:]):
            nodes, edges = np.divmod(part.keys[::-1] - firsts[side], len(surfaces[1 - side].edges))
            kept[side][nodes] = edges
    return kept[0], kept[1]


def _paired(
    positions: Floats, edge_places: Ints, edges: Floats, guarded_nodes: Bools, kept: Ints, *, settle: bool
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
    nodes, partners = (np.concatenate(arrays) for arrays in zip(*pieces, strict=True))
    return nodes, partners


def penetrating(surfaces: Sides, positions: Positions, guarded_nodes: Guards, explained: float, bent: float) -> Guards:
    """Further nodes of two surfaces that lie behind the other one by more than curves and the law of contact explain.

    If sharp corners are among them, only these: they define the direction in which the other body moves, which may
    free the other nodes.

    Parameters
    ----------
    surfaces
        Secondary and primary surface.
    positions
        Current positions of the points of their `Surface.contact_places`, each (n, 2).
    guarded_nodes
        Which of their nodes are guarded already, each (n_nodes,).
    explained
        Penetration that the law of contact explains.
    bent
        Maximum depth that the deformation of edges explains on each side.

    Returns
    -------
    tuple of Bools
        For the nodes of either surface, each (n,).

    """
    edges = [at[surface.contact_places] for surface, at in zip(surfaces, positions, strict=True)]
    depth = min(float(np.linalg.norm(np.ptp(edge_points, axis=(0, 1)))) for edge_points in edges) / 2.0
    counts = [len(surface.nodes) for surface in surfaces]
    through = [np.zeros(count, dtype=np.bool_) for count in counts]
    near = [behind(at[:n], other) for at, n, other in zip(positions, counts, edges[::-1], strict=True)]
    if not (near[0].any() or near[1].any()):
        return through[0], through[1]
    sagittas = [surface.sagittas(edge_points, bent) for surface, edge_points in zip(surfaces, edges, strict=True)]
    for side, other in ((0, 1), (1, 0)):
        at, places, none = positions[side], surfaces[side].edge_places, np.full(counts[side], -1)
        given = at, places, edges[other], np.flatnonzero(near[side]), node_normals(at, places, bisecting=True), none
        secondary_depths = np.full(counts[side], np.inf)
        for column in places.T:
            np.minimum.at(secondary_depths, column, sagittas[side])

        def allowed(nodes: Ints, partners: Ints, depths: Floats = secondary_depths, other: int = other) -> Floats:
            return GUARDED_DEPTH * (depths[nodes] + sagittas[other][partners]) + explained

        margins = guarded_margins(edges[other])
        nodes, _, gaps = facing_pairs(*given, FOOT_SLACK, margins, FOOT_SLACK, allowed)
        through[side][nodes[gaps.gaps > -depth]] = True
    through = [of_side & ~before for of_side, before in zip(through, guarded_nodes, strict=True)]
    sharp = through[0] & _sharp(surfaces[0]), through[1] & _sharp(surfaces[1])
    return sharp if sharp[0].any() or sharp[1].any() else (through[0], through[1])


def _sharp(surface: Surface) -> Bools:
    """Which nodes of a surface are at sharp convex corners of its body, shape (n,)."""
    result = np.zeros(len(surface.nodes), dtype=np.bool_)
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
        ends = surfaces[other].edge_places[:, [0, -1]]
        joints = np.flatnonzero(_sharp(surfaces[other])[ends[:, 1]])
        corners = np.flatnonzero(_sharp(surfaces[side]))
        if len(corners) == 0 or len(joints) == 0:
            continue
        pair = corners.repeat(len(joints)), np.tile(joints, len(corners))
        edges = positions[other][ends]
        into, out = edges[pair[1]], edges[(pair[1] + 1) % len(edges)]
        depths = -np.stack([node_edge_gaps(positions[side][pair[0]], edge).gaps for edge in (into, out)])
        lengths = np.minimum(*(np.linalg.norm(edge[:, 1] - edge[:, 0], axis=1) for edge in (into, out)))
        similar = np.abs(depths[0] - depths[1]) <= DEPTH_TOLERANCE * depths.max(axis=0)
        similar &= (depths.min(axis=0) > 0.0) & (depths.max(axis=0) < lengths)
        gaps.append(positions[side][pair[0][similar]])
    return np.concatenate(gaps) if gaps else np.empty((0, 2))
