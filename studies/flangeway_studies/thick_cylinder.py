"""Thick cylinders under pressure in closed form."""

from dataclasses import dataclass

import numpy as np

from flangeway.checks import are_finite, check_finite
from flangeway.errors import InputError, short
from flangeway.types import Floats


@dataclass(frozen=True)
class ThickCylinder:
    """Isotropic cylinder under internal and external pressure (Lame, 1852; Timoshenko and Goodier, 1970, art. 28).

    Parameters
    ----------
    inner_radius, outer_radius
        Radii, 0 < inner < outer.
    inner_pressure, outer_pressure
        Pressures, positive in compression.

    """

    inner_radius: float
    outer_radius: float
    inner_pressure: float
    outer_pressure: float = 0.0

    def __post_init__(self) -> None:
        radii = self.inner_radius, self.outer_radius
        if not (are_finite(radii, 2) and 0.0 < radii[0] < radii[1]):
            raise InputError(
                f"ThickCylinder(inner_radius={short(radii[0])}, outer_radius={short(radii[1])})",
                "0 < inner_radius < outer_radius",
                "give both radii",
            )
        for name in ("inner_pressure", "outer_pressure"):
            check_finite("ThickCylinder", name, getattr(self, name))

    @property
    def _constants(self) -> tuple[float, float]:
        """Constants A and B of ``A -+ B / r^2``."""
        inner, outer = self.inner_radius**2, self.outer_radius**2
        mean = (self.inner_pressure * inner - self.outer_pressure * outer) / (outer - inner)
        varying = (self.inner_pressure - self.outer_pressure) * inner * outer / (outer - inner)
        return mean, varying

    def radial_stress(self, radius: Floats) -> Floats:
        """Radial stress at radii (n,)."""
        mean, varying = self._constants
        return mean - varying / np.asarray(radius) ** 2

    def hoop_stress(self, radius: Floats) -> Floats:
        """Hoop stress at radii (n,)."""
        mean, varying = self._constants
        return mean + varying / np.asarray(radius) ** 2

    def radial_displacement(self, radius: Floats, young: float, poisson: float, *, plane_strain: bool = True) -> Floats:
        """Radial displacement at radii (n,), with no strain or no stress along the axis."""
        mean, varying = self._constants
        r = np.asarray(radius)
        if plane_strain:
            return (1.0 + poisson) / young * ((1.0 - 2.0 * poisson) * mean * r + varying / r)
        return ((1.0 - poisson) * mean * r + (1.0 + poisson) * varying / r) / young
