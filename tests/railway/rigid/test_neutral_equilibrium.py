"""Cylinders: an equilibrium that is neutral is called so, and the conicity below a jump is zero, not undefined."""

import math

import numpy as np
import pytest

from flangeway.cases.rigid.rigid_case import find_geometry_case
from flangeway.cases.rigid.rigid_run import conicities_of, run_geometry
from flangeway.railway.rigid.conicity import RollingRadiusDifference, equivalent_conicity

PUBLISHED = {1.0: 0.000, 1.4: 0.000, 2.4: 0.450, 3.0: 0.493, 4.0: 0.488, 5.0: 0.476}
"""Equivalent conicity of wheel I on rail A over the amplitude, EN 15302:2021, annex K, as A. Rohrbeck gives it."""


def heights(y, pieces):
    """Heights, up, of a profile of circles (first, last, centre y, centre z, radius, sign) and lines (.., z, slope)."""
    z = np.full(len(y), np.nan)
    for first, last, *numbers in pieces:
        inside = (y >= first) & (y <= last)
        if len(numbers) == 4:
            middle, height, radius, sign = numbers
            z[inside] = height + sign * np.sqrt(radius**2 - (y[inside] - middle) ** 2)
        else:
            z[inside] = numbers[0] + numbers[1] * y[inside]
    return -z


WHEEL_I = (
    (-69.9, -62.7647, -49.5, 9.51929, 20.5, 1.0),
    (-62.7647, -49.6625, -55.0, 16.00054, 12.0, 1.0),
    (-49.6625, -39.764, -58.5583, 8.83545, 20.0, 1.0),
    (-39.764, -39.0486, -93.5767, -2.7475),
    (-39.0486, -29.9231, -25.8929, 18.49733, 14.0, -1.0),
    (-29.9231, 5.0, 5.0, math.sqrt(14375.0), 120.0, -1.0),
    (5.0, 30.0, math.sqrt(14375.0) - 120.0, 0.0),
    (30.0, 60.0, 1.89679, -0.0667),
)
RAIL_A = (
    (-32.634, -23.2401, -19.63949, 15.899044, 13.0, -1.0),
    (-23.2401, -7.8749, -1.0825, 80.277908, 80.0, -1.0),
    (-7.8749, 13.0989, 17.5966, 299.48349, 300.0, -1.0),
    (13.0989, 28.6709, 14.29829, 79.508225, 80.0, -1.0),
    (28.6709, 39.2705, 26.33535, 13.598369, 13.0, -1.0),
)


@pytest.fixture
def run(tmp_path):
    """Wheel I on rail A of EN 15302 as points of four decimals, without lateral force."""
    files = {}
    for kind, origin, pieces, ends in (
        ("wheel", "tape", WHEEL_I, (-69.6, 59.9)),
        ("rail", "top", RAIL_A, (-32.6, 39.2)),
    ):
        y = np.arange(*ends, 0.2)
        rows = "\n".join(f"{a:.4f} {b:.4f}" for a, b in zip(y, heights(y, pieces), strict=True))
        files[kind] = str(tmp_path / f"{kind}.txt")
        header = f"# unit: mm\n# kind: {kind}\n# origin: {origin}\n# up: yes\n"
        (tmp_path / f"{kind}.txt").write_text(header + rows + "\n", encoding="utf-8")
    values = {**files, "rail_inclination": 0.0, "gauge_mm": 1435.16, "maximum_lateral_mm": 6.0, "roll": "none"}
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
