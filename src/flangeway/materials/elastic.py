"""Isotropic linear elasticity."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from flangeway.errors import InputError
from flangeway.materials.material import (
    Hypothesis,
    Material,
    check_density,
    check_finite,
    check_hypothesis,
    no_expansion,
)

Floats = NDArray[np.float64]


@dataclass(frozen=True)
class Elastic(Material):
    """Isotropic linear elasticity in the plane or about an axis.

    Parameters
    ----------
    young
        Young's modulus E > 0, in the unit of stress.
    poisson
        Poisson's ratio, -1 < nu < 1/2.
    hypothesis
        ``"plane_strain"`` (no strain out of the plane), ``"plane_stress"`` (no stress out of it) or ``"axisymmetric"``
        (x is the radius, y the axis of revolution).
    density
        Mass per volume, for gravity.
    expansion
        Coefficient of thermal expansion, per unit of temperature.

    """

    young: float
    poisson: float
    hypothesis: Hypothesis = "plane_strain"
    density: float | None = None
    expansion: float | None = None

    def __post_init__(self) -> None:
        if not (np.isfinite(self.young) and self.young > 0.0):
            raise InputError(
                f"Elastic(young={self.young})",
                "a positive number",
                "give Young's modulus in the unit of stress, 210000 MPa for steel",
            )
        if not -1.0 < self.poisson < 0.5:
            raise InputError(
                f"Elastic(poisson={self.poisson})",
                "-1 < poisson < 0.5",
                "for nearly incompressible materials take 0.4999 and elements of order 2",
            )
        check_hypothesis("Elastic", self.hypothesis)
        check_density("Elastic", self.density)
        check_finite("Elastic", "expansion", self.expansion)

    @property
    def shear_modulus(self) -> float:
        """Shear modulus G."""
        return self.young / (2.0 * (1.0 + self.poisson))

    @property
    def plane_modulus(self) -> float:
        """Modulus of plane contact, E in plane stress and E / (1 - nu^2) otherwise."""
        if self.hypothesis == "plane_stress":
            return self.young
        return self.young / (1.0 - self.poisson**2)

    @property
    def spatial_matrix(self) -> Floats:
        """See `Material.spatial_matrix`."""
        return self._matrix(self.young * self.poisson / ((1.0 + self.poisson) * (1.0 - 2.0 * self.poisson)))

    @property
    def matrix(self) -> Floats:
        """See `Material.matrix`; plane stress in closed form, so that it keeps its digits near nu = 1/2."""
        if self.hypothesis != "plane_stress":
            return self.spatial_matrix
        matrix = self._matrix(self.young * self.poisson / (1.0 - self.poisson**2))
        matrix[3] = matrix[:, 3] = 0.0
        return matrix

    def _matrix(self, lame: float) -> Floats:
        matrix = np.zeros((4, 4))
        normal = np.array([0, 1, 3])
        matrix[np.ix_(normal, normal)] = lame
        matrix[normal, normal] += 2.0 * self.shear_modulus
        matrix[2, 2] = self.shear_modulus
        return matrix

    @property
    def thermal_strain(self) -> Floats:
        """See `Material.thermal_strain`."""
        if self.expansion is None:
            raise no_expansion(str(self))
        return self.expansion * np.array([1.0, 1.0, 0.0, 1.0])
