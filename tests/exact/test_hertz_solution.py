"""Hertz's line contact, and the stresses below it."""

import numpy as np
import pytest
from scipy.special import roots_legendre

from flangeway.errors import InputError
from flangeway.exact import LineContact, PointContact
from flangeway.exact.hertz import DEPTH_OF_MAX_SHEAR
from flangeway_studies.discs import axis_stresses_in_disc


@pytest.fixture
def contact() -> LineContact:
    """The published problem: two discs of 4 cm, E = 20000 kN/cm^2, nu = 1/3."""
    return LineContact(251.84, 0.5, 11250.0)


def test_published_reference_follows_from_its_force(contact):
    """P = 251.84 kN/cm gives the published p0 = 671.51 kN/cm^2 and a = 0.239 cm (Moherdaui 2021, Table 11)."""
    assert contact.max_pressure == pytest.approx(671.51, rel=2e-5)
    assert contact.half_width == pytest.approx(0.239, abs=5e-4)


def test_a_contact_is_found_from_its_maximum_pressure(contact):
    """The maximum pressure gives back the force, P = pi R p0^2 / E*, where the published table lacks the square."""
    again = LineContact.of_max_pressure(contact.max_pressure, 0.5, 11250.0)
    assert again.force_per_length == pytest.approx(contact.force_per_length, rel=1e-14)
    with pytest.raises(InputError):
        LineContact.of_max_pressure(-1.0, 0.5, 11250.0)


def test_pressure_carries_the_force(contact):
    """The pressure integrates to the force and vanishes outside of the contact."""
    angles, weights = np.polynomial.legendre.leggauss(40)
    t = np.pi / 2.0 * angles
    a = contact.half_width
    total = np.sum(np.pi / 2.0 * weights * contact.pressure(a * np.sin(t)) * a * np.cos(t))
    assert total == pytest.approx(contact.force_per_length, rel=1e-12)
    assert (contact.pressure([-1.01 * a, 2.0 * a]) == 0.0).all()


def test_stresses_are_in_equilibrium(contact):
    """Both components of the divergence of the stresses vanish (central differences, to their own error)."""
    h = 1e-5
    x, z = np.array([0.1, 0.3, -0.2, 0.5, 0.0]), np.array([0.2, 0.05, 0.1, 0.9, 0.4])
    by_x = (contact.stresses(x + h, z) - contact.stresses(x - h, z)) / (2.0 * h)
    by_z = (contact.stresses(x, z + h) - contact.stresses(x, z - h)) / (2.0 * h)
    scale = contact.max_pressure / contact.half_width
    np.testing.assert_allclose(by_x[:, 0] + by_z[:, 2], 0.0, atol=1e-7 * scale)
    np.testing.assert_allclose(by_x[:, 2] + by_z[:, 1], 0.0, atol=1e-7 * scale)


def test_stresses_meet_the_loads_on_the_surface(contact):
    """On the surface the normal stress is minus the pressure, along it as across it, and there is no shear."""
    x = np.linspace(-2.0, 2.0, 81) * contact.half_width
    stresses = contact.stresses(x, 0.0)
    expected = -contact.pressure(x)[:, None] * [1.0, 1.0, 0.0]
    np.testing.assert_allclose(stresses, expected, atol=1e-12 * contact.max_pressure)


def test_stresses_on_the_axis_are_the_published_expressions(contact):
    """On the line of symmetry the solution is that of Moherdaui (2021) 2.73 to 2.75, the last without its sign."""
    p0, a = contact.max_pressure, contact.half_width
    z = np.linspace(0.0, 1.0, 21)
    root = np.sqrt(a**2 + z**2)
    stresses = contact.stresses(0.0, z)
    np.testing.assert_allclose(stresses[:, 1], -p0 * a / root, rtol=1e-12)
    np.testing.assert_allclose(stresses[:, 0], -p0 / a * ((a**2 + 2.0 * z**2) / root - 2.0 * z), atol=1e-10 * p0)
    np.testing.assert_allclose((stresses[:, 0] - stresses[:, 1]) / 2.0, p0 / a * (z - z**2 / root), atol=1e-10 * p0)


def test_shear_is_greatest_at_its_depth(contact):
    """The shear on the axis is nowhere greater than 0.3003 p0, which it has at 0.786 a."""
    z = np.linspace(0.0, 3.0, 3001) * contact.half_width
    stresses = contact.stresses(0.0, z)
    shear = (stresses[:, 0] - stresses[:, 1]) / 2.0
    assert shear.max() == pytest.approx(contact.max_shear, rel=1e-7)
    assert contact.max_shear == pytest.approx(0.3003 * contact.max_pressure, rel=1e-4)
    assert z[shear.argmax()] == pytest.approx(DEPTH_OF_MAX_SHEAR * contact.half_width, rel=1e-3)


def test_the_middle_of_a_disc_is_that_of_the_split_cylinder(contact):
    """In a disc the tension across the diameter is P / (pi R) in the middle, and the stress along it -3 P / (pi R)."""
    radius = 4.0
    middle = axis_stresses_in_disc(contact, np.array([radius]), radius)[0]
    even = contact.force_per_length / (np.pi * radius)
    small = (contact.half_width / radius) ** 2
    np.testing.assert_allclose(middle, [even, -3.0 * even, 0.0], atol=2.0 * small * even)


def test_what_is_not_below_the_surface_is_refused(contact):
    """Negative depths, and depths beyond the disc, are refused."""
    with pytest.raises(InputError, match="depths >= 0"):
        contact.stresses(0.0, -0.1)
    with pytest.raises(InputError, match="disc of radius"):
        axis_stresses_in_disc(contact, [8.5], 4.0)


NODES = roots_legendre(2000)
"""Nodes and weights of Gauss's rule."""


@pytest.mark.parametrize("ratio", [1.0 + 1e-9, 6.0, 1e4])
def test_an_ellipse_of_pressure_closes_the_gap(ratio) -> None:
    """The displacement of a half-space by the pressure of the ellipse has the curvatures of the gap.

    They are integrals over the depth w of the confocal ellipses (Johnson, 1985, 3.5), done by quadrature.
    """
    contact = PointContact(3e4, 80.0, 80.0 * ratio, 1.1e5)
    a, b = contact.semi_axes
    assert (a <= b * (1.0 + 1e-9)) == (ratio >= 1.0)
    assert PointContact(3e4, 80.0 * ratio, 80.0, 1.1e5).semi_axes == pytest.approx((b, a), rel=1e-12)

    def depth(power_a: int, power_b: int) -> float:
        """Integral of ``dw / ((a^2 + w)^(p/2) (b^2 + w)^(q/2) w^(1/2))`` with ``w = a b tan(t)^2``."""
        nodes, weights = NODES
        t = np.pi / 4.0 * (nodes + 1.0)
        w = a * b * np.tan(t) ** 2
        jacobian = 2.0 * np.sqrt(a * b) / np.cos(t) ** 2
        values = jacobian / ((a**2 + w) ** (power_a / 2.0) * (b**2 + w) ** (power_b / 2.0))
        return float(np.pi / 4.0 * weights @ values)

    scale = contact.max_pressure * a * b / (2.0 * contact.modulus)
    assert scale * depth(1, 1) == pytest.approx(contact.approach, rel=1e-6)
    assert scale * depth(3, 1) == pytest.approx(0.5 / 80.0, rel=1e-6)
    assert scale * depth(1, 3) == pytest.approx(0.5 / (80.0 * ratio), rel=1e-6)
