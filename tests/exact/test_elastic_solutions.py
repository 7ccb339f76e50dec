"""Closed-form solutions of elasticity satisfy the equations they solve."""

import numpy as np
import pytest

from flangeway.errors import InputError
from flangeway.exact import PlateWithHole, ThickCylinder
from flangeway.materials import Elastic


def test_thick_cylinder_is_in_balance_and_meets_the_pressures() -> None:
    """Radial stresses are minus the pressures at both walls and ``d(r sigma_r)/dr`` is the hoop stress."""
    cylinder = ThickCylinder(1.0, 3.0, 7.0, 2.0)
    assert cylinder.radial_stress(np.array([1.0, 3.0])) == pytest.approx([-7.0, -2.0])
    r, step = np.linspace(1.1, 2.9, 7), 1e-6
    slope = ((r + step) * cylinder.radial_stress(r + step) - (r - step) * cylinder.radial_stress(r - step)) / (2 * step)
    assert slope == pytest.approx(cylinder.hoop_stress(r), rel=1e-6)


@pytest.mark.parametrize("plane_strain", [True, False])
def test_thick_cylinder_obeys_hooke(plane_strain: bool) -> None:
    """The hoop strain u / r is Hooke's for the stresses."""
    cylinder, young, poisson = ThickCylinder(1.0, 3.0, 7.0, 2.0), 100.0, 0.3
    r = np.linspace(1.0, 3.0, 5)
    radial, hoop = cylinder.radial_stress(r), cylinder.hoop_stress(r)
    axial = poisson * (radial + hoop) if plane_strain else 0.0
    strain = cylinder.radial_displacement(r, young, poisson, plane_strain=plane_strain) / r
    assert strain == pytest.approx((hoop - poisson * (radial + axial)) / young)


@pytest.mark.parametrize("hypothesis", ["plane_strain", "plane_stress"])
def test_kirsch_displacements_have_kirsch_stresses(hypothesis: str) -> None:
    """Hooke's law on the displacements' differences gives the stresses, which vanish on the hole along its normal."""
    plate, material, step = PlateWithHole(2.0, 5.0), Elastic(100.0, 0.3, hypothesis), 1e-6
    kolosov = 3.0 - 1.2 if hypothesis == "plane_strain" else 2.7 / 1.3
    points = np.array([[2.5, 0.4], [-1.0, 3.0], [0.1, -2.2]])
    slopes = [
        plate.displacements(points + move, material.shear_modulus, kolosov)
        - plate.displacements(points - move, material.shear_modulus, kolosov)
        for move in step * np.eye(2)
    ]
    gradient = np.stack(slopes, axis=2) / (2.0 * step)
    stress = np.einsum("ijkl,nkl->nij", material.stiffness, gradient)
    expected = plate.stresses(points)
    assert stress[:, [0, 1, 0], [0, 1, 1]] == pytest.approx(expected, abs=1e-6)
    angle = np.linspace(0.0, np.pi, 5)
    normal = np.stack((np.cos(angle), np.sin(angle)), axis=1)
    xx, yy, xy = plate.stresses(2.0 * normal).T
    assert xx * normal[:, 0] + xy * normal[:, 1] == pytest.approx(0.0, abs=1e-12)
    assert xy * normal[:, 0] + yy * normal[:, 1] == pytest.approx(0.0, abs=1e-12)


def test_impossible_radii_are_refused() -> None:
    """A wall without thickness and a hole without radius are input errors."""
    with pytest.raises(InputError, match="inner_radius"):
        ThickCylinder(2.0, 2.0, 1.0)
    with pytest.raises(InputError, match="radius"):
        PlateWithHole(0.0, 1.0)
