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
from flangeway.problems import LinearBody
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


def components(nodes: Ints) -> Ints:
    """Numbers of the two components of nodes, one node after the other, shape (2 n,)."""
    return (2 * nodes[:, None] + np.arange(2)).ravel()


class LoadedBodies(BodyResponse):
    """Placed bodies with displacements that are there before any contact force acts.

    The bodies are linear, so displacements by loads and by contact forces add: the contact meets surfaces that the
    loads have moved. The fields, displacements of each body under its loads and prescribed displacements without
    contact, in its own frame (n_dofs, 2), or None, are multiplied with `share`. Loads keep their direction in the
    bodies' frames.
    """

    def __init__(self, unloaded: BodyResponse, fields: Sequence[Floats | None], share: float = 1.0) -> None:
        super().__init__(
            [
                surface if field is None else _moved(surface, share * field)
                for surface, field in zip(unloaded.surfaces, fields, strict=True)
            ]
        )
        self._unloaded, self._fields, self._share = unloaded, tuple(fields), share

    @property
    def n_unknowns(self) -> int:
        """See `BodyResponse.n_unknowns`."""
        return self._unloaded.n_unknowns

    def displacements(self, rotations: Floats, touched: Ints, forces: Floats) -> Floats:
        """See `BodyResponse.displacements`; those by the loads are in the bodies' reference."""
        return self._unloaded.displacements(rotations, touched, forces)

    def respond(
        self, rotations: Floats, touched: Ints, geometric: sp.csr_array, loads: sp.csr_array, *, symmetric: bool = True
    ) -> Floats:
        """See `BodyResponse.respond`."""
        return self._unloaded.respond(rotations, touched, geometric, loads, symmetric=symmetric)

    def constrained(
        self, rotations: Floats, touched: Ints, geometric: sp.csr_array, laws: Constrained
    ) -> tuple[Callable[[Ints, sp.csr_array], tuple[Floats, Floats]], Floats] | None:
        """See `BodyResponse.constrained`."""
        return self._unloaded.constrained(rotations, touched, geometric, laws)

    def fields(self, rotations: Floats, forces: Floats) -> list[Floats]:
        """See `BodyResponse.fields`; with the displacements by the loads."""
        return [
            found if field is None else found + self._share * field
            for found, field in zip(self._unloaded.fields(rotations, forces), self._fields, strict=True)
        ]


def _moved(surface: SurfaceNodes, field: Floats) -> SurfaceNodes:
    shifts = field[surface.nodes]
    return SurfaceNodes(surface.body, surface.nodes, shifts if surface.shifts is None else surface.shifts + shifts)
