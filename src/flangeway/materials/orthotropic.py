"""Orthotropic linear elasticity."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from flangeway.checks import are_finite, check_finite, check_positive, refused
from flangeway.errors import InputError
from flangeway.materials.material import (
    LEAST_STIFFNESS,
    Hypothesis,
    Material,
    check_density,
    check_hypothesis,
    no_expansion,
)
from flangeway.types import Floats

Triple = tuple[float, float, float]


@dataclass(frozen=True)
class Orthotropic(Material):
    """Orthotropic linear elasticity with axes 1 and 2 in the plane and 3 out of it.

    Parameters
    ----------
    young
        Young's moduli E1, E2, E3 > 0.
    poisson
        Poisson's ratios nu12, nu23, nu13: a stress along the first index strains the second by ``-nu / E`` of the
        first, so that ``nu21 = nu12 E2 / E1``.
    shear
        Shear modulus G12 > 0.
    angle
        Angle in radians from the x axis to axis 1, counter-clockwise.
    hypothesis
        ``"plane_strain"``, ``"plane_stress"`` or ``"axisymmetric"`` (then 3 is the hoop direction).
    density
        Mass per volume, for gravity.
    expansion
        Coefficients of thermal expansion along 1, 2 and 3.
    longitudinal
        Shear moduli G23, G13 > 0, which only `flangeway.problems.Harmonic` needs.

    """

    young: Triple
    poisson: Triple
    shear: float
    angle: float = 0.0
    hypothesis: Hypothesis = "plane_strain"
    density: float | None = None
    expansion: Triple | None = None
    longitudinal: tuple[float, float] | None = None

    def __post_init__(self) -> None:
        check_hypothesis("Orthotropic", self.hypothesis)
        check_density("Orthotropic", self.density)
        check_finite("Orthotropic", "angle", self.angle, "a finite angle in radians")
        for name in ("young", "poisson", "expansion"):
            values = getattr(self, name)
            if not (are_finite(values, 3) or (name == "expansion" and values is None)):
                allowed = "three numbers, finite, for the axes 1, 2 and 3"
                raise refused("Orthotropic", name, values, allowed, "give all three")
        for name, moduli in (("young", self.young), ("shear", (self.shear, *(self.longitudinal or ())))):
            for value in moduli:
                check_positive("Orthotropic", name, value, "positive numbers", "give moduli in the unit of stress")
        least = float(np.linalg.eigvalsh(self._scaled_compliance).min())
        if self.hypothesis == "plane_stress" and least > -LEAST_STIFFNESS:
            least = 1.0 - abs(self._scaled_compliance[0, 1])
        if not least >= LEAST_STIFFNESS:
            raise InputError(
                f"Orthotropic(young={self.young}, poisson={self.poisson}) with a strain of no or negative energy",
                "constants whose compliance is positive definite, so nu12^2 < E1 / E2, nu23^2 < E2 / E3, "
                "nu13^2 < E1 / E3 and more",
                "check that nu12, nu23, nu13 go with stresses along the first index; nu21 = nu12 E2 / E1",
            )

    @property
    def _scaled_compliance(self) -> Floats:
        """Compliance of the normal stresses 1, 2, 3, scaled to ones on the diagonal, shape (3, 3)."""
        (first, second, third), (nu12, nu23, nu13) = self.young, self.poisson
        scaled = np.eye(3)
        scaled[0, 1] = scaled[1, 0] = -nu12 * np.sqrt(second / first)
        scaled[1, 2] = scaled[2, 1] = -nu23 * np.sqrt(third / second)
        scaled[0, 2] = scaled[2, 0] = -nu13 * np.sqrt(third / first)
        return scaled

    @property
    def _to_axes(self) -> Floats:
        """Strains 11, 22, 2 12, 33 from xx, yy, 2 xy, zz, shape (4, 4)."""
        c, s = np.cos(self.angle), np.sin(self.angle)
        return np.array(
            [
                [c * c, s * s, c * s, 0.0],
                [s * s, c * c, -c * s, 0.0],
                [-2.0 * c * s, 2.0 * c * s, c * c - s * s, 0.0],
                [0.0, 0.0, 0.0, 1.0],
            ]
        )

    @property
    def spatial_matrix(self) -> Floats:
        """See `Material.spatial_matrix`."""
        return self._matrix(np.array([0, 1, 3]))

    @property
    def matrix(self) -> Floats:
        """See `Material.matrix`; plane stress from the compliance in the plane, which keeps its digits."""
        return self._matrix(np.array([0, 1])) if self.hypothesis == "plane_stress" else self.spatial_matrix

    def _matrix(self, places: NDArray[np.int64]) -> Floats:
        """Stiffness where there are normal stresses at some places of xx, yy, xy, zz only."""
        n = len(places)
        root = np.sqrt(np.array(self.young, dtype=np.float64))[:n]
        normal = np.linalg.inv(self._scaled_compliance[:n, :n]) * np.outer(root, root)
        matrix = np.zeros((4, 4))
        matrix[np.ix_(places, places)] = (normal + normal.T) / 2.0
        matrix[2, 2] = self.shear
        turned: Floats = self._to_axes.T @ matrix @ self._to_axes
        return turned

    @property
    def longitudinal_shear(self) -> Floats:
        """See `Material.longitudinal_shear`."""
        if self.longitudinal is None:
            raise InputError(
                f"{self} without shear moduli along the third axis",
                "a material with longitudinal=(G23, G13)",
                "give both in the unit of stress",
            )
        c, s = np.cos(self.angle), np.sin(self.angle)
        to_axes = np.array([[c, -s], [s, c]])  # 2 23, 2 13 from 2 yz, 2 xz
        turned: Floats = to_axes.T @ np.diag(self.longitudinal) @ to_axes
        return turned

    @property
    def thermal_strain(self) -> Floats:
        """See `Material.thermal_strain`."""
        if self.expansion is None:
            raise no_expansion(str(self))
        first, second, third = self.expansion
        strain: Floats = np.linalg.solve(self._to_axes, np.array([first, second, 0.0, third]))
        return strain
