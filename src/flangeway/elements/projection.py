"""The integrals behind the projections of virtual elements, and polynomials on curved edges of cells."""

from abc import ABC, abstractmethod
from dataclasses import dataclass, field

import numpy as np

from flangeway.elements import batched, monomials
from flangeway.elements.monomials import Frame, n_monomials
from flangeway.elements.quadrature import edge_points, edge_rule, gauss_lobatto
from flangeway.geometry.arrays import steps_around
from flangeway.types import Floats

# --- The integrals behind the projections of virtual elements (Moherdaui 2021, 3.3.3), for whole batches of polygons.


@dataclass(frozen=True, eq=False)
class CellGeometry(ABC):
    """Geometry of a batch of polygons or polyhedra and the monomials' integrals over them."""

    order: int  # order k of the element
    frame: Frame  # local coordinates of the monomials
    local: Floats  # vertices in local coordinates, (n_vertices, d, n_cells)
    normals: Floats  # outward normals in space times lengths of edges, or see `Polyhedra`, (n_vertices, d, n_cells)
    moments: Floats  # integrals of the monomials up to degree 2 k, (n_monomials(2 k), n_cells)
    inner: Floats | None = field(default=None, kw_only=True)  # see `inner_factor`

    @abstractmethod
    def boundary_values(self) -> Floats:
        """Monomials of degree k at the boundary's degrees of freedom, (n_monomials(k), n, n_cells)."""

    @abstractmethod
    def gradient_moments(self, boundary: Floats) -> Floats:
        """Integrals of the basis functions' gradients times the monomials of degree k - 1.

        - `boundary`: of `boundary_values`.

        Returned: shape (n_monomials(k - 1), d, n_local, n_cells).
        """

    @property
    def n_boundary(self) -> int:
        """Degrees of freedom on the boundary of a cell."""
        return self.order * len(self.local)

    def monomial_dofs(self, boundary: Floats) -> Floats:
        """Degrees of freedom of the monomials, matrix D (Moherdaui 2021, 3.64), (n_local, n_monomials(k), n_cells)."""
        n_inner = n_monomials(self.order - 2, len(self.frame.map))
        if not n_inner:
            return np.ascontiguousarray(boundary.swapaxes(0, 1))
        means = monomials.mass(self.order, self.moments, len(self.frame.map))[:n_inner] / self.moments[0]
        if self.inner is not None:
            batched.solve_lower(self.inner, means, out=means)
        return np.concatenate((boundary.swapaxes(0, 1), means))

    def energy_matrices(self, gradient_moments: Floats) -> tuple[Floats, Floats]:
        """Gradient products of the monomials from degree 1, and of these with the basis functions.

        These are the matrices G and B without their first rows (Moherdaui 2021, 3.56, 3.60): shapes
        (n, n, n_cells) and (n, n_local, n_cells) with ``n = n_monomials(k) - 1``.
        """
        order, map_, dimension = self.order, self.frame.map, len(self.frame.map)
        # the metric of the frame: grad m . grad m' = (map^T d m) . (map^T d m')
        metric = np.einsum("jie,kie->jke", map_, map_)
        mass = monomials.mass(order - 1, self.moments, dimension)
        # each derivative of a monomial is a multiple of one monomial: sums are gathers with factors
        entries = monomials.derivative_entries(order, dimension)
        n = n_monomials(order, dimension)
        gram = np.zeros((n, n, mass.shape[-1]))
        rhs = np.zeros((n, *gradient_moments.shape[2:]))
        for j, (columns, factors) in enumerate(entries):
            for k, (other_columns, other_factors) in enumerate(entries):
                products = mass * (np.outer(factors, other_factors)[:, :, None] * metric[j, k])
                gram[columns[:, None], other_columns] += products
            along = gradient_moments[:, 0] * map_[j, 0]
            for axis in range(1, dimension):
                along += gradient_moments[:, axis] * map_[j, axis]
            rhs[columns] += factors[:, None, None] * along
        return gram[1:, 1:], rhs[1:]

    def means(self) -> Floats:
        """The functional that fixes the constant: vertex average (k = 1) or mean, shape (n_local,)."""
        mean = np.zeros(self.n_boundary + n_monomials(self.order - 2, len(self.frame.map)))
        if self.order == 1:
            mean[:] = 1.0 / self.n_boundary
        else:
            mean[self.n_boundary] = 1.0
        return mean

    def energy_projection(self, monomial_dofs: Floats, gradient_moments: Floats) -> tuple[Floats, Floats]:
        """Energy projection and the integrals that it is made of (Moherdaui 2021, 3.60, 3.62).

        Returns
        -------
        tuple of Floats
            Coefficients of the projection, (n_monomials(k), n_local, n_cells), and the gradient products of the
            monomials from degree 1 with the basis functions, (n_monomials(k) - 1, n_local, n_cells).

        """
        gram, rhs = self.energy_matrices(gradient_moments)
        value = np.empty((len(gram) + 1, *rhs.shape[1:]))
        batched.solve(gram, rhs, out=value[1:])
        mean = self.means()
        of_monomials = np.einsum("i,iae->ae", mean, monomial_dofs[:, 1:])
        np.einsum("ae,aie->ie", of_monomials, value[1:], out=value[0])
        np.subtract(mean[:, None], value[0], out=value[0])
        return value, rhs


@dataclass(frozen=True, eq=False)
class Polygons(CellGeometry):
    """Geometry of a batch of polygons."""

    @classmethod
    def of(cls, vertices: Floats, order: int, frame: Frame) -> "Polygons":
        """Polygons with counter-clockwise vertices (n_vertices, 2, n_cells)."""
        local = frame.local(vertices)
        normals = batched.turned_right(steps_around(vertices))
        moments = monomials.integrals(2 * order, local, 1.0 / frame.determinant)
        return cls(order, frame, local, normals, moments)

    def boundary_values(self) -> Floats:
        """Monomials of degree k at the boundary's degrees of freedom, (n_monomials(k), n, n_cells)."""
        start, end = self.local, np.roll(self.local, -1, axis=0)
        inner = gauss_lobatto(self.order + 1)[0][1:-1, None, None]
        on_edges = start[:, None] + inner * (end - start)[:, None]
        points = np.concatenate((self.local, on_edges.reshape(-1, 2, self.local.shape[-1])))
        return monomials.evaluate(self.order, points)

    def gradient_moments(self, boundary: Floats) -> Floats:
        """Integrals of the basis functions' gradients times the monomials of degree k - 1.

        Green's formula ``int grad v m = -int v grad m + int_boundary v m n`` needs the traces, integrated
        exactly by the Gauss-Lobatto points that carry them, and the moments up to degree k - 2.

        Returns
        -------
        Floats
            Shape (n_monomials(k - 1), 2, n_local, n_cells).

        """
        order, n_cells = self.order, self.normals.shape[-1]
        n_low, n_inner = n_monomials(order - 1), n_monomials(order - 2)
        weights = gauss_lobatto(order + 1)[1]
        at_vertices = weights[0] * (self.normals + np.roll(self.normals, 1, axis=0))
        on_edges = weights[1:-1, None, None] * self.normals[:, None]
        weighted = np.concatenate((at_vertices, on_edges.reshape(-1, 2, n_cells)))
        moments = np.empty((n_low, 2, self.n_boundary + n_inner, n_cells))
        np.multiply(boundary[:n_low, None], weighted.swapaxes(0, 1), out=moments[:, :, : self.n_boundary])
        if n_inner:
            local = monomials.derivatives(order - 1)
            in_space = np.einsum("jie,jga->aige", self.frame.map, local)
            if self.inner is not None:
                in_space = np.einsum("aige,ghe->aihe", in_space, self.inner)
            moments[:, :, self.n_boundary :] = -in_space * self.moments[0]
        return moments


def inner_factor(order: int, moments: Floats) -> Floats | None:
    """Monomials of degree k - 2 in terms of the polynomials whose moments are the unknowns inside cells: ``m = L q``.

    The polynomials q are the monomials orthogonalised in turn, with 1 on the diagonal of L. Moments with the monomials
    themselves nearly depend on each other from degree 4 on, and condensing them costs the digits. Up to degree 1 the
    principal frame makes the monomials orthogonal: None.

    Parameters
    ----------
    order
        Order k of the element.
    moments
        Integrals of the monomials up to degree 2 k - 4 or more, (n, n_cells).

    Returns
    -------
    Floats or None
        Lower triangular, shape (n_monomials(k - 2), n_monomials(k - 2), n_cells).

    """
    if order < 4:
        return None
    factor = batched.cholesky(monomials.mass(order - 2, moments))
    return factor / np.einsum("aae->ae", factor)


def principal_frame(vertices: Floats) -> Frame:
    """Frame in which every polygon has the second moments of the unit circle, whatever its stretch.

    Coordinates are taken about a vertex first, so that cells far from the origin lose no digits.

    Parameters
    ----------
    vertices
        Counter-clockwise vertices, shape (n_vertices, 2, n_cells).

    """
    base = vertices[0]
    start = vertices - base
    end = np.roll(start, -1, axis=0)
    cross = batched.cross(start, end)
    area = cross.sum(axis=0) / 2.0
    centroid = np.einsum("vie,ve->ie", start + end, cross) / (6.0 * area)
    start, end = start - centroid, end - centroid
    cross = batched.cross(start, end)
    total = start + end
    second = np.einsum("vie,vje,ve->ije", total, total, cross)
    second += np.einsum("vie,vje,ve->ije", start, start, cross)
    second += np.einsum("vie,vje,ve->ije", end, end, cross)
    factor = 2.0 * batched.cholesky(second / (24.0 * area))
    inverse = np.zeros_like(factor)
    inverse[0, 0] = 1.0 / factor[0, 0]
    inverse[1, 1] = 1.0 / factor[1, 1]
    inverse[1, 0] = -factor[1, 0] * inverse[0, 0] * inverse[1, 1]
    return Frame(centroid + base, inverse)


# --- Cells with curved edges: polynomials of degree k through the Gauss-Lobatto points of the true curve.
#
# An *outline* has for each edge of a cell its first vertex and the points inside it, (n_vertices, order, 2, n_cells).
# A function of degree k along the edge and the place on it are polynomials of one parameter (isoparametric), so that
# linear functions, and with them rigid motions and uniform strains, belong to the space.


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
