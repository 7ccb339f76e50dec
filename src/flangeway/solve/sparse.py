"""Linear bodies on all their unknowns: the reference for the condensed way."""

from collections.abc import Sequence

import numpy as np
import scipy.sparse as sp
from numpy.typing import NDArray

from flangeway._core import Ldlt
from flangeway.solve.bodies import BodyResponse, SurfaceNodes, to_bodies, to_space
from flangeway.space import SymmetricMatrix

Floats = NDArray[np.float64]
Ints = NDArray[np.int64]


class SparseBodies(BodyResponse):
    """Placed bodies through sparse factorisations of all free unknowns, anew for every tangent.

    Parameters
    ----------
    surfaces
        Bodies with their surface nodes.

    """

    def __init__(self, surfaces: Sequence[SurfaceNodes]) -> None:
        super().__init__(surfaces)
        blocks = [surface.body.stiffness.full() for surface in self.surfaces]
        sizes = [block.shape[0] for block in blocks]
        self._starts = np.concatenate(([0], np.cumsum(sizes)))
        self._stiffness = sp.csr_array(sp.block_diag(blocks, format="csr"))
        unknowns = [
            start + surface.body.free_numbers(surface.nodes).reshape(-1, 2)
            for surface, start in zip(self.surfaces, self._starts[:-1], strict=True)
        ]
        self._unknowns: Ints = np.concatenate(unknowns).astype(np.int64)
        groups, first = [], 0
        for surface in self.surfaces:
            groups.append(first + surface.body.free_nodes)
            first += surface.body.space.n_dofs
        self._groups = np.concatenate(groups).astype(np.int32)

    @property
    def n_unknowns(self) -> int:
        """Free unknowns of all bodies."""
        return int(self._starts[-1])

    def displacements(self, rotations: Floats, touched: Ints, forces: Floats) -> Floats:
        """See `BodyResponse.displacements`."""
        local = np.zeros((self.n_nodes, 2))
        local[touched] = to_bodies(rotations[touched], forces)
        return to_space(rotations, self._solve(self._stiffness, local)[self._unknowns])

    def respond(self, rotations: Floats, touched: Ints, geometric: Floats, loads: Floats) -> Floats:
        """See `BodyResponse.respond`."""
        matrix, n = rotations[touched], len(touched)
        local = np.einsum("mji,mjnk,nkl->minl", matrix, geometric.reshape(n, 2, n, 2), matrix)
        unknowns = self._unknowns[touched].ravel()
        places = np.broadcast_to(unknowns, (2 * n, 2 * n))
        size = self.n_unknowns
        added = sp.coo_array((local.ravel(), (places.T.ravel(), places.ravel())), shape=(size, size))
        rhs = np.zeros((size, loads.shape[1]))
        rhs[unknowns] = to_bodies(matrix, loads.reshape(n, 2, -1)).reshape(2 * n, -1)
        solution = self._factor(self._stiffness + added).solve(rhs)
        at_nodes = solution[unknowns].reshape(n, 2, -1)
        return to_space(matrix, at_nodes).reshape(2 * n, -1)

    def fields(self, rotations: Floats, forces: Floats) -> list[Floats]:
        """See `BodyResponse.fields`."""
        solution = self._solve(self._stiffness, to_bodies(rotations, forces))
        fields = []
        for surface, start, end in zip(self.surfaces, self._starts[:-1], self._starts[1:], strict=True):
            field = np.zeros(len(surface.body.free))
            field[surface.body.free] = solution[start:end]
            fields.append(field.reshape(-1, 2))
        return fields

    def _factor(self, matrix: sp.sparray) -> Ldlt:
        lower = SymmetricMatrix.from_full(matrix)
        return Ldlt(lower.indptr, lower.indices, lower.values, self._groups)

    def _solve(self, matrix: sp.csr_array, at_nodes: Floats) -> Floats:
        rhs = np.zeros(self.n_unknowns)
        rhs[self._unknowns] = at_nodes
        solution: Floats = self._factor(matrix).solve(rhs)
        return solution
