"""Inputs of cases: defaults, ranges, types, what follows from them, and the messages about wrong ones."""

import math

import numpy as np
import pytest

from flangeway.campaign import Campaign
from flangeway.cases import WheelsetCurveCase, WheelsetTangentCase
from flangeway.cases.case import OF_REPORT
from flangeway.cases.rigid_run import find_geometry_case
from flangeway.cases.wheelset.spatial_wheelset_case import SpatialWheelsetCase
from flangeway.errors import InputError
from flangeway.exact.shakedown import ABOVE_SHAKEDOWN, shakedown_limits, shakedown_state
from flangeway.railway.profiles.bundled import rail, wheel
from flangeway.railway.track.wheelset_problem import superelevation_angle


def test_defaults_are_the_published_measures():
    """Without inputs the case is the dissertation's: broad gauge, 1:40, 300 kN, 10 mm, plane strain steel."""
    problem = WheelsetTangentCase().problem()
    assert (problem.track.gauge_mm, problem.track.rail_inclination) == (1600.0, 1 / 40)
    assert (problem.wheelset.back_to_back_mm, problem.wheelset.radius_mm) == (1515.0, 500.0)
    assert problem.wheelset.centre_of_gravity_height_mm == 1457.7
    assert (problem.load.vertical_N, problem.thickness_mm) == (300e3, 10.0)
    assert (problem.material.young, problem.material.poisson) == (210e3, 0.3)
    assert problem.material.hypothesis == "plane_strain"


def test_every_input_reaches_the_problem():
    """Each input, changed alone, changes the problem that is solved: none is without effect."""
    changes = {
        "crown_radius_in": 14.0, "gauge_mm": 1602.0, "rail_inclination": 0.05, "back_to_back_mm": 1516.0,
        "wheel_radius_mm": 450.0, "centre_of_gravity_height_mm": 1500.0, "axle_load_kN": 200.0, "thickness_mm": 20.0,
        "young_MPa": 2e5, "poisson": 0.25, "method": "vem", "size_scale": 2.0, "contact_size_mm": 0.3,
        "body_size_mm": 2.0, "penalty_factor": 10.0, "primary": "wheel", "rail": "60E1", "wheel": "S1002",
        "left_rail": "60E1", "left_wheel": "S1002", "gauge_depth_mm": 13.0, "gauge_at": "within-depth",
        "wheel_radius_at": "tape-line", "left_wheel_radius_mm": 499.0, "car_mass_t": 100.0,
        "lateral_force_kN": 10.0, "superelevation_mm": 20.0, "lateral_mm": 5.0, "vertical_mm": -1.0, "roll_rad": 1e-4,
        "wheel_young_MPa": 2e5, "wheel_poisson": 0.25, "rail_young_MPa": 2e5, "rail_poisson": 0.25, "order": 2,
        "wheel_method": "vem", "rail_method": "vem", "wheel_order": 2, "rail_order": 2, "wheel_contact_size_mm": 0.3,
        "rail_contact_size_mm": 0.3, "growth": 0.2, "pairing": "node-to-segment", "enforcement": "multiplier",
        "penetration_mm": 1e-3, "yield_MPa": 900.0,
    }  # fmt: skip
    curve = {"speed_km_h": 70.0, "curve_radius_m": 400.0, "superelevation_mm": "from-speed"}
    together = {
        "n_axles": ({"car_mass_t": 100.0}, 6),
        "speed_km_h": ({"curve_radius_m": 400.0, "speed_km_h": 60.0}, 70.0),
        "curve_radius_m": (curve, 500.0),
        "cant_deficiency_mm": (curve, 20.0),
        "superelevation_base_mm": (curve | {"superelevation_mm": 30.0}, 1500.0),
        "nodal_penalty_N_per_mm": ({"pairing": "node-to-segment"}, 1e7),
    }
    files_only = {"rail_body", "wheel_body"} | {
        f"{side}{part}_{option}"
        for side in ("", "left_")
        for part in ("rail", "wheel")
        for option in ("unit", "mirror")
    }
    files_only |= {"wheel_tape_mm", "left_wheel_tape_mm", "rail_position_mm", "left_rail_position_mm"}
    files_only |= {"wheel_angle_deg", "left_wheel_angle_deg"}
    files_only |= set(OF_REPORT)
    assert set(changes) | set(together) | files_only == set(WheelsetTangentCase.model_fields)
    default = repr(WheelsetTangentCase().problem())
    for key, value in changes.items():
        assert repr(WheelsetTangentCase.from_values({key: value}).problem()) != default, key
    for key, (others, value) in together.items():
        before = repr(WheelsetTangentCase.from_values(others).problem())
        assert repr(WheelsetTangentCase.from_values({**others, key: value}).problem()) != before, key


def test_a_curve_to_the_right_is_the_mirror_image():
    """A negative radius turns force and superelevation round: from the speed, less a deficiency, or by default."""
    for values in (
        {},
        {"superelevation_mm": "from-speed"},
        {"superelevation_mm": "from-speed", "cant_deficiency_mm": 9},
    ):
        left, right = (
            WheelsetCurveCase.from_values({**values, "speed_km_h": 60, "curve_radius_m": radius}).load()
            for radius in (500, -500)
        )
        assert left.tilt_rad > 0.0
        assert left.lateral_N > 0.0
        assert (right.lateral_N, right.tilt_rad) == (-left.lateral_N, -left.tilt_rad)


@pytest.mark.parametrize(("inputs", "base"), [({}, 1600.0), ({"superelevation_base_mm": 1665.0}, 1665.0)])
def test_superelevation_is_over_the_gauge_or_the_base_that_is_given(inputs, base):
    """The angle has the sine of the height over the gauge, or over the given base."""
    case = WheelsetCurveCase.from_values({"superelevation_mm": 30.0, **inputs})
    assert case.load().tilt_rad == pytest.approx(math.asin(30.0 / base))


def test_what_is_taken_off_the_balanced_superelevation_is_the_deficiency():
    """60 km/h in 500 m over 1500 mm give 84.85 mm in equilibrium, g = 9.80665 m/s²; 50 mm less are 34.85 mm."""
    values = {"speed_km_h": 60, "curve_radius_m": 500, "superelevation_mm": "from-speed", "cant_deficiency_mm": 50}
    load = WheelsetTangentCase.from_values({**values, "superelevation_base_mm": 1500}).load()
    assert 1500.0 * math.sin(load.tilt_rad) == pytest.approx(34.85, abs=0.05)


def test_a_measured_profile_finds_its_body(tmp_path):
    """A file gets the body of the bundled profile on the other side, else of the nearest, unless it is said."""
    head = rail("60E1").outline.part(rail("60E1").running_names).sampled(spacing=0.5) - [0.0, 172.0]
    np.savetxt(tmp_path / "head.txt", head)
    np.savetxt(tmp_path / "tread.txt", wheel("S1002").running_surface.sampled(spacing=0.5))
    head_file, tread_file = str(tmp_path / "head.txt"), str(tmp_path / "tread.txt")
    for values, on_rail, on_wheel in (
        ({"rail": head_file, "wheel": tread_file}, "body of 60E1", "body of S1002"),
        (
            {"rail": "136RE", "left_rail": head_file, "wheel": "heavy-haul", "left_wheel": tread_file},
            "136RE",
            "heavy-haul",
        ),
        ({"rail": head_file, "wheel": tread_file, "rail_body": "136RE", "wheel_body": "plain"}, "136RE", "plain"),
    ):
        case = WheelsetTangentCase.from_values(values)
        assert on_rail in case.track().rail_of("left").title
        assert on_wheel in case.wheelset().wheel_of("left").title


def test_settings_are_read_by_the_type_of_their_input(call):
    """``--set`` is text: numbers, truth values and lists are read where the input is one, and only there."""
    for setting in ("size_mm=true", "order=true", "order=1.5", "order='1'", 'poisson="0.3"', "n_steps=1e0"):
        status, _, err = call("check", "hertz", "--set", setting)
        assert status == 2, setting
        assert setting.partition("=")[0] in err
    for setting in ("size_mm=0.5", "order=2", "poisson=1e-1", "lower=block"):
        assert call("check", "hertz", "--set", setting)[0] == 0, setting
    assert call("check", "torsion", "--set", "half=1")[0] == 2
    assert call("check", "torsion", "--set", "half=false")[0] == 0


def test_campaigns_are_strict(tmp_path):
    """Lists under [vary] and values under [inputs] are typed; cells of a table are text, read by their input's type."""

    def campaign(text):
        (tmp_path / "c.toml").write_text('case = "cook"\n' + text, encoding="utf-8")
        return Campaign.from_file(tmp_path / "c.toml")

    for text in (
        '[vary]\nlevel = ["1", "2"]\n',
        "[vary]\npoisson = [true]\n",
        '[inputs]\npoisson = "0.3"\n[vary]\nlevel = [1]\n',
        "[inputs]\norder = true\n[vary]\nlevel = [1]\n",
        'table = "t.csv"\n[inputs]\npoisson = "0.3"\n',
    ):
        (tmp_path / "t.csv").write_text("level,method\n1,fem\n2,vem\n", encoding="utf-8")
        with pytest.raises(InputError):
            campaign(text)
    rows = campaign('table = "t.csv"\n').rows
    assert [(row.case.level, row.case.method) for row in rows] == [(1, "fem"), (2, "vem")]
    (tmp_path / "t.csv").write_text("level\ntrue\n", encoding="utf-8")
    with pytest.raises(InputError, match="level = 'true'"):
        campaign('table = "t.csv"\n')


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
    assert shakedown_state(1.001 * max(plain, most), traction) == ABOVE_SHAKEDOWN
    if plain < 0.99 * most:
        assert shakedown_state(1.001 * plain, traction) == shakedown_state(0.999 * most, traction) == "hardening"
