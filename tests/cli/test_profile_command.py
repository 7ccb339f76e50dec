"""`flangeway profile`, as users call it."""

import csv
import json
import re

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


@pytest.mark.parametrize(
    ("name", "words"),
    [
        ("heavy-haul", "tape line is"),
        ("60E1", "head width at 14 mm"),
    ],
)
def test_bundled_profiles_are_shown_with_their_certainty(name, words, call, tmp_path):
    """Every bundled profile goes through the command, and says how certain it is and where it comes from."""
    status, out, err = call("profile", name, "--out", "here")
    assert status == 0, err
    assert words in " ".join(out.split())
    assert "Certainty:" in out
    assert "Source:" in out
    assert {path.name for path in (tmp_path / "here").iterdir()} == FILES


@pytest.mark.parametrize(
    ("name", "ending"),
    [("S1002", "whl"), ("60E1", "prr")],
)
def test_bundled_profiles_are_converted(name, ending, call):
    """A bundled running surface, written for another program, lies within a micrometre of the nominal one."""
    assert call("profile", name, "--to", f"n.{ending}", "--no-pictures")[0] == 0
    found = read_profile(f"n.{ending}")
    nominal = run_profile(name)
    surface = nominal.profile.surface
    shift = [0.0, 0.0] if nominal.profile.kind == "wheel" else [0.0, surface.bounds()[1, 1]]
    assert surface.closest(found.points + shift)[2].max() < 1e-3


def test_a_failing_picture_leaves_nothing(call, files, tmp_path, monkeypatch):
    """If a picture cannot be drawn, no file is left at its place, the conversion neither."""

    def fail(*_):
        raise KeyboardInterrupt

    monkeypatch.setattr("flangeway.report.profile.profile_outputs.curvature_figure", fail)
    status, _, err = call("profile", "tread.txt", "--to", "y.txt")
    assert status == 130
    assert "interrupted" in err
    assert not (tmp_path / "out").exists()
    assert not (tmp_path / "y.txt").exists()


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


def test_profiles_of_one_title_have_the_names_of_their_files(call, tmp_path):
    """Files of one instrument share a title: table and notes name the file."""
    for name, lift in (("a.whl", 0.0), ("b.whl", 0.8)):
        assert call("profile", "S1002", "--to", name, "--no-pictures")[0] == 0
        lines = (tmp_path / name).read_text(encoding="utf-8").splitlines()
        head, points = lines[: lines.index("") + 1], lines[lines.index("") + 1 :]
        moved = (f"{x} {float(y) + lift:.9f}" for x, y in map(str.split, points))
        (tmp_path / name).write_text("\n".join([*head, *moved]), encoding="utf-8")
    status, out, err = call("profile", "a.whl", "b.whl", "60E1", "--no-pictures")
    assert status == 0, err
    assert re.search(r"^S1002, a\.whl +28\.000", out, flags=re.MULTILINE)
    assert re.search(r"moved to zero\. \(S1002, b\.whl\)", out.replace("\n", " "))


def test_a_worn_wheel_is_below_the_new_one_in_the_overlay(files):
    """Distances are outwards from the first profile: a millimetre of wear is one millimetre less."""
    first = run_profile("S1002").body.running_surface
    worn = first.transformed(Placement(translation=(0.0, 1.0)))
    points = worn.sampled(spacing=0.25)
    apart = deviations(first, points)[np.abs(points[:, 0] - 30.0) < 10.0]
    assert apart == pytest.approx(-1.0, abs=0.02)
