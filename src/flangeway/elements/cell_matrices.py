"""The matrices of one virtual element as the literature writes them, for teaching and for checks."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from flangeway.checks import check_integer
from flangeway.elements import monomials
from flangeway.elements.monomials import Frame, n_monomials
from flangeway.elements.projection import Polygons
from flangeway.elements.virtual import HIGHEST_ORDER
from flangeway.errors import InputError
from flangeway.geometry.arrays import as_points
from flangeway.mesh.polymesh import PolyMesh
from flangeway.types import Floats


@dataclass(frozen=True, eq=False)
class CellMatrices:
    """Matrices of one polygon in the notation of Beirao da Veiga et al. (2014) and of Ahmad et al. (2013).

    Monomials are scaled by the diameter, ``((x - centroid) / diameter)^a ((y - ...) / diameter)^b``, and ordered by
    degree. With ``n_k`` monomials and ``n`` degrees of freedom (vertices, Gauss-Lobatto points of each edge in turn,
    moments):

    Parameters
    ----------
    order
        Order k.
    centroid
        Centroid, shape (2,).
    diameter
        Maximum distance of two vertices.
    area
        Area.
    D
        Degrees of freedom of the monomials, (n, n_k).
    B
        Gradient products of monomials with basis functions, the first row the mean, (n_k, n).
    G
        Gradient products of monomials, the first row their mean, (n_k, n_k); equals ``B D``.
    C
        Products of monomials with basis functions in the enhanced space, (n_k, n).
    H
        Products of monomials, (n_k, n_k).

    """

    order: int
    centroid: Floats
    diameter: float
    area: float
    D: Floats
    B: Floats
    G: Floats
    C: Floats
    H: Floats

    @property
    def pi_nabla_star(self) -> Floats:
        """Energy projection as coefficients of the monomials, ``G^-1 B``, (n_k, n)."""
        return np.asarray(np.linalg.solve(self.G, self.B), dtype=np.float64)

    @property
    def pi_nabla(self) -> Floats:
        """Energy projection as degrees of freedom, ``D G^-1 B``, (n, n)."""
        return self.D @ self.pi_nabla_star

    @property
    def pi_zero_star(self) -> Floats:
        """L2 projection as coefficients of the monomials, ``H^-1 C``, (n_k, n)."""
        return np.asarray(np.linalg.solve(self.H, self.C), dtype=np.float64)

    @property
    def pi_zero(self) -> Floats:
        """L2 projection as degrees of freedom, ``D H^-1 C``, (n, n)."""
        return self.D @ self.pi_zero_star

    @property
    def stiffness(self) -> Floats:
        """Stiffness of Laplace's operator with the identity as stabilisation (Moherdaui 2021, 3.69, 3.71), (n, n)."""
        gram = self.G.copy()
        gram[0] = 0.0
        missed = np.eye(len(self.D)) - self.pi_nabla
        return self.pi_nabla_star.T @ gram @ self.pi_nabla_star + missed.T @ missed


def cell_matrices(points: ArrayLike, order: int) -> CellMatrices:
    """Compute the matrices of one simple polygon.

    `Virtual` solves the same systems in the cell's principal axes, which is better conditioned.

    Parameters
    ----------
    points
        Counter-clockwise vertices, shape (n_vertices, 2).
    order
        Order k >= 1.

    Raises
    ------
    InputError
        If there are fewer than three points, the area is not positive, or the order is not from 1 to 10.

    """
    corners = as_points(points)
    if len(corners) < 3:
        raise InputError(f"points of shape {corners.shape}", "three or more rows of x and y", "give the vertices")
    order = check_integer("cell_matrices", "order", order, 1, HIGHEST_ORDER, advice="choose order=1")
    mesh = PolyMesh.from_cells(corners, [range(len(corners))])
    area = float(mesh.cell_areas[0])
    if not area > 0.0:
        raise InputError(f"a polygon with signed area {area:g}", "counter-clockwise vertices", "reverse the points")
    centroid, diameter = mesh.cell_centroids[0], float(mesh.cell_diameters[0])
    frame = Frame(centroid[:, None], np.eye(2)[:, :, None] / diameter)
    cell = Polygons.of(corners[:, :, None], order, frame)
    boundary = cell.boundary_values()
    dofs = cell.monomial_dofs(boundary)
    low_gram, low_rhs = cell.energy_matrices(cell.gradient_moments(boundary))
    D = dofs[:, :, 0]
    mean = cell.means()
    B = np.vstack((mean, low_rhs[:, :, 0]))
    G = np.zeros((D.shape[1], D.shape[1]))
    G[0] = mean @ D
    G[1:, 1:] = low_gram[:, :, 0]
    H = monomials.mass(order, cell.moments)[:, :, 0]
    C = H @ np.linalg.solve(G, B)
    n_inner = n_monomials(order - 2)
    C[:n_inner] = 0.0
    C[:n_inner, len(D) - n_inner :] = area * np.eye(n_inner)
    return CellMatrices(order, centroid, diameter, area, D, B, G, C, H)
