"""Row B6: a gauge alone is enough where its wheelsets are known; what does not fit is said with both keys."""

import pytest

from flangeway.cases import WheelsetTangentCase
from flangeway.cases.rigid.rigid_case import GeometryCase
from flangeway.errors import InputError


@pytest.mark.parametrize(("gauge", "distance"), [(1435, 1360), (1445, 1360), (1600, 1515)])
def test_the_distance_of_the_wheels_follows_from_the_gauge(gauge, distance):
    """Without ``back_to_back_mm`` a usual gauge, widened or not, has its usual wheelset, and the words say which."""
    made = GeometryCase.from_values({"gauge_mm": gauge, "wheel": "S1002", "rail": "60E1"})
    assert made.wheelset().back_to_back_mm == distance
    assert any(f"Back to back {distance} mm" in each and f"{gauge} mm" in each for each in made.derived())
    assert not any("Back to back" in each for each in made.model_copy(update={"back_to_back_mm": 1400.0}).derived())


@pytest.mark.parametrize(
    ("gauge", "distance", "words"),
    [
        (1435, 1515, "flanges are .* too far apart"),
        (1600, 1300, "misses its rail by"),
    ],
)
def test_what_does_not_fit_is_said_with_both_keys(gauge, distance, words):
    """A wheelset that does not fit its track is refused by the names of both keys, and by how much."""
    for case in (WheelsetTangentCase, GeometryCase):
        made = case.from_values({"gauge_mm": gauge, "back_to_back_mm": distance})
        with pytest.raises(
            InputError, match=f"gauge_mm = {gauge} and back_to_back_mm = {distance} do not fit.*{words}"
        ):
            made.geometry() if isinstance(made, GeometryCase) else made.problem()


def test_an_unknown_gauge_asks_for_the_distance():
    """A gauge of which no wheelset is known is refused with the key to add."""
    with pytest.raises(InputError, match="gauge_mm = 1000 without back_to_back_mm"):
        WheelsetTangentCase.from_values({"gauge_mm": 1000}).problem()
