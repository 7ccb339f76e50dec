"""Where the gauge is measured, beside gauges measured here on the profiles' points."""

import math

import numpy as np
import pytest

from flangeway.campaign import Campaign
from flangeway.cases import Wheelset
from flangeway.cases.case_file import load_case
from flangeway.cases.rigid_run import find_geometry_case, run_geometry
from flangeway.errors import InputError
from flangeway.live.engine import LiveEngine
from flangeway.railway.profiles.bundled import rail
from flangeway.railway.profiles.formats.instrument_files import write_miniprof
from flangeway.railway.profiles.named import RailFile, profile_of
from flangeway.railway.track.placements import SIDES, RailSide, Track, usual_gauge
from flangeway.report.wheelset.wheelset_page import results_table


def own_gauge(heads: list[np.ndarray], depth: float) -> float:
    """Smallest distance of points (n, 2) of a left and a right head down to a depth below each top."""
    left, right = (points[points[:, 1] >= points[:, 1].max() - depth] for points in heads)
    return float(right[:, 0].min() - left[:, 0].max())


def heads_of(track: Track) -> list[np.ndarray]:
    return [track.placement(side).points(track.rail_of(side).running_surface.sampled(spacing=0.002)) for side in SIDES]


def worn_file(folder, seed: int, name: str = "60E1") -> str:
    """A MiniProf file of a head with random wear of its crown, gauge corner and gauge face, up to 6 mm."""
    random = np.random.default_rng(seed)
    profile = rail(name)
    points = profile.running_surface.sampled(spacing=0.1)[::3]
    points = points - [0.0, points[:, 1].max()]
    along = np.gradient(points, axis=0)
    normals = np.column_stack((along[:, 1], -along[:, 0])) / np.hypot(*along.T)[:, None]
    s = np.linspace(0.0, 1.0, len(points))
    corner, width, depth = random.uniform(0.7, 0.85), random.uniform(0.06, 0.12), random.uniform(0.5, 6.0)
    wear = depth * np.exp(-(((s - corner) / width) ** 2)) + random.uniform(0.0, 2.0) * np.exp(-(((s - 0.5) / 0.2) ** 2))
    worn = points - normals * (wear * np.clip((1.0 - s) / 0.05, 0.0, 1.0) * np.clip(s / 0.05, 0.0, 1.0))[:, None]
    file = folder / f"worn{seed}.ban"
    file.write_text(write_miniprof(worn, "rail", "worn"))
    return str(file)


@pytest.mark.parametrize("seed", range(4))
def test_gauge_is_measured_within_14_mm_on_inclined_and_worn_rails(tmp_path, seed):
    """A random worn rail and its new partner at a random inclination are the gauge apart within 14 mm of their tops."""
    random = np.random.default_rng(seed)
    track = Track(
        rail=RailFile(file=worn_file(tmp_path, seed), body="60E1"), left=RailSide(rail="60E1"),
        gauge_mm=1435.0 + random.uniform(-5.0, 20.0), inclination=random.uniform(0.0, 0.06),
    )  # fmt: skip
    assert own_gauge(heads_of(track), 14.0) == pytest.approx(track.gauge_mm, abs=2e-3)
    assert track.measured_gauge_mm == pytest.approx(track.gauge_mm, abs=1e-9)
    for side, points in zip(SIDES, heads_of(track), strict=True):
        inner = points[points[:, 1] >= points[:, 1].max() - 14.0]
        at = inner[np.abs(inner[:, 0]).argmin()]
        assert track.gauge_point(side).depth_mm == pytest.approx(points[:, 1].max() - at[1], abs=0.05)


@pytest.mark.parametrize("seed", range(2))
def test_a_worn_rail_may_stand_where_it_stood_new(tmp_path, seed):
    """At the gauge of the unworn head a worn rail stands as the new one, and its own gauge is wider by its wear."""
    worn = RailFile(file=worn_file(tmp_path, seed), body="60E1")
    track, new = (Track(rail=each, gauge_at="unworn") for each in (worn, "60E1"))
    assert track.placement("right") == new.placement("right")
    assert track.measured_gauge_mm == pytest.approx(own_gauge(heads_of(track), 14.0), abs=2e-3)
    assert track.measured_gauge_mm > 1435.5


@pytest.mark.parametrize("inclination", [0.0, 0.025, 0.05])
def test_the_narrowest_place_is_an_option(inclination):
    """At the narrowest place, the heads' closest points at any depth are the gauge apart."""
    track = Track(rail="60E1", inclination=inclination, gauge_at="narrowest")
    assert own_gauge(heads_of(track), math.inf) == pytest.approx(1435.0, abs=2e-3)
    assert track.measured_gauge_mm == pytest.approx(own_gauge(heads_of(track), 14.0), abs=2e-3)


def test_depth_of_the_gauge():
    """EN 13848-1 measures 14 mm below the top; another depth is taken in both units."""
    for inputs, depth in (
        ({}, 14.0),
        ({"units": "us"}, 14.0),
        ({"units": "us", "gauge_depth_in": 0.625}, 15.875),
        ({"gauge_depth_mm": 10.0}, 10.0),
    ):
        track = load_case("wheelset", **inputs).track
        assert own_gauge(heads_of(track), depth) == pytest.approx(1435.0, abs=2e-3)


def test_all_commands_measure_the_same_gauge(tmp_path):
    """Run, geometry, campaign and the live page put 60E1 rails 1435 mm apart within 14 mm of their tops."""
    outlines = LiveEngine(tmp_path).geometry({})["sides"]
    fine = []
    for side in SIDES:  # faces are straight between the corners of a drawn outline
        corners = np.array(outlines[side]["rail"])
        at = np.linspace(0.0, len(corners) - 1.0, 200 * len(corners))
        fine.append(np.column_stack([np.interp(at, np.arange(len(corners)), column) for column in corners.T]))
    assert own_gauge(fine, 14.0) == pytest.approx(1435.0, abs=0.1)  # drawn to some hundredths of a millimetre
    file = tmp_path / "few.toml"
    file.write_text('case = "wheelset"\n[vary]\nlateral_mm = [0.0, 1.0]\n')
    cases = [Wheelset(), find_geometry_case("wheelset", {}), Wheelset(contact="plane")]
    cases += [row.case for row in Campaign.from_file(file).rows]
    for case in cases:
        assert own_gauge(heads_of(case.track), 14.0) == pytest.approx(1435.0, abs=2e-3)


def test_the_published_plane_wheelset_keeps_its_definition():
    """Moherdaui (2021) measures 1600 mm between the closest points of the heads."""
    for case in (load_case("wheelset-tangent"), find_geometry_case("wheelset-tangent", {})):
        assert own_gauge(heads_of(case.track), math.inf) == pytest.approx(1600.0, abs=2e-3)


def test_the_place_of_the_gauge_is_reported():
    """Results have the depth of the gauge point and the gauge of the heads as they are."""
    coarse = {"size_scale": 6.0, "order": 1, "support": "continuous", "patch_cells": 10}
    run = load_case("wheelset", **coarse, gauge_at="narrowest").run()
    summary = run.parts()
    own = own_gauge(heads_of(run.problem.track), 14.0)
    assert summary["track"]["measured_gauge_mm"] == pytest.approx(own, abs=2e-3)
    assert [side["gauge_depth_mm"] for side in summary["sides"]] == pytest.approx([35.2, 35.2], abs=3.0)
    assert any("gauge point" in row[0] for row in results_table(run).rows)
    rigid = run_geometry("wheelset", find_geometry_case("wheelset", {"step_mm": 0.5, "maximum_lateral_mm": 2.0}))
    assert rigid.summary["track"]["measured_gauge_mm"] == pytest.approx(1435.0, abs=1e-9)


def test_unknown_unworn_heads_and_shallow_heads_are_refused(tmp_path):
    """A head on a plain body has no unworn head, and one that ends above the depth of the gauge has no gauge there."""
    file = worn_file(tmp_path, 3)
    plain = profile_of(RailFile(file=file, body="plain"), "rail")
    with pytest.raises(InputError, match="unworn"):
        Track(rail=plain, gauge_at="unworn").placement("right")
    with pytest.raises(InputError, match="gauge_depth_mm"):
        Track(rail=plain, gauge_depth_mm=60.0).placement("right")


@pytest.mark.parametrize("gauge", [1000.0, 1067.0, 1372.0, 1524.0, 1672.0, 1676.0])
def test_wheelsets_of_other_gauges_are_asked_for(gauge):
    """Gauges without a source for their wheelsets ask for back_to_back_mm, the next ones to known gauges too."""
    with pytest.raises(InputError, match="back_to_back_mm"):
        usual_gauge(gauge)


@pytest.mark.parametrize(
    ("gauge", "back_to_back"), [(1430.0, 1360.0), (1465.0, 1360.0), (1520.0, 1440.0), (1668.0, 1593.0)]
)
def test_wheelsets_of_known_gauges(gauge, back_to_back):
    """Middles of the ranges in Regulation (EU) 1302/2014, 4.2.3.5.2.1; a widened track keeps its wheelsets."""
    assert usual_gauge(gauge).back_to_back_mm == back_to_back
