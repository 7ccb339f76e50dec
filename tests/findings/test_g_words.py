"""G2, G9, G10: yielding without a word, a default in another gauge, and adverse cant in silence."""

import numpy as np
import pytest

from flangeway import cli
from flangeway.cases.rigid.rigid_case import find_geometry_case
from flangeway.cases.wheelset.spatial_wheelset_case import SpatialWheelsetCase
from flangeway.errors import InputError
from flangeway.exact.shakedown import ABOVE, shakedown_limits, shakedown_state
from flangeway.railway.track.placements import WheelsetPosition
from flangeway.railway.track.wheelset_load import superelevation_angle
from flangeway.railway.wheelset.equilibrium import RelativeResiduals

CURVE = {"curve_radius_m": 500.0, "speed_km_h": 80.0}


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


@pytest.mark.parametrize("key", ["friction", "kinetic_friction", "flange_friction"])
def test_coefficients_of_friction_end_at_one(key):
    """A coefficient of 3 is refused by its name with the bound; 1 is allowed."""
    values = {"speed_km_h": 50.0, "friction": 0.3, key: 3.0}
    with pytest.raises(InputError) as raised:
        SpatialWheelsetCase.from_values(values)
    assert key in str(raised.value)
    assert "1" in raised.value.allowed
    SpatialWheelsetCase.from_values(values | {key: 1.0, "friction": 1.0}).check()


@pytest.mark.parametrize("name", ["wheelset", "s1002-60e1"])
def test_geometry_and_run_have_one_default_wheelset(name):
    """Profiles, gauge, wheels and load of `geometry` are those of `run wheelset`."""
    own, main = find_geometry_case(name, {}), SpatialWheelsetCase()
    for key in ("rail", "wheel", "gauge_mm", "wheel_radius_mm", "wheel_radius_at", "axle_load_kN", "rail_inclination"):
        assert getattr(own, key) == getattr(main, key), key
    assert own.load().vertical_N == main.load().vertical_N == 200e3


def test_geometry_without_a_case_is_in_standard_gauge(tmp_path, monkeypatch):
    """`geometry --wheel S1002 --rail 60E1` has the usual conicity of this pair, 0.17 to 0.18, not that of 1600 mm."""
    monkeypatch.setattr(
        "sys.argv",
        ["flangeway", "geometry", "--wheel", "S1002", "--rail", "60E1", "--set", "step_mm=0.1", "--no-pictures",
         "--out", str(tmp_path / "out"), "-q"],
    )  # fmt: skip
    with pytest.raises(SystemExit) as caught:
        cli.main()
    assert caught.value.code == 0
    table = np.genfromtxt(tmp_path / "out" / "conicity.csv", delimiter=",", names=True)
    amplitude, conicity = (table[name] for name in table.dtype.names[:2])
    assert np.interp(3.0, amplitude, conicity) == pytest.approx(0.177, abs=0.004)


@pytest.mark.parametrize("traction", [0.0, 0.15, 0.3])
def test_shakedown_states_change_at_the_limits(traction):
    """From elastic to what no limit allows, at first yield, shakedown and shakedown with hardening of a circle."""
    limits = shakedown_limits("point", traction)
    first, plain, most = (float(each) for each in (limits.first_yield, limits.shakedown, limits.hardening))
    assert shakedown_state(0.999 * first, traction) == "elastic"
    assert shakedown_state(1.001 * first, traction) == shakedown_state(0.999 * plain, traction) == "shakedown"
    assert shakedown_state(1.001 * max(plain, most), traction) == ABOVE
    if plain < 0.99 * most:
        assert shakedown_state(1.001 * plain, traction) == shakedown_state(0.999 * most, traction) == "hardening"


def test_a_position_has_plain_numbers_and_its_residual_includes_the_yaw():
    """G14: NumPy's numbers become floats; the yaw residual counts with and without a residual of the torque."""
    position = WheelsetPosition(np.float64(1.5), np.float64(-0.5), np.float64(1e-3))
    assert [type(each) for each in position.components] == [float] * 3
    assert repr(position) == repr(WheelsetPosition(1.5, -0.5, 1e-3))
    for torque in (0.0, 4e-9):
        found = RelativeResiduals(0.0, 0.0, 0.0, torque_residual=torque, yaw_residual=3e-9)
        assert found.equilibrium_residual == pytest.approx(np.hypot(torque, 3e-9), rel=1e-12)
