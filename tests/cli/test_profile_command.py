"""`flangeway profile`, as users call it."""

import csv
import json

import numpy as np
import pytest
from matplotlib.image import imread

from flangeway.cases.profile.profile_run import run_profile
from flangeway.geometry import Placement
from flangeway.railway.profiles.bundled import rail, wheel
from flangeway.railway.profiles.profile_file import ReadOptions, read_profile
from flangeway.report.profile.profile_figures import deviations

FILES = {"profile.png", "curvature.png", "report.html", "profile.json"}


@pytest.fixture
def files(tmp_path):
    """A worn head, noisy, in inches, from its top; and a noisy S1002 in mm."""
    rng = np.random.default_rng(1)
    profile = rail()
    head = profile.outline.part(profile.head_names).sampled(spacing=0.3) - [0.0, profile.outline.bounds()[1, 1]]
    head += 3e-3 * rng.normal(size=head.shape)
    (tmp_path / "worn.csv").write_text("\n".join(f"{x / 25.4:.7f},{y / 25.4:.7f}" for x, y in head))
    tread = wheel("S1002")
    points = tread.outline.part(tread.running_names).sampled(spacing=0.3)
    points += 3e-3 * rng.normal(size=points.shape)
    (tmp_path / "tread.txt").write_text("\n".join(f"{x:.5f} {y:.5f}" for x, y in points))


def test_a_measured_head_on_a_rail(call, files, tmp_path):
    """Unit, origin, noise, smoothing and joints are printed back; pictures, summary and conversion are written."""
    status, out, err = call("profile", "worn.csv", "--unit", "in", "--join", "136RE", "--to", "new/rail.dxf")
    assert status == 0, err
    for words in ("rail, CSV", "in (given)", "top (from the numbers)", "deviation, maximum, μm"):
        assert " ".join(words.split()) in " ".join(out.split())
    assert "gap to nominal, first end, mm" in out
    folder = tmp_path / "out" / "profile-worn"
    assert {path.name for path in folder.iterdir()} == FILES | {"joined.png"}
    for path in folder.glob("*.png"):
        assert min(imread(path).shape[:2]) > 400
    summary = json.loads((folder / "profile.json").read_text(encoding="utf-8"))
    assert summary["unit"] == "in (given)"
    assert 2.0 < summary["noise_um"] < 4.0
    assert summary["maximum_deviation_um"] <= summary["limit_um"] < 25.0
    assert summary["area_mm2"] == pytest.approx(8602.42, abs=3.0)
    assert summary["peak_memory_MB"] > 10.0
    again = run_profile("new/rail.dxf")
    assert again.summary["area_mm2"] == pytest.approx(summary["area_mm2"], rel=1e-9)
    assert again.profile.kind == "rail"


def test_conversion_keeps_the_smoothed_wheel(call, files):
    """A noisy wheel, smoothed and converted, is read back within a micrometre, without being smoothed again."""
    status, out, err = call("profile", "tread.txt", "--smooth", 6, "--to", "tread2.prw", "--no-pictures")
    assert status == 0, err
    assert "wheel, two columns" in out
    assert "tread2.prw" in out
    first = run_profile("tread.txt", ReadOptions(smooth_mm=6.0)).profile
    again = read_profile("tread2.prw", ReadOptions(smooth_mm=0.0))
    assert np.abs(again.surface.closest(first.smoothing.points)[2]).max() < 1e-3


def test_several_profiles_give_one_table_and_one_picture(call, files, tmp_path):
    """A row for each profile with its measures; the picture has them all; options of one file are refused."""
    status, out, err = call("profile", "tread.txt", "S1002", "60E1", "--out", "b")
    assert status == 0, err
    assert "Sh" in out
    assert {path.name for path in (tmp_path / "b").iterdir()} == {
        "profiles.csv",
        "profiles.png",
        "profiles.json",
        "report.html",
    }
    with (tmp_path / "b" / "profiles.csv").open(encoding="utf-8") as stream:
        rows = list(csv.DictReader(stream))
    assert [row["kind"] for row in rows] == ["wheel", "wheel", "rail"]
    assert float(rows[0]["flange_height_mm"]) == pytest.approx(float(rows[1]["flange_height_mm"]), abs=0.01)
    assert rows[2]["flange_height_mm"] == ""
    assert min(imread(tmp_path / "b" / "profiles.png").shape[:2]) > 400
    assert call("profile", "S1002", "60E1", "--to", "x.csv")[0] == 2


def test_a_worn_wheel_is_below_the_new_one_in_the_overlay(files):
    """Distances are outwards from the first profile: a millimetre of wear is one millimetre less."""
    first = run_profile("S1002").body.running_surface
    worn = first.transformed(Placement(translation=(0.0, 1.0)))
    points = worn.sampled(spacing=0.25)
    apart = deviations(first, points)[np.abs(points[:, 0] - 30.0) < 10.0]
    assert apart == pytest.approx(-1.0, abs=0.02)
