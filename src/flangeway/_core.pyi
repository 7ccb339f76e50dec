"""Sparse machinery: assembly pattern, Cholesky with a trailing Schur complement, LDLT.

All matrices are symmetric and given by their lower triangle in compressed columns: ``indptr``
int64 (n + 1,), ``indices`` int32 (n_entries,), ``values`` float64 (n_entries,); the rows of a
column increase strictly and begin with the diagonal, which is always present. Arrays must have the
dtype named and lie in memory in C order (right-hand sides may be strided). Objects never change,
results do not depend on the number of threads, and the interpreter lock is released at work.
"""

from collections.abc import Sequence
from typing import final

import numpy as np
from numpy.typing import NDArray

class NotPositiveDefiniteError(ArithmeticError):
    """A pivot is not positive.

    The arguments are the message and the number of the unknown, as numbered by the caller, at
    which the pivot failed. A pivot counts as zero if it is at most ``max(1e-13, 2 n eps)`` times
    the diagonal entry that it began as: rounding leaves that much of a zero. A motion that nothing
    holds shows at the last unknowns that take part in it.
    """

    args: tuple[str, int]

class SingularMatrixError(ArithmeticError):
    """The matrix is singular, or the factor is not accurate enough: no digit of the solution is certain."""

class FactorTooLargeError(MemoryError):
    """Work that has too many entries or needs too much memory; refused before the memory is taken.

    The arguments are the message and the bytes that the work needs at its peak, or None if the
    factor has more than 2^31 - 1 entries.
    """

    args: tuple[str, int | None]

def n_threads() -> int:
    """Number of threads that share the work: ``RAYON_NUM_THREADS``, or the cores given to the process.

    Raises
    ------
    FactorTooLargeError
        If there is no memory for the threads, which start at the first call or the first work.
    """

@final
class Pattern:
    """Sparsity pattern of ragged cells, found once; their matrices are summed into it many times.

    Parameters
    ----------
    n_dofs
        Number of unknowns, at least 1.
    batches
        One array (n_local, n_cells) int32 for the cells with the same number of unknowns: the
        number of each unknown. A negative number is skipped (an eliminated unknown).

    Raises
    ------
    ValueError
        If a dtype, a dimension or the memory order is wrong, or a number is not below ``n_dofs``.
    FactorTooLargeError
        If there is no memory for it.
    """

    def __init__(self, n_dofs: int, batches: Sequence[NDArray[np.int32]]) -> None: ...
    @property
    def n_dofs(self) -> int:
        """Number of unknowns."""

    @property
    def indptr(self) -> NDArray[np.int64]:
        """Where each column of the lower triangle begins, (n_dofs + 1,), read-only."""

    @property
    def indices(self) -> NDArray[np.int32]:
        """Rows of the lower triangle column by column, (n_entries,), read-only."""

    def scatter(self, matrices: Sequence[NDArray[np.float64]]) -> NDArray[np.float64]:
        """Sum the matrices of all cells.

        Parameters
        ----------
        matrices
            One array (n_local, n_local, n_cells) for each batch, symmetric in its first two axes:
            only entries in the lower triangle of the assembled matrix are read.

        Returns
        -------
        NDArray[np.float64]
            Values of the lower triangle, (n_entries,), in the order of ``indices``.

        Raises
        ------
        ValueError
            If a dtype, a shape or the memory order is wrong, or a sum is not finite.
        FactorTooLargeError
            If there is no memory for it.
        """

@final
class Cholesky:
    """Sparse Cholesky factor with some unknowns kept last, and their Schur complement.

    With ``i`` the interior and ``b`` the trailing unknowns, only ``K_ii`` must be positive
    definite: the Schur complement ``S = K_bb - K_bi K_ii^-1 K_ib`` may be singular or indefinite.

    The interior is ordered by approximate minimum degree (Amestoy, Davis and Duff, 1996) on the
    graph of its nodes, then postordered by its elimination tree. What the pattern alone determines is kept for the
    last four patterns of up to a million entries, and serves matrices of other values: half of the time.

    Parameters
    ----------
    indptr, indices, values
        Lower triangle in compressed columns, as from `Pattern`.
    groups
        Number of the node of each unknown, (n,) int32; unknowns of one node are ordered together.
    trailing
        Unknowns kept last in the order given, (n_trailing,) int32, each once; may be empty.
    most_bytes
        Memory that the factorisation may take beside its arguments; left out: as much as there is.

    Raises
    ------
    NotPositiveDefiniteError
        If ``K_ii`` is not positive definite.
    FactorTooLargeError
        If the factor has more than 2^31 - 1 entries, or needs more memory than allowed or than there is.
    ValueError
        If a dtype, a shape, the memory order, the structure or a number is wrong, or a value is not
        finite.
    """

    def __init__(
        self,
        indptr: NDArray[np.int64],
        indices: NDArray[np.int32],
        values: NDArray[np.float64],
        groups: NDArray[np.int32],
        trailing: NDArray[np.int32],
        most_bytes: int = ...,
    ) -> None: ...
    @property
    def n(self) -> int:
        """Number of unknowns."""

    @property
    def n_trailing(self) -> int:
        """Number of unknowns kept last."""

    @property
    def factor_nonzeros(self) -> int:
        """Entries stored for the factor, eight bytes each, padding of its dense blocks included."""

    @property
    def peak_bytes(self) -> int:
        """Memory that the factorisation was expected to take at its peak, beside its arguments."""

    def schur(self) -> NDArray[np.float64]:
        """Return the Schur complement ``S``, (n_trailing, n_trailing), both triangles."""

    def solve(self, rhs: NDArray[np.float64]) -> NDArray[np.float64]:
        """Solve ``K x = rhs``; the first call factorises ``S``.

        Parameters
        ----------
        rhs
            Right-hand side, (n,) or (n, m).

        Returns
        -------
        NDArray[np.float64]
            Solution, in the shape of ``rhs``.

        Raises
        ------
        NotPositiveDefiniteError
            If ``S`` is not positive definite; the number is that of a trailing unknown.
        ValueError
            If the dtype or the shape is wrong, or a value is not finite.
        """

    def condense(self, rhs: NDArray[np.float64]) -> NDArray[np.float64]:
        """Return the right-hand side of the condensed system ``S u_b = g_b``.

        Parameters
        ----------
        rhs
            Right-hand side ``f``, (n,) or (n, m).

        Returns
        -------
        NDArray[np.float64]
            ``g_b = f_b - K_bi K_ii^-1 f_i``, (n_trailing,) or (n_trailing, m).

        Raises
        ------
        ValueError
            If the dtype or the shape is wrong, or a value is not finite.
        """

    def recover(self, trailing_values: NDArray[np.float64], rhs: NDArray[np.float64]) -> NDArray[np.float64]:
        """Return the whole solution, ``u_i = K_ii^-1 (f_i - K_ib u_b)`` in the interior.

        Parameters
        ----------
        trailing_values
            ``u_b``, (n_trailing,) or (n_trailing, m), in the order of ``trailing``.
        rhs
            Right-hand side ``f``, (n,) or (n, m) with the same m; its trailing entries are ignored.

        Returns
        -------
        NDArray[np.float64]
            ``u``, (n,) or (n, m).

        Raises
        ------
        ValueError
            If a dtype or a shape is wrong, or a value that is used is not finite.
        """

@final
class Ldlt:
    """Sparse factor of a symmetric indefinite matrix, such as a tangent with multipliers.

    Pivots are chosen within the dense blocks of the factor (Bunch and Kaufman, 1977); an unknown
    with a zero diagonal is ordered after its neighbours. Every solution is refined.

    Parameters
    ----------
    indptr, indices, values
        Lower triangle in compressed columns; a diagonal entry may be zero but must be present.
    groups
        Number of the node of each unknown, (n,) int32; unknowns of one node are ordered together.
    most_bytes
        Memory that the factorisation may take beside its arguments; left out: as much as there is.

    Raises
    ------
    FactorTooLargeError
        If the factor has more than 2^31 - 1 entries, or needs more memory than allowed or than there is.
    ValueError
        If a dtype, a shape, the memory order or the structure is wrong, or a value is not finite.
    """

    def __init__(
        self,
        indptr: NDArray[np.int64],
        indices: NDArray[np.int32],
        values: NDArray[np.float64],
        groups: NDArray[np.int32],
        most_bytes: int = ...,
    ) -> None: ...
    @property
    def n(self) -> int:
        """Number of unknowns."""

    def solve(self, rhs: NDArray[np.float64]) -> NDArray[np.float64]:
        """Solve ``K x = rhs`` with one to five steps of iterative refinement.

        Parameters
        ----------
        rhs
            Right-hand side, (n,) or (n, m).

        Returns
        -------
        NDArray[np.float64]
            Solution, in the shape of ``rhs``.

        Raises
        ------
        SingularMatrixError
            If the solution is not finite, its normwise backward error stays above sixteen times
            the round-off of one, or its last correction is above 1e-3 of it: the matrix is
            singular, or no pivot within the dense blocks was stable.
        ValueError
            If the dtype or the shape is wrong, or a value is not finite.
        """
