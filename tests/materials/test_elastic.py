"""Linear elastic materials."""

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from flangeway.errors import InputError
from flangeway.materials import Elastic


@given(
    young=st.floats(1e-3, 1e6),
    poisson=st.floats(-0.9, 0.49),
    hypothesis=st.sampled_from(["plane_strain", "plane_stress"]),
)
def test_stiffness_is_symmetric_and_positive(young: float, poisson: float, hypothesis: str) -> None:
    """The tensor has both minor symmetries and the major one, and every strain has a positive energy."""
    tensor = Elastic(young, poisson, hypothesis).stiffness
    for axes in ((1, 0, 2, 3), (0, 1, 3, 2), (2, 3, 0, 1)):
        assert np.array_equal(tensor, tensor.transpose(axes))
    voigt = tensor.reshape(4, 4)[np.ix_([0, 3, 1], [0, 3, 1])]
    assert np.linalg.eigvalsh(voigt).min() > 0.0


def test_uniaxial_stress_in_plane_stress() -> None:
    """In plane stress a strain of (1, -nu) has the stress (E, 0) and none out of the plane."""
    material = Elastic(200.0, 0.25, "plane_stress")
    strain = np.diag([1.0, -0.25])
    assert np.einsum("ijkl,kl->ij", material.stiffness, strain) == pytest.approx(np.diag([200.0, 0.0]))
    assert not material.out_of_plane.any()


def test_plane_strain_is_three_dimensional_hooke() -> None:
    """In plane strain the stresses are those of Hooke's law with no strain out of the plane."""
    material = Elastic(200.0, 0.25)
    strain = np.array([[1.0, 0.3], [0.3, -0.4]])
    lame, shear = 200.0 * 0.25 / (1.25 * 0.5), 200.0 / 2.5
    expected = lame * np.trace(strain) * np.eye(2) + 2.0 * shear * strain
    assert np.einsum("ijkl,kl->ij", material.stiffness, strain) == pytest.approx(expected)
    assert np.sum(material.out_of_plane * strain) == pytest.approx(lame * np.trace(strain))
    assert material.plane_modulus == pytest.approx(200.0 / (1.0 - 0.25**2))


@pytest.mark.parametrize(
    ("values", "name"),
    [
        ((0.0, 0.3), "young"),
        ((-1.0, 0.3), "young"),
        ((math.nan, 0.3), "young"),
        ((1.0, 0.5), "poisson"),
        ((1.0, -1.0), "poisson"),
        ((1.0, math.nan), "poisson"),
        ((1.0, 0.3, "plane"), "hypothesis"),
        ((1.0, 0.3, "plane_strain", 0.0), "density"),
        ((1.0, 0.3, "plane_strain", None, math.inf), "expansion"),
    ],
)
def test_impossible_materials_are_refused(values: tuple, name: str) -> None:
    """Each wrong number is named, with what is allowed."""
    with pytest.raises(InputError, match=name) as error:
        Elastic(*values)
    assert error.value.allowed
    assert error.value.advice
