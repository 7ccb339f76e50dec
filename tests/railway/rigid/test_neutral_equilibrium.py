"""Cylinders: an equilibrium that is neutral is called so, and the conicity below a jump is zero, not undefined."""

import numpy as np
import pytest

from flangeway.cases.rigid.rigid_case import find_geometry_case
from flangeway.cases.rigid.rigid_run import conicities_of, run_geometry
from flangeway.railway.profiles.bundled import REFERENCE_RAIL, wheel
from flangeway.railway.rigid.conicity import RollingRadiusDifference, equivalent_conicity

PUBLISHED = {1.0: 0.000, 1.4: 0.000, 2.4: 0.450, 3.0: 0.493, 4.0: 0.488, 5.0: 0.476}
"""Equivalent conicity of wheel I on rail A over the amplitude, EN 15302:2021, annex K, as A. Rohrbeck gives it."""


@pytest.fixture(scope="module")
def run(tmp_path_factory):
    """Wheel I on rail A of EN 15302 without lateral force, the wheel as measured points of four decimals."""
    file = tmp_path_factory.mktemp("wheel") / "i.txt"
    points = wheel("R-519-I").running_surface.sampled(spacing=0.2)
    rows = "\n".join(f"{x:.4f} {y:.4f}" for x, y in points)
    file.write_text(f"# unit: mm\n# kind: wheel\n# origin: tape\n# up: yes\n{rows}\n", encoding="utf-8")
    values = {"wheel": str(file), "wheel_body": "R-519-I", "rail": REFERENCE_RAIL, "rail_inclination": 0.05}
    values |= {"gauge_mm": 1435.1654, "maximum_lateral_mm": 6.0, "roll": "none"}
    return run_geometry("s1002-60e1", find_geometry_case("s1002-60e1", values))


def test_neutral_equilibrium(run):
    """A cylinder without lateral force is in neutral equilibrium, which is said with its range; nothing overturns."""
    status = run.equilibrium.status
    assert status.converged
    assert "neutral" in status.message
    low, high = run.equilibrium.position.neutral_mm
    assert low < -1.0
    assert high > 1.0
    assert run.equilibrium.position.motion.lateral_mm == pytest.approx(0.0, abs=1e-9)
    assert len(run.equilibrium.positions) == 1


def test_conicity_below_the_jump(run):
    """Below the jump the conicity is zero, beyond it the standard's within the 0.05 that it allows."""
    assert np.isfinite(run.conicities.integration).all()
    found = np.interp(list(PUBLISHED), run.conicities.amplitudes_mm, run.conicities.integration)
    assert np.abs(found - list(PUBLISHED.values())).max() < 0.05
    assert found[:2].tolist() == [0.0, 0.0]


@pytest.mark.parametrize("noise", [2e-5, -2e-5])
def test_noise_between_cylinders(noise):
    """A difference below 0.1 micrometres, of either sign, is none: the motion is not pushed away by rounding."""
    lateral = np.linspace(-6.0, 6.0, 241)
    difference = np.where(np.abs(lateral) < 2.0, noise * lateral, np.sign(lateral) * (np.abs(lateral) - 1.5))
    found = equivalent_conicity(RollingRadiusDifference(lateral, difference), [1.0, 1.8, 3.0])
    assert found[:2] == pytest.approx(0.0, abs=2e-5)
    assert found[2] > 0.05


def test_a_hump_has_no_conicity_and_says_so():
    """A difference of 0.1 mm that pushes the wheelset aside has no conicity there."""
    lateral = np.linspace(-6.0, 6.0, 241)
    hump = np.where(np.abs(lateral) < 2.0, -0.05 * lateral, np.sign(lateral) * (np.abs(lateral) - 2.1))
    found = conicities_of(RollingRadiusDifference(lateral, hump), 3.0)
    at = np.interp([1.9, 3.0], found.amplitudes_mm, found.integration)
    assert np.isnan(at).tolist() == [True, False]
    assert any("pushes the wheelset away" in notice for notice in found.notices)
