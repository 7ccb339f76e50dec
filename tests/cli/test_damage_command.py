"""``flangeway damage``: its files, and what it says about wrong ones."""

import csv
import json

import numpy as np
import pytest

from flangeway.campaign.damage_campaign import DamageCampaign
from flangeway.cases.damage_file import DamageFile
from flangeway.errors import InputError
from flangeway.railway.profiles.profile_file import read_profile

FILE = """
[inputs]
size_scale = 6
mesh.order = 1
track.support = "continuous"
axle = "rigid"
patch_cells = 10
friction = 0.3
yaw_stiffness_kNm_per_mrad = 10
theory = "fastsim"

[[states]]
share = 1
curve.speed_km_h = 80
curve.radius_m = 600

[wear.wheel]
kind = "energy"
constant = 0.5
unit = "mm3/kJ"

[evolution]
end = 100
"""


@pytest.fixture
def written(tmp_path):
    """A function that writes a file with parts exchanged."""

    def write(*parts: tuple[str, str]):
        text = FILE
        for old, new in parts:
            assert old in text
            text = text.replace(old, new)
        file = tmp_path / "line.toml"
        file.write_text(text)
        return file

    return write


def test_all_paths_of_a_file_take_us_units(written) -> None:
    """Inputs, states, their ranges, settings, limits and strategies in US units are the same as the metric ones."""
    end, states = "end = 100\n", "curve.speed_km_h = 80\ncurve.radius_m = 600"
    more = "{}\n[evolution.limits]\n{}\n[strategies.wide.inputs]\n{}\n"
    metric = DamageFile.read(
        written(
            ("patch_cells = 10", "patch_cells = 10\ngauge_mm = 1435.1\naxle_load_kN = 150"),
            (states, "curve.speed_km_h = 80\ncurve.radius_m = [609.6, 304.8]\nparts = 2\naxle_load_kN = 160"),
            (end, end + more.format("max_depth_mm = 0.0254", "max_tread_wear_mm = 2.54", "gauge_mm = 1447.8")),
        )
    ).strategies()
    us = DamageFile.read(
        written(
            ("patch_cells = 10", "patch_cells = 10\ngauge_in = 56.5\naxle_load_kN = 150"),
            (
                states,
                f"curve.speed_mph = {80 / 1.609344!r}\ncurve.radius_ft = [2000, 1000]\nparts = 2\n"
                f"axle_load_kip = {160 / 4.4482216152605!r}",
            ),
            (end, end + more.format("max_depth_in = 0.001", "max_tread_wear_in = 0.1", "gauge_mm = 1447.8")),
        )
    ).strategies()
    assert [*us] == [*metric] == ["line", "wide"]
    for one, other in zip(metric.values(), us.values(), strict=True):
        assert other.evolution.settings == one.evolution.settings
        for state, same in zip(one.evolution.collective.states, other.evolution.collective.states, strict=True):
            assert same.problem.track.gauge_mm == state.problem.track.gauge_mm
            assert same.problem.forces.vertical_N == pytest.approx(state.problem.forces.vertical_N, rel=1e-14)
            assert same.problem.forces.lateral_N == pytest.approx(state.problem.forces.lateral_N, rel=1e-12)
    assert us["wide"].evolution.collective.states[0].problem.track.gauge_mm == 1447.8


def test_inputs_of_a_bundled_collective_in_us_units_are_refused(written) -> None:
    """An input in US units that a bundled collective has is refused as the metric one is."""
    states = ("[[states]]\nshare = 1\ncurve.speed_km_h = 80\ncurve.radius_m = 600", "")
    for key in ("gauge_in = 56.5", "gauge_mm = 1435.1"):
        file = written(states, ("friction = 0.3\n", f"{key}\n"), ("[inputs]", 'collective = "tangent"\n[inputs]'))
        with pytest.raises(InputError, match=f"line 9: {key[:8]} with a bundled collective"):
            DamageFile.read(file).strategies()


@pytest.mark.ci
def test_files_hold_what_was_computed(written, tmp_path, call) -> None:
    """The summary, the table of steps and the worn profile have the same numbers, and a second run computes nothing."""
    out = tmp_path / "out"
    run = ("damage", str(written()), "--out", str(out), "--no-pictures", "--quiet")
    assert call(*run)[0] == 0
    summary = json.loads((out / "summary.json").read_text())
    with (out / "steps.csv").open() as file:
        rows = list(csv.DictReader(file))
    assert [float(row["position"]) for row in rows] == [step["position"] for step in summary["steps"]]
    assert float(rows[-1]["right_wheel_depth_mm"]) == summary["steps"][-1]["right_wheel_depth_mm"] > 0.0
    # as `flangeway geometry wheelset` prints it
    assert float(rows[0]["conicity"]) == pytest.approx(0.1771, abs=5e-5)
    worn = read_profile(out / "worn-right-wheel.csv").surface.sampled(spacing=0.1)
    assert np.abs(worn[:, 1]).max() > 20.0
    assert "energy, 0.5 mm3/kJ" in (out / "report.html").read_text()
    stamp = (out / "damage.sqlite").stat().st_mtime_ns
    assert call(*run)[0] == 0
    assert (out / "damage.sqlite").stat().st_mtime_ns == stamp


@pytest.mark.ci
def test_states_without_equilibrium_are_told(written, tmp_path, call) -> None:
    """A state that overturns is named, and the page says what stands for it."""
    fast = "[[states]]\nname = 'fast'\nshare = 0.5\ncurve.radius_m = 200\ncurve.speed_km_h = 200"
    parts = ("share = 1\n", "share = 0.5\n"), ("radius_m = 600\n", f"radius_m = 600\n{fast}\n"), AT_ONCE
    file, out = written(*parts), tmp_path / "out"
    assert call("damage", str(file), "--out", str(out), "--no-pictures", "--quiet")[0] == 1
    (message,) = json.loads((out / "summary.json").read_text())["unconverged"]
    assert message.startswith("fast: ")
    page = (out / "report.html").read_text()
    assert message[:40] in page
    assert "the mean of the others is taken" in page


@pytest.mark.ci
def test_strategies_are_single_runs_side_by_side(written, tmp_path, call) -> None:
    """A strategy has the numbers of a file of its own with the same changes, and the page has all of them."""
    changes = {
        "inputs": ("curve.radius_m = 600", "curve.radius_m = 500"),
        "wear.wheel": ("constant = 0.5", "constant = 0.2"),
    }
    tables = "".join(f"[strategies.sharp.{table}]\n{new}\n" for table, (_, new) in changes.items())
    results = {}
    for name, parts in {"both": [("end = 100", f"end = 100\n{tables}")], "single": changes.values()}.items():
        out = tmp_path / name
        assert call("damage", str(written(*parts)), "--out", str(out), "--no-pictures", "-q")[0] == 0
        results[name] = json.loads((out / "summary.json").read_text())
    compared, single = results["both"]["strategies"], results["single"]["steps"]
    assert list(compared) == ["line", "sharp"]
    assert compared["sharp"].items() >= single[-1].items()
    areas = [compared[name]["right_wheel_area_mm2"] for name in compared]
    assert areas[0] > 1.1 * areas[1]
    page = (tmp_path / "both" / "report.html").read_text()
    assert "inputs.curve.radius_m = 500, wear.wheel.constant = 0.2" in page
    assert all(f"{area:.3f}" in page for area in areas)
    with (tmp_path / "both" / "steps.csv").open() as file:
        rows = [row for row in csv.DictReader(file) if row["strategy"] == "sharp"]
    assert [float(row["position"]) for row in rows] == [step["position"] for step in single]


@pytest.mark.parametrize(
    ("parts", "words"),
    [
        ([("end = 100", "end = 100\n[strategies.a.inputs]\nspeed = 3")], ("line 24", "speed_km_h")),
        ([("end = 100", "end = 100\n[strategies.a.wear.wheel]\nk = 3")], ("line 25", "wear.wheel.k")),
        ([('"mm3/kJ"', '"mm3"')], ("unit", "mm3/kJ")),
        ([('unit = "mm3/kJ"', "")], ("line 17", "no wear.wheel.unit", "mm3/kJ")),
        ([("[wear.wheel]", "[wear.wheels]")], ("line 17", "wheels", "wheel, rail")),
        ([("share = 1", "share = 0.9")], ("0.9", "sum of 1")),
        ([('kind = "energy"', 'kind = "usfdd"')], ("usfdd", "usfd")),
        ([("end = 100", "end = 100\nfilter = 2")], ("filter", "filter_mm")),
        ([("mesh.order = 1", 'mesh.order = 1\nwheel = "gone.whl"')], ("line", "wheel = 'gone.whl'", "no such file")),
        ([("[evolution]", "[evolutoin]")], ("evolutoin", "evolution")),
        ([("[inputs]", 'collective = "metro"\n[inputs]')], ("collective",)),
        ([("friction = 0.3", "friction = 0")], ("rolling.friction = 0",)),
        ([('unit = "mm3/kJ"', 'unit = "mm3/kJ"\nper_patch = "no"')], ("line 21", "per_patch = 'no'", "true or false")),
        (
            [("end = 100", "end = 100\n[evolution.limits]\nmax_side_wear_mm = 4")],
            ("max_side_wear_mm", "rails, which do not wear"),
        ),
        ([("patch_cells = 10", 'contact = "plane"')], ("contact.kind = plane", "support")),
        ([("share = 1\n", "share = 1\nparts = 100000000\n")], ("parts", "1000")),
    ],
)
def test_wrong_files_are_refused(written, parts, words) -> None:
    """The error names the file and the key, what is allowed and what to do."""
    file = written(*parts)
    with pytest.raises(InputError) as error:
        DamageFile.read(file).strategies()
    for word in ("line.toml", *words):
        assert word in str(error.value)


def test_bundled_collective_refuses_inputs_that_its_states_have(written) -> None:
    """With a bundled collective a friction of its own would have no effect."""
    file = written(
        ("[[states]]\nshare = 1\ncurve.speed_km_h = 80\ncurve.radius_m = 600\n", ""),
        ("[inputs]", 'collective = "metro"\n[inputs]'),
    )
    with pytest.raises(InputError, match="friction"):
        DamageFile.read(file).damage()


AT_ONCE = ("end = 100", "end = 100\n[evolution.limits]\nmin_flange_thickness_mm = 50")
"""A limit that is reached before the first step."""


def test_a_campaign_with_damage_runs_all_combinations(written, tmp_path, call) -> None:
    """Each combination of the values that vary is a strategy beside the file as it is, in a folder of its name."""
    written(AT_ONCE)
    file, out = tmp_path / "harder.toml", tmp_path / "out"
    file.write_text('damage = "line.toml"\n[vary.inputs]\nfriction = [0.2]\n[vary.wear.wheel]\nconstant = [0.2, 0.3]\n')
    strategies = DamageCampaign.read(file).strategies()
    assert list(strategies) == ["line", "friction 0.2, constant 0.2", "friction 0.2, constant 0.3"]
    for constant, inputs in zip((0.2, 0.3), list(strategies.values())[1:], strict=True):
        assert inputs.evolution.laws["wheel"].constant == constant
        assert inputs.evolution.collective.states[0].problem.rolling.coefficient == 0.2
    file.write_text('damage = "line.toml"\n[vary.inputs]\nfriction = [0.2]\n')
    assert call("campaign", str(file), "--out", str(out), "--no-pictures", "--quiet")[0] == 0
    found = json.loads((out / "summary.json").read_text())["strategies"]
    assert list(found) == ["line", "friction 0.2"]
    energies = [each["t_gamma_N"] for each in found.values()]
    assert energies[0] > energies[1] > 0.0
    assert (out / "friction 0.2" / "steps.csv").is_file()


@pytest.mark.parametrize(
    ("text", "options", "words"),
    [
        ('damage = "line.toml"\n', (), ("nothing varies",)),
        ('damage = "line.toml"\n[vary.inputs]\nfriction = 0.2\n', (), ("line 3", "vary.inputs.friction", "a list")),
        ('damage = "line.toml"\n[vary.inputs]\nfrictoin = [0.2]\n', (), ("frictoin",)),
        ('damage = "line.toml"\n[inputs]\nfriction = 0.2\n', (), ("line 2", "inputs", "damage, vary")),
        ('damage = "line.toml"\n[vary.inputs]\nfriction = [0.2]\n', ("--workers", "2"), ("--workers", "leave out")),
    ],
)
def test_wrong_campaigns_with_damage_are_refused(written, tmp_path, call, text, options, words) -> None:
    """Keys that do not belong there, values that do not vary, and options without effect are errors."""
    written()
    file = tmp_path / "sweep.toml"
    file.write_text(text)
    status, _, error = call("campaign", str(file), "--out", str(tmp_path / "out"), *options)
    assert status != 0
    for word in words:
        assert word in error
