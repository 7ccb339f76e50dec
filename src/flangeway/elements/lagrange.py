"""Lagrange triangles of order k (Moherdaui 2021, 3.2.3: T3, T6, and T10)."""

from dataclasses import dataclass
from functools import cache

import numpy as np

from flangeway.checks import check_integer
from flangeway.elements import monomials
from flangeway.elements.monomials import Frame, n_monomials
from flangeway.elements.quadrature import gauss_lobatto, triangle
from flangeway.elements.reconstruction import Element, Function, Reconstruction
from flangeway.errors import InputError
from flangeway.types import Floats

HIGHEST_ORDER = 3


@dataclass(frozen=True)
class Lagrange(Element):
    """Triangle with polynomials of degree k, values as degrees of freedom.

    Edges carry Gauss-Lobatto points, so that triangles and virtual elements of one order share their edges'
    unknowns (for k <= 2 these are the usual nodes); order 3 has the centroid as one more node.

    Parameters
    ----------
    order
        Order k: 1, 2 or 3.

    """

    order: int

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
        n_cells = vertices.shape[-1]
        value, moments, dofs = _reference(self.order)
        first, second = vertices[1] - vertices[0], vertices[2] - vertices[0]
        jacobian = first[0] * second[1] - first[1] * second[0]
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
        return function(vertices.mean(axis=0).T)[None]

    def stabilise(
        self,
        reconstruction: Reconstruction,
        consistency: Floats,
    ) -> None:
        """Nothing: the reconstruction is exact."""


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
