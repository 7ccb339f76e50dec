"""Monomials in a cell's own coordinates, their derivatives and exact integrals.

A cell has a *frame*: the affine map ``xi = map @ (x - origin)``. The monomials are ordered by degree,
``1, xi, eta, xi^2, xi eta, eta^2, ...`` (Beirao da Veiga et al., 2014, "The Hitchhiker's guide to the
virtual element method", section 3, with another frame).
"""

from dataclasses import dataclass
from functools import cache, cached_property

import numpy as np

from flangeway.elements.batched import cross
from flangeway.elements.quadrature import gauss
from flangeway.types import Floats, Ints


@dataclass(frozen=True, eq=False)
class Frame:
    """Local coordinates of a batch of cells: ``xi = map @ (x - origin)``."""

    origin: Floats  # centroids, (2, n_cells)
    map: Floats  # linear maps from space to local coordinates, (2, 2, n_cells)

    def local(self, points: Floats) -> Floats:
        """Local coordinates of points in space, both of shape (..., 2, n_cells)."""
        shifted = points - self.origin
        x, y = shifted[..., 0, :], shifted[..., 1, :]
        map_ = self.map
        return np.stack((map_[0, 0] * x + map_[0, 1] * y, map_[1, 0] * x + map_[1, 1] * y), axis=-2)

    @property
    def determinant(self) -> Floats:
        """Signed area in local coordinates per area in space, (n_cells,)."""
        return cross(*self.map)

    @cached_property
    def inverse(self) -> Floats:
        """Linear maps from local coordinates to space, (2, 2, n_cells)."""
        (a, b), (c, d) = self.map
        return np.array([[d, -b], [-c, a]]) / self.determinant


def n_monomials(degree: int) -> int:
    """Dimension of the polynomials of two variables of a degree; 0 below degree 0."""
    return (degree + 1) * (degree + 2) // 2 if degree >= 0 else 0


@cache
def exponents(degree: int) -> Ints:
    """Exponents of the monomials up to a degree, shape (n_monomials, 2)."""
    pairs = [(total - j, j) for total in range(degree + 1) for j in range(total + 1)]
    table = np.array(pairs, dtype=np.int64).reshape(-1, 2)
    table.setflags(write=False)
    return table


def index(powers: Ints) -> Ints:
    """Position of monomials in the order of `exponents`; ``powers`` has shape (..., 2)."""
    total = powers.sum(axis=-1)
    return total * (total + 1) // 2 + powers[..., 1]


def evaluate(degree: int, local: Floats) -> Floats:
    """Values of all monomials at local points of shape (..., 2, n_cells).

    Returns
    -------
    Floats
        Shape (n_monomials, ..., n_cells).

    """
    xi, eta = local[..., 0, :], local[..., 1, :]
    values = np.empty((n_monomials(degree), *xi.shape))
    values[0] = 1.0
    for total in range(1, degree + 1):
        start, previous = n_monomials(total - 1), n_monomials(total - 2)
        values[start : start + total] = values[previous : previous + total] * xi
        values[start + total] = values[previous + total - 1] * eta
    return values


@cache
def derivatives(degree: int) -> Floats:
    """Matrices of the local derivatives: coefficients of degree k to those of degree k - 1.

    Returns
    -------
    Floats
        Shape (2, n_monomials(degree - 1), n_monomials(degree)); first axis: by xi, by eta.

    """
    powers = exponents(degree)
    matrices = np.zeros((2, n_monomials(degree - 1), len(powers)))
    for axis in (0, 1):
        columns = np.flatnonzero(powers[:, axis] > 0)
        lowered = powers[columns].copy()
        lowered[:, axis] -= 1
        matrices[axis, index(lowered), columns] = powers[columns, axis]
    matrices.setflags(write=False)
    return matrices


@cache
def derivative_entries(degree: int) -> tuple[tuple[Ints, Floats], tuple[Ints, Floats]]:
    """The only entry in each row of both matrices of `derivatives`: its column and its value.

    Row a of the derivative by xi or eta comes from one monomial of degree k: ``(columns, factors)``, each of
    shape (n_monomials(degree - 1),).
    """
    by_xi, by_eta = derivatives(degree)
    columns = by_xi.argmax(axis=1), by_eta.argmax(axis=1)
    return (columns[0], by_xi.max(axis=1)), (columns[1], by_eta.max(axis=1))


def integrals(degree: int, local_vertices: Floats, jacobian: Floats) -> Floats:
    """Exact integrals of all monomials over straight-sided polygons.

    For a homogeneous function f of degree d, ``(d + 2) int_P f = sum over edges of (x . n) int_e f``
    (Lasserre, 1998, Proc. AMS 126), with Gauss quadrature along each edge.

    Parameters
    ----------
    degree
        Highest degree.
    local_vertices
        Vertices in local coordinates, counter-clockwise in space, shape (n_vertices, 2, n_cells).
    jacobian
        Area in space per signed area in local coordinates, shape (n_cells,).

    Returns
    -------
    Floats
        Shape (n_monomials(degree), n_cells).

    """
    abscissae, weights = gauss(degree // 2 + 1)
    start, end = local_vertices, np.roll(local_vertices, -1, axis=0)
    areas = cross(start, end)
    total = np.zeros((n_monomials(degree), local_vertices.shape[-1]))
    for position, weight in zip(abscissae, weights, strict=True):
        values = evaluate(degree, start + position * (end - start))
        total += weight * np.einsum("ave,ve->ae", values, areas)
    order = exponents(degree).sum(axis=1)
    return total * jacobian / (order + 2)[:, None]


@cache
def _product_table(degree: int) -> Ints:
    powers = exponents(degree)
    return index(powers[:, None, :] + powers[None, :, :])


def mass(degree: int, moments: Floats) -> Floats:
    """Integrals of all products of two monomials.

    Parameters
    ----------
    degree
        Degree of each factor.
    moments
        Integrals of the monomials up to twice that degree, shape (>= n_monomials(2 degree), n_cells).

    Returns
    -------
    Floats
        Shape (n_monomials(degree), n_monomials(degree), n_cells).

    """
    return moments[_product_table(degree)]
