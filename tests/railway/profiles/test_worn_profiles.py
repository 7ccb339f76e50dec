"""A worn wheel on a worn rail, measured with 30 micrometres of noise: from files to the equilibrium."""

from functools import cache

import numpy as np
import pytest

from flangeway.cases import WheelsetCurveCase, WheelsetTangentCase
from flangeway.railway.profiles.bundled import rail, wheel
from flangeway.railway.profiles.formats.miniprof import write_miniprof
from flangeway.railway.profiles.formats.simpack import write_simpack
from flangeway.railway.profiles.smoothing import smoothed, usual_wavelength_mm
from flangeway.railway.track.placements import Track, Wheelset, WheelsetPosition

NOISE_MM = 0.03
SPACING_MM = 0.25
WEAR_MM = 1.0
LATERALS_MM = (-2.0, 0.0, 2.0, 4.0, 6.0)


def across(points):
    """Unit normals (n, 2) to the left of a row of points."""
    along = np.gradient(points, axis=0)
    return np.column_stack((-along[:, 1], along[:, 0])) / np.hypot(*along.T)[:, None]


def worn_head():
    """A 136RE's head from its top, 0.8 mm worn at the gauge corner and 0.2 mm on the crown."""
    profile = rail()
    points = profile.running_surface.sampled(spacing=SPACING_MM) - [0.0, profile.outline.bounds()[1, 1]]
    depth = 0.8 * np.exp(-(((points[:, 0] + 30.0) / 6.0) ** 2)) + 0.2 * np.exp(-((points[:, 0] / 20.0) ** 2))
    return points + across(points) * (depth * (points[:, 1] > -20.0))[:, None]


def hollow_tread():
    """An AAR-1B's running surface, 1 mm hollow: the head has worn its shape into it at several lateral motions."""
    track, wheelset = Track(rail()), Wheelset(wheel())
    points = wheelset.wheel.running_surface.sampled(spacing=SPACING_MM)
    on_track = track.placement("right").points(worn_head() + np.array([0.0, rail().outline.bounds()[1, 1]]))
    height = points[:, 1].copy()
    reached = (points[:, 0] > -40.0) & (points[:, 0] < 55.0)
    for lateral in LATERALS_MM:
        at = WheelsetPosition(lateral, 0.0, 0.0).placement(wheelset, "right").inverse().points(on_track)
        at = at[np.argsort(at[:, 0])]
        rail_height = np.interp(points[:, 0], at[:, 0], at[:, 1])
        lowered = (points[:, 1] - rail_height)[reached].min()
        height = np.where(reached, np.maximum(height, rail_height + lowered + WEAR_MM), height)
    window = np.hanning(23) / np.hanning(23).sum()
    depth = np.convolve(np.pad(height - points[:, 1], 11, mode="edge"), window, "valid")
    return points + np.column_stack((np.zeros(len(points)), depth))


def noisy(points, seed):
    """Points moved across their curve by white noise."""
    return points + across(points) * NOISE_MM * np.random.default_rng(seed).normal(size=(len(points), 1))


@pytest.fixture(scope="module")
def files(tmp_path_factory):
    """Files of the pair, without and with noise, by ending."""
    folder = tmp_path_factory.mktemp("worn")
    found = {}
    for name, head, tread in (
        ("new", worn_head(), hollow_tread()),
        ("worn", noisy(worn_head(), 1), noisy(hollow_tread(), 2)),
    ):
        texts = {
            ".ban": write_miniprof(head, "rail", name),
            ".prr": write_simpack(head, "rail", name),
            ".whl": write_miniprof(tread, "wheel", name, wheel().flange_back_mm),
            ".prw": write_simpack(tread, "wheel", name),
        }
        for ending, text in texts.items():
            file = folder / f"{name}{ending}"
            file.write_text(text, encoding="utf-8")
            found[name, ending] = file
    return found


@pytest.fixture(scope="module")
def runs(files):
    """Function that solves a case once: tangent without and with noise, curve with noise."""
    cases = {
        "smooth": (WheelsetTangentCase, "new", ".whl", ".ban"),
        "noisy": (WheelsetTangentCase, "worn", ".whl", ".ban"),
        "curve": (WheelsetCurveCase, "worn", ".prw", ".prr"),
    }

    @cache
    def solved(name):
        case, worn, wheel_ending, rail_ending = cases[name]
        values = {"wheel": str(files[worn, wheel_ending]), "rail": str(files[worn, rail_ending]), "size_scale": 3.0}
        return case.from_values(values).run()

    return solved


@pytest.mark.ci
@pytest.mark.parametrize("name", ["smooth", "noisy", "curve"])
def test_the_chain_ends_in_equilibrium(name, runs):
    """From the files to the equilibrium: converged, errors below 1e-10, contact forces that carry the load."""
    run = runs(name)
    assert run.result.status.converged, run.result.status.message
    assert run.result.equilibrium.residuals.equilibrium_residual < 1e-10
    along, onto = run.result.model.problem.load.in_track
    total = sum(patch.force_on_wheel_N for patch in run.result.patches)
    assert total == pytest.approx([-along, onto], rel=1e-8, abs=1.0)


def test_a_hollow_tread_conforms(runs):
    """The worn wheel touches at one wide place: more than 9 mm half width, where the new pair has 6.4 mm."""
    patches = runs("smooth").result.patches
    assert [patch.side for patch in patches] == ["left", "right"]
    assert min(patch.pressure.half_width for patch in patches) > 9.0


def test_noise_is_no_wear(runs):
    """With 30 micrometres of noise the contacts are as many, 1.5 mm about their places, their pressure within 20 %."""
    smooth, noise = (runs(name).result.patches for name in ("smooth", "noisy"))
    assert [patch.side for patch in noise] == [patch.side for patch in smooth]
    for one, other in zip(smooth, noise, strict=True):
        assert other.rail_point_mm == pytest.approx(one.rail_point_mm, abs=1.5)
        assert other.pressure.pressures.max() == pytest.approx(one.pressure.pressures.max(), rel=0.2)


def test_the_run_says_how_the_noise_was_smoothed(runs):
    """What was done to the files stands among the assumptions of the run, with wheel and rail named."""
    said = [line for line in runs("noisy").summary["assumptions"] if "The noise is" in line]
    assert len(said) == 2
    noise = [float(line.split("The noise is ")[1].split(" micrometres")[0]) for line in said]
    assert noise == pytest.approx([1e3 * NOISE_MM] * 2, rel=0.2)
    assert "AAR-1B" in said[0]
    assert "136RE" in said[1]


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
