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

from flangeway.contact.kinematics import shape_functions
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
    edges: Floats, gaps: Floats, parameters: Floats, nodes_before: Floats, edges_before: Floats
) -> tuple[Floats, Floats, Floats, Floats]:
    """Slips of nodes along edges.

    Parameters
    ----------
    edges
        Current positions of the edges' nodes, shape (n, order + 1, 2).
    gaps, parameters
        From `NodeEdgeGaps`, each (n,).
    nodes_before, edges_before
        Earlier positions of the nodes (n, 2) and of the edges' nodes.

    Returns
    -------
    tuple of Floats
        Slips (n,); with d numbers for the components of the node and then of the edge's nodes: their derivatives
        (n, d), unit tangential forces (n, d), and the derivatives of these (n, d, d).

    """
    values = shape_functions(edges.shape[1] - 1, parameters, 3)
    slope, bend, twist = (np.einsum("na,nai->ni", each, edges) for each in values[1:])
    length = np.linalg.norm(slope, axis=1)[:, None]
    tangent = slope / length
    normal = np.stack((tangent[:, 1], -tangent[:, 0]), axis=1)
    gap = gaps[:, None]
    bend_t, bend_n, twist_n = (
        np.einsum("ni,ni->n", *pair)[:, None] for pair in ((tangent, bend), (normal, bend), (normal, twist))
    )
    metric = length**2 - gap * bend_n
    ones, zeros = np.ones_like(gap), np.zeros_like(gap)
    apart = np.concatenate((ones, -values[0]), axis=1)
    slopes, bends = (np.concatenate((zeros, each), axis=1) for each in values[1:3])

    def along(shapes: Floats, direction: Floats) -> Floats:
        return (shapes[:, :, None] * direction[:, None, :]).reshape(len(shapes), 2 * shapes.shape[1])

    def outer(one: Floats, other: Floats) -> Floats:
        return one[:, :, None] * other[:, None, :]

    apart_t, apart_n = along(apart, tangent), along(apart, normal)
    slope_t, slope_n, across = along(slopes, tangent), along(slopes, normal), along(bends, normal)
    slide = (length * apart_t + gap * slope_n) / metric
    turn, stretch = slope_n + bend_n * slide, slope_t + bend_t * slide
    metric_rate = 2.0 * length * stretch - bend_n * apart_n
    metric_rate -= gap * (across + twist_n * slide - turn * bend_t / length)
    direction = length * slide
    turns = outer(apart_t, stretch) - outer(slope_t, length * slide + gap / length * turn) + outer(apart_n, turn)
    turns += outer(slope_n, apart_n) + outer(across, gap * slide)
    turns *= (length / metric)[..., None]
    turns += outer(direction, stretch / length - metric_rate / metric)

    slope, bend = (np.einsum("na,nai->ni", each, edges_before) for each in values[1:3])
    before = np.linalg.norm(slope, axis=1)
    tangent = slope / before[:, None]
    normal = np.stack((tangent[:, 1], -tangent[:, 0]), axis=1)
    away = nodes_before - np.einsum("na,nai->ni", values[0], edges_before)
    slips = -np.einsum("ni,ni->n", tangent, away)
    by_parameter = before - np.einsum("ni,ni->n", normal, bend) * np.einsum("ni,ni->n", normal, away) / before
    return slips, by_parameter[:, None] * slide, direction, turns
