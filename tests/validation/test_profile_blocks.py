"""Wheel and rail with true profiles, cut to blocks, beside CalculiX."""

import numpy as np
import pytest

from studies.spatial.profile_blocks import HALF, RADIUS, cut_surfaces, heights


def test_the_cut_profiles_touch_first_at_the_origin() -> None:
    """The gap is least there and nothing, and on the rail two arcs of the crown meet within the patch."""
    low, high, axle = cut_surfaces()
    x = np.linspace(-HALF + 0.1, HALF - 0.1, 2001)
    gap = heights(high, x) - heights(low, x)
    assert gap.min() == pytest.approx(0.0, abs=1e-6)
    assert abs(x[gap.argmin()]) < 0.02
    curvatures = [np.polyfit(x[near], gap[near], 2)[0] * 2.0 for near in (abs(x + 1.5) < 0.8, abs(x - 4.0) < 0.8)]
    assert curvatures[0] > 3.0 * curvatures[1]
    assert axle == pytest.approx(RADIUS, abs=1.0)
