"""Profiles against the figures printed in their files and in the standards."""

import numpy as np
import pytest

from flangeway.geometry import Arc, Line
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
