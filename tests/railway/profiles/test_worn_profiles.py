"""Worn profiles: from noisy files to the equilibrium, and one tape distance whatever body is joined."""

from functools import cache

import numpy as np
import pytest

from benchmarks import worn
from flangeway.cases import WheelsetCurveCase, WheelsetTangentCase
from flangeway.railway.profiles.bundled import rail, wheel
from flangeway.railway.profiles.formats.miniprof import write_miniprof
from flangeway.railway.profiles.joining import joined, on_plain_body
from flangeway.railway.profiles.profile_file import ReadOptions, read_profile
from flangeway.railway.profiles.smoothing import smoothed, usual_wavelength_mm
from flangeway.railway.rigid.rigid_geometry import RigidGeometry
from flangeway.railway.track.placements import Track, Wheelset

NOISE_MM, SPACING_MM = worn.NOISE_MM, worn.SPACING_MM


@pytest.fixture(scope="module")
def pairs(tmp_path_factory):
    """Inputs that name files of the pair, without and with noise."""
    found = {}
    for name, noise in (("smooth", 0.0), ("noisy", NOISE_MM)):
        with pytest.MonkeyPatch.context() as patched:
            patched.setattr(worn, "NOISE_MM", noise)
            found[name] = worn.worn_pair(tmp_path_factory.mktemp(name))
    return found


@pytest.fixture(scope="module")
def runs(pairs):
    """Function that solves a case once: tangent without and with noise, curve with noise; and what it said."""

    @cache
    def solved(name):
        case, said = (WheelsetCurveCase if name == "curve" else WheelsetTangentCase), []
        run = case.from_values({**pairs["smooth" if name == "smooth" else "noisy"], "size_scale": 3.0}).run(said.append)
        return run, said

    return solved


@pytest.mark.ci
@pytest.mark.parametrize("name", ["smooth", "noisy", "curve"])
def test_the_chain_ends_in_equilibrium(name, runs):
    """From the files to the equilibrium: converged, errors below 1e-10, contact forces that carry the load."""
    run, _ = runs(name)
    assert run.result.status.converged, run.result.status.message
    assert run.result.equilibrium.residuals.equilibrium_residual < 1e-10
    along, onto = run.result.model.problem.load.in_track
    total = sum(patch.force_on_wheel_N for patch in run.result.patches)
    assert total == pytest.approx([-along, onto], rel=1e-8, abs=1.0)


def test_a_hollow_tread_conforms(runs):
    """The worn wheel touches at one wide place: more than 9 mm half width, where the new pair has 6.4 mm."""
    patches = runs("smooth")[0].result.patches
    assert [patch.side for patch in patches] == ["left", "right"]
    assert min(patch.pressure.half_width for patch in patches) > 9.0


def test_noise_is_no_wear(runs):
    """With 30 micrometres of noise the contacts are as many, 1.5 mm about their places, their pressure within 20 %."""
    smooth, noise = (runs(name)[0].result.patches for name in ("smooth", "noisy"))
    assert [patch.side for patch in noise] == [patch.side for patch in smooth]
    for one, other in zip(smooth, noise, strict=True):
        assert other.rail_point_mm == pytest.approx(one.rail_point_mm, abs=1.5)
        assert other.pressure.pressures.max() == pytest.approx(one.pressure.pressures.max(), rel=0.2)


def test_the_run_says_how_the_noise_was_smoothed(runs):
    """What was done to the files stands among the assumptions of the run, with wheel and rail named."""
    said = [line for line in runs("noisy")[0].summary["assumptions"] if "The noise is" in line]
    assert len(said) == 2
    noise = [float(line.split("The noise is ")[1].split(" micrometres")[0]) for line in said]
    assert noise == pytest.approx([1e3 * NOISE_MM] * 2, rel=0.2)
    assert "AAR-1B" in said[0]
    assert "136RE" in said[1]


def test_a_conforming_pair_costs_no_second_model(runs):
    """Its wide contact is foreseen: one model of at most 2.4 times the bundled pair's surface nodes."""
    run, said = runs("noisy")
    plain = WheelsetTangentCase.from_values({"size_scale": 3.0}).run()
    nodes = [sum(len(each.points) for each in one.result.model.system.surface_nodes) for one in (run, plain)]
    assert not any(sentence.startswith("once more") for sentence in said)
    assert nodes[0] < 2.4 * nodes[1]


def test_the_wavelength_bounds_the_scatter_of_the_curvature():
    """White noise of 30 micrometres on a straight line leaves a curvature that scatters by 0.001/mm, as is bound."""
    x = np.arange(0.0, 400.0, SPACING_MM)
    points = np.column_stack((x, NOISE_MM * np.random.default_rng(3).normal(size=len(x))))
    found = smoothed(points, limit_um=1e4)
    assert found.wavelength_mm == usual_wavelength_mm(1e3 * NOISE_MM, SPACING_MM) == 11.0
    inner = found.points[40:-40]
    curvature = np.gradient(np.gradient(inner[:, 1], inner[:, 0]), inner[:, 0])
    assert np.std(curvature) == pytest.approx(1e-3, rel=0.3)
    assert usual_wavelength_mm(2.0, SPACING_MM) == 5.0
    assert usual_wavelength_mm(500.0, SPACING_MM) == 20.0


TAPE_MM = 72.0


@pytest.fixture
def file(tmp_path):
    """A worn S1002, measured from 3 mm above the flange's tip to the rim, whose file counts from the flange's back."""
    points = wheel("S1002").running_surface.sampled(spacing=0.5)
    points = points[(points[:, 0] > -60.0) | (points[:, 1] < -25.0)]
    points = points[points[:, 0] > -63.0]
    hollow = 0.4 * np.exp(-((points[:, 0] / 25.0) ** 2))
    points = points + np.column_stack([np.zeros(len(points)), hollow])
    path = tmp_path / "worn.whl"
    path.write_text(write_miniprof(points, "wheel", "worn", TAPE_MM), encoding="utf-8")
    return path


def bodies(file):
    """The wheel on every bundled body and on the plain one."""
    measured = read_profile(file, ReadOptions(smooth_mm=5.0))
    return [on_plain_body(measured), *(joined(measured, name).profile for name in ("S1002", "AAR-1B", "heavy-haul"))]


def test_the_joined_body_does_not_move_the_wheel(file):
    """On any body a measured wheel stands its file's tape distance from the inner face, and reaches the same shift."""
    wheels = bodies(file)
    assert [each.flange_back_mm for each in wheels] == [TAPE_MM] * 4
    shifts = []
    for each in wheels:
        axle = Wheelset(each, 1360.0, 460.0 + each.flange_height_mm)
        path = RigidGeometry.of(Track(rail("60E1"), 1435.0), axle).path(40.0)
        shifts.append((path.rail_level - 460.0 * np.sin(path.roll)).max())
    assert np.ptp(shifts) < 0.02
    assert all(f"{TAPE_MM:g} mm from the flange's back (from the file)" in each.certainty for each in wheels)


def test_tape_mm_is_a_key_of_cases(file):
    """``wheel_tape_mm`` moves the wheel on its axle, and the distance stands with its origin in the summary's words."""
    inputs = {"wheel": str(file), "wheel_body": "plain", "rail": "60E1", "gauge_mm": 1435.0}
    places = {}
    for tape in (None, 70.0, 74.0):
        axle = WheelsetTangentCase.from_values({**inputs, "wheel_tape_mm": tape}).wheelset()
        face = axle.placement("right").points(axle.wheel.running_surface.sampled(spacing=0.5))
        places[tape] = axle.back_to_back_mm / 2.0 + axle.wheel.flange_back_mm
        assert axle.wheel.flange_back_mm == (tape or TAPE_MM)
        # the file counts from the flange's back: its points stay where they are, the tape line moves on them
        assert face[:, 0].min() == pytest.approx(680.0 + TAPE_MM - 63.0, abs=0.6)
    assert places[74.0] - places[70.0] == 4.0


def test_a_back_that_is_not_measured_is_assumed_and_said(tmp_path):
    """A file that counts from the tape line and does not show the flange's back gets 70 mm, with a notice."""
    points = wheel("AAR-1B").running_surface.sampled(spacing=0.5)
    path = tmp_path / "half.txt"
    for head, expected in (("", 70.0), ("tape_mm: 77", 77.0)):
        header = f"unit: mm\nkind: wheel\norigin: tape\n{head}"
        np.savetxt(path, points[points[:, 0] > -66.0], "%.5f", header=header)
        measured = read_profile(path)
        assert on_plain_body(measured).flange_back_mm == expected
        assert any("flange's back is not measured" in each for each in measured.notices) == (not head)
    np.savetxt(path, points, "%.5f")
    assert read_profile(path, ReadOptions(unit="mm")).flange_back_mm == pytest.approx(77.7875, abs=0.01)
