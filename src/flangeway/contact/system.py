"""The system of all contacts among some parts, as the solver uses it."""

import itertools
from collections.abc import Sequence
from typing import NamedTuple

import numpy as np
import scipy.sparse as sp

from flangeway.contact.contact_pair import Contact
from flangeway.contact.guards import corners_on_corners, corners_under_force, guarded, key_starts, penetrating
from flangeway.contact.linearisation import ContactLinearisation, components_of
from flangeway.contact.pairs import Constraints
from flangeway.contact.surface import Surface
from flangeway.errors import InputError
from flangeway.problems import Part
from flangeway.solve import SurfaceNodes
from flangeway.types import Bools, Floats, Ints

BETWEEN_NODES = 1e-3
"""Depth over the maximum displacement of the surfaces that elements leave between nodes."""

MAX_OVERLAP = 0.2
"""Overlap over the maximum displacement of the surfaces, between nodes where bodies bend and meshes do not: elements at
the end of a contact on a sharp corner leave up to 0.18 on the coarsest meshes that are held to be of use. Nodes that
bending on both sides puts deeper get a constraint of their own."""

LARGE_OVERLAP = 0.05
"""The same, above which it is said."""

ROUND_OFF = 1e-9
"""Of a depth, over the size of the smaller body."""


class SolvedContact(NamedTuple):
    """A contact in a solution: its constraints, where they are among those of all contacts, and their forces."""

    contact: Contact
    pairs: Constraints
    inside: slice
    forces: Floats


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
        if not contacts:
            raise InputError("no contact", "at least one", "pair two surfaces with Contact(...)")
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
        self._first_node = np.concatenate(([0], np.cumsum(counts)))
        sides = [contact.sides for contact in self.contacts]
        self._first_key = np.concatenate(([0], np.cumsum([key_starts(*both)[-1] for both in sides])))
        # edges of the primary side, then those of the secondary one
        self._first_edge = np.concatenate(([0], np.cumsum([sum(len(each.edges) for each in both) for both in sides])))
        self._points, self._spread = self._middles()

    @property
    def reach(self) -> float:
        """Mean length of the edges of a primary surface, that of the contact where it is least."""
        return min(float(contact.primary.edge_lengths.mean()) for contact in self.contacts)

    def solved(self, lin: ContactLinearisation, all_forces: Floats) -> list[SolvedContact]:
        """The contacts with their parts of a linearisation and of the forces of its constraints."""
        ends = np.cumsum([0, *(len(pairs.keys) for pairs in lin.pairs)]).tolist()
        slices = itertools.starmap(slice, itertools.pairwise(ends))
        given = zip(self.contacts, lin.pairs, slices, strict=True)
        return [SolvedContact(contact, pairs, inside, all_forces[inside]) for contact, pairs, inside in given]

    def nodes_of(self, surface: Surface) -> Ints:
        """Numbers of a surface's nodes among the surface nodes of all parts, along the surface."""
        number = self.parts.index(surface.part)
        within = np.searchsorted(self.surface_nodes[number].nodes, surface.nodes)
        return (self._first_node[number] + within).astype(np.int64)

    def linearise(
        self, positions: Floats, previous: ContactLinearisation | None, *, settle: bool = False
    ) -> ContactLinearisation:
        """Linearise about positions (n_nodes, 2) of the surface nodes; pairs of ``previous`` stay where they can.

        To ``settle`` is to keep them by a wider margin, for an iteration that goes round in circles.
        """
        none = [
            (np.zeros(len(each.secondary.nodes), dtype=np.bool_), np.zeros(len(each.primary.nodes), dtype=np.bool_))
            for each in self.contacts
        ]
        return self._with(none if previous is None else previous.guarded_nodes, positions, previous, settle=settle)

    def unguarded(self, positions: Floats, lin: ContactLinearisation, forces: Floats) -> ContactLinearisation:
        """Linearise about the positions of ``lin`` without guarded nodes; itself if it has none.

        Those of sharp corners under force stay: no other constraint has what such a corner presses on.
        """
        if not any(each.any() for sides in lin.guarded_nodes for each in sides):
            return lin
        kept = [corners_under_force(pairs, contact.sides, own) for contact, pairs, _, own in self.solved(lin, forces)]
        return self._with(kept, positions, lin, settle=False)

    def guarded(
        self, positions: Floats, lin: ContactLinearisation, forces: Floats, moved: float
    ) -> ContactLinearisation | None:
        """Linearise with constraints for nodes that penetrate although those of ``lin`` hold; None if there are none.

        ``moved`` is the maximum displacement, to which small depths are compared.
        """
        guarded_nodes, more = [], False
        points = self._all_points(positions)
        for number, each in enumerate(self.solved(lin, forces)):
            sides, explained = each.contact.sides, self.explained(each, moved)
            at = points[self._points[id(sides[0])]], points[self._points[id(sides[1])]]
            found = penetrating(sides, at, lin.guarded_nodes[number], explained, MAX_OVERLAP * moved / 2.0)
            one, other = (before | new for before, new in zip(lin.guarded_nodes[number], found, strict=True))
            more |= int(one.sum() + other.sum()) > sum(int(each.sum()) for each in lin.guarded_nodes[number])
            guarded_nodes.append((one, other))
        return self._with(guarded_nodes, positions, lin, settle=False) if more else None

    def corners_on_corners(self, reference: Floats, number: int) -> Floats:
        """Points (n, 2) at which corners of a contact's surfaces meet, by the undeformed surface nodes (n_nodes, 2)."""
        sides = self.contacts[number].sides
        return corners_on_corners(sides, (reference[self.nodes_of(sides[0])], reference[self.nodes_of(sides[1])]))

    @staticmethod
    def explained(solved: SolvedContact, moved: float) -> float:
        """Maximum penetration that the law of a contact, the elements between nodes and round-off explain."""
        law = solved.contact.enforcement
        given = law.tolerance()
        if not np.isfinite(given):
            compliances = np.concatenate([law.compliances(part) for part in solved.pairs.parts])
            given = float((compliances * solved.forces).max(initial=0.0))
        size = min(part.body.size for part in solved.contact.parts)
        return (1.0 + ROUND_OFF) * given + BETWEEN_NODES * moved + ROUND_OFF * size

    def _with(
        self,
        guarded_nodes: Sequence[tuple[Bools, Bools]],
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
        x, y = positions[self.nodes_of(surface)[node]]
        return f"node {surface.nodes[node]} of {surface.part.name!r} at ({x:.6g}, {y:.6g}) on {other.part.name!r}"

    def _all_points(self, positions: Floats) -> Floats:
        """Surface nodes at positions (n_nodes, 2), and the points of `Surface.bends`."""
        return positions if self._spread is None else (self._spread @ positions.ravel()).reshape(-1, 2)

    def _kept(self, number: int, previous: ContactLinearisation | None) -> Ints:
        first = self._first_key[number]
        contact = self.contacts[number]
        kept = np.full(len(contact.pairing.key_nodes(contact.secondary)), -1, dtype=np.int64)
        if previous is not None:
            mine = (previous.keys >= first) & (previous.keys < first + len(kept))
            kept[previous.keys[mine] - first] = previous.partners[mine] - self._first_edge[number]
        return kept

    def _assembled(
        self, all_pairs: list[Constraints], members: list[Ints], guarded_nodes: tuple[tuple[Bools, Bools], ...]
    ) -> ContactLinearisation:
        parts = [part for pairs in all_pairs for part in pairs.parts]
        starts = np.cumsum([0, *(len(part.keys) for part in parts)])
        points = np.unique(np.concatenate([member.ravel() for member in members]))
        places = tuple(np.searchsorted(points, member) for member in members)
        nodes, spread = points, None
        if self._spread is not None:
            rows_of_points = self._spread[components_of(points).ravel()]
            nodes = np.unique(rows_of_points.indices // 2).astype(np.int64)
            spread = sp.csr_array(rows_of_points[:, components_of(nodes).ravel()])
        laws = [each.enforcement for each, pairs in zip(self.contacts, all_pairs, strict=True) for _ in pairs.parts]
        return ContactLinearisation(
            tuple(all_pairs),
            starts,
            nodes,
            np.concatenate([self._first_key[i] + p.keys for i, p in enumerate(all_pairs)]),
            np.concatenate([_shifted(p.partners, self._first_edge[i]) for i, p in enumerate(all_pairs)]),
            np.concatenate([pairs.gaps for pairs in all_pairs]),
            np.concatenate([law.compliances(part) for law, part in zip(laws, parts, strict=True)]),
            np.concatenate([law.barriers(part) for law, part in zip(laws, parts, strict=True)]),
            np.repeat([law.tolerance() for law in laws], np.diff(starts)),
            np.repeat([contact.friction_coefficient for contact in self.contacts], [len(p.keys) for p in all_pairs]),
            places,
            guarded_nodes,
            spread,
        )

    def _middles(self) -> tuple[dict[int, Ints], sp.csr_array | None]:
        """Numbers of each surface's points by its id, and the positions of all points by those of the surface nodes.

        Points are the nodes of all surfaces, then those of `Surface.bends`.
        """
        n = int(self._first_node[-1])
        surfaces = {id(each): each for contact in self.contacts for each in contact.sides}
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
    sides, others = (each.sides for each in (first, second))
    if any(all(map(_share_edges, sides, each)) for each in (others, others[::-1])):
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
