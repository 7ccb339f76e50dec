"""The system of all contacts among some parts, as the solver sees it."""

import itertools
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
import scipy.sparse as sp
from numpy.typing import NDArray

from flangeway.contact.contact import Contact
from flangeway.contact.pairs import Pairs
from flangeway.contact.surface import Surface
from flangeway.errors import InputError
from flangeway.problems import Part
from flangeway.solve import Linearisation, SurfaceNodes

Floats = NDArray[np.float64]
Ints = NDArray[np.int64]


@dataclass(frozen=True, eq=False)
class ContactLinearisation:
    """Gaps of all contacts about some positions; see `flangeway.solve.Linearisation`.

    Parameters
    ----------
    pairs
        The pairs of each contact.
    starts
        First constraint of each contact, and the number of all.
    nodes, keys, partners, gaps, jacobian, compliances, tolerances
        See `flangeway.solve.Linearisation`.
    term_nodes
        Places in ``nodes`` of the nodes of each contact's terms, arrays (p, w).

    """

    pairs: tuple[Pairs, ...]
    starts: Ints
    nodes: Ints
    keys: Ints
    partners: Ints
    gaps: Floats
    jacobian: sp.csr_array
    compliances: Floats
    tolerances: Floats
    term_nodes: tuple[Ints, ...]

    def curvature(self, forces: Floats) -> sp.csr_array:
        """Sum of ``force * second derivative of the gap`` over the constraints."""
        rows, columns, values = [], [], []
        for number, pairs in enumerate(self.pairs):
            mine = forces[self.starts[number] : self.starts[number + 1]]
            if not mine.any():
                continue
            loaded, found = pairs.curvatures(mine)
            dofs = _components(self.term_nodes[number][loaded]).reshape(len(loaded), -1)
            rows.append(np.broadcast_to(dofs[:, :, None], found.shape).ravel())
            columns.append(np.broadcast_to(dofs[:, None, :], found.shape).ravel())
            values.append(found.ravel())
        shape = (2 * len(self.nodes), 2 * len(self.nodes))
        if not values:
            return sp.csr_array(shape)
        entries = np.concatenate(rows), np.concatenate(columns)
        return sp.csr_array(sp.coo_array((np.concatenate(values), entries), shape=shape))


class ContactSystem:
    """All contacts among some parts, as inequalities on the parts' surface nodes.

    Parameters
    ----------
    contacts
        The contacts; their parts are numbered in order of appearance.

    Raises
    ------
    InputError
        If there is none, or two of them are between the same edges: each would bear a part of the pressure.

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
            for surface in (contact.secondary, contact.primary):
                parts.setdefault(id(surface.part), surface.part)
                surfaces.setdefault(id(surface.part), []).append(surface)
        self.parts = tuple(parts.values())
        self.surface_nodes = tuple(_union(surfaces[id(part)]) for part in self.parts)
        counts = [len(surface.nodes) for surface in self.surface_nodes]
        self._first_node = np.concatenate(([0], np.cumsum(counts)))
        sizes = [len(contact.pairing.key_nodes(contact.secondary)) for contact in self.contacts]
        self._first_key = np.concatenate(([0], np.cumsum(sizes)))
        edges = [len(contact.primary.edges) for contact in self.contacts]
        self._first_edge = np.concatenate(([0], np.cumsum(edges)))

    def nodes_of(self, surface: Surface) -> Ints:
        """Numbers of a surface's nodes among the surface nodes of all parts, along the surface."""
        number = self.parts.index(surface.part)
        within = np.searchsorted(self.surface_nodes[number].nodes, surface.nodes)
        return (self._first_node[number] + within).astype(np.int64)

    def linearise(
        self, positions: Floats, previous: Linearisation | None, *, settle: bool = False
    ) -> ContactLinearisation:
        """Pair all surfaces at positions (n_nodes, 2) of the surface nodes; see `flangeway.solve.Constraints`."""
        all_pairs: list[Pairs] = []
        members = []
        for number, contact in enumerate(self.contacts):
            secondary = self.nodes_of(contact.secondary)
            edges = self.nodes_of(contact.primary)[contact.primary.edge_places]
            pairs = contact.pairing.pair(
                contact.secondary,
                contact.primary,
                positions[secondary],
                positions[edges],
                self._kept(number, previous),
                settle=settle,
            )
            all_pairs.append(pairs)
            mine = (secondary[pairs.secondary_members], edges[pairs.primary_edges])
            members.append(np.concatenate(mine, axis=1))
        return self._assembled(all_pairs, members)

    def describe(self, key: int, positions: Floats) -> str:
        """Name a constraint; see `flangeway.solve.Constraints.describe`."""
        number = int(np.searchsorted(self._first_key, key, side="right")) - 1
        contact = self.contacts[number]
        place = contact.pairing.key_nodes(contact.secondary)[key - self._first_key[number]]
        x, y = positions[self.nodes_of(contact.secondary)[place]]
        node = contact.secondary.nodes[place]
        names = contact.secondary.part.name, contact.primary.part.name
        return f"node {node} of {names[0]!r} at ({x:.6g}, {y:.6g}) on {names[1]!r}"

    def _kept(self, number: int, previous: Linearisation | None) -> Ints:
        first, last = self._first_key[number : number + 2]
        kept = np.full(last - first, -1, dtype=np.int64)
        if previous is not None:
            mine = (previous.keys >= first) & (previous.keys < last)
            kept[previous.keys[mine] - first] = previous.partners[mine] - self._first_edge[number]
        return kept

    def _assembled(self, all_pairs: list[Pairs], members: list[Ints]) -> ContactLinearisation:
        starts = np.concatenate(([0], np.cumsum([len(pairs.keys) for pairs in all_pairs])))
        nodes = np.unique(np.concatenate([member.ravel() for member in members]))
        places = tuple(np.searchsorted(nodes, member) for member in members)
        rows, columns, values = [], [], []
        for start, pairs, place in zip(starts, all_pairs, places, strict=False):
            gradients = pairs.gradients
            rows.append(np.broadcast_to(start + pairs.rows[:, :, None, None], gradients.shape).ravel())
            columns.append(np.broadcast_to(_components(place)[:, None], gradients.shape).ravel())
            values.append(gradients.ravel())
        entries = (np.concatenate(rows), np.concatenate(columns))
        shape = (int(starts[-1]), 2 * len(nodes))
        jacobian = sp.csr_array(sp.coo_array((np.concatenate(values), entries), shape=shape))
        laws = [contact.enforcement for contact in self.contacts]
        return ContactLinearisation(
            tuple(all_pairs),
            starts,
            nodes,
            np.concatenate([self._first_key[i] + p.keys for i, p in enumerate(all_pairs)]),
            np.concatenate([_shifted(p.partners, self._first_edge[i]) for i, p in enumerate(all_pairs)]),
            np.concatenate([pairs.gaps for pairs in all_pairs]),
            jacobian,
            np.concatenate([law.compliances(pairs) for law, pairs in zip(laws, all_pairs, strict=True)]),
            np.concatenate([np.full(len(p.keys), law.penetration) for law, p in zip(laws, all_pairs, strict=True)]),
            places,
        )


def _refuse_twice(first: Contact, second: Contact) -> None:
    """Raise `InputError` if two contacts have edges of both bodies in common, whichever is secondary."""
    others = {id(surface.part): surface.edges for surface in (second.secondary, second.primary)}
    pairs = [(surface.edges, others.get(id(surface.part))) for surface in (first.secondary, first.primary)]
    if all(theirs is not None and _share_edges(mine, theirs) for mine, theirs in pairs):
        raise InputError(
            f"two contacts of {first.secondary.part.name!r} and {first.primary.part.name!r} along the same edges",
            "each pair of edges in one contact",
            "leave one of them out: a contact keeps both bodies off each other, whichever is secondary",
        )


def _share_edges(one: NDArray[np.int32], other: NDArray[np.int32]) -> bool:
    return not set(map(tuple, one.tolist())).isdisjoint(map(tuple, other.tolist()))


def _union(surfaces: list[Surface]) -> SurfaceNodes:
    """Nodes of one part's surfaces; where several have a node, the first with a curve gives its place."""
    nodes = np.unique(np.concatenate([surface.nodes for surface in surfaces]))
    shifts = np.zeros((len(nodes), 2))
    for surface in reversed(surfaces):
        if surface.curve is not None:
            shifts[np.searchsorted(nodes, surface.nodes)] = surface.shifts
    return SurfaceNodes(surfaces[0].part.body, nodes, shifts if shifts.any() else None)


def _components(places: Ints) -> Ints:
    """Numbers of the components of nodes (..., w), shape (..., w, 2)."""
    return 2 * places[..., None] + np.arange(2)


def _shifted(partners: Ints, first: np.int64) -> Ints:
    return np.where(partners >= 0, partners + first, -1)
