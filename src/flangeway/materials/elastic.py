"""Isotropic linear elasticity."""

from dataclasses import dataclass

import numpy as np

from flangeway.checks import check_finite, check_positive, refused
from flangeway.materials.material import (
    LEAST_STIFFNESS,
    Hypothesis,
    Material,
    check_density,
    check_hypothesis,
    no_expansion,
)
from flangeway.types import Floats

NEAR = 0.01
"""Distance of ``1 - 2 nu`` from zero that means a nearly incompressible material."""


@dataclass(frozen=True)
class Elastic(Material):
    """Isotropic linear elasticity in the plane or about an axis.

    Parameters
    ----------
    young
        Young's modulus E > 0, in the unit of stress.
    poisson
        Poisson's ratio, -1 < nu < 1/2, at least 1e-10 from -1 and 5e-11 from 1/2; 1/2 itself in plane stress too.
    hypothesis
        ``"plane_strain"`` (no strain out of the plane), ``"plane_stress"`` (no stress out of it) or ``"axisymmetric"``
        (x is the radius, y the axis of revolution).
    density
        Mass per volume, for gravity.
    expansion
        Coefficient of thermal expansion, per unit of temperature.

    Raises
    ------
    InputError
        If a value is no number, or out of its range.

    """

    young: float
    poisson: float
    hypothesis: Hypothesis = "plane_strain"
    density: float | None = None
    expansion: float | None = None

    def __post_init__(self) -> None:
        advice = "give Young's modulus in the unit of stress, 210000 MPa for steel"
        check_positive("Elastic", "young", self.young, advice=advice)
        check_hypothesis("Elastic", self.hypothesis)
        self._check_poisson()
        check_density("Elastic", self.density)
        if self.expansion is not None:
            check_finite("Elastic", "expansion", self.expansion, "a finite number, or None")

    def _check_poisson(self) -> None:
        plane_stress = self.hypothesis == "plane_stress"
        allowed = "-1 < poisson <= 0.5" if plane_stress else "-1 < poisson < 0.5"
        advice = "give Poisson's ratio, 0.3 for steel"
        poisson = check_finite("Elastic", "poisson", self.poisson, allowed, advice)
        least = min(1.0 + poisson, 1.0 - 2.0 * poisson)
        if plane_stress and 0.0 <= poisson <= 0.5:
            least = 1.0
        if least >= LEAST_STIFFNESS:
            return
        if abs(least) < NEAR and poisson > 0.0:
            advice = "for nearly incompressible materials take 0.4999 and elements of order 2"
        if least > 0.0:
            allowed += f", with 1 - 2 poisson and 1 + poisson of {LEAST_STIFFNESS:g} or more"
        raise refused("Elastic", "poisson", self.poisson, allowed, advice)

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
        """See `Material.spatial_matrix`; an InputError for Poisson's ratio 1/2, of which it is infinite."""
        if self.poisson == 0.5:
            raise refused("Elastic", "poisson", 0.5, "plane stress only", "take 0.4999 for other hypotheses")
        return self._matrix(self.young * self.poisson / ((1.0 + self.poisson) * (1.0 - 2.0 * self.poisson)))

    @property
    def matrix(self) -> Floats:
        """See `Material.matrix`; plane stress in closed form, so that it keeps its digits near nu = 1/2."""
        if self.hypothesis != "plane_stress":
            return self.spatial_matrix
        matrix = self._matrix(self.young * self.poisson / (1.0 - self.poisson**2))
        matrix[3] = matrix[:, 3] = 0.0
        return matrix

    @property
    def longitudinal_shear(self) -> Floats:
        """See `Material.longitudinal_shear`."""
        return self.shear_modulus * np.eye(2)

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
