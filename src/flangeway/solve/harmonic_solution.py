"""Solution of prisms and bodies of revolution at one wavenumber."""

from dataclasses import dataclass

import numpy as np
import scipy.sparse as sp

from flangeway._core import NotPositiveDefiniteError
from flangeway.errors import InputError
from flangeway.problems.harmonic import Harmonic
from flangeway.solve.linear import solve_linear
from flangeway.solve.status import Status
from flangeway.space import SymmetricMatrix
from flangeway.types import Bools, Floats


@dataclass(frozen=True, eq=False)
class HarmonicSolution:
    """Amplitudes of the displacements at one wavenumber.

    Parameters
    ----------
    problem
        What was solved.
    wavenumber
        Wavenumber k of a prism, or harmonic n of a body of revolution.
    amplitudes
        U, V, W of all unknowns, shape (n_dofs, 3); see `flangeway.problems.harmonic`.
    energy
        Strain energy over a quarter wave's mean of ``cos^2`` (1 / 2): ``f . u / 2`` of the amplitudes, with the
        foundations'.
    status
        How the computation ended.

    """

    problem: Harmonic
    wavenumber: float
    amplitudes: Floats
    energy: float
    status: Status

    def displacements(self, along: float) -> Floats:
        """Displacements of all nodes at a place z (or angle t), shape (n_nodes, 3)."""
        return self.amplitudes[: self.problem.elasticity.space.n_nodes] * self._phases(along, 2, 1)

    def stresses(self, along: float) -> Floats:
        """Stresses at all cells' centres of gravity at a place z (or angle t), shape (n_cells, 6), see `NAMES`."""
        space = self.problem.elasticity.space
        result = np.empty((space.mesh.n_cells, 6))
        for batch in space.batches():
            polynomials = self.problem.cell_stresses(batch, self.amplitudes, self.wavenumber)[1]
            result[batch.cells] = polynomials[:, 0].T  # their frames have their origins there
        return result * self._phases(along, 4, 2)

    def _phases(self, along: float, n_even: int, n_odd: int) -> Floats:
        """Cosine for the even components, sine for the others that follow."""
        phase = self.wavenumber * along
        return np.repeat([np.cos(phase), np.sin(phase)], [n_even, n_odd])


def solve_harmonic(problem: Harmonic, wavenumber: float) -> HarmonicSolution:
    """Solve for the amplitudes at one wavenumber.

    At wavenumber 0 the displacements in the plane and those along z do not act on each other. What is not loaded then
    stays at rest, so that it needs no support.

    Parameters
    ----------
    problem
        Body, loads and supports.
    wavenumber
        Wavenumber k >= 0 of a prism, per length; whole number n >= 0 for a body of revolution.

    Raises
    ------
    InputError
        If the wavenumber is wrong, or the body can move without strain.

    """
    if not (np.isfinite(wavenumber) and wavenumber >= 0.0) or (problem.revolution and wavenumber != round(wavenumber)):
        raise InputError(
            f"the wavenumber {wavenumber}",
            "a whole number >= 0 of waves around the axis" if problem.revolution else "a finite number >= 0",
            "sum the solutions of several",
        )
    load = problem.load_vector()
    free = problem.free(wavenumber)
    if wavenumber == 0.0:
        free[:, :2] &= bool(load[:, :2].any())
        free[:, 2] &= bool(load[:, 2].any())
    matrix = problem.stiffness(wavenumber)
    transform = _transform(problem, free, wavenumber)
    if transform is None:
        reduced, rhs = matrix.restricted(free.ravel()), load[free]
    else:
        reduced = SymmetricMatrix.from_full(sp.csr_array(transform.T @ matrix.full() @ transform))
        rhs = transform.T @ load.ravel()
    try:
        values, status = solve_linear(reduced, (np.flatnonzero(free) // 3).astype(np.int32), rhs)
    except NotPositiveDefiniteError as error:
        unknown = int(np.flatnonzero(free)[int(error.args[1])])
        raise InputError(
            f"body `{problem.elasticity.name}` at wavenumber {wavenumber:g}: it can move along "
            f"{'xyz'[unknown % 3]} without force",
            "a body that is held, or on a foundation, in every direction in which it is loaded",
            "give held=... or foundations=...",
        ) from error
    amplitudes = np.zeros(load.shape)
    if transform is None:
        amplitudes[free] = values
    else:
        amplitudes[:] = (transform @ values).reshape(-1, 3)
    return HarmonicSolution(problem, wavenumber, amplitudes, 0.5 * float(np.sum(load * amplitudes)), status)


def _transform(problem: Harmonic, free: Bools, wavenumber: float) -> sp.csr_array | None:
    """All amplitudes by the free ones, where a motion of the axis couples two of them (n = 1); else None."""
    if not problem.revolution or wavenumber != 1 or len(problem.axis_nodes) == 0:
        return None
    numbers = np.cumsum(free.ravel()) - 1
    at = np.flatnonzero(free)
    moved = problem.axis_nodes[free[problem.axis_nodes, 0]]
    rows = np.concatenate((at, 3 * moved + 2))
    columns = np.concatenate((numbers[at], numbers[3 * moved]))
    values = np.concatenate((np.ones(len(at)), -np.ones(len(moved))))
    return sp.csr_array(sp.coo_array((values, (rows, columns)), shape=(free.size, len(at))))
