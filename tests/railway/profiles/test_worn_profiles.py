"""A worn wheel on a worn rail, measured with 30 micrometres of noise: from files to the equilibrium."""

from functools import cache

import numpy as np
import pytest

from benchmarks import worn
from flangeway.cases import WheelsetCurveCase, WheelsetTangentCase
from flangeway.railway.profiles.smoothing import smoothed, usual_wavelength_mm

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
