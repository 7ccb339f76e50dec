"""Newton's method for items: bodies, loads and laws of which it knows the residual, the tangent and the history.

Unknowns that linear items alone act on are condensed once, so that the iteration runs on the others.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np
import scipy.sparse as sp
from numpy.typing import NDArray

from flangeway._core import Cholesky, NotPositiveDefiniteError
from flangeway.errors import InputError
from flangeway.problems.items import Item
from flangeway.solve.linear import NO_UNKNOWNS, cholesky
from flangeway.solve.status import NewtonSettings, Status
from flangeway.space import SymmetricMatrix
from flangeway.types import Floats

MAX_DENSE = 3000
"""Unknowns of nonlinear items up to which the others are condensed: a dense matrix of 72 MB, solved in about 1 s."""


DEFAULTS = NewtonSettings(max_iterations=25, tolerance=1e-9)


@dataclass(frozen=True, eq=False)
class ItemSolution:
    """Equilibrium of items."""

    status: Status  # how the iteration ended
    state: Floats  # all unknowns, (n,)
    items: tuple[Item, ...]  # the items with the history of the state; as they were if the iteration did not converge
    reactions: Floats  # forces that hold the prescribed unknowns, zero elsewhere, (n,)
    residuals: tuple[float, ...]  # relative residual before the first and after each iteration


def solve_items(
    items: Sequence[Item],
    start: Floats,
    free: NDArray[np.bool_],
    settings: NewtonSettings = DEFAULTS,
    *,
    condense: bool = True,
) -> ItemSolution:
    """Find the state in which the residuals of all items add up to zero on the free unknowns.

    Parameters
    ----------
    items
        The items.
    start
        First state, with the prescribed values of the unknowns that are not free, shape (n,).
    free
        Which unknowns are free, shape (n,).
    settings
        Limits of the iteration; there are no corrections.
    condense
        Whether unknowns that linear items alone act on are condensed; the state found is the same.

    Returns
    -------
    ItemSolution
        Its status reports whether the iteration converged.

    Raises
    ------
    InputError
        If a free unknown has no stiffness at the start.

    """
    items = tuple(items)
    system = _System(items, np.array(start, dtype=np.float64), free, condense=condense)
    residuals = [system.relative_residual()]
    why = ""
    while residuals[-1] > settings.tolerance and len(residuals) <= settings.max_iterations:
        try:
            system.advance()
        except NotPositiveDefiniteError as error:
            unknown = int(system.free[int(error.args[1])])
            if len(residuals) == 1:
                raise _without_stiffness(unknown) from error
            why = f", the tangent is not positive definite at unknown {unknown}"
            break
        residuals.append(system.relative_residual())
    converged = bool(residuals[-1] <= settings.tolerance)
    n_iterations = len(residuals) - 1
    ended = f"converged in {n_iterations} iterations: the residual is {residuals[-1]:.1e} of the maximum force"
    if converged:
        items = tuple(item.commit(system.state[item.unknowns]) for item in items)
    status = Status(converged, ended if converged else f"not {ended}{why}; take smaller load steps", n_iterations)
    return ItemSolution(status, system.state, items, system.reactions(), tuple(residuals))


def _without_stiffness(unknown: int) -> InputError:
    return InputError(
        f"items without stiffness at unknown {unknown}",
        "a positive definite tangent on the free unknowns",
        "hold the unknown, or add an item with stiffness there",
    )


class _System:
    """Linear items as one matrix, factorised once where it can be, and the state of the iteration."""

    def __init__(self, items: tuple[Item, ...], state: Floats, free: NDArray[np.bool_], *, condense: bool) -> None:
        self.state, self.free = state, np.flatnonzero(free)
        self.nonlinear = [item for item in items if not item.linear]
        linear = [item for item in items if item.linear]
        at_zero = [(item, np.zeros(len(item.unknowns))) for item in linear]
        self.stiffness = self._assembled(at_zero)
        self.load = np.zeros(len(state))
        for item, zero in at_zero:
            self.load[item.unknowns] -= item.residual(zero)
        touched = np.zeros(len(state), dtype=np.bool_)
        for item in self.nonlinear:
            touched[item.unknowns] = True
        # unknowns of nonlinear items among the free ones, where condensation pays
        self.kept = np.flatnonzero(touched[self.free])
        self.condenses = condense and len(self.kept) <= MAX_DENSE and len(self.kept) < len(self.free)

    def relative_residual(self) -> float:
        """Maximum residual of a free unknown over the maximum force on any."""
        residual, maximum = self._residual()
        return float(np.abs(residual[self.free]).max(initial=0.0)) / (maximum or 1.0)

    def reactions(self) -> Floats:
        """Forces that hold the prescribed unknowns."""
        held = self._residual()[0]
        held[self.free] = 0.0
        return held

    def advance(self) -> None:
        """Take one step of Newton's method."""
        right = -self._residual()[0][self.free]
        tangent = self._assembled([(item, self.state[item.unknowns]) for item in self.nonlinear])
        tangent = tangent[self.free][:, self.free]
        if not self.condenses:
            self.state[self.free] += self._factor(self._free_stiffness + tangent).solve(right)
        elif len(self.kept) == 0:
            self.state[self.free] += self._condensed[0].solve(right)
        else:
            factor, schur = self._condensed
            at_kept = np.linalg.solve(schur + tangent[self.kept][:, self.kept].toarray(), factor.condense(right))
            self.state[self.free] += factor.recover(at_kept, right)

    def _residual(self) -> tuple[Floats, float]:
        """Residual of all unknowns, and the maximum force on one."""
        internal = self.stiffness @ self.state
        total = internal - self.load
        maximum = max(np.abs(internal).max(initial=0.0), np.abs(self.load).max(initial=0.0))
        for item in self.nonlinear:
            forces = item.residual(self.state[item.unknowns])
            total[item.unknowns] += forces
            maximum = max(maximum, np.abs(forces).max(initial=0.0))
        return total, float(maximum)

    def _assembled(self, parts: Sequence[tuple[Item, Floats]]) -> sp.csr_array:
        """Sum of the tangents of items at their states, shape (n, n)."""
        n = len(self.state)
        total = sp.csr_array((n, n))
        for item, state in parts:
            tangent, numbers = sp.coo_array(item.tangent(state)), item.unknowns
            total = total + sp.coo_array((tangent.data, (numbers[tangent.row], numbers[tangent.col])), shape=(n, n))
        return sp.csr_array(total)

    @cached_property
    def _free_stiffness(self) -> sp.csr_array:
        return self.stiffness[self.free][:, self.free]

    @cached_property
    def _condensed(self) -> tuple[Cholesky, Floats]:
        """Factor of the linear items' stiffness, and what is left of it on the kept unknowns.

        The kept ones may have no stiffness of linear items: they get some before and lose it after the factorisation.
        """
        added = np.zeros(len(self.free))
        added[self.kept] = self._free_stiffness.diagonal().max(initial=1.0)
        factor = self._factor(self._free_stiffness + sp.diags_array(added), self.kept.astype(np.int32))
        return factor, factor.schur() - np.diag(added[self.kept])

    def _factor(self, matrix: sp.sparray, trailing: NDArray[np.int32] = NO_UNKNOWNS) -> Cholesky:
        numbers = np.arange(matrix.shape[0], dtype=np.int32)
        entries = sp.coo_array(matrix)
        # the factorisation wants every diagonal entry to be present, zeros too
        data = np.concatenate((entries.data, np.zeros(len(numbers))))
        places = (np.concatenate((entries.row, numbers)), np.concatenate((entries.col, numbers)))
        full = sp.csc_array(sp.coo_array((data, places), shape=matrix.shape))
        return cholesky(SymmetricMatrix.from_full(full), numbers, trailing)
