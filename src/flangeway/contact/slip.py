"""Slip between two surfaces since an earlier position, and the directions of their tangential forces.

The slip of a point is measured where the bodies were before. With the edge's point ``x(xi)`` that faces it now and the
edge's unit tangent e, both at the earlier position, it is ``s = -e . (x_s - x(xi))``: the way of the point along the
edge. It does not change with rigid motions of both bodies together, is the way along the surface on straight edges
whichever of them the point has passed, and needs no partner at the earlier position. The tangential force is the one
whose power with any velocities is that with the slip's rate, ``|x'| xi_dot`` (T. A. Laursen, 2002, "Computational
Contact and Impact Mechanics", 4.2): it is in equilibrium on both bodies.
"""

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from flangeway.contact.kinematics import derivative, edge_series, gaps_over, horner
from flangeway.contact.taylor import Taylor, as_complex, dot
from flangeway.types import Floats, Ints


@dataclass(frozen=True, eq=False)
class Slides:
    """Slips of m constraints since an earlier position, of p terms with w points each; see `Pairs`.

    Parameters
    ----------
    slips
        How far the secondary has moved along the primary's direction, shape (m,).
    rates
        What each term adds to the derivatives of the slips by the positions of its points, shape (p, r, w, 2).
    directions
        What it adds to the forces on its points for a unit of tangential force, shape (p, r, w, 2).
    turns
        Called with tangential forces (m,): terms under load (q,), and the derivatives of their forces on the points by
        the points' positions, not symmetric, shape (q, 2 w, 2 w).

    """

    slips: Floats
    rates: Floats
    directions: Floats
    turns: Callable[[Floats], tuple[Ints, Floats]]


def node_edge_slips(points: Taylor, parameters: Floats, before: Floats) -> tuple[Taylor, Floats]:
    """Slips of nodes along edges since an earlier position, and unit tangential forces.

    Parameters
    ----------
    points
        Current positions of each node and of the nodes of its edge, shape (p, order + 2), with derivatives.
    parameters
        Those of the feet, shape (p,).
    before
        Earlier positions, shape (p, order + 2, 2).

    Returns
    -------
    tuple
        Slips (p,), and the forces on the points by their d variables, shape (p, d).

    """
    xi, _, length = gaps_over(points, parameters)
    series = edge_series(before[:, 1:])
    slope = horner(derivative(series), xi)
    slips = dot(slope, horner(series, xi) - as_complex(before[:, 0])) / slope.abs
    return slips, (length.value * xi.first).T


def node_edge_turns(points: Taylor, parameters: Floats) -> Floats:
    """Derivatives (p, d, d) of unit tangential forces ``|x'| dxi/du``; points with second ones."""
    xi, _, length = gaps_over(points, parameters)
    assert xi.second is not None
    turns: Floats = xi.first[:, None] * length.first + length.value * xi.second
    return np.moveaxis(turns, -1, 0)
