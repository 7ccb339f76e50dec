"""Row B6: a gauge alone is enough where its wheelsets are known; what does not fit is said with both keys."""

import numpy as np
import pytest

from flangeway.campaign import Campaign
from flangeway.cases import WheelsetCurveCase, WheelsetTangentCase
from flangeway.cases.rigid.rigid_case import GeometryCase
from flangeway.errors import InputError


@pytest.mark.parametrize(("gauge", "distance"), [(1435, 1360), (1445, 1360), (1520, 1440), (1600, 1515), (1668, 1593)])
@pytest.mark.parametrize("case", [WheelsetTangentCase, WheelsetCurveCase, GeometryCase])
def test_b6_the_distance_of_the_wheels_follows_from_the_gauge(case, gauge, distance):
    """Without ``back_to_back_mm`` a usual gauge, widened or not, has its usual wheelset, and the words say which."""
    made = case.from_values({"gauge_mm": gauge, "wheel": "S1002", "rail": "60E1"})
    assert made.wheelset().back_to_back_mm == distance
    assert any(f"Back to back {distance} mm" in each and f"{gauge} mm" in each for each in made.derived())
    assert not any("Back to back" in each for each in made.model_copy(update={"back_to_back_mm": 1400.0}).derived())


@pytest.mark.parametrize("profiles", [{}, {"wheel": "S1002", "rail": "60E1"}])
def test_b6_standard_gauge_works_at_the_first_try(profiles):
    """``gauge_mm = 1435`` alone puts both wheels on their rails, with room for the flanges."""
    wheelset = GeometryCase.from_values({"gauge_mm": 1435, **profiles}).geometry()
    locus = wheelset.locus(np.array([-2.0, 0.0, 2.0]))
    assert np.isfinite(locus.right.rail_points_mm[:, 0]).all()


def test_b6_standard_gauge_is_computed_and_reported():
    """The elastic case on standard gauge converges, and its summary says which distance of the wheels was taken."""
    run = WheelsetTangentCase.from_values({"gauge_mm": 1435, "size_scale": 6.0}).run()
    assert run.status.converged
    assert any("Back to back 1360 mm" in each for each in run.case.assumptions(run.result))


@pytest.mark.parametrize(
    ("gauge", "distance", "words"),
    [
        (1435, 1515, "flanges are .* too far apart"),
        (1600, 1300, "misses its rail by"),
        (3000, 1515, "misses its rail by"),
    ],
)
def test_b6_what_does_not_fit_is_said_with_both_keys(gauge, distance, words):
    """A wheelset that does not fit its track is refused by the names of both keys, and by how much."""
    for case in (WheelsetTangentCase, GeometryCase):
        made = case.from_values({"gauge_mm": gauge, "back_to_back_mm": distance})
        with pytest.raises(
            InputError, match=f"gauge_mm = {gauge} and back_to_back_mm = {distance} do not fit.*{words}"
        ):
            made.geometry() if isinstance(made, GeometryCase) else made.problem()


def test_b6_an_unknown_gauge_asks_for_the_distance():
    """A gauge of which no wheelset is known is refused with the key to add."""
    with pytest.raises(InputError, match="gauge_mm = 1000 without back_to_back_mm"):
        WheelsetTangentCase.from_values({"gauge_mm": 1000}).problem()


def test_b6_campaigns_take_the_gauge_alone(tmp_path):
    """A campaign over gauges gives each row the wheelset of its gauge."""
    file = tmp_path / "campaign.toml"
    file.write_text('case = "wheelset-tangent"\n[vary]\ngauge_mm = [1435, 1600]\n', encoding="utf-8")
    rows = Campaign.from_file(file).rows
    assert [row.case.wheelset().back_to_back_mm for row in rows] == [1360.0, 1515.0]
