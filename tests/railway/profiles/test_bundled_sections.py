"""Sections that come with the package."""

import numpy as np
import pytest

from flangeway.errors import InputError
from flangeway.railway.profiles.bundled import RAILS, bundled_name, bundled_section, rail
from flangeway.railway.profiles.joining import nominal_profile

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
