"""Regions and sections: exact properties, those of handbooks and a peer, and holes that are refused."""

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
    angle_section,
    box_section,
    channel_section,
    circle,
    i_section,
    nested_regions,
    pipe_section,
    polygon,
    rectangle,
    rounded_polygon,
    square,
    tee_section,
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


PEERS = {
    "i_section": (i_section(200, 100, 8.5, 5.6, 12), {"d": 200, "b": 100, "t_f": 8.5, "t_w": 5.6, "r": 12, "n_r": 256}),
    "channel_section": (
        channel_section(120, 60, 8, 6, 10), {"d": 120, "b": 60, "t_f": 8, "t_w": 6, "r": 10, "n_r": 256},
    ),
    "tee_section": (tee_section(200, 100, 12, 6, 8), {"d": 200, "b": 100, "t_f": 12, "t_w": 6, "r": 8, "n_r": 256}),
    "angle_section": (
        angle_section(150, 100, 12, 10, 5), {"d": 150, "b": 100, "t": 12, "r_r": 10, "r_t": 5, "n_r": 256},
    ),
    "rectangular_hollow_section": (
        box_section(120, 80, 6), {"d": 120, "b": 80, "t": 6, "r_out": 0, "n_r": 1},
    ),
}  # fmt: skip


@pytest.mark.parametrize("name", PEERS)
def test_areas_and_second_moments_are_those_of_the_peers_library(name):
    """The area and the second moments about the centroid agree to 1e-5, which the peer's chords leave."""
    library = pytest.importorskip("sectionproperties.pre.library")
    ours, arguments = PEERS[name]
    theirs = getattr(library, name)(**arguments).geom
    assert ours.area == pytest.approx(theirs.area, rel=1e-5)
    # second moments of a polygon of chords, by Green's formula
    ixx = 0.0
    for ring, sign in [(theirs.exterior, 1.0), *[(each, -1.0) for each in theirs.interiors]]:
        p = np.array(ring.coords) - [theirs.centroid.x, theirs.centroid.y]
        (x0, y0), (x1, y1) = p[:-1].T, p[1:].T
        cross = x0 * y1 - x1 * y0
        ixx += sign * abs((cross * (y0**2 + y0 * y1 + y1**2)).sum() / 12.0)
    assert ours.second_moments[0] == pytest.approx(ixx, rel=2e-5)


def test_ipe_200_is_the_one_of_the_tables():
    """IPE 200 (EN 10365): 28.5 cm2, 1943 cm4, 142 cm4."""
    beam = i_section(200.0, 100.0, 8.5, 5.6, 12.0)
    assert beam.area == pytest.approx(2850.0, rel=1e-3)
    np.testing.assert_allclose(sorted(beam.second_moments[:2]), [142.4e4, 1943e4], rtol=2e-3)


def test_a_pipe_and_a_rounded_square_have_the_known_areas():
    """The pipe has pi (R^2 - r^2), the square its own less (4 - pi) r^2."""
    assert pipe_section(50.0, 5.0).area == pytest.approx(np.pi * (25.0**2 - 20.0**2), rel=1e-12)
    rounded = rounded_polygon([(0, 0), (4, 0), (4, 4), (0, 4)], [1, 1, 1, 1])
    assert rounded.area == pytest.approx(16.0 - 4.0 + np.pi, rel=1e-12)


@pytest.mark.parametrize("make", [
    lambda: i_section(10, 10, 6, 1),
    lambda: pipe_section(10, 5),
    lambda: box_section(10, 10, -1),
    lambda: i_section(100, 50, 5, 5, 60),
    lambda: rounded_polygon([(0, 0), (1, 0), (0, 1)], [0, -1, 0]),
])  # fmt: skip
def test_dimensions_that_do_not_fit_are_refused(make):
    """Walls thicker than the section, radii longer than sides, negative numbers."""
    with pytest.raises(InputError):
        make()
