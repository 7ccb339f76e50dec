"""Row B6: a gauge alone is enough where its wheelsets are known; what does not fit is said with both keys."""

import pytest

from flangeway.cases.rigid.rigid_case import GeometryCase


@pytest.mark.parametrize(("gauge", "distance"), [(1435, 1360), (1445, 1360), (1600, 1515)])
def test_the_distance_of_the_wheels_follows_from_the_gauge(gauge, distance):
    """Without ``back_to_back_mm`` a usual gauge, widened or not, has its usual wheelset, and the words say which."""
    made = GeometryCase.from_values({"gauge_mm": gauge, "wheel": "S1002", "rail": "60E1"})
    assert made.wheelset().back_to_back_mm == distance
    assert any(f"Back to back {distance} mm" in each and f"{gauge} mm" in each for each in made.derived())
    assert not any("Back to back" in each for each in made.model_copy(update={"back_to_back_mm": 1400.0}).derived())
