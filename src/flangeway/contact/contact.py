"""Contacts between surfaces, and the system of all contacts that the solver sees."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
import scipy.sparse as sp
from numpy.typing import NDArray

from flangeway.contact.enforcement import Penalty
from flangeway.contact.node_to_segment import NodePairs, NodeToSegment
from flangeway.contact.surface import Surface
from flangeway.errors import InputError
from flangeway.problems import Part
from flangeway.solve import Linearisation, SurfaceNodes

Floats = NDArray[np.float64]
Ints = NDArray[np.int64]


@dataclass(frozen=True, eq=False)
class Contact:
    """Frictionless contact between two surfaces.

    Parameters
    ----------
    secondary
        Surface that gives nodes.
    primary
        Surface that gives segments; the normal points out of it.
    pairing
        How the surfaces are compared.
    enforcement
        How the condition of no penetration is enforced.

    """

    secondary: Surface
    primary: Surface
    pairing: NodeToSegment
    enforcement: Penalty

    def __post_init__(self) -> None:
        if self.secondary.part is self.primary.part:
            raise InputError(
                f"a contact of {self.primary.part.name!r} with itself",
                "surfaces of two parts",
                "model the two sides as two parts",
            )

    @property
    def node_areas(self) -> Floats:
        """Tributary areas of the secondary nodes, length times thickness."""
        return self.secondary.tributary_lengths * self.secondary.part.body.thickness


@dataclass(frozen=True, eq=False)
class ContactLinearisation:
    """Gaps of all contacts about some positions; see `flangeway.solve.Linearisation`.

    Parameters
    ----------
    pairs
        The pairs of each contact.
    starts
        First constraint of each contact, and the number of all.
    nodes, keys, partners, gaps, jacobian, compliances
        See `flangeway.solve.Linearisation`.
    pair_nodes
        Places in ``nodes`` of each constraint's nodes, one array a contact.

    """

    pairs: tuple[NodePairs, ...]
    starts: Ints
    nodes: Ints
    keys: Ints
    partners: Ints
    gaps: Floats
    jacobian: sp.csr_array
    compliances: Floats
    pair_nodes: tuple[Ints, ...]

    def curvature(self, forces: Floats) -> Floats:
        """Sum of ``force * second derivative of the gap`` over the constraints."""
        n = 2 * len(self.nodes)
        total = np.zeros((n, n))
        for number, pairs in enumerate(self.pairs):
            mine = forces[self.starts[number] : self.starts[number + 1]]
            loaded = np.flatnonzero(mine)
            if len(loaded) == 0:
                continue
            places = self.pair_nodes[number][loaded]
            dofs = (2 * places[:, :, None] + np.arange(2)).reshape(len(loaded), -1)
            values = mine[loaded, None, None] * pairs.kinematics.hessians[loaded]
            np.add.at(total, (dofs[:, :, None], dofs[:, None, :]), values)
        return total


class ContactSystem:
    """All contacts among some parts, as inequalities on the parts' surface nodes.

    Parameters
    ----------
    contacts
        The contacts; their parts are numbered in order of appearance.

    """

    def __init__(self, contacts: Sequence[Contact]) -> None:
        if not contacts:
            raise InputError("no contact", "at least one", "pair two surfaces with Contact(...)")
        self.contacts = tuple(contacts)
        parts: dict[int, Part] = {}
        nodes: dict[int, list[NDArray[np.int32]]] = {}
        for contact in self.contacts:
            for surface in (contact.secondary, contact.primary):
                parts.setdefault(id(surface.part), surface.part)
                nodes.setdefault(id(surface.part), []).append(surface.nodes)
        self.parts = tuple(parts.values())
        self.surface_nodes = tuple(
            SurfaceNodes(part.body, np.unique(np.concatenate(nodes[id(part)]))) for part in self.parts
        )
        counts = [len(surface.nodes) for surface in self.surface_nodes]
        self._first_node = np.concatenate(([0], np.cumsum(counts)))
        sizes = [len(contact.secondary.nodes) for contact in self.contacts]
        self._first_key = np.concatenate(([0], np.cumsum(sizes)))
        edges = [len(contact.primary.edges) for contact in self.contacts]
        self._first_edge = np.concatenate(([0], np.cumsum(edges)))

    def nodes_of(self, surface: Surface) -> Ints:
        """Numbers of a surface's nodes among the surface nodes of all parts, along the surface."""
        number = self.parts.index(surface.part)
        within = np.searchsorted(self.surface_nodes[number].nodes, surface.nodes)
        return (self._first_node[number] + within).astype(np.int64)

    def linearise(self, positions: Floats, previous: Linearisation | None) -> ContactLinearisation:
        """Pair all surfaces at positions (n_nodes, 2) of the surface nodes."""
        all_pairs, members = [], []
        for number, contact in enumerate(self.contacts):
            secondary = self.nodes_of(contact.secondary)
            edges = self.nodes_of(contact.primary)[contact.primary.edge_places]
            pairs = contact.pairing.pair(
                positions[secondary],
                contact.secondary.edge_places,
                positions[edges],
                self._kept(number, previous),
            )
            all_pairs.append(pairs)
            members.append(np.concatenate((secondary[pairs.nodes][:, None], edges[pairs.edges]), axis=1))
        return self._assembled(all_pairs, members)

    def _kept(self, number: int, previous: Linearisation | None) -> Ints:
        kept = np.full(len(self.contacts[number].secondary.nodes), -1, dtype=np.int64)
        if previous is not None:
            first, last = self._first_key[number : number + 2]
            mine = (previous.keys >= first) & (previous.keys < last)
            kept[previous.keys[mine] - first] = previous.partners[mine] - self._first_edge[number]
        return kept

    def _assembled(self, all_pairs: list[NodePairs], members: list[Ints]) -> ContactLinearisation:
        starts = np.concatenate(([0], np.cumsum([len(pairs.nodes) for pairs in all_pairs])))
        nodes = np.unique(np.concatenate([member.ravel() for member in members]))
        places = tuple(np.searchsorted(nodes, member) for member in members)
        rows, columns, values = [], [], []
        for start, pairs, place in zip(starts, all_pairs, places, strict=False):
            gradients = pairs.kinematics.gradients
            row = start + np.arange(len(pairs.nodes))[:, None, None]
            rows.append(np.broadcast_to(row, gradients.shape).ravel())
            columns.append((2 * place[:, :, None] + np.arange(2)).ravel())
            values.append(gradients.ravel())
        entries = (np.concatenate(rows), np.concatenate(columns))
        shape = (int(starts[-1]), 2 * len(nodes))
        jacobian = sp.csr_array(sp.coo_array((np.concatenate(values), entries), shape=shape))
        numbered = list(zip(all_pairs, self.contacts, strict=True))
        return ContactLinearisation(
            tuple(all_pairs),
            starts,
            nodes,
            np.concatenate([self._first_key[i] + p.nodes for i, p in enumerate(all_pairs)]),
            np.concatenate([self._first_edge[i] + p.edges for i, p in enumerate(all_pairs)]),
            np.concatenate([pairs.kinematics.gaps for pairs in all_pairs]),
            jacobian,
            np.concatenate([c.enforcement.compliances(c.node_areas[pairs.nodes]) for pairs, c in numbered]),
            places,
        )
