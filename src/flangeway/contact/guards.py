"""Nodes of either side that are kept off the other one by a constraint each, beside those of the pairing.

A pairing sees the gap at the nodes of one side, or as an average. A corner that lies within the other body while the
average is open, or a node of the primary side between two nodes of the secondary one, is not seen. Such nodes are found
once the pairing's own equations are solved, and are guarded from then on: a constraint as in `NodeToSegment`, whichever
side the node is on. Its gap is invariant to rigid motions, so the forces on both sides balance.
"""

from dataclasses import dataclass

import numpy as np

from flangeway.contact.boundary import SHARP, turns_of
from flangeway.contact.edge_shapes import shape_functions
from flangeway.contact.kinematics import NodeEdgeGaps, closest_parameters, node_edge_gaps
from flangeway.contact.node_to_segment import HOLLOW, SLACK, NodePairs, NodeToSegment, facing_pairs, margins_of
from flangeway.contact.pairs import Pairs
from flangeway.contact.surface import Surface
from flangeway.types import Bools, Floats, Ints

OVERHANG = 0.1
"""Parts of an edge beyond its ends within which a guarded node stays with it when an iteration goes round in circles;
`SLACK` before."""
EARLY = 0.9
"""Depth over that which chords of curves explain from which a node is guarded: between nodes it may be larger."""
ALIKE = 0.02
"""Difference of two depths, over the larger one, below which it is chance which of them is the smaller one."""


@dataclass(frozen=True, eq=False)
class _NodeTerms:
    """Terms of a node and an edge each, written as terms of an edge of either side.

    Parameters
    ----------
    nodes
        Places of the nodes in their surface, shape (n,).
    kinematics
        Gaps of the nodes over the edges.
    edges, partners
        Secondary and primary edges, each (n,).
    slots
        Place of the node, then of the edge's nodes, among those of the two edges, shape (n, order + 2).

    """

    nodes: Ints
    kinematics: NodeEdgeGaps
    edges: Ints
    partners: Ints
    slots: Ints

    def gradients(self, width: int) -> Floats:
        """Derivatives of the gaps by the nodes of both edges, ``width`` in all, shape (n, width, 2)."""
        result = np.zeros((len(self.slots), width, 2))
        np.put_along_axis(result, self.slots[:, :, None], self.kinematics.gradients, axis=1)
        return result

    def hessians(self, width: int, chosen: Ints) -> Floats:
        """Second derivatives of some, shape (m, 2 width, 2 width)."""
        dofs = (2 * self.slots[chosen][:, :, None] + np.arange(2)).reshape(len(chosen), 2 * self.slots.shape[1])
        result = np.zeros((len(chosen), 2 * width, 2 * width))
        each = np.arange(len(chosen))[:, None, None]
        result[each, dofs[:, :, None], dofs[:, None, :]] = self.kinematics.hessians[chosen]
        return result


@dataclass(frozen=True, eq=False)
class GuardedPairs:
    """Constraints of a pairing and of guarded nodes; see `flangeway.contact.pairs.Pairs`.

    Every term is one of a secondary and a primary edge.

    Parameters
    ----------
    base
        Constraints of the pairing.
    base_terms
        Their terms, if these are nodes and edges.
    guards
        Terms of the guarded nodes of the secondary side, then of the primary one.
    keys, partners, nodes, areas
        Of all constraints, those of the pairing first.
    secondary_places
        Its `Surface.contact_places`, shape (n_edges, order + 1).
    n_primary_nodes
        Number of points of a primary edge.

    """

    base: Pairs
    base_terms: _NodeTerms | None
    guards: tuple[_NodeTerms, _NodeTerms]
    keys: Ints
    partners: Ints
    nodes: Ints
    areas: Floats
    whole_areas: Floats
    secondary_places: Ints
    n_primary_nodes: int

    @property
    def gaps(self) -> Floats:
        """See `flangeway.contact.pairs.Pairs.gaps`."""
        return np.concatenate((self.base.gaps, *(guard.kinematics.gaps for guard in self.guards)))

    @property
    def guarded(self) -> Bools:
        """See `flangeway.contact.pairs.Pairs.guarded`."""
        return np.arange(len(self.keys)) >= len(self.base.keys)

    @property
    def secondary_members(self) -> Ints:
        """See `flangeway.contact.pairs.Pairs.secondary_members`."""
        own = self.base.secondary_members if self.base_terms is None else self.secondary_places[self.base_terms.edges]
        return np.concatenate((own, *(self.secondary_places[guard.edges] for guard in self.guards)))

    @property
    def primary_edges(self) -> Ints:
        """See `flangeway.contact.pairs.Pairs.primary_edges`."""
        return np.concatenate((self.base.primary_edges, *(guard.partners for guard in self.guards)))

    @property
    def rows(self) -> Ints:
        """See `flangeway.contact.pairs.Pairs.rows`."""
        mine = np.arange(len(self.base.keys), len(self.keys))[:, None]
        return np.concatenate((self.base.rows, np.repeat(mine, self.base.rows.shape[1], axis=1)))

    @property
    def gradients(self) -> Floats:
        """See `flangeway.contact.pairs.Pairs.gradients`."""
        base = self.base.gradients if self.base_terms is None else self.base_terms.gradients(self._width)[:, None]
        parts = [base]
        for guard in self.guards:
            mine = np.zeros((len(guard.edges), *base.shape[1:]))
            mine[:, 0] = guard.gradients(self._width)
            parts.append(mine)
        return np.concatenate(parts)

    def curvatures(self, forces: Floats) -> tuple[Ints, Floats]:
        """See `flangeway.contact.pairs.Pairs.curvatures`."""
        width, first, row = self._width, len(self.base.rows), len(self.base.keys)
        if self.base_terms is None:
            terms, values = self.base.curvatures(forces[:row])
            found, sums = [terms], [values]
        else:
            terms = np.flatnonzero(forces[:row])
            found, sums = [terms], [forces[terms, None, None] * self.base_terms.hessians(width, terms)]
        for guard in self.guards:
            mine = forces[row : row + len(guard.edges)]
            chosen = np.flatnonzero(mine)
            found.append(first + chosen)
            sums.append(mine[chosen, None, None] * guard.hessians(width, chosen))
            first, row = first + len(mine), row + len(mine)
        return np.concatenate(found), np.concatenate(sums)

    def opposite_points(self, edges: Floats) -> Floats:
        """See `flangeway.contact.pairs.Pairs.opposite_points`."""
        onto, of = self.guards
        shapes = shape_functions(edges.shape[1] - 1, onto.kinematics.parameters, 0)[0]
        on_edges = np.einsum("na,nai->ni", shapes, edges[onto.partners])
        at_nodes = edges[of.partners, of.slots[:, 0] - self.secondary_places.shape[1]]
        return np.concatenate((self.base.opposite_points(edges), on_edges, at_nodes))

    @property
    def _width(self) -> int:
        return self.secondary_places.shape[1] + self.n_primary_nodes


def guarded(
    base: Pairs,
    surfaces: tuple[Surface, Surface],
    positions: tuple[Floats, Floats],
    armed: tuple[Bools, Bools],
    before: Pairs | None,
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
    armed
        Which of their nodes are guarded, each (n_nodes,).
    before
        What was found in the iteration before.
    settle
        See `NodeToSegment.pair`.

    """
    secondary, primary = surfaces
    n_nodes, n_edges = len(secondary.nodes), len(primary.edges)
    n_keys = len(secondary.hats.nodes) + n_nodes
    places = secondary.contact_places, primary.contact_places
    width, other_width = places[0].shape[1], places[1].shape[1]
    edges = positions[0][places[0]], positions[1][places[1]]
    kept = _kept(before, (n_nodes, len(primary.nodes)))
    base_terms, taken = None, np.full(n_nodes, -1)
    if isinstance(base, NodePairs):
        owners, columns = _owners(places[0], base.nodes)
        slots = _slots(columns, width + np.arange(other_width))
        base_terms = _NodeTerms(base.nodes, base.kinematics, owners, base.primary_edges, slots)
        taken[base.nodes] = base.primary_edges
    nodes, faced, gaps = _paired(positions[0], places[0], edges[1], armed[0], kept[0], settle=settle)
    new = faced != taken[nodes]
    nodes, faced, gaps = nodes[new], faced[new], gaps.take(new)
    owners, columns = _owners(places[0], nodes)
    onto = _NodeTerms(nodes, gaps, owners, faced, _slots(columns, width + np.arange(other_width)))
    others, facing, gaps = _paired(positions[1], places[1], edges[0], armed[1], kept[1], settle=settle)
    owners, columns = _owners(places[1], others)
    of = _NodeTerms(others, gaps, facing, owners, _slots(width + columns, np.arange(width)))
    nearest = (gaps.parameters > 0.5).astype(np.int64) * (width - 1)
    rule = NodeToSegment()
    areas = np.concatenate((rule.node_areas(secondary)[nodes], rule.node_areas(primary)[others]))
    first_other = n_keys + n_nodes * n_edges
    return GuardedPairs(
        base,
        base_terms,
        (onto, of),
        np.concatenate((base.keys, n_keys + nodes * n_edges + faced, first_other + others * len(edges[0]) + facing)),
        np.concatenate((base.partners, faced, n_edges + facing)),
        np.concatenate((base.nodes, nodes, places[0][facing, nearest])),
        np.concatenate((base.areas, areas)),
        np.concatenate((base.whole_areas, areas)),
        places[0],
        other_width,
    )


def n_keys(secondary: Surface, primary: Surface) -> int:
    """Number of keys that the constraints of two surfaces, guarded nodes included, can have."""
    crossed = len(secondary.nodes) * len(primary.edges) + len(primary.nodes) * len(secondary.edges)
    return len(secondary.hats.nodes) + len(secondary.nodes) + crossed


def _kept(before: Pairs | None, counts: tuple[int, int]) -> tuple[Ints, Ints]:
    """Edge that each node of either side was guarded against first; -1 for none."""
    one, other = (np.full(count, -1, dtype=np.int64) for count in counts)
    if isinstance(before, GuardedPairs):
        onto, of = before.guards
        one[onto.nodes[::-1]] = onto.partners[::-1]
        other[of.nodes[::-1]] = of.edges[::-1]
    return one, other


def _slots(nodes: Ints, edge: Ints) -> Ints:
    return np.column_stack((nodes, np.broadcast_to(edge, (len(nodes), len(edge)))))


def _owners(edge_places: Ints, nodes: Ints) -> tuple[Ints, Ints]:
    """An edge that has each node, and the node's place in it."""
    edges, columns = np.zeros((2, edge_places.max() + 1), dtype=np.int64)
    for column in range(edge_places.shape[1]):
        edges[edge_places[:, column]] = np.arange(len(edge_places))
        columns[edge_places[:, column]] = column
    return edges[nodes], columns[nodes]


def _paired(
    positions: Floats, edge_places: Ints, edges: Floats, armed: Bools, kept: Ints, *, settle: bool
) -> tuple[Ints, Ints, NodeEdgeGaps]:
    """Guarded nodes that face an edge of the other side, those edges, and the gaps.

    At a hollow joint the other body's outside is what is outside of both edges: a node has a constraint against each.
    """
    given = positions, edge_places, edges, np.flatnonzero(armed), directions(positions, edge_places), kept
    nodes, partners, gaps = facing_pairs(*given, OVERHANG if settle else SLACK, SLACK)
    found, margins = [(nodes, partners)], margins_of(edges, SLACK)
    for end, step in ((1, 1), (0, -1)):
        hollow = margins[partners, end] == HOLLOW
        both, beside = nodes[hollow], (partners[hollow] + step) % len(edges)
        # a node that is off this joint on one edge is in front of the other one
        near = np.abs(gaps.parameters[hollow] - 0.5) > 0.5
        near |= np.abs(closest_parameters(positions[both], edges[beside]) - 0.5) < 0.5 + SLACK
        found.append((both[near], beside[near]))
    nodes, partners = (np.concatenate(each) for each in zip(*found, strict=True))
    return nodes, partners, node_edge_gaps(positions[nodes], edges[partners])


def directions(positions: Floats, edge_places: Ints) -> Floats:
    """Outward directions at the nodes of a chain that bisect its corners, shape (n_nodes, 2)."""
    chords = positions[edge_places[:, -1]] - positions[edge_places[:, 0]]
    normals = np.stack((chords[:, 1], -chords[:, 0]), axis=1) / np.linalg.norm(chords, axis=1)[:, None]
    result = np.zeros_like(positions)
    for column in edge_places.T:
        np.add.at(result, column, normals)
    return result


def penetrating(
    surfaces: tuple[Surface, Surface],
    positions: tuple[Floats, Floats],
    armed: tuple[Bools, Bools],
    explained: float,
) -> tuple[Bools, Bools]:
    """Further nodes of two surfaces that lie behind the other one by more than curves and the law of contact explain.

    Where sharp edges are among them, they alone: they say where the other body is to be pushed, which may free the
    others.

    Parameters
    ----------
    surfaces
        Secondary and primary surface.
    positions
        Current positions of the points of their `Surface.contact_places`, each (n, 2).
    armed
        Which of their nodes are guarded already, each (n_nodes,).
    explained
        Penetration that the law of contact explains.

    Returns
    -------
    tuple of Bools
        For the nodes of either surface, each (n,).

    """
    edges = [at[surface.contact_places] for surface, at in zip(surfaces, positions, strict=True)]
    depth = min(float(np.linalg.norm(np.ptp(each, axis=(0, 1)))) for each in edges) / 2.0
    counts = [len(surface.nodes) for surface in surfaces]
    found = [np.zeros(count, dtype=np.bool_) for count in counts]
    near = [_in_box(at[:n], other, depth) for at, n, other in zip(positions, counts, edges[::-1], strict=True)]
    if not (near[0].any() or near[1].any()):
        return found[0], found[1]
    sagittas = [surface.sagittas(each) for surface, each in zip(surfaces, edges, strict=True)]
    for side, other in ((0, 1), (1, 0)):
        at, places, none = positions[side], surfaces[side].edge_places, np.full(counts[side], -1)
        given = at, places, edges[other], np.flatnonzero(near[side]), directions(at, places), none
        nodes, partners, gaps = facing_pairs(*given, SLACK, SLACK)
        own = np.full(counts[side], np.inf)
        for column in places.T:
            np.minimum.at(own, column, sagittas[side])
        allowed = EARLY * (own[nodes] + sagittas[other][partners]) + explained
        found[side][nodes[(gaps.gaps < -allowed) & (gaps.gaps > -depth)]] = True
    found = [each & ~before for each, before in zip(found, armed, strict=True)]
    sharp = found[0] & _sharp(positions[0], surfaces[0]), found[1] & _sharp(positions[1], surfaces[1])
    return sharp if sharp[0].any() or sharp[1].any() else (found[0], found[1])


def _sharp(positions: Floats, surface: Surface) -> Bools:
    """Which nodes of a surface are at sharp edges of its body, shape (n,)."""
    ends = surface.edge_places[:, [0, -1]]
    turns = turns_of(positions[ends], np.roll(np.arange(len(ends)), -1))
    meets = ends[:, 1] == np.roll(ends[:, 0], -1)
    result = np.zeros(len(surface.nodes), dtype=np.bool_)
    result[ends[meets & (turns > SHARP), 1]] = True
    return result


def _in_box(points: Floats, edges: Floats, margin: float) -> Bools:
    """Whether points lie in the box round edges, or within a margin of it."""
    low, high = edges.min(axis=(0, 1)) - margin, edges.max(axis=(0, 1)) + margin
    inside: Bools = ((points >= low) & (points <= high)).all(axis=1)
    return inside


def corners_on_corners(surfaces: tuple[Surface, Surface], positions: tuple[Floats, Floats]) -> Floats:
    """Places at which sharp corners of two surfaces are in each other so that either side may bear, shape (n, 2).

    Parameters
    ----------
    surfaces
        Secondary and primary surface.
    positions
        Of their nodes before the deformation, each (n, 2).

    """
    found = []
    for side, other in ((0, 1), (1, 0)):
        places = surfaces[other].edge_places[:, [0, -1]]
        joints = np.flatnonzero(_sharp(positions[other], surfaces[other])[places[:, 1]])
        own = np.flatnonzero(_sharp(positions[side], surfaces[side]))
        if len(own) == 0 or len(joints) == 0:
            continue
        pair = own.repeat(len(joints)), np.tile(joints, len(own))
        edges = positions[other][places]
        into, out = edges[pair[1]], edges[(pair[1] + 1) % len(edges)]
        depths = -np.stack([node_edge_gaps(positions[side][pair[0]], each).gaps for each in (into, out)])
        lengths = np.minimum(*(np.linalg.norm(each[:, 1] - each[:, 0], axis=1) for each in (into, out)))
        alike = np.abs(depths[0] - depths[1]) <= ALIKE * depths.max(axis=0)
        alike &= (depths.min(axis=0) > 0.0) & (depths.max(axis=0) < lengths)
        found.append(positions[side][pair[0][alike]])
    return np.concatenate(found) if found else np.empty((0, 2))
