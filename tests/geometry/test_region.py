"""Regions and sections: exact properties, and holes that are refused with their place."""

import math

import numpy as np
import pytest

from flangeway.errors import InputError
from flangeway.geometry import (
    Arc,
    Line,
    Outline,
    Placement,
    Region,
    Section,
    circle,
    nested_regions,
    polygon,
    rectangle,
    square,
)


def test_ring_has_textbook_properties():
    """A ring of radii 3 and 2 far from the origin: area 5 pi, second moments 65 pi/4, centroid in its middle."""
    centre = (400.0, -300.0)
    ring = Region(circle(3.0, centre), (circle(2.0, centre),))
    assert ring.area == pytest.approx(5.0 * math.pi, rel=1e-12)
    np.testing.assert_allclose(ring.centroid, centre, rtol=1e-13)
    np.testing.assert_allclose(ring.second_moments, (65 * math.pi / 4, 65 * math.pi / 4, 0.0), atol=1e-9)
    assert ring.boundary_length == pytest.approx(10.0 * math.pi)
    np.testing.assert_array_equal(ring.contains([(402.5, -300.0), centre, (410.0, 0.0)]), [True, False, False])


def test_hole_moves_the_centroid_away():
    """A square of side 4 without its quarter of side 2 about (1, 1): centroid at -1/3 by statics, Ixy negative."""
    region = Region(square(4.0), (square(1.0, (1.0, 1.0)),))
    np.testing.assert_allclose(region.centroid, (-1.0 / 15.0, -1.0 / 15.0), rtol=1e-12)
    ixx = 4.0**4 / 12 + 16.0 / 225.0 - (1.0 / 12.0 + (16.0 / 15.0) ** 2)
    np.testing.assert_allclose(region.second_moments[:2], ixx, rtol=1e-12)
    assert region.second_moments[2] == pytest.approx(16.0 / 225.0 - (16.0 / 15.0) ** 2, rel=1e-12)


def first_and(second):
    return Region(square(4.0), (square(1.0, (-1.0, 0.0)), second))


@pytest.mark.parametrize(
    ("make", "message"),
    [
        (lambda: Region(square(4.0), (square(1.0, (5.0, 0.0)),)), r"hole 1 of 1 at \(4.5, -0.5\) is outside"),
        (lambda: Region(square(4.0), (square(1.0, (1.5, 0.0)),)), r"hole 1 of 1 meets the outer boundary at \(2, "),
        (lambda: Region(square(4.0), (circle(1.0, (1.0, 0.0)),)), r"meets the outer boundary at \(2, "),
        (lambda: Region(square(4.0), (square(1.0, (2.0, 0.0)),)), r"meets the outer boundary at \(2, "),
        (lambda: Region(square(4.0), (square(9.0),)), "is outside of the outer boundary"),
        (lambda: first_and(square(1.0, (0.0, 0.0))), r"hole 2 of 2 meets hole 1 at \(-0.5"),
        (lambda: first_and(circle(0.2, (-1.0, 0.0))), "one inside the other"),
        (lambda: first_and(square(1.6, (-1.0, 0.0))), "one inside the other"),
        (lambda: first_and(square(1.0, (-0.3, 0.0))), "keep apart|meets hole 1"),
        (lambda: nested_regions([square(2.0), square(2.0, (1.5, 0.5))]), "cross at"),
        (lambda: nested_regions([square(2.0), square(2.0)]), "lie on each other"),
        (lambda: Section({}), "without parts"),
    ],
)
def test_holes_and_loops_that_meet_are_refused_with_their_place(make, message):
    """Holes outside, that share a side, touch, cross, enclose or nest; loops that cross or are the same; no parts."""
    with pytest.raises(InputError, match=message):
        make()


@pytest.mark.parametrize("turn", [0.0, 0.25, 0.5, 1.0, 1.5, 1.75])
@pytest.mark.parametrize("n_arcs", [2, 4])
def test_points_on_the_chord_of_an_arc_are_inside(turn, n_arcs):
    """The centre of a disc made of half turns lies on their chords and inside; the chord of a bay is outside."""
    place = Placement(turn * math.pi)
    disc = circle(1.0, n_arcs=n_arcs).transformed(place)
    assert disc.contains([(0.0, 0.0), (0.3, 0.0), (0.0, -0.3), *disc.sampled(spacing=0.1) * 0.999]).all()
    square_with_bay = Outline.from_segments(
        [
            Line((1.0, 1.0), (-1.0, 1.0)),
            Line((-1.0, 1.0), (-1.0, -1.0)),
            Arc((-1.0, -1.0), (1.0, -1.0), (0.0, -1.0), counter_clockwise=False),
            Line((1.0, -1.0), (1.0, 1.0)),
        ],
        ["top", "left", "bay", "right"],
    ).transformed(place)
    inside = square_with_bay.contains(place.points([(0.0, -0.5), (0.0, -1.0), (0.5, -1.0), (0.0, 0.5)]))
    np.testing.assert_array_equal(inside, [False, False, False, True])


def test_loops_are_sorted_by_what_lies_in_what():
    """Five loops, given in any order, become a ring with an island that has a hole, and a part beside them."""
    loops = [circle(r) for r in (4.0, 3.0, 2.0, 1.0)] + [square(2.0, (6.0, 0.0))]
    regions = nested_regions([loops[i] for i in (3, 0, 4, 2, 1)])
    assert [region.area for region in regions] == pytest.approx([7 * math.pi, 3 * math.pi, 4.0])
    assert [len(region.holes) for region in regions] == [1, 1, 0]


def test_section_weighs_its_parts():
    """Two squares of side 2 side by side with weights 1 and 3: centroid three quarters along, Steiner's terms."""
    parts = {"left": Region(square(2.0)), "right": Region(square(2.0, (2.0, 0.0)))}
    section = Section(parts)
    assert section.area == 8.0
    np.testing.assert_allclose(section.centroid(), (1.0, 0.0), atol=1e-14)
    weights = {"left": 1.0, "right": 3.0}
    np.testing.assert_allclose(section.centroid(weights), (1.5, 0.0), atol=1e-14)
    own = 2.0**4 / 12
    iyy = own + 4.0 * 1.5**2 + 3.0 * (own + 4.0 * 0.5**2)
    np.testing.assert_allclose(section.second_moments(weights), (4.0 * own, iyy, 0.0), atol=1e-12)


def test_mean_thickness_is_the_wall_of_a_tube_and_the_radius_of_a_disc():
    """Twice area over boundary is the wall's thickness of a tube and the radius of a disc."""
    tube = Section({"tube": Region(circle(10.0), (circle(9.5),))})
    assert tube.mean_thickness == pytest.approx(0.5)
    assert Section({"disc": Region(circle(2.0))}).mean_thickness == pytest.approx(2.0)


def test_section_cannot_be_changed():
    """A section keeps its own copy of the parts."""
    parts = {"a": Region(rectangle(1.0, 2.0))}
    section = Section(parts)
    parts["b"] = Region(polygon([(5.0, 0.0), (6.0, 0.0), (5.0, 1.0)]))
    assert list(section.parts) == ["a"]
    with pytest.raises(TypeError):
        section.parts["c"] = parts["a"]


def test_reentrant_corners_are_those_of_notches_and_holes():
    """An L has one reentrant corner, a square hole four, a round hole none, and a tangent joint none."""
    ell = polygon([(0, 0), (3, 0), (3, 1), (1, 1), (1, 3), (0, 3)])
    np.testing.assert_allclose(Region(ell).reentrant_corners(), [(1.0, 1.0)])
    assert len(Region(square(4.0), (square(1.0),)).reentrant_corners()) == 4
    assert Region(circle(2.0), (circle(1.0),)).reentrant_corners().shape == (0, 2)
