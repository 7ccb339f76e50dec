"""Linear elastic materials, isotropic and orthotropic, in the plane or about an axis."""

from abc import ABC, abstractmethod
from dataclasses import dataclass
from typing import Literal, get_args

import numpy as np

from flangeway.checks import are_finite, check_finite, check_positive, refused
from flangeway.errors import InputError
from flangeway.types import Floats, Ints

# --- What every linear elastic material gives, in the plane or about an axis.


MAX_BULK = 5.0
"""Bulk over shear modulus in the plane above which stabilisations no longer grow: that of nu = 0.4 in plane strain."""

MIN_STIFFNESS = 1e-10
"""Smallest ``1 - 2 nu`` and ``1 + nu``: every decade below 1 costs solutions one of their sixteen digits."""

Hypothesis = Literal["plane_strain", "plane_stress", "axisymmetric"]


class Material(ABC):
    """A linear elastic material with a hypothesis on the direction out of the plane; its subclasses are final.

    Stresses are ordered xx, yy, xy, zz and strains xx, yy, 2 xy, zz. In ``"axisymmetric"`` problems x is the radius,
    y the axis of revolution and zz the hoop direction.
    """

    hypothesis: Hypothesis
    density: float | None

    @property
    @abstractmethod
    def spatial_matrix(self) -> Floats:
        """Stresses xx, yy, xy, zz per strain xx, yy, 2 xy, zz without any hypothesis, shape (4, 4)."""

    @property
    @abstractmethod
    def thermal_strain(self) -> Floats:
        """Free strains xx, yy, 2 xy, zz per rise of temperature, shape (4,); an InputError if unknown."""

    @property
    @abstractmethod
    def longitudinal_shear(self) -> Floats:
        """Shear stresses yz, xz per strain 2 yz, 2 xz, shape (2, 2); an InputError if unknown."""

    @property
    def full_matrix(self) -> Floats:
        """Stresses xx, yy, zz, xy, yz, xz per strain xx, yy, zz, 2 xy, 2 yz, 2 xz, without hypothesis: (6, 6)."""
        order = np.array([0, 1, 3, 2])
        matrix = np.zeros((6, 6))
        matrix[:4, :4] = self.spatial_matrix[np.ix_(order, order)]
        matrix[4:, 4:] = self.longitudinal_shear
        return matrix

    @property
    def full_thermal_strain(self) -> Floats:
        """Free strains xx, yy, zz, 2 xy, 2 yz, 2 xz per rise of temperature, shape (6,); an InputError if unknown."""
        return np.append(self.thermal_strain[[0, 1, 3, 2]], (0.0, 0.0))

    @property
    def matrix(self) -> Floats:
        """Stresses per strain under the hypothesis, shape (4, 4); in plane stress row and column zz are zero."""
        matrix = self.spatial_matrix
        if self.hypothesis == "plane_stress":
            matrix = matrix - np.outer(matrix[:, 3], matrix[3]) / matrix[3, 3]
            matrix[3] = matrix[:, 3] = 0.0
        return matrix

    @property
    def thermal_stress(self) -> Floats:
        """Stresses xx, yy, xy, zz per rise of temperature that would undo its strain, shape (4,)."""
        stress: Floats = self.matrix @ self.thermal_strain
        return stress

    @property
    def stiffness(self) -> Floats:
        """In-plane elasticity tensor ``C[i, j, k, l]``, shape (2, 2, 2, 2): stress = C : strain."""
        voigt = np.array([[0, 2], [2, 1]])
        return self.matrix[voigt[:, :, None, None], voigt]

    @property
    def out_of_plane(self) -> Floats:
        """Normal stress out of the plane for each in-plane strain, shape (2, 2)."""
        xx, yy, xy, _ = self.matrix[3]
        return np.array([[xx, xy], [xy, yy]])

    @property
    def stabilisation_factor(self) -> float:
        """Factor of stabilisations that keeps nearly incompressible bodies from locking, 1 up to nu = 0.4.

        The trace of the stiffness grows with the bulk modulus without limit, and a stabilisation in proportion would
        hold the part of the displacement that the projection misses, which must be free to keep the volume.
        """
        return float(bulk_limited(self.stiffness))

    @property
    def bulk_ratio(self) -> float:
        """Bulk over mean shear modulus in the plane, ``1 / (1 - 2 nu)`` of isotropic plane strain."""
        bulk, mean_shear = _bulk_and_shear(self.stiffness)
        return float(bulk / mean_shear)


def bulk_limited(tensor: Floats) -> Floats:
    """Factor of stabilisations, see `Material.stabilisation_factor`, of tangents (2, 2, 2, 2, ...)."""
    bulk, mean_shear = _bulk_and_shear(tensor)
    factor: Floats = (np.minimum(bulk, MAX_BULK * mean_shear) + 2.0 * mean_shear) / (bulk + 2.0 * mean_shear)
    return factor


def _bulk_and_shear(tensor: Floats) -> tuple[Floats, Floats]:
    """Bulk modulus in the plane, and the mean of both shear moduli, of tangents (2, 2, 2, 2, ...)."""
    xx, yy, xy = tensor[0, 0, 0, 0], tensor[1, 1, 1, 1], (tensor[0, 0, 1, 1] + tensor[1, 1, 0, 0]) / 2.0
    shear = (tensor[0, 1, 0, 1] + tensor[1, 0, 1, 0]) / 2.0
    return (xx + yy + 2.0 * xy) / 4.0, ((xx + yy - 2.0 * xy) / 4.0 + shear) / 2.0


def check_hypothesis(owner: str, hypothesis: str) -> None:
    """Refuse an unknown hypothesis."""
    if hypothesis not in get_args(Hypothesis):
        raise refused(
            owner, "hypothesis", hypothesis, " or ".join(map(repr, get_args(Hypothesis))), "choose one of these"
        )


def check_density(owner: str, density: float | None) -> None:
    """Refuse a density that is not positive; None is allowed."""
    if density is not None:
        advice = "give the mass per volume in the units of the model, 7.85e-9 t/mm3 for steel in mm, N and MPa"
        check_positive(owner, "density", density, "a positive number, or None", advice)


def no_expansion(owner: str) -> InputError:
    """The error of a thermal load on a material without an expansion coefficient."""
    return InputError(
        f"a change of temperature of {owner} without a thermal expansion",
        "a material with one",
        "give expansion, 1.2e-5 per kelvin for steel",
    )


# --- Isotropic linear elasticity.


INCOMPRESSIBLE_MARGIN = 0.01
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
        if least >= MIN_STIFFNESS:
            return
        if abs(least) < INCOMPRESSIBLE_MARGIN and poisson > 0.0:
            advice = "for nearly incompressible materials take 0.4999 and elements of order 2"
        if least > 0.0:
            allowed += f", with 1 - 2 poisson and 1 + poisson of {MIN_STIFFNESS:g} or more"
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


# --- Orthotropic linear elasticity.


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
        if self.hypothesis == "plane_stress" and least > -MIN_STIFFNESS:
            least = 1.0 - abs(self._scaled_compliance[0, 1])
        if not least >= MIN_STIFFNESS:
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

    def _matrix(self, indices: Ints) -> Floats:
        """Stiffness where there are normal stresses at some places of xx, yy, xy, zz only."""
        n = len(indices)
        root = np.sqrt(np.array(self.young, dtype=np.float64))[:n]
        normal = np.linalg.inv(self._scaled_compliance[:n, :n]) * np.outer(root, root)
        matrix = np.zeros((4, 4))
        matrix[np.ix_(indices, indices)] = (normal + normal.T) / 2.0
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
