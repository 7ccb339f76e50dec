"""Linear bodies condensed once to the flexibility of their surfaces."""

from collections.abc import Sequence
from functools import cached_property

import numpy as np
import scipy.sparse as sp
from numpy.typing import NDArray
from scipy.linalg import cho_factor, cho_solve

from flangeway._core import Cholesky
from flangeway.problems import Body
from flangeway.solve.bodies import BodyResponse, SurfaceNodes, components, turning
from flangeway.solve.cache import Cache, content_key
from flangeway.solve.linear import factorise

Floats = NDArray[np.float64]
Ints = NDArray[np.int64]


class CondensedBody:
    """Exact flexibility of a body's surface nodes with its held edges at rest.

    The Schur complement of the stiffness on the surface is the trailing block of its Cholesky factor; its inverse is
    kept. Nothing here depends on where the body stands, so one condensation serves every position, and a mirrored
    twin as well.

    Parameters
    ----------
    surface
        The body and its surface nodes.
    cache
        Where flexibilities are kept from one process to the next. With one that is known, the body is factorised only
        when a field is asked for.

    """

    def __init__(self, surface: SurfaceNodes, cache: Cache | None = None) -> None:
        body = surface.body
        self.body = body
        self._numbers = body.free_numbers(surface.nodes)
        self._loose = np.flatnonzero(self._numbers >= 0)
        key = body_key("flexibility", body, surface.nodes) if cache is not None else None
        if cache is None or key is None:
            flexibility: NDArray[np.float64] = self._computed()["flexibility"]
        else:
            flexibility = cache.get(key, self._computed)["flexibility"]
        self.flexibility = np.asarray(flexibility, dtype=np.float64)
        self.flexibility.setflags(write=False)

    @cached_property
    def _factor(self) -> Cholesky:
        return factorise(self.body, self._numbers[self._loose])

    def _computed(self) -> dict[str, Floats]:
        factor = cho_factor(self._factor.schur(), lower=True)
        inverse = cho_solve(factor, np.eye(len(self._loose)))
        flexibility: Floats = np.zeros((len(self._numbers), len(self._numbers)))
        flexibility[np.ix_(self._loose, self._loose)] = (inverse + inverse.T) / 2.0
        return {"flexibility": flexibility}

    def field(self, forces: Floats) -> Floats:
        """Displacements (n_dofs, 2) of all nodes under forces (n, 2) on the surface nodes, body's axes."""
        at_surface = (self.flexibility @ forces.ravel())[self._loose]
        return self.body.field(self._factor.recover(at_surface, np.zeros(self._factor.n)))

    def fields(self, forces: Floats) -> Floats:
        """Displacements (m, n_dofs, 2) of all nodes under m loads (m, n, 2) on the surface nodes, body's axes."""
        at_surface = (self.flexibility @ forces.reshape(len(forces), -1).T)[self._loose]
        free = self._factor.recover(at_surface, np.zeros((self._factor.n, len(forces))))
        return np.stack([self.body.field(values) for values in free.T])


def body_key(kind: str, body: Body, *parts: object) -> str | None:
    """Key of what a body's mesh, elements, material, thickness and held edges determine, and some parts."""
    mesh = body.mesh
    return content_key(
        kind,
        mesh.points,
        mesh.cell_offsets,
        mesh.cell_points,
        {name: mesh.edge_sets[name] for name in body.supports if isinstance(name, str)},
        dict(mesh.cell_sets),
        body.element,
        body.material,
        dict(body.supports),
        body.thickness,
        *parts,
    )


class CondensedBodies(BodyResponse):
    """Placed bodies through the flexibilities of their surfaces.

    Parameters
    ----------
    surfaces
        Bodies with their surface nodes. A body that appears several times with the same nodes (as a twin placed
        elsewhere) is condensed once.
    cache
        See `CondensedBody`.

    """

    def __init__(self, surfaces: Sequence[SurfaceNodes], cache: Cache | None = None) -> None:
        super().__init__(surfaces)
        unique: dict[tuple[Body, bytes], CondensedBody] = {}
        self._condensed: list[CondensedBody] = []
        for surface in self.surfaces:
            key = (surface.body, surface.nodes.tobytes())
            if key not in unique:
                unique[key] = CondensedBody(surface, cache)
            self._condensed.append(unique[key])

    def flexibility(self, number: int) -> Floats:
        """Displacements of a placed body's surface nodes by forces on them, body's axes, shape (2 n, 2 n)."""
        return self._condensed[number].flexibility

    def body_fields(self, number: int, forces: Floats) -> Floats:
        """Displacements (m, n_dofs, 2) of a placed body under m loads (m, n, 2) on its surface nodes, body's axes."""
        return self._condensed[number].fields(forces)

    @property
    def n_unknowns(self) -> int:
        """Components of the surface nodes' displacements."""
        return 2 * self.n_nodes

    def displacements(self, rotations: Floats, touched: Ints, forces: Floats) -> Floats:
        """See `BodyResponse.displacements`."""
        local = turning(rotations[touched]).T @ forces.ravel()
        result = np.zeros(2 * self.n_nodes)
        for number, body in enumerate(self._condensed):
            here, columns = self._touched_of(number, touched)
            rows = slice(2 * self.offsets[number], 2 * self.offsets[number + 1])
            result[rows] = body.flexibility[:, columns] @ local[here]
        return (turning(rotations) @ result).reshape(-1, 2)

    def respond(self, rotations: Floats, touched: Ints, geometric: Floats, loads: sp.csr_array) -> Floats:
        """See `BodyResponse.respond`.

        With the flexibility F the solution is ``(I + F G)^-1 F loads``. G lives on the few unknowns of loaded pairs,
        so by Woodbury's formula only a system of their number is solved.
        """
        free = self._flex(rotations, touched, loads)
        bent = np.flatnonzero(geometric.any(axis=0))
        if len(bent) == 0:
            return free
        ones = (np.ones(len(bent)), (bent, np.arange(len(bent))))
        units = sp.csr_array(sp.coo_array(ones, shape=(len(geometric), len(bent))))
        columns = self._flex(rotations, touched, units)
        # each of its rows holds the few unknowns of a pair: sparse products cost nothing beside the solution
        inner = sp.csr_array(geometric[np.ix_(bent, bent)])
        matrix = inner @ columns[bent]
        matrix[np.diag_indices(len(bent))] += 1.0
        bend = np.linalg.solve(matrix, inner @ free[bent])
        for number in range(len(self._condensed)):  # each body yields to its own forces alone
            here, _ = self._touched_of(number, touched)
            mine = np.flatnonzero(np.isin(bent, here))
            free[here] -= columns[np.ix_(here, mine)] @ bend[mine]
        return free

    def fields(self, rotations: Floats, forces: Floats) -> list[Floats]:
        """See `BodyResponse.fields`."""
        local = (turning(rotations).T @ forces.ravel()).reshape(-1, 2)
        return [
            body.field(local[self.offsets[number] : self.offsets[number + 1]])
            for number, body in enumerate(self._condensed)
        ]

    def _touched_of(self, number: int, touched: Ints) -> tuple[Ints, Ints]:
        """Components among the touched ones of a body's nodes, and their columns in its flexibility."""
        here = np.flatnonzero(self.body_of_node[touched] == number)
        nodes = touched[here] - self.offsets[number]
        return components(here), components(nodes)

    def _flex(self, rotations: Floats, touched: Ints, loads: sp.csr_array) -> Floats:
        """Displacements of the touched nodes under loads on them, both (2 n_touched, m) in space."""
        turn = turning(rotations[touched])
        local = sp.csr_array(turn.T @ loads)
        result = np.zeros(local.shape)
        for number, body in enumerate(self._condensed):
            here, columns = self._touched_of(number, touched)
            result[here] = (local[here].T @ body.flexibility[np.ix_(columns, columns)]).T
        return turn @ result
