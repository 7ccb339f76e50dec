"""Linear elastic materials."""

from dataclasses import dataclass
from typing import Literal, get_args

import numpy as np
from numpy.typing import NDArray

from flangeway.errors import InputError

Floats = NDArray[np.float64]
Hypothesis = Literal["plane_strain", "plane_stress"]


@dataclass(frozen=True)
class Elastic:
    """Isotropic linear elasticity in the plane.

    Parameters
    ----------
    young
        Young's modulus E > 0, in the unit of stress.
    poisson
        Poisson's ratio, -1 < nu < 1/2.
    hypothesis
        ``"plane_strain"`` (no strain out of the plane) or ``"plane_stress"`` (no stress out of it).

    """

    young: float
    poisson: float
    hypothesis: Hypothesis = "plane_strain"

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
        if self.hypothesis not in get_args(Hypothesis):
            raise InputError(
                f"Elastic(hypothesis={self.hypothesis!r})",
                " or ".join(repr(name) for name in get_args(Hypothesis)),
                "choose one of these",
            )

    @property
    def shear_modulus(self) -> float:
        """Shear modulus G."""
        return self.young / (2.0 * (1.0 + self.poisson))

    @property
    def plane_modulus(self) -> float:
        """Modulus of plane contact, E / (1 - nu^2) in plane strain and E in plane stress."""
        if self.hypothesis == "plane_stress":
            return self.young
        return self.young / (1.0 - self.poisson**2)

    @property
    def _lame(self) -> float:
        """Lame's first parameter of the plane problem."""
        nu = self.poisson
        if self.hypothesis == "plane_stress":
            return self.young * nu / (1.0 - nu**2)
        return self.young * nu / ((1.0 + nu) * (1.0 - 2.0 * nu))

    @property
    def stiffness(self) -> Floats:
        """In-plane elasticity tensor ``C[i, j, k, l]``, shape (2, 2, 2, 2): stress = C : strain."""
        delta = np.eye(2)
        symmetric = np.einsum("ik,jl->ijkl", delta, delta) + np.einsum("il,jk->ijkl", delta, delta)
        volumetric: Floats = np.einsum("ij,kl->ijkl", delta, delta)
        return self._lame * volumetric + self.shear_modulus * symmetric

    @property
    def out_of_plane(self) -> Floats:
        """Normal stress out of the plane for each in-plane strain, shape (2, 2)."""
        if self.hypothesis == "plane_stress":
            return np.zeros((2, 2))
        return self._lame * np.eye(2)
