"""Shape functions on an edge: Lagrange polynomials at its Gauss-Lobatto points.

Where an edge is evaluated many times its points are a power series in the parameter. Vectors of the plane are complex
numbers there, x + i y: the real part of ``conj(a) b`` is the dot product of two, the imaginary part a's cross b.
"""

from functools import cache
from typing import TypeVar

import numpy as np
from numpy.typing import NDArray

from flangeway.elements.quadrature import gauss_lobatto
from flangeway.types import Complex, Floats

Number = TypeVar("Number", np.float64, np.complex128)


@cache
def _coefficients(order: int) -> Floats:
    """Power series of the functions, shape (power, node)."""
    nodes = gauss_lobatto(order + 1)[0]
    values: Floats = nodes[:, None] ** np.arange(order + 1)
    return np.asarray(np.linalg.inv(values), dtype=np.float64)


def shape_functions(order: int, xi: Floats, highest: int = 2) -> tuple[Floats, ...]:
    """Values and derivatives at parameters.

    Parameters
    ----------
    order
        Polynomial degree of the edge.
    xi
        Parameters along the edge, 0 at its start and 1 at its end, any shape.
    highest
        Highest derivative.

    Returns
    -------
    tuple of Floats
        ``highest + 1`` arrays of shape (*xi.shape, order + 1), nodes in the direction of the edge (Moherdaui 2021,
        3.122 and 3.131 with its middle node in the middle).

    """
    coefficients = _coefficients(order)
    results = []
    for _ in range(highest + 1):
        value = np.zeros((*xi.shape, order + 1))
        for power in coefficients[::-1]:
            value *= xi[..., None]
            value += power
        results.append(value)
        coefficients = np.arange(1.0, len(coefficients))[:, None] * coefficients[1:]
    return tuple(results)


def as_complex(vectors: Floats) -> Complex:
    """Vectors (..., 2) as complex numbers, shape (...)."""
    numbers: Complex = np.ascontiguousarray(vectors).view(np.complex128)[..., 0]
    return numbers


def as_vectors(numbers: Complex) -> Floats:
    """Complex numbers (...) as vectors (..., 2)."""
    return np.stack((numbers.real, numbers.imag), axis=-1)


def edge_series(edges: Floats) -> Complex:
    """Coefficients of the powers of the parameter for points of edges (..., order + 1, 2), shape (order + 1, ...)."""
    coefficients = _coefficients(edges.shape[-2] - 1)
    return np.ascontiguousarray(np.moveaxis(as_complex(edges) @ coefficients.T, -1, 0))


def derivative(series: NDArray[Number]) -> NDArray[Number]:
    """Coefficients of the derivative by the parameter of power series (n_powers, ...), one power less."""
    powers = np.arange(1.0, len(series)).reshape(-1, *[1] * (series.ndim - 1))
    return np.asarray(powers * series[1:], dtype=series.dtype)


def horner(series: NDArray[Number], xi: Floats) -> NDArray[Number]:
    """Values of power series (n_powers, ...) at parameters, whose shape goes with that of each coefficient."""
    if len(series) == 0:
        return np.zeros(xi.shape, dtype=series.dtype)
    value = series[-1] + 0.0 * xi
    for coefficient in series[-2::-1]:
        value = value * xi + coefficient
    return np.asarray(value)
