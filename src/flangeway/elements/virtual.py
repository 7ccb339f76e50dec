"""The virtual element of order k on simple polygons (seed 3.3.1 to 3.3.5 and 3.3.7)."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from flangeway.elements import batched, monomials
from flangeway.elements.monomials import Frame, n_monomials
from flangeway.elements.quadrature import gauss_lobatto
from flangeway.elements.reconstruction import Element, Reconstruction
from flangeway.errors import InputError

Floats = NDArray[np.float64]


@dataclass(frozen=True)
class Virtual(Element):
    """Virtual element: polynomials of degree k on the edges, moments up to degree k - 2 inside.

    The gradient is reconstructed by its L2 projection onto polynomials of degree k - 1, whose symmetric part is
    the projection onto strains of Artioli et al. (2017, Comput. Mech. 60, eq. 14; seed 3.84 to 3.88), and the
    value by the projection that is orthogonal in energy (Beirao da Veiga et al., 2013; seed 3.58 to 3.66).

    Parameters
    ----------
    order
        Order k >= 1.
    tau
        Factor of the stabilisation ``tau tr(K_c) (I - Q Q^T)``, where the columns of Q are an orthonormal basis of
        the polynomials' degrees of freedom (seed 3.96; 0.5 there).

    """

    order: int
    tau: float = 0.5

    def __post_init__(self) -> None:
        if self.order < 1:
            raise InputError(
                f"Virtual(order={self.order})", "an order of 1 or more", "choose order=1 or order=2"
            )
        if not (np.isfinite(self.tau) and self.tau > 0.0):
            raise InputError(
                f"Virtual(tau={self.tau})", "a positive number", "use the published value tau=0.5"
            )

    def n_interior(self) -> int:
        """Moments inside the cell: the dimension of the polynomials of degree k - 2."""
        return n_monomials(self.order - 2)

    def check_cells(self, n_vertices: int) -> None:
        """Accept every polygon."""
        if n_vertices < 3:
            raise InputError(
                f"a cell with {n_vertices} vertices", "3 or more", "check the mesh"
            )

    def reconstruct(self, vertices: Floats) -> Reconstruction:
        """Project on each polygon; see `Element.reconstruct`."""
        order = self.order
        cells = _Cells.of(vertices, order)
        inverse_area = 1.0 / cells.moments[0]
        boundary = cells.boundary_values()
        gradient = _gradient(cells, boundary)
        monomial_dofs = np.concatenate(
            (
                boundary.swapaxes(0, 1),
                monomials.mass(order, cells.moments)[: self.n_interior()] * inverse_area,
            )
        )
        value = _value(cells, gradient, monomial_dofs)
        return Reconstruction(
            order, cells.frame, value, gradient, cells.moments, monomial_dofs, exact=False
        )

    def stabilisation(self, reconstruction: Reconstruction, consistency: Floats) -> Floats:
        """Seed (3.96), for one component; the trace is over all components."""
        dofs = reconstruction.monomial_dofs
        gram = np.einsum("iae,ibe->abe", dofs, dofs)
        polynomial = np.einsum("iae,aje->ije", dofs, batched.solve(gram, dofs.swapaxes(0, 1)))
        trace = np.einsum("cciie->e", consistency)
        return self.tau * trace * (np.eye(reconstruction.n_local)[:, :, None] - polynomial)


@dataclass(frozen=True)
class _Cells:
    """Geometry of a batch that the projections share."""

    order: int
    frame: Frame
    local: Floats  # local vertices (n_vertices, 2, n_cells)
    normals: Floats  # outward normals times edge lengths (n_vertices, 2, n_cells)
    moments: Floats  # integrals of monomials up to degree 2 k

    @classmethod
    def of(cls, vertices: Floats, order: int) -> "_Cells":
        frame = _principal_frame(vertices)
        local = frame.local(vertices)
        along = np.roll(vertices, -1, axis=0) - vertices
        normals = np.stack((along[:, 1], -along[:, 0]), axis=1)
        determinant = frame.map[0, 0] * frame.map[1, 1] - frame.map[0, 1] * frame.map[1, 0]
        moments = monomials.integrals(2 * order, local, 1.0 / determinant)
        return cls(order, frame, local, normals, moments)

    def boundary_values(self) -> Floats:
        """Monomials of degree k at the boundary's degrees of freedom, (n_monomials, n, n_cells)."""
        start, end = self.local, np.roll(self.local, -1, axis=0)
        inner = gauss_lobatto(self.order + 1)[0][1:-1, None, None]
        on_edges = start[:, None] + inner * (end - start)[:, None]
        points = np.concatenate((self.local, on_edges.reshape(-1, 2, self.local.shape[-1])))
        return monomials.evaluate(self.order, points)


def _principal_frame(vertices: Floats) -> Frame:
    """Frame in which every cell has the second moments of the unit circle, whatever its stretch.

    Coordinates are taken about a vertex first, so that cells far from the origin lose no digits.
    """
    base = vertices[0]
    start = vertices - base
    end = np.roll(start, -1, axis=0)
    cross = start[:, 0] * end[:, 1] - start[:, 1] * end[:, 0]
    area = cross.sum(axis=0) / 2.0
    centroid = np.einsum("vie,ve->ie", start + end, cross) / (6.0 * area)
    start, end = start - centroid, end - centroid
    cross = start[:, 0] * end[:, 1] - start[:, 1] * end[:, 0]
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


def _gradient(cells: _Cells, boundary: Floats) -> Floats:
    """L2 projection of the gradient onto degree k - 1.

    Green's formula ``int grad v m = -int v grad m + int_boundary v m n`` needs the traces, integrated exactly by
    the Gauss-Lobatto points that carry them, and the moments up to degree k - 2.
    """
    order, n_vertices = cells.order, cells.local.shape[0]
    n_low, n_inner = n_monomials(order - 1), n_monomials(order - 2)
    weights = gauss_lobatto(order + 1)[1]
    traces = boundary[:n_low]
    at_vertices = weights[0] * (cells.normals + np.roll(cells.normals, 1, axis=0))
    on_edges = weights[1:-1, None, None] * cells.normals[:, None]
    weighted = np.concatenate((at_vertices, on_edges.reshape(-1, 2, cells.normals.shape[-1])))
    n_boundary = n_vertices * order
    rhs = np.empty((n_low, 2, n_boundary + n_inner, cells.normals.shape[-1]))
    rhs[:, :, :n_boundary] = traces[:, None] * weighted.swapaxes(0, 1)
    if n_inner:
        local = monomials.derivatives(order - 1)
        in_space = np.einsum("jie,jga->aige", cells.frame.map, local)
        rhs[:, :, n_boundary:] = -in_space * cells.moments[0]
    mass = monomials.mass(order - 1, cells.moments)
    return batched.solve(mass, rhs.reshape(n_low, -1, rhs.shape[-1])).reshape(rhs.shape)


def _value(cells: _Cells, gradient: Floats, monomial_dofs: Floats) -> Floats:
    """Energy projection onto degree k, its mean fixed by the vertices (k = 1) or the mean moment."""
    order, n_vertices = cells.order, cells.local.shape[0]
    local = monomials.derivatives(order)[:, :, 1:]
    in_space = np.einsum("jie,jab->aibe", cells.frame.map, local)
    mass = monomials.mass(order - 1, cells.moments)
    weighted = np.einsum("ace,cibe->aibe", mass, in_space)
    gram = np.einsum("aime,aine->mne", in_space, weighted)
    rhs = np.einsum("aime,aine->mne", weighted, gradient)
    value = np.empty((len(gram) + 1, *gradient.shape[2:]))
    value[1:] = batched.solve(gram, rhs)
    mean = np.zeros(gradient.shape[2])
    if order == 1:
        mean[:n_vertices] = 1.0 / n_vertices
    else:
        mean[n_vertices * order] = 1.0
    means = np.einsum("i,iae->ae", mean, monomial_dofs[:, 1:])
    value[0] = mean[:, None] - np.einsum("ae,aie->ie", means, value[1:])
    return value
