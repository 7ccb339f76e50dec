"""Bundled rails and wheels against their formulas and the figures of their files and standards."""

import itertools
import math

import numpy as np
import pytest

from flangeway.errors import InputError
from flangeway.geometry import Arc, Line
from flangeway.mesh import check, triangulate
from flangeway.railway.profiles.bundled import (
    RAILS,
    REFERENCE_RAIL,
    WHEELS,
    bundled_name,
    bundled_section,
    rail,
    wheel,
)
from flangeway.railway.profiles.joining import nominal_profile
from flangeway.railway.profiles.orientation import flange_angle_rad, measures
from flangeway.railway.track.placements import Track

# printed in the files: area mm2, centroid above base mm, Ix mm4, Iy mm4
PRINTED = {
    8: (8589.06, 84.918, 39282165.2, 6020282.7),
    10: (8602.42, 85.069, 39407316.1, 6030244.6),
    14: (8617.36, 85.237, 39547782.8, 6041288.2),
}


@pytest.mark.parametrize(("radius", "printed"), PRINTED.items())
def test_rail_sections_have_the_printed_properties(radius, printed):
    """Area, centroid and inertias are those printed in the file, to 1e-5."""
    outline = rail(crown_radius_in=radius).outline
    ixx, iyy, ixy = outline.second_moments
    found = (outline.area, outline.centroid[1], ixx, iyy)
    np.testing.assert_allclose(found, printed, rtol=1e-5)
    assert abs(ixy) < 1e-9 * ixx
    assert abs(outline.centroid[0]) < 1e-10


@pytest.mark.parametrize("radius", [8, 10, 14])
def test_crown_is_one_arc_of_the_radius_asked_for(radius):
    """Crown and base are single segments across the middle, the crown with its radius."""
    outline = rail(crown_radius_in=radius).outline
    crown = outline.segments[outline.names.index("crown")]
    base = outline.segments[outline.names.index("base")]
    assert isinstance(crown, Arc)
    assert isinstance(base, Line)
    assert crown.radius == pytest.approx(radius * 25.4, rel=1e-6)
    np.testing.assert_allclose(crown.point(0.5), [(0.0, 185.7375)], atol=1e-6)
    np.testing.assert_allclose(base.point(0.5), [(0.0, 0.0)], atol=1e-12)


@pytest.mark.parametrize("name", ["crown", "shoulder_gauge", "upper_web_fillet_field", "web_upper_gauge"])
def test_rail_is_smooth_where_arcs_meet(name):
    """Arcs of the rail meet their neighbours tangentially, to the rounding of the file."""
    outline = rail().outline
    i = outline.names.index(name)
    for a, b in ((i - 1, i), (i, i + 1)):
        first = outline.segments[a].tangent(1.0)[0]
        second = outline.segments[b].tangent(0.0)[0]
        assert abs(first[0] * second[1] - first[1] * second[0]) < 1e-4


def test_wheel_has_the_figures_of_the_standard():
    """Flange 1 in high and 1-3/8 in thick, back 3-1/16 in from the tape line, taper 1:20."""
    profile = wheel()
    outline = profile.outline
    assert profile.flange_height_mm == 25.4
    assert profile.flange_back_mm == 77.7875
    assert profile.title == "AAR-1B (approximate)"
    np.testing.assert_allclose(outline.bounds(), [(-77.7875, -25.4), (67.46875, 50.0)], atol=1e-12)
    tread = outline.segments[outline.names.index("tread_1:20")]
    assert abs(tread.tangent(0.5)[0, 1] / tread.tangent(0.5)[0, 0]) == pytest.approx(0.05, rel=1e-5)
    tape_line = tread.closest([(0.0, 0.0)])[1][0]
    assert tape_line < 1e-5
    arc = outline.segments[outline.names.index("flange_root_R1")]
    points = arc.point(np.linspace(0, 1, 100001))
    thickness = profile.flange_back_mm + points[np.argmin(np.abs(points[:, 1] + 9.525)), 0]
    assert thickness == pytest.approx(34.925, abs=2e-3)


@pytest.mark.parametrize(("name", "degrees"), [("S1002", 70.0), ("AAR-1B", 75.0)])
def test_flange_angles_are_those_of_the_standards(name, degrees):
    """70 degrees (EN 13715) and 75 degrees (AAR); the rounded edge of the rim, which is upright at its end, is none."""
    surface = wheel(name).running_surface
    assert math.degrees(flange_angle_rad(surface)) == pytest.approx(degrees, abs=0.05)


def test_s1002_has_the_figures_of_the_standard():
    """Flange 28 mm high and 32.5 mm thick, qR 10.8, back 70 mm from the tape line, tread 1:15 at its end."""
    profile = wheel("S1002")
    assert profile.flange_height_mm == pytest.approx(28.0, abs=1e-6)
    assert profile.flange_back_mm == 70.0
    found = measures(profile.outline.part(profile.running_names), "wheel")
    assert found["flange_height_mm"] == pytest.approx(28.0, abs=1e-3)
    assert found["flange_thickness_mm"] == pytest.approx(32.5, abs=2e-3)
    assert found["flange_slope_mm"] == pytest.approx(10.794, abs=2e-3)
    contour = wheel("S1002").outline.part(wheel("S1002").running_names)
    assert contour.closest([(0.0, 0.0)])[2][0] < 5e-5
    outside = contour.segments[-1].tangent(0.0)[0]
    assert outside[1] / outside[0] == pytest.approx(1.0 / 15.0, rel=1e-6)


def test_s1002_is_smooth():
    """No joint of the S1002 turns by more than a twentieth of a degree; its arcs have the standard's radii."""
    contour = wheel("S1002").outline.part(wheel("S1002").running_names)
    for a, b in itertools.pairwise(contour.segments):
        turn = a.tangent(1.0)[0] @ b.tangent(0.0)[0]
        assert math.degrees(math.acos(min(1.0, turn))) < 0.05
    radii = {n: s.radius for n, s in zip(contour.names, contour.segments, strict=True) if isinstance(s, Arc)}
    for name, radius in (("flange_root_R13", 13.0), ("flange_front_R20", 20.0), ("flange_tip_R12", 12.0)):
        assert radii[name] == pytest.approx(radius, rel=1e-8)
    assert contour.segments[contour.names.index("flange_root_R13")].curvature < 0.0
    assert contour.segments[contour.names.index("flange_tip_R12")].curvature > 0.0


def test_heavy_haul_wheel_is_nine_smooth_arcs():
    """The nine arcs meet tangentially, with a flange of 26 mm, and the tread passes the tape line at zero."""
    contour = wheel("heavy-haul").running_surface
    assert contour.n_segments == 9
    for a, b in itertools.pairwise(contour.segments):
        assert a.tangent(1.0)[0] @ b.tangent(0.0)[0] == pytest.approx(1.0, abs=1e-8)
    assert contour.closest([(0.0, 0.0)])[2][0] < 1e-5
    hollow = [n for n, s in zip(contour.names, contour.segments, strict=True) if s.curvature < 0.0]
    assert hollow == ["flange_root_R14", "flange_root_R39"]
    assert wheel("heavy-haul").flange_height_mm == pytest.approx(26.0, abs=0.05)


@pytest.mark.parametrize("name", [*WHEELS, "R-519-A", "R-519-C"])
def test_wheels_are_regions_with_a_straight_cut(name):
    """Every bundled wheel is one region below its cut, says where it comes from, and is meshed soundly."""
    profile = wheel(name)
    assert profile.outline.bounds()[1, 1] == 50.0
    assert profile.certainty.endswith(".")
    assert profile.source.endswith(".")
    running = profile.outline.part(profile.running_names)
    assert running.segments[0].start[0] < -60.0
    assert running.segments[-1].end[0] > 50.0
    mesh = triangulate(profile.outline, size=4.0)
    check(mesh, region_area=profile.outline.area, area_tolerance=2e-3)
    assert len(mesh.chain(*profile.running_names)) > 20


def test_the_reference_rail_is_that_of_the_standard_when_it_is_inclined():
    """At 1:20 its head passes points of table I.6; upright it has the foot and the height of a 60E1."""
    profile = rail(REFERENCE_RAIL)
    track = Track(rail=profile, gauge_mm=1435.164446, inclination=0.05, gauge_depth_mm=14.0)
    head = profile.running_surface.transformed(track.placement("right"))
    top = 0.49178
    table = ((-32.0, 11.87191), (-20.0, 2.54678), (0.0, 0.0), (10.0, -0.42031), (24.0, 0.09867), (39.0, 10.66466))
    points = [(750.0 + y, -z - top) for y, z in table]
    assert head.closest(points)[2].max() < 3e-3
    assert profile.outline.bounds()[:, 1] == pytest.approx([0.0, 172.0], abs=1e-4)


@pytest.mark.parametrize("name", RAILS)
def test_heads_have_their_nominal_width(name):
    """The head's width 14 mm below the top is that of the outline there."""
    profile = rail(name)
    head = profile.outline.part(profile.running_names)
    level = float(head.bounds()[1, 1]) - 14.0
    points = head.sampled(spacing=0.01)
    at_level = points[np.abs(points[:, 1] - level) < 0.01]
    width = measures(head, "rail")["head_width_mm"]
    assert width == pytest.approx(np.ptp(at_level[:, 0]), abs=0.01)


def test_measures_are_left_out_where_a_surface_does_not_reach():
    """A tread without its flange has no measures; a flange without its back has no thickness."""
    contour = wheel("S1002").outline.part(wheel("S1002").running_names)
    tread = contour.part([name for name in contour.names if name.startswith("tread")])
    assert measures(tread, "wheel") == {}
    front = contour.part([name for name in contour.names if name != "flange_back_R20.5"])
    assert set(measures(front, "wheel")) == {"flange_height_mm", "flange_slope_mm"}


PUBLISHED = {
    "60E1": (76.70, 3038.3, 512.3, 150.0, 172.0),
    "60E2": (76.48, 3021.5, 510.5, 150.0, 172.0),
    "54E1": (69.77, 2337.9, 419.2, 140.0, 159.0),
    "49E1": (62.92, 1816.0, 319.1, 125.0, 149.0),
    "136RE-14": (13.35 * 2.54**2, 94.9 * 2.54**4, 14.5 * 2.54**4, 152.4, 185.7375),
}
"""Area in cm2, Ixx and Iyy in cm4, base and height in mm: EN 13674-1, annex A; AREMA, chapter 4."""


@pytest.mark.parametrize("name", PUBLISHED)
def test_bundled_sections_agree_with_their_standards(name):
    """Area and both moments of inertia of each rail are within 0.2 % of its standard's, base and height exact."""
    area, ixx, iyy, base, height = PUBLISHED[name]
    outline = nominal_profile(name).outline
    found_ixx, found_iyy, ixy = outline.second_moments
    np.testing.assert_allclose(
        (outline.area / 1e2, found_ixx / 1e4, found_iyy / 1e4), (area, ixx, iyy), rtol=2e-3, err_msg=name
    )
    assert abs(ixy) < 1e-9 * found_ixx
    low, high = outline.bounds()
    np.testing.assert_allclose(high - low, (base, height), rtol=1e-9)


@pytest.mark.parametrize("name", [name for name in RAILS if name != "136RE"])
def test_segments_of_european_rails_are_tangent(name):
    """Neighbouring lines and arcs of a rail of EN 13674-1 have one tangent: its joints are those of the drawing."""
    segments = rail(name).outline.segments
    for one, other in zip(segments, [*segments[1:], segments[0]], strict=True):
        end, start = one.tangent(1.0)[0], other.tangent(0.0)[0]
        assert float(end @ start) > 1.0 - 1e-12, (one, other)


@pytest.mark.parametrize(
    ("said", "meant"),
    [("uic 60", "60E1"), ("UIC_54", "54E1"), ("S49", "49E1"), ("136re-14", "136RE-14")],
)  # fmt: skip
def test_names_that_people_use_lead_to_bundled_profiles(said, meant):
    """Older designations and other spellings of a name give the same rail or wheel."""
    assert nominal_profile(said).title == nominal_profile(meant).title
    assert bundled_name("115RE") == "115RE"


def test_unknown_names_are_refused_with_the_nearest():
    """A name that is not there is refused, with those there are and the nearest; a 60E1 has no choice of crown."""
    with pytest.raises(InputError, match="did you mean 136RE"):
        bundled_section("136RA")
    with pytest.raises(InputError, match="leave it out"):
        rail("60E1", crown_radius_in=10.0)
