"""What every linear elastic material gives, in the plane or about an axis."""

from abc import ABC, abstractmethod
from typing import Literal, get_args

import numpy as np

from flangeway.checks import check_positive, refused
from flangeway.errors import InputError
from flangeway.types import Floats

MOST_BULK = 5.0
"""Bulk over shear modulus in the plane above which stabilisations no longer grow: that of nu = 0.4 in plane strain."""

LEAST_STIFFNESS = 1e-10
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
        place = np.array([[0, 2], [2, 1]])
        return self.matrix[place[:, :, None, None], place]

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


def bulk_limited(tensor: Floats) -> Floats:
    """Factor of stabilisations, see `Material.stabilisation_factor`, of tangents (2, 2, 2, 2, ...)."""
    xx, yy, xy = tensor[0, 0, 0, 0], tensor[1, 1, 1, 1], (tensor[0, 0, 1, 1] + tensor[1, 1, 0, 0]) / 2.0
    shear = (tensor[0, 1, 0, 1] + tensor[1, 0, 1, 0]) / 2.0
    bulk = (xx + yy + 2.0 * xy) / 4.0
    mean_shear = ((xx + yy - 2.0 * xy) / 4.0 + shear) / 2.0
    factor: Floats = (np.minimum(bulk, MOST_BULK * mean_shear) + 2.0 * mean_shear) / (bulk + 2.0 * mean_shear)
    return factor


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
