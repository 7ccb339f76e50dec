"""Cells with curved edges: polynomials of degree k through the Gauss-Lobatto points of the true curve.

An *outline* has for each edge of a cell its first vertex and the points inside it, (n_vertices, order, 2, n_cells).
A function of degree k along the edge and the place on it are polynomials of one parameter (isoparametric), so that
linear functions, and with them rigid motions and uniform strains, belong to the space.
"""

from dataclasses import dataclass

import numpy as np

from flangeway.elements import batched, monomials
from flangeway.elements.monomials import Frame, n_monomials
from flangeway.elements.polygon_quadrature import edge_points
from flangeway.elements.projection import Polygons, principal_frame
from flangeway.elements.quadrature import edge_rule
from flangeway.types import Floats


def outline_frame(outline: Floats) -> Frame:
    """Frame of a batch of cells: principal axes of the polygons through all points of the outline."""
    return principal_frame(outline.reshape(-1, *outline.shape[2:]))


@dataclass(frozen=True, eq=False)
class CurvedPolygons(Polygons):
    """Geometry of a batch of cells with curved edges; integrals are exact on the edges' polynomials."""

    outline: Floats  # in local coordinates, (n_vertices, order, 2, n_cells)

    @classmethod
    def of_outline(cls, outline: Floats, frame: Frame) -> "CurvedPolygons":
        """Cells with counter-clockwise edges."""
        order, local = outline.shape[1], frame.local(outline)
        # homogeneous functions again (see `monomials.integrals`), of degree 2 k on edges of degree k
        weights, shapes, slopes = edge_rule(order, order * (order + 1))
        nodes = edge_points(local)
        points, along = np.einsum("qj,vjie->vqie", shapes, nodes), np.einsum("qj,vjie->vqie", slopes, nodes)
        areas = batched.cross(points, along) * weights[:, None]
        moments = np.einsum("avqe,vqe->ae", monomials.evaluate(2 * order, points), areas)
        moments /= (monomials.exponents(2 * order).sum(axis=1) + 2)[:, None] * frame.determinant
        ends = np.einsum("ije,vje->vie", frame.inverse, np.roll(local[:, 0], -1, axis=0) - local[:, 0])
        return cls(order, frame, local[:, 0], batched.turned_right(ends), moments, local)

    def boundary_values(self) -> Floats:
        """See `Polygons.boundary_values`."""
        inner = self.outline[:, 1:].reshape(-1, 2, self.outline.shape[-1])
        return monomials.evaluate(self.order, np.concatenate((self.outline[:, 0], inner)))

    def gradient_moments(self, boundary: Floats) -> Floats:
        """See `Polygons.gradient_moments`; Gauss points, since the monomials are of a higher degree along edges."""
        order, n_cells = self.order, self.outline.shape[-1]
        moments = super().gradient_moments(boundary)
        weights, shapes, slopes = edge_rule(order, (order * (order + 1) + 1) // 2)
        nodes = edge_points(self.outline)
        values = monomials.evaluate(order - 1, np.einsum("qj,vjie->vqie", shapes, nodes))
        # normals times lengths are the cofactors of the frame's inverse times local ones
        along = np.einsum("qj,vjie->vqie", slopes, nodes)
        cofactors = self.frame.map / self.frame.determinant
        normals = np.einsum("jie,vqje->ivqe", cofactors, batched.turned_right(along))
        n_edges, n_low = len(nodes), n_monomials(order - 1)
        products = (values[:, None] * normals).transpose(0, 1, 2, 4, 3) @ (weights[:, None] * shapes)
        traces = products.transpose(0, 1, 2, 4, 3)  # (n_low, 2, n_edges, order + 1, n_cells)
        moments[:, :, :n_edges] = traces[:, :, :, 0] + np.roll(traces[:, :, :, -1], 1, axis=2)
        moments[:, :, n_edges : self.n_boundary] = traces[:, :, :, 1:-1].reshape(n_low, 2, -1, n_cells)
        return moments
