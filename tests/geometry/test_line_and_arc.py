"""Lines, arcs and closed splines against elementary geometry."""

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from flangeway import triangulate
from flangeway.errors import InputError
from flangeway.geometry import Arc, Line, Outline, Placement, Spline, polygon, square
from flangeway.mesh import PolyMesh

QUARTER = Arc((2.0, 0.0), (0.0, 2.0), (0.0, 0.0), True)
LONG_WAY = Arc((2.0, 0.0), (0.0, 2.0), (0.0, 0.0), False)
SEGMENTS = [Line((1.0, 2.0), (4.0, -2.0)), QUARTER, LONG_WAY]


@st.composite
def arcs(draw):
    radius = draw(st.floats(0.01, 1e3))
    start = draw(st.floats(-math.pi, math.pi))
    sweep = draw(st.floats(0.01, 6.2)) * draw(st.sampled_from([-1.0, 1.0]))
    x, y = draw(st.floats(-1e3, 1e3)), draw(st.floats(-1e3, 1e3))
    ends = [(x + radius * math.cos(a), y + radius * math.sin(a)) for a in (start, start + sweep)]
    return Arc(ends[0], ends[1], (x, y), sweep > 0), radius, sweep


def test_a_3_4_5_line_has_length_5():
    """A line over three and down four is five long and points that way."""
    line = SEGMENTS[0]
    assert line.length == 5.0
    np.testing.assert_allclose(line.tangent([0.0, 1.0]), [[0.6, -0.8]] * 2, rtol=1e-15)
    np.testing.assert_allclose(line.normal(0.3), [[-0.8, -0.6]], rtol=1e-15)


def test_arc_both_ways_round():
    """Between two points of a circle the two arcs sweep a quarter and three quarters."""
    assert QUARTER.sweep == pytest.approx(math.pi / 2, rel=1e-15)
    assert LONG_WAY.sweep == pytest.approx(-3 * math.pi / 2, rel=1e-15)
    assert QUARTER.curvature == 0.5
    assert LONG_WAY.curvature == -0.5


def test_normals_point_right_of_travel():
    """A counter-clockwise arc has its normals away from the centre, a clockwise one towards it."""
    s = np.linspace(0.0, 1.0, 7)
    np.testing.assert_allclose(QUARTER.normal(s), QUARTER.point(s) / 2.0, atol=1e-15)
    np.testing.assert_allclose(LONG_WAY.normal(s), -LONG_WAY.point(s) / 2.0, atol=1e-15)


@pytest.mark.parametrize("segment", SEGMENTS)
def test_tangent_is_the_derivative_of_the_point(segment):
    """The tangent times the length is the derivative by the parameter (central difference)."""
    s, step = np.linspace(0.1, 0.9, 9), 1e-6
    slope = (segment.point(s + step) - segment.point(s - step)) / (2 * step)
    np.testing.assert_allclose(segment.tangent(s) * segment.length, slope, atol=1e-8)


@pytest.mark.parametrize("segment", SEGMENTS)
def test_ends_are_exact(segment):
    """The parameters 0 and 1 give the ends to the last bit, so that neighbours stay joined."""
    assert np.array_equal(segment.point([0.0, 1.0]), [segment.start, segment.end])


@given(arcs())
def test_bounds_hold_every_point_tightly(case):
    """The box of an arc holds its points, and each side of the box is touched."""
    arc, radius, _ = case
    points = arc.point(np.linspace(0.0, 1.0, 4001))
    low, high = arc.bounds
    assert np.all(points >= low - 1e-9 * radius)
    assert np.all(points <= high + 1e-9 * radius)
    np.testing.assert_allclose(points.min(axis=0), low, atol=1e-5 * radius)
    np.testing.assert_allclose(points.max(axis=0), high, atol=1e-5 * radius)


@given(arcs())
def test_length_is_radius_times_angle(case):
    """The length of an arc is its radius times its opening."""
    arc, radius, sweep = case
    assert arc.length == pytest.approx(radius * abs(sweep), rel=1e-8)


@given(arcs(), st.floats(-3e3, 3e3), st.floats(-3e3, 3e3))
def test_closest_point_of_an_arc_beats_a_fine_sampling(case, x, y):
    """No sampled point of an arc is nearer than the closest point."""
    arc, radius, _ = case
    s, distance = arc.closest([(x, y)])
    sampled = np.hypot(*(arc.point(np.linspace(0, 1, 2001)) - [x, y]).T)
    assert distance[0] <= sampled.min() + 1e-9 * (radius + abs(x) + abs(y))
    assert np.hypot(*(arc.point(s)[0] - [x, y])) == distance[0]


def test_closest_point_of_a_line_stays_on_it():
    """Beyond the end of a line its end is closest; beside it the foot of the perpendicular."""
    s, distance = Line((0.0, 0.0), (4.0, 0.0)).closest([(7.0, 4.0), (1.0, 2.0), (-3.0, 0.0)])
    assert np.array_equal(s, [1.0, 0.25, 0.0])
    assert np.array_equal(distance, [5.0, 2.0, 3.0])


@pytest.mark.parametrize("segment", SEGMENTS)
def test_reversed_runs_through_the_same_points(segment):
    """A reversed segment has the same points at the parameters 1 - s and opposite curvature."""
    s = np.linspace(0.0, 1.0, 5)
    back = segment.reversed()
    np.testing.assert_allclose(back.point(1.0 - s), segment.point(s), atol=1e-14)
    assert back.curvature == -segment.curvature


@pytest.mark.parametrize("segment", SEGMENTS)
@pytest.mark.parametrize("mirrored", [False, True])
def test_transformed_commutes_with_point(segment, mirrored):
    """To place a segment and take a point is to take the point and place it."""
    placement = Placement(0.7, (3.0, -1.0), mirrored)
    s = np.linspace(0.0, 1.0, 9)
    moved = segment.transformed(placement)
    np.testing.assert_allclose(moved.point(s), placement.points(segment.point(s)), atol=1e-14)


@pytest.mark.parametrize("segment", SEGMENTS)
def test_split_pieces_make_the_whole(segment):
    """The pieces of a split join exactly, and their lengths are the shares asked for."""
    pieces = segment.split([0.75, 0.25])
    assert [p.end for p in pieces[:-1]] == [p.start for p in pieces[1:]]
    assert (pieces[0].start, pieces[-1].end) == (segment.start, segment.end)
    shares = [p.length / segment.length for p in pieces]
    np.testing.assert_allclose(shares, [0.25, 0.5, 0.25], rtol=1e-13)


def test_arc_of_a_file_with_rounded_numbers_becomes_consistent():
    """An arc with six decimals keeps its ends and gets one centre equally far from both."""
    arc = Arc((17.78, 185.114436), (28.334359, 182.508009), (15.5575, 153.442319), False)
    radii = [math.dist(end, arc.centre) for end in (arc.start, arc.end)]
    assert radii[0] == pytest.approx(radii[1], rel=1e-15)
    assert arc.radius == pytest.approx(31.75, abs=2e-6)
    assert math.dist(arc.centre, (15.5575, 153.442319)) < 1e-5


@pytest.mark.parametrize(
    ("make", "word"),
    [
        (lambda: Line((1.0, 1.0), (1.0, 1.0)), "zero length"),
        (lambda: Line((1.0, float("nan")), (1.0, 1.0)), "nan"),
        (lambda: Line((1.0, 2.0, 3.0), (1.0, 1.0)), "shape"),
        (lambda: Arc((1.0, 0.0), (1.0, 0.0), (0.0, 0.0), True), "zero length"),
        (lambda: Arc((1.0, 0.0), (0.0, 1.1), (0.0, 0.0), True), "radii"),
        (lambda: Arc((1.0, 0.0), (0.0, 1.0), (0.0, float("inf")), True), "inf"),
        (lambda: Line((0.0, 0.0), (1.0, 0.0)).split([0.0, 0.5]), "split"),
    ],
)
def test_wrong_segments_are_refused(make, word):
    """A segment without length, with NaN, or with two radii is refused, and the message says so."""
    with pytest.raises(InputError, match=word):
        make()


def hole(n: int, closing: float) -> tuple[Outline, Spline]:
    """A polygon on the unit circle, and the spline through its corners with a gap at its end."""
    angle = np.linspace(0.0, 2.0 * np.pi, n + 1)
    points = np.column_stack((np.cos(angle), np.sin(angle)))
    points[-1] = points[0] + (0.0, closing)
    return polygon(points[:-1]), Spline(points)


@pytest.mark.parametrize("gap", [0.0, 1.1e-16, -2.4e-16, 1e-13])
def test_ends_that_differ_by_round_off(gap: float) -> None:
    """No edge of the mesh leaves the circle by more than the spline does, where one ran through the hole."""
    corners, spline = hole(24, gap)
    assert spline.closed
    mesh: PolyMesh = triangulate(square(6.0), size=0.8, holes=[corners], outline=[square(6.0), spline])
    assert mesh.curves is not None
    assert np.linalg.norm(mesh.curves.points([0.25, 0.5, 0.75]), axis=2) == pytest.approx(1.0, abs=2e-5)


def test_a_moved_spline_stays_closed() -> None:
    """Far from the origin, where placed ends may differ in their last digits, it is closed too."""
    _, spline = hole(9, 0.0)
    for angle in np.linspace(0.1, 6.0, 7):
        assert spline.transformed(Placement(float(angle), (1e3, -3e3))).closed


def test_a_true_gap_is_open() -> None:
    """A gap above round-off is a gap."""
    assert not hole(9, 1e-9)[1].closed
