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
        ``highest + 1`` arrays of shape (*xi.shape, order + 1), nodes in the direction of the edge (seed 3.122 and 3.131
        with its middle node in the middle).

    """
    coefficients = _coefficients(order)
    results = []
    for _ in range(highest + 1):
        results.append(xi[..., None] ** np.arange(len(coefficients)) @ coefficients)
        coefficients = np.arange(1.0, len(coefficients))[:, None] * coefficients[1:]
    return tuple(results)
