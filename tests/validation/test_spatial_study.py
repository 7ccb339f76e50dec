"""Three dimensions from plane meshes: cheaper numbers of `flangeway reproduce spatial`, and its closed forms."""

import numpy as np
import pytest

from studies.spatial.cosine_loads import exact_bar
from studies.spatial.patches import half_space_contact, published_gaps
from studies.spatial.point_loads import meshed_rail, transformed


def test_the_bar_has_its_limits() -> None:
    """Long waves stretch the bar freely, short ones meet a half-space."""
    bars = exact_bar()
    assert bars[0.01][0] == pytest.approx(-(1.0 - 0.3), rel=1e-6)
    assert bars[40.0][0] == pytest.approx(-2.0 * (1.0 - 0.3**2) / 40.0, rel=0.02)


def test_a_strip_is_transformed_as_its_integral() -> None:
    """``A = 1 / (1 + k^2)`` belongs to ``exp(-|z|) / 2``, over a strip to its integral."""
    waves = np.geomspace(1e-4, 400.0, 120)
    amplitudes = 1.0 / (1.0 + waves**2)
    assert transformed(waves, amplitudes, 2.0) == pytest.approx(1.0 - np.exp(-1.0), rel=1e-4)
    expected = np.exp(-3.0) * np.sinh(1.0)
    assert transformed(waves, amplitudes, 2.0, 3.0) == pytest.approx(expected, rel=1e-3)


def test_published_conformal_contact_by_half_spaces() -> None:
    """The published force and pressure follow from one curvature along z, and from no window that cuts the patch."""
    force, pressure, _ = half_space_contact("half-space")
    assert force == pytest.approx(91840.0, rel=1e-3)
    assert pressure == pytest.approx(1012.0, rel=2e-3)
    bounds, along = np.linspace(-5.0, 5.0, 11), np.array([-6.0, 0.0, 6.0])
    gaps, shares = published_gaps(bounds, along, "half-space")
    np.testing.assert_allclose(gaps, gaps[::-1], rtol=1e-12)
    assert gaps[0, 1] == pytest.approx(0.2 * (1.0 - np.cos(0.45)), rel=0.02)
    assert shares[0, 0] == pytest.approx(np.cos(0.45))


def test_the_shear_area_of_a_rail_is_about_that_of_its_web() -> None:
    """Jourawski's area of the section lies between 0.35 and 0.5 of the whole."""
    rail = meshed_rail()
    assert 0.35 < rail.shear_area / rail.constants.area < 0.5
    assert rail.foot == pytest.approx(149.2, abs=0.1)
