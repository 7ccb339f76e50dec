"""Yielding without a word, a default in another gauge, and adverse cant in silence."""

import pytest

from flangeway.cases.rigid.rigid_case import find_geometry_case
from flangeway.cases.wheelset.spatial_wheelset_case import SpatialWheelsetCase
from flangeway.exact.shakedown import ABOVE, shakedown_limits, shakedown_state
from flangeway.railway.track.wheelset_load import superelevation_angle


@pytest.mark.parametrize("sign", [1.0, -1.0])
def test_superelevation_follows_the_curve(sign):
    """60 mm raise the outer rail of both curves, -60 mm the inner one, with a warning that names the input."""
    for height, warned in ((60.0, False), (-60.0, True)):
        case = SpatialWheelsetCase.from_values(
            {"speed_km_h": 80.0, "curve_radius_m": sign * 500.0, "superelevation_mm": height}
        )
        assert case.load().tilt_rad == pytest.approx(superelevation_angle(sign * height, 1500.0))
        assert any("superelevation_mm" in each and "adverse" in each for each in case.warnings()) == warned
    straight = SpatialWheelsetCase.from_values({"superelevation_mm": -60.0})
    assert straight.load().tilt_rad == pytest.approx(superelevation_angle(-60.0, 1500.0))
    assert straight.warnings() == []


@pytest.mark.parametrize("name", ["wheelset", "s1002-60e1"])
def test_geometry_and_run_have_one_default_wheelset(name):
    """Profiles, gauge, wheels and load of `geometry` are those of `run wheelset`."""
    own, main = find_geometry_case(name, {}), SpatialWheelsetCase()
    for key in ("rail", "wheel", "gauge_mm", "wheel_radius_mm", "wheel_radius_at", "axle_load_kN", "rail_inclination"):
        assert getattr(own, key) == getattr(main, key), key
    assert own.load().vertical_N == main.load().vertical_N == 200e3


@pytest.mark.parametrize("traction", [0.0, 0.3])
def test_shakedown_states_change_at_the_limits(traction):
    """From elastic to what no limit allows, at first yield, shakedown and shakedown with hardening of a circle."""
    limits = shakedown_limits("point", traction)
    first, plain, most = (float(each) for each in (limits.first_yield, limits.shakedown, limits.hardening))
    assert shakedown_state(0.999 * first, traction) == "elastic"
    assert shakedown_state(1.001 * first, traction) == shakedown_state(0.999 * plain, traction) == "shakedown"
    assert shakedown_state(1.001 * max(plain, most), traction) == ABOVE
    if plain < 0.99 * most:
        assert shakedown_state(1.001 * plain, traction) == shakedown_state(0.999 * most, traction) == "hardening"
