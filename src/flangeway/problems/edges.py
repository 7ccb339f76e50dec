"""Integrals along edges of a space: what tractions and springs on named edges need."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from flangeway.elements.quadrature import gauss, gauss_lobatto
from flangeway.space import Space
from flangeway.types import Floats


@dataclass(frozen=True, eq=False)
class EdgeQuadrature:
    """Gauss points on straight edges with the traces of the nodes."""

    nodes: NDArray[np.int32]  # nodes of each edge in its direction, (n_edges, order + 1)
    points: Floats  # (n_edges, n_points, 2)
    weights: Floats  # lengths that belong to the points, (n_edges, n_points)
    shapes: Floats  # values of the nodes' functions at the points, the same on every edge, (n_points, order + 1)
    normals: Floats  # outward unit normals, (n_edges, 2)


def edge_quadrature(space: Space, pairs: NDArray[np.integer]) -> EdgeQuadrature:
    """Quadrature, exact to degree ``2 order + 3``, on edges given as pairs of points (n, 2), body on the left."""
    abscissae, weights = gauss(space.order + 2)
    start, end = space.mesh.points[pairs[:, 0]], space.mesh.points[pairs[:, 1]]
    along = end - start
    lengths = np.linalg.norm(along, axis=1)
    normals = np.stack((along[:, 1], -along[:, 0]), axis=1) / lengths[:, None]
    points = start[:, None] + abscissae[:, None] * along[:, None]
    shapes = edge_shapes(space.order, abscissae)
    return EdgeQuadrature(space.edge_nodes(pairs), points, lengths[:, None] * weights, shapes, normals)


def edge_shapes(order: int, places: Floats) -> Floats:
    """Lagrange's polynomials of the Gauss-Lobatto points at places (n,) in [0, 1], shape (n, order + 1)."""
    nodes = gauss_lobatto(order + 1)[0]
    own = np.eye(order + 1, dtype=np.bool_)
    apart = np.where(own, 1.0, nodes[:, None] - nodes)
    factors = np.where(own, 1.0, (places[:, None, None] - nodes) / apart)
    shapes: Floats = factors.prod(axis=2)
    return shapes
