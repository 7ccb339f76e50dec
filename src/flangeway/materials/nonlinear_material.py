"""Nonlinear materials: stress, consistent tangent and history at points, from the displacement's gradient."""

from abc import ABC, abstractmethod
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from flangeway.checks import check_finite, check_positive
from flangeway.errors import InputError
from flangeway.materials.elastic import Elastic
from flangeway.types import Floats

NORMALS, SHEARS = np.array([0, 1, 3]), np.array([2, 4, 5])
"""Places of normal components and of shears among xx, yy, xy, zz, and in space yz and xz."""
TENSOR = np.array([[0, 2, 5], [2, 1, 4], [5, 4, 3]])
"""Place of each component of a tensor among them."""
PLASTIC = np.array([0, 1, 2, 3, 5, 6])
"""Places of the plastic strain in the history of `J2Plasticity`."""


class Response(NamedTuple):
    """What a material answers at n points.

    Parameters
    ----------
    stress
        First Piola-Kirchhoff stress, force along i per undeformed area normal to J, (n, d, d) with d = 2 in the plane
        and 3 in space; the stress itself where strains are small.
    tangent
        Its derivative by the gradient, ``A[i, J, k, L]``, (n, d, d, d, d).
    history
        The history after the step, (n, n_history).

    """

    stress: Floats
    tangent: Floats
    history: Floats


class NonlinearMaterial(ABC):
    """A nonlinear material in plane strain or in space.

    Parameters
    ----------
    elastic
        Linear elasticity of the undeformed material: units, and the start of Newton's method.
    n_history
        How many numbers a point remembers, all zero at first.

    """

    elastic: Elastic
    n_history: int = 0

    @abstractmethod
    def respond(self, gradient: Floats, history: Floats) -> Response:
        """Stress at points.

        Parameters
        ----------
        gradient
            Gradient of the displacement, ``gradient[:, i, J]`` the derivative of component i by axis J, (n, d, d).
        history
            History before the step, (n, n_history).

        """

    def _check_plane_strain(self) -> None:
        if not isinstance(self.elastic, Elastic) or self.elastic.hypothesis != "plane_strain":
            raise InputError(
                f"{type(self).__name__} with elastic={self.elastic!r}",
                "Elastic(young, poisson) in plane strain",
                "leave the hypothesis out",
            )


@dataclass(frozen=True)
class NeoHooke(NonlinearMaterial):
    """Compressible neo-Hooke: energy ``G / 2 (tr F^T F - d - 2 ln J) + L / 2 (ln J)^2`` (Bonet and Wood, 2008, 6.27).

    Parameters
    ----------
    elastic
        Elasticity at small strains in plane strain, which gives Lame's constants G and L.

    Raises
    ------
    InputError
        If the elasticity is not one of plane strain.

    """

    elastic: Elastic

    def __post_init__(self) -> None:
        self._check_plane_strain()

    def respond(self, gradient: Floats, history: Floats) -> Response:
        """See `NonlinearMaterial.respond`; where F turns a point inside out, the stress is not a number."""
        shear = self.elastic.shear_modulus
        lame = float(self.elastic.matrix[0, 1])
        unit = np.eye(gradient.shape[1])
        deformation = gradient + unit
        if len(unit) == 2:
            (a, b), (c, d) = np.moveaxis(deformation, 0, -1)
            volume = a * d - b * c
            inverse = np.moveaxis(np.array([[d, -b], [-c, a]]) / volume, -1, 0)
        else:
            volume, inverse = np.linalg.det(deformation), np.linalg.inv(deformation)
        with np.errstate(invalid="ignore", divide="ignore"):
            pressure = (lame * np.log(volume) - shear)[:, None, None]
        stress = shear * deformation + pressure * inverse.swapaxes(1, 2)
        # A_iJkL = G d_ik d_JL + L F^-1_Ji F^-1_Lk + (G - L ln J) F^-1_Li F^-1_Jk
        tangent = shear * np.einsum("ik,jl->ijkl", unit, unit) + lame * np.einsum("nji,nlk->nijkl", inverse, inverse)
        tangent -= pressure[..., None, None] * np.einsum("nli,njk->nijkl", inverse, inverse)
        return Response(stress, tangent, history)


@dataclass(frozen=True)
class J2Plasticity(NonlinearMaterial):
    """Small strains, von Mises' yield surface, linear isotropic and kinematic hardening: radial return.

    Simo and Hughes (1998, Computational Inelasticity, boxes 3.1 and 3.2). The history is the plastic strain xx, yy, xy,
    zz, the equivalent plastic strain, and the plastic strain yz and xz, which is zero in the plane.

    Parameters
    ----------
    elastic
        Elasticity in plane strain.
    yield_stress
        Yield stress in tension, > 0.
    isotropic
        Growth of the yield stress per equivalent plastic strain, >= 0.
    kinematic
        Modulus H of the back stress ``2/3 H`` times plastic strain, >= 0.

    Raises
    ------
    InputError
        If a value is out of its range.

    """

    elastic: Elastic
    yield_stress: float
    isotropic: float = 0.0
    kinematic: float = 0.0
    n_history = 7

    def __post_init__(self) -> None:
        self._check_plane_strain()
        check_positive("J2Plasticity", "yield_stress", self.yield_stress, advice="give it in the unit of stress")
        for name in ("isotropic", "kinematic"):
            if check_finite("J2Plasticity", name, getattr(self, name), "a finite number >= 0") < 0.0:
                raise InputError(f"J2Plasticity: {name}={getattr(self, name)}", "a number >= 0", "softening localises")

    def respond(self, gradient: Floats, history: Floats) -> Response:
        """See `NonlinearMaterial.respond`."""
        shear, hardening = self.elastic.shear_modulus, self.isotropic + self.kinematic
        bulk = float(self.elastic.matrix[0, 1]) + 2.0 / 3.0 * shear
        d, n = gradient.shape[1], len(gradient)
        unit, tensor, shears, plastic = np.eye(d), TENSOR[:d, :d], SHEARS[: 2 * d - 3], PLASTIC[: 2 * d]
        strain = np.zeros((n, 2 * d))
        strain[:, tensor] = (gradient + gradient.swapaxes(1, 2)) / 2.0
        volume = strain[:, NORMALS].sum(axis=1)
        deviator = strain - history[:, plastic]
        deviator[:, NORMALS] -= volume[:, None] / 3.0
        trial = 2.0 * shear * deviator - 2.0 / 3.0 * self.kinematic * history[:, plastic]
        size = np.sqrt((trial[:, NORMALS] ** 2).sum(axis=1) + 2.0 * (trial[:, shears] ** 2).sum(axis=1))
        beyond = size - np.sqrt(2.0 / 3.0) * (self.yield_stress + self.isotropic * history[:, 4])
        flow = np.maximum(beyond, 0.0) / (2.0 * shear + 2.0 / 3.0 * hardening)
        normal = trial / np.maximum(size, np.finfo(float).tiny)[:, None]
        after = history.copy()
        after[:, plastic] += flow[:, None] * normal
        after[:, 4] += np.sqrt(2.0 / 3.0) * flow
        stress = 2.0 * shear * (deviator - flow[:, None] * normal)
        stress[:, NORMALS] += bulk * volume[:, None]
        # C = K 1 x 1 + 2 G theta (I - 1 x 1 / 3) - 2 G theta_bar n x n
        theta = 1.0 - 2.0 * shear * flow / np.maximum(size, np.finfo(float).tiny)
        theta_bar = np.where(flow > 0.0, 1.0 / (1.0 + hardening / (3.0 * shear)) - (1.0 - theta), 0.0)
        directions, products = normal[:, tensor], np.einsum("ik,jl->ijkl", unit, unit)
        # the strain of a gradient is (d_ik d_jl + d_il d_jk) / 2 times it
        tangent = 2.0 * shear * theta[:, None, None, None, None] * (products + products.swapaxes(2, 3)) / 2.0
        pressure = bulk - 2.0 / 3.0 * shear * theta
        tangent = tangent + np.einsum("n,ij,kl->nijkl", pressure, unit, unit)
        tangent -= np.einsum("n,nij,nkl->nijkl", 2.0 * shear * theta_bar, directions, directions)
        return Response(stress[:, tensor], tangent, after)
