"""How a set of placed linear bodies answers to forces on its surface nodes.

Two ways give the same answers: `CondensedBodies` works on the surfaces alone, `SparseBodies` on all unknowns. The
iteration for contact uses only `BodyResponse`.

The surface nodes of all bodies are numbered one after the other; vectors on them have shape (n_nodes, 2) and the
axes of space.
"""

from abc import ABC, abstractmethod
from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np
import scipy.sparse as sp
from numpy.typing import NDArray

from flangeway.geometry import Placement
from flangeway.problems import Elasticity, LinearBody
from flangeway.solve.body_loads import BodyLoads
from flangeway.types import Floats, Ints


@dataclass(frozen=True, eq=False)
class SurfaceNodes:
    """The nodes of one body where contact can happen.

    Parameters
    ----------
    body
        The body.
    nodes
        Its nodes, shape (n,), without repetition.
    shifts
        What leads from the nodes to the surface that they represent, in the body's frame, shape (n, 2); left out: the
        nodes are on it.

    """

    body: LinearBody
    nodes: NDArray[np.int32]
    shifts: Floats | None = None

    @property
    def points(self) -> Floats:
        """Points of the surface in the body's frame, shape (n, 2)."""
        points: Floats = self.body.nodes[self.nodes]
        return points if self.shifts is None else points + self.shifts


@dataclass(frozen=True, eq=False)
class Constrained:
    """Constraints of an iteration about displacements of the touched nodes, shape (2 n_touched,).

    Their gaps and slips (k,) are ``violations + jacobian (u - displacements) + compliances * forces``, and forces (k,)
    act along the ``directions``, both (k, 2 n_touched).
    """

    displacements: Floats
    jacobian: sp.csr_array
    directions: sp.csr_array
    compliances: Floats
    violations: Floats


class BodyResponse(ABC):
    """Answers of placed bodies to forces on their surface nodes; subclasses are final."""

    digits: float | None = None
    """Decimal digits that round-off leaves of displacements; None where they are not estimated."""

    def __init__(self, surfaces: Sequence[SurfaceNodes]) -> None:
        self.surfaces = tuple(surfaces)
        counts = [len(surface.nodes) for surface in self.surfaces]
        self.offsets: Ints = np.concatenate(([0], np.cumsum(counts))).astype(np.int64)
        self.body_of_node: Ints = np.repeat(np.arange(len(counts)), counts)
        self.n_nodes = int(self.offsets[-1])

    def rotations(self, placements: Sequence[Placement]) -> Floats:
        """Matrix of each surface node's body, shape (n_nodes, 2, 2)."""
        matrices = np.stack([placement.matrix for placement in placements])
        return matrices[self.body_of_node]

    def reference(self, placements: Sequence[Placement]) -> Floats:
        """Positions of the surface nodes before deformation, shape (n_nodes, 2)."""
        parts = [placement.points(surface.points) for surface, placement in zip(self.surfaces, placements, strict=True)]
        return np.concatenate(parts)

    def resultant(self, number: int, placement: Placement, pivot: Floats) -> Floats:  # noqa: ARG002 (no loads)
        """Force x, y and moment about a point of space of a placed body's loads, and its derivative by the angle."""
        return np.zeros(4)

    def problem(self, number: int, placement: Placement) -> Elasticity:  # noqa: ARG002 (no loads)
        """Elastic problem behind a body, with its loads as they act in its frame."""
        return self.surfaces[number].body.elasticity

    def turning(self, number: int, placement: Placement) -> Floats | None:  # noqa: ARG002 (no loads)
        """What a turn by 1 rad adds to the displacements by loads of a body's surface nodes, in space; None: nothing.

        Shape (n, 2). Times contact forces it is the moment of the loads at arms that are the displacements by these
        forces (Maxwell's and Betti's theorem).
        """
        return None

    @abstractmethod
    def displacements(self, rotations: Floats, touched: Ints, forces: Floats) -> Floats:
        """Displacements of all surface nodes under forces on some.

        Parameters
        ----------
        rotations
            From `rotations`.
        touched
            Surface nodes with the forces, rising, shape (n_touched,).
        forces
            Shape (n_touched, 2).

        Returns
        -------
        Floats
            Shape (n_nodes, 2).

        """

    @abstractmethod
    def respond(
        self, rotations: Floats, touched: Ints, geometric: sp.csr_array, loads: sp.csr_array, *, symmetric: bool = True
    ) -> Floats:
        """Solve ``(K + G) u = loads`` with both sides on the touched nodes.

        Parameters
        ----------
        rotations, touched
            As in `displacements`.
        geometric
            Stiffness G to be added on the touched nodes, shape (2 n_touched, 2 n_touched).
        loads
            Right-hand sides, shape (2 n_touched, m).
        symmetric
            Whether G is symmetric; with friction it is not.

        Returns
        -------
        Floats
            Displacements of the touched nodes, shape (2 n_touched, m).

        """

    def constrained(  # noqa: B027 (optional)
        self, rotations: Floats, touched: Ints, geometric: sp.csr_array, laws: Constrained
    ) -> tuple[Callable[[Ints, sp.csr_array], tuple[Floats, Floats]], Floats] | None:
        """Solve with constraints without a matrix of them all; None where that is not known.

        Parameters
        ----------
        rotations, touched, geometric
            As in `respond`.
        laws
            The constraints.

        Returns
        -------
        tuple or None
            A function of the rows (r,) of gaps and slips that vanish, and of what makes all forces of as many unknown
            ones, (k, r): all forces (k,), and all gaps and slips (k,). And an estimate of the displacement by a unit of
            each force, > 0, shape (k,).

        """

    @abstractmethod
    def fields(self, rotations: Floats, forces: Floats) -> list[Floats]:
        """Displacements of all nodes of each body in its own frame, each (n_dofs, 2).

        Parameters
        ----------
        rotations
            From `rotations`.
        forces
            Forces on all surface nodes, shape (n_nodes, 2).

        """

    @property
    @abstractmethod
    def n_unknowns(self) -> int:
        """Number of unknowns that an iteration works on."""


def turning(rotations: Floats) -> sp.csr_array:
    """Block-diagonal matrix that turns vectors on nodes from their bodies' axes into those of space.

    Parameters
    ----------
    rotations
        Matrix of each node's body, shape (n, 2, 2).

    """
    n = len(rotations)
    columns = np.repeat(np.arange(2 * n).reshape(n, 1, 2), 2, axis=1)
    starts = np.arange(0, 4 * n + 1, 2)
    return sp.csr_array((rotations.ravel(), columns.ravel(), starts), shape=(2 * n, 2 * n))


class LoadedBodies(BodyResponse):
    """Placed bodies with loads, which displace them before any contact force acts.

    The bodies are linear, so displacements by loads and by contact forces add: the contact meets surfaces that the
    loads have moved.

    Parameters
    ----------
    unloaded
        The bodies.
    loads
        Loads of each body, None for none.
    placements
        Placement of each body before handles moved it.
    share
        Factor on all loads.

    """

    def __init__(
        self,
        unloaded: BodyResponse,
        loads: Sequence[BodyLoads | None],
        placements: Sequence[Placement],
        share: float = 1.0,
    ) -> None:
        super().__init__(unloaded.surfaces)
        self.unloaded, self.share, self.digits = unloaded, share, unloaded.digits
        self._loads, self._given = tuple(loads), [placement.matrix for placement in placements]

    @property
    def n_unknowns(self) -> int:
        """See `BodyResponse.n_unknowns`."""
        return self.unloaded.n_unknowns

    def reference(self, placements: Sequence[Placement]) -> Floats:
        """See `BodyResponse.reference`; with the displacements by the loads."""
        result = self.unloaded.reference(placements)
        for i, (load, placement) in enumerate(zip(self._loads, placements, strict=True)):
            if load is not None:
                field = self.share * load.field(load.weights(placement.matrix, self._given[i]))
                nodes = slice(*self.offsets[i : i + 2].tolist())
                result[nodes] += placement.vectors(field[self.surfaces[i].nodes])
        return result

    def resultant(self, number: int, placement: Placement, pivot: Floats) -> Floats:
        """See `BodyResponse.resultant`."""
        if (load := self._loads[number]) is None:
            return np.zeros(4)
        weights = load.weights(placement.matrix, self._given[number])
        return load.resultant(weights, self.share, placement, pivot)

    def turning(self, number: int, placement: Placement) -> Floats | None:
        """See `BodyResponse.turning`."""
        if (load := self._loads[number]) is None:
            return None
        turned = np.array([[0.0, -1.0], [1.0, 0.0]]) @ placement.matrix
        field = self.share * load.field(load.weights(turned, self._given[number], 0.0))
        moved: Floats = placement.vectors(field[self.surfaces[number].nodes])
        return moved

    def problem(self, number: int, placement: Placement) -> Elasticity:
        """See `BodyResponse.problem`."""
        if (load := self._loads[number]) is None:
            return super().problem(number, placement)
        return load.problem(load.weights(placement.matrix, self._given[number]), self.share)

    def displacements(self, rotations: Floats, touched: Ints, forces: Floats) -> Floats:
        """See `BodyResponse.displacements`; those by the loads are in the bodies' reference."""
        return self.unloaded.displacements(rotations, touched, forces)

    def respond(
        self, rotations: Floats, touched: Ints, geometric: sp.csr_array, loads: sp.csr_array, *, symmetric: bool = True
    ) -> Floats:
        """See `BodyResponse.respond`."""
        return self.unloaded.respond(rotations, touched, geometric, loads, symmetric=symmetric)

    def constrained(
        self, rotations: Floats, touched: Ints, geometric: sp.csr_array, laws: Constrained
    ) -> tuple[Callable[[Ints, sp.csr_array], tuple[Floats, Floats]], Floats] | None:
        """See `BodyResponse.constrained`."""
        return self.unloaded.constrained(rotations, touched, geometric, laws)

    def fields(self, rotations: Floats, forces: Floats) -> list[Floats]:
        """See `BodyResponse.fields`; with the displacements by the loads."""
        found = self.unloaded.fields(rotations, forces)
        for i, load in enumerate(self._loads):
            if load is not None:
                found[i] = found[i] + self.share * load.field(load.weights(rotations[self.offsets[i]], self._given[i]))
        return found
