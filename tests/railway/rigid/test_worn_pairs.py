"""Worn pairs whose flange is deeper than the lower edge of the worn gauge face, and what ends a rigid search."""

import math

import numpy as np
import pytest
from shapely import Polygon
from shapely.affinity import translate

from flangeway.cases.case_file import load_case
from flangeway.cases.rigid_run import find_geometry_case, run_geometry
from flangeway.railway.profiles.bundled import rail, wheel
from flangeway.railway.profiles.formats.instrument_files import write_miniprof
from flangeway.railway.rigid.rigid_equilibrium import rigid_equilibrium
from flangeway.railway.track.placements import SIDES


def worn_pair(folder, seed: int) -> dict[str, dict[str, str]]:
    """A 60E1 whose gauge face S1002 wheels have cut, measured some 15 mm deep, and an S1002 with a hollow tread."""
    random = np.random.default_rng(seed)
    side, down, hang, reach, hollow = (
        random.uniform(*limits) for limits in ((8, 18), (0, 6), (0, 1), (12, 17), (2, 6))
    )
    body, cut = (Polygon(each.outline.sampled(spacing=0.2)) for each in (rail("60E1"), wheel("S1002")))
    for part in np.linspace(0.2, 1.0, 5):
        body = body.difference(translate(cut, -3.5 + side * part, 172.0 - (down + hang) * part))
    body = body if body.geom_type == "Polygon" else max(body.geoms, key=lambda piece: piece.area)
    ring = np.array(body.exterior.coords)[:-1]
    ring = ring if body.exterior.is_ccw else ring[::-1]
    upper = ring[:, 1] > ring[:, 1].max() - reach
    first = max(np.flatnonzero(upper & ~np.roll(upper, 1)), key=lambda number: ring[number, 0])
    ring, upper = np.roll(ring, -first, axis=0), np.roll(upper, -first)
    head = ring[: np.argmin(upper)]
    lengths = np.append(0.0, np.cumsum(np.hypot(*np.diff(head, axis=0).T)))
    at = np.arange(0.0, lengths[-1], 0.25)
    head = np.column_stack([np.interp(at, lengths, column) for column in head.T])
    tread = wheel("S1002").running_surface.sampled(spacing=0.2)
    tread[:, 1] += hollow * np.exp(-(((tread[:, 0] - 5.0) / 25.0) ** 4))
    tread[:, 1] -= np.interp(0.0, tread[tread[:, 1] > -15.0, 0], tread[tread[:, 1] > -15.0, 1])
    texts = {
        "rail": write_miniprof(head - [0.0, head[:, 1].max()], "rail", "worn"),
        "wheel": write_miniprof(tread, "wheel", "worn", wheel("S1002").flange_back_mm),
    }
    files = {"rail": folder / f"worn{seed}.ban", "wheel": folder / f"worn{seed}.whl"}
    for kind, text in texts.items():
        files[kind].write_text(text)
    bodies = {"rail": "60E1", "wheel": "S1002"}
    return {kind: {"file": str(file), "body": bodies[kind]} for kind, file in files.items()}


def case_of(folder, seed: int, **inputs):
    values = {"gauge_at": "narrowest", "inclination": 0.05, "lateral_force_kN": 20.0}
    return find_geometry_case("wheelset", worn_pair(folder, seed) | values | inputs)


def overlap_mm2(case, position) -> float:
    """Area in which wheels and rails overlap in a position, by polygons of their outlines."""
    track, axle = case.track, case.wheels
    area = 0.0
    for side in SIDES:
        on_rail = track.placement(side).points(track.rail_of(side).outline.sampled(spacing=0.1))
        on_wheel = position.motion.placement(axle, side).points(axle.wheel_of(side).outline.sampled(spacing=0.1))
        area += Polygon(on_rail).intersection(Polygon(on_wheel)).area
    return area


@pytest.mark.parametrize("seed", [pytest.param(0, marks=pytest.mark.ci), 5])
def test_a_flange_deeper_than_the_worn_face_stands(tmp_path, seed):
    """Under L/V 0.1 the wheelset stands on its flange in equilibrium, and wheels and rails do not overlap."""
    case = case_of(tmp_path, seed)
    geometry = case.geometry()
    equilibrium = rigid_equilibrium(geometry, case.forces)
    position = equilibrium.reached()
    forces = sum(np.array(point.force_on_wheel_N) for point in position.contacts)
    assert forces == pytest.approx((-20e3, 200e3), rel=1e-6)
    assert max(math.degrees(point.contact_angle_rad) for point in position.contacts) > 20.0
    assert overlap_mm2(case, position) < 0.05
    # the flange goes on over the edge below the face, up to its steepest part
    steepest = np.degrees(max(geometry.path().side(side).angle[:, 0].max() for side in SIDES))
    assert steepest > 60.0


@pytest.mark.ci
def test_such_a_pair_runs(tmp_path):
    """The elastic wheelset of such a pair is in equilibrium under L/V 0.1."""
    inputs = worn_pair(tmp_path, 5) | {"gauge_at": "narrowest", "inclination": 0.05, "lateral_force_kN": 20.0}
    run = load_case("wheelset", **inputs, size_scale=3.0, patch_cells=14).run()
    assert run.status.converged, run.status.message
    total = sum(run.result.force_on_wheel_N(side) for side in SIDES)
    assert total == pytest.approx((-20e3, 200e3), rel=1e-5)


def test_the_end_of_a_search_is_told_from_climbing():
    """On a track 80 mm too wide the rim of one wheel ends before the other flange touches: no flange climbs."""
    inputs = {"gauge_mm": 1515.0, "back_to_back_mm": 1360.0, "lateral_force_kN": 20.0, "maximum_lateral_mm": 60.0}
    case = find_geometry_case("wheelset", inputs | {"step_mm": 0.5})
    geometry = case.geometry()
    assert math.degrees(geometry.right.flange_angle_rad()) == pytest.approx(70.0, abs=0.01)
    status = rigid_equilibrium(geometry, case.forces).status
    assert not status.converged
    assert "climbs" not in status.message
    assert "the rim of the" in status.message
    assert "flange angle 70.0 deg" in status.message
    assert any("the rim of the" in notice for notice in run_geometry("wide", case).summary["notices"])


def test_a_climbing_flange_is_named():
    """S1002 on 60E1 under L/V beyond what its flange holds, low centre of gravity: the flange climbs, at 70 degrees."""
    case = find_geometry_case("wheelset", {"lateral_force_kN": 620.0, "centre_of_gravity_height_mm": -459.0})
    geometry = case.geometry()
    status = rigid_equilibrium(geometry, case.forces).status
    assert not status.converged
    assert "climbs" in status.message
    assert "flange angle 70.0 deg" in status.message
