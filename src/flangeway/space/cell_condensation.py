"""Static condensation: the unknowns inside cells are eliminated cell by cell, before assembly."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from flangeway._core import Pattern
from flangeway.elements import batched
from flangeway.errors import InputError
from flangeway.geometry.arrays import IntArray
from flangeway.space.core_limits import refuse_large_assembly
from flangeway.space.spaces import CellBatch, Space
from flangeway.space.symmetric import SymmetricMatrix
from flangeway.types import Bools, Floats, Ints


@dataclass(frozen=True, eq=False)
class CondensedCells:
    """What recovers the internal unknowns of a batch of cells.

    Parameters
    ----------
    outer, inner
        Unknowns on the cells' edges (n_outer, n_cells) and inside them (n_inner, n_cells).
    factor
        Lower Cholesky factor L of the block of the internal unknowns, shape (n_inner, n_inner, n_cells).
    coupling
        ``L^-1 K_ib``, K_ib the block that couples them with the edges, shape (n_inner, n_outer, n_cells).

    """

    outer: IntArray
    inner: IntArray
    factor: Floats
    coupling: Floats


@dataclass(frozen=True, eq=False)
class CondensedMatrix:
    """A symmetric matrix on the unknowns at nodes alone, with the way back to those inside the cells.

    Parameters
    ----------
    space
        The space.
    n_components
        Components of the field; unknowns are numbered ``n_components * dof + component``.
    matrix
        Matrix of size ``n_components * n_nodes``.
    cells
        Cells with internal unknowns.

    """

    space: Space[Any]
    n_components: int
    matrix: SymmetricMatrix
    cells: tuple[CondensedCells, ...]

    def condense(self, load: Floats) -> Floats:
        """Loads at the nodes from loads on all unknowns (n_dofs, n_components), shape (n_nodes, n_components)."""
        flat = load.ravel()
        result = flat[: self.matrix.n].copy()
        for cells in self.cells:
            inside = flat[cells.inner]
            if inside.any():
                inside = batched.solve_lower(cells.factor, inside[:, None])[:, 0]
                moved = np.einsum("ibe,ie->be", cells.coupling, inside)
                result -= np.bincount(cells.outer.ravel(), moved.ravel(), minlength=len(result))
        return result.reshape(-1, self.n_components)

    def recover(self, at_nodes: Floats, load: Floats | None = None) -> Floats:
        """All unknowns (n_dofs, n_components) from those at nodes (n_nodes, n_components) and the load on all."""
        result = np.empty(self.n_components * self.space.n_dofs)
        result[: self.matrix.n] = at_nodes.ravel()
        for cells in self.cells:
            inside = -np.einsum("ibe,be->ie", cells.coupling, result[cells.outer])
            if load is not None:
                inside += batched.solve_lower(cells.factor, load.ravel()[cells.inner][:, None])[:, 0]
            result[cells.inner] = batched.solve_upper(cells.factor, inside[:, None])[:, 0]
        return result.reshape(-1, self.n_components)


@dataclass(frozen=True, eq=False)
class InnerUnknowns:
    """What the unknowns inside cells add to a matrix ``K0 + k K1 + k^2 K2`` on the nodes when they are eliminated.

    Parameters
    ----------
    blocks
        Rows of K0, K1, K2 of the internal unknowns of each batch, those of the nodes first, (3, n_inner, n, n_cells).
    pairs
        Rows and columns of a cell's lower triangle on the nodes, for each batch.
    places
        Where these pairs are among the values of the matrix on the nodes, for all batches; after the last one if held.

    """

    blocks: tuple[Floats, ...]
    pairs: tuple[tuple[Ints, Ints], ...]
    places: Ints

    @classmethod
    def of(
        cls, space: Space, parts: Sequence[SymmetricMatrix], kept: Bools, matrix: SymmetricMatrix
    ) -> "InnerUnknowns":
        """Find them in assembled parts, for the matrix of the unknowns at nodes that are kept."""
        n_components = parts[0].n // space.n_dofs
        numbers = np.where(kept, np.cumsum(kept) - 1, -1)
        blocks, pairs, entries = [], [], []
        for batch in space.batches():
            n_inner = n_components * batch.element.n_interior()
            unknowns = batch.vector_dofs(n_components)
            unknowns = unknowns[:, kept[unknowns[-1]]] if n_inner else unknowns[:, :0]
            if unknowns.size == 0:
                continue
            inner = parts[0].places(unknowns[-n_inner:, None], unknowns[None])
            blocks.append(np.stack([part.values[inner] for part in parts]))
            lower = np.tril_indices(len(unknowns) - n_inner)
            rows, columns = (numbers[unknowns[indices]] for indices in lower)
            loose = np.minimum(rows, columns) >= 0
            pairs.append(lower)
            entries.append(np.where(loose, matrix.places(rows, columns), len(matrix.values)).ravel())
        return cls(tuple(blocks), tuple(pairs), np.concatenate(entries) if entries else np.empty(0, dtype=np.int64))

    def eliminated(self, values: Floats, wavenumber: float) -> Floats:
        """Values of the matrix on the nodes, once the internal unknowns at a wavenumber have been eliminated."""
        if not self.blocks:
            return values
        moved = []
        for (constant, linear, square), pair in zip(self.blocks, self.pairs, strict=True):
            rows = constant + wavenumber * (linear + wavenumber * square)
            n_outer = rows.shape[1] - rows.shape[0]
            coupling = batched.solve_lower(batched.cholesky(rows[:, n_outer:]), rows[:, :n_outer])
            moved.append(batched.symmetric_product(coupling, coupling)[pair].ravel())
        summed = np.bincount(self.places, np.concatenate(moved), minlength=len(values) + 1)
        return np.subtract(values, summed[: len(values)], dtype=np.float64)


def assemble_condensed(
    space: Space[Any], cell_matrices: Callable[[CellBatch], Floats], n_components: int
) -> CondensedMatrix:
    """Add up symmetric matrices of cells with their internal unknowns eliminated.

    Elimination is the first part of Cholesky's method for the cell's matrix, whose round-off is that of a small change
    of the matrix itself; it never forms an inverse, with which digits would be lost as the unknowns' scales part.

    Parameters
    ----------
    space
        The space.
    cell_matrices
        Gives the matrices of a batch, shape (n, n, n_cells) with ``n = n_components * n_local``.
    n_components
        Components of the field.

    Raises
    ------
    InputError
        If the internal unknowns of a cell can move without energy.
    OutOfMemoryError
        If there is too little memory for the matrices of all cells.

    """
    batches = list(space.batches())
    refuse_large_assembly((n_components * len(batch.dofs), len(batch.cells)) for batch in batches)
    dofs, matrices, cells = [], [], []
    for batch in batches:
        matrix, numbers = cell_matrices(batch), batch.vector_dofs(n_components)
        n_outer = len(numbers) - n_components * batch.element.n_interior()
        if n_outer < len(numbers):
            condensed = _condensed(batch, matrix, numbers, n_outer)
            cells.append(condensed)
            coupling = condensed.coupling
            matrix = matrix[:n_outer, :n_outer] - batched.symmetric_product(coupling, coupling)
            numbers = condensed.outer
        dofs.append(np.ascontiguousarray(numbers))
        matrices.append(np.ascontiguousarray(matrix))
    n = n_components * space.n_nodes
    pattern = Pattern(n, dofs)
    assembled = SymmetricMatrix(n, pattern.indptr, pattern.indices, pattern.scatter(matrices))
    return CondensedMatrix(space, n_components, assembled, tuple(cells))


def _condensed(batch: CellBatch, matrix: Floats, numbers: IntArray, n_outer: int) -> CondensedCells:
    with np.errstate(invalid="ignore", divide="ignore"):
        factor = batched.cholesky(matrix[n_outer:, n_outer:])
        coupling = batched.solve_lower(factor, matrix[n_outer:, :n_outer])
    broken = ~np.isfinite(coupling).all(axis=(0, 1))
    if broken.any():
        raise InputError(
            f"cell {batch.cells[broken.argmax()]}, whose internal unknowns can move without energy",
            "elements with a stabilisation, on cells without zero area",
            "check the mesh with flangeway.mesh.check, and leave the element's stabilisation as published",
        )
    return CondensedCells(numbers[:n_outer], numbers[n_outer:], factor, coupling)
