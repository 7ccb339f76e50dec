"""Contacts between surfaces, and the system of all among some parts as the solver uses it."""

import itertools
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property, partial
from typing import NamedTuple

import numpy as np
import scipy.sparse as sp
from scipy.ndimage import maximum_filter1d

from flangeway.checks import are_all, is_finite, refused
from flangeway.contact.guards import (
    Guards,
    corners_on_corners,
    guarded,
    key_starts,
    penetrating,
    unguarded,
)
from flangeway.contact.kinematics import Slides
from flangeway.contact.pairs import Constraints, Enforcement, Multiplier, Pairing, Pairs
from flangeway.contact.rolling.friction import Friction
from flangeway.contact.search import visits
from flangeway.contact.segment_to_segment import SegmentToSegment
from flangeway.contact.surface import Surface
from flangeway.errors import InputError, short
from flangeway.geometry.arrays import chords_of, components_of, max_magnitude, norms, starts_of
from flangeway.mesh.connectivity import places_in
from flangeway.problems import Part
from flangeway.solve import SurfaceNodes
from flangeway.solve.active_set import LIMIT_MARGIN
from flangeway.types import Floats, Ints

# --- Contact between two surfaces.


PAIRINGS = "NodeToSegment(...), SegmentToSegment(...) or NodeToNode()"
ENFORCEMENTS = "Penalty(...) or AugmentedLagrange(...) or Multiplier(...) or Barrier(...)"

MIN_RESOLVED = 5
"""Constraints of the pairing under force from which a contact is not narrower than its elements."""


@dataclass(frozen=True, eq=False)
class Contact:
    """Contact between two surfaces of two parts or of one, without friction or with Coulomb's.

    Of bodies of revolution areas, forces and dissipated work are those of the whole circumference.

    Parameters
    ----------
    secondary
        Surface that gives nodes, or over which gaps are averaged. The one with the finer mesh is the better choice.
    primary
        Surface that gives segments.
    pairing
        How the surfaces are compared: by default segment to segment.
    enforcement
        How the condition of no penetration is enforced: by default by multipliers, which leave none.
    friction
        Coefficient of Coulomb's friction, >= 0, or a `Friction` with one such coefficient. Slip is counted from the
        last converged step, so the answer depends on the path of the motion; see `press`.

    Raises
    ------
    InputError
        If the surfaces have nodes in common or belong to parts of different thickness or hypothesis, if the pairing
        and the enforcement do not go together, if a penalty has no value (the message suggests one for these bodies),
        or if the friction is no number >= 0 or falls with the slip velocity, which statics does not know.

    """

    secondary: Surface
    primary: Surface
    pairing: Pairing = field(default_factory=SegmentToSegment)
    enforcement: Enforcement = field(default_factory=Multiplier)
    friction: float | Friction = 0.0

    def __post_init__(self) -> None:
        kinds = {"pairing": (Pairing, PAIRINGS), "enforcement": (Enforcement, ENFORCEMENTS)}
        for name, (kind, allowed) in kinds.items():
            if not isinstance(value := getattr(self, name), kind):
                raise refused("Contact", name, value, allowed, "make one, with its parentheses")
        if self.secondary.part is self.primary.part and np.intersect1d(self.secondary.nodes, self.primary.nodes).size:
            raise InputError(
                f"a contact of {self.primary.part.name!r} with itself, whose surfaces have nodes in common",
                "surfaces of two parts, or two of one part that do not meet",
                "name the edges of both; leave the edges at the common corner out of one of them",
            )
        if self.secondary.part.body.thickness != self.primary.part.body.thickness:
            raise InputError(
                f"a contact of {self._names} with thicknesses {self.secondary.part.body.thickness} and "
                f"{self.primary.part.body.thickness}",
                "one thickness for both",
                "give both bodies the length over which they touch",
            )
        bodies = [part.body for part in self.parts]
        hypotheses = [body.hypothesis or "a plane of unknown strain" for body in bodies]
        known = {body.hypothesis for body in bodies if body.hypothesis is not None}
        if len(known) > 1 or bodies[0].axisymmetric != bodies[1].axisymmetric:
            raise InputError(
                f"a contact of {self._names} in {' and '.join(word.replace('_', ' ') for word in hypotheses)}",
                "both in plane strain, both in plane stress, or both axisymmetric",
                "take one hypothesis for both materials",
            )
        if bodies[0].axisymmetric and isinstance(self.pairing, SegmentToSegment) and self.pairing.weighting == "dual":
            raise InputError(
                f"dual weighting of bodies of revolution {self._names}",
                "weighting='standard': the dual functions average nothing at the axis",
                "leave it out",
            )
        self._refuse_bad_friction()
        mean_area = float(np.mean(self.node_areas))
        self.enforcement.check(self.pairing, self.suggested_penalty, mean_area, self._names)

    @property
    def sides(self) -> tuple[Surface, Surface]:
        """Secondary and primary surface."""
        return self.secondary, self.primary

    @property
    def parts(self) -> tuple[Part, Part]:
        """Parts of the secondary and of the primary surface."""
        return self.secondary.part, self.primary.part

    @property
    def node_areas(self) -> Floats:
        """Areas of the secondary nodes, length times thickness, if the primary faces them all: shape (n_nodes,)."""
        return self.pairing.node_areas(self.secondary)

    @property
    def suggested_penalty(self) -> float:
        """Ten times the larger stiffness over the mean length of the secondary edges, a pressure per length."""
        stiffest = max(part.body.modulus for part in self.parts)
        return 10.0 * stiffest / float(np.mean(self.secondary.edge_lengths))

    @property
    def friction_coefficient(self) -> float:
        """Coefficient of friction, the same at every point and slip."""
        return float(self.friction.limits[0][0]) if isinstance(self.friction, Friction) else float(self.friction)

    def follows_curves(self, n_pressed: int = 0) -> bool:
        """Whether its edges are their curves also between nodes, where so many constraints of the pairing are pressed.

        Else they are chords: with friction, as slip is that of nodes, and where many elements are in contact, as forces
        between their nodes would oscillate.
        """
        return self.friction_coefficient == 0.0 and n_pressed < MIN_RESOLVED

    def _refuse_bad_friction(self) -> None:
        given = f"Contact(friction={short(self.friction)}) of {self._names}"
        law = self.friction
        if isinstance(law, Friction):
            if not law.constant or len(law.limits[0]) != 1:
                raise InputError(
                    given,
                    "one coefficient that does not depend on the slip velocity: bodies move slowly here",
                    "give a number; flangeway rolls with other laws",
                )
        elif not (is_finite(law) and law >= 0.0):
            raise InputError(given, "a number >= 0", "leave friction out for contact without it")

    @property
    def _names(self) -> str:
        return f"{self.secondary.part.name!r} on {self.primary.part.name!r}"


# --- Gaps of all contacts about some positions, and what is measured of two linearisations and forces.


@dataclass(frozen=True, eq=False)
class Sliding:
    """Slips of the constraints of a linearisation about its positions, and the directions of tangential forces.

    Parameters
    ----------
    slips
        Slips, shape (m,).
    jacobian
        Derivatives of the slips, shape (m, 2 n_touched).
    directions
        Nodal forces of unit tangential forces, which do the work of the slips, shape (m, 2 n_touched).
    curvature
        Called with tangential forces (m,): derivatives of their nodal forces, not symmetric, (2 n_touched,
        2 n_touched).

    """

    slips: Floats
    jacobian: sp.csr_array
    directions: sp.csr_array
    curvature: Callable[[Floats], sp.csr_array]


@dataclass(frozen=True, eq=False)
class ContactLinearisation:
    """Gaps of all contacts about some positions, to second order.

    Parameters
    ----------
    pairs
        The constraints of each contact; their parts follow each other.
    starts
        First constraint of each part, and the number of all.
    nodes
        Surface nodes on which any gap depends, shape (n_touched,).
    keys
        Identity of each constraint from one linearisation to the next, shape (m,).
    partners
        What each constraint is against, shape (m,); a change starts a new linear piece.
    gaps
        Gaps, open where positive, shape (m,).
    compliances, offsets
        Derivative of the penetration by each force, and penetration at which the law's tangent has none, each (m,).
    barriers
        Force times gap of a barrier, and its reach, shape (m, 2): 0 and infinite where there is none.
    tolerances
        Maximum penetration that is tolerated, shape (m,): where finite, forces are corrected until it is reached.
    coefficients
        Coefficients of friction, shape (m,).
    term_points
        Numbers among the touched points of those of each part's terms, arrays (p, w).
    spread
        Positions of the touched points by those of ``nodes``, components after each other; None: they are the nodes.
    guarded_nodes
        Which points of each contact's secondary and primary surface are guarded, see `flangeway.contact.guards`.

    """

    pairs: tuple[Constraints, ...]
    starts: Ints
    nodes: Ints
    keys: Ints
    partners: Ints
    gaps: Floats
    compliances: Floats
    offsets: Floats
    barriers: Floats
    tolerances: Floats
    coefficients: Floats
    term_points: tuple[Ints, ...]
    guarded_nodes: tuple[Guards, ...]
    spread: sp.csr_array | None = None

    @property
    def parts(self) -> list[Pairs]:
        """Constraints of one kind each, contact by contact."""
        return [part for pairs in self.pairs for part in pairs.parts]

    @cached_property
    def jacobian(self) -> sp.csr_array:
        """Derivatives of the gaps, shape (m, 2 n_touched)."""
        return self._by_nodes([part.gradients for part in self.parts])

    def curvature(self, forces: Floats) -> sp.csr_array:
        """Sum of ``force * second derivative of the gap`` over the constraints, shape (2 n_touched, 2 n_touched)."""
        return self._second([part.curvatures for part in self.parts], forces)

    def slides(self, positions: Floats, before: Floats) -> Sliding:
        """Slips since earlier positions (n_nodes, 2) of the surface nodes, which are at others now."""
        now, was = self.points(positions), self.points(before)
        sliding_parts = []
        for number, (pairs, terms) in enumerate(zip(self.parts, self.term_points, strict=True)):
            if self.coefficients[self.starts[number] : self.starts[number + 1]].any():
                sliding_parts.append(pairs.slides(now[terms], was[terms]))
            else:
                sliding_parts.append(_no_slides(pairs))
        jacobian = self._by_nodes([part.rates for part in sliding_parts])
        directions = self._by_nodes([part.directions for part in sliding_parts])
        slips = np.concatenate([part.slips for part in sliding_parts])
        return Sliding(slips, jacobian, directions, partial(self._second, [part.turns for part in sliding_parts]))

    def _by_nodes(self, all_gradients: Sequence[Floats]) -> sp.csr_array:
        """Derivatives of all constraints by the touched nodes, from those (p, r, w, 2) of each part's terms."""
        rows, columns, values = [], [], []
        for start, part, points, gradients in zip(
            self.starts[:-1], self.parts, self.term_points, all_gradients, strict=True
        ):
            rows.append(np.broadcast_to(start + part.rows[:, :, None, None], gradients.shape).ravel())
            columns.append(np.broadcast_to(components_of(points)[:, None], gradients.shape).ravel())
            values.append(gradients.ravel())
        matrix = self._matrix(int(self.starts[-1]), rows, columns, values)
        return matrix if self.spread is None else sp.csr_array(matrix @ self.spread)

    def _second(self, seconds: Sequence[Callable[[Floats], tuple[Ints, Floats]]], forces: Floats) -> sp.csr_array:
        """Sum of ``force * second derivative`` by a function of each part, which has those of its terms."""
        rows, columns, values = [], [], []
        for number, second in enumerate(seconds):
            part_forces = forces[self.starts[number] : self.starts[number + 1]]
            if not part_forces.any():
                continue
            loaded, matrix = second(part_forces)
            dofs = components_of(self.term_points[number][loaded]).reshape(len(loaded), -1)
            rows.append(np.broadcast_to(dofs[:, :, None], matrix.shape).ravel())
            columns.append(np.broadcast_to(dofs[:, None, :], matrix.shape).ravel())
            values.append(matrix.ravel())
        if not values:
            return sp.csr_array((2 * len(self.nodes), 2 * len(self.nodes)))
        matrix = self._matrix(None, rows, columns, values)
        return matrix if self.spread is None else sp.csr_array(self.spread.T @ matrix @ self.spread)

    def _matrix(
        self, n_rows: int | None, rows: Sequence[Ints], columns: Sequence[Ints], values: Sequence[Floats]
    ) -> sp.csr_array:
        """Matrix of entries whose columns, and rows where no number is given, are components of the touched points."""
        n = 2 * len(self.nodes) if self.spread is None else self.spread.shape[0]
        entries = np.concatenate(rows), np.concatenate(columns)
        shape = (n if n_rows is None else n_rows, n)
        matrix = sp.csr_array((np.concatenate(values), entries), shape=shape)
        matrix.eliminate_zeros()
        return matrix

    def points(self, positions: Floats) -> Floats:
        """Positions of the touched points by those of all surface nodes (n_nodes, 2), shape (n, 2)."""
        touched = positions[self.nodes]
        return touched if self.spread is None else (self.spread @ touched.ravel()).reshape(-1, 2)


def _no_slides(pairs: Pairs) -> Slides:
    """Those of a contact without friction."""
    nothing = np.zeros(pairs.gradients.shape)
    return Slides(np.zeros(len(pairs.keys)), nothing, nothing, pairs.curvatures)


def carried_forces(before: ContactLinearisation | None, forces: Floats, after: ContactLinearisation) -> Floats:
    """Forces of the constraints in ``after`` that were in ``before``; zero for new ones."""
    result = np.zeros(len(after.keys))
    if before is None or len(before.keys) == 0:
        return result
    rows, known = places_in(before.keys, after.keys)
    result[known] = forces[rows[known]]
    return result


def nodal_forces_of(
    lin: ContactLinearisation, forces: Floats, slides: Sliding | None, tangential: Floats, n_nodes: int
) -> Floats:
    """Forces on all surface nodes (n_nodes, 2) by normal and tangential forces of the constraints, each (m,)."""
    result = np.zeros((n_nodes, 2))
    result[lin.nodes] = (lin.jacobian.T @ forces).reshape(-1, 2)
    if slides is not None:
        result[lin.nodes] += (slides.directions.T @ tangential).reshape(-1, 2)
    return result


def changed_keys(
    before: ContactLinearisation,
    forces: tuple[Floats, Floats],
    after: ContactLinearisation,
    new_forces: tuple[Floats, Floats],
) -> tuple[int, ...]:
    """Keys of active constraints that came, went, changed their partner, or between stick and slip."""
    pairs = []
    for lin, (values, tangential) in ((before, forces), (after, new_forces)):
        active = values > 0.0
        signs = np.where(np.abs(tangential) >= (1.0 - LIMIT_MARGIN) * lin.coefficients * values, np.sign(tangential), 0)
        keys = (lin.keys[active].tolist(), lin.partners[active].tolist(), signs[active].tolist())
        pairs.append(set(zip(*keys, strict=True)))
    return tuple(sorted({key for key, _, _ in pairs[0] ^ pairs[1]}))


# --- The system of all contacts among some parts, as the solver uses it.


BETWEEN_NODES = 1e-3
"""Depth relative to the maximum displacement of the surfaces that elements leave between nodes."""

MAX_OVERLAP = 0.2
"""Overlap relative to the maximum displacement of the surfaces, between nodes where bodies bend and meshes do not:
elements at the end of a contact on a sharp corner leave up to 0.18 on the coarsest meshes that are held to be of use.
Nodes that bending on both sides puts deeper get a constraint of their own."""

N_NEIGHBOURS = 5
"""Edges in a row the longest of which is the length of the one in their middle."""

MIN_THICKNESS = 5e-3
"""Depth relative to the length of an edge below which a node that leaves through another edge met a corner's tip or an
edge that turned, and no body: twice that is the thickness of the thinnest body that stops it."""

SHALLOW = 0.1
"""Depth relative to the length of an edge up to which a node has not gone through it: guards and averages see to it."""

SMALL_MOVE = 3e-3
"""Move relative to the mean length of an edge that takes no node into another surface: all iterations together go less
deep than `SHALLOW` by such moves."""

SIMULTANEOUS = 1e-6
"""Difference of times, as parts of a move, at which nodes enter another surface together."""

LARGE_OVERLAP = 0.05
"""The same, above which it is said."""

ROUND_OFF = 1e-9
"""Of a depth, relative to the size of the smaller body."""


class SolvedContact(NamedTuple):
    """A contact in a solution: its constraints, where they are among those of all contacts, and their forces."""

    contact: Contact
    pairs: Constraints
    inside: slice
    forces: Floats

    @property
    def follows_curves(self) -> bool:
        """Whether its edges are their curves also between nodes, see `Contact.follows_curves`."""
        return self.contact.follows_curves(int(np.count_nonzero(self.forces[~self.pairs.guarded])))


class Entry(NamedTuple):
    """Where nodes enter another surface on a straight move.

    - `time`: part of the move after which the first one does.
    - `guards`: which nodes of each contact's secondary and primary surface do then.
    """

    time: float
    guards: tuple[Guards, ...]


class ContactSystem:
    """All contacts among some parts, as inequalities on the parts' surface nodes.

    Parameters
    ----------
    contacts
        The contacts; their parts are numbered in order of appearance.

    Raises
    ------
    InputError
        If there is none, or two of them are between the same edges: each would carry a part of the pressure.

    """

    def __init__(self, contacts: Sequence[Contact]) -> None:
        if not are_all(contacts, Contact) or not contacts:
            raise InputError(f"contacts={short(contacts)}", "a list of at least one Contact(...)", "write [contact]")
        self.contacts = tuple(contacts)
        for first, second in itertools.combinations(self.contacts, 2):
            _refuse_twice(first, second)
        parts: dict[int, Part] = {}
        surfaces: dict[int, list[Surface]] = {}
        for contact in self.contacts:
            for surface in contact.sides:
                parts.setdefault(id(surface.part), surface.part)
                surfaces.setdefault(id(surface.part), []).append(surface)
        self.parts = tuple(parts.values())
        self.surface_nodes = tuple(_union(surfaces[id(part)]) for part in self.parts)
        counts = [len(surface.nodes) for surface in self.surface_nodes]
        self._first_node = starts_of(counts)
        sides = [contact.sides for contact in self.contacts]
        self._first_key = starts_of([key_starts(*both)[-1] for both in sides])
        # edges of the primary side, then those of the secondary one
        self._first_edge = starts_of([sum(len(surface.edges) for surface in both) for both in sides])
        self._points, self._spread = self._middles()

    @property
    def reach(self) -> float:
        """Mean length of the edges of a primary surface, that of the contact where it is least."""
        return min(float(contact.primary.edge_lengths.mean()) for contact in self.contacts)

    @property
    def without_friction(self) -> "ContactSystem":
        """The same contacts without friction."""
        return ContactSystem([replace(contact, friction=0.0) for contact in self.contacts])

    def solved(self, lin: ContactLinearisation, all_forces: Floats) -> list[SolvedContact]:
        """The contacts with their parts of a linearisation and of the forces of its constraints."""
        ends = starts_of([len(pairs.keys) for pairs in lin.pairs]).tolist()
        slices = itertools.starmap(slice, itertools.pairwise(ends))
        given = zip(self.contacts, lin.pairs, slices, strict=True)
        return [SolvedContact(contact, pairs, inside, all_forces[inside]) for contact, pairs, inside in given]

    def rows_of(self, number: int) -> slice:
        """Rows of a part among the surface nodes of all parts."""
        return slice(*self._first_node[number : number + 2].tolist())

    def nodes_of(self, surface: Surface) -> Ints:
        """Numbers of a surface's nodes among the surface nodes of all parts, along the surface."""
        number = self.parts.index(surface.part)
        within = np.searchsorted(self.surface_nodes[number].nodes, surface.nodes)
        return (self._first_node[number] + within).astype(np.int64)

    def points_of(self, surface: Surface, positions: Floats) -> Floats:
        """Points of a surface's `Surface.contact_places` by positions (n_nodes, 2) of all surface nodes."""
        return self._all_points(positions)[self._points[id(surface)]]

    @property
    def _none_guarded(self) -> tuple[Guards, ...]:
        """No point of the contacts' surfaces, in new arrays."""
        return tuple(unguarded(contact.sides) for contact in self.contacts)

    def linearise(
        self, positions: Floats, previous: ContactLinearisation | None, *, settle: bool = False
    ) -> ContactLinearisation:
        """Linearise about positions (n_nodes, 2) of the surface nodes; pairs of ``previous`` stay where they can.

        To ``settle`` is to keep them by a wider margin, for an iteration that goes round in circles.
        """
        guarded_nodes = self._none_guarded if previous is None else previous.guarded_nodes
        return self._with(guarded_nodes, positions, previous, settle=settle)

    def unguarded(self, positions: Floats, lin: ContactLinearisation) -> ContactLinearisation:
        """Linearise about the positions of ``lin`` without guarded nodes; itself if it has none."""
        if not any(mask.any() for sides in lin.guarded_nodes for mask in sides):
            return lin
        return self._with(self._none_guarded, positions, lin, settle=False)

    def guarded(
        self, positions: Floats, lin: ContactLinearisation, forces: Floats, moved: float
    ) -> ContactLinearisation | None:
        """Linearise with constraints for nodes that penetrate although those of ``lin`` hold; None if there are none.

        ``moved`` is the maximum displacement, to which small depths are compared.
        """
        guarded_nodes, more = [], False
        points = self._all_points(positions)
        for number, contact in enumerate(self.solved(lin, forces)):
            sides, explained = contact.contact.sides, self.explained(contact, moved)
            at = points[self._points[id(sides[0])]], points[self._points[id(sides[1])]]
            bent = MAX_OVERLAP * moved / 2.0
            guards = penetrating(sides, at, lin.guarded_nodes[number], explained, bent, follow=contact.follows_curves)
            more |= bool(guards[0].any() or guards[1].any())
            one, other = (
                np.where(new > 0.0, new, before) for before, new in zip(lin.guarded_nodes[number], guards, strict=True)
            )
            guarded_nodes.append((one, other))
        return self._with(guarded_nodes, positions, lin, settle=False) if more else None

    def entered(self, before: Floats, after: Floats, lin: ContactLinearisation) -> Entry | None:
        """Where nodes go into another surface on a straight move, and no constraint after it has a gap that shows it.

        None if there are none.

        - `before`, `after`: positions of the surface nodes, each (n_nodes, 2).
        - `lin`: linearisation of the contacts about those after the move.
        """
        if max_magnitude(after - before) <= SMALL_MOVE * self.reach:
            return None
        points = np.stack((self._all_points(before), self._all_points(after)))
        all_entries: list[tuple[int, int, Ints, Floats]] = []
        for number, contact in enumerate(self.solved(lin, lin.gaps)):
            sides = contact.contact.sides
            at = [points[:, self._points[id(side)]] for side in sides]
            closed = contact.pairs.nodes[contact.forces < 0.0]  # its forces are gaps here
            shown = np.any(np.isin(sides[0].edge_places, closed), axis=1)
            on_shown = np.zeros(len(sides[0].nodes), dtype=np.bool_)
            on_shown[sides[0].edge_places[np.flatnonzero(shown)]] = True
            for side, other in ((0, 1), (1, 0)):
                places, n = sides[other].contact_places, len(sides[side].nodes)
                pieces = np.stack((places[:, :-1].ravel(), places[:, 1:].ravel()), axis=1)
                edges = at[other][:, pieces]
                # short edges beside long ones turn about their nodes as these deform: their length says nothing
                lengths = maximum_filter1d(norms(chords_of(edges[0])), N_NEIGHBOURS)
                depths = SHALLOW * lengths
                entry = visits(at[side][:, :n], edges, depths)
                shows = on_shown[entry.points] if side == 0 else shown[entry.edges // (places.shape[1] - 1)]
                deep = (entry.depths > depths[entry.edges]) & ~(shows & (entry.ends == 1.0))
                # constraints of its own hold a node that has any, unless it goes right through
                right_through = entry.other_side & (entry.depths > MIN_THICKNESS * lengths[entry.edges])
                deep = right_through | (deep & (lin.guarded_nodes[number][side][entry.points] == 0.0))
                all_entries.append((number, side, entry.points[deep], entry.times[deep]))
        first = min((float(times.min(initial=np.inf)) for *_, times in all_entries), default=np.inf)
        if first > 1.0:
            return None
        guards = self._none_guarded
        for number, side, nodes, times in all_entries:
            guards[number][side][nodes[times <= first + SIMULTANEOUS]] = 1.0
        return Entry(first, guards)

    def guarded_too(
        self, positions: Floats, lin: ContactLinearisation, guards: Sequence[Guards]
    ) -> ContactLinearisation:
        """Linearise about positions (n_nodes, 2) with those nodes guarded that are in ``lin``, and others."""
        pairs = zip(lin.guarded_nodes, guards, strict=True)
        both = [(np.maximum(one, more[0]), np.maximum(two, more[1])) for (one, two), more in pairs]
        return self._with(both, positions, lin, settle=False)

    def corners_on_corners(self, reference: Floats, number: int) -> Floats:
        """Points (n, 2) at which corners of a contact's surfaces meet, by the undeformed surface nodes (n_nodes, 2)."""
        sides = self.contacts[number].sides
        return corners_on_corners(sides, (reference[self.nodes_of(sides[0])], reference[self.nodes_of(sides[1])]))

    @staticmethod
    def explained(solved: SolvedContact, moved: float) -> float:
        """Maximum penetration that the law of a contact, the elements between nodes and round-off explain."""
        law = solved.contact.enforcement
        given = law.tolerance() if solved.forces.any() else 0.0
        if not np.isfinite(given):
            parts = solved.pairs.parts
            compliances, offsets = (
                np.concatenate([of(part) for part in parts]) for of in (law.compliances, law.offsets)
            )
            given = float((compliances * solved.forces + offsets)[solved.forces > 0.0].max(initial=0.0))
        size = min(part.body.size for part in solved.contact.parts)
        return (1.0 + ROUND_OFF) * given + BETWEEN_NODES * moved + ROUND_OFF * size

    def _with(
        self,
        guarded_nodes: Sequence[Guards],
        positions: Floats,
        previous: ContactLinearisation | None,
        *,
        settle: bool,
    ) -> ContactLinearisation:
        all_pairs: list[Constraints] = []
        members = []
        points = self._all_points(positions)
        for number, contact in enumerate(self.contacts):
            sides = contact.sides
            secondary, primary = (self._points[id(side)] for side in sides)
            edges = primary[contact.primary.contact_places]
            kept = self._kept(number, previous)
            pairs = contact.pairing.pair(*sides, points[secondary], points[edges], kept, settle=settle)
            all_pairs.append(pairs)
            if guarded_nodes[number][0].any() or guarded_nodes[number][1].any():
                before = None if previous is None else previous.pairs[number]
                at = points[secondary], points[primary]
                all_pairs[-1] = guarded(pairs, sides, at, guarded_nodes[number], before, settle=settle)
            for part in all_pairs[-1].parts:
                nodes = secondary[part.secondary_members], edges[part.primary_edges]
                members.append(np.concatenate(nodes, axis=1))
        return self._assembled(all_pairs, members, tuple(guarded_nodes))

    def describe(self, key: int, positions: Floats) -> str:
        """Name a constraint for messages: its node, where that is among positions (n_nodes, 2), and the surfaces."""
        number = int(np.searchsorted(self._first_key, key, side="right")) - 1
        contact = self.contacts[number]
        surface, other = contact.sides
        local, (first, second, _) = int(key - self._first_key[number]), key_starts(surface, other)
        if local < first:
            node = int(contact.pairing.key_nodes(surface)[local])
        elif local < second:
            node = (local - first) // len(other.edges)
        else:
            node = (local - second) // len(surface.edges)
            surface, other = other, surface
        if node >= len(surface.nodes):  # a point of an edge
            node = int(surface.edge_places[node - len(surface.nodes), 0])
        return self._node_text(int(self.nodes_of(surface)[node]), positions, [other])

    def describe_node(self, node: int, positions: Floats) -> str:
        """Name a surface node at one of positions (n_nodes, 2) for messages, and the surfaces that it is against."""
        sides = [both for contact in self.contacts for both in (contact.sides, contact.sides[::-1])]
        return self._node_text(node, positions, [other for one, other in sides if node in self.nodes_of(one)])

    def _node_text(self, node: int, positions: Floats, others: Sequence[Surface]) -> str:
        number, (x, y) = int(np.searchsorted(self._first_node, node, side="right")) - 1, positions[node]
        within = self.surface_nodes[number].nodes[node - self._first_node[number]]
        against = " and ".join(dict.fromkeys(repr(other.part.name) for other in others))
        return f"node {within} of {self.parts[number].name!r} at ({x:.6g}, {y:.6g}) on {against}"

    def describe_entry(self, entry: Entry, positions: Floats) -> str:
        """Name the bodies of which one moved through the other, and where it entered among positions (n_nodes, 2)."""
        number, side = next((i, side) for i, sides in enumerate(entry.guards) for side in (0, 1) if sides[side].any())
        surface, other = self.contacts[number].sides[:: 1 - 2 * side]
        x, y = positions[self.nodes_of(surface)[int(entry.guards[number][side].argmax())]]
        return f"{surface.part.name} moved through {other.part.name} at ({x:.6g}, {y:.6g})"

    def _all_points(self, positions: Floats) -> Floats:
        """Surface nodes at positions (n_nodes, 2), and the points of `Surface.bends`."""
        return positions if self._spread is None else (self._spread @ positions.ravel()).reshape(-1, 2)

    def _kept(self, number: int, previous: ContactLinearisation | None) -> Ints:
        first = self._first_key[number]
        contact = self.contacts[number]
        kept = np.full(len(contact.pairing.key_nodes(contact.secondary)), -1, dtype=np.int64)
        if previous is not None:
            of_contact = (previous.keys >= first) & (previous.keys < first + len(kept))
            kept[previous.keys[of_contact] - first] = previous.partners[of_contact] - self._first_edge[number]
        return kept

    def _assembled(
        self, all_pairs: list[Constraints], members: list[Ints], guarded_nodes: tuple[Guards, ...]
    ) -> ContactLinearisation:
        parts = [part for pairs in all_pairs for part in pairs.parts]
        starts = starts_of([len(part.keys) for part in parts])
        points = np.unique(np.concatenate([member.ravel() for member in members]))
        point_rows = tuple(np.searchsorted(points, member) for member in members)
        nodes, spread = points, None
        if self._spread is not None:
            rows_of_points = self._spread[components_of(points).ravel()]
            nodes = np.unique(rows_of_points.indices // 2).astype(np.int64)
            spread = sp.csr_array(rows_of_points[:, components_of(nodes).ravel()])
        laws = [
            contact.enforcement for contact, pairs in zip(self.contacts, all_pairs, strict=True) for _ in pairs.parts
        ]
        return ContactLinearisation(
            tuple(all_pairs),
            starts,
            nodes,
            np.concatenate([self._first_key[i] + p.keys for i, p in enumerate(all_pairs)]),
            np.concatenate([_shifted(p.partners, self._first_edge[i]) for i, p in enumerate(all_pairs)]),
            np.concatenate([pairs.gaps for pairs in all_pairs]),
            np.concatenate([law.compliances(part) for law, part in zip(laws, parts, strict=True)]),
            np.concatenate([law.offsets(part) for law, part in zip(laws, parts, strict=True)]),
            np.concatenate([law.barriers(part) for law, part in zip(laws, parts, strict=True)]),
            np.repeat([law.tolerance() for law in laws], np.diff(starts)),
            np.repeat([contact.friction_coefficient for contact in self.contacts], [len(p.keys) for p in all_pairs]),
            point_rows,
            guarded_nodes,
            spread,
        )

    def _middles(self) -> tuple[dict[int, Ints], sp.csr_array | None]:
        """Numbers of each surface's points by its id, and the positions of all points by those of the surface nodes.

        Points are the nodes of all surfaces, then those of `Surface.bends`.
        """
        n = int(self._first_node[-1])
        surfaces = {id(surface): surface for contact in self.contacts for surface in contact.sides}
        numbers: dict[int, Ints] = {}
        ends, bends = [], []
        count = n
        for key, surface in surfaces.items():
            numbers[key] = self.nodes_of(surface)
            if surface.bends is not None:
                ends.append(numbers[key][surface.edge_places])
                # in space a mirrored body's edges bend to the other side
                bends.append(surface.bends.conj() if surface.part.placement.mirrored else surface.bends)
                numbers[key] = np.append(numbers[key], count + np.arange(len(surface.bends)))
                count += len(surface.bends)
        if count == n:
            return numbers, None
        bend = np.concatenate(bends)
        factors = np.stack((0.5 - bend, 0.5 + bend), axis=1)  # complex: shares of both ends
        entries = np.repeat(np.arange(count - n), 2), np.concatenate(ends).ravel()
        middles = sp.coo_array((factors.ravel(), entries), shape=(count - n, n))
        shares = sp.vstack((sp.eye_array(n), middles))
        spread = sp.csr_array(sp.kron(shares.real, np.eye(2)) + sp.kron(shares.imag, [[0.0, -1.0], [1.0, 0.0]]))
        spread.eliminate_zeros()
        return numbers, spread


def _refuse_twice(first: Contact, second: Contact) -> None:
    """Raise `InputError` if two contacts have edges of both bodies in common, whichever is secondary."""
    sides, others = (contact.sides for contact in (first, second))
    if any(all(map(_share_edges, sides, order)) for order in (others, others[::-1])):
        raise InputError(
            f"two contacts of {first.secondary.part.name!r} and {first.primary.part.name!r} along the same edges",
            "each pair of edges in one contact",
            "leave one of them out: a contact prevents overlap of both bodies, whichever is secondary",
        )


def _share_edges(one: Surface, other: Surface) -> bool:
    shared = not set(map(tuple, one.edges.tolist())).isdisjoint(map(tuple, other.edges.tolist()))
    return one.part is other.part and shared


def _union(surfaces: list[Surface]) -> SurfaceNodes:
    """Nodes of one part's surfaces; where several have a node, the first with a curve gives its position."""
    nodes = np.unique(np.concatenate([surface.nodes for surface in surfaces]))
    shifts = np.zeros((len(nodes), 2))
    for surface in reversed(surfaces):
        if surface.curve is not None:
            shifts[np.searchsorted(nodes, surface.nodes)] = surface.shifts
    return SurfaceNodes(surfaces[0].part.body, nodes, shifts if shifts.any() else None)


def _shifted(partners: Ints, first: np.int64) -> Ints:
    return np.where(partners >= 0, partners + first, -1)
