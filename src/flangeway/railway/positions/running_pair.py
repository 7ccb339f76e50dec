"""A wheel over a rail: running surfaces, flexibilities, gaps and overlap of many positions at once.

A slot of the batch holds one position of the wheelset. All is in the right-hand form and in the frame of the rail; a
side of the track is the same pair with its position mirrored. The slot is the first axis of arrays.
"""

import math
from dataclasses import dataclass
from typing import Self

import numpy as np
from scipy.spatial import cKDTree

from flangeway.contact import Contact, ContactSystem, Multiplier, Penalty, SegmentToSegment, Surface
from flangeway.contact.edge_pieces import Pieces, find_pieces, integrate
from flangeway.contact.segment_to_segment import DUAL, LEAST_COVERED
from flangeway.contact.surface import Hats, node_normals
from flangeway.errors import InputError
from flangeway.problems import Part
from flangeway.solve import CondensedBodies
from flangeway.types import Bools, Floats, Ints

ALLOWED_MM = 0.05
"""Overlap that curves between nodes and the stiff displacement of what is beside the running surfaces may show."""


@dataclass(frozen=True, eq=False)
class BoundaryNodes:
    """Corners of a body's whole boundary; what is beside the running surface moves with the nearer end of it.

    - `previous`, `following`: neighbours along the boundary, the body on the left, each (n,).
    - `moves_with`: node of the running surface that each of them is or moves with, shape (n,).
    - `offsets`: vectors from that node, shape (n, 2).
    """

    previous: Ints
    following: Ints
    moves_with: Ints
    offsets: Floats

    @classmethod
    def of(cls, surface: Surface) -> Self:
        """Boundary of the body of a running surface."""
        mesh = surface.part.body.space.mesh
        edges = mesh.boundary_edges.astype(np.int64)
        nodes, ends = np.unique(edges, return_inverse=True)
        first, second = ends.reshape(-1, 2).T
        previous, following = np.zeros((2, len(nodes)), dtype=np.int64)
        following[first], previous[second] = second, first
        points, running = mesh.points[nodes], surface.part.body.space.nodes[surface.nodes]
        to_ends = np.linalg.norm(points[:, None] - running[[0, -1]], axis=2)
        moves_with = np.where(to_ends[:, 0] < to_ends[:, 1], 0, len(running) - 1)
        place = {int(node): number for number, node in enumerate(surface.nodes)}
        moves_with = np.array([place.get(int(node), end) for node, end in zip(nodes, moves_with, strict=True)])
        return cls(previous, following, moves_with, points - running[moves_with])

    def positions(self, running: Floats, turn: Floats) -> Floats:
        """Positions (n, 2) by those of the running surface's nodes, and the matrix (2, 2) from the body's frame."""
        return running[self.moves_with] + self.offsets @ turn.T


def overlap_depth(one: BoundaryNodes, on_one: Floats, other: BoundaryNodes, on_other: Floats) -> float:
    """Maximum depth of a body's corners in another body and the reverse, at positions of their corners, each (n, 2)."""
    return max(_depth(on_one, other, on_other), _depth(on_other, one, on_one))


def _depth(points: Floats, other: BoundaryNodes, corners: Floats) -> float:
    """Maximum depth of points (m, 2) in a body whose corners are at positions (n, 2); zero outside of it."""
    points = points[((points > corners.min(axis=0)) & (points < corners.max(axis=0))).all(axis=1)]
    if len(points) == 0:
        return 0.0
    _, nearest = cKDTree(corners).query(points)
    before, corner, after = (
        corners[each[nearest]] for each in (other.previous, np.arange(len(corners)), other.following)
    )
    left = [_cross(end - start, points - start) > 0.0 for start, end in ((before, corner), (corner, after))]
    inside = np.where(_cross(corner - before, after - corner) > 0.0, left[0] & left[1], left[0] | left[1])
    distances = np.minimum(_distances(points, before, corner), _distances(points, corner, after))
    return float(distances[inside].max(initial=0.0))


def _cross(one: Floats, other: Floats) -> Floats:
    product: Floats = one[:, 0] * other[:, 1] - one[:, 1] * other[:, 0]
    return product


def _distances(points: Floats, starts: Floats, ends: Floats) -> Floats:
    """Distances of points from segments, one each, shape (m,)."""
    along = ends - starts
    share = np.clip(((points - starts) * along).sum(axis=1) / (along**2).sum(axis=1), 0.0, 1.0)
    distances: Floats = np.linalg.norm(points - starts - share[:, None] * along, axis=1)
    return distances


SEEN_MM = 3.0  # distance beyond which a wheel's node faces no node of the rail
FACING = -0.3  # cosine between outward normals above which two nodes do not face each other
BESIDE_MM = 0.2  # length of the rail beside what faces a wheel's edge that is compared with it as well


@dataclass(frozen=True, eq=False)
class Chain:
    """Running surface of one body in its frame, nodes one after the other with the body on the left.

    - `points`: places of the nodes on the drawn surface, shape (n, 2).
    - `mesh_points`: their places in the mesh, shape (n, 2).
    - `edges`: places of the edges' nodes, shape (n_edges, order + 1).
    - `flexibility`: displacements by forces, shape (2 n, 2 n).
    - `places`: places of the nodes among the body's surface nodes, shape (n,).
    """

    points: Floats
    mesh_points: Floats
    edges: Ints
    flexibility: Floats
    places: Ints

    @property
    def ends(self) -> Ints:
        """Nodes at the edges' ends, one more than edges."""
        return np.append(self.edges[:, 0], self.edges[-1, -1])

    def displacements(self, forces: Floats) -> Floats:
        """Displacements (L, n, 2) under forces (L, n, 2), both in the body's frame."""
        flat = forces.reshape(len(forces), -1)
        loaded = np.flatnonzero(flat.any(axis=0))
        if len(loaded) == 0:
            return np.zeros_like(forces)
        result: Floats = (flat[:, loaded] @ self.flexibility[loaded]).reshape(forces.shape)
        return result

    def in_own_order(self, forces: Floats) -> Floats:
        """Forces (n, 2) along the chain in the order of the body's surface nodes, shape (n, 2)."""
        result = np.empty_like(forces)
        result[self.places] = forces
        return result

    def outward(self) -> Floats:
        """Unit normals at the edges' ends, shape (n_edges + 1, 2)."""
        normals = node_normals(self.points, self.edges)[self.ends]
        return normals / np.linalg.norm(normals, axis=1)[:, None]


@dataclass(frozen=True, eq=False)
class Candidates:
    """Where the contact of slots is evaluated.

    - `window`: hat functions whose constraints are evaluated, shape (L, n_hats).
    - `edges`, `partners`: edges of the secondary and of the primary that may face each other, numbered through all
      slots.
    """

    window: Bools
    edges: Ints
    partners: Ints


@dataclass(frozen=True, eq=False)
class Gaps:
    """Gaps of slots about some positions.

    - `gaps`, `areas`: of all hat functions, zero outside of windows, shape (L, n_hats); areas are length times
      thickness.
    - `pieces`: pieces of the secondary, edges numbered through all slots.
    - `rows`: constraints of each piece, numbered through all slots, shape (p, 2).
    - `nodes`: nodes of each piece's wheel's edge and rail's edge, numbered through all slots, each (p, order + 1).
    - `on_wheel`, `on_rail`: derivatives of the gaps of its constraints by their positions, each (p, 2, order + 1, 2).
    - `shapes`: see `PieceIntegrals.primary_shapes`.
    - `covered`: see `PieceIntegrals.lengths`.
    """

    gaps: Floats
    areas: Floats
    pieces: Pieces
    rows: Ints
    nodes: tuple[Ints, Ints]
    on_wheel: Floats
    on_rail: Floats
    shapes: Floats
    covered: Floats


@dataclass(frozen=True, eq=False)
class RunningPair:
    """A wheel and the rail under it.

    - `wheel`, `rail`: their surfaces.
    - `wheel_is_secondary`: whether the wheel carries the hat functions.
    - `hats`, `edge_lengths`: hat functions and undeformed lengths of the secondary's edges.
    - `thickness`: length along the track.
    - `compliance`: penetration per pressure.
    - `dual`: whether gaps are weighted with biorthogonal functions.
    - `reach`, `depth`: see `SegmentToSegment`.
    - `rail_edge`: mean length of the rail's edges.
    - `boundaries`: whole boundaries of wheel and rail.
    """

    wheel: Chain
    rail: Chain
    wheel_is_secondary: bool
    hats: Hats
    edge_lengths: Floats
    thickness: float
    compliance: float
    dual: bool
    reach: float
    depth: float
    rail_edge: float
    boundaries: tuple[BoundaryNodes, BoundaryNodes]
    _tree: cKDTree
    _normals: tuple[Floats, Floats]

    @classmethod
    def of(cls, system: ContactSystem, contact: Contact, response: CondensedBodies) -> "RunningPair":
        """Pair of one contact. An `InputError` if it is not segment-to-segment with a penalty or multipliers."""
        law, pairing = contact.enforcement, contact.pairing
        if not (isinstance(pairing, SegmentToSegment) and isinstance(law, Penalty | Multiplier)):
            raise InputError(
                f"many positions with {type(pairing).__name__} and {type(law).__name__}",
                "segment-to-segment contact with a penalty or multipliers",
                "set pairing = segment-to-segment and enforcement = penalty, or solve position after position",
            )
        given = (contact.secondary, contact.primary)
        # in the right-hand form, whichever side it is of
        surfaces = [
            Surface(Part(each.part.name, each.part.body), each.edges, each.curve, each.nodes_only) for each in given
        ]
        chains = [
            _chain(surface, response.flexibility(system.parts.index(each.part)), system)
            for surface, each in zip(surfaces, given, strict=True)
        ]
        wheel_first = contact.secondary.part.name.startswith("wheel")
        wheel, rail = chains if wheel_first else chains[::-1]
        boundaries = [BoundaryNodes.of(each) for each in (surfaces if wheel_first else surfaces[::-1])]
        extents = [float(np.linalg.norm(np.ptp(chain.points, axis=0))) for chain in chains]
        chords = np.linalg.norm(np.diff(chains[1].points[chains[1].ends], axis=0), axis=1)
        return cls(
            wheel,
            rail,
            wheel_first,
            surfaces[0].hats,
            surfaces[0].edge_lengths,
            contact.secondary.part.body.thickness,
            1.0 / float(law.value or np.inf) if isinstance(law, Penalty) else 0.0,
            pairing.weighting == "dual",
            pairing.reach or 2.0 * float(chords.mean()),
            pairing.depth or min(extents) / 2.0,
            float(np.linalg.norm(np.diff(rail.points[rail.ends], axis=0), axis=1).mean()),
            (boundaries[0], boundaries[1]),
            cKDTree(rail.points[rail.ends]),
            (wheel.outward(), rail.outward()),
        )

    @property
    def secondary(self) -> Chain:
        """The surface that carries the hat functions."""
        return self.wheel if self.wheel_is_secondary else self.rail

    @property
    def primary(self) -> Chain:
        """The other one."""
        return self.rail if self.wheel_is_secondary else self.wheel

    def search(self, wheel: Floats, rail: Floats, turns: Floats, lowered: Floats, margin: Floats | float) -> Candidates:
        """Look for hat functions whose gap is below a margin, and for the edges that make their gaps.

        - `wheel`, `rail`: positions of the nodes in the rail's frame, shape (L, n, 2).
        - `turns`: matrices from the wheel's frame into the rail's, shape (L, 2, 2).
        - `lowered`: about how far the rail's head has moved, shape (L, 2).
        - `margin`: maximum gap, one for all or shape (L,).
        """
        wheel_ends, rail_ends = self.wheel.ends, self.rail.ends
        points = wheel[:, wheel_ends]
        n_positions, n_ends = points.shape[:2]
        distances, facing = self._tree.query((points - lowered[:, None]).reshape(-1, 2), distance_upper_bound=SEEN_MM)
        found = np.isfinite(distances).reshape(n_positions, n_ends)
        facing = np.minimum(facing, len(rail_ends) - 1).reshape(n_positions, n_ends)
        normals = self._normals[1][facing]
        found &= np.einsum("lki,lij,kj->lk", normals, turns, self._normals[0]) < FACING
        there = np.take_along_axis(rail[:, rail_ends], facing[:, :, None], axis=1)
        apart = points - there
        across = apart[..., 0] * normals[..., 0] + apart[..., 1] * normals[..., 1]
        near = found & (across < np.reshape(margin, (-1, 1)))
        slots, edges, partners = self._edges_between(near, found, facing)
        window = np.zeros((n_positions, len(self.hats.nodes)), dtype=np.bool_)
        if self.wheel_is_secondary:
            window[:] = self._at_hats(near)
            secondary, primary = edges, partners
        else:
            near_rail = np.zeros((n_positions, len(rail_ends)), dtype=np.bool_)
            slot, end = np.nonzero(near)
            near_rail[slot, facing[slot, end]] = True
            near_rail = _widened(near_rail, 1)
            window[:] = self._at_hats(near_rail)
            secondary, primary = partners, edges
        return Candidates(
            window, slots * len(self.secondary.edges) + secondary, slots * len(self.primary.edges) + primary
        )

    def _at_hats(self, ends: Bools) -> Bools:
        """Hat functions of the secondary's ends, shape (L, n_hats)."""
        place = np.full(len(self.secondary.points), -1, dtype=np.int64)
        place[self.secondary.ends] = np.arange(ends.shape[1])
        chosen: Bools = ends[:, place[self.hats.nodes]]
        return chosen

    def _edges_between(self, near: Bools, found: Bools, facing: Ints) -> tuple[Ints, Ints, Ints]:
        """Slots, wheel's edges and rail's edges of all pairs that may make a gap."""
        wide = _widened(near, 1 if self.wheel_is_secondary else 4)
        start, end = found[:, :-1], found[:, 1:]
        slots, edges = np.nonzero((wide[:, :-1] | wide[:, 1:]) & (start | end))
        first = np.where(start, facing[:, :-1], facing[:, 1:])[slots, edges]
        last = np.where(end, facing[:, 1:], facing[:, :-1])[slots, edges]
        beside = math.ceil(BESIDE_MM / self.rail_edge)
        low = np.maximum(np.minimum(first, last) - 1 - beside, 0)
        high = np.minimum(np.maximum(first, last) + beside, len(self.rail.edges) - 1)
        counts = high - low + 1
        starts = np.cumsum(counts) - counts
        partners = np.arange(counts.sum()) - np.repeat(starts - low, counts)
        return np.repeat(slots, counts), np.repeat(edges, counts), partners

    def gaps(self, wheel: Floats, rail: Floats, candidates: Candidates) -> Gaps:
        """Gaps and their derivatives at positions (L, n, 2) in the rail's frame."""
        chains = (self.secondary, self.primary)
        positions = (wheel, rail) if self.wheel_is_secondary else (rail, wheel)
        sides = [
            nodes[:, chain.edges].reshape(-1, chain.edges.shape[1], 2)
            for nodes, chain in zip(positions, chains, strict=True)
        ]
        pieces = find_pieces(sides[0], sides[1], (candidates.edges, candidates.partners), self.reach, self.depth)
        slots, edges = np.divmod(pieces.edges, len(self.secondary.edges))
        lengths = self.edge_lengths[edges]
        found = integrate(pieces, sides[0][pieces.edges], sides[1][pieces.partners], lengths, second=False)
        n_hats = len(self.hats.nodes)
        rows = slots[:, None] * n_hats + self.hats.of_edge[edges]
        n_rows = len(wheel) * n_hats
        covered = np.bincount(rows.ravel(), found.lengths.ravel(), minlength=n_rows)
        thickness = self.thickness
        least = LEAST_COVERED * np.tile(self.hats.areas, len(wheel))
        evaluated = candidates.window.ravel() & (covered * thickness > least)
        inverse = np.where(evaluated, 1.0 / np.where(evaluated, covered, 1.0), 0.0)
        weights = inverse[rows]
        values = found.gaps
        gradients = found.gradients
        if self.dual:
            values, gradients = self._dual(pieces, edges, found.lengths, values, gradients)
        gaps = np.bincount(rows.ravel(), (weights * values).ravel(), minlength=n_rows)
        gradients = (gradients * weights[:, :, None]).reshape(len(rows), 2, gradients.shape[2] // 2, 2)
        width = chains[0].edges.shape[1]
        parts = gradients[:, :, :width], gradients[:, :, width:]
        nodes = (
            slots[:, None] * len(chains[0].points) + chains[0].edges[edges],
            slots[:, None] * len(chains[1].points) + chains[1].edges[pieces.partners % len(chains[1].edges)],
        )
        if not self.wheel_is_secondary:
            nodes, parts = nodes[::-1], parts[::-1]
        areas = np.where(evaluated, covered * thickness, 0.0)
        shape = (len(wheel), n_hats)
        return Gaps(
            gaps.reshape(shape).astype(np.float64, copy=False), areas.reshape(shape), pieces, rows,
            nodes, parts[0], parts[1], found.primary_shapes, found.lengths,
        )  # fmt: skip

    def _dual(
        self, pieces: Pieces, edges: Ints, lengths: Floats, values: Floats, gradients: Floats
    ) -> tuple[Floats, Floats]:
        """Integrals with the biorthogonal functions on edges that are covered as a whole."""
        covered = np.bincount(pieces.edges, lengths.sum(axis=1))
        whole = covered[pieces.edges] > (1.0 - LEAST_COVERED) * self.edge_lengths[edges]
        functions = np.where(whole[:, None, None], DUAL, np.eye(2))
        return np.einsum("prs,ps->pr", functions, values), np.einsum("prs,psd->prd", functions, gradients)


def _chain(surface: Surface, flexibility: Floats, system: ContactSystem) -> Chain:
    """Chain of a surface in the right-hand form, from the flexibility of its body's surface nodes."""
    given = next(each for each in system.surface_nodes if each.body is surface.part.body)
    if len(given.nodes) != len(surface.nodes) or surface.edge_places[-1, -1] == 0:
        raise InputError(
            f"many positions with a surface of {surface.part.name!r} that is closed, or one of several of its body",
            "one open surface for each wheel and rail",
            "solve position after position",
        )
    places = np.searchsorted(given.nodes, surface.nodes)
    dofs = (2 * places[:, None] + np.arange(2)).ravel()
    mesh_points = surface.part.body.space.nodes[surface.nodes]
    return Chain(given.points[places], mesh_points, surface.edge_places, flexibility[np.ix_(dofs, dofs)], places)


def _widened(chosen: Bools, n: int) -> Bools:
    """Neighbours of what is chosen along the last axis, n on each side, are chosen as well."""
    result = chosen.copy()
    for step in range(1, n + 1):
        result[:, step:] |= chosen[:, :-step]
        result[:, :-step] |= chosen[:, step:]
    return result
