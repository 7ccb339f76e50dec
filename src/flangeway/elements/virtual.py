"""The virtual element of order k on simple polygons (Moherdaui 2021, 3.3.1 to 3.3.5 and 3.3.7)."""

from dataclasses import dataclass, replace
from typing import ClassVar

import numpy as np

from flangeway.checks import check_integer, check_kind
from flangeway.elements import batched, monomials
from flangeway.elements.curved_cells import CurvedPolygons, outline_frame
from flangeway.elements.monomials import n_monomials
from flangeway.elements.polygon_quadrature import polygon_quadrature
from flangeway.elements.projection import Polygons, inner_factor, principal_frame
from flangeway.elements.reconstruction import Element, Function, Reconstruction
from flangeway.elements.stabilisation import IdentityStabilisation, SpectralStabilisation, Stabilisation
from flangeway.errors import InputError
from flangeway.types import Floats

HIGHEST_ORDER = 10
MAX_PROJECTION_ERROR = 3e-12
"""Error in L2 of the projection of a linear function, relative to a cell's size: displacements of thin V shapes and
spirals lose up to eight digits more (measured)."""


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

    The moments inside are those with polynomials that are orthogonalised on the cell (`inner_factor`); moments with the
    monomials themselves lost seven digits at k = 10. Solutions of plane elasticity at nu = 0.3 reproduce stresses of
    polynomials to 1e-12 for k <= 8 and to 1e-10 for k = 10 (measured on squares, cells with hanging nodes, Voronoi and
    dual cells, and agglomerated cells that are not convex). Towards nu = 1/2 they lose a digit for every decade of
    ``1 - 2 nu``; cells stretched 1:1000 obliquely to the axes, and stars with thin rays, lose several digits more.

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
        allowed = f"orders 1 to {HIGHEST_ORDER}; above, monomials lose too many digits"
        check_integer("Virtual", "order", self.order, 1, HIGHEST_ORDER, allowed, "choose 1 or 2, and a finer mesh")
        kinds = Stabilisation | None
        check_kind("Virtual", "stabilisation", self.stabilisation, kinds, "None or a Stabilisation", "leave it out")

    def n_interior(self) -> int:
        """Moments inside the cell: the dimension of the polynomials of degree k - 2."""
        return n_monomials(self.order - 2)

    def check_cells(self, n_vertices: int) -> None:
        """Accept every polygon."""
        if n_vertices < 3:
            raise InputError(f"a cell with {n_vertices} vertices", "3 or more", "check the mesh")

    def reconstruct(self, vertices: Floats) -> Reconstruction:
        """Project on each polygon; an `InputError` where round-off takes the digits; see `Element.reconstruct`."""
        cells = self._cells(vertices)
        boundary = cells.boundary_values()
        gradient_moments = cells.gradient_moments(boundary)
        dofs = cells.monomial_dofs(boundary)
        value, energy_moments = cells.energy_projection(dofs, gradient_moments)
        self._refuse_lost_digits(cells, value, dofs)
        return Reconstruction(
            self.order, cells.frame, value, cells.moments, dofs, gradient_moments, energy_moments, inner=cells.inner
        )

    def _refuse_lost_digits(self, cells: Polygons, value: Floats, dofs: Floats) -> None:
        """Refuse cells whose projection (n, n_local, n_cells) does not keep the linear functions of the frame."""
        linear = np.einsum("aie,ixe->axe", value, dofs[:, 1:3])
        linear[1:3] -= np.eye(2)[:, :, None]
        products = np.einsum("abe,bxe->axe", monomials.mass(self.order, cells.moments), linear)
        squares = np.einsum("axe,axe->e", linear, products) / cells.moments[0]
        if not (squares <= MAX_PROJECTION_ERROR**2).all():  # NaN where round-off makes a mass negative
            x, y = cells.frame.origin[:, int(np.nan_to_num(squares, nan=np.inf).argmax())]
            raise InputError(
                f"Virtual({self.order}) in the cell at ({x:g}, {y:g}), which is so thin that its polynomials are lost "
                "in round-off",
                f"cells whose projections keep linear functions to {MAX_PROJECTION_ERROR:g}, so that displacements "
                "keep about four digits",
                "take a lower order, or cut the cell with mesh.refined",
            )

    def _cells(self, vertices: Floats) -> Polygons:
        """Geometry of cells, with the polynomials of the moments inside them."""
        if vertices.ndim == 4:
            cells: Polygons = CurvedPolygons.of_outline(vertices, outline_frame(vertices))
        else:
            cells = Polygons.of(vertices, self.order, principal_frame(vertices))
        return replace(cells, inner=inner_factor(self.order, cells.moments))

    def interior_dofs(self, vertices: Floats, function: Function, degree: int) -> Floats:
        """Mean products with the polynomials of `inner_factor`; see `Element.interior_dofs`."""
        if self.order == 1:
            return np.empty((0, vertices.shape[-1]))
        points, weights = polygon_quadrature(vertices, degree + self.order - 2)
        values = function(points.swapaxes(-1, -2).reshape(-1, 2)).reshape(weights.shape)
        cells = self._cells(vertices)
        local = cells.frame.local(points)
        products = np.einsum("aqe,qe->ae", monomials.evaluate(self.order - 2, local), values * weights)
        means: Floats = products / weights.sum(axis=0)
        return means if cells.inner is None else batched.solve_lower(cells.inner, means[:, None])[:, 0]

    def stabilise(self, reconstruction: Reconstruction, consistency: Floats) -> Floats | None:
        """Stiffness of what the projection misses; see `Element.stabilise`."""
        return self.chosen_stabilisation(len(consistency)).matrices(reconstruction, consistency)

    def chosen_stabilisation(self, n_components: int) -> Stabilisation:
        """Stabilisation of a field with so many components."""
        if self.stabilisation is not None:
            return self.stabilisation
        return IdentityStabilisation() if n_components == 1 else SpectralStabilisation()
