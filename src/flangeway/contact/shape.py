"""Shape functions on an edge: Lagrange polynomials at its Gauss-Lobatto points."""

from functools import cache

import numpy as np
from numpy.typing import NDArray

from flangeway.elements.quadrature import gauss_lobatto

Floats = NDArray[np.float64]


@cache
def _coefficients(order: int) -> Floats:
    """Power series of the functions, shape (power, node)."""
    nodes = gauss_lobatto(order + 1)[0]
    values: Floats = nodes[:, None] ** np.arange(order + 1)
    return np.asarray(np.linalg.inv(values), dtype=np.float64)


def shape_functions(order: int, xi: Floats) -> tuple[Floats, Floats, Floats]:
    """Values and first and second derivatives at parameters.

    Parameters
    ----------
    order
        Polynomial degree of the edge.
    xi
        Parameters along the edge, 0 at its start and 1 at its end, shape (n,).

    Returns
    -------
    tuple of Floats
        Three arrays of shape (n, order + 1), nodes in the direction of the edge (seed 3.122 and 3.131 with its
        middle node in the middle).

    """
    value = _coefficients(order)
    power = np.arange(1.0, order + 1.0)[:, None]
    first = power * value[1:]
    second = power[:-1] * first[1:]
    return _series(value, xi), _series(first, xi), _series(second, xi)


def _series(coefficients: Floats, xi: Floats) -> Floats:
    return xi[:, None] ** np.arange(len(coefficients)) @ coefficients
