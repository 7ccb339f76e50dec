"""Symmetric sparse matrices, stored as their lower triangle by columns."""

from dataclasses import dataclass

import numpy as np
import scipy.sparse as sp
from numpy.typing import NDArray

from flangeway.types import Floats


@dataclass(frozen=True, eq=False)
class SymmetricMatrix:
    """Lower triangle of a symmetric matrix in compressed columns, rows sorted.

    Parameters
    ----------
    n
        Number of rows and columns.
    indptr, indices, values
        Column starts (n + 1,), rows and entries of the lower triangle.

    """

    n: int
    indptr: NDArray[np.int64]
    indices: NDArray[np.int32]
    values: Floats

    @property
    def lower(self) -> sp.csc_array:
        """The lower triangle, as a SciPy array."""
        return sp.csc_array((self.values, self.indices, self.indptr), shape=(self.n, self.n))

    def full(self) -> sp.csr_array:
        """Both triangles, as a SciPy array."""
        return sp.csr_array(self.lower + sp.tril(self.lower, -1).T)

    @property
    def _keys(self) -> NDArray[np.int64]:
        """Column times n, plus row, of the entries, rising."""
        return np.repeat(np.arange(self.n), np.diff(self.indptr)) * self.n + self.indices

    def _keys_of(self, rows: NDArray[np.integer], columns: NDArray[np.integer]) -> NDArray[np.int64]:
        return np.minimum(rows, columns).astype(np.int64) * self.n + np.maximum(rows, columns)

    def places(self, rows: NDArray[np.integer], columns: NDArray[np.integer]) -> NDArray[np.int64]:
        """Where entries, which must be in the pattern on either side of the diagonal, are among the values."""
        return np.searchsorted(self._keys, self._keys_of(rows, columns))

    def widened(self, rows: NDArray[np.integer], columns: NDArray[np.integer]) -> "SymmetricMatrix":
        """Take more entries, on either side of the diagonal, into the pattern, as zeros."""
        stored = self._keys
        keys = np.union1d(stored, self._keys_of(rows, columns))
        values = np.zeros(len(keys))
        values[np.searchsorted(keys, stored)] = self.values
        starts = np.searchsorted(keys, np.arange(self.n + 1) * self.n)
        return SymmetricMatrix(self.n, starts.astype(np.int64), (keys % self.n).astype(np.int32), values)

    def times(self, vector: Floats) -> Floats:
        """Product with a vector (n,)."""
        lower = self.lower
        product: Floats = lower @ vector + lower.T @ vector - lower.diagonal() * vector
        return product

    def restricted(self, kept: NDArray[np.bool_]) -> "SymmetricMatrix":
        """Rows and columns where ``kept``, shape (n,), is true, in their order."""
        columns = np.repeat(np.arange(self.n), np.diff(self.indptr))
        stays = kept[columns] & kept[self.indices]
        number = np.cumsum(kept, dtype=np.int32) - 1
        counts = np.bincount(number[columns[stays]], minlength=int(kept.sum()))
        return SymmetricMatrix(
            int(kept.sum()),
            np.concatenate(([0], np.cumsum(counts))).astype(np.int64),
            number[self.indices[stays]].astype(np.int32),
            self.values[stays],
        )

    def bordered(self, rows: sp.sparray) -> "SymmetricMatrix":
        """Take more rows (m, n) below, with their transpose and an explicit zero diagonal beside them."""
        m = rows.shape[0]
        zero = sp.csc_array((np.zeros(m), np.arange(m), np.arange(m + 1)), shape=(m, m))
        lower = sp.csc_array(sp.block_array([[self.lower, None], [rows, zero]]))
        lower.sort_indices()
        return SymmetricMatrix(self.n + m, lower.indptr.astype(np.int64), lower.indices.astype(np.int32), lower.data)

    @classmethod
    def from_full(cls, matrix: sp.sparray) -> "SymmetricMatrix":
        """Take the lower triangle of a symmetric SciPy array."""
        lower = sp.csc_array(sp.tril(matrix))
        lower.sort_indices()
        return cls(
            lower.shape[0],
            lower.indptr.astype(np.int64),
            lower.indices.astype(np.int32),
            np.asarray(lower.data, dtype=np.float64),
        )
