"""What every element gives: polynomials from degrees of freedom, a stiffness from their energy, and stabilisations."""

from abc import ABC, abstractmethod
from collections.abc import Callable
from dataclasses import dataclass
from functools import cached_property
from typing import Any, ClassVar

import numpy as np

from flangeway.checks import check_positive
from flangeway.elements import batched, monomials
from flangeway.elements.monomials import Frame, n_monomials
from flangeway.types import Floats

# --- What every element gives, whatever its method: polynomials from degrees of freedom.
#
# An element is a reconstruction plus a stabilisation (see `docs/theory/elements.md`). Stiffness, loads, stresses and
# norms are computed from the coefficients below and never ask which method a cell uses.


Function = Callable[[Floats], Floats]
"""A function of points (n, 2) with values (n,), or (n, m) for m components."""


@dataclass(frozen=True, eq=False)
class Reconstruction:
    """Polynomials of a batch of cells as linear maps of one field's local degrees of freedom.

    Parameters
    ----------
    order
        Order k of the element.
    frame
        The local coordinates in which the monomials are written.
    value
        Coefficients of the value, degree k, shape (n_monomials(k), n_local, n_cells). A virtual element's
        is orthogonal in energy (Moherdaui 2021, 3.54).
    moments
        Integrals of the monomials up to degree 2 k over each cell, shape (n_monomials(2 k), n_cells).
    monomial_dofs
        Degrees of freedom of the monomials of degree k, shape (n_local, n_monomials(k), n_cells).
    gradient_moments
        Integrals of the gradient times the monomials of degree k - 1, in the axes of space,
        shape (n_monomials(k - 1), d, n_local, n_cells). None if every discrete function is a polynomial
        of degree k, so that nothing is left to project or to stabilise.
    energy_moments
        Integrals of the gradient times those of the monomials from degree 1, the matrix B of Moherdaui (2021, 3.60)
        without its first row, shape (n_monomials(k) - 1, n_local, n_cells); None for the same elements.
    value_moments
        Integrals of the value times the monomials of degree k, shape as `value`, where they are known. None: those up
        to degree k - 2 are the last degrees of freedom.
    missed
        Integrals of products of what `gradient` misses, (n_local, n_local, n_cells), where they are known.
    inner
        Monomials in terms of the polynomials whose moments are degrees of freedom, see `inner_factor`; None: the same.

    """

    order: int
    frame: Frame
    value: Floats
    moments: Floats
    monomial_dofs: Floats
    gradient_moments: Floats | None = None
    energy_moments: Floats | None = None
    value_moments: Floats | None = None
    missed: Floats | None = None
    inner: Floats | None = None

    @property
    def exact(self) -> bool:
        """Whether every discrete function is its own reconstruction."""
        return self.gradient_moments is None

    @property
    def for_energy(self) -> "Reconstruction":
        """Reconstruction whose `gradient` the stiffness is made of: itself, but for elements without stabilisation."""
        return self

    @property
    def n_interior(self) -> int:
        """Number of local degrees of freedom inside the cell, which are the last ones; of virtual elements."""
        return n_monomials(self.order - 2, self.dimension)

    @property
    def dimension(self) -> int:
        """Number of coordinates, 2 or 3."""
        return len(self.frame.map)

    @property
    def n_local(self) -> int:
        """Number of local degrees of freedom of one field."""
        return int(self.value.shape[1])

    @property
    def areas(self) -> Floats:
        """Areas of the cells, volumes of those in space, shape (n_cells,)."""
        return self.moments[0]

    @cached_property
    def mass(self) -> Floats:
        """Integrals of products of the monomials of degree k - 1, shape (n, n, n_cells)."""
        return monomials.mass(self.order - 1, self.moments, self.dimension)

    @cached_property
    def value_gradient(self) -> Floats:
        """Coefficients of the gradient of `value`, degree k - 1, shape as `gradient`."""
        # d_i v = sum_j map_ji (derivative of v by the local coordinate j)
        entries = monomials.derivative_entries(self.order, self.dimension)
        local = [self.value[columns] * factors[:, None, None] for columns, factors in entries]
        gradient = np.empty((len(local[0]), self.dimension, *self.value.shape[1:]))
        for axis in range(self.dimension):
            np.multiply(local[0], self.frame.map[0, axis], out=gradient[:, axis])
            for derivative, row in zip(local[1:], self.frame.map[1:], strict=True):
                gradient[:, axis] += derivative * row[axis]
        return gradient

    def value_energy(self, moduli: Floats) -> Floats:
        """Integrals of products of the gradients of `value` times moduli (n_cells,), (n_local, n_local, n_cells).

        This is the consistency of Moherdaui (2021, 3.69), ``Pi^T B``.
        """
        if self.energy_moments is None:
            return self.gradient_energy(self.value_gradient, moduli)
        return batched.symmetric_product(self.value[1:], self.energy_moments * moduli)

    def gradient_energy(self, gradient: Floats, moduli: Floats) -> Floats:
        """Integrals of products of gradients with coefficients like those of `gradient`."""
        weighted = np.einsum("abe,bime->aime", self.mass * moduli, gradient)
        rows = (-1, *gradient.shape[2:])
        return batched.symmetric_product(gradient.reshape(rows), weighted.reshape(rows))

    @cached_property
    def gradient(self) -> Floats:
        """Coefficients of the L2 projection of the gradient in the axes of space, degree k - 1.

        Returns
        -------
        Floats
            Shape (n_monomials(k - 1), d, n_local, n_cells).

        """
        moments = self.gradient_moments
        if moments is None:
            return self.value_gradient
        flat = moments.reshape(len(moments), -1, moments.shape[-1])
        return batched.solve(self.mass, flat).reshape(moments.shape)

    @cached_property
    def projected_value(self) -> Floats:
        """Coefficients of the L2 projection of the value, degree k, shape as `value` (Moherdaui 2021, 3.76).

        Moments up to degree k - 2 are degrees of freedom; those of degree k - 1 and k are, in the enhanced
        space (Ahmad et al., 2013, "Equivalent projectors for virtual element methods"), the moments of
        `value`. For k = 1 and 2 both projections agree (Moherdaui 2021, 3.80).
        """
        if self.exact or (self.order <= 2 and self.value_moments is None):
            return self.value
        mass = monomials.mass(self.order, self.moments, self.dimension)
        if self.value_moments is not None:
            return batched.solve(mass, self.value_moments)
        rhs = np.einsum("abe,bme->ame", mass, self.value)
        n_inner = n_monomials(self.order - 2, self.dimension)
        rhs[:n_inner] = 0.0
        rhs[:n_inner, self.n_local - n_inner :] = self.inner_moments
        return batched.solve(mass, rhs)

    @property
    def inner_moments(self) -> Floats:
        """Integrals of the value times monomials by the degrees of freedom inside, (n_inner, n_inner, n_cells)."""
        factor = np.eye(self.n_interior)[:, :, None] if self.inner is None else self.inner
        return factor * self.areas

    def coordinate_dofs(self) -> Floats:
        """Degrees of freedom of the coordinates about the cells' origins, (n_local, d, n_cells)."""
        linear = self.monomial_dofs[:, 1 : 1 + self.dimension]
        return np.einsum("iae,xae->ixe", linear, self.frame.inverse)

    def at(self, points: Floats) -> Floats:
        """Values of the monomials of degree k at points (..., 2, n_cells), shape (n, ..., n_cells)."""
        return monomials.evaluate(self.order, self.frame.local(points))


class Element(ABC):
    """A finite or virtual element of some order; its subclasses are final."""

    order: int
    curved: ClassVar[bool] = False
    """Whether cells may have curved edges: arrays of vertices may then be outlines, (n_vertices, order, 2, n_cells)."""
    spatial: ClassVar[bool] = False
    """Whether cells may be polyhedra, at order 1."""

    @abstractmethod
    def n_interior(self) -> int:
        """Degrees of freedom of one field that belong to the inside of one cell."""

    @abstractmethod
    def check_cells(self, n_vertices: int) -> None:
        """Raise `InputError` when the element has no form for cells of so many vertices."""

    def locks(self, n_vertices: int) -> bool:
        """Whether cells of so many vertices become too stiff where their volume is nearly constant."""
        return self.order == 1 and n_vertices == 3

    @abstractmethod
    def reconstruct(self, vertices: Any) -> Reconstruction:
        """Reconstruct on cells with the same number of vertices.

        Parameters
        ----------
        vertices
            Counter-clockwise vertices, shape (n_vertices, 2, n_cells); of a `spatial` element also `Polyhedra`.

        Returns
        -------
        Reconstruction
            Local degrees of freedom in the order: vertices, then ``order - 1`` Gauss-Lobatto points inside
            each edge in its direction, then the inside of the cell.

        """

    @abstractmethod
    def interior_dofs(self, vertices: Floats, function: Function, degree: int) -> Floats:
        """Degrees of freedom inside the cells of a given function.

        Parameters
        ----------
        vertices
            Counter-clockwise vertices, shape (n_vertices, 2, n_cells).
        function
            Takes points (n, 2), gives values (n,).
        degree
            Moments are exact for functions that are polynomials of this degree.

        Returns
        -------
        Floats
            Shape (n_interior, n_cells).

        """

    @abstractmethod
    def stabilise(self, reconstruction: Reconstruction, consistency: Floats) -> Floats | None:
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


# --- Stiffness of one scalar field on a batch of cells, from the energy of its reconstruction.


def energy_stiffness(element: Element, reconstruction: Reconstruction, moduli: Floats) -> Floats:
    """Consistency (Moherdaui 2021, 3.69) plus stabilisation.

    Parameters
    ----------
    element
        Element of the cells.
    reconstruction
        Their reconstruction.
    moduli
        Modulus of each cell, shape (n_cells,).

    Returns
    -------
    Floats
        Shape (n_local, n_local, n_cells).

    """
    consistency = reconstruction.value_energy(moduli)
    added = element.stabilise(reconstruction, consistency[None, None])
    return consistency if added is None else consistency + added


# --- Stabilisations: a stiffness for what the projection of a virtual element does not see.
#
# Each acts on ``I - D Pi``, the part of the degrees of freedom that the projected polynomial misses, and scales with
# the problem's moduli, so that results do not depend on units.


class Stabilisation(ABC):
    """A stiffness that vanishes on polynomials of degree k; its subclasses are final."""

    @abstractmethod
    def matrices(self, reconstruction: Reconstruction, consistency: Floats) -> Floats | None:
        """Matrices of cells; arguments and result as in `Element.stabilise`."""


class _WithFactor(Stabilisation):
    """A stabilisation with a factor, > 0."""

    factor: float

    def __post_init__(self) -> None:
        check_positive(type(self).__name__, "factor", self.factor, advice="leave the default")


def mean_modulus(reconstruction: Reconstruction, consistency: Floats) -> Floats:
    """Mean modulus, shape (n_cells,): the energy of the coordinates x and y, whose gradients every projection keeps.

    For a scalar problem it is the problem's own modulus.
    """
    linear = reconstruction.coordinate_dofs()
    forces = np.einsum("ccmne,nxe->mxe", consistency, linear)
    energy = np.einsum("mxe,mxe->e", linear, forces)
    return energy / (float(reconstruction.dimension * len(consistency)) * reconstruction.areas)


@dataclass(frozen=True)
class IdentityStabilisation(_WithFactor):
    """Modulus times ``(I - D Pi)^T (I - D Pi)`` (Moherdaui 2021, 3.71; Beirao da Veiga et al., 2013).

    Parameters
    ----------
    factor
        Factor, 1 as published.

    """

    factor: float = 1.0

    def matrices(self, reconstruction: Reconstruction, consistency: Floats) -> Floats:
        """Matrices of cells; see `Stabilisation.matrices`."""
        return _weighted_missed(reconstruction, self.factor * mean_modulus(reconstruction, consistency))


@dataclass(frozen=True)
class DiagonalStabilisation(_WithFactor):
    """``(I - D Pi)^T diag(max(modulus, K_c,ii)) (I - D Pi)``, the diagonal recipe.

    It follows the growth of the consistency's diagonal with the order (Beirao da Veiga, Dassi and Russo, 2017,
    "High-order virtual element method on polyhedral meshes", section 4).

    Parameters
    ----------
    factor
        Factor, 1 as published.

    """

    factor: float = 1.0

    def matrices(self, reconstruction: Reconstruction, consistency: Floats) -> Floats:
        """Matrices of cells; see `Stabilisation.matrices`."""
        diagonal = np.einsum("cciie->ie", consistency) / len(consistency)
        weights = np.maximum(diagonal, mean_modulus(reconstruction, consistency))
        return _weighted_missed(reconstruction, self.factor * weights)


def missed_mass(reconstruction: Reconstruction) -> Floats:
    """``(I - D Pi)^T (I - D Pi)``, Pi the L2 projection of the value, each unknown with an equal share of the area.

    Products of the values that the projection misses, shape (n_local, n_local, n_cells).
    """
    return _weighted_missed(
        reconstruction, reconstruction.areas / reconstruction.n_local, reconstruction.projected_value
    )


def _weighted_missed(reconstruction: Reconstruction, weights: Floats, projection: Floats | None = None) -> Floats:
    """``(I - D Pi)^T diag(weights) (I - D Pi)``, by the energy projection unless another one is given.

    - `weights`: of the degrees of freedom (n_local, n_cells), or one for all (n_cells,).
    """
    value = reconstruction.value if projection is None else projection
    missed = -np.einsum("iae,ame->ime", reconstruction.monomial_dofs, value)
    dofs = np.arange(reconstruction.n_local)
    missed[dofs, dofs] += 1.0
    return batched.symmetric_product(missed, missed * np.broadcast_to(weights, missed.shape[::2])[:, None])


@dataclass(frozen=True)
class SpectralStabilisation(_WithFactor):
    """``(I - D Pi)^T diag(max(K_c,ii, factor m)) (I - D Pi)``, m the mean eigenvalue of the cell's own edges.

    The mean is the trace of the consistency over the degrees of freedom on the boundary, of all components, by the
    number of strains that it can have: the dimension of the polynomials of degree k without rigid motions. So what the
    projection misses is about as stiff as what it sees, however many edges the cell has; a modulus in its place, as in
    `DiagonalStabilisation`, is many times too stiff for a hundred short edges, and the trace for four.

    Parameters
    ----------
    factor
        Factor of the mean eigenvalue, 1/3 by measurement (docs/theory/elements.md).

    """

    factor: float = 1.0 / 3.0

    def matrices(self, reconstruction: Reconstruction, consistency: Floats) -> Floats:
        """Matrices of cells; see `Stabilisation.matrices`."""
        n_components, order = len(consistency), reconstruction.order
        diagonal = np.einsum("cciie->ie", consistency) / n_components
        n_boundary = reconstruction.n_local - reconstruction.n_interior
        n_polynomials = n_monomials(order, reconstruction.dimension)
        n_strains = n_components * n_polynomials - n_components * (n_components + 1) // 2
        mean = diagonal[:n_boundary].sum(axis=0) * (n_components / n_strains)
        return _weighted_missed(reconstruction, np.maximum(diagonal, self.factor * mean))


@dataclass(frozen=True)
class TraceStabilisation(_WithFactor):
    """``factor tr(K_c) (I - Q Q^T)``, Q an orthonormal basis of the polynomials' unknowns (Moherdaui 2021, 3.96).

    Parameters
    ----------
    factor
        Factor of the trace over all components, 0.5 as published.

    """

    factor: float = 0.5

    def matrices(self, reconstruction: Reconstruction, consistency: Floats) -> Floats:
        """Matrices of cells; see `Stabilisation.matrices`."""
        dofs = reconstruction.monomial_dofs
        gram = np.einsum("iae,ibe->abe", dofs, dofs)
        polynomial = np.einsum("iae,aje->ije", dofs, batched.solve(gram, dofs.swapaxes(0, 1)))
        trace = np.einsum("cciie->e", consistency)
        return self.factor * trace * (np.eye(reconstruction.n_local)[:, :, None] - polynomial)


@dataclass(frozen=True)
class NoStabilisation(Stabilisation):
    """Nothing, to look at the consistency alone: on most polygons the stiffness is then singular."""

    def matrices(
        self,
        reconstruction: Reconstruction,
        consistency: Floats,
    ) -> None:
        """Nothing."""
