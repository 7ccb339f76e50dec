"""Rigid curves: the closed formulas of lines and arcs against the segments they come from."""

import math

import numpy as np
import pytest

from flangeway.errors import InputError
from flangeway.geometry import Arc, Contour, Line, Placement
from flangeway.railway.profiles.bundled import rail, wheel
from flangeway.railway.profiles.running_graphs import STEEPEST_RAD
from flangeway.railway.rigid.rigid_curve import RigidCurve


@pytest.fixture(params=["rail", "wheel"])
def contour(request):
    if request.param == "rail":
        profile = rail("136RE")
        return profile.outline.part(profile.head_names)
    profile = wheel("AAR-1B")
    return profile.outline.part(profile.running_names)


def test_points_along_the_curve_are_on_the_contour(contour):
    """Every place along a rigid curve is a point of its contour, with the contour's tangent and curvature."""
    curve = RigidCurve.from_contour(contour)
    places = curve.at(np.linspace(0.0, curve.length, 997))
    number, parameter, distance = contour.closest(np.column_stack((places.x, places.y)))
    assert distance.max() < 1e-11
    for i in range(0, 997, 13):
        segment = contour.segments[number[i]]
        tangent = segment.tangent(parameter[i])[0]
        assert abs(tangent[0] * np.sin(places.angle[i]) - tangent[1] * np.cos(places.angle[i])) < 1e-5
        sign = 1.0 if tangent[0] * np.cos(places.angle[i]) > 0.0 else -1.0
        if 1e-6 < parameter[i] < 1.0 - 1e-6:
            assert places.curvature[i] == pytest.approx(sign * segment.curvature)


def test_the_curve_as_a_graph_is_the_curve(contour):
    """Height, angle and curvature over x agree with those along the curve."""
    curve = RigidCurve.from_contour(contour)
    along = curve.at(np.linspace(0.0, curve.length, 1001)[1:-1])
    over = curve.over(along.x)
    # near its steep ends an error of x counts sixty times in y
    assert np.abs(over.y - along.y).max() < 1e-10
    assert np.abs(over.angle - along.angle).max() < 1e-6


def test_x_grows_and_steep_parts_are_left_out(contour):
    """A rigid curve runs from the gauge side to the field side and is nowhere steeper than the limit."""
    for given in (contour, contour.reversed()):
        curve = RigidCurve.from_contour(given)
        assert (np.diff(curve.joints) > 0.0).all()
        places = curve.at(np.linspace(0.0, curve.length, 5001))
        assert np.abs(places.angle).max() <= STEEPEST_RAD + 1e-12


def test_a_graph_is_met_by_arcs_with_its_slopes():
    """Arcs through the points of a sine leave it by no more than the third power of their length."""
    errors = []
    for n_points in (41, 81):
        x = np.linspace(-2.0, 2.0, n_points)
        curve = RigidCurve.from_graph(x, np.sin(x), np.cos(x))
        between = np.linspace(-1.99, 1.99, 2000)
        errors.append(np.abs(curve.over(between).y - np.sin(between)).max())
    assert errors[0] < 2e-4
    assert errors[0] / errors[1] > 7.0


def test_a_placed_contour_is_turned_before_it_is_cut():
    """A vertical line that is turned by 10 degrees is not vertical any more and stays."""
    upright = Contour.from_segments([Line((0.0, 0.0), (0.0, 1.0)), Line((0.0, 1.0), (5.0, 1.0))], ["side", "top"])
    assert len(RigidCurve.from_contour(upright).lengths) == 1
    assert len(RigidCurve.from_contour(upright, Placement(-math.radians(10.0))).lengths) == 2


def test_an_overhang_is_refused():
    """A surface that turns back between two running parts is an error that names the place."""
    hook = [
        Line((0.0, 0.0), (10.0, 0.0)),
        Arc((10.0, 0.0), (10.0, 4.0), (10.0, 2.0), True),
        Line((10.0, 4.0), (6.0, 4.0)),
        Line((6.0, 4.0), (6.0, 8.0)),
        Line((6.0, 8.0), (20.0, 8.0)),
    ]
    with pytest.raises(InputError, match="overhang"):
        RigidCurve.from_contour(Contour.from_segments(hook, ["a", "b", "c", "d", "e"]))


def test_a_wall_has_no_running_surface():
    """A vertical line alone is refused."""
    with pytest.raises(InputError, match="running surface"):
        RigidCurve.from_contour(Contour.from_segments([Line((0.0, 0.0), (0.0, 1.0))], ["wall"]))
