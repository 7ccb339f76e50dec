"""Bilinear and linear forms on any space as SciPy arrays.

Unknowns of a field of m components are numbered ``m * dof + component``: arrays (n_dofs, m), row by row.
"""

from collections.abc import Callable
from types import SimpleNamespace

import numpy as np
import scipy.sparse as sp
from numpy.typing import ArrayLike

from flangeway.elements import Function, Reconstruction
from flangeway.errors import InputError
from flangeway.forms.weak import FormRegion, PointValues, assembled_form, linear, products_round_off, value_products
from flangeway.problems.strains import add_consistency, strain_operators
from flangeway.space import CellBatch, CellCoefficient, Coefficient, FormMatrix, Space, load_vector
from flangeway.space.functions import function_of
from flangeway.types import Floats, floats


def stiffness(space: Space, coefficient: Coefficient = 1.0, *, degree: int | None = None) -> sp.csr_array:
    """Integrals of ``grad v : C : grad u``.

    Gradients of virtual functions are their L2 projections onto polynomials of degree k - 1, which keeps the order for
    coefficients that vary (Beirao da Veiga, Brezzi, Marini and Russo, 2016, "Virtual element method for general
    second-order elliptic problems on polygonal meshes"); the element's stabilisation is added.

    Parameters
    ----------
    space
        The space.
    coefficient
        A number, or a matrix (2, 2) for anisotropy: one field. A matrix (3, 3) of plane elasticity, stresses xx, yy, xy
        per strain xx, yy, 2 xy: a displacement. Any tensor (m, 2, m, 2), such as ``Elastic(...).stiffness``: m fields.
        The same for each cell (one more axis in front), by the names of cell sets, or as a function of points (n, 2)
        with one more axis in front. Symmetric and positive.
    degree
        Degree of the quadrature with a function, ``2 k + 2`` by default.

    Returns
    -------
    scipy.sparse.csr_array
        Shape (m n_dofs, m n_dofs).

    Raises
    ------
    InputError
        If the coefficient has another shape, is not symmetric or not positive.

    """
    given = CellCoefficient.on(space, coefficient, "gradients")
    if given.function is not None:
        return _at_points(given, None, degree)

    def matrices(batch: CellBatch, reconstruction: Reconstruction, blocks: Floats) -> Floats | None:
        strains = strain_operators(batch, reconstruction.for_energy, axisymmetric=False)
        add_consistency(blocks, given.at(batch, np.empty((1, 2, 0)))[..., 0, :], strains)
        return batch.element.stabilise(reconstruction, blocks)

    matrix = _assembled(space, given.n_components, matrices)
    return FormMatrix.measured(matrix, np.repeat(space.constant, given.n_components))


def mass(
    space: Space, coefficient: Coefficient = 1.0, *, on: str | None = None, degree: int | None = None
) -> sp.csr_array:
    """Integrals of ``v . c u``: mass, reaction, or springs along edges.

    Values of virtual functions inside cells are their L2 projections (Ahmad et al., 2013, "Equivalent projectors for
    virtual element methods"); what these miss is added with equal shares of the area, but for elements without
    stabilisation: the energy of what is missed may be near zero there, and such motions would be slow modes.

    Parameters
    ----------
    space
        The space.
    coefficient
        A number for one field, or a symmetric matrix (m, m) for m components; the same for each cell, by the names of
        cell sets, or as a function, see `stiffness`.
    on
        Name of an edge set: integrals along it, of a coefficient that is the same everywhere or a function.
    degree
        Degree of the quadrature with a function, ``2 k + 2`` by default.

    Returns
    -------
    scipy.sparse.csr_array
        Shape (m n_dofs, m n_dofs).

    Raises
    ------
    InputError
        If the coefficient has another shape or is not symmetric.

    """
    given = CellCoefficient.on(space, coefficient, "values")
    if on is not None and given.values is not None and len(given.values) > 1:
        raise InputError("a coefficient of cells along edges", "a number, a matrix or a function", "give one of these")
    if on is not None or given.function is not None:
        return _at_points(given, on, degree)
    round_off = np.ones(space.n_dofs)

    def matrices(batch: CellBatch, reconstruction: Reconstruction, blocks: Floats) -> None:
        products = value_products(reconstruction)
        of_cells = products_round_off(reconstruction, products, space.constant[batch.dofs])
        np.maximum.at(round_off, batch.dofs, of_cells)
        tensor = given.at(batch, np.empty((1, 2, 0)))[..., 0, :]
        for i, j in np.argwhere(np.abs(tensor).any(axis=-1)):
            blocks[i, j] = products * tensor[i, j]

    result = FormMatrix(_assembled(space, given.n_components, matrices))
    result.round_off = np.repeat(round_off, given.n_components)
    return result


def _at_points(given: CellCoefficient, on: str | None, degree: int | None) -> sp.csr_array:
    """Integrals by values of the coefficient at points of cells or edges."""
    m, region = given.n_components, FormRegion((given.space, given.space), {}, on, degree)

    def tensor(w: SimpleNamespace) -> Floats:
        values = given.along(w.points)
        whole = np.zeros((m, region.n_jets, m, region.n_jets, len(w.points)))
        if values.ndim == 3:
            whole[:, 0, :, 0] = values
        else:
            whole[:, 1:, :, 1:] = values
        return whole.reshape(m * region.n_jets, m * region.n_jets, -1)

    return assembled_form(region, tensor, m, m, on is None)


def _assembled(
    space: Space, m: int, matrices: Callable[[CellBatch, Reconstruction, Floats], Floats | None]
) -> sp.csr_array:
    """Add up matrices of cells, whose blocks of components a function fills, returning what is added to each field."""

    def of_cells(batch: CellBatch) -> Floats:
        reconstruction = batch.element.reconstruct(batch.outline)
        n = reconstruction.n_local
        result = np.zeros((n, m, n, m, len(batch.cells)))
        blocks = result.transpose(1, 3, 0, 2, 4)
        added = matrices(batch, reconstruction, blocks)
        if added is not None:
            for i in range(m):
                blocks[i, i] += added
        return result.reshape(m * n, m * n, -1)

    return space.assemble(of_cells, m).full()


def load(space: Space, function: Function | ArrayLike, *, on: str | None = None, degree: int | None = None) -> Floats:
    """Integrals of ``v . f`` over the cells, or along edges (a flux or a traction).

    Parameters
    ----------
    space
        The space.
    function
        Function of points (n, 2) with values (n,), or (n, m) for m components; or a number, or m numbers.
    on
        Name of an edge set; None takes the cells.
    degree
        Degree of the quadrature over cells, ``2 k + 2`` by default.

    Returns
    -------
    Floats
        Shape (n_dofs,) or (n_dofs, m).

    """
    given = function_of("a load", function)
    if on is None:
        return load_vector(space, given, degree)
    shape = np.shape(given(space.nodes[:1]))[1:]
    m = int(np.prod(shape, dtype=np.int64))

    def traction(v: PointValues, w: SimpleNamespace) -> Floats:
        return (np.reshape(given(w.points), (-1, m)) * v.value.reshape(-1, m)).sum(axis=1)

    return floats(linear(space, traction, components=m, on=on)).reshape(-1, *shape)
