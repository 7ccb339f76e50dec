"""Fields inside a prism by forces on cells of its surface in three dimensions.

The forces of the strips are waves along z, whose amplitudes the prism answers one by one. The field at a section is the
integral over all wavenumbers; between those at which the prism is solved it is a spline, so that each of these carries
one load with the weights of the integral: ``sum over strips j of f_j (1 / pi) int phi_i(k) w(k) cos k(z - z_j) dk``.
"""

from collections.abc import Iterator
from concurrent.futures import ThreadPoolExecutor

import numpy as np

from flangeway._core import n_threads
from flangeway.problems.harmonic import Harmonic, at_wavenumber
from flangeway.solve.linear import cholesky
from flangeway.solve.surface_cells import SurfaceCells
from flangeway.solve.surface_compliance import inverse_weights
from flangeway.types import Floats

PER_DECADE = 8
"""Wavenumbers for each decade; twice as many change no stress by more than 1e-3 of the maximum pressure."""


def amplitudes(problem: Harmonic, wavenumbers: Floats, rhs: Floats) -> Iterator[Floats]:
    """Amplitudes (3 n_dofs, m) at each wavenumber, by loads (3 n_dofs, n_k, m), or (3 n_dofs, 1, m) at all of them."""
    free = problem.free(1.0).ravel()
    parts = [part.restricted(free) for part in problem.parts]
    groups = (np.flatnonzero(free) // 3).astype(np.int32)
    loads = np.broadcast_to(rhs[free], (int(free.sum()), len(wavenumbers), rhs.shape[2]))

    def answer(number: int) -> Floats:
        found = np.zeros((len(free), rhs.shape[2]))
        factor = cholesky(at_wavenumber(parts, wavenumbers[number]), groups)
        found[free] = factor.solve(np.ascontiguousarray(loads[:, number]))
        return found

    with ThreadPoolExecutor(n_threads()) as pool:
        yield from pool.map(answer, range(len(wavenumbers)))


def wave_sums(cells: SurfaceCells, forces: Floats, apart: Floats, strip: float, least: float) -> tuple[Floats, Floats]:
    """Sum the amplitudes of all wavenumbers at a section, and the amplitudes times their wavenumbers.

    Strains are linear in both, ``B0 u + k B1 u``: the sums give all stresses.

    Parameters
    ----------
    cells
        The cells.
    forces
        Forces along their outward normals, shape (n_cells, n_strips).
    apart
        The section's z less those of the middles of the strips, shape (n_strips,).
    strip
        Width of the strips.
    least
        Least wavenumber.

    Returns
    -------
    tuple
        Amplitudes of what varies as the cosine, and as the sine, each (2, n_dofs, 3): sum, and sum times wavenumber.

    """
    top = 2.0 * np.pi / strip
    wavenumbers = np.geomspace(least, top, int(np.ceil(PER_DECADE * np.log10(top / least))) + 1)
    even, odd = inverse_weights(wavenumbers, np.abs(apart), strip, averaged=1)
    problem, space = cells.problem, cells.problem.elasticity.space
    nodes, loads = cells.nodes_and_loads
    # f(i, cosine or sine): forces of the cells at the wavenumber i
    at_waves = np.stack((forces @ even, forces @ (np.sign(apart)[:, None] * odd)), axis=-1)
    rhs = np.zeros((3 * space.n_dofs, len(wavenumbers), 2))
    rhs[(3 * nodes[:, None] + np.arange(3)).ravel()] = np.einsum("nc,cki->nki", loads[:, 1::3], at_waves)
    sums = np.zeros((2, len(rhs), 2))
    for k, each in zip(wavenumbers.tolist(), amplitudes(problem, wavenumbers, rhs), strict=True):
        sums += np.stack((each, k * each))
    cosine, sine = np.moveaxis(sums.reshape(2, -1, 3, 2), -1, 0)
    return cosine, sine
