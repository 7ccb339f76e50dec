"""`flangeway profile`, as users call it."""

import csv
import json
import re

import numpy as np
import pytest
from matplotlib.image import imread

from flangeway.cases.profile_run import nearest_nominal, run_folder, run_profile
from flangeway.cases.rigid_run import find_geometry_case, run_geometry
from flangeway.errors import InputError
from flangeway.geometry import Placement
from flangeway.railway.profiles.bundled import rail, wheel
from flangeway.railway.profiles.formats.instrument_files import write_miniprof
from flangeway.railway.profiles.formats.two_column import write_two_column
from flangeway.railway.profiles.joining import joined
from flangeway.railway.profiles.orientation import ReadOptions, measures
from flangeway.railway.profiles.profile_file import read_profile
from flangeway.report.profile_outputs import deviations, folder_record, join_figure

FILES = {"profile.png", "curvature.png", "report.html", "profile.json"}


@pytest.fixture
def files(tmp_path):
    """A worn head, noisy, in inches, from its top; and a noisy S1002 in mm."""
    rng = np.random.default_rng(1)
    profile = rail()
    head = profile.outline.part(profile.running_names).sampled(spacing=0.3) - [0.0, profile.outline.bounds()[1, 1]]
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


FLANGE_MM, TREAD_MM, SIDE_MM, TOP_MM = 2.5, 1.5, 4.0, 3.0


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    """New wheel and rail, a thin flange, a worn tread, a head narrowed and lowered, and a file of something else."""
    tmp_path = tmp_path_factory.mktemp("worn")
    tread = wheel("S1002").running_surface.sampled(spacing=0.25)
    head = rail("60E1").running_surface.sampled(spacing=0.25) - [0.0, 172.0]
    thin = tread - np.interp(tread[:, :1], (-62.0, -50.0, -37.0, -25.0), (0.0, 1.0, 1.0, 0.0)) * [FLANGE_MM, 0.0]
    hollow = tread + np.interp(tread[:, :1], (-30.0, -15.0), (0.0, 1.0)) * [0.0, TREAD_MM]
    narrow = head + np.clip(-head[:, :1] / 30.0, 0.0, 1.0) * [SIDE_MM, 0.0] - [0.0, TOP_MM]
    for name, points in (("new", tread), ("thin", thin), ("hollow", hollow)):
        text = write_miniprof(points, "wheel", name) if name == "new" else write_two_column(points, "wheel", name, 70.0)
        (tmp_path / f"{name}.{'whl' if name == 'new' else 'txt'}").write_text(text)
    (tmp_path / "head.ban").write_text(write_miniprof(head, "rail", "head"))
    (tmp_path / "narrow.txt").write_text(write_two_column(narrow, "rail", "narrow"))
    (tmp_path / "empty.txt").write_text("no profile\n")
    (tmp_path / "notes.md").write_text("not read\n")
    return tmp_path


@pytest.fixture(scope="module")
def done(folder):
    """What is found in the folder."""
    return run_folder(folder)


def test_wear_is_what_was_taken_away(done):
    """Each wear is what the file was made with, 0 of new profiles, and the most worn comes first."""
    rows = {row.file: row for row in done.profiles}
    assert [row.file for row in done.profiles[:2]] == ["narrow.txt", "thin.txt"]
    assert rows["new.whl"].wear_mm == pytest.approx({"tread_wear": 0.0, "flange_wear": 0.0}, abs=0.02)
    assert rows["thin.txt"].wear_mm["flange_wear"] == pytest.approx(FLANGE_MM, abs=0.05)
    assert rows["hollow.txt"].wear_mm["tread_wear"] == pytest.approx(TREAD_MM, abs=0.05)
    assert rows["head.ban"].wear_mm["side_wear"] == pytest.approx(0.0, abs=0.02)
    assert rows["narrow.txt"].wear_mm["side_wear"] == pytest.approx(SIDE_MM, abs=0.05)
    assert rows["narrow.txt"].wear_mm["top_wear"] == pytest.approx(TOP_MM, abs=0.05)
    (refused,) = done.refused
    assert "empty.txt" in refused


def test_conicity_is_that_of_the_geometry(done):
    """A new wheel and a new rail have the conicity that `flangeway geometry` has of the pair, from their files."""
    pair = run_geometry("s1002-60e1", find_geometry_case("s1002-60e1", {"step_mm": 0.1}))
    wanted = pair.conicities.at_reference["integration"]
    for row in done.profiles:
        if row.file in ("new.whl", "head.ban"):
            assert row.conicity == pytest.approx(wanted, rel=0.02)


def test_the_command_writes_table_picture_and_report(call, done, monkeypatch, folder, tmp_path):
    """The table has a row for each profile that was read, the warnings the file that was not."""
    monkeypatch.setattr("flangeway.cases.profile_run.run_folder", lambda *_, **__: done)
    code, out, err = call("profiles", folder, "--out", tmp_path / "found")
    assert code == 0, err
    assert "empty.txt" in out
    assert {path.name for path in (tmp_path / "found").iterdir()} == {
        "profiles.csv",
        "profiles.json",
        "profiles.png",
        "report.html",
        *(f"worn-{kind}-{number}.png" for kind in ("rail", "wheel") for number in (1, 2)),
    }
    with (tmp_path / "found" / "profiles.csv").open(encoding="utf-8") as stream:
        rows = list(csv.DictReader(stream))
    assert [row["file"] for row in rows][:1] == ["narrow.txt"]
    assert len(rows) == 5
    assert float(rows[0]["side_wear_mm"]) == pytest.approx(SIDE_MM, abs=0.05)
    # what was assumed of a file is in the report, with its name, and in the file for programs
    summary = json.loads((tmp_path / "found" / "profiles.json").read_text())
    notices = {row["file"]: row["notices"] for row in summary["profiles"]}
    (assumed,) = notices["hollow.txt"]
    assert f"{TREAD_MM:.3f} mm" in assumed
    report = (tmp_path / "found" / "report.html").read_text()
    assert re.search(rf">[^<]*hollow\.txt[^<]*</th>\s*<td[^>]*>[^<]*{re.escape(assumed)}", report)


def test_notices_are_metric(done):
    """What the report says of a file in sentences is metric, also where its tables are in US units."""
    notices = dict(folder_record(done, "worn", "", "us").chapters["Notices"][0].rows)
    assert f"at a height of {TREAD_MM:.3f} mm " in notices["hollow.txt"]


def test_wear_is_of_the_given_nominal_profile(folder, tmp_path):
    """Side wear against a given rail is how much narrower the head is than that rail's; wheels keep the nearest one."""
    for name in ("head.ban", "thin.txt"):
        (tmp_path / name).write_bytes((folder / name).read_bytes())
    rows = {row.file: row for row in run_folder(tmp_path, nominal="54E1").profiles}
    widths = {name: measures(rail(name).running_surface, "rail")["head_width_mm"] for name in ("54E1", "60E1")}
    assert rows["head.ban"].wear_mm["side_wear"] == pytest.approx(widths["54E1"] - widths["60E1"], abs=0.05)
    assert (rows["head.ban"].nominal, rows["thin.txt"].nominal) == ("54E1", "S1002")
    with pytest.raises(InputError, match="S1003"):
        run_folder(tmp_path, nominal="S1003")


def test_folders_without_profiles_are_refused(tmp_path):
    """No folder, and a folder of other files, are refused by their name."""
    for path in (tmp_path / "none", tmp_path):
        with pytest.raises(InputError, match=str(path)):
            run_folder(path)


WORN_MM = 0.6


def test_a_measured_wheel_is_drawn_over_its_nominal_one(call, tmp_path):
    """The picture of a wheel worn by 0.6 mm in the middle of its tread has this depth below the nominal one there."""
    new = wheel("S1002").running_surface.sampled(spacing=0.25)
    worn = new + [0.0, WORN_MM] * np.exp(-(((new[:, :1] - 30.0) / 6.0) ** 2))
    (tmp_path / "worn.csv").write_text("\n".join(f"{x:.5f},{y:.5f}" for x, y in worn), encoding="utf-8")
    status, _, error = call("profile", "worn.csv", "--kind", "wheel", "--unit", "mm", "--nominal", "S1002")
    assert status == 0, error
    folder = tmp_path / "out" / "profile-worn"
    assert (folder / "worn.png").read_bytes().startswith(b"\x89PNG")
    assert "on the nominal S1002" in (folder / "report.html").read_text(encoding="utf-8")
    run = run_profile(str(tmp_path / "worn.csv"), ReadOptions(kind="wheel", unit="mm"))
    assert nearest_nominal(run.profile) == "S1002"
    below = join_figure(joined(run.profile, "S1002")).axes[1].lines[0]
    x, off = below.get_xdata(), below.get_ydata()
    assert x[off.argmin()] == pytest.approx(30.0, abs=0.5)
    assert off.min() == pytest.approx(-WORN_MM, abs=0.02)
    assert np.abs(off[np.abs(x - 30.0) > 20.0]).max() < 0.02
