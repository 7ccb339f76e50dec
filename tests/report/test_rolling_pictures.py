"""Pictures of patches that roll: what is drawn are the numbers of the patch."""

from unittest.mock import Mock

import numpy as np
import pytest
from matplotlib.collections import QuadMesh
from matplotlib.quiver import Quiver

from flangeway.cases.wheelset.wheelset_quantities import WheelResult
from flangeway.contact.rolling.creepages import Creepages
from flangeway.contact.rolling.exact_rolling import roll
from flangeway.contact.rolling.rolling_result import NO_CONTACT, SLIPS
from flangeway.exact.shakedown import shakedown_limits
from flangeway.railway.wheelset.spatial_result import SpatialResult
from flangeway.report.rolling.rolling_maps import ShownRolling, rolling_figure
from flangeway.report.rolling.shakedown_figure import shakedown_figure
from studies.rolling.rolling_cases import elliptic


@pytest.fixture(scope="module")
def found():
    """An ellipse of 16 by 20 cells under all creepages, at 2 m/s for each unit of speed."""
    return roll(elliptic(8.0, 5.0, 100e3, (16, 20)), Creepages(-0.5e-3, -0.6e-3, -2e-4, speed=2.0))


def shown(found, sign=1.0):
    return ShownRolling("left", found, 20.0, 1.0, sign)


@pytest.mark.parametrize("sign", [1.0, -1.0])
def test_maps_show_states_slip_and_power_where_they_are(found, sign):
    """A row of three maps: states, slip velocities in m/s and power in W/mm^2, mirrored with the side."""
    figure = rolling_figure([shown(found, sign)])
    maps = [next(each for each in axes.collections if isinstance(each, QuadMesh)) for axes in figure.axes[:3]]
    states, slip, power = (np.ma.filled(each.get_array(), 0.0).T for each in maps)
    assert (states == found.states).all()
    assert slip.max() == pytest.approx(10.0 * np.linalg.norm(found.slip_velocities, axis=2).max())
    areas = found.contact.areas
    total = np.where(found.states == NO_CONTACT, 0.0, np.nan_to_num(power))
    assert (total * areas).sum() == pytest.approx(10.0 * found.frictional_power, rel=1e-9)
    # lengths along the surface run to the left for the sign of the left side
    assert np.sign(np.diff(maps[0].get_coordinates()[0, :, 0])).mean() == -sign
    slipping = 100.0 * (found.states == SLIPS).sum() / (found.states != NO_CONTACT).sum()
    assert f"{slipping:.0f} % slips" in figure.axes[0].get_title()
    arrows = next(each for each in figure.axes[0].collections if isinstance(each, Quiver))
    assert np.sign(arrows.U.sum()) == -sign * np.sign(found.across)
    assert np.sign(arrows.V.sum()) == np.sign(found.along)
    assert len(arrows.U) > 50


def test_patches_lie_in_the_shakedown_diagram():
    """Points at (creep force over normal force, pressure over k), named in the legend; limits are the theory's."""
    patches = [("left", 0.1, 900.0), ("right, tread", 0.27, 1300.0), ("right, flange", 0.27, 1290.0)]
    axes = shakedown_figure(patches, 510.0).axes[0]
    points = {line.get_label(): line.get_xydata().ravel() for line in axes.lines if line.get_marker() != "None"}
    assert list(points) == ["left: 900 MPa", "right, tread: 1300 MPa", "right, flange: 1290 MPa"]
    for (_, used, pressure), found in zip(patches, points.values(), strict=True):
        assert found == pytest.approx([used, pressure * np.sqrt(3.0) / 510.0])
    drawn = [line.get_xydata() for line in axes.lines if line.get_marker() == "None" and len(line.get_xydata())]
    assert len(drawn) == 6
    traction, pressure = drawn[1].T
    assert pressure == pytest.approx(shakedown_limits("point", traction).shakedown)


def test_nadals_criterion_is_that_of_the_wheel_whose_flange_touches():
    """L/V over Nadal's limit, None for a wheel whose flange does not touch, and the statement."""
    for ratio, touches, said in (
        (0.6, True, "exceeded (120 %)"),
        (0.095, True, "not exceeded (19 %)"),
        (0.6, False, None),
    ):
        result = Mock(spec=SpatialResult, rolling=(1,))
        result.nadal_limit.return_value, result.flange_touches.return_value = 0.5, touches
        result.lateral_over_vertical.return_value = ratio
        wheel = WheelResult(result, "right", [])
        assert wheel.nadal_fraction == (pytest.approx(ratio / 0.5) if touches else None)
        assert wheel.nadal_words == said
