"""The command ``flangeway geometry``: its files, its numbers, and its errors."""

import csv
import json

import numpy as np
import pytest

from flangeway.cases import load_case
from flangeway.cases.case_file import read_case
from flangeway.cases.rigid_run import find_geometry_case, read_geometry_case, run_geometry

COARSE = ("--set", "step_mm=0.1")


def test_the_command_writes_its_files(call, tmp_path):
    """Pictures, tables and summary are there, the tables complete and of one piece with the summary."""
    code, out, _ = call("geometry", "s1002-60e1", *COARSE)
    assert code == 0
    folder = tmp_path / "out" / "geometry-s1002-60e1"
    names = {path.name for path in folder.iterdir()}
    assert names == {
        "contact_locus.png",
        "conicity.png",
        "table.csv",
        "conicity.csv",
        "geometry.json",
        "report.html",
    }
    for name in names:
        assert (folder / name).stat().st_size > 1000
    assert out.splitlines()[-1] == "Report: out/geometry-s1002-60e1/report.html"
    with (folder / "table.csv").open(encoding="utf-8") as file:
        rows = list(csv.DictReader(file))
    assert len(rows) == 141
    lateral = np.array([float(row["lateral_mm"]) for row in rows])
    assert lateral == pytest.approx(np.linspace(-7.0, 7.0, 141))
    radii = [float(row["right_rolling_radius_mm"]) - float(row["left_rolling_radius_mm"]) for row in rows]
    assert radii == pytest.approx([float(row["rolling_radius_difference_mm"]) for row in rows], abs=1e-6)
    summary = json.loads((folder / "geometry.json").read_text(encoding="utf-8"))
    assert summary["status"]["converged"]
    assert summary["peak_memory_MB"] > 10.0
    with (folder / "conicity.csv").open(encoding="utf-8") as file:
        at = next(row for row in csv.DictReader(file) if abs(float(row["amplitude_mm"]) - 3.0) < 1e-9)
    assert float(at["conicity_integration"]) == pytest.approx(summary["equivalent_conicity"]["integration"])
    assert f"{summary['equivalent_conicity']['integration']:.4f}" in out
    (jumps,) = (int(line.split()[-1]) for line in out.splitlines() if line.startswith("contact jumps"))
    assert jumps == len(summary["jumps"]) > 0


def test_the_title_says_what_is_changed():
    """The title names the inputs that are not the case's own: nobody takes one wheel's conicity for another's."""
    values = {"step_mm": 0.5, "maximum_lateral_mm": 2.0, "wheel": "AAR-1B"}
    title = run_geometry("s1002-60e1", find_geometry_case("s1002-60e1", values)).summary["title"]
    assert title.startswith("S1002 on 60E1 at 1:40")
    assert title.endswith("; changed: wheelset.wheel = AAR-1B, scan.maximum_lateral_mm = 2.0, scan.step_mm = 0.5")


def test_overturning_ends_with_one(call):
    """No equilibrium is a result with exit status 1, and the sentence gives L/V."""
    code, out, _ = call("geometry", "--set", "lateral_force_kN=200", *COARSE, "--no-pictures")
    assert code == 1
    assert "overturning" in out
    assert "L/V" in out


def test_unequal_wheels_swing_aside():
    """A left wheel that is 0.2 mm smaller moves the place of equal radii to the left by that over twice the slope."""
    values = {"left.radius_mm": 474.4, "radius_mm": 474.6, "radius_at": "tape-line", "step_mm": 0.1}
    found = find_geometry_case("wheelset-tangent", values).geometry().locus(np.linspace(-8.0, 0.0, 81), roll=False)
    assert found.rolling_radius_difference_mm[-1] == pytest.approx(0.2, abs=1e-6)
    at = np.interp(0.0, found.rolling_radius_difference_mm, found.lateral_mm)
    assert at == pytest.approx(-0.2 / (2.0 * 0.05), abs=1e-4)


def test_the_geometry_of_the_main_job_has_its_inputs(tmp_path):
    """A file of the wheelset in three dimensions gives the same track, wheels and load; what has no effect is named."""
    file = tmp_path / "c.toml"
    file.write_text(
        'case = "wheelset"\nposition.yaw_mrad = 2.0\nrolling.friction = 0.3\n[track]\ngauge_mm = 1433.0\n'
        "support.spacing_mm = 650.0\n[load.curve]\nspeed_km_h = 80.0\nradius_m = 500.0\nsuperelevation_mm = 60.0\n",
        encoding="utf-8",
    )
    case, notices = read_geometry_case(file, {})
    main = read_case(file)
    assert notices == ("not used by the geometry: rolling, track.support",)
    assert case.load == main.load
    for own, whole in ((case.track, main.track), (case.wheels, main.wheels)):
        assert {key for key in type(own).model_fields if getattr(own, key) != getattr(whole, key)} <= {"left", "right"}
    assert case.position.yaw_mrad == 2.0
    assert find_geometry_case("wheelset", {}).load == load_case("wheelset").load


def test_without_roll_the_tread_of_1_20_is_its_conicity():
    """Without roll the AAR-1B's conicity is the slope of its tread; with roll about five percent more."""
    values = {"step_mm": 0.1, "maximum_lateral_mm": 5.0}
    plain = run_geometry("wheelset-tangent", find_geometry_case("wheelset-tangent", {**values, "roll": "none"}))
    assert plain.summary["equivalent_conicity"]["integration"] == pytest.approx(0.05, rel=1e-5)
    rolled = run_geometry("wheelset-tangent", find_geometry_case("wheelset-tangent", values))
    assert rolled.summary["equivalent_conicity"]["integration"] == pytest.approx(0.05226, abs=2e-5)


def test_several_wheels_give_one_table_and_one_picture(call, tmp_path):
    """Every wheel on every rail, with the numbers that each pair has by itself."""
    pairs = ("--wheel", "S1002", "--wheel", "R-519-A", "--rail", "60E1", "--rail", "136RE")
    code, out, err = call("geometry", "s1002-60e1", "--set", "step_mm=0.5", "--set", "maximum_lateral_mm=5", *pairs)
    assert code == 0, err
    assert "R-519-A" in out
    folder = tmp_path / "out" / "geometry-s1002-60e1"
    assert {path.name for path in folder.iterdir()} == {
        "geometries.csv",
        "geometries.png",
        "geometries.json",
        "report.html",
    }
    with (folder / "geometries.csv").open(encoding="utf-8") as stream:
        rows = list(csv.DictReader(stream))
    assert [(row["wheel"], row["rail"]) for row in rows] == [
        *(("S1002", name) for name in ("60E1", "136RE")),
        *(("R-519-A", name) for name in ("60E1", "136RE")),
    ]
    assert float(rows[0]["conicity_integration"]) == pytest.approx(0.177, abs=2e-3)
