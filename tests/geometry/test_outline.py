"""Outlines against closed-form section properties, placements as a group of motions, and what is refused."""

import itertools
import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from flangeway.errors import InputError
from flangeway.geometry import (
    Arc,
    Contour,
    Line,
    Outline,
    Placement,
    circle,
    half_disc,
    polygon,
    rectangle,
)

HALF_DISC = Outline.from_segments(
    [Line((-2.0, 0.0), (2.0, 0.0)), Arc((2.0, 0.0), (-2.0, 0.0), (0.0, 0.0), True)],
    ["cut", "round"],
)


@st.composite
def star_polygons(draw):
    n = draw(st.integers(3, 12))
    radii = np.array(draw(st.lists(st.floats(0.5, 2.0), min_size=n, max_size=n)))
    angles = 2 * np.pi * np.arange(n) / n
    return np.column_stack([radii * np.cos(angles), radii * np.sin(angles)])


def test_half_disc_has_textbook_properties():
    """A half disc of radius r: area pi r^2/2, centroid 4r/(3 pi), Ixx (pi/8 - 8/(9 pi)) r^4."""
    r = 2.0
    assert pytest.approx(math.pi * r**2 / 2, rel=1e-14) == HALF_DISC.area
    np.testing.assert_allclose(HALF_DISC.centroid, (0.0, 4 * r / (3 * math.pi)), atol=1e-14)
    ixx, iyy, ixy = HALF_DISC.second_moments
    assert ixx == pytest.approx((math.pi / 8 - 8 / (9 * math.pi)) * r**4, rel=1e-13)
    assert iyy == pytest.approx(math.pi * r**4 / 8, rel=1e-13)
    assert ixy == pytest.approx(0.0, abs=1e-13)
    assert HALF_DISC.length == pytest.approx(r * (2 + math.pi), rel=1e-14)


@pytest.mark.parametrize("n_arcs", [2, 3, 7])
def test_circle_far_from_the_origin_keeps_its_digits(n_arcs):
    """A circle of any number of arcs, a thousand radii away, has pi r^2 and pi r^4/4."""
    outline = circle(1.5, (1500.0, -900.0), n_arcs)
    assert outline.area == pytest.approx(math.pi * 1.5**2, rel=1e-12)
    expected = math.pi * 1.5**4 / 4
    np.testing.assert_allclose(outline.second_moments, (expected, expected, 0.0), atol=1e-9)


def test_triangle_has_textbook_product_of_inertia():
    """A right triangle of base b and height h has Ixy = -b^2 h^2/72 about its centroid."""
    triangle = polygon([(0.0, 0.0), (3.0, 0.0), (0.0, 2.0)])
    ixx, iyy, ixy = triangle.second_moments
    assert ixx == pytest.approx(3.0 * 2.0**3 / 36, rel=1e-14)
    assert iyy == pytest.approx(2.0 * 3.0**3 / 36, rel=1e-14)
    assert ixy == pytest.approx(-(3.0**2) * 2.0**2 / 72, rel=1e-14)


@given(star_polygons())
def test_area_of_a_polygon_is_the_shoelace_formula(corners):
    """The area from the boundary integral is the shoelace formula's."""
    x, y = corners.T
    shoelace = 0.5 * np.sum(x * np.roll(y, -1) - np.roll(x, -1) * y)
    assert polygon(corners).area == pytest.approx(shoelace, rel=1e-12)


@given(
    star_polygons(),
    st.builds(
        Placement,
        st.floats(-4.0, 4.0),
        st.tuples(st.floats(-50.0, 50.0), st.floats(-50.0, 50.0)),
        st.booleans(),
    ),
)
def test_placement_keeps_area_and_moves_the_centroid(corners, placement):
    """A placed outline has the same area, and its centroid is the placed centroid."""
    outline = polygon(corners)
    moved = outline.transformed(placement)
    assert moved.area == pytest.approx(outline.area, rel=1e-11)
    np.testing.assert_allclose(moved.centroid, placement.points([outline.centroid])[0], atol=1e-11)
    assert sum(moved.second_moments[:2]) == pytest.approx(sum(outline.second_moments[:2]), rel=1e-10)


def test_mirrored_keeps_names_on_their_sides():
    """In the mirror the right side is at negative x, still named right, and the loop turns left."""
    image = rectangle(4.0, 2.0, (3.0, 0.0)).mirrored()
    np.testing.assert_allclose(image.bounds(["right"])[:, 0], -5.0)
    assert image.area == pytest.approx(8.0)


def test_clockwise_segments_are_reversed_on_request_only():
    """from_segments turns a clockwise loop round with its names; the constructor refuses it."""
    ends = [(0.0, 0.0), (0.0, 1.0), (1.0, 1.0), (1.0, 0.0)]
    sides = tuple(Line(a, b) for a, b in zip(ends, ends[1:] + ends[:1], strict=True))
    names = ("left", "top", "right", "bottom")
    outline = Outline.from_segments(sides, names)
    assert outline.area == pytest.approx(1.0)
    assert np.array_equal(outline.bounds("top")[:, 1], [1.0, 1.0])
    with pytest.raises(InputError, match="clockwise"):
        Outline(sides, names)


def test_small_gaps_are_closed_and_larger_ones_named():
    """A gap of file rounding is closed; one of a thousandth is refused with its segment."""
    a, b, c = (0.0, 0.0), (1.0, 0.0), (0.0, 1.0)
    near = [Line(a, b), Line((1.0, 3e-7), c), Line(c, a)]
    assert Outline.from_segments(near, "xyz").segments[1].start == (1.0, 0.0)
    with pytest.raises(InputError, match=r"rounding"):
        Outline(tuple(near), tuple("xyz"))
    far = [Line(a, b), Line((1.0, 1e-3), c), Line(c, a)]
    with pytest.raises(InputError, match=r"segment 1 starts at \(1.0, 0.001\)"):
        Outline.from_segments(far, "xyz")
    with pytest.raises(InputError, match="segment 0 starts"):
        Outline.from_segments(near[:2], "xy")


@pytest.mark.parametrize(
    ("corners", "place"),
    [
        ([(0, 0), (1, 1), (1, 0), (0, 1)], r"\(0.5, 0.5\)"),
        ([(0, 0), (2, 0), (2, 2), (1, 0), (0, 2)], r"\(1, 0\)"),
        ([(0, 0), (3, 0), (3, 1), (1, 1), (2, 1), (2, 2), (0, 2)], "meet at"),
        ([(0, 0), (1, 0), (1, 0), (0, 1)], r"\(1.0, 0.0\) with zero length"),
        ([(0, 0), (1, 0), (0, 1), (0, 0)], "repeated"),
        ([(0, 0), (1, 0)], "2 corners"),
        ([(0, 0), (1, 0), (np.nan, 1)], "row 2"),
    ],
)
def test_bad_polygons_are_refused_with_the_place(corners, place):
    """Crossing, touching, folded back, duplicate and NaN corners: each message says where."""
    with pytest.raises(InputError, match=place):
        polygon(np.array(corners, dtype=float))


def test_arc_that_crosses_a_line_is_found():
    """A round top that dips through the bottom is refused at the crossing."""
    dip = Arc((2.0, 1.0), (0.0, 1.0), (1.0, 1.0), False)
    sides = [Line((0.0, 0.2), (2.0, 0.2)), Line((2.0, 0.2), (2.0, 1.0)), dip]
    sides.append(Line((0.0, 1.0), (0.0, 0.2)))
    with pytest.raises(InputError, match=r"meet at \((0.4|1.6), 0.2\)"):
        Outline.from_segments(sides, "abcd")


def test_two_arcs_that_cross_are_found():
    """Two bulges into a strip that overlap are refused."""
    lower = Arc((0.0, 0.0), (2.0, 0.0), (1.0, 0.0), False)
    upper = Arc((2.0, 1.5), (0.0, 1.5), (1.0, 1.5), False)
    sides = [lower, Line((2.0, 0.0), (2.0, 1.5)), upper, Line((0.0, 1.5), (0.0, 0.0))]
    with pytest.raises(InputError, match=r"0.75\)"):
        Outline.from_segments(sides, "abcd")


def test_tangent_neighbours_are_not_taken_for_a_crossing():
    """A slot of two lines and two tangent half circles is simple, rotated or not."""
    sides = [
        Line((0.0, 0.0), (7.3, 0.0)),
        Arc((7.3, 0.0), (7.3, 1.1), (7.3, 0.55), True),
        Line((7.3, 1.1), (0.0, 1.1)),
        Arc((0.0, 1.1), (0.0, 0.0), (0.0, 0.55), True),
    ]
    slot = Outline.from_segments(sides, "abcd")
    for angle in np.linspace(0.0, 6.0, 13):
        moved = slot.transformed(Placement(angle, (100.0, -30.0)))
        assert Outline(moved.segments, moved.names).n_segments == 4


def test_contains_is_exact_at_arcs():
    """Points of a slotted disc are inside if and only if the formulas of its circles say so."""
    ring_part = Outline.from_segments(
        [
            Arc((2.0, 0.0), (-2.0, 0.0), (0.0, 0.0), True),
            Line((-2.0, 0.0), (-1.0, 0.0)),
            Arc((-1.0, 0.0), (1.0, 0.0), (0.0, 0.0), False),
            Line((1.0, 0.0), (2.0, 0.0)),
        ],
        "abcd",
    )
    points = np.random.default_rng(0).uniform(-2.5, 2.5, (20000, 2))
    radius = np.hypot(*points.T)
    expected = (radius < 2.0) & (radius > 1.0) & (points[:, 1] > 0.0)
    assert np.array_equal(ring_part.contains(points), expected)


def test_sampled_points_keep_the_spacing_and_the_deviation():
    """Samples hold all joints, keep the spacing, and chords deviate no more than asked."""
    points = HALF_DISC.sampled(spacing=0.3)
    gaps = np.hypot(*(np.roll(points, -1, axis=0) - points).T)
    assert gaps.max() <= 0.3
    assert {(-2.0, 0.0), (2.0, 0.0)} <= set(map(tuple, points))
    for deviation in (0.5, 0.01, 1e-4):
        chords = HALF_DISC.sampled(max_deviation=deviation)[1:]
        chords = np.vstack([chords, [(-2.0, 0.0)]])
        middles = 0.5 * (chords[1:] + chords[:-1])
        assert 2.0 - np.hypot(*middles.T).min() <= deviation * (1 + 1e-9)
    with pytest.raises(InputError, match="neither"):
        HALF_DISC.sampled()
    with pytest.raises(InputError, match="spacing"):
        HALF_DISC.sampled(spacing=0.0)


def test_closest_names_the_segment():
    """The closest point of a far one is on the segment that faces it."""
    number, s, distance = HALF_DISC.closest([(0.0, 5.0), (0.5, -1.0)])
    assert [HALF_DISC.names[i] for i in number] == ["round", "cut"]
    np.testing.assert_allclose(s, [0.5, 0.625])
    np.testing.assert_allclose(distance, [3.0, 1.0])


def test_part_follows_the_outline_through_its_closing_joint():
    """A part that passes the joint of last and first segment is one chain in outline order."""
    box = rectangle(4.0, 2.0)
    part = box.part(["bottom", "left"])
    assert part.names == ("left", "bottom")
    assert isinstance(part, Contour)
    assert part.length == 6.0
    with pytest.raises(InputError, match="not one open chain"):
        box.part(["bottom", "top"])
    with pytest.raises(InputError, match="side"):
        box.part(["side"])


def test_open_contour_may_not_cross_itself():
    """An open chain is checked for crossings, and need not be closed."""
    ends = [(0.0, 0.0), (2.0, 0.0), (2.0, 1.0), (1.0, 1.0)]
    zigzag = [Line(a, b) for a, b in itertools.pairwise(ends)]
    assert Contour.from_segments(zigzag, "abc").sampled(spacing=9.0).tolist() == [list(end) for end in ends]
    with pytest.raises(InputError, match=r"meet at \(1, 0\)"):
        Contour.from_segments([*zigzag, Line((1.0, 1.0), (1.0, -1.0))], "abcd")
    with pytest.raises(InputError, match="2 names for 3"):
        Contour.from_segments(zigzag, "ab")


def test_a_flat_loop_has_no_area():
    """Two arcs there and back along nearly the same circle enclose nothing and are refused."""
    there = Arc((1.0, 0.0), (-1.0, 0.0), (0.0, 0.0), True)
    with pytest.raises(InputError):
        Outline.from_segments([there, there.reversed()], "ab")


NUMBERS = st.floats(-100.0, 100.0)
PLACEMENTS = st.builds(Placement, st.floats(-7.0, 7.0), st.tuples(NUMBERS, NUMBERS), st.booleans())
POINTS = np.array([[0.0, 0.0], [1.0, 0.0], [3.0, -2.0]])


def test_mirror_acts_before_rotation():
    """A mirrored quarter turn brings (1, 0) over (-1, 0) to (0, -1)."""
    placement = Placement(math.pi / 2, (10.0, 0.0), mirrored=True)
    np.testing.assert_allclose(placement.points([(1.0, 0.0)]), [(10.0, -1.0)], atol=1e-15)
    np.testing.assert_allclose(placement.vectors([(1.0, 0.0)]), [(0.0, -1.0)], atol=1e-15)


@given(PLACEMENTS)
def test_inverse_undoes(placement):
    """A placement followed by its inverse leaves points where they were."""
    back = placement.inverse().points(placement.points(POINTS))
    np.testing.assert_allclose(back, POINTS, atol=1e-12)


@given(PLACEMENTS, PLACEMENTS)
def test_composition_is_one_after_the_other(first, second):
    """The composition of two placements acts like both in turn."""
    both = second.after(first)
    np.testing.assert_allclose(both.points(POINTS), second.points(first.points(POINTS)), atol=1e-11)


@given(PLACEMENTS)
def test_matrix_is_orthogonal_with_the_sign_of_the_mirror(placement):
    """The linear part keeps lengths; it turns the orientation if and only if mirrored."""
    np.testing.assert_allclose(placement.matrix @ placement.matrix.T, np.eye(2), atol=1e-15)
    assert np.linalg.det(placement.matrix) == pytest.approx(-1.0 if placement.mirrored else 1.0)


def test_rotation_about_a_point_keeps_it():
    """A rotation about a point moves others and not that one."""
    turn = Placement.about((3.0, 4.0), 1.2)
    np.testing.assert_allclose(turn.points([(3.0, 4.0)]), [(3.0, 4.0)], atol=1e-14)
    assert turn.rotation_rad == 1.2


@pytest.mark.parametrize("half", ["lower", "upper"])
def test_half_discs_have_a_rim_and_a_cut(half):
    """A half disc has half of the circle's area on its side of the centre; an arc of its own is about its apex."""
    sign = 1.0 if half == "upper" else -1.0
    whole, divided = half_disc(2.0, (1.0, 3.0), half), half_disc(2.0, (1.0, 3.0), half, arc=0.5)
    for outline in (whole, divided):
        assert outline.area == pytest.approx(2.0 * np.pi, rel=1e-14)
        assert outline.centroid == pytest.approx([1.0, 3.0 + sign * 4.0 * 2.0 / (3.0 * np.pi)])
    assert whole.names == ("cut", "rim", "rim")
    assert divided.names == ("cut", "rim", "arc", "rim")
    assert divided.segments[2].point(np.array([0.5]))[0] == pytest.approx([1.0, 3.0 + 2.0 * sign])
    assert divided.segments[2].length == pytest.approx(2.0 * 0.5)
    for wrong in ({"half": "left"}, {"arc": 4.0}, {"radius": 0.0}):
        with pytest.raises(InputError):
            half_disc(**{"radius": 2.0, **wrong})
