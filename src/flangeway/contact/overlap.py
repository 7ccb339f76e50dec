"""Whether deformed bodies overlap, measured on their whole boundaries."""

import itertools
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from flangeway.contact.boundary import ROUND_OFF, Boundary, deepest_intrusion
from flangeway.contact.system import ContactLinearisation, ContactSystem
from flangeway.problems import Part
from flangeway.solve import BodyResponse, ContactState
from flangeway.types import Floats


@dataclass(frozen=True)
class BodyOverlap:
    """How deep two parts overlap.

    Parameters
    ----------
    parts
        Names of the two.
    depth
        Distance of a point of one body's boundary from that of the other, in which it lies.
    place
        That point, x and y.
    allowed
        Depth that is explained there: by the penetration of the contact law, by the chords of curves (h^2 / 8 R on each
        side, see `Boundary`), by a thousandth of the surfaces' maximum displacement, and by round-off.

    """

    parts: tuple[str, str]
    depth: float
    place: tuple[float, float]
    allowed: float

    @property
    def is_explained(self) -> bool:
        """Whether the depth is within what is allowed."""
        return self.depth <= self.allowed

    def __str__(self) -> str:
        """Return a sentence."""
        x, y = self.place
        return (
            f"{self.parts[0]} and {self.parts[1]} overlap by {self.depth:.3g} at ({x:.4g}, {y:.4g}), where contact and "
            f"the chords of curves explain {self.allowed:.1e}; give all edges that may touch, move in smaller steps, "
            "or take a finer mesh there"
        )


def body_overlaps(
    system: ContactSystem, response: BodyResponse, state: ContactState, fields: Sequence[Floats] | None = None
) -> tuple[BodyOverlap, ...]:
    """Deepest overlap of each pair of deformed parts, whatever edges were given to their contacts.

    Parameters
    ----------
    system, response, state
        The contacts, the bodies, and a solution.
    fields
        Displacements of all nodes of each body in its own frame, if they are known.

    Returns
    -------
    tuple of BodyOverlap
        One for each pair that overlaps, also where it is explained.

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
        points = part.body.space.nodes
        at = state.placements[number].points(points + field[: len(points)])
        at[nodes] = state.positions[first:last]
        boundaries.append(part_boundary(part, at))
    moved = float(np.abs(state.displacements).max(initial=0.0))
    explained = [system.explained(lin, state.forces, number, moved) for number in range(len(system.contacts))]
    found = []
    for (one, first_side), (other, other_side) in itertools.combinations(zip(system.parts, boundaries, strict=True), 2):
        law = _between(system, one, other, explained)
        deepest = deepest_intrusion(first_side, other_side)
        if deepest is not None:
            allowed = deepest.allowed + law + ROUND_OFF * min(one.body.elasticity.size, other.body.elasticity.size)
            found.append(BodyOverlap((one.name, other.name), deepest.depth, deepest.place, allowed))
    return tuple(found)


def part_boundary(part: Part, positions: Floats) -> Boundary:
    """Boundary of a part whose nodes are at positions in space, shape (n_nodes, 2)."""
    edges = part.body.mesh.boundary_edges
    nodes = part.body.space.edge_nodes(edges)
    if part.placement.mirrored:
        edges, nodes = edges[:, ::-1], nodes[:, ::-1]
    drawn = part.placement.points(part.body.mesh.points)[edges]
    return Boundary.of(drawn, positions[nodes], (edges[:, 0].astype(np.int64), edges[:, 1].astype(np.int64)))


def _between(system: ContactSystem, one: Part, other: Part, explained: Sequence[float]) -> float:
    """Penetration that the laws of contacts between two parts explain."""
    mine = [
        each
        for contact, each in zip(system.contacts, explained, strict=True)
        if {id(contact.secondary.part), id(contact.primary.part)} == {id(one), id(other)}
    ]
    return max(mine, default=0.0)
