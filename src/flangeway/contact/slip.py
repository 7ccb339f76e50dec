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

from flangeway.contact.kinematics import derivative, edge_series, foot, horner, taylor_series
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


def node_edge_slides(
    nodes: Floats, edges: Floats, parameters: Floats, nodes_before: Floats, edges_before: Floats
) -> tuple[Floats, Floats, Floats, Floats]:
    """Slips of nodes along edges.

    Parameters
    ----------
    nodes, edges
        Current positions of the nodes (n, 2) and of the edges' nodes, shape (n, order + 1, 2).
    parameters
        From `NodeEdgeGaps`, (n,).
    nodes_before, edges_before
        Earlier positions of the same.

    Returns
    -------
    tuple of Floats
        Slips (n,); with d numbers for the components of the node and then of the edge's nodes: their derivatives
        (n, d), unit tangential forces (n, d), and the derivatives of these (n, d, d).

    """
    points = Taylor.of_points(np.concatenate((nodes[:, None], edges), axis=1), second=True)
    n_points = points.value.shape[1]
    series = taylor_series(points, 1, n_points)
    xi = foot(series, points.weighted(np.eye(n_points)[0]), parameters)
    length = horner(derivative(series), xi).abs
    assert xi.second is not None
    # the unit force T_i = |x'| dxi/du_i, and dT_i/du_j
    directions = length.value[:, None] * xi.first
    turns = xi.first[:, :, None] * length.first[:, None, :] + length.value[:, None, None] * xi.second

    before = edge_series(edges_before)
    slope = horner(derivative(before), xi)
    slips = dot(slope, horner(before, xi) - as_complex(nodes_before)) / slope.abs
    return slips.value, slips.first, directions, turns
