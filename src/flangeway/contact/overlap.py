"""Overlap of deformed bodies, measured on their whole boundaries."""

import itertools
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Self

import numpy as np

from flangeway.contact.kinematics import shape_functions
from flangeway.contact.search import candidate_pairs
from flangeway.contact.surface import sagittas_of
from flangeway.contact.system import ROUND_OFF, ContactLinearisation, ContactSystem
from flangeway.geometry import crossing_shares
from flangeway.problems import Part
from flangeway.solve import BodyResponse, ContactState
from flangeway.types import Bools, Floats, Ints

SAMPLES = np.linspace(0.0, 1.0, 6)
"""Points of parts of edges inside another body at which the depth is measured."""

ENTRIES_PER_CHUNK = 1_000_000


@dataclass(frozen=True)
class Intrusion:
    """Where one boundary lies within the other one, beyond what is allowed.

    Parameters
    ----------
    depth
        Distance of a point of one boundary from the other, in whose body it lies.
    position
        That point, x and y.
    allowed
        Depth that the chords of curves explain there.

    """

    depth: float
    position: tuple[float, float]
    allowed: float

    @classmethod
    def deepest(cls, points: Floats, depths: Floats, allowed: Floats) -> Self:
        """Of points (n, 2) at depths with what is allowed there, both (n,): the one with the largest excess."""
        deepest = int(np.argmax(depths - allowed))
        x, y = points[deepest].tolist()
        return cls(float(depths[deepest]), (x, y), float(allowed[deepest]))


@dataclass(frozen=True, eq=False)
class Boundary:
    """Edges of a body's boundary as straight segments, and how far a smooth curve may lie from them.

    Parameters
    ----------
    segments
        Ends of the segments, the body on their left, shape (n, 2, 2).
    sagittas
        Distance to which a curve through the edges' ends may leave the segments, shape (n,).

    """

    segments: Floats
    sagittas: Floats

    @classmethod
    def of(cls, drawn: Floats, deformed: Floats, joints: tuple[Ints, Ints]) -> Self:
        """Edges of any order; curved ones become several segments; see `sagittas_of`.

        Parameters
        ----------
        drawn
            Ends of the edges before the deformation, shape (n, 2, 2).
        deformed
            Nodes of the deformed edges, shape (n, order + 1, 2).
        joints
            Points at which the edges start and end, each (n,).

        """
        order = deformed.shape[1] - 1
        sagittas = sagittas_of(drawn, deformed, joints)
        if order == 1:
            return cls(deformed, sagittas)
        parts = 4 * (order // 2 + 1)
        points = np.einsum("ta,nai->nti", shape_functions(order, np.linspace(0.0, 1.0, parts + 1), 0)[0], deformed)
        segments = np.stack((points[:, :-1], points[:, 1:]), axis=2).reshape(-1, 2, 2)
        return cls(segments, np.repeat(sagittas, parts))

    def contains(self, points: Floats) -> Bools:
        """Whether points (m, 2) lie within the closed boundary, by the number of segments to their right."""
        (ax, ay), (bx, by) = self.segments.transpose(1, 2, 0)
        inside = np.zeros(len(points), dtype=np.bool_)
        for here in _chunks(len(points), len(ax)):
            x, y = points[here, :1], points[here, 1:]
            which, side = np.nonzero((ay <= y) != (by <= y))
            share = (y[which, 0] - ay[side]) / (by[side] - ay[side])
            right = ax[side] + share * (bx[side] - ax[side]) > x[which, 0]
            inside[here] = np.bincount(which[right], minlength=len(x)) % 2 == 1
        return inside

    def nearest(self, points: Floats, facing: Floats | None = None) -> tuple[Floats, Ints]:
        """Distances of points (m, 2) from the boundary, and the segments that are nearest, each (m,).

        With ``facing`` (m, 2) only segments that run against these directions count.
        """
        starts = self.segments[:, 0]
        chords = self.segments[:, 1] - starts
        squares = (chords**2).sum(axis=1)
        distances, numbers = np.empty(len(points)), np.empty(len(points), dtype=np.int64)
        for here in _chunks(len(points), len(starts)):
            x, y = (points[here, axis, None] - starts[:, axis] for axis in range(2))
            share = np.clip((x * chords[:, 0] + y * chords[:, 1]) / squares, 0.0, 1.0)
            apart = (x - share * chords[:, 0]) ** 2 + (y - share * chords[:, 1]) ** 2
            if facing is not None:
                apart[facing[here] @ chords.T >= 0.0] = np.inf
            numbers[here] = apart.argmin(axis=1)
            distances[here] = np.sqrt(apart.min(axis=1))
        return distances, numbers

    def within(self, other: "Boundary") -> Intrusion | None:
        """Return the point of this boundary that lies in the other's body deepest beyond what curves explain."""
        near = np.flatnonzero(_boxes_meet(self.segments, other.segments))
        starts = self.segments[near, 0]
        ends = self.segments[near, 1]
        chosen = other.contains(starts) | other.contains(ends)
        of, crossings = _crossings(self.segments[near], other.segments)
        chosen[of] = True
        every = np.flatnonzero(chosen)
        if len(every) == 0:
            return None
        owners = np.concatenate((every, every, of))
        shares = np.concatenate((np.zeros(len(every)), np.ones(len(every)), crossings))
        order = np.lexsort((shares, owners))
        owners, shares = owners[order], shares[order]
        same = np.flatnonzero(owners[1:] == owners[:-1])
        along = shares[same, None] + (shares[same + 1] - shares[same])[:, None] * SAMPLES
        owner = np.repeat(owners[same], len(SAMPLES))
        along = along.ravel()
        points = starts[owner] + along[:, None] * (ends - starts)[owner]
        inside = other.contains(points)
        points, owner = points[inside], near[owner[inside]]
        if len(points) == 0:
            return None
        depths, nearest = other.nearest(points)
        allowed = self.sagittas[owner] + other.sagittas[nearest]
        return Intrusion.deepest(points, depths, allowed)

    def within_itself(self, apart: float) -> Intrusion | None:
        """Return the point of this boundary that lies in the body's own other side, seen from ``apart`` outside of it.

        The body is where the boundary winds round once: a point outside of it that is inside lies in an overlap.
        """
        starts, chords = self.segments[:, 0], self.segments[:, 1] - self.segments[:, 0]
        outward = np.stack((chords[:, 1], -chords[:, 0]), axis=1) / np.hypot(*chords.T)[:, None]
        along = starts[:, None] + SAMPLES[1:-1, None] * chords[:, None] + apart * outward[:, None]
        points, owner = along.reshape(-1, 2), np.repeat(np.arange(len(starts)), len(SAMPLES) - 2)
        inside = self.contains(points)
        if not inside.any():
            return None
        points, owner = points[inside], owner[inside]
        depths, nearest = self.nearest(points, chords[owner])
        allowed = self.sagittas[owner] + self.sagittas[nearest]
        return Intrusion.deepest(points, depths, allowed)


def deepest_intrusion(one: Boundary, other: Boundary) -> Intrusion | None:
    """Where two bodies overlap most, beyond what the chords of curves explain; None where nothing lies in the other."""
    found = [each for each in (one.within(other), other.within(one)) if each is not None]
    return max(found, key=lambda each: each.depth - each.allowed, default=None)


def _boxes_meet(segments: Floats, others: Floats) -> Bools:
    """Whether the bounding boxes of segments meet the box round all the others."""
    low, high = others.min(axis=(0, 1)), others.max(axis=(0, 1))
    meets: Bools = ((segments.max(axis=1) >= low) & (segments.min(axis=1) <= high)).all(axis=1)
    return meets


def _crossings(segments: Floats, others: Floats) -> tuple[Ints, Floats]:
    """Segments that cross others, and the shares of their lengths at which they do, each (c,)."""
    if len(segments) == 0:
        return np.empty(0, dtype=np.int64), np.empty(0)
    i, j = candidate_pairs(segments, others, 0.0)
    along, other = segments[i, 1] - segments[i, 0], others[j, 1] - others[j, 0]
    s, t = crossing_shares(segments[i, 0], along, others[j, 0], other)
    cross = (s > 0.0) & (s < 1.0) & (t >= 0.0) & (t <= 1.0)
    return i[cross], s[cross]


def _chunks(n: int, width: int) -> list[slice]:
    size = max(1, ENTRIES_PER_CHUNK // max(width, 1))
    return [slice(first, first + size) for first in range(0, n, size)]


@dataclass(frozen=True)
class BodyOverlap:
    """How deep two parts overlap, or one overlaps itself.

    Parameters
    ----------
    parts
        Names of the two, or twice that of the one.
    depth
        Distance of a point of one body's boundary from that of the other, in which it lies.
    position
        That point, x and y.
    allowed
        Depth that is explained there: by the penetration of the contact law, by the chords of curves (h^2 / 8 R on each
        side, see `Boundary`), by a thousandth of the surfaces' maximum displacement, and by round-off.

    """

    parts: tuple[str, str]
    depth: float
    position: tuple[float, float]
    allowed: float

    @property
    def is_explained(self) -> bool:
        """Whether the depth is within what is allowed."""
        return self.depth <= self.allowed

    def __str__(self) -> str:
        """Return a sentence."""
        x, y = self.position
        one, other = self.parts
        who = f"{one} overlaps itself" if one == other else f"{one} and {other} overlap"
        return (
            f"{who} by {self.depth:.3g} at ({x:.4g}, {y:.4g}), where contact and "
            f"the chords of curves explain {self.allowed:.1e}; give all edges that may touch, move in smaller steps, "
            "or take a finer mesh there"
        )


def body_overlaps(
    system: ContactSystem, response: BodyResponse, state: ContactState, fields: Sequence[Floats] | None = None
) -> tuple[BodyOverlap, ...]:
    """Deepest overlap of each pair of deformed parts, and of each part in contact with itself.

    The whole boundaries count, whatever edges were given to the contacts.

    Parameters
    ----------
    system, response, state
        The contacts, the bodies, and a solution.
    fields
        Displacements of all nodes of each body in its own frame, if they are known.

    Returns
    -------
    tuple of BodyOverlap
        One for each pair that overlaps, and for each part in contact with itself that does, also where it is explained.
        A boundary that is not closed has no inside: such bodies are left out.

    """
    lin = state.linearisation
    if not isinstance(lin, ContactLinearisation):
        raise TypeError("a state of another system of constraints")
    if fields is None:
        fields = response.fields(response.rotations(state.placements), state.nodal_forces)
    boundaries = []
    for number, (part, field) in enumerate(zip(system.parts, fields, strict=True)):
        first, last = response.offsets[number : number + 2]
        nodes = system.surface_nodes[number].nodes
        points = part.body.nodes
        at = state.placements[number].points(points + field[: len(points)])
        at[nodes] = state.positions[first:last]
        boundaries.append(part_boundary(part, at))
    moved = float(np.abs(state.displacements).max(initial=0.0))
    explained = [system.explained(lin, state.forces, number, moved) for number in range(len(system.contacts))]
    found = []
    sides = [each for each in zip(system.parts, boundaries, strict=True) if each[0].body.boundary_is_closed]
    touched = {id(each.primary.part) for each in system.contacts if each.primary.part is each.secondary.part}
    alone = [(side, side) for side in sides if id(side[0]) in touched]
    for (one, first_side), (other, other_side) in itertools.chain(itertools.combinations(sides, 2), alone):
        law = _between(system, one, other, explained)
        if one is other:
            deepest = first_side.within_itself(ROUND_OFF * one.body.size)
        else:
            deepest = deepest_intrusion(first_side, other_side)
        if deepest is not None:
            allowed = deepest.allowed + law + ROUND_OFF * min(one.body.size, other.body.size)
            found.append(BodyOverlap((one.name, other.name), deepest.depth, deepest.position, allowed))
    return tuple(found)


def part_boundary(part: Part, positions: Floats) -> Boundary:
    """Boundary of a part whose nodes are at positions in space, shape (n_nodes, 2)."""
    edges = part.body.boundary_edges
    nodes = part.body.edge_nodes(edges)
    if part.placement.mirrored:
        edges, nodes = edges[:, ::-1], nodes[:, ::-1]
    drawn = part.placement.points(part.body.nodes)[edges]
    return Boundary.of(drawn, positions[nodes], (edges[:, 0].astype(np.int64), edges[:, 1].astype(np.int64)))


def _between(system: ContactSystem, one: Part, other: Part, explained: Sequence[float]) -> float:
    """Penetration that the laws of contacts between two parts explain."""
    mine = [
        each
        for contact, each in zip(system.contacts, explained, strict=True)
        if {id(contact.secondary.part), id(contact.primary.part)} == {id(one), id(other)}
    ]
    return max(mine, default=0.0)
