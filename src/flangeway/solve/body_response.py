"""How a set of placed linear bodies answers to forces on its surface nodes.

Two ways give the same answers: `CondensedBodies` works on the surfaces alone, `SparseBodies` on all unknowns. The
iteration for contact uses only `BodyResponse`.

The surface nodes of all bodies are numbered one after the other; vectors on them have shape (n_nodes, 2) and the
axes of space.
"""

from abc import ABC, abstractmethod
from collections.abc import Callable, Sequence
from copy import copy
from dataclasses import dataclass
from typing import Self

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

    def of(self, rows: Ints) -> "Constrained":
        """Some of the constraints."""
        return Constrained(
            self.displacements,
            sp.csr_array(self.jacobian[rows]),
            sp.csr_array(self.directions[rows]),
            self.compliances[rows],
            self.violations[rows],
        )


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
        self._loads: dict[int, tuple[BodyLoads, Floats, float]] = {}

    def rotations(self, placements: Sequence[Placement]) -> Floats:
        """Matrix of each surface node's body, shape (n_nodes, 2, 2)."""
        matrices = np.stack([placement.matrix for placement in placements])
        return matrices[self.body_of_node]

    def loaded(self, loads: Sequence[BodyLoads | None], placements: Sequence[Placement], share: float) -> Self:
        """The same bodies with a share of loads, which displace them before any contact force acts.

        The bodies are linear, so displacements by loads and by contact forces add: the contact meets surfaces that the
        loads have moved. ``loads`` are those of each body, None for none, at ``placements`` before handles moved it.
        """
        result = copy(self)
        result._loads = {
            number: (load, placement.matrix, share)
            for number, (load, placement) in enumerate(zip(loads, placements, strict=True))
            if load is not None
        }
        return result

    def _by_loads(self, number: int, matrix: Floats, constant: float = 1.0) -> Floats:
        """Displacements (n_dofs, 2) of a body by its loads, in its frame; arguments as of `BodyLoads.weights`."""
        load, given, share = self._loads[number]
        return share * load.field(load.weights(matrix, given, constant))

    def reference(self, placements: Sequence[Placement]) -> Floats:
        """Positions of the surface nodes before contact deforms the bodies, shape (n_nodes, 2)."""
        parts = []
        for number, (surface, placement) in enumerate(zip(self.surfaces, placements, strict=True)):
            parts.append(placement.points(surface.points))
            if number in self._loads:
                moved = self._by_loads(number, placement.matrix)[surface.nodes]
                parts[-1] = parts[-1] + placement.vectors(moved)
        return np.concatenate(parts)

    def resultant(self, number: int, placement: Placement, pivot: Floats) -> Floats:
        """Force x, y and moment about a point of space of a placed body's loads, and its derivative by the angle."""
        if number not in self._loads:
            return np.zeros(4)
        load, given, share = self._loads[number]
        return load.resultant(load.weights(placement.matrix, given), share, placement, pivot)

    def problem(self, number: int, placement: Placement) -> Elasticity:
        """Elastic problem behind a body, with its loads as they act in its frame."""
        if number not in self._loads:
            return self.surfaces[number].body.elasticity
        load, given, share = self._loads[number]
        return load.problem(load.weights(placement.matrix, given), share)

    def turning(self, number: int, placement: Placement) -> Floats | None:
        """What a turn by 1 rad adds to the displacements by loads of a body's surface nodes, in space; None: nothing.

        Shape (n, 2). Times contact forces it is the moment of the loads at arms that are the displacements by these
        forces (Maxwell's and Betti's theorem).
        """
        if number not in self._loads:
            return None
        field = self._by_loads(number, np.array([[0.0, -1.0], [1.0, 0.0]]) @ placement.matrix, 0.0)
        return placement.vectors(field[self.surfaces[number].nodes])

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
    def tangent(
        self, rotations: Floats, touched: Ints, geometric: sp.csr_array, *, symmetric: bool = True
    ) -> Callable[[sp.csr_array], Floats]:
        """Solve ``(K + G) u = loads`` with both sides on the touched nodes.

        Parameters
        ----------
        rotations, touched
            As in `displacements`.
        geometric
            Stiffness G to be added on the touched nodes, shape (2 n_touched, 2 n_touched).
        symmetric
            Whether G is symmetric; with friction it is not.

        Returns
        -------
        Callable
            Called with loads, right-hand sides of shape (2 n_touched, m): displacements of the touched nodes, shape
            (2 n_touched, m).

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

    def fields(self, rotations: Floats, forces: Floats) -> list[Floats]:
        """Displacements of all nodes of each body in its own frame, by forces and loads, each (n_dofs, 2).

        Parameters
        ----------
        rotations
            From `rotations`.
        forces
            Forces on all surface nodes, shape (n_nodes, 2).

        """
        result = self._fields_by_forces(rotations, forces)
        for number in self._loads:
            result[number] = result[number] + self._by_loads(number, rotations[self.offsets[number]])
        return result

    @abstractmethod
    def _fields_by_forces(self, rotations: Floats, forces: Floats) -> list[Floats]:
        """Those of `fields` by the forces alone."""

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
