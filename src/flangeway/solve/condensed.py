"""Linear bodies condensed once to the flexibility of their surfaces, and the reference on all their unknowns."""

from collections.abc import Callable, Sequence
from functools import cached_property
from itertools import pairwise

import numpy as np
import scipy.sparse as sp
from numpy.typing import NDArray
from scipy.linalg import cho_factor, cho_solve
from scipy.sparse.linalg import splu

from flangeway._core import Cholesky
from flangeway.errors import InputError
from flangeway.geometry.arrays import components_of, starts_of
from flangeway.mesh.connectivity import connected
from flangeway.problems import Body, LinearBody
from flangeway.solve.body_response import BodyResponse, Constrained, SurfaceNodes, turning
from flangeway.solve.constraints import refuse_floating
from flangeway.solve.linear import (
    NO_UNKNOWNS,
    IndefiniteFactor,
    digits_left,
    factorise,
    indefinite,
    ldlt,
    relative_maximum,
)
from flangeway.solve.status import MIN_DIGITS, Status
from flangeway.space import SymmetricMatrix
from flangeway.space.symmetric import EPS
from flangeway.system.disk_cache import Cache, cached
from flangeway.system.memory_limits import refuse_beyond_memory
from flangeway.types import Floats, Ints

# --- Linear bodies condensed once to the flexibility of their surfaces.


DENSE_COPIES = 6
"""Dense matrices of the surface's unknowns that exist at a time while the flexibility is made."""


POWER_ITERATIONS = 3
"""Iterations until the softest displacement has 1e-6 of others, if these are a hundred times as stiff."""

ZERO_PIVOT = 1e-13
"""Pivot relative to the diagonal entry that it began as which rounding leaves of a zero, as in the sparse
factorisation."""


class CondensedBody:
    """Exact flexibility of a body's surface nodes with its held edges at rest.

    The Schur complement of the stiffness on the surface is the trailing block of its Cholesky factor; its inverse is
    kept. Nothing here depends on the placement of the body, so one condensation serves every position, and a mirrored
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
        arrays = cached(cache, self._computed, "flexibility", *body.content, surface.nodes)
        self.flexibility: NDArray[np.float64] = np.asarray(arrays["flexibility"], dtype=np.float64)
        self.flexibility.setflags(write=False)
        self.digits = float(arrays["digits"][0])
        """Decimal digits that round-off leaves of the body's softest displacement, `MIN_DIGITS` or more."""

    @cached_property
    def _factor(self) -> Cholesky:
        return factorise(self.body, self._numbers[self._loose])

    def _computed(self) -> dict[str, Floats]:
        n = len(self._loose)
        refuse_beyond_memory(f"the flexibility of a surface with {n} unknowns", DENSE_COPIES * 8 * n**2)
        stiffness = self.body.stiffness
        diagonal = stiffness.values[stiffness.indptr[self._numbers[self._loose]]]
        try:
            factor = cho_factor(self._factor.schur(), lower=True)
        except np.linalg.LinAlgError as error:
            raise indefinite(self.body) from error
        if (factor[0].diagonal() ** 2 <= max(ZERO_PIVOT, 2.0 * stiffness.n * EPS) * diagonal).any():
            raise indefinite(self.body)
        inverse = cho_solve(factor, np.eye(n))
        flexibility: Floats = np.zeros((len(self._numbers), len(self._numbers)))
        flexibility[np.ix_(self._loose, self._loose)] = (inverse + inverse.T) / 2.0
        return {"flexibility": flexibility, "digits": np.array([self._digits(inverse)])}

    def _digits(self, flexibility: Floats) -> float:
        """Digits of the displacement by the forces that it is largest for, found by power iteration."""
        forces = np.cos(np.arange(len(flexibility)))
        for _ in range(POWER_ITERATIONS):
            forces = flexibility @ (forces / np.abs(forces).max(initial=1.0))
        moved = self._factor.recover(flexibility @ forces, np.zeros(self._factor.n))
        product = self.body.product
        residual = -product.times(moved)
        residual[self._numbers[self._loose]] += forces
        change = relative_maximum(self._factor.solve(residual), moved)
        digits = digits_left(self._factor, product, moved, change)
        if digits < MIN_DIGITS:
            raise InputError(
                Status(False, f"the flexibility of body {self.body.name!r}", 0).with_digits(digits).message,
                "bodies whose displacements keep two digits or more",
                "take a thicker body, larger elements, or hold it in more places",
            )
        return digits

    def field(self, forces: Floats) -> Floats:
        """Displacements (n_dofs, 2) of all nodes under forces (n, 2) on the surface nodes, body's axes."""
        at_surface = (self.flexibility @ forces.ravel())[self._loose]
        return self.body.field(self._factor.recover(at_surface, np.zeros(self._factor.n)))


def condensed_bytes(surfaces: Sequence[SurfaceNodes]) -> int:
    """Bytes of the dense matrices of `CondensedBodies` at their peak: one that is made beside all that are kept."""
    counts = {(id(surface.body), surface.nodes.tobytes()): 2 * len(surface.nodes) for surface in surfaces}
    return 8 * (DENSE_COPIES * max(counts.values()) ** 2 + sum(n**2 for n in counts.values()))


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
        unique: dict[tuple[LinearBody, bytes], CondensedBody] = {}
        self._condensed: list[CondensedBody] = []
        for surface in self.surfaces:
            key = (surface.body, surface.nodes.tobytes())
            if key not in unique:
                unique[key] = CondensedBody(surface, cache)
            self._condensed.append(unique[key])
        self.digits = min(body.digits for body in self._condensed)
        self._asked: Ints = np.empty(0, dtype=np.int64)
        self._kept: list[tuple[slice, Floats]] = []

    def flexibility(self, number: int) -> Floats:
        """Displacements of a placed body's surface nodes by forces on them, body's axes, shape (2 n, 2 n)."""
        return self._condensed[number].flexibility

    @property
    def n_unknowns(self) -> int:
        """Components of the surface nodes' displacements."""
        return 2 * self.n_nodes

    def displacements(self, rotations: Floats, touched: Ints, forces: Floats) -> Floats:
        """See `BodyResponse.displacements`."""
        local = np.zeros((self.n_nodes, 2))
        local[touched] = np.matmul(forces[:, None], rotations[touched])[:, 0]
        parts = np.split(local.ravel(), 2 * self.offsets[1:-1])
        moved = [body.flexibility @ part for body, part in zip(self._condensed, parts, strict=True)]
        return np.matmul(rotations, np.concatenate(moved).reshape(-1, 2, 1))[..., 0]

    def tangent(
        self,
        rotations: Floats,
        touched: Ints,
        geometric: sp.csr_array,
        *,
        symmetric: bool = True,  # noqa: ARG002 (either)
    ) -> Callable[[sp.csr_array], Floats]:
        """See `BodyResponse.tangent`.

        With the flexibility F the solution is ``(I + F G)^-1 F loads``. G lives on the few unknowns b of loaded pairs,
        so by Woodbury's formula it is ``F loads - F[:, b] (I + G F)[b, b]^-1 (G F loads)[b]``, for each group of bodies
        that G links: both sides of a track yield apart. F is symmetric.
        """
        turn = turning(rotations[touched])  # the bodies' axes are those of the flexibilities
        geometric = sp.csr_array(turn.T @ geometric @ turn)
        blocks = self._blocks(touched)
        bent = np.flatnonzero(np.diff(geometric.indptr))
        owner = np.searchsorted([here.stop for here, _ in blocks], bent, side="right")
        inner = sp.csr_array(geometric[bent][:, bent])
        groups = connected(owner[np.stack(inner.tocoo().coords, axis=1)], len(blocks))
        bends = []
        for group in np.unique(groups[owner]):
            members = np.flatnonzero(groups[owner] == group)
            stiffness, matrix, bodies = inner[members][:, members], np.eye(len(members)), []
            for here, flexibility in (blocks[number] for number in np.flatnonzero(groups == group)):
                of_body = slice(*np.searchsorted(bent[members], (here.start, here.stop)).tolist())
                among = bent[members][of_body] - here.start
                matrix[:, of_body] += stiffness[:, of_body] @ flexibility[np.ix_(among, among)]
                bodies.append((here, of_body, flexibility[among]))
            bends.append((bent[members], stiffness, matrix, bodies))

        def solved(loads: sp.csr_array) -> Floats:
            loads, result = sp.csr_array(turn.T @ loads), np.zeros(loads.shape)
            for here, flexibility in blocks:
                result[here] = (sp.csc_array(loads[here].T) @ flexibility).T
            for at, stiffness, matrix, bodies in bends:
                columns = np.flatnonzero(result[at].any(axis=0))
                bend = np.linalg.solve(matrix, stiffness @ result[np.ix_(at, columns)])
                for here, of_body, rows in bodies:  # each body yields to its own forces alone
                    result[here, columns] -= rows.T @ bend[of_body]
            return turn @ result

        return solved

    def _fields_by_forces(self, rotations: Floats, forces: Floats) -> list[Floats]:
        local = np.matmul(forces[:, None], rotations)[:, 0]
        return [
            body.field(local[self.offsets[number] : self.offsets[number + 1]])
            for number, body in enumerate(self._condensed)
        ]

    def _blocks(self, touched: Ints) -> list[tuple[slice, Floats]]:
        """Components among the touched ones of each body that has some, and their flexibility in the body's axes.

        Those asked for last are kept: iterations at one place ask for the same ones again.
        """
        if not np.array_equal(touched, self._asked):
            self._asked, self._kept = touched, []
            for number, (first, last) in enumerate(pairwise(np.searchsorted(touched, self.offsets))):
                if first < last:
                    dofs = components_of(touched[first:last] - self.offsets[number]).ravel()
                    flexibility = self._condensed[number].flexibility[np.ix_(dofs, dofs)]
                    self._kept.append((slice(2 * first, 2 * last), flexibility))
        return self._kept


# --- Linear bodies on all their unknowns: the reference for the condensed way.


ENTRIES_AT_ONCE = 5_000_000
"""Numbers of right-hand sides that are solved together, so that loads on a long surface need no more memory."""

SURFACE_SOFTNESS = 4000.0
"""Displacement of a surface by forces on all its nodes relative to that of one node under its own force with all
others held: some number of nodes. Friction is found in the fewest guesses if it is too large rather than too
small."""


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
        self._starts = starts_of(sizes)
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
        return sp.csr_array(turning(rotations[touched]) @ self._chosen[components_of(touched).ravel()])

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
            return np.concatenate([spread @ factor.solve(right[:, block].toarray()) for block in columns], axis=1)

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
            solution = factor.solve(right)
            solution += factor.solve(right - system @ solution)  # one refinement: thin bodies leave 1e-10 without
            forces = np.asarray(spreading @ solution[size:])
            return forces, np.asarray(jacobian @ solution[:size] + offset + laws.compliances * forces)

        diagonal = SURFACE_SOFTNESS * np.asarray(jacobian.power(2) @ (1.0 / self._stiffness.diagonal()))
        return solved, diagonal + laws.compliances

    def _fields_by_forces(self, rotations: Floats, forces: Floats) -> list[Floats]:
        every = self._spread(rotations, np.arange(self.n_nodes))
        solution = self._undeformed.solve(every.T @ forces.ravel())
        return [
            surface.body.field(solution[start:end])
            for surface, start, end in zip(self.surfaces, self._starts[:-1], self._starts[1:], strict=True)
        ]

    def _factor(self, matrix: sp.sparray) -> IndefiniteFactor:
        return ldlt(SymmetricMatrix.from_full(matrix), self._groups)
