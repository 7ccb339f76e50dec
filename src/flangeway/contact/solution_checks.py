"""Checks of a contact solution that share no code with the gaps, the guards or the iteration; and overlap of bodies."""

import itertools
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from functools import cache, cached_property, reduce
from operator import itemgetter

import numpy as np
import shapely

from flangeway.contact.contact_state import ContactState, bending
from flangeway.contact.force_errors import (
    ForceError,
    force_errors,
    hidden_overlap,
)
from flangeway.contact.kinematics import as_complex, as_vectors, shape_functions
from flangeway.contact.node_to_segment import MatchedPairs
from flangeway.contact.search import MAX_ROTATION_STEP, on_path, visits
from flangeway.contact.surface import CORNER_ANGLE, Surface, sagittas_of
from flangeway.contact.system import LARGE_OVERLAP, MAX_OVERLAP, ROUND_OFF, Contact, ContactSystem
from flangeway.geometry import Placement
from flangeway.geometry.arrays import chords_of, cross_product, max_magnitude, norms, point_text, turned_right
from flangeway.mesh import PolyhedralMesh
from flangeway.mesh.connectivity import edge_places
from flangeway.problems import Body, Elasticity, Part
from flangeway.solve import BodyResponse, Checks, Handle
from flangeway.space.symmetric import EPS
from flangeway.types import Bools, Floats, Ints

# --- Overlap of deformed bodies, measured by Shapely on their whole boundaries.


SAMPLES = np.linspace(0.0, 1.0, 6)[:, None]
"""Points of a side of an overlap at which its depth is measured, as parts of the side."""

MAX_PASSAGE_DEPTH = 1e-6
"""Depth relative to the size of the smaller body up to which bodies that slide along each other are apart."""


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
    between_nodes
        Depth that elements which bend leave between nodes there.

    """

    depth: float
    position: tuple[float, float]
    allowed: float
    between_nodes: float


@dataclass(frozen=True, eq=False)
class Boundary:
    """Edges of a body's boundary as straight segments, and how far the drawn curve lies from them.

    Parameters
    ----------
    segments
        Ends of the segments, the body on their left, shape (n, 2, 2).
    sagittas
        Distance of a drawn curve through the edges' ends from the segments, shape (n,).
    in_contacts
        Whether the segments are of surfaces of contacts, shape (n,).

    """

    segments: Floats
    sagittas: Floats
    in_contacts: Bools

    @classmethod
    def of_part(
        cls, part: Part, positions: Floats, surfaces: Sequence[Surface] = (), followed: Sequence[Surface] = ()
    ) -> "Boundary":
        """Boundary of a part whose nodes are at positions in space (n_nodes, 2); curved edges become 8 segments.

        ``surfaces`` are those of contacts; edges of the ``followed`` ones follow their drawn curves.
        """
        edges = part.body.boundary_edges
        nodes = part.body.edge_nodes(edges)
        if part.placement.mirrored:
            edges, nodes = edges[:, ::-1], nodes[:, ::-1]
        drawn, points = part.placement.points(part.body.nodes)[edges], positions[nodes]
        order, joints = nodes.shape[1] - 1, (edges[:, 0].astype(np.int64), edges[:, 1].astype(np.int64))
        exact, bends = np.zeros(len(edges), dtype=np.bool_), np.zeros(len(edges), dtype=np.complex128)
        in_contacts, chord_turn = exact.copy(), max((side.chord_turn for side in surfaces), default=CORNER_ANGLE)
        for surface in surfaces:
            rows = edge_places(surface.edge_nodes[:, [0, -1]], edges, len(part.body.nodes))[0]
            in_contacts[rows] = True
            if surface not in followed:
                continue
            exact[rows] |= surface.follows_curve
            if surface.bends is not None:
                bends[rows] = surface.bends.conj() if part.placement.mirrored else surface.bends
        # what bodies bend is no curve: straight edges have 0
        sagittas = sagittas_of(drawn, drawn, joints, 0.0, chord_turn, exact)
        at_ends = np.zeros(len(part.body.nodes))
        np.maximum.at(at_ends, edges, sagittas[:, None])
        # half a chord beside a corner, as on dual polygons, has no turn that shows the curve: its neighbour has
        sagittas = np.where(exact, 0.0, at_ends[edges].max(axis=1))
        if order == 1 and not bends.any():
            return cls(points, sagittas, in_contacts)
        if order == 1:
            start, end = as_complex(points).T
            points = np.insert(points, 1, as_vectors((start + end) / 2.0 + bends * (end - start)), axis=1)
        parts = 4 * (points.shape[1] // 2 + 1)
        # points_eti = sum_a N_a(t) x_eai
        shapes = shape_functions(points.shape[1] - 1, np.linspace(0.0, 1.0, parts + 1), 0)[0]
        along = np.einsum("ta,eai->eti", shapes, points)
        segments = np.stack((along[:, :-1], along[:, 1:]), axis=2).reshape(-1, 2, 2)
        return cls(segments, np.repeat(sagittas, parts), np.repeat(in_contacts, parts))

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

    def overlap(self, other: "Boundary", deformation: float = 0.0) -> Intrusion | None:
        """Point of one boundary in the other's body with the maximum depth beyond what is allowed; None if apart.

        ``deformation`` is the displacement of the surfaces by which elements bend, see `bending`.
        """
        common = shapely.intersection(self.area, other.area)
        points = [_samples(ring) for polygon in shapely.get_parts(common) for ring in _rings_of(polygon)]
        if not points:
            return None
        at = np.concatenate(points)
        (own_depths, own_edges), (other_depths, other_edges) = self.nearest(at), other.nearest(at)
        depths, seen = np.maximum(own_depths, other_depths), np.ones(len(at), dtype=np.bool_)
        for boundary, edges in ((self, own_edges), (other, other_edges)):
            # no constraint sees what lies further beyond the end of a surface than it is deep
            rows = np.flatnonzero(~boundary.in_contacts[edges])
            surfaces = shapely.multilinestrings(boundary.segments[boundary.in_contacts])
            seen[rows] &= shapely.distance(shapely.points(at[rows]), surfaces) <= 2.0 * depths[rows]
        between = deformation * np.where(seen, MAX_OVERLAP, LARGE_OVERLAP)
        return _deepest(at, depths, self.sagittas[own_edges] + other.sagittas[other_edges], between)

    def overlap_with_itself(self, apart: float, deformation: float) -> Intrusion | None:
        """Point of this boundary in the body's other side with the maximum depth, seen from ``apart`` outside of it.

        Round a point of an overlap the boundary winds twice, and just outside of an edge in it once.
        """
        starts, chords = self.segments[:, 0], chords_of(self.segments)
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
        sagittas = self.sagittas[owner] + self.sagittas[facing]
        return _deepest(at, away.min(axis=1), sagittas, np.full(len(at), MAX_OVERLAP * deformation))


def _rings_of(polygon: shapely.Geometry) -> Sequence[shapely.Geometry]:
    whole = polygon.geom_type == "Polygon" and not polygon.is_empty
    return (polygon.exterior, *polygon.interiors) if whole else ()


def _samples(ring: shapely.Geometry) -> Floats:
    at = shapely.get_coordinates(ring)
    return (at[:-1, None] + SAMPLES[:-1] * np.diff(at, axis=0)[:, None]).reshape(-1, 2)


def _deepest(points: Floats, depths: Floats, sagittas: Floats, between_nodes: Floats) -> Intrusion:
    beyond = depths - sagittas
    deepest = int(np.argmax(beyond if (beyond <= between_nodes).all() else beyond - between_nodes))
    x, y = points[deepest].tolist()
    return Intrusion(float(depths[deepest]), (x, y), float(sagittas[deepest]), float(between_nodes[deepest]))


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
        on each side, by what is between nodes, and by round-off.
    between_nodes
        Depth that is explained between nodes: `MAX_OVERLAP` of `flangeway.contact.contact_state.bending` on surfaces of
        contacts, beyond their ends `LARGE_OVERLAP` of it.

    """

    parts: tuple[str, str]
    depth: float
    position: tuple[float, float]
    allowed: float
    between_nodes: float = 0.0

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
            f"the chords of curves explain {self.allowed:.1e}; give all edges that may touch, "
            "or take a finer mesh there"
        )


def deformed_boundaries(
    system: ContactSystem,
    response: BodyResponse,
    state: ContactState,
    fields: Sequence[Floats],
) -> list[Boundary]:
    """Boundary of each part in space, with the displacements of all nodes of each body in its own frame."""
    boundaries = []
    solved = system.solved(state.linearisation, state.forces)
    followed = [contact.contact for contact in solved if contact.follows_curves]
    for number, (part, field) in enumerate(zip(system.parts, fields, strict=True)):
        first, last = response.offsets[number : number + 2]
        points = part.body.nodes
        at = state.placements[number].points(points + field[: len(points)])
        at[system.surface_nodes[number].nodes] = state.positions[first:last]
        boundaries.append(_boundary(system, part, at, followed))
    return boundaries


def _boundary(system: ContactSystem, part: Part, positions: Floats, followed: Sequence[Contact]) -> Boundary:
    """Boundary of a part whose nodes are at positions in space, on its curves where contacts follow them."""
    of_part, on_curves = (
        [side for contact in contacts for side in contact.sides if side.part is part]
        for contacts in (system.contacts, followed)
    )
    return Boundary.of_part(part, positions, of_part, on_curves)


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
    deformation = bending(response, state.placements, state.positions, state.displacements)
    overlaps = []
    sides = [side for side in zip(system.parts, boundaries, strict=True) if side[0].body.boundary_is_closed]
    touched = {
        id(contact.primary.part) for contact in system.contacts if contact.primary.part is contact.secondary.part
    }
    alone = [(side, side) for side in sides if id(side[0]) in touched]
    for (one, first_side), (other, other_side) in itertools.chain(itertools.combinations(sides, 2), alone):
        if one is other:
            deepest = first_side.overlap_with_itself(ROUND_OFF * one.body.size, deformation)
        else:
            deepest = first_side.overlap(other_side, deformation)
        if deepest is not None:
            size = min(one.body.size, other.body.size)
            allowed = deepest.allowed + _between(system, state, one, other)
            allowed += deepest.between_nodes + ROUND_OFF * size
            both = one.name, other.name
            overlaps.append(BodyOverlap(both, deepest.depth, deepest.position, allowed, deepest.between_nodes))
    return tuple(overlaps)


def _between(system: ContactSystem, state: ContactState, one: Part, other: Part) -> float:
    """Maximum penetration that the laws of contacts between two parts explain."""
    both = {one, other}
    laws = (
        system.explained(contact, 0.0)
        for contact in system.solved(state.linearisation, state.forces)
        if set(contact.contact.parts) == both
    )
    return max(laws, default=0.0)


def passages(system: ContactSystem, states: Sequence[ContactState]) -> list[str]:
    """Sentences about parts of a contact of which one moved through the other from one load step to the next.

    Whole deformed boundaries count, on straight ways, or on arcs where parts turn. Parts that press on each other
    before or after a step have met: there the iteration has followed the surfaces in contact.

    Parameters
    ----------
    system
        The contacts.
    states
        Solution of each load step.

    """
    errors = []
    at = cache(lambda step: _placed_boundaries(system, states[step - 1] if step else None))
    for one, other in dict.fromkeys(contact.parts for contact in system.contacts):
        pressed = [False, *(_press_on_each_other(system, state, {one, other}) for state in states)]
        numbers = system.parts.index(one), system.parts.index(other)
        ways = (
            [[at(step)[number] for number in numbers] for step in steps]
            for steps in itertools.pairwise(range(len(pressed)))
            if one is not other and not any(pressed[step] for step in steps)
        )
        if any(passes_through(one, other, *way) for way in ways):
            errors.append(
                f"{one.name} moved through {other.name}: they overlap on the way, and do not touch after it; give all "
                "edges that may touch, or move it less"
            )
    return errors


def _press_on_each_other(system: ContactSystem, state: ContactState, both: set[Part]) -> bool:
    solved = system.solved(state.linearisation, state.forces)
    return any(contact.forces.any() for contact in solved if set(contact.contact.parts) == both)


PlacedBoundary = tuple[Placement, Boundary]


def _placed_boundaries(system: ContactSystem, state: ContactState | None) -> list[PlacedBoundary]:
    """Placement and deformed boundary of each part in a solution; None: before any motion and deformation."""
    if state is None:
        followed = [contact for contact in system.contacts if contact.follows_curves()]
        places = [(part, part.placement.points(part.body.nodes)) for part in system.parts]
        return [(part.placement, _boundary(system, part, at, followed)) for part, at in places]
    assert state.response is not None
    fields = state.response.fields(state.response.rotations(state.placements), state.nodal_forces)
    return list(zip(state.placements, deformed_boundaries(system, state.response, state, fields), strict=True))


def passes_through(one: Part, other: Part, before: Sequence[PlacedBoundary], after: Sequence[PlacedBoundary]) -> bool:
    """Whether one of two parts moves through the other, or into it, from boundaries before to those after.

    Parts that meet do so with a vertex of one boundary, or the middle of an edge, in the other part.
    """
    bodies = (one, other)
    turns = [abs(last.rotation_rad - first.rotation_rad) for (first, _), (last, _) in zip(before, after, strict=True)]
    shares = np.linspace(0.0, 1.0, 2 + int(max(turns) / MAX_ROTATION_STEP)).tolist()
    segments = []  # of both parts at each share
    for (first, start), (last, end) in zip(before, after, strict=True):
        both = np.stack((start.segments.reshape(-1, 2), end.segments.reshape(-1, 2)))
        segments.append(np.stack([on_path(first, last, both, share).reshape(-1, 2, 2) for share in shares]))
    allowed = MAX_PASSAGE_DEPTH * min(body.body.size for body in bodies)
    allowed += sum(float(boundary.sagittas.max()) for _, boundary in before)
    for mover, target in ((0, 1), (1, 0)):
        if not bodies[target].body.boundary_is_closed:
            continue
        points = np.concatenate((segments[mover][:, :, 0], segments[mover].mean(axis=2)), axis=1)
        for step in itertools.pairwise(range(len(shares))):
            entry = visits(points[list(step)], segments[target][list(step)], np.full(len(segments[target][0]), allowed))
            if (entry.other_side | (entry.depths > allowed)).any():
                return True
    return False


# --- Checks of a contact solution that share no code with the gaps, the guards or the iteration that found it.


MAX_RESIDUAL = 1e-6
"""Sum of forces relative to the maximum nodal force, and of moments relative to that and the size: above round-off."""

MAX_SLIDE = 0.5
"""Tangential distance of paired nodes relative to an edge, above which each faces the partner of another one."""

MAX_KEPT = 1e-3
"""Force along a motion that is kept in place, relative to all forces of the part, see `flangeway.solve.Handle`."""

MIN_NORMAL = float(np.finfo(np.float64).tiny)
"""Smallest normal number: no force divided by no force is zero."""

LARGE_STRAIN = 0.05
"""Mean strain of a cell, or pressure relative to the modulus, above which small strains are off by as many parts."""

LARGE_TURN = 0.1
"""Rotation of a cell in rad whose square half, 0.005, is a false strain."""

MAX_LINEAR = 1.0
"""Strain, and rotation in rad, above which the solution of a linear body is wrong: sides are longer by two fifths."""


def check_solution(
    system: ContactSystem,
    response: BodyResponse,
    state: ContactState,
    fields: Sequence[Floats],
    overlaps: Sequence[BodyOverlap],
    given: Sequence[tuple[Placement, Handle | None]],
) -> Checks:
    """Measure a solution whose iteration converged.

    Parameters
    ----------
    system, response, state
        The contacts, the bodies with their loads, and the solution.
    fields
        Displacements of all nodes of each part in its own frame, each (n_dofs, 2).
    overlaps
        See `flangeway.contact.solution_checks.body_overlaps`.
    given
        Placement of each part before its handle moved it, and the handle with its loads.

    """
    errors = [str(overlap) for overlap in overlaps if not overlap.is_explained]
    undeformed = state.positions - state.displacements
    warnings = [
        f"a corner meets a corner at ({x:.4g}, {y:.4g}): the side that carries the force is arbitrary; move one of "
        "them, or round them off"
        for number in range(len(system.contacts) if state.forces.any() else 0)
        for x, y in system.corners_on_corners(undeformed, number)[:1]
    ]
    size = max(part.body.size for part in system.parts)
    moved = bending(response, state.placements, state.positions, state.displacements)
    slide, by_slides = _slide(system, state, errors)
    # Forces of a pair act at points that a gap separates: the sum of f.x over all nodes is that of force times gap.
    work = abs(float((state.nodal_forces * (state.positions - state.positions.mean(axis=0))).sum()))
    gap = work / max(float(state.forces.sum()), MIN_NORMAL)
    # forces that displace no digit of the positions are none
    least = MIN_NORMAL + EPS * size / max(part.body.softness for part in system.parts)
    loads = (max_magnitude(handle.load[:2]) for _, handle in given if handle is not None)
    reference = max(max_magnitude(norms(state.nodal_forces)), least, *loads)
    # Friction acts across the gap of a law, and that between nodes; forces of paired nodes across their slides.
    apart = np.abs(state.linearisation.gaps) + LARGE_OVERLAP * moved
    by_gap = 0.0 if state.friction is None else float(np.abs(state.friction.forces) @ apart)
    force, moment = _unbalanced(system, response, state, fields, given)
    force, moment = force / reference, max(0.0, moment - by_slides - by_gap) / (reference * size)
    if not (force <= MAX_RESIDUAL and moment <= MAX_RESIDUAL):
        errors.append(
            f"forces of the contacts and loads are unbalanced by {force:.1e} of the maximum force, moments by "
            f"{moment:.1e} of it times the size; take another pairing"
        )
    inverted, strain, turn = 0, 0.0, 0.0
    for part, field in zip(system.parts, fields, strict=True):
        if isinstance(part.body, Body):
            warnings += filter(None, [part.body.elasticity.locking])
            cells = _cells(part, part.body, field, errors, warnings)
            inverted, strain, turn = inverted + cells[0], max(strain, cells[1]), max(turn, cells[2])
    # without the tolerance for what bends between nodes
    beyond = [overlap.depth - overlap.allowed + overlap.between_nodes for overlap in overlaps]
    overlap = max([0.0, *beyond])
    if overlap > LARGE_OVERLAP * moved and not errors:
        deepest = overlaps[int(np.argmax(beyond))]
        warnings.append(
            f"{' and '.join(deepest.parts)} overlap by {overlap:.2g} at {point_text(deepest.position)}, "
            f"{100.0 * overlap / moved:.2g} % of the maximum displacement, between nodes: take a finer mesh there"
        )
    moving = [part for part, (_, handle) in zip(system.parts, given, strict=True) if handle is not None]
    of_force, of_approach = _force_errors(
        force_errors(system, response, state), system, state, overlaps, moving, errors, warnings
    )
    measured = force, moment, gap, slide, overlap, inverted, strain, turn, of_force, of_approach
    return Checks(*measured, tuple(errors), tuple(warnings))


def _force_errors(
    regions: Sequence[ForceError],
    system: ContactSystem,
    state: ContactState,
    overlaps: Sequence[BodyOverlap],
    moving: Sequence[Part],
    errors: list[str],
    warnings: list[str],
) -> tuple[float, float]:
    """Maximum errors of a region's force, and of its approach, by the law of contact and by the mesh, see `ForceError`.

    The force of parts that move freely, ``moving``, is prescribed, and only their approach has an error.
    """
    worst = [0.0, 0.0]
    for number, solved in enumerate(system.solved(state.linearisation, state.forces)):
        contact = solved.contact
        name = f"the contact of {contact.secondary.part.name} on {contact.primary.part.name}"
        names = {part.name for part in contact.parts}
        depth = max((overlap.depth for overlap in overlaps if set(overlap.parts) == names), default=0.0)
        if not all(part.body.boundary_is_closed for part in contact.parts):
            depth = np.inf
        if not solved.follows_curves:  # the overlap is that of chords
            depth += sum(surface.curve_height for surface in contact.sides)
        # no mean is above the maximum on the whole boundaries
        of_contact = [
            replace(region, between_nodes=min(region.between_nodes, 2.0 * depth))
            for region in regions
            if region.contact == number
        ]
        if not of_contact:
            overlap = hidden_overlap(system, state, number)
            if overlap > ROUND_OFF * max(part.body.size for part in contact.parts):
                errors.append(
                    f"nothing touches in {name}, though its surfaces overlap by {overlap:.2g} between nodes: take "
                    "smaller elements there, and give it their drawn curves (curved)"
                )
            continue
        prescribed = bool(set(contact.parts).intersection(moving))
        by_law = [(ForceError.by_law, _error_by_law)] if contact.enforcement.approximates else []
        for measure, sentence in (*by_law, (ForceError.by_mesh, _error_by_mesh)):
            measured = [measure(region, prescribed=prescribed) for region in of_contact]
            error, region = max(zip(measured, of_contact, strict=True), key=itemgetter(0))
            small, most = region.limits(prescribed=prescribed)
            worst[prescribed] = max(worst[prescribed], error)
            if error > small:
                (errors if error > most else warnings).append(sentence(region, name, *_named(error, prescribed)))
    return worst[0], worst[1]


def _named(error: float, prescribed: bool) -> tuple[str, str]:
    """What an error is one of, and its size."""
    return ("approach", f"{error:.2g}") if prescribed else ("force", f"{100.0 * error:.2g} %")


def _error_by_law(region: ForceError, name: str, what: str, error: str) -> str:
    """Sentence about the error of a region by the law of contact."""
    size = "small" if (region.penetration < region.gap) == (what == "approach") else "large"
    makes = f"makes its {what} {error} too {size}"
    if region.penetration > region.gap:
        return f"the penetration of {name}, {region.penetration:.2g}, {makes}: raise the penalty"
    return f"surfaces of {name} are {region.gap:.2g} apart under pressure, which {makes}: take a smaller barrier"


def _error_by_mesh(region: ForceError, name: str, what: str, error: str) -> str:
    """Sentence about the error of a region by the mesh."""
    advice = f"take elements of at most {region.size:.2g} there"
    if region.chords > region.between_nodes + region.spread:
        advice = f"its surfaces are chords of curves: give them their drawn curves (curved), or {advice}"
    return f"the {what} of {name} may be off by {error}: its mesh is too coarse; {advice}"


def _slide(system: ContactSystem, state: ContactState, errors: list[str]) -> tuple[float, float]:
    """Maximum tangential distance of node-to-node pairs under force over the mean edge, and the moment by all."""
    worst, moment = 0.0, 0.0
    for contact, pairs, _, all_forces in system.solved(state.linearisation, state.forces):
        base = pairs.parts[0]
        if not isinstance(base, MatchedPairs):
            continue
        forces = all_forces[: len(base.keys)]
        if not (loaded := forces > 0.0).any():
            continue
        moment += float(forces @ base.shifts)
        # In mean edges under force: inserted nodes make edges of any shortness, beside which all slides are long.
        slides = np.where(loaded, base.shifts, 0.0) / base.longest[loaded].mean()
        worst = max(worst, most := float(slides.max()))
        if most > MAX_SLIDE:
            at = state.positions[system.nodes_of(contact.secondary)[base.nodes[slides.argmax()]]]
            errors.append(
                f"{contact.secondary.part.name} has slid by {most:.2g} edges from the node opposite it at "
                f"{point_text(at)}, and NodeToNode is for sliding far below an edge; match the boundaries where the "
                "bodies meet, or take SegmentToSegment"
            )
    return worst, moment


def _unbalanced(
    system: ContactSystem,
    response: BodyResponse,
    state: ContactState,
    fields: Sequence[Floats],
    given: Sequence[tuple[Placement, Handle | None]],
) -> tuple[float, float]:
    """Maximum force and moment by which contacts, and each handle with its loads and springs, are unbalanced.

    Motions of a handle that are kept in place take the forces that nothing else does: only their part above
    `MAX_KEPT` of the contact forces counts.
    """
    forces, at = state.nodal_forces, state.positions
    max_moves = [max_magnitude(norms(field)) for field in fields]
    total = forces.sum(axis=0)
    if system.parts[0].body.axisymmetric:
        force, moment = abs(float(total[1])), 0.0
    else:
        force = float(np.linalg.norm(total))
        moment = abs(float(cross_product(at - at.mean(axis=0), forces).sum()))
    for handle in dict.fromkeys(handle for _, handle in given if handle is not None):
        numbers = [number for number, (_, handle_of_force) in enumerate(given) if handle_of_force is handle]
        motion = state.placements[numbers[0]].after(given[numbers[0]][0].inverse())
        pivot = motion.points([handle.pivot])[0]
        point = handle.pivot if handle.load_point is None else handle.load_point
        arm = motion.points([point])[0] - pivot
        on_handle = np.append(handle.load[:2], handle.load[2] + cross_product(arm, handle.load[:2]))
        scale, by_strain = 0.0, 0.0
        for number in numbers:
            nodes = slice(*response.offsets[number : number + 2].tolist())
            on_body = response.resultant(number, state.placements[number], pivot)[:3]
            on_handle += on_body
            # loads on a body act where it is not deformed, contact where it is: small strains leave the difference
            by_strain += float(np.linalg.norm(on_body[:2])) * max_moves[number]
            on_handle[:2] += forces[nodes].sum(axis=0)
            on_handle[2] += cross_product(at[nodes] - pivot, forces[nodes]).sum()
            scale += float(np.abs(forces[nodes]).sum())
        left = np.append(handle.directions @ on_handle[:2], on_handle[2:] if handle.turns else [])
        if handle.stiffness is not None:
            moves = np.append(handle.directions @ (pivot - handle.pivot), [motion.rotation_rad] if handle.turns else [])
            left -= handle.stiffness @ moves
        kept = MAX_KEPT * scale if handle.soft_motions == "kept" else 0.0
        reach = max(system.parts[number].body.size for number in numbers)
        slides = np.abs(left[: len(handle.directions)])
        force = max(force, float(slides.max(initial=0.0)) - kept)
        if handle.turns:
            moment = max(moment, abs(float(left[-1])) - kept * reach - by_strain)
    return force, moment


def _cells(part: Part, body: Body, field: Floats, errors: list[str], warnings: list[str]) -> tuple[int, float, float]:
    """Number of inverted cells, and maximum mean strain and rotation of a cell, in the body's frame."""
    mesh = body.mesh
    starts, corners = mesh.cell_offsets[:-1].astype(np.int64), mesh.cell_points
    counts = np.diff(mesh.cell_offsets)
    following = np.arange(1, len(corners) + 1)
    following[mesh.cell_offsets[1:] - 1] = starts
    before, moved = mesh.points[corners], field[: len(mesh.points)][corners]
    areas = np.add.reduceat(cross_product(before, before[following]), starts) / 2.0
    chords = before[following] - before
    normals = turned_right(chords)
    # H_cij = 1/A_c sum over the cell's sides of (u_i + u_i')/2 n_j
    parts = 0.5 * (moved + moved[following])[:, :, None] * normals[:, None, :]
    gradients = np.add.reduceat(parts, starts) / areas[:, None, None]
    turns = np.abs(gradients[:, 1, 0] - gradients[:, 0, 1]) / 2.0
    mean, half = np.trace(gradients, axis1=1, axis2=2) / 2.0, (gradients[:, 0, 0] - gradients[:, 1, 1]) / 2.0
    strains = np.abs(mean) + np.hypot(half, (gradients[:, 0, 1] + gradients[:, 1, 0]) / 2.0)
    # by the mean deformation gradient: the corner between nearly straight sides turns inside out under any strain
    inverted = np.linalg.det(np.eye(2) + gradients) <= 0.0
    centres = np.add.reduceat(before, starts) / counts[:, None]
    return _linear_cells(part.name, centres, inverted, strains, turns, errors, warnings)


def spatial_cells(
    problem: Elasticity[PolyhedralMesh], field: Floats, errors: list[str], warnings: list[str]
) -> tuple[int, float, float]:
    """Number of inverted cells of a body in space, and maximum mean strain and rotation of a cell."""
    mesh = problem.space.mesh
    gradients = np.empty((mesh.n_cells, 3, 3))
    for batch in problem.space.batches():
        coefficients = problem.strains(batch, batch.reconstruct()).coefficients
        gradients[batch.cells] = np.einsum("jme,mei->eij", coefficients[0], field.reshape(-1, 3)[batch.dofs])
    inverted = np.linalg.det(np.eye(3) + gradients) <= 0.0
    strains = np.abs(np.linalg.eigvalsh((gradients + gradients.swapaxes(1, 2)) / 2.0)).max(axis=1)
    turns = np.linalg.norm(gradients - gradients.swapaxes(1, 2), axis=(1, 2)) / np.sqrt(8.0)
    centres = np.add.reduceat(mesh.points[mesh.cell_points], mesh.cell_offsets[:-1]) / mesh.cell_sizes[:, None]
    return _linear_cells(problem.name, centres, inverted, strains, turns, errors, warnings)


def _linear_cells(
    name: str,
    centres: Floats,
    inverted: Bools,
    strains: Floats,
    turns: Floats,
    errors: list[str],
    warnings: list[str],
) -> tuple[int, float, float]:
    """Add sentences about cells where bodies are not linear; the number of inverted ones, and the maxima."""
    if inverted.any():
        errors.append(
            f"{inverted.sum()} cells of {name} are inverted, one at {point_text(centres[inverted.argmax()])}; "
            "bodies are linear, for small strains: press less, or take a finer mesh there"
        )
    for values, limit, what in (
        (strains, LARGE_STRAIN, "the strain of {0} is {1:.2g}"),
        (turns, LARGE_TURN, "{0} turns by {1:.2g} rad"),
    ):
        cell = int(values.argmax())
        if values[cell] > limit:
            words, wrong = what.format(name, values[cell]), values[cell] > MAX_LINEAR
            where = f"at {point_text(centres[cell])}, beyond {MAX_LINEAR if wrong else limit:g}"
            (errors if wrong else warnings).append(f"{words} {where}, where bodies are not linear")
    return int(inverted.sum()), float(strains.max()), float(turns.max())
