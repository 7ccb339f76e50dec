"""Gap between a node and an edge, with its first and second derivatives (Moherdaui 2021, 3.5.1 to 3.5.6).

With the closest point ``x_m(xi)``, the edge's tangent ``t = x_m,xi`` and its unit normal n, which points out of the
primary body, the gap is ``g = n . (x_s - x_m)``: open where positive.
"""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from flangeway.contact.edge_shapes import as_complex, derivative, edge_series, horner, shape_functions
from flangeway.types import Floats

ENOUGH = 1e-9
"""Change of a parameter after which another of Newton's, of the size of its square, is round-off."""


@dataclass(frozen=True, eq=False)
class NodeEdgeGaps:
    """Gaps of n pairs of a node and an edge of some order.

    Parameters
    ----------
    parameters
        Closest points' parameters xi, shape (n,).
    gaps
        Shape (n,).
    normals
        Unit normals out of the primary side, shape (n, 2).
    gradients
        First derivatives by the positions of the node and then the edge's nodes, shape (n, 2 + order, 2).
    hessians
        Second derivatives, shape (n, 2 (2 + order), 2 (2 + order)).

    """

    parameters: Floats
    gaps: Floats
    normals: Floats
    gradients: Floats
    hessians: Floats

    def take(self, chosen: NDArray[np.int64] | NDArray[np.bool_]) -> "NodeEdgeGaps":
        """Some of the pairs."""
        return NodeEdgeGaps(
            self.parameters[chosen],
            self.gaps[chosen],
            self.normals[chosen],
            self.gradients[chosen],
            self.hessians[chosen],
        )


def closest_parameters(nodes: Floats, edges: Floats) -> Floats:
    """Parameter of the point of each edge (extended beyond its ends) that is closest to a node.

    Straight edges have the closed form of Moherdaui (2021, 3.125), which is also the first guess of the Newton
    iteration for curved ones (Moherdaui 2021, 3.135).

    Parameters
    ----------
    nodes
        Shape (n, 2).
    edges
        Nodes of the edges in direction, shape (n, order + 1, 2).

    """
    series, points = edge_series(edges), as_complex(nodes)
    chord = series[1:].sum(axis=0)
    xi: Floats = (np.conj(chord) * (points - series[0])).real / (chord * np.conj(chord)).real
    slopes = derivative(series)
    bends = derivative(slopes)
    for _ in range(20 if len(series) > 2 else 0):
        apart, tangent = points - horner(series, xi), horner(slopes, xi)
        slope = (np.conj(apart) * horner(bends, xi)).real - (tangent * np.conj(tangent)).real
        change = np.clip((np.conj(apart) * tangent).real / slope, -0.5, 0.5)
        xi = xi - change
        if np.abs(change).max(initial=0.0) < ENOUGH:
            break
    return xi


def node_edge_gaps(nodes: Floats, edges: Floats) -> NodeEdgeGaps:
    """Gaps of nodes over edges whose body lies on the left of their direction.

    Parameters
    ----------
    nodes
        Current positions, shape (n, 2).
    edges
        Current positions of the edges' nodes in direction, shape (n, order + 1, 2).

    """
    order = edges.shape[1] - 1
    xi = closest_parameters(nodes, edges)
    value, first, second = shape_functions(order, xi)
    tangent = np.einsum("na,nai->ni", first, edges)
    metric = np.einsum("ni,ni->n", tangent, tangent)
    unit = tangent / np.sqrt(metric)[:, None]
    normal = np.stack((unit[:, 1], -unit[:, 0]), axis=1)
    gap = np.einsum("ni,ni->n", nodes - np.einsum("na,nai->ni", value, edges), normal)
    curvature = np.einsum("ni,na,nai->n", normal, second, edges)

    ones, zeros = np.ones((len(xi), 1)), np.zeros((len(xi), 1))
    apart = np.concatenate((ones, -value), axis=1)
    slope = np.concatenate((zeros, first), axis=1)
    gradient = apart[:, :, None] * normal[:, None, :]
    turning = slope[:, :, None] * normal[:, None, :]
    sliding = apart[:, :, None] * tangent[:, None, :] + gap[:, None, None] * turning
    sliding /= (metric - gap * curvature)[:, None, None]

    n_local = 2 * apart.shape[1]
    turn, slide = turning.reshape(-1, n_local), sliding.reshape(-1, n_local)
    rotation = turn + curvature[:, None] * slide
    hessian = (gap / metric)[:, None, None] * rotation[:, :, None] * rotation[:, None, :]
    cross = turn[:, :, None] * slide[:, None, :]
    hessian -= cross + cross.swapaxes(1, 2)
    hessian -= curvature[:, None, None] * slide[:, :, None] * slide[:, None, :]
    return NodeEdgeGaps(xi, gap, normal, gradient, hessian)
