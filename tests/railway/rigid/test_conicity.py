"""Equivalent conicity: cones, closed forms of waves, circular profiles, and cylinders, whose equilibrium is neutral."""

import math

import numpy as np
import pytest
from scipy.special import ellipk, gamma

from flangeway.cases.rigid_run import conicities_of, find_geometry_case, run_geometry
from flangeway.errors import InputError
from flangeway.railway.profiles.bundled import REFERENCE_RAIL, wheel
from flangeway.railway.rigid.conicity import (
    RollingRadiusDifference,
    conicity_by_regression,
    equivalent_conicity,
    read_rolling_radius_difference,
)
from flangeway.railway.rigid.rigid_geometry import RigidGeometry
from flangeway.railway.rigid.rigid_side import RigidCurve, RigidSide

AMPLITUDES = np.array([0.1, 1.0, 3.0, 7.5])


@pytest.mark.parametrize("points", [[-8.0, 8.0], [-9.0, -7.5, 8.0]])
def test_a_cone_has_its_own_conicity(points):
    """Twice the cone times the lateral motion gives exactly the cone, for all amplitudes, points and methods."""
    lateral = np.array(points)
    difference = RollingRadiusDifference(lateral, 2.0 * 0.05 * lateral)
    assert equivalent_conicity(difference, AMPLITUDES) == pytest.approx(0.05, rel=1e-10)
    assert conicity_by_regression(difference, AMPLITUDES) == pytest.approx(0.05, rel=1e-10)


def test_two_slopes_in_closed_form():
    """A difference with a weak slope to the left and a strong one to the right: two quarter waves each."""
    weak, strong = 0.04, 0.6
    difference = RollingRadiusDifference([-20.0, 0.0, 20.0], [-20.0 * weak, 0.0, 20.0 * strong])
    half = 0.5 * math.pi * (1.0 / math.sqrt(weak) + 1.0 / math.sqrt(strong))
    assert equivalent_conicity(difference, [1.0, 5.0]) == pytest.approx(0.5 * (math.pi / half) ** 2, rel=1e-12)


def test_a_cubic_difference_in_closed_form():
    """A difference of the third power has a wave whose length is an elliptic integral, by which the conicity is known.

    The half wave of y'' = -k y^3 with amplitude a is 2 / a * sqrt(2 / k) * integral of dt / sqrt(1 - t^4) from 0 to 1.
    """
    factor, amplitude = 0.02, 4.0
    lateral = np.linspace(-6.0, 6.0, 6001)
    quarter = math.sqrt(math.pi) * gamma(1.25) / gamma(0.75)
    assert quarter == pytest.approx(ellipk(-1.0))
    half = 2.0 * math.sqrt(2.0 / factor) / amplitude * quarter
    found = equivalent_conicity(RollingRadiusDifference(lateral, factor * lateral**3), [amplitude])
    assert found == pytest.approx(0.5 * (math.pi / half) ** 2, rel=1e-6)
    # least squares of y^3 over the width: slope 3 a^2 / 5
    regression = conicity_by_regression(RollingRadiusDifference(lateral, factor * lateral**3), [amplitude])
    assert regression == pytest.approx(0.5 * factor * 3.0 * amplitude**2 / 5.0, rel=1e-6)


def test_jumps_in_closed_form():
    """A difference that only jumps, from -d to d, accelerates evenly: half a wave takes 2 sqrt(2 a / d)."""
    jump, amplitude = 0.8, 3.0
    difference = RollingRadiusDifference([-9.0, -1e-9, 1e-9, 9.0], [-jump, -jump, jump, jump])
    half = 2.0 * math.sqrt(2.0 * amplitude / jump)
    assert equivalent_conicity(difference, [amplitude]) == pytest.approx(0.5 * (math.pi / half) ** 2, rel=1e-6)


def test_an_offset_moves_the_middle_only():
    """Unequal wheel diameters shift the place about which cones swing, not the wave."""
    lateral = np.linspace(-12.0, 12.0, 241)
    difference = RollingRadiusDifference(lateral, 0.1 * lateral + 0.3)
    assert difference.centred_mm == pytest.approx(-3.0)
    assert equivalent_conicity(difference, [1.0, 5.0]) == pytest.approx(0.05, rel=1e-10)


def test_cones_the_wrong_way_round_do_not_swing():
    """A difference that falls through zero is refused."""
    with pytest.raises(InputError, match="grow through zero"):
        equivalent_conicity(RollingRadiusDifference([-8.0, 8.0], [0.4, -0.4]), [3.0])


def circle(radius, x, *, centre=(0.0, 0.0)):
    """Upper half of a circle about (x0, y0), as a graph over x."""
    height = np.sqrt(radius**2 - (x - centre[0]) ** 2)
    return x, centre[1] + height, -(x - centre[0]) / height


@pytest.mark.parametrize(("wheel_radius", "rail_radius"), [(350.0, 300.0), (330.0, 80.0)])
def test_circular_profiles_agree_with_the_known_formula(wheel_radius, rail_radius):
    """Wheels hollow by one circle on rails of one circle have the conicity of Wickens' formula for small motions.

    A. H. Wickens, "Fundamentals of Rail Vehicle Dynamics" (2003): with radii R' of the wheel and R of the rail, contact
    angle d0, half distance l of the contacts and rolling radius r0, ``R' d0 / (R' - R) * (l + R d0) / (l - r0 d0)``.
    """
    angle, half_distance, radius = 0.01, 750.0, 460.0
    x = half_distance + np.linspace(-40.0, 40.0, 1601)
    # both circles have the slope of the contact angle at the same point
    rail_centre = half_distance + rail_radius * math.sin(angle), -rail_radius * math.cos(angle)
    wheel_centre = half_distance + wheel_radius * math.sin(angle), -radius - wheel_radius * math.cos(angle)
    wheel_curve = RigidCurve.from_graph(*circle(wheel_radius, x, centre=wheel_centre))
    head = half_distance + np.linspace(-38.0, 38.0, 1521)
    rail_curve = RigidCurve.from_graph(*circle(rail_radius, head, centre=rail_centre))
    side = RigidSide(wheel_curve, rail_curve)
    locus = RigidGeometry(side, side, radius).locus(np.linspace(-0.25, 0.25, 101))
    found = equivalent_conicity(RollingRadiusDifference.of(locus), [0.2])[0]
    steering = wheel_radius * angle / (wheel_radius - rail_radius)
    expected = steering * (half_distance + rail_radius * angle) / (half_distance - radius * angle)
    assert found == pytest.approx(expected, rel=0.01)


def test_columns_are_taken_by_their_names(tmp_path):
    """Of the table of `flangeway geometry` lateral displacement and difference are read, with their unit."""
    lateral = np.linspace(-8.0, 8.0, 33)
    rows = [f"{y},-0.5,{y / 9:.9f},{0.1 * y:.9f},,3" for y in lateral]
    file = tmp_path / "table.csv"
    head = "lateral_mm,vertical_mm,roll_mrad,rolling_radius_difference_mm,left_next_gap_mm,curvature_per_m"
    file.write_text("\n".join([head, *rows]), encoding="utf-8")
    found = read_rolling_radius_difference(file)
    assert np.allclose(found.lateral_mm, lateral)
    assert np.allclose(found.difference_mm, 0.1 * lateral)
    file.write_text("case,lateral_mm,computed_mm\nA,0,1\nA,1,2\n", encoding="utf-8")
    with pytest.raises(InputError, match="line 3: 'A,1,2'") as raised:
        read_rolling_radius_difference(file)
    assert "lateral displacement and rolling radius difference" in raised.value.allowed


PUBLISHED = {1.0: 0.000, 1.4: 0.000, 2.4: 0.450, 3.0: 0.493, 4.0: 0.488, 5.0: 0.476}
"""Equivalent conicity of wheel I on rail A over the amplitude, EN 15302:2021, annex K, as A. Rohrbeck gives it."""


@pytest.fixture(scope="module")
def run(tmp_path_factory):
    """Wheel I on rail A of EN 15302 without lateral force, the wheel as measured points of four decimals."""
    file = tmp_path_factory.mktemp("wheel") / "i.txt"
    points = wheel("R-519-I").running_surface.sampled(spacing=0.2)
    rows = "\n".join(f"{x:.4f} {y:.4f}" for x, y in points)
    file.write_text(f"# unit: mm\n# kind: wheel\n# origin: tape\n# up: yes\n{rows}\n", encoding="utf-8")
    values = {"wheel": {"file": str(file), "body": "R-519-I"}, "rail": REFERENCE_RAIL, "inclination": 0.05}
    values |= {"gauge_mm": 1435.164446, "maximum_lateral_mm": 6.0, "roll": "none"}
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
    """Below the jump the conicity is zero to the rounding of points, beyond it the standard's within its 0.05."""
    assert np.isfinite(run.conicities.integration).all()
    found = np.interp(list(PUBLISHED), run.conicities.amplitudes_mm, run.conicities.integration)
    assert np.abs(found - list(PUBLISHED.values())).max() < 0.05
    assert found[:2] == pytest.approx(0.0, abs=2e-5)  # radii of points of four decimals differ by nanometres


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
