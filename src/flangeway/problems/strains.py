"""Strains of cells as polynomials of degree k - 1: in the plane, and about an axis with the radius as weight."""

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from flangeway.elements import Reconstruction, batched, monomials
from flangeway.elements.monomials import exponents, index, n_monomials
from flangeway.elements.polygon_quadrature import edge_points
from flangeway.elements.quadrature import edge_rule, edge_unknowns, gauss_lobatto
from flangeway.geometry.arrays import steps_around
from flangeway.space import CellBatch
from flangeway.types import Floats

STRAIN_PLACES = np.array([[0, 2, 3], [2, 1, -1]])
"""Place among xx, yy, 2 xy, zz of the strain that is a component's (row) derivative by x, by y, or its hoop strain."""
STRAINS = np.array([strain == STRAIN_PLACES for strain in range(4)], dtype=np.float64)
"""Each strain by component and derivative, shape (4, 2, 3)."""


@dataclass(frozen=True, eq=False)
class StrainOperators:
    """Derivatives of one component by x and y, and in a body of revolution its hoop strain, on a batch of cells.

    The strains of a discrete displacement are their projections onto polynomials of degree k - 1, orthogonal in L2,
    with the radius as weight in a body of revolution (Moherdaui 2021, 3.84 to 3.88).

    Parameters
    ----------
    moments
        Weighted integrals times the monomials of degree k - 1, shape (n_monomials(k - 1), 2 or 3, n_local, n_cells).
    mass
        Weighted integrals of the products of these monomials, shape (n, n, n_cells).
    exact_coefficients
        The polynomials where they are known without solving, shape as `moments`.

    """

    moments: Floats
    mass: Floats
    exact_coefficients: Floats | None = None

    @cached_property
    def coefficients(self) -> Floats:
        """Coefficients of the polynomials, shape as `moments`."""
        if self.exact_coefficients is not None:
            return self.exact_coefficients
        flat = self.moments.reshape(len(self.moments), -1, self.moments.shape[-1])
        return batched.solve(self.mass, flat).reshape(self.moments.shape)

    def products(self, first: int, second: int) -> Floats:
        """Weighted integrals of products of two of the derivatives, shape (n_local, n_local, n_cells)."""
        left, right = self.moments[:, first], self.coefficients[:, second]
        if first == second:
            return batched.symmetric_product(left, right)
        return np.einsum("ame,ane->mne", left, right)


def add_consistency(blocks: Floats, tensor: Floats, strains: StrainOperators) -> None:
    """Add the integrals of ``sum_ab T_iajb d_a v d_b u`` for all local functions v and u.

    - `blocks`: to which they are added, by components i and j, (m, m, n_local, n_local, n_cells).
    - `tensor`: T, symmetric, for the derivatives a and b of `strains`, (m, n_slots, m, n_slots, n_cells or 1).
    """
    n_slots = tensor.shape[1]
    for a in range(n_slots):
        for b in range(a, n_slots):
            used = np.argwhere(tensor[:, a, :, b].any(axis=-1)).tolist()
            product = strains.products(a, b) if used else np.empty(0)
            for i, j in used:
                block = tensor[i, a, j, b] * product
                blocks[i, j] += block
                if a != b:
                    blocks[j, i] += block.swapaxes(0, 1)


def strain_operators(batch: CellBatch, reconstruction: Reconstruction, *, axisymmetric: bool) -> StrainOperators:
    """Strains of a batch of cells; x is the radius if ``axisymmetric``."""
    if axisymmetric:
        return _about_axis(batch, reconstruction)
    gradient, mass = reconstruction.gradient, reconstruction.mass
    moments = reconstruction.gradient_moments
    if moments is None:
        moments = np.einsum("abe,bsme->asme", mass, gradient)
    return StrainOperators(moments, mass, gradient)


def _about_axis(batch: CellBatch, reconstruction: Reconstruction) -> StrainOperators:
    """Operators with the radius r = x as weight.

    ``int r p u,j = int_boundary r p u n_j - int u (r p),j`` holds the moments of u up to degree k - 1 only, which the
    enhanced space gives for every order, and so does the hoop strain's ``int r p (u / r) = int p u``.
    """
    order = reconstruction.order
    n_low, n_below = n_monomials(order - 1), n_monomials(order - 2)
    radius = _radius(reconstruction)
    all_moments = reconstruction.moments
    value_moments = np.einsum(
        "abe,bme->ame", monomials.mass(order, all_moments)[:n_low], reconstruction.projected_value
    )
    moments = np.empty((n_low, 3, *value_moments.shape[1:]))
    moments[:, :2] = _boundary_moments(batch, reconstruction)
    moments[:, 0] -= value_moments
    moments[:, 2] = value_moments
    if n_below:
        weighted = _times_radius(value_moments, order - 2, radius)
        in_space = np.einsum("jie,jba->abie", reconstruction.frame.map, monomials.derivatives(order - 1))
        moments[:, :2] -= np.einsum("abie,bme->aime", in_space, weighted)
    products = exponents(order - 1)[:, None] + exponents(order - 1)
    weighted_moments = _times_radius(all_moments, 2 * (order - 1), radius)
    return StrainOperators(moments, weighted_moments[index(products)])


def _radius(reconstruction: Reconstruction) -> Floats:
    """Coefficients of x as a polynomial of degree 1 in the local coordinates, shape (3, n_cells)."""
    return np.concatenate((reconstruction.frame.origin[:1], reconstruction.frame.inverse[0]))


def _times_radius(moments: Floats, degree: int, radius: Floats) -> Floats:
    """Moments with monomials up to a degree times the radius, from moments up to one degree more, first axis."""
    powers = exponents(degree)
    result = np.zeros((len(powers), *moments.shape[1:]))
    for step, factor in zip(((0, 0), (1, 0), (0, 1)), radius, strict=True):
        result += factor * moments[index(powers + np.array(step))]
    return result


def _boundary_moments(batch: CellBatch, reconstruction: Reconstruction) -> Floats:
    """Integrals of r times monomials of degree k - 1 times traces times the normal, (n, 2, n_local, n_cells)."""
    order, vertices, outline = reconstruction.order, batch.vertices, batch.outline
    n_vertices, _, n_cells = vertices.shape
    # degree k of r, k - 1 of the normal, k of the trace, and k - 1 times k of the monomials
    n_points = (order * (order + 2) + 1) // 2
    if outline.ndim == 3:
        n_points, along = order + 1, steps_around(vertices)
        outline = vertices[:, None] + gauss_lobatto(order + 1)[0][:-1, None, None] * along[:, None]
    weights, shapes, slopes = edge_rule(order, n_points)
    result = np.zeros((n_monomials(order - 1), 2, reconstruction.n_local, n_cells))
    for edge, local in enumerate(edge_unknowns(order, n_vertices)):
        nodes = edge_points(outline)[edge] - vertices[edge]
        points, tangents = (np.einsum("qj,jie->qie", table, nodes) for table in (shapes, slopes))
        points += vertices[edge]
        values = monomials.evaluate(order - 1, reconstruction.frame.local(points))
        right = batched.turned_right(tangents) * weights[:, None, None]
        result[:, :, local] += np.einsum("aqe,qe,qie,qn->aine", values, points[:, 0], right, shapes, optimize=True)
    return result
