"""Integrals along edges of a space: what tractions and springs on named edges need."""

from dataclasses import dataclass

import numpy as np

from flangeway.elements.quadrature import edge_rule, edge_shapes, gauss
from flangeway.geometry.arrays import IntArray, turned_right
from flangeway.space import Space
from flangeway.types import Floats, Indices


@dataclass(frozen=True, eq=False)
class EdgeQuadrature:
    """Gauss points on edges with the traces of the nodes."""

    nodes: IntArray  # nodes of each edge in its direction, (n_edges, order + 1)
    points: Floats  # (n_edges, n_points, 2)
    weights: Floats  # lengths that belong to the points, (n_edges, n_points)
    shapes: Floats  # values of the nodes' functions at the points, the same on every edge, (n_points, order + 1)
    normals: Floats  # outward unit normals, (n_edges, n_points, 2)


def edge_quadrature(space: Space, pairs: Indices, n_points: int | None = None) -> EdgeQuadrature:
    """Quadrature on edges given as pairs of points (n, 2), body on the left.

    Exact to degree ``2 n_points - 1``, by default ``2 order + 3``.

    On curved edges that is the degree along the edge of the integrand times its length or normal.
    """
    abscissae, weights = gauss(space.order + 2 if n_points is None else n_points)
    start, end = space.mesh.points[pairs[:, 0]], space.mesh.points[pairs[:, 1]]
    along = end - start
    lengths = np.linalg.norm(along, axis=1)
    normals = turned_right(along) / lengths[:, None]
    points = start[:, None] + abscissae[:, None] * along[:, None]
    shapes = edge_shapes(space.order, abscissae)
    normals = np.repeat(normals[:, None], len(abscissae), axis=1)
    nodes, sizes = space.edge_nodes(pairs), lengths[:, None] * weights
    if space.mesh.curves is not None:
        curved = np.flatnonzero(space.mesh.curve_rows[space.mesh.edge_numbers(pairs)] >= 0)
        _, _, slopes = edge_rule(space.order, len(abscissae))
        own = space.nodes[nodes[curved]]
        points[curved], along = shapes @ own, slopes @ own
        lengths = np.linalg.norm(along, axis=2)
        normals[curved] = turned_right(along) / lengths[..., None]
        sizes[curved] = lengths * weights
    return EdgeQuadrature(nodes, points, sizes, shapes, normals)
