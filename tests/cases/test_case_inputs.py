"""Inputs of cases: defaults, ranges, types, what follows from them, and the messages about wrong ones."""

import math

import numpy as np
import pytest

from flangeway.campaign import Campaign
from flangeway.cases import Wheelset, load_case
from flangeway.cases.rigid_run import find_geometry_case
from flangeway.cases.wheelset.wheelset_notes import unusual
from flangeway.errors import InputError
from flangeway.exact.shakedown import ABOVE_SHAKEDOWN, shakedown_limits, shakedown_state
from flangeway.railway.profiles.bundled import rail, wheel
from flangeway.railway.track.wheelset_loads import Curve, Load, superelevation_angle
from flangeway.railway.track.wheelset_problem import Plane
from flangeway.records import with_settings


def test_the_plane_case_files_have_the_published_measures():
    """The bundled files are the dissertation's: broad gauge, 1:40, 300 kN, 10 mm, plane strain steel."""
    for name in ("wheelset-tangent", "wheelset-curve"):
        case = load_case(name)
        assert (case.track.gauge_mm, case.track.inclination) == (1600.0, 1 / 40)
        assert (case.wheels.back_to_back_mm, case.wheels.radius_mm) == (1515.0, 500.0)
        assert case.forces.height_mm == 1457.7
        assert (case.forces.vertical_N, case.plane.thickness_mm) == (300e3, 10.0)
        assert (case.material.young_MPa, case.material.poisson) == (210e3, 0.3)
        assert case.material_of("rail").hypothesis == "plane_strain"


def test_a_curve_to_the_right_is_the_mirror_image():
    """A negative radius turns force and superelevation round: 0 by default, from the speed, or less a deficiency."""
    for height in (30.0, "from-speed", {"cant_deficiency_mm": 9.0}):
        left, right = (
            Wheelset(load=Load(curve=Curve(radius_m=radius, speed_km_h=60.0, superelevation_mm=height))).forces
            for radius in (500.0, -500.0)
        )
        assert left.tilt_rad > 0.0
        assert left.lateral_N > 0.0
        assert (right.lateral_N, right.tilt_rad) == (-left.lateral_N, -left.tilt_rad)


@pytest.mark.parametrize(("track", "base"), [({}, 1500.0), ({"superelevation_base_mm": 1665.0}, 1665.0)])
def test_superelevation_is_over_the_running_circles_or_the_base_of_the_track(track, base):
    """The angle has the sine of the height over the gauge and 65 mm, or over the base."""
    case = Wheelset(track=track, load=Load(superelevation_mm=30.0))
    assert case.forces.tilt_rad == pytest.approx(math.asin(30.0 / base))


def test_the_deficiency_is_what_the_equilibrium_superelevation_has_more():
    """60 km/h in 500 m over 1500 mm give 84.85 mm in equilibrium, g = 9.80665 m/s²; 50 mm less are 34.85 mm."""
    height = {"kind": "from-speed", "cant_deficiency_mm": 50.0}
    load = Wheelset(load={"curve": {"radius_m": 500.0, "speed_km_h": 60.0, "superelevation_mm": height}}).forces
    assert 1500.0 * math.sin(load.tilt_rad) == pytest.approx(34.85, abs=0.05)


def test_a_measured_profile_finds_its_body(tmp_path):
    """A file gets the body of the bundled profile on the other side, else of the nearest, unless it is said."""
    head = rail("60E1").outline.part(rail("60E1").running_names).sampled(spacing=0.5) - [0.0, 172.0]
    np.savetxt(tmp_path / "head.txt", head)
    np.savetxt(tmp_path / "tread.txt", wheel("S1002").running_surface.sampled(spacing=0.5))
    head_file, tread_file = str(tmp_path / "head.txt"), str(tmp_path / "tread.txt")
    for rails, wheels, on_rail, on_wheel in (
        ({"rail": head_file}, {"wheel": tread_file}, "body of 60E1", "body of S1002"),
        (
            {"rail": "136RE", "left": {"rail": head_file}}, {"wheel": "heavy-haul", "left": {"wheel": tread_file}},
            "136RE", "heavy-haul",
        ),
        (
            {"rail": {"file": head_file, "body": "136RE"}}, {"wheel": {"file": tread_file, "body": "plain"}},
            "136RE", "plain",
        ),
    ):  # fmt: skip
        case = Wheelset(track=rails, wheelset=wheels)
        assert on_rail in case.track.rail_of("left").title
        assert on_wheel in case.wheels.wheel_of("left").title


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
        (tmp_path / "c.toml").write_text('case = "torsion"\n' + text, encoding="utf-8")
        return Campaign.from_file(tmp_path / "c.toml")

    for text in (
        '[vary]\norder = ["1", "2"]\n',
        "[vary]\npoisson = [true]\n",
        '[inputs]\npoisson = "0.3"\n[vary]\norder = [1]\n',
        "[inputs]\npoisson = true\n[vary]\norder = [1]\n",
        'table = "t.csv"\n[inputs]\npoisson = "0.3"\n',
    ):
        (tmp_path / "t.csv").write_text("order,method\n1,fem\n2,vem\n", encoding="utf-8")
        with pytest.raises(InputError):
            campaign(text)
    rows = campaign('table = "t.csv"\n').rows
    assert [(row.case.order, row.case.method) for row in rows] == [(1, "fem"), (2, "vem")]
    (tmp_path / "t.csv").write_text("order\ntrue\n", encoding="utf-8")
    with pytest.raises(InputError, match="order = 'true'"):
        campaign('table = "t.csv"\n')


@pytest.mark.parametrize("sign", [1.0, -1.0])
def test_superelevation_follows_the_curve(sign):
    """60 mm raise the outer rail of both curves, -60 mm the inner one, with a warning that names the input."""
    for height, warned in ((60.0, False), (-60.0, True)):
        curve = Curve(speed_km_h=80.0, radius_m=sign * 500.0, superelevation_mm=height)
        case = Wheelset(load=Load(curve=curve))
        assert case.forces.tilt_rad == pytest.approx(superelevation_angle(sign * height, 1500.0))
        assert any("superelevation_mm" in each and "adverse" in each for each in unusual(case)) == warned
    straight = Wheelset(load=Load(superelevation_mm=-60.0))
    assert straight.forces.tilt_rad == pytest.approx(superelevation_angle(-60.0, 1500.0))
    assert unusual(straight) == []


@pytest.mark.parametrize("name", ["wheelset", "s1002-60e1"])
def test_geometry_and_run_have_one_default_wheelset(name):
    """Profiles, gauge, wheels and load of `geometry` are those of `run wheelset`."""
    own, main = find_geometry_case(name, {}), Wheelset()
    assert own.load.weight_N == main.load.weight_N
    for rigid, elastic in ((own.track, main.track), (own.wheels, main.wheels)):
        keys = set(type(rigid).model_fields) - {"left", "right"}
        assert {key: getattr(rigid, key) for key in keys} == {key: getattr(elastic, key) for key in keys}
    assert own.forces.vertical_N == main.forces.vertical_N == 200e3


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


def test_a_change_inside_of_a_kind_keeps_the_kind():
    """A slice stays a slice where one of its own inputs, or its size, is changed in Python or by a setting."""
    case = Wheelset(contact=Plane(thickness_mm=12.0))
    changed = case.replaced(contact={"growth": 0.2}, mesh={"size_scale": 2.0})
    assert (changed.contact, changed.mesh.size_scale) == (Plane(thickness_mm=12.0, growth=0.2), 2.0)
    finer = Wheelset.from_values(with_settings(Wheelset, case.written, case.halved_sizes()))
    assert finer.contact == case.contact
    assert finer.mesh.size_scale == 0.5
