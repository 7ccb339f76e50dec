"""Lagrange triangles of order k (Moherdaui 2021, 3.2.3: T3, T6, and T10)."""

from dataclasses import dataclass, replace
from functools import cache
from typing import ClassVar

import numpy as np

from flangeway.checks import check_integer
from flangeway.elements import batched, monomials
from flangeway.elements.monomials import Frame, n_monomials
from flangeway.elements.projection import CurvedPolygons, outline_frame
from flangeway.elements.quadrature import gauss_lobatto, triangle
from flangeway.elements.reconstruction import Element, Function, Reconstruction, mean_modulus
from flangeway.errors import InputError
from flangeway.types import Floats

HIGHEST_ORDER = 3


@dataclass(frozen=True)
class Lagrange(Element):
    """Triangle with polynomials of degree k, values as degrees of freedom.

    Edges carry Gauss-Lobatto points, so that triangles and virtual elements of one order share their edges'
    unknowns (for k <= 2 these are the usual nodes); order 3 has the centroid as one more node.

    Triangles with curved edges are isoparametric. Their strains are projected onto polynomials of degree k - 1 in space
    as those of every element, and what the projection misses is added with the mean modulus.

    Parameters
    ----------
    order
        Order k: 1, 2 or 3.

    """

    order: int
    curved: ClassVar[bool] = True

    def __post_init__(self) -> None:
        advice = "choose one of these, or Virtual(order) for higher orders"
        check_integer("Lagrange", "order", self.order, 1, HIGHEST_ORDER, f"orders 1 to {HIGHEST_ORDER}", advice)

    def n_interior(self) -> int:
        """Nodes inside the triangle: none, none, and the centroid."""
        return n_monomials(self.order - 3)

    def check_cells(self, n_vertices: int) -> None:
        """Accept triangles only."""
        if n_vertices != 3:
            raise InputError(
                f"a cell with {n_vertices} vertices for Lagrange(order={self.order})",
                "triangles",
                "use Virtual(order) on polygons, or triangulate the region",
            )

    def reconstruct(self, vertices: Floats) -> Reconstruction:
        """Write the shape functions as polynomials; see `Element.reconstruct`."""
        if vertices.ndim == 4:
            return _isoparametric(vertices)
        n_cells = vertices.shape[-1]
        value, moments, dofs = _reference(self.order)
        first, second = vertices[1] - vertices[0], vertices[2] - vertices[0]
        jacobian = batched.cross(first, second)
        inverse = np.array([[second[1], -second[0]], [-first[1], first[0]]]) / jacobian
        frame = Frame(vertices[0] + (first + second) / 3.0, inverse)
        return Reconstruction(
            self.order,
            frame,
            _for_all(value, n_cells),
            moments[:, None] * jacobian,
            _for_all(dofs, n_cells),
        )

    def interior_dofs(
        self,
        vertices: Floats,
        function: Function,
        degree: int,  # noqa: ARG002
    ) -> Floats:
        """Value at the centroid for order 3; see `Element.interior_dofs`."""
        if not self.n_interior():
            return np.empty((0, vertices.shape[-1]))
        centre = _nodes(vertices)[-1] if vertices.ndim == 4 else vertices.mean(axis=0)
        return function(centre.T)[None]

    def stabilise(self, reconstruction: Reconstruction, consistency: Floats) -> Floats | None:
        """Nothing where the reconstruction is exact; the energy that it misses where edges are curved."""
        if reconstruction.missed is None:
            return None
        return reconstruction.missed * mean_modulus(reconstruction, consistency)


def _for_all(array: Floats, n_cells: int) -> Floats:
    return np.broadcast_to(array[..., None], (*array.shape, n_cells))


def _reference_nodes(order: int) -> Floats:
    """Nodes on the triangle (0,0) (1,0) (0,1), shape (n_local, 2)."""
    corners = np.array([[0.0, 0.0], [1.0, 0.0], [0.0, 1.0]])
    inner = gauss_lobatto(order + 1)[0][1:-1]
    nodes = [corners]
    for i in range(3):
        start, end = corners[i], corners[(i + 1) % 3]
        nodes.append(start + inner[:, None] * (end - start))
    if order == HIGHEST_ORDER:
        nodes.append(corners.mean(axis=0, keepdims=True))
    return np.concatenate(nodes)


@cache
def _reference(order: int) -> tuple[Floats, Floats, Floats]:
    """Return value, moments and monomials at the nodes, on the reference triangle."""
    centroid = np.full(2, 1.0 / 3.0)
    nodes = _reference_nodes(order) - centroid
    dofs: Floats = monomials.evaluate(order, nodes.T).T
    value = np.asarray(np.linalg.inv(dofs), dtype=np.float64)
    points, weights = triangle(2 * order)
    moments: Floats = monomials.evaluate(2 * order, (points - centroid).T) @ weights
    return value, moments, dofs


def _nodes(outline: Floats) -> Floats:
    """Nodes of isoparametric triangles, (n_local, 2, n_cells).

    The node inside is where quadratic functions of the nodes on the edges put it, so that it follows the edges to the
    order that cubic elements need (Ciarlet and Raviart, 1972).
    """
    inner = outline[:, 1:].reshape(-1, *outline.shape[2:])
    nodes = [outline[:, 0], inner]
    if outline.shape[1] == HIGHEST_ORDER:
        nodes.append((5.0 * inner.sum(axis=0) - 4.0 * outline[:, 0].sum(axis=0))[None] / 18.0)
    return np.concatenate(nodes)


def _isoparametric(outline: Floats) -> Reconstruction:
    """Triangles with curved edges, integrated on the reference triangle."""
    order, nodes = outline.shape[1], _nodes(outline)
    geometry = CurvedPolygons.of_outline(outline, outline_frame(outline))
    value, _, _ = _reference(order)
    points, weights = triangle(order * order + 3 * order)
    local = (points - 1.0 / 3.0).T
    shapes = np.einsum("aq,aj->qj", monomials.evaluate(order, local), value)
    slopes = np.einsum("aq,xab,bj->xqj", monomials.evaluate(order - 1, local), monomials.derivatives(order), value)
    # cofactors of the Jacobian times the derivatives on the reference triangle are derivatives in space times areas
    columns = np.einsum("xqj,jie->xqie", slopes, nodes)
    jacobian = batched.cross(*columns)
    by_x = slopes[0][:, :, None] * columns[1, :, None, 1] - slopes[1][:, :, None] * columns[0, :, None, 1]
    by_y = slopes[1][:, :, None] * columns[0, :, None, 0] - slopes[0][:, :, None] * columns[1, :, None, 0]
    gradients = np.stack((by_x, by_y)) * weights[:, None, None]
    at = monomials.evaluate(order, geometry.frame.local(np.einsum("qj,jie->qie", shapes, nodes)))
    gradient_moments = np.einsum("aqe,iqje->aije", at[: n_monomials(order - 1)], gradients)
    value_moments = np.einsum("aqe,qe,qj->aje", at, jacobian * weights[:, None], shapes)
    gram, energy_moments = geometry.energy_matrices(gradient_moments)
    projected = np.empty_like(value_moments)
    batched.solve(gram, energy_moments, out=projected[1:])
    projected[0] = value_moments[0] - np.einsum("ae,aje->je", geometry.moments[1 : len(at)], projected[1:])
    projected[0] /= geometry.moments[0]
    dofs = monomials.evaluate(order, geometry.frame.local(nodes)).swapaxes(0, 1)
    reconstruction = Reconstruction(
        order, geometry.frame, projected, geometry.moments, dofs, gradient_moments, energy_moments, value_moments
    )
    energy = np.einsum("iqje,iqme,qe->jme", gradients, gradients, 1.0 / (jacobian * weights[:, None]))
    return replace(
        reconstruction,
        missed=energy - reconstruction.gradient_energy(reconstruction.gradient, np.ones(outline.shape[-1])),
    )
