"""Serendipity virtual elements: fewer moments inside, as many as the lines of the boundary leave open."""

from dataclasses import dataclass, field

import numpy as np

from flangeway.checks import check_integer
from flangeway.elements import batched
from flangeway.elements.monomials import n_monomials
from flangeway.elements.reconstruction import Element, Function, Reconstruction
from flangeway.elements.stabilisation import Stabilisation
from flangeway.elements.virtual import HIGHEST_ORDER, Virtual
from flangeway.errors import InputError
from flangeway.geometry.arrays import steps_around
from flangeway.types import Floats, Ints

ONE_LINE = 1e-6
"""Angle, and distance over the size of the cell, up to which two sides count as one line."""
UNDETERMINED = 1e-6
"""Singular value of the unknowns of polynomials over the highest one, below which they do not determine them."""


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

    def _too_few(self, where: str, found: int) -> InputError:
        return InputError(
            f"{where} on {found} different lines for Serendipity({self.order}, lines={self.lines})",
            f"cells with at least {self.lines} lines",
            f"choose lines={found} for the cell set of such cells" if found >= 3 else "check the mesh",
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
        found = distinct_lines(full.monomial_dofs[:n_vertices, 1:3])
        if (found < self.lines).any():
            raise self._too_few(_place(full, int(found.argmin())), int(found.min()))
        dofs = full.monomial_dofs[: self.order * n_vertices + self.n_interior()]
        values = np.linalg.svd(dofs.transpose(2, 0, 1), compute_uv=False)
        poor = values[:, -1] < UNDETERMINED * values[:, 0]
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
        counts += ~((turned <= ONE_LINE) & (offset <= ONE_LINE * size)).any(axis=0)
    return counts
