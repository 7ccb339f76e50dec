"""Solution of linear systems and eigenproblems of forms, through one kept factorisation."""

from typing import Any, Protocol

import numpy as np
import scipy.sparse as sp
from numpy.typing import ArrayLike, NDArray
from scipy.sparse.linalg import LinearOperator, eigsh

from flangeway.checks import check_integer
from flangeway.errors import InputError
from flangeway.solve.factor import Factor
from flangeway.types import Bools, Floats, Indices

MAX_EIGEN_RESIDUAL = 1e-9
"""Residual of eigenvectors relative to the magnitudes of its terms, above their round-off."""
EIGEN_SHIFT = 1e-6
"""Shift of eigenvalues relative to the ratio of the traces, so that free bodies are no exception."""


class Unknowns(Protocol):
    """What eigenproblems ask of a `Space`, a `Plate` or an element of your own."""

    @property
    def n_dofs(self) -> int: ...  # noqa: D102


def solve(
    matrix: sp.sparray, load: ArrayLike, fixed: Indices | Bools | None = None, values: ArrayLike = 0.0
) -> NDArray[Any]:
    """Solve a linear system with some unknowns prescribed; `Factor` keeps the factorisation for more solutions.

    Parameters
    ----------
    matrix
        Sum of forms, shape (m n_dofs, m n_dofs), symmetric or not, real or complex.
    load
        Right-hand side, shape (n_dofs,) or (n_dofs, m).
    fixed
        Unknowns of one field that are prescribed, see `Space.boundary_dofs`: all their components. Or truth values of
        the load's shape.
    values
        Their values: a number, or an array of the load's shape, such as from `interpolate`; others are ignored.

    Returns
    -------
    Floats, or complex numbers if the matrix, the load or a value is complex
        All unknowns, shape of the load.

    Raises
    ------
    InputError
        If the matrix does not fit the load, or is singular: the message names the motion without energy.

    Warns
    -----
    scipy.linalg.LinAlgWarning
        If fewer than four digits of the solution are right.

    """
    given = np.asarray(load)
    return Factor(matrix, fixed, 1 if given.ndim == 1 else given.shape[1]).solve(given, values)


def modes(
    space: Unknowns,
    stiffness: sp.sparray,
    mass: sp.sparray,
    number: int = 6,
    fixed: Indices | Bools | None = None,
) -> tuple[Floats, Floats]:
    """Lowest eigenvalues of ``K u = lambda M u``: free vibration with the angular frequencies ``sqrt(lambda)``.

    Parameters
    ----------
    space
        The space, or a `Plate`.
    stiffness, mass
        Symmetric, the mass positive; see `stiffness` and `mass`.
    number
        Number of eigenvalues.
    fixed
        Unknowns that are zero, see `solve`.

    Returns
    -------
    tuple of Floats
        Eigenvalues (number,) in rising order, and modes (number, n_dofs) or (number, n_dofs, m), ``u . M u = 1``.

    Raises
    ------
    InputError
        If a matrix is complex or not symmetric, or the mass not positive.

    """
    shift = -EIGEN_SHIFT * stiffness.trace() / mass.trace()
    free, inverse, parts = _reduced(space, stiffness - shift * mass, (stiffness, mass), fixed, number, "modes")
    values, vectors = eigsh(
        parts[0], number, parts[1], sigma=shift, OPinv=inverse, v0=np.ones(len(parts[0].indptr) - 1)
    )
    _check_residuals(parts[0], parts[1], values, vectors)
    return _sorted(values, vectors, free, space)


def buckling(
    space: Unknowns,
    stiffness: sp.sparray,
    geometric: sp.sparray,
    number: int = 1,
    fixed: Indices | Bools | None = None,
) -> tuple[Floats, Floats]:
    """Lowest positive load factors of ``(K + lambda G) u = 0``: linear buckling.

    Parameters
    ----------
    space
        The space, or a `Plate`.
    stiffness
        Symmetric and, with the fixed unknowns, positive definite.
    geometric
        Geometric stiffness of the reference load, symmetric: of a stress sigma the form
        ``grad v_i : sigma : grad u_i``, negative under pressure; see `bilinear`.
    number
        Number of load factors.
    fixed
        Unknowns that are zero, see `solve`.

    Returns
    -------
    tuple of Floats
        Load factors (number,) in rising order, and modes with ``u . K u = 1``, shape as of `modes`.

    Raises
    ------
    InputError
        If the stiffness is singular, a matrix complex or not symmetric, or fewer load factors are positive.

    """
    given = stiffness, -1.0 * geometric
    free, inverse, (elastic, destabilising) = _reduced(space, stiffness, given, fixed, number, "buckling")
    start = np.random.default_rng(0).standard_normal(elastic.shape[0])
    # -G u = mu K u with mu = 1 / lambda: the largest mu first
    inverse_factors, vectors = eigsh(destabilising, number, elastic, Minv=inverse, which="LA", v0=start)
    if not inverse_factors.min() > 0.0:
        raise InputError(
            f"a geometric stiffness with {int((inverse_factors > 0.0).sum())} positive load factors of {number}",
            "stresses with as much pressure as buckling needs",
            "check the sign of the load, or ask for fewer",
        )
    _check_residuals(destabilising, elastic, inverse_factors, vectors)
    return _sorted(1.0 / inverse_factors, vectors, free, space)


def _reduced(
    space: Unknowns,
    factored: sp.sparray,
    matrices: tuple[sp.sparray, sp.sparray],
    fixed: Indices | Bools | None,
    number: int,
    where: str,
) -> tuple[Bools, LinearOperator, list[sp.csr_array]]:
    """Which unknowns are free, the inverse of a matrix on them, and matrices on them; checks the number of modes."""
    factor = Factor(factored, fixed, factored.shape[0] // space.n_dofs)
    check_integer(where, "number", number, 1, int(factor.free.sum()) - 1)
    parts = [sp.csr_array(matrix)[factor.free][:, factor.free] for matrix in matrices]
    inverse = LinearOperator(parts[0].shape, matvec=lambda x: factor.solve_free(np.ravel(x)), dtype=np.float64)
    return factor.free, inverse, parts


def _check_residuals(left: sp.csr_array, right: sp.csr_array, values: Floats, vectors: Floats) -> None:
    """Raise `InputError` unless ``left v = value right v``, as Lanczos' method finds of symmetric matrices only."""
    residuals = left @ vectors - (right @ vectors) * values
    terms = abs(left) @ np.abs(vectors) + (abs(right) @ np.abs(vectors)) * np.abs(values)
    if not (np.linalg.norm(residuals, axis=0) <= MAX_EIGEN_RESIDUAL * np.linalg.norm(terms, axis=0)).all():
        raise InputError(
            "an eigenproblem whose matrices are not real and symmetric, or whose mass is not positive",
            "symmetric matrices, a positive mass, and a positive stiffness for buckling",
            "take scipy.sparse.linalg.eigs for others",
        )


def _sorted(values: Floats, vectors: Floats, free: Bools, space: Unknowns) -> tuple[Floats, Floats]:
    order = np.argsort(values)
    result = np.zeros((len(values), len(free)))
    result[:, free] = vectors[:, order].T
    shape = (space.n_dofs,) if len(free) == space.n_dofs else (space.n_dofs, -1)
    return values[order], result.reshape(len(values), *shape)
