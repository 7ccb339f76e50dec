"""Symmetric sparse matrices, stored as their lower triangle by columns, and matrices of forms as SciPy arrays."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
import scipy.sparse as sp

from flangeway.geometry.arrays import IntArray, max_magnitude
from flangeway.mesh.connectivity import row_numbers
from flangeway.types import Bools, Floats, Indices, Ints

# --- Symmetric sparse matrices, stored as their lower triangle by columns.


EPS = float(np.finfo(np.float64).eps)
"""Round-off of a double precision number of one."""


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
    indptr: Ints
    indices: IntArray
    values: Floats

    @property
    def lower(self) -> sp.csc_array:
        """The lower triangle, as a SciPy array."""
        return sp.csc_array((self.values, self.indices, self.indptr), shape=(self.n, self.n))

    def full(self) -> sp.csr_array:
        """Both triangles, as a SciPy array."""
        column = row_numbers(self.indptr)
        values = np.where(self.indices == column, 0.5 * self.values, self.values)
        half = sp.csc_array((values, self.indices, self.indptr), shape=(self.n, self.n))
        return sp.csr_array(half.T + half)

    @property
    def _keys(self) -> Ints:
        """Column times n, plus row, of the entries, rising."""
        return row_numbers(self.indptr) * self.n + self.indices

    def _keys_of(self, rows: Indices, columns: Indices) -> Ints:
        return np.minimum(rows, columns).astype(np.int64) * self.n + np.maximum(rows, columns)

    def places(self, rows: Indices, columns: Indices) -> Ints:
        """Where entries, which must be in the pattern on either side of the diagonal, are among the values."""
        return np.searchsorted(self._keys, self._keys_of(rows, columns))

    def widened(self, rows: Indices, columns: Indices) -> "SymmetricMatrix":
        """Take more entries, on either side of the diagonal, into the pattern, as zeros."""
        stored = self._keys
        # np.union1d hashes the keys, which takes ten times as long as sorting what is nearly sorted
        keys = np.sort(np.concatenate((stored, self._keys_of(rows, columns))), kind="stable")
        keys = keys[np.diff(keys, prepend=-1) > 0]
        values = np.zeros(len(keys))
        values[np.searchsorted(keys, stored)] = self.values
        starts = np.searchsorted(keys, np.arange(self.n + 1) * self.n)
        return SymmetricMatrix(self.n, starts.astype(np.int64), (keys % self.n).astype(np.int32), values)

    def times(self, vector: Floats) -> Floats:
        """Product with a vector (n,)."""
        lower = self.lower
        return lower @ vector + lower.T @ vector - lower.diagonal() * vector

    def magnitudes(self, vector: Floats) -> Floats:
        """``|K| |u|``: of the terms that the product adds up, which round-off of the entries is relative to."""
        return replace(self, values=np.abs(self.values)).times(np.abs(vector))

    def round_off(self, motion: Floats) -> Floats:
        """Round-off of each row's entries over that of the last bit, from the forces of a motion (n,) without energy.

        Entries of virtual elements of high order on thin cells are off by many times the last bit. The last bit is that
        of the row's largest entries: those for a motion across may be round-off themselves.
        """
        return over_last_bit(self.times(motion), max_magnitude(motion) * self.magnitudes(np.ones(self.n)))

    def plus(self, added: sp.csc_array) -> "SymmetricMatrix":
        """Sum with another symmetric matrix, both triangles of which are given."""
        return SymmetricMatrix.of_lower(self.lower + sp.tril(added, format="csc"))

    def restricted(self, kept: Bools) -> "SymmetricMatrix":
        """Rows and columns where ``kept``, shape (n,), is true, in their order."""
        numbers = np.flatnonzero(kept)
        return SymmetricMatrix.of_lower(self.lower[:, numbers][numbers])

    def transformed(self, transform: sp.csr_array) -> "SymmetricMatrix":
        """Return ``T' K T`` for other unknowns (m,), whose columns of T (n, m) these are."""
        return SymmetricMatrix.from_full(transform.T @ self.full() @ transform)

    def bordered(self, rows: sp.sparray) -> "SymmetricMatrix":
        """Take more rows (m, n) below, with their transpose and an explicit zero diagonal beside them."""
        m = rows.shape[0]
        zero = sp.csc_array((np.zeros(m), np.arange(m), np.arange(m + 1)), shape=(m, m))
        return SymmetricMatrix.of_lower(sp.block_array([[self.lower, None], [rows, zero]]))

    @classmethod
    def from_full(cls, matrix: sp.sparray) -> "SymmetricMatrix":
        """Take the lower triangle of a symmetric SciPy array."""
        return cls.of_lower(sp.tril(matrix))

    @classmethod
    def of_lower(cls, lower: sp.sparray) -> "SymmetricMatrix":
        """Take a lower triangle, explicit zeros included."""
        columns = sp.csc_array(lower)
        columns.sum_duplicates()  # which sorts the rows too
        indptr, indices = columns.indptr.astype(np.int64), columns.indices.astype(np.int32)
        return cls(columns.shape[0], indptr, indices, columns.data.astype(np.float64, copy=False))


def over_last_bit(forces: Floats, terms: Floats) -> Floats:
    """Forces that would be zero over the last bit of the terms that they add up, 1 or more, each (n,)."""
    return np.maximum(np.abs(forces) / np.maximum(EPS * terms, np.finfo(np.float64).tiny), 1.0)


class DifferenceProduct:
    """Product of a body's stiffness with displacements, computed from differences between nodes.

    A translation strains nothing, so ``(K u)_i = sum_j K_ij (u_j - u_i)``: the diagonal, which only round-off keeps
    equal to minus the sum of its row, is not used. Where a slender body turns, displacements are many times larger than
    their differences, and the product keeps as many more digits. `magnitudes` takes the round-off of the entries from
    the forces of translations, see `SymmetricMatrix.round_off`.

    Parameters
    ----------
    matrix
        Stiffness of d displacements at each node, numbered ``d * node + component``, before anything is held.
    transform
        Displacements at nodes by the unknowns that stay free, shape (d n_nodes, n_free).
    axisymmetric
        Whether a displacement in x strains the body, so that the rows' sums over x are kept.
    springs
        Stiffness that is added at the nodes, whose rows have no zero sum.
    dimension
        Number d of components.

    """

    def __init__(
        self,
        matrix: SymmetricMatrix,
        transform: sp.csr_array,
        *,
        axisymmetric: bool,
        springs: sp.sparray | None = None,
        dimension: int = 2,
    ) -> None:
        columns, rows = row_numbers(matrix.indptr), matrix.indices.astype(np.int64)
        other = rows // dimension != columns // dimension
        self._rows, self._columns, self._values = rows[other], columns[other], matrix.values[other]
        # the component of the other unknown, at the node of this one
        self._row_nodes = self._rows // dimension * dimension + self._columns % dimension
        self._column_nodes = self._columns // dimension * dimension + self._rows % dimension
        self._transform = transform
        self._added = sp.csc_array((matrix.n, matrix.n)) if springs is None else springs
        if axisymmetric:
            radial = np.arange(matrix.n) % 2 == 0
            sums, every = matrix.times(radial.astype(np.float64)), np.arange(matrix.n)
            self._added = self._added + sp.csc_array((sums, (every, every // 2 * 2)), shape=self._added.shape)
        translations = np.eye(dimension)[axisymmetric:]
        self._round_off = np.max(
            [matrix.round_off(np.resize(translation, matrix.n)) for translation in translations], axis=0
        )

    def times(self, vector: Floats) -> Floats:
        """Forces on the free unknowns from their values, (n_free,)."""
        return self._transform.T @ self.at_nodes(self._transform @ vector)

    def at_nodes(self, vector: Floats) -> Floats:
        """Forces at the nodes from displacements there, (d n_nodes,)."""
        return self._added @ vector + self._sums(self._values, vector)

    def magnitudes(self, vector: Floats) -> Floats:
        """See `SymmetricMatrix.magnitudes`: here ``g_i = sum_j |K_ij| |u_j - u_i|``, times the entries' round-off."""
        nodal = self._transform @ vector
        terms = self._round_off * self._sums(np.abs(self._values), nodal, np.abs)
        return abs(self._transform).T @ (terms + abs(self._added) @ np.abs(nodal))

    def _sums(self, values: Floats, vector: Floats, of: Callable[[Floats], Floats] = np.asarray) -> Floats:
        """Sums of values times a function of the differences of their column node's and row node's displacement.

        The displacements are in the column's component for the row, and the reverse for the column.
        """
        along = of(vector[self._columns] - vector[self._row_nodes])
        across = of(vector[self._rows] - vector[self._column_nodes])
        result = np.bincount(self._rows, values * along, len(vector)).astype(np.float64)
        result += np.bincount(self._columns, values * across, len(vector))
        return result


# --- Matrices of forms, as SciPy arrays that know the round-off of their entries.


class FormMatrix(sp.csr_array):  # type: ignore[misc]  # SciPy has no types
    """A sum of forms; with other arrays, and times a number, it stays one.

    Attributes
    ----------
    round_off
        Round-off of each row's entries over that of the last bit, 1 or more: of virtual elements of high order on thin
        cells it is many times larger. Rows, columns and `block_array` keep it; products lose it: they have 1.

    """

    def __init__(self, *args: Any, round_off: Floats | float = 1.0, **options: Any) -> None:
        super().__init__(*args, **options)
        self.round_off = round_off

    @classmethod
    def measured(
        cls, matrix: sp.sparray, motions: Floats, forces: Floats | None = None, least: Floats | float = 1.0
    ) -> "FormMatrix":
        """Measure the round-off by the forces of motions (n,) or (n, m) without energy, or given ones of a part.

        The last bit is that of the terms of all motions: those of a motion across may be round-off themselves.
        """
        zeros = matrix @ motions if forces is None else forces
        forces, motions = (np.abs(array).reshape(len(array), -1) for array in (zeros, motions))
        round_off = over_last_bit(forces.max(axis=1), abs(matrix) @ motions.sum(axis=1))
        return cls(matrix, round_off=np.maximum(round_off, least))

    def __getitem__(self, key: Any) -> Any:
        result = super().__getitem__(key)
        if isinstance(result, FormMatrix) and result.ndim == 2:
            rows = key[0] if isinstance(key, tuple) else key
            return FormMatrix(result, round_off=np.broadcast_to(self.round_off, self.shape[:1])[rows].ravel())
        return result

    def _kept(self, result: Any, other: Any = None) -> Any:
        if isinstance(result, FormMatrix):
            return FormMatrix(result, round_off=np.maximum(self.round_off, getattr(other, "round_off", 1.0)))
        return result

    def __add__(self, other: Any) -> Any:
        return self._kept(super().__add__(other), other)

    __radd__ = __add__

    def __sub__(self, other: Any) -> Any:
        return self._kept(super().__sub__(other), other)

    def __rsub__(self, other: Any) -> Any:
        return -self + other

    def __mul__(self, other: Any) -> Any:
        return self._kept(super().__mul__(other))

    __rmul__ = __mul__

    def __truediv__(self, other: Any) -> Any:
        return self._kept(super().__truediv__(other))

    def __neg__(self) -> Any:
        return self._kept(super().__neg__())


def block_array(blocks: Sequence[Sequence[Any]]) -> FormMatrix:
    """SciPy's function of this name, for forms of several fields: blocks keep the round-off of their entries.

    Parameters
    ----------
    blocks
        Rows of matrices, None where there is nothing; unknowns are numbered field by field.

    """
    rows = []
    for row in blocks:
        given = [block for block in row if block is not None]
        round_offs = [np.broadcast_to(getattr(block, "round_off", 1.0), given[0].shape[:1]) for block in given]
        rows.append(np.max(round_offs, axis=0))
    return FormMatrix(sp.block_array(blocks, format="csr"), round_off=np.concatenate(rows))
