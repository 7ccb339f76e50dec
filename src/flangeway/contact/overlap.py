"""Overlap of deformed bodies, measured by Shapely on their whole boundaries."""

import itertools
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from functools import cached_property, reduce

import numpy as np
import shapely

from flangeway.contact.kinematics import shape_functions
from flangeway.contact.newton import ContactState
from flangeway.contact.surface import CORNER, sagittas_of
from flangeway.contact.system import MAX_OVERLAP, ROUND_OFF, ContactSystem
from flangeway.geometry import Placement
from flangeway.geometry.arrays import turned_right
from flangeway.problems import Part
from flangeway.solve import BodyResponse
from flangeway.types import Floats, Ints

SAMPLES = np.linspace(0.0, 1.0, 6)[:, None]
"""Points of a side of an overlap at which its depth is measured, as parts of the side."""

PASSAGE = 1e-6
"""Depth over the size of the smaller body up to which bodies that slide along each other are apart."""

TURNED = 0.05
"""Rotation in rad between two positions of a path that is checked."""


@dataclass(frozen=True)
class Intrusion:
    """Where two boundaries overlap most, beyond what is allowed.

    Parameters
    ----------
    depth
        Distance of a point of one boundary from the other, in whose body it lies.
    position
        That point, x and y.
    allowed
        Sagitta of the drawn curves there, whose chords are the edges.

    """

    depth: float
    position: tuple[float, float]
    allowed: float


@dataclass(frozen=True, eq=False)
class Boundary:
    """Edges of a body's boundary as straight segments, and how far the drawn curve lies from them.

    Parameters
    ----------
    segments
        Ends of the segments, the body on their left, shape (n, 2, 2).
    sagittas
        Distance of a drawn curve through the edges' ends from the segments, shape (n,).

    """

    segments: Floats
    sagittas: Floats

    @classmethod
    def of_part(cls, part: Part, positions: Floats, chord_turn: float = CORNER) -> "Boundary":
        """Boundary of a part whose nodes are at positions in space (n_nodes, 2); curved edges become 8 segments."""
        edges = part.body.boundary_edges
        nodes = part.body.edge_nodes(edges)
        if part.placement.mirrored:
            edges, nodes = edges[:, ::-1], nodes[:, ::-1]
        drawn, deformed = part.placement.points(part.body.nodes)[edges], positions[nodes]
        order, joints = nodes.shape[1] - 1, (edges[:, 0].astype(np.int64), edges[:, 1].astype(np.int64))
        sagittas = sagittas_of(
            drawn, drawn, joints, 0.0, chord_turn
        )  # what bodies bend is no curve: straight edges have 0
        at_ends = np.zeros(len(part.body.nodes))
        np.maximum.at(at_ends, edges, sagittas[:, None])
        # half a chord beside a corner, as on dual polygons, has no turn that shows the curve: its neighbour has
        sagittas = at_ends[edges].max(axis=1)
        if order == 1:
            return cls(deformed, sagittas)
        parts = 4 * (order // 2 + 1)
        # points_eti = sum_a N_a(t) x_eai
        points = np.einsum("ta,eai->eti", shape_functions(order, np.linspace(0.0, 1.0, parts + 1), 0)[0], deformed)
        segments = np.stack((points[:, :-1], points[:, 1:]), axis=2).reshape(-1, 2, 2)
        return cls(segments, np.repeat(sagittas, parts))

    @cached_property
    def area(self) -> shapely.Geometry:
        """Points round which the boundary winds once."""
        rings = [shapely.make_valid(shapely.Polygon(ring)) for ring in self._rings()]
        return reduce(shapely.symmetric_difference, sorted(rings, key=lambda ring: -ring.area))

    @cached_property
    def _tree(self) -> shapely.STRtree:
        return shapely.STRtree(shapely.linestrings(self.segments))

    def _rings(self) -> Iterator[Floats]:
        """Closed chains of the segments, each (m, 2)."""
        left = {tuple(start): end for start, end in self.segments.tolist()}
        while left:
            ring = [next(iter(left))]
            while (end := left.pop(ring[-1], None)) is not None:
                ring.append(tuple(end))
            if len(ring) > 3:
                yield np.array(ring)

    def nearest(self, points: Floats) -> tuple[Floats, Ints]:
        """Distances of points (m, 2) from the boundary, and the segments that are nearest, each (m,)."""
        geometries = shapely.points(points)
        numbers = self._tree.nearest(geometries)
        return shapely.distance(geometries, self._tree.geometries[numbers]), numbers

    def overlap(self, other: "Boundary") -> Intrusion | None:
        """Point of one boundary in the other's body with the maximum depth beyond the curves; None if apart."""
        common = shapely.intersection(self.area, other.area)
        points = [_samples(ring) for polygon in shapely.get_parts(common) for ring in _rings_of(polygon)]
        if not points:
            return None
        at = np.concatenate(points)
        (mine, own), (theirs, its) = self.nearest(at), other.nearest(at)
        return _deepest(at, np.maximum(mine, theirs), self.sagittas[own] + other.sagittas[its])

    def overlap_with_itself(self, apart: float) -> Intrusion | None:
        """Point of this boundary in the body's other side with the maximum depth, seen from ``apart`` outside of it.

        Round a point of an overlap the boundary winds twice, and just outside of an edge in it once.
        """
        starts, chords = self.segments[:, 0], self.segments[:, 1] - self.segments[:, 0]
        outward = turned_right(chords) / np.hypot(*chords.T)[:, None]
        at = (starts[:, None] + SAMPLES[1:-1] * chords[:, None] + apart * outward[:, None]).reshape(-1, 2)
        owner = np.repeat(np.arange(len(starts)), len(SAMPLES) - 2)
        inside = shapely.contains_xy(self.area, at)
        at, owner = at[inside], owner[inside]
        if len(at) == 0:
            return None
        away = shapely.distance(shapely.points(at)[:, None], self._tree.geometries)
        away[chords[owner] @ chords.T >= 0.0] = np.inf  # edges that run the other way face this one
        facing = away.argmin(axis=1)
        return _deepest(at, away.min(axis=1), self.sagittas[owner] + self.sagittas[facing])


def _rings_of(polygon: shapely.Geometry) -> Sequence[shapely.Geometry]:
    whole = polygon.geom_type == "Polygon" and not polygon.is_empty
    return (polygon.exterior, *polygon.interiors) if whole else ()


def _samples(ring: shapely.Geometry) -> Floats:
    at = shapely.get_coordinates(ring)
    return (at[:-1, None] + SAMPLES[:-1] * np.diff(at, axis=0)[:, None]).reshape(-1, 2)


def _deepest(points: Floats, depths: Floats, allowed: Floats) -> Intrusion:
    deepest = int(np.argmax(depths - allowed))
    x, y = points[deepest].tolist()
    return Intrusion(float(depths[deepest]), (x, y), float(allowed[deepest]))


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
        Depth that is explained there: by the penetration of the contact law, by the sagitta h^2 / 8 R of drawn curves
        on each side, by `MAX_OVERLAP` of the surfaces' maximum displacement, and by round-off.

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


def deformed_boundaries(
    system: ContactSystem, response: BodyResponse, state: ContactState, fields: Sequence[Floats]
) -> list[Boundary]:
    """Boundary of each part in space, with the displacements of all nodes of each body in its own frame."""
    boundaries = []
    for number, (part, field) in enumerate(zip(system.parts, fields, strict=True)):
        first, last = response.offsets[number : number + 2]
        points = part.body.nodes
        at = state.placements[number].points(points + field[: len(points)])
        at[system.surface_nodes[number].nodes] = state.positions[first:last]
        surfaces = (side for each in system.contacts for side in each.sides if side.part is part)
        boundaries.append(Boundary.of_part(part, at, max(surface.chord_turn for surface in surfaces)))
    return boundaries


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
    if fields is None:
        fields = response.fields(response.rotations(state.placements), state.nodal_forces)
    boundaries = deformed_boundaries(system, response, state, fields)
    moved = float(np.linalg.norm(state.displacements, axis=1).max(initial=0.0))
    found = []
    sides = [each for each in zip(system.parts, boundaries, strict=True) if each[0].body.boundary_is_closed]
    touched = {id(each.primary.part) for each in system.contacts if each.primary.part is each.secondary.part}
    alone = [(side, side) for side in sides if id(side[0]) in touched]
    for (one, first_side), (other, other_side) in itertools.chain(itertools.combinations(sides, 2), alone):
        if one is other:
            deepest = first_side.overlap_with_itself(ROUND_OFF * one.body.size)
        else:
            deepest = first_side.overlap(other_side)
        if deepest is not None:
            size = min(one.body.size, other.body.size)
            allowed = deepest.allowed + _between(system, state, one, other)
            allowed += MAX_OVERLAP * moved + ROUND_OFF * size
            found.append(BodyOverlap((one.name, other.name), deepest.depth, deepest.position, allowed))
    return tuple(found)


def _between(system: ContactSystem, state: ContactState, one: Part, other: Part) -> float:
    """Maximum penetration that the laws of contacts between two parts explain."""
    both = {one, other}
    laws = (
        system.explained(each, 0.0)
        for each in system.solved(state.linearisation, state.forces)
        if set(each.contact.parts) == both
    )
    return max(laws, default=0.0)


def passages(system: ContactSystem, states: Sequence[ContactState]) -> list[str]:
    """Sentences about parts of a contact of which one moved through the other from one load step to the next.

    Parts that press on each other before or after a step have met. The way is that of the parts' final motions, those
    by handles included, so that a part that was pushed aside is no obstacle.

    Parameters
    ----------
    system
        The contacts.
    states
        Solution of each load step.

    """
    errors = []
    for one, other in dict.fromkeys(each.parts for each in system.contacts):
        numbers = system.parts.index(one), system.parts.index(other)
        apart = [(one.placement, other.placement)]
        ways = []
        for state in states:
            stop = state.placements[numbers[0]], state.placements[numbers[1]]
            solved = system.solved(state.linearisation, state.forces)
            if any(each.forces.any() for each in solved if set(each.contact.parts) == {one, other}):
                apart = []
                continue
            ways += [[*apart[-1:], stop]]
            apart = [stop]
        smallest = PASSAGE * min(one.body.size, other.body.size)
        if one is not other and any(passes_through(one, other, way, smallest) for way in ways if len(way) == 2):
            errors.append(
                f"{one.name} moved through {other.name}: they overlap on the way, and do not touch after it; move it "
                "less, or in smaller steps"
            )
    return errors


def passes_through(one: Part, other: Part, way: Sequence[tuple[Placement, Placement]], apart: float) -> bool:
    """Whether undeformed parts overlap by more than a distance between two placements of both.

    Parts that meet do so with a vertex of one boundary, or the middle of an edge, in the other part.
    """
    bodies = (one, other)
    for mover, target in ((0, 1), (1, 0)):
        if not bodies[target].body.boundary_is_closed:
            continue
        first, last = (placements[target].inverse().after(placements[mover]) for placements in way)
        motion = last.after(first.inverse())
        shares = np.linspace(0.0, 1.0, 2 + int(abs(motion.rotation_rad) / TURNED)).tolist()
        (x, y), angle = motion.translation, motion.rotation_rad
        frames = [Placement(share * angle, (share * x, share * y)).after(first) for share in shares]
        moved, still = (Boundary.of_part(part, part.body.nodes) for part in (bodies[mover], bodies[target]))
        points = np.concatenate((moved.segments[:, 0], moved.segments.mean(axis=1)))
        ways = shapely.linestrings(np.stack([frame.points(points) for frame in frames], axis=1))
        core = shapely.buffer(still.area, -apart - moved.sagittas.max() - still.sagittas.max())
        shapely.prepare(core)
        if shapely.intersects(core, ways).any():
            return True
    return False
