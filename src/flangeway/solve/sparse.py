"""Linear bodies on all their unknowns: the reference for the condensed way."""

from collections.abc import Callable, Sequence

import numpy as np
import scipy.sparse as sp
from scipy.sparse.linalg import splu

from flangeway._core import Ldlt
from flangeway.problems import Body
from flangeway.solve.body_response import BodyResponse, Constrained, SurfaceNodes, turning
from flangeway.solve.constraints import components
from flangeway.solve.free_motions import refuse_floating
from flangeway.solve.linear import NO_UNKNOWNS, factorise, ldlt
from flangeway.space import SymmetricMatrix
from flangeway.types import Floats, Ints

ENTRIES_AT_ONCE = 5_000_000
"""Numbers of right-hand sides that are solved together, so that loads on a long surface need no more memory."""

YIELDING = 4000.0
"""Displacement of a surface by forces on all its nodes over that of one node under its own force with all others held:
some number of nodes. Friction is found in the fewest guesses if it is too large rather than too small."""


class SparseBodies(BodyResponse):
    """Placed bodies through sparse factorisations of all free unknowns, anew for every tangent.

    Parameters
    ----------
    surfaces
        Bodies with their surface nodes.

    Raises
    ------
    InputError
        If what is held of a body leaves a motion free.

    """

    def __init__(self, surfaces: Sequence[SurfaceNodes]) -> None:
        super().__init__(surfaces)
        for body in dict.fromkeys(surface.body for surface in self.surfaces):
            refuse_floating(body)
            if not isinstance(body, Body):  # what is not held of a mesh leaves rigid motions free, and no others
                factorise(body, NO_UNKNOWNS)
        blocks = [surface.body.stiffness.full() for surface in self.surfaces]
        sizes = [block.shape[0] for block in blocks]
        self._starts = np.concatenate(([0], np.cumsum(sizes)))
        self._stiffness = sp.csr_array(sp.block_diag(blocks, format="csr"))
        unknowns = []
        for surface, start in zip(self.surfaces, self._starts[:-1], strict=True):
            numbers = surface.body.free_numbers(surface.nodes)
            unknowns.append(np.where(numbers >= 0, start + numbers, -1))
        numbers = np.concatenate(unknowns)
        free = np.flatnonzero(numbers >= 0)
        shape = len(numbers), self.n_unknowns
        self._chosen = sp.csr_array((np.ones(len(free)), (free, numbers[free])), shape=shape)
        groups, first = [], 0
        for surface in self.surfaces:
            groups.append(first + surface.body.free_nodes)
            first += len(surface.body.free) // 2
        self._groups = np.concatenate(groups).astype(np.int32)
        self._undeformed = self._factor(self._stiffness)

    @property
    def n_unknowns(self) -> int:
        """Free unknowns of all bodies."""
        return int(self._starts[-1])

    def _spread(self, rotations: Floats, touched: Ints) -> sp.csr_array:
        """Displacements of the touched nodes in space by the free unknowns, shape (2 n_touched, n_unknowns)."""
        return sp.csr_array(turning(rotations[touched]) @ self._chosen[components(touched)])

    def displacements(self, rotations: Floats, touched: Ints, forces: Floats) -> Floats:
        """See `BodyResponse.displacements`."""
        loads = self._spread(rotations, touched).T @ forces.ravel()
        every = self._spread(rotations, np.arange(self.n_nodes))
        return np.asarray(every @ self._undeformed.solve(loads)).reshape(-1, 2)

    def tangent(
        self, rotations: Floats, touched: Ints, geometric: sp.csr_array, *, symmetric: bool = True
    ) -> Callable[[sp.csr_array], Floats]:
        """See `BodyResponse.tangent`."""
        spread, at_once = self._spread(rotations, touched), max(1, ENTRIES_AT_ONCE // self.n_unknowns)
        tangent = self._stiffness + spread.T @ geometric @ spread
        factor = self._factor(tangent) if symmetric else splu(sp.csc_array(tangent))

        def solved(loads: sp.csr_array) -> Floats:
            right = sp.csc_array(spread.T @ loads)
            columns = (slice(first, first + at_once) for first in range(0, right.shape[1], at_once))
            return np.concatenate([spread @ factor.solve(right[:, each].toarray()) for each in columns], axis=1)

        return solved

    def constrained(
        self, rotations: Floats, touched: Ints, geometric: sp.csr_array, laws: Constrained
    ) -> tuple[Callable[[Ints, sp.csr_array], tuple[Floats, Floats]], Floats]:
        """See `BodyResponse.constrained`: bodies and constraints in one sparse factorisation for each guess."""
        size, spread = self.n_unknowns, self._spread(rotations, touched)
        tangent = self._stiffness + spread.T @ geometric @ spread
        jacobian, directions = sp.csr_array(laws.jacobian @ spread), sp.csr_array(laws.directions @ spread)
        load = spread.T @ (geometric @ laws.displacements)
        offset = laws.violations - laws.jacobian @ laws.displacements

        def solved(rows: Ints, spreading: sp.csr_array) -> tuple[Floats, Floats]:
            by_forces = -(directions.T @ spreading)
            softness = (sp.diags_array(laws.compliances) @ spreading)[rows]
            system = sp.block_array([[tangent, by_forces], [jacobian[rows], softness]], format="csc")
            right, factor = np.concatenate((load, -offset[rows])), splu(system)
            found = factor.solve(right)
            found += factor.solve(right - system @ found)  # one refinement: thin bodies leave 1e-10 without
            forces = np.asarray(spreading @ found[size:])
            return forces, np.asarray(jacobian @ found[:size] + offset + laws.compliances * forces)

        own = YIELDING * np.asarray(jacobian.power(2) @ (1.0 / self._stiffness.diagonal()))
        return solved, own + laws.compliances

    def _fields_by_forces(self, rotations: Floats, forces: Floats) -> list[Floats]:
        every = self._spread(rotations, np.arange(self.n_nodes))
        solution = self._undeformed.solve(every.T @ forces.ravel())
        return [
            surface.body.field(solution[start:end])
            for surface, start, end in zip(self.surfaces, self._starts[:-1], self._starts[1:], strict=True)
        ]

    def _factor(self, matrix: sp.sparray) -> Ldlt:
        return ldlt(SymmetricMatrix.from_full(matrix), self._groups)
