"""Virtual elements of order k on simple polygons: the usual ones, serendipity ones, and ones without stabilisation."""

from dataclasses import dataclass, field, replace
from typing import ClassVar

import numpy as np

from flangeway.checks import check_integer, check_kind
from flangeway.elements import batched, monomials
from flangeway.elements.monomials import n_monomials
from flangeway.elements.projection import (
    CellGeometry,
    CurvedPolygons,
    Polygons,
    inner_factor,
    outline_frame,
    principal_frame,
)
from flangeway.elements.quadrature import edge_shapes, edge_unknowns, gauss, polygon_quadrature
from flangeway.elements.reconstruction import (
    Element,
    Function,
    IdentityStabilisation,
    Reconstruction,
    SpectralStabilisation,
    Stabilisation,
)
from flangeway.errors import InputError
from flangeway.geometry.arrays import point_text, steps_around
from flangeway.types import Floats, Ints

# --- The virtual element of order k on simple polygons (Moherdaui 2021, 3.3.1 to 3.3.5 and 3.3.7).


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
    spatial: ClassVar[bool] = True

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

    def reconstruct(self, vertices: Floats | CellGeometry) -> Reconstruction:
        """Project on each cell; an `InputError` where round-off takes the digits; see `Element.reconstruct`."""
        cells = self._cells(vertices)
        boundary = cells.boundary_values()
        gradient_moments = cells.gradient_moments(boundary)
        dofs = cells.monomial_dofs(boundary)
        value, energy_moments = cells.energy_projection(dofs, gradient_moments)
        self._refuse_lost_digits(cells, value, dofs)
        return Reconstruction(
            self.order, cells.frame, value, cells.moments, dofs, gradient_moments, energy_moments, inner=cells.inner
        )

    def _refuse_lost_digits(self, cells: CellGeometry, value: Floats, dofs: Floats) -> None:
        """Refuse cells whose projection (n, n_local, n_cells) does not keep the linear functions of the frame."""
        d = len(cells.frame.map)
        linear = np.einsum("aie,ixe->axe", value, dofs[:, 1 : 1 + d])
        linear[1 : 1 + d] -= np.eye(d)[:, :, None]
        products = np.einsum("abe,bxe->axe", monomials.mass(self.order, cells.moments, d), linear)
        squares = np.einsum("axe,axe->e", linear, products) / cells.moments[0]
        if not (squares <= MAX_PROJECTION_ERROR**2).all():  # NaN where round-off makes a mass negative
            place = point_text(cells.frame.origin[:, int(np.nan_to_num(squares, nan=np.inf).argmax())])
            raise InputError(
                f"Virtual({self.order}) in the cell at {place}, which is so thin that its polynomials are lost in "
                "round-off",
                f"cells whose projections keep linear functions to {MAX_PROJECTION_ERROR:g}, so that displacements "
                "keep about four digits",
                "take a lower order, or cut the cell with mesh.refined",
            )

    def _cells(self, vertices: Floats | CellGeometry) -> CellGeometry:
        """Geometry of cells, with the polynomials of the moments inside them."""
        if isinstance(vertices, CellGeometry):
            return vertices
        if vertices.ndim == 4:
            cells: CellGeometry = CurvedPolygons.of_outline(vertices, outline_frame(vertices))
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


# --- Serendipity virtual elements: fewer moments inside, as many as the lines of the boundary leave open.


LINE_TOLERANCE = 1e-6
"""Angle, and distance relative to the size of the cell, up to which two sides count as one line."""
MIN_SINGULAR_VALUE = 1e-6
"""Singular value of the unknowns of polynomials relative to the highest one, below which they do not determine them."""


@dataclass(frozen=True, eq=False)
class _Reduced(Reconstruction):
    """A reconstruction on fewer unknowns."""

    l2_value: Floats = field(kw_only=True)
    n_inner: int = field(kw_only=True)

    @property
    def projected_value(self) -> Floats:
        return self.l2_value

    @property
    def n_interior(self) -> int:
        return self.n_inner


@dataclass(frozen=True)
class Serendipity(Element):
    """Virtual element with moments inside up to degree k minus the number of lines of the boundary only.

    A polynomial of degree k that vanishes on n different lines is a multiple of their product: boundary values and
    moments up to degree ``k - n`` determine it if no such multiple is orthogonal to these moments, as in convex cells.
    The other moments up to degree k - 2 are those of the polynomial that fits the unknowns in least squares; all
    projections are then those of `Virtual` (Beirao da Veiga, Brezzi, Marini and Russo, 2016, "Serendipity nodal VEM
    spaces", Computers & Fluids 141). Cells with at least k + 1 lines need no unknown inside.

    Parameters
    ----------
    order
        Order k, 1 to 10.
    lines
        Number of lines that every cell has at least, 3 or more. Each cell is checked, and in cells that are not convex
        whether its unknowns determine the polynomials. Give cell sets an element each where the numbers differ.
    stabilisation
        As of `Virtual`.

    """

    order: int
    lines: int = 3
    stabilisation: Stabilisation | None = None

    def __post_init__(self) -> None:
        allowed = f"orders 1 to {HIGHEST_ORDER}"
        check_integer("Serendipity", "order", self.order, 1, HIGHEST_ORDER, allowed, "choose a lower order")
        check_integer("Serendipity", "lines", self.lines, 3, advice="triangles have 3 lines, quadrilaterals 4")
        _ = self._full

    @property
    def _full(self) -> Virtual:
        return Virtual(self.order, self.stabilisation)

    def n_interior(self) -> int:
        """Moments inside the cell: the dimension of the polynomials of degree k minus the number of lines."""
        return n_monomials(self.order - self.lines)

    def check_cells(self, n_vertices: int) -> None:
        """Refuse cells with fewer sides than lines."""
        if n_vertices < self.lines:
            raise self._too_few(f"a cell with {n_vertices} vertices", n_vertices)

    def _too_few(self, where: str, n_lines: int) -> InputError:
        return InputError(
            f"{where} on {n_lines} different lines for Serendipity({self.order}, lines={self.lines})",
            f"cells with at least {self.lines} lines",
            f"choose lines={n_lines} for the cell set of such cells" if n_lines >= 3 else "check the mesh",
        )

    def reconstruct(self, vertices: Floats) -> Reconstruction:
        """Reduce the reconstruction of the virtual element; see `Element.reconstruct`."""
        full = self._full.reconstruct(vertices)
        n_boundary, n_inner = self.order * len(vertices), self.n_interior()
        kept = n_boundary + n_inner
        dofs = full.monomial_dofs[:kept]
        if self.order > 1:
            self._check_lines(full, len(vertices))
        gram = np.einsum("iae,ibe->abe", dofs, dofs)
        # fewer moments are left out for k = 1, none
        fit = batched.solve(gram, dofs.swapaxes(0, 1)) if kept < full.n_local else np.zeros_like(dofs.swapaxes(0, 1))
        others = np.einsum("iae,aje->ije", full.monomial_dofs[kept:], fit)

        def reduced(array: Floats) -> Floats:
            return array[..., :kept, :] + np.einsum("...ie,ije->...je", array[..., kept:, :], others)

        assert full.gradient_moments is not None
        assert full.energy_moments is not None
        return _Reduced(
            full.order,
            full.frame,
            reduced(full.value),
            full.moments,
            dofs,
            reduced(full.gradient_moments),
            reduced(full.energy_moments),
            l2_value=reduced(full.projected_value),
            n_inner=n_inner,
        )

    def _check_lines(self, full: Reconstruction, n_vertices: int) -> None:
        """Refuse cells with too few lines, and those whose unknowns do not determine polynomials of degree k."""
        lines = distinct_lines(full.monomial_dofs[:n_vertices, 1:3])
        if (lines < self.lines).any():
            raise self._too_few(_place(full, int(lines.argmin())), int(lines.min()))
        dofs = full.monomial_dofs[: self.order * n_vertices + self.n_interior()]
        values = np.linalg.svd(dofs.transpose(2, 0, 1), compute_uv=False)
        poor = values[:, -1] < MIN_SINGULAR_VALUE * values[:, 0]
        if poor.any():
            raise InputError(
                f"{_place(full, int(poor.argmax()))}: the unknowns of Serendipity({self.order}, lines={self.lines}) do "
                "not determine the polynomials",
                "cells that are convex, or nearly so",
                f"choose fewer lines, or take Virtual({self.order})",
            )

    def interior_dofs(self, vertices: Floats, function: Function, degree: int) -> Floats:
        """The first moments of `Virtual`; see `Element.interior_dofs`."""
        return self._full.interior_dofs(vertices, function, degree)[: self.n_interior()]

    def stabilise(self, reconstruction: Reconstruction, consistency: Floats) -> Floats | None:
        """As of `Virtual`, on fewer unknowns; see `Element.stabilise`."""
        return self._full.stabilise(reconstruction, consistency)


def _place(full: Reconstruction, cell: int) -> str:
    x, y = full.frame.origin[:, cell]
    return f"the cell at ({x:g}, {y:g})"


def distinct_lines(vertices: Floats) -> Ints:
    """Numbers of different lines on which the sides of polygons (n_vertices, 2, n_cells) lie, shape (n_cells,)."""
    along = steps_around(vertices)
    along = along / np.sqrt((along**2).sum(axis=1, keepdims=True))
    counts = np.zeros(vertices.shape[-1], dtype=np.int64)
    size = np.ptp(vertices, axis=0).max(axis=0)
    for i in range(len(vertices)):
        step = vertices[:i] - vertices[i]
        turned = np.abs(batched.cross(along[i], along[:i]))
        offset = np.abs(batched.cross(along[i], step))
        counts += ~((turned <= LINE_TOLERANCE) & (offset <= LINE_TOLERANCE * size)).any(axis=0)
    return counts


# --- Virtual elements whose stiffness needs no stabilisation, since gradients are projected onto a higher degree.


HIGHEST_FREE_ORDER = 3
HIGHEST_DEGREE = 14
MAX_GRADIENT_ERROR = 1e-10
"""Error of a constant gradient; displacements of cells with thin parts lose up to six digits more (measured)."""
MIN_ENERGY = 1e-11
"""Eigenvalue of a cell's energy in its own frame relative to the maximum, below which it is round-off."""


class _Energetic(Reconstruction):
    """Gradients of a higher degree; the value is the L2 projection of the degree of the element."""

    @property
    def projected_value(self) -> Floats:
        return self.value


@dataclass(frozen=True, eq=False)
class _Enlarged(Reconstruction):
    """The reconstruction of a virtual element, and the gradients of a higher degree that its stiffness is made of."""

    energetic: Reconstruction = field(kw_only=True)

    @property
    def for_energy(self) -> Reconstruction:
        return self.energetic

    def value_energy(self, moduli: Floats) -> Floats:
        return self.energetic.gradient_energy(self.energetic.gradient, moduli)


@dataclass(frozen=True)
class StabilisationFree(Element):
    """Virtual element with gradients and strains projected onto polynomials of a degree that leaves no motion free.

    Its unknowns are those of `Virtual`. Moments of the function beyond degree k - 2 are those of its projection that is
    orthogonal in energy, in a space enlarged for that; with them the L2 projection of the gradient onto polynomials of
    any degree l can be computed. The energy of this projection alone is the stiffness (Berrone, Borio and Marcon, 2021,
    "Lowest order stabilization free virtual element method for the Poisson equation", arXiv:2103.16896; D'Altri,
    de Miranda, Patruno and Sacco, 2021, "An enhanced VEM formulation for plane elasticity"; Chen and Sukumar, 2023,
    "Stabilization-free virtual element method for plane elasticity", CMAME 404).

    For n unknowns of a field in a cell, gradients have ``(l + 1) (l + 2) >= n - 1`` coefficients and strains
    ``3 (l + 1) (l + 2) / 2 >= 2 n - 3``. This is necessary; whether it suffices depends on the cell's shape (regular
    polygons need more), so that every cell's stiffness is checked: only rigid motions may be without energy. For k >= 2
    the energy of motions of a very short side vanishes with its length; with loads this does no harm, and masses leave
    such motions out. The check is made in the cell's own frame, and so does not depend on a stretch or the material.

    It locks towards nu = 1/2: on 200 dual cells in a square, divergence-free displacement, orders 1, 2 and 3, the error
    of the gradient grows 1.7, 1.3 and 1.2 times from nu = 0.3 to 0.49, and 5.9, 3.2 and 2.0 times to 0.4999 (measured).

    Parameters
    ----------
    order
        Order k, 1 to 3; above, cells of Voronoi meshes need degrees that lose all digits.
    degree
        Degree l of the projected gradient, from k - 1. None takes for n sides what regular polygons need (measured):
        the least degree with enough strains, one more for k >= 2 and n >= 4, and at least ``n // 2 + k - 2``; where
        gradients of that degree leave a motion free, as in polygons with several sides in one line, the least degree
        up to 14 that does not, found for the cells of a batch together.

    """

    order: int
    degree: int | None = None

    def __post_init__(self) -> None:
        allowed = f"orders 1 to {HIGHEST_FREE_ORDER}"
        check_integer(
            "StabilisationFree", "order", self.order, 1, HIGHEST_FREE_ORDER, allowed, "take Virtual(order) above"
        )
        if self.degree is not None:
            low = self.order - 1
            check_integer("StabilisationFree", "degree", self.degree, low, HIGHEST_DEGREE, advice="leave it out")

    def locks(self, n_vertices: int) -> bool:  # noqa: ARG002 (other elements ask for it)
        """Polygons lock too at order 1: strains of a higher degree constrain the volume at more points."""
        return self.order == 1

    def n_interior(self) -> int:
        """Moments up to degree k - 2, as of `Virtual`."""
        return n_monomials(self.order - 2)

    def degree_of(self, n_vertices: int) -> int:
        """Degree l of the projected gradient of cells with so many vertices."""
        if self.degree is not None:
            return self.degree
        n = self.order * n_vertices + self.n_interior()
        least = next(d for d in range(self.order - 1, 1000) if 3 * n_monomials(d) >= 2 * n - 3)
        return max(least + (n_vertices > 3 and self.order > 1), n_vertices // 2 + self.order - 2)

    def check_cells(self, n_vertices: int) -> None:
        """Accept polygons with so few sides that the degree is at most 14."""
        if (degree := self.degree_of(n_vertices)) > HIGHEST_DEGREE:
            raise InputError(
                f"a cell with {n_vertices} vertices for StabilisationFree({self.order}), which takes degree {degree}",
                f"degrees up to {HIGHEST_DEGREE}; monomials of higher ones lose all digits",
                "take Virtual(order), or cells with fewer sides",
            )

    def reconstruct(self, vertices: Floats) -> Reconstruction:
        """Project as `Virtual` does, and the gradient onto the higher degree too; see `Element.reconstruct`."""
        plain = Virtual(self.order).reconstruct(vertices)
        degree = self.degree_of(len(vertices))
        while True:
            cells = Polygons.of(vertices, degree + 1, principal_frame(vertices))
            energetic = _Energetic(
                degree + 1,
                plain.frame,
                plain.projected_value,
                cells.moments,
                plain.monomial_dofs,
                _moments(cells, plain, degree),
            )
            if self.degree is not None or not _free_motions(energetic, 1).any() or degree == HIGHEST_DEGREE:
                break
            degree += 1
        return _Enlarged(
            plain.order,
            plain.frame,
            plain.value,
            plain.moments,
            plain.monomial_dofs,
            plain.gradient_moments,
            plain.energy_moments,
            inner=plain.inner,
            energetic=energetic,
        )

    def interior_dofs(self, vertices: Floats, function: Function, degree: int) -> Floats:
        """As of `Virtual`; see `Element.interior_dofs`."""
        return Virtual(self.order).interior_dofs(vertices, function, degree)

    def stabilise(self, reconstruction: Reconstruction, consistency: Floats) -> None:
        """Nothing; an `InputError` if more than rigid motions are without energy, or round-off takes the gradients."""
        _refuse_lost_digits(self.order, reconstruction)
        m = len(consistency)
        rigid = m * (m + 1) // 2
        free = _free_motions(reconstruction.for_energy, m) if m <= 2 else np.ones(1)  # three: waves along a prism
        if free.any():
            degree = reconstruction.for_energy.order - 1
            x, y = reconstruction.frame.origin[:, int(free.argmax())]
            raise InputError(
                f"StabilisationFree({self.order}) in the cell at ({x:g}, {y:g}): {free.max():g} motions without energy "
                f"besides the {rigid} rigid ones, with gradients of degree {degree}",
                "plane problems, and a degree that leaves rigid motions only",
                f"{f'choose degree={degree + 1} or more, or ' * (self.degree is not None)}take Virtual({self.order})",
            )


def _refuse_lost_digits(order: int, reconstruction: Reconstruction) -> None:
    """Refuse cells of which the projection of a constant gradient is off by more than `MAX_GRADIENT_ERROR`."""
    energetic = reconstruction.for_energy
    gradient = np.einsum("aine,nje->aije", _in_frame(energetic), energetic.monomial_dofs[:, 1:3])
    gradient[0] -= np.eye(2)[:, :, None]
    squares = np.einsum("aije,abe,bije->e", gradient, energetic.mass, gradient, optimize=True) / energetic.areas
    if (squares > MAX_GRADIENT_ERROR**2).any():
        x, y = reconstruction.frame.origin[:, int(np.nanargmax(squares))]
        raise InputError(
            f"StabilisationFree({order}) in the cell at ({x:g}, {y:g}): gradients of degree {energetic.order - 1} are "
            f"off by {np.sqrt(np.nanmax(squares)):.0e}",
            f"up to {MAX_GRADIENT_ERROR:g}, with which displacements keep about four digits",
            f"take Virtual({order}), or cells that are less thin and have fewer sides",
        )


def _free_motions(energetic: Reconstruction, m: int) -> Ints:
    """Number of motions without energy besides the rigid ones, (n_cells,), of a field or of displacements.

    The energy is that of gradients and strains in the frame of the cell, with unit moduli. A linear map ``x = A xi``
    turns displacements u into ``A^T u`` and strains e into ``A^T e A``, so that neither a stretch of the cell nor the
    material changes which motions are without energy.
    """
    n, local = energetic.n_local, _in_frame(energetic)
    products = np.einsum("aime,abe,bjne->ijmne", local, energetic.mass / energetic.areas, local, optimize=True)
    both = products[0, 0] + products[1, 1]
    blocks = both[None, None]
    if m == 2:  # 2 e(u) : e(v) of components i of v and j of u: d_j v d_i u, and grad v . grad u if i is j
        blocks = products.swapaxes(0, 1) + np.eye(2)[:, :, None, None, None] * both
    matrices = blocks.transpose(4, 0, 2, 1, 3).reshape(-1, m * n, m * n)
    lost = ~np.isfinite(matrices).all(axis=(1, 2), keepdims=True)
    values = np.linalg.eigvalsh(np.where(lost, 0.0, matrices))  # no energy is known of these cells
    return (values[:, m * (m + 1) // 2 :] <= MIN_ENERGY * values[:, -1:]).sum(axis=1)


def _in_frame(energetic: Reconstruction) -> Floats:
    """Coefficients of the gradient by local coordinates, shape as `Reconstruction.gradient`."""
    # grad_x = map^T grad_xi
    return np.einsum("jie,ajne->aine", energetic.frame.inverse, energetic.gradient)


def _moments(cells: Polygons, plain: Reconstruction, degree: int) -> Floats:
    """Integrals of gradients times the monomials of a degree l, (n_monomials(l), 2, n_local, n_cells)."""
    order, n_vertices = plain.order, len(cells.local)
    n_local, n_inner = plain.n_local, n_monomials(order - 2)
    result = np.zeros((n_monomials(degree), 2, n_local, plain.value.shape[-1]))
    if degree:
        n_below = n_monomials(degree - 1)
        mass = monomials.mass(max(degree - 1, order), cells.moments)[:n_below, : plain.value.shape[0]]
        values = np.einsum("abe,bme->ame", mass, plain.value)
        values[:n_inner] = 0.0
        inner = min(n_inner, n_below)
        values[:inner, n_local - n_inner :] = plain.inner_moments[:inner]
        derivatives = np.einsum("jie,jba->abie", plain.frame.map, monomials.derivatives(degree))
        result -= np.einsum("abie,bme->aime", derivatives, values, optimize=True)
    abscissae, weights = gauss((order + degree) // 2 + 1)
    shapes = edge_shapes(order, abscissae)
    along = steps_around(cells.local)
    for edge, local in enumerate(edge_unknowns(order, n_vertices)):
        points = cells.local[edge] + abscissae[:, None, None] * along[edge]
        traces = np.einsum("aqe,q,qn->ane", monomials.evaluate(degree, points), weights, shapes)
        result[:, :, local] += traces[:, None] * cells.normals[edge][None, :, None]
    return result
