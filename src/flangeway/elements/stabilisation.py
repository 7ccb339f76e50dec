"""Stabilisations: a stiffness for what the projection of a virtual element does not see.

Each acts on ``I - D Pi``, the part of the degrees of freedom that the projected polynomial misses, and scales with
the problem's moduli, so that results do not depend on units.
"""

from abc import ABC, abstractmethod
from dataclasses import dataclass

import numpy as np

from flangeway.checks import check_positive
from flangeway.elements import batched
from flangeway.elements.monomials import n_monomials
from flangeway.elements.reconstruction import Reconstruction
from flangeway.types import Floats


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
    return energy / (2.0 * len(consistency) * reconstruction.areas)


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
    places = np.arange(reconstruction.n_local)
    missed[places, places] += 1.0
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
        n_strains = n_components * n_monomials(order) - n_components * (n_components + 1) // 2
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
