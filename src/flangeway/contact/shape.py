"""Shape functions on an edge: Lagrange polynomials at its Gauss-Lobatto points."""

from functools import cache

import numpy as np
from numpy.polynomial import polynomial
from numpy.typing import NDArray

from flangeway.elements.quadrature import gauss_lobatto

Floats = NDArray[np.float64]


@cache
def _coefficients(order: int) -> tuple[Floats, ...]:
    """Power series of the functions and of their first and second derivatives, (power, node)."""
    nodes = gauss_lobatto(order + 1)[0]
    value: Floats = np.linalg.inv(np.vander(nodes, increasing=True))
    first: Floats = polynomial.polyder(value)
    second: Floats = polynomial.polyder(first)
    return value, first, second


def shape_functions(order: int, xi: Floats) -> tuple[Floats, ...]:
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
    return tuple(polynomial.polyval(xi, series).T for series in _coefficients(order))
