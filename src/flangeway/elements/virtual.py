"""The virtual element of order k on simple polygons (Moherdaui 2021, 3.3.1 to 3.3.5 and 3.3.7)."""

from dataclasses import dataclass
from typing import ClassVar

import numpy as np

from flangeway.checks import check_integer, refused
from flangeway.elements import monomials
from flangeway.elements.curved_cells import CurvedPolygons, outline_frame
from flangeway.elements.monomials import Frame, n_monomials
from flangeway.elements.polygon_quadrature import polygon_quadrature
from flangeway.elements.projection import Polygons, principal_frame
from flangeway.elements.reconstruction import Element, Function, Reconstruction
from flangeway.elements.stabilisation import IdentityStabilisation, SpectralStabilisation, Stabilisation
from flangeway.errors import InputError
from flangeway.types import Floats

HIGHEST_ORDER = 10


@dataclass(frozen=True)
class Virtual(Element):
    """Virtual element: polynomials of degree k on the edges, moments up to degree k - 2 inside.

    Curved edges are polynomials of degree k through points of the true curve, and functions polynomials of the same
    parameter: linear functions are exact, and the error in energy decreases like h^k (docs/theory/elements.md).

    The value is reconstructed by the projection that is orthogonal in energy (Beirao da Veiga et al., 2013; Moherdaui,
    2021, 3.58 to 3.66), and the gradient either as that polynomial's or by its own L2 projection onto polynomials of
    degree k - 1, whose symmetric part is the projection onto strains of Artioli et al. (2017, Comput. Mech. 60,
    eq. 14; Moherdaui (2021) 3.84 to 3.88). Monomials are written in the cell's principal axes, so that a stretch costs
    no digits.

    What breaks first is the conditioning of the monomials, however far the cell is from the origin and however short
    its edges. Solutions of plane elasticity reproduce polynomials, at nu = 0.3, to 1e-12 for k <= 4, to 1e-11 for
    k = 6, to 1e-6 for k = 8 and to 2e-3 for k = 10 (measured on squares, Voronoi cells, zigzag cells, and stars whose
    dents reach to 2/5 of the way from the centre to a side; without dents eight digits are left for k = 10). Towards
    nu = 1/2 they lose a digit for every decade of ``1 - 2 nu``; cells stretched 1:1000 obliquely to the axes, and stars
    with thin rays, lose two to three digits more, and above k = 6 all of them.

    Parameters
    ----------
    order
        Order k, 1 to 10.
    stabilisation
        Stiffness of what the projection misses. None takes `IdentityStabilisation` for one field (Moherdaui 2021, 3.71)
        and `SpectralStabilisation` for a displacement, chosen by measurement; published displacements took
        `TraceStabilisation` (Moherdaui 2021, 3.96).

    """

    order: int
    stabilisation: Stabilisation | None = None
    curved: ClassVar[bool] = True

    def __post_init__(self) -> None:
        allowed = f"orders 1 to {HIGHEST_ORDER}; above, monomials lose all digits"
        check_integer("Virtual", "order", self.order, 1, HIGHEST_ORDER, allowed, "choose 1 or 2, and a finer mesh")
        if not (self.stabilisation is None or isinstance(self.stabilisation, Stabilisation)):
            raise refused("Virtual", "stabilisation", self.stabilisation, "None or a Stabilisation", "leave it out")

    def n_interior(self) -> int:
        """Moments inside the cell: the dimension of the polynomials of degree k - 2."""
        return n_monomials(self.order - 2)

    def check_cells(self, n_vertices: int) -> None:
        """Accept every polygon."""
        if n_vertices < 3:
            raise InputError(f"a cell with {n_vertices} vertices", "3 or more", "check the mesh")

    def reconstruct(self, vertices: Floats) -> Reconstruction:
        """Project on each polygon; see `Element.reconstruct`."""
        frame = _frame(vertices)
        if vertices.ndim == 4:
            cells: Polygons = CurvedPolygons.of_outline(vertices, frame)
        else:
            cells = Polygons.of(vertices, self.order, frame)
        boundary = cells.boundary_values()
        gradient_moments = cells.gradient_moments(boundary)
        dofs = cells.monomial_dofs(boundary)
        value, energy_moments = cells.energy_projection(dofs, gradient_moments)
        return Reconstruction(self.order, cells.frame, value, cells.moments, dofs, gradient_moments, energy_moments)

    def interior_dofs(self, vertices: Floats, function: Function, degree: int) -> Floats:
        """Mean products with the monomials of degree k - 2; see `Element.interior_dofs`."""
        if self.order == 1:
            return np.empty((0, vertices.shape[-1]))
        points, weights = polygon_quadrature(vertices, degree + self.order - 2)
        values = function(points.swapaxes(-1, -2).reshape(-1, 2)).reshape(weights.shape)
        local = _frame(vertices).local(points)
        products = np.einsum("aqe,qe->ae", monomials.evaluate(self.order - 2, local), values * weights)
        return products / weights.sum(axis=0)

    def stabilise(self, reconstruction: Reconstruction, consistency: Floats) -> Floats | None:
        """Stiffness of what the projection misses; see `Element.stabilise`."""
        return self.chosen_stabilisation(len(consistency)).matrices(reconstruction, consistency)

    def chosen_stabilisation(self, n_components: int) -> Stabilisation:
        """Stabilisation of a field with so many components."""
        if self.stabilisation is not None:
            return self.stabilisation
        return IdentityStabilisation() if n_components == 1 else SpectralStabilisation()


def _frame(vertices: Floats) -> Frame:
    return principal_frame(vertices) if vertices.ndim == 3 else outline_frame(vertices)
