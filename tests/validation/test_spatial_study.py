"""Three dimensions from plane meshes: cheaper numbers of `flangeway reproduce spatial`, and its closed forms."""

import numpy as np
import pytest

from studies.spatial.cosine_loads import exact_bar
from studies.spatial.patches import published_gaps


def test_the_bar_has_its_limits() -> None:
    """Long waves stretch the bar freely, short ones meet a half-space."""
    bars = exact_bar()
    assert bars[0.01][0] == pytest.approx(-(1.0 - 0.3), rel=1e-6)
    assert bars[40.0][0] == pytest.approx(-2.0 * (1.0 - 0.3**2) / 40.0, rel=0.02)


def test_gaps_of_the_conformal_contact() -> None:
    """The gaps of the published contact, whose force and pressure are in the study, are those of its circles."""
    bounds, along = np.linspace(-5.0, 5.0, 11), np.array([-6.0, 0.0, 6.0])
    gaps, shares = published_gaps(bounds, along, "half-space")
    np.testing.assert_allclose(gaps, gaps[::-1], rtol=1e-12)
    assert gaps[0, 1] == pytest.approx(0.2 * (1.0 - np.cos(0.45)), rel=0.02)
    assert shares[0, 0] == pytest.approx(np.cos(0.45))
