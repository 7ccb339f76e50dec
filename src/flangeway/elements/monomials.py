"""Monomials of two or three variables in a cell's own coordinates, their derivatives and exact integrals.

A cell has a *frame*: the affine map ``xi = map @ (x - origin)``. The monomials are ordered by degree,
``1, xi, eta, xi^2, xi eta, eta^2, ...``, or ``1, xi, eta, zeta, xi^2, xi eta, xi zeta, eta^2, ...`` (Beirao da Veiga et
al., 2014, "The Hitchhiker's guide to the virtual element method", section 3, with another frame). The number of
variables d is 2 unless an argument says 3.
"""

from dataclasses import dataclass
from functools import cache, cached_property
from itertools import product
from math import comb, factorial

import numpy as np

from flangeway.elements.batched import cross
from flangeway.elements.quadrature import gauss
from flangeway.geometry.arrays import frozen
from flangeway.types import Floats, Indices, Ints, floats


@dataclass(frozen=True, eq=False)
class Frame:
    """Local coordinates of a batch of cells: ``xi = map @ (x - origin)``."""

    origin: Floats  # centroids, (d, n_cells)
    map: Floats  # linear maps from space to local coordinates, (d, d, n_cells)

    def local(self, points: Floats) -> Floats:
        """Local coordinates of points in space, both of shape (..., d, n_cells)."""
        shifted = np.moveaxis(points - self.origin, -2, 0)
        # xi_i = sum_j map_ij (x_j - origin_j)
        products = ([factor * x for factor, x in zip(row, shifted, strict=True)] for row in self.map)
        return np.stack([sum(others, first) for first, *others in products], axis=-2)

    def part(self, columns: Indices) -> "Frame":
        """Those of some cells, by their places in the batch (m,)."""
        return Frame(self.origin[:, columns], self.map[:, :, columns])

    @property
    def determinant(self) -> Floats:
        """Signed area or volume in local coordinates per area or volume in space, (n_cells,)."""
        return cross(*self.map) if len(self.map) == 2 else np.linalg.det(np.moveaxis(self.map, -1, 0))

    @cached_property
    def inverse(self) -> Floats:
        """Linear maps from local coordinates to space, (d, d, n_cells)."""
        if len(self.map) == 3:
            return np.moveaxis(floats(np.linalg.inv(np.moveaxis(self.map, -1, 0))), 0, -1)
        (a, b), (c, d) = self.map
        return np.array([[d, -b], [-c, a]]) / self.determinant


def n_monomials(degree: int, dimension: int = 2) -> int:
    """Number of the polynomials' monomials of two or three variables of a degree; 0 below degree 0."""
    return comb(degree + dimension, dimension) if degree >= 0 else 0


@cache
def exponents(degree: int, dimension: int = 2) -> Ints:
    """Exponents of the monomials up to a degree, shape (n_monomials, d)."""
    powers = product(range(degree, -1, -1), repeat=dimension)
    table = np.array(sorted((p for p in powers if sum(p) <= degree), key=sum), dtype=np.int64).reshape(-1, dimension)
    return frozen(table)


def index(powers: Ints) -> Ints:
    """Position of monomials in the order of `exponents`; ``powers`` has shape (..., d)."""
    dimension, position = powers.shape[-1], np.zeros(powers.shape[:-1], dtype=np.int64)
    for first in range(dimension):
        # before it are those of a lower degree than t in the n variables from this one on: binomial(t + n - 1, n)
        total, n = powers[..., first:].sum(axis=-1), dimension - first
        position += np.prod([total + i for i in range(n)], axis=0) // factorial(n)
    return position


def evaluate(degree: int, local: Floats) -> Floats:
    """Values of all monomials at local points of shape (..., d, n_cells).

    Returns
    -------
    Floats
        Shape (n_monomials, ..., n_cells).

    """
    dimension = local.shape[-2]
    values = np.empty((n_monomials(degree, dimension), *local.shape[:-2], local.shape[-1]))
    values[0] = 1.0
    for total in range(1, degree + 1):
        start = end = n_monomials(total - 1, dimension)
        for axis in range(dimension):  # times those of one degree less that have no variable before this one
            n = comb(total + dimension - axis - 2, total - 1)
            np.multiply(values[end - n : end], local[..., axis, :], out=values[start : start + n])
            start += n
    return values


@cache
def derivatives(degree: int, dimension: int = 2) -> Floats:
    """Matrices of the local derivatives: coefficients of degree k to those of degree k - 1.

    Returns
    -------
    Floats
        Shape (d, n_monomials(degree - 1), n_monomials(degree)); first axis: by xi, by eta, by zeta.

    """
    powers = exponents(degree, dimension)
    matrices = np.zeros((dimension, n_monomials(degree - 1, dimension), len(powers)))
    for axis in range(dimension):
        columns = np.flatnonzero(powers[:, axis] > 0)
        lowered = powers[columns].copy()
        lowered[:, axis] -= 1
        matrices[axis, index(lowered), columns] = powers[columns, axis]
    return frozen(matrices)


@cache
def derivative_entries(degree: int, dimension: int = 2) -> tuple[tuple[Ints, Floats], ...]:
    """The only entry in each row of the matrices of `derivatives`: its column and its value.

    Row a of the derivative by xi, eta or zeta comes from one monomial of degree k: ``(columns, factors)``, each of
    shape (n_monomials(degree - 1),).
    """
    return tuple((matrix.argmax(axis=1), matrix.max(axis=1)) for matrix in derivatives(degree, dimension))


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
def _product_table(degree: int, dimension: int) -> Ints:
    powers = exponents(degree, dimension)
    return index(powers[:, None, :] + powers[None, :, :])


def mass(degree: int, moments: Floats, dimension: int = 2) -> Floats:
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
    return moments[_product_table(degree, dimension)]
