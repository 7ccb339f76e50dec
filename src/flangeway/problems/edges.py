"""Integrals along edges of a space: what tractions and springs on named edges need."""

from dataclasses import dataclass

import numpy as np

from flangeway.elements.quadrature import edge_rule
from flangeway.geometry.arrays import IntArray, turned_right
from flangeway.space import Space
from flangeway.types import Floats, Indices, Ints


def entries_between(unknowns: Indices, matrices: Floats) -> tuple[Ints, Ints, Floats]:
    """Rows, columns and entries, each (m,), of symmetric matrices (..., n, n) between unknowns (..., n)."""
    rows, columns, entries = np.broadcast_arrays(unknowns[..., None], unknowns[..., None, :], matrices)
    return rows.ravel().astype(np.int64), columns.ravel().astype(np.int64), entries.ravel()


@dataclass(frozen=True, eq=False)
class EdgeQuadrature:
    """Gauss points on edges with the traces of the nodes."""

    nodes: IntArray  # nodes of each edge in its direction, (n_edges, order + 1)
    points: Floats  # (n_edges, n_points, 2)
    weights: Floats  # lengths that belong to the points, (n_edges, n_points)
    shapes: Floats  # values of the nodes' functions at the points, the same on every edge, (n_points, order + 1)
    normals: Floats  # outward unit normals, (n_edges, n_points, 2)

    def products(self, depth: Floats | float) -> Floats:
        """Integrals of products of the nodes' functions times a depth (n_edges, n_points), (n_edges, n, n)."""
        return np.einsum("eq,qm,qn->emn", self.weights * depth, self.shapes, self.shapes)


def edge_quadrature(space: Space, pairs: Indices, n_points: int | None = None) -> EdgeQuadrature:
    """Quadrature on edges given as pairs of points (n, 2), body on the left.

    Exact to degree ``2 n_points - 1``, by default ``2 order + 3``.

    On curved edges that is the degree along the edge of the integrand times its length or normal.
    """
    weights, shapes, slopes = edge_rule(space.order, space.order + 2 if n_points is None else n_points)
    nodes = space.edge_nodes(pairs)
    start = space.nodes[nodes[:, :1]]
    local = space.nodes[nodes] - start  # no digits are lost far from the origin
    along = slopes @ local
    lengths = np.linalg.norm(along, axis=2)
    normals = turned_right(along) / lengths[..., None]
    return EdgeQuadrature(nodes, start + shapes @ local, lengths * weights, shapes, normals)
