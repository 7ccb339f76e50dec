"""Linear elastic materials, isotropic and orthotropic."""

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from flangeway.errors import InputError
from flangeway.materials import Elastic, Orthotropic


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


WOOD = {"young": (12.0, 0.8, 0.5), "poisson": (0.4, 0.35, 0.45), "shear": 0.7}


def compliance() -> np.ndarray:
    """Strains 11, 22, 2 12, 33 per stress, from the definition of the constants."""
    (e1, e2, e3), (nu12, nu23, nu13) = WOOD["young"], WOOD["poisson"]
    return np.array(
        [
            [1 / e1, -nu12 / e1, 0.0, -nu13 / e1],
            [-nu12 / e1, 1 / e2, 0.0, -nu23 / e2],
            [0.0, 0.0, 1 / WOOD["shear"], 0.0],
            [-nu13 / e1, -nu23 / e2, 0.0, 1 / e3],
        ]
    )


def test_constants_are_those_of_the_definition() -> None:
    """Without a hypothesis on the third direction, stress times compliance is the identity."""
    assert Orthotropic(**WOOD, hypothesis="axisymmetric").matrix @ compliance() == pytest.approx(np.eye(4), abs=1e-12)


@pytest.mark.parametrize("hypothesis", ["plane_strain", "plane_stress", "axisymmetric"])
def test_equal_constants_are_isotropic_at_any_angle(hypothesis: str) -> None:
    """With one modulus and ratio, and the shear modulus they imply, the matrix is the isotropic one."""
    isotropic = Elastic(200.0, 0.3, hypothesis)
    turned = Orthotropic((200.0,) * 3, (0.3,) * 3, isotropic.shear_modulus, 0.7, hypothesis)
    assert turned.matrix == pytest.approx(isotropic.matrix, abs=1e-10)


def test_plane_stress_has_no_stress_out_of_the_plane() -> None:
    """A stress along a turned axis 1 alone gives the strains 1 / E1 and -nu12 / E1 along the axes."""
    angle = 0.6
    material = Orthotropic(**WOOD, angle=angle, hypothesis="plane_stress")
    c, s = math.cos(angle), math.sin(angle)
    rotation = np.array([[c, -s], [s, c]])
    local = np.diag([1.0 / 12.0, -0.4 / 12.0])
    stress = np.einsum("ijkl,kl->ij", material.stiffness, rotation @ local @ rotation.T)
    assert rotation.T @ stress @ rotation == pytest.approx(np.diag([1.0, 0.0]), abs=1e-12)
    assert not material.out_of_plane.any()


def test_free_thermal_strain_turns_with_the_axes() -> None:
    """The free strain is that of the axes, seen in x and y, and the thermal stress undoes it."""
    material = Orthotropic(**WOOD, angle=0.3, hypothesis="axisymmetric", expansion=(1e-5, 3e-5, 2e-5))
    c, s = math.cos(0.3), math.sin(0.3)
    rotation = np.array([[c, -s], [s, c]])
    tensor = rotation @ np.diag([1e-5, 3e-5]) @ rotation.T
    expected = [tensor[0, 0], tensor[1, 1], 2.0 * tensor[0, 1], 2e-5]
    assert material.thermal_strain == pytest.approx(expected)
    assert np.linalg.solve(material.matrix, material.thermal_stress) == pytest.approx(expected)


@pytest.mark.parametrize(
    ("changes", "words"),
    [
        ({"poisson": (4.0, 0.35, 0.45)}, "positive definite"),
        ({"poisson": (1.5, 1.0, 2.0)}, "positive definite"),
        ({"young": (1.0, -1.0, 1.0)}, "positive numbers"),
        ({"young": (1.0, 1.0)}, "three numbers"),
        ({"shear": 0.0}, "positive numbers"),
        ({"angle": math.nan}, "angle"),
        ({"poisson": (math.inf, 0.0, 0.0)}, "finite"),
        ({"hypothesis": "flat"}, "hypothesis"),
        ({"density": -1.0}, "density"),
        ({"expansion": 1e-5}, "three numbers"),
    ],
)
def test_impossible_constants_are_refused(changes: dict, words: str) -> None:
    """Each wrong constant is an input error that says what is allowed."""
    with pytest.raises(InputError, match=words):
        Orthotropic(**{**WOOD, **changes})


@pytest.mark.parametrize("poisson", [-0.5, 0.0, 0.3, 0.4])
def test_stabilisation_is_as_published_up_to_0_4(poisson: float) -> None:
    """The factor is 1 up to nu = 0.4, and falls like the shear over the bulk modulus towards 0.5."""
    assert Elastic(1.0, poisson).stabilisation_factor == 1.0
    assert Elastic(1.0, 0.49999).stabilisation_factor < 1e-3
    assert Elastic(1.0, 0.49999, "plane_stress").stabilisation_factor == 1.0
