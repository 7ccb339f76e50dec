"""What every element gives, whatever its method: polynomials from degrees of freedom.

An element is a reconstruction plus a stabilisation (see `docs/theory.md`). Stiffness, loads, stresses and
norms are computed from the coefficients below and never ask which method a cell uses.
"""

from abc import ABC, abstractmethod
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from flangeway.elements import monomials
from flangeway.elements.monomials import Frame

Floats = NDArray[np.float64]


@dataclass(frozen=True)
class Reconstruction:
    """Polynomials of a batch of cells as linear maps of one field's local degrees of freedom.

    Parameters
    ----------
    order
        Order k of the element.
    frame
        The local coordinates in which the monomials are written.
    value
        Coefficients of the value, degree k, shape (n_monomials(k), n_local, n_cells).
    gradient
        Coefficients of the gradient in the axes of space, degree k - 1,
        shape (n_monomials(k - 1), 2, n_local, n_cells).
    moments
        Integrals of the monomials up to degree 2 k over each cell, shape (n_monomials(2 k), n_cells).
    monomial_dofs
        Degrees of freedom of the monomials of degree k, shape (n_local, n_monomials(k), n_cells).
    exact
        Whether every discrete function is a polynomial of degree k, so that nothing is left to stabilise.

    """

    order: int
    frame: Frame
    value: Floats
    gradient: Floats
    moments: Floats
    monomial_dofs: Floats
    exact: bool

    @property
    def n_local(self) -> int:
        """Number of local degrees of freedom of one field."""
        return int(self.gradient.shape[2])

    @property
    def mass(self) -> Floats:
        """Integrals of products of the monomials of degree k - 1, shape (n, n, n_cells)."""
        return monomials.mass(self.order - 1, self.moments)

    @property
    def areas(self) -> Floats:
        """Areas of the cells, shape (n_cells,)."""
        return self.moments[0]


class Element(ABC):
    """A finite or virtual element of some order; its subclasses are final."""

    order: int

    @abstractmethod
    def n_interior(self) -> int:
        """Degrees of freedom of one field that belong to the inside of one cell."""

    @abstractmethod
    def check_cells(self, n_vertices: int) -> None:
        """Raise `InputError` when the element has no form for cells of so many vertices."""

    @abstractmethod
    def reconstruct(self, vertices: Floats) -> Reconstruction:
        """Reconstruct on cells with the same number of vertices.

        Parameters
        ----------
        vertices
            Counter-clockwise vertices, shape (n_vertices, 2, n_cells).

        Returns
        -------
        Reconstruction
            Local degrees of freedom in the order: vertices, then ``order - 1`` Gauss-Lobatto points inside
            each edge in its direction, then the inside of the cell.

        """

    @abstractmethod
    def stabilisation(
        self, reconstruction: Reconstruction, consistency: Floats
    ) -> Floats | None:
        """Stiffness of what the reconstruction misses, or None when it misses nothing.

        Parameters
        ----------
        reconstruction
            The cells' reconstruction.
        consistency
            The stiffness of the reconstructed field with components first,
            shape (n_components, n_components, n_local, n_local, n_cells).

        Returns
        -------
        Floats or None
            Shape (n_local, n_local, n_cells), to be added to each component's own block.

        """
