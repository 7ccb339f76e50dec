"""Profiles against the figures printed in their files and in the standards."""

import numpy as np
import pytest

from flangeway.errors import InputError
from flangeway.geometry import Arc, Line, Outline
from flangeway.mesh import Refinement, check, dual, triangulate
from flangeway.railway.profiles.bundled import rail, wheel

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


def test_rail_agrees_with_published_136re():
    """136RE is published with 13.35 in2, 94.9 in4, height 7-5/16 in, base 6 in (within 0.5 %)."""
    outline = rail(crown_radius_in=14).outline
    assert outline.area / 25.4**2 == pytest.approx(13.35, rel=5e-3)
    assert outline.second_moments[0] / 25.4**4 == pytest.approx(94.9, rel=5e-3)
    low, high = outline.bounds()
    assert high[1] - low[1] == pytest.approx(7.3125 * 25.4, abs=1e-6)
    assert high[0] - low[0] == pytest.approx(6.0 * 25.4, abs=1e-6)
    assert low[1] == 0.0


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


def test_rail_names_tell_the_side():
    """Gauge segments are at negative x, field segments at positive x, as mirror images."""
    outline = rail().outline
    gauge = [name for name in outline.names if name.endswith("_gauge")]
    assert len(gauge) == 13
    for name in gauge:
        left = outline.bounds([name])
        right = outline.bounds([name.replace("_gauge", "_field")])
        assert left[1, 0] < 0.0
        np.testing.assert_allclose(left[:, 0], -right[::-1, 0], atol=1e-12)
        np.testing.assert_allclose(left[:, 1], right[:, 1], atol=1e-12)


def test_rail_head_is_one_chain_from_side_to_side():
    """The running surface is one chain over the crown, named from gauge side to field side."""
    profile = rail()
    head = profile.outline.part(profile.head_names)
    assert head.names == profile.head_names[::-1]
    assert profile.head_names[0] == "head_side_1:40_gauge"
    assert profile.head_names[-1] == "head_side_1:40_field"
    assert head.bounds()[1, 1] == pytest.approx(185.7375)
    assert profile.outline.bounds(profile.base_names)[1, 1] == 0.0


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


def test_wheel_is_a_region_above_its_tread():
    """The flange is at negative x, the body above, the cut straight, 50 mm above the tape line."""
    outline = wheel().outline
    assert isinstance(outline, Outline)
    np.testing.assert_allclose(outline.bounds(["cut"])[:, 1], 50.0)
    assert outline.bounds(["flange_tip_land"])[1, 0] < -50.0
    assert outline.contains([(0.0, 25.0)])[0]
    for face in ("back_face", "outer_face"):
        assert outline.bounds([face])[1, 1] == 50.0


def test_wheel_running_surface_is_one_chain_in_outline_order():
    """The running surface goes from the flange's back to the rim's edge without a gap."""
    profile = wheel()
    part = profile.outline.part(profile.running_names)
    assert part.names == profile.running_names
    assert part.segments[0].start == (-77.7875, -7.9375)
    assert {"flange_root_R1", "flange_root_R2", "tread_1:20"} <= set(part.names)


def test_users_see_how_certain_the_contours_are():
    """Every profile says how far it can be trusted and where it comes from."""
    assert "derived" in rail().certainty
    assert "exact" in rail(crown_radius_in=14).certainty
    assert "approximation" in wheel().certainty
    for profile in (rail(), wheel()):
        assert profile.source.endswith(".")


@pytest.mark.parametrize(
    ("make", "word"),
    [
        (lambda: rail("115RE"), "136RE"),
        (lambda: rail(crown_radius_in=12), "8, 10, 14"),
        (lambda: wheel("S1003"), "AAR-1B"),
    ],
)
def test_unknown_profiles_are_refused_with_those_there_are(make, word):
    """An unknown name or radius is refused, and the message lists what is allowed."""
    with pytest.raises(InputError, match=word):
        make()


@pytest.mark.parametrize("make", [rail, wheel])
def test_profiles_make_sound_meshes(make):
    """Rail and wheel are meshed with a refined running surface; triangles and duals are sound."""
    profile = make()
    names = profile.head_names if hasattr(profile, "head_names") else profile.running_names
    surface = profile.outline.part(names).sampled(spacing=0.5)
    surface = surface[np.abs(surface[:, 0]) < 10.0]
    mesh = triangulate(profile.outline, size=3.0, refinements=[Refinement(surface, 0.5, 0.2)])
    check(mesh, region_area=profile.outline.area, area_tolerance=2e-3)
    check(dual(mesh), region_area=mesh.cell_areas.sum())
    assert set(mesh.edge_sets) == set(profile.outline.names)
    np.testing.assert_allclose(profile.outline.closest(mesh.points[mesh.chain(*names)])[2], 0.0, atol=1e-9)
