"""Virtual elements whose stiffness needs no stabilisation, since gradients are projected onto a higher degree."""

from dataclasses import dataclass, field

import numpy as np

from flangeway.checks import check_integer
from flangeway.elements import monomials
from flangeway.elements.monomials import n_monomials
from flangeway.elements.projection import Polygons, principal_frame
from flangeway.elements.quadrature import edge_shapes, edge_unknowns, gauss
from flangeway.elements.reconstruction import Element, Function, Reconstruction
from flangeway.elements.virtual import Virtual
from flangeway.errors import InputError
from flangeway.geometry.arrays import steps_around
from flangeway.types import Floats, Ints

HIGHEST_ORDER = 3
HIGHEST_DEGREE = 14
MAX_GRADIENT_ERROR = 1e-10
"""Error of a constant gradient; displacements of cells with thin parts lose up to six digits more (measured)."""
WITHOUT_ENERGY = 1e-11
"""Eigenvalue of a cell's energy in its own frame relative to the maximum, below which it is round-off."""


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
        allowed = f"orders 1 to {HIGHEST_ORDER}"
        check_integer("StabilisationFree", "order", self.order, 1, HIGHEST_ORDER, allowed, "take Virtual(order) above")
        if self.degree is not None:
            low = self.order - 1
            check_integer("StabilisationFree", "degree", self.degree, low, HIGHEST_DEGREE, advice="leave it out")

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
            cells = Polygons.of(vertices, max(degree, self.order), principal_frame(vertices))
            energetic = Reconstruction(
                degree + 1, plain.frame, plain.value, cells.moments, plain.monomial_dofs, _moments(cells, plain, degree)
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
    return (values[:, m * (m + 1) // 2 :] <= WITHOUT_ENERGY * values[:, -1:]).sum(axis=1)


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
    places, weights = gauss((order + degree) // 2 + 1)
    shapes = edge_shapes(order, places)
    along = steps_around(cells.local)
    for edge, local in enumerate(edge_unknowns(order, n_vertices)):
        points = cells.local[edge] + places[:, None, None] * along[edge]
        traces = np.einsum("aqe,q,qn->ane", monomials.evaluate(degree, points), weights, shapes)
        result[:, :, local] += traces[:, None] * cells.normals[edge][None, :, None]
    return result
