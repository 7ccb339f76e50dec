"""Sections that come with the package."""

import numpy as np
import pytest

from flangeway.errors import InputError
from flangeway.railway.profiles.bundled import SECTIONS, bundled_section, rail


def test_60e1_agrees_with_the_standard():
    """60E1 of EN 13674-1: area 76.70 cm2, Ixx 3038.3 cm4, Iyy 512.3 cm4, height 172 mm, base 150 mm (within 1 %)."""
    outline = rail("60E1").outline
    ixx, iyy, ixy = outline.second_moments
    np.testing.assert_allclose((outline.area, ixx, iyy), (7670.0, 30383000.0, 5123000.0), rtol=1e-2)
    assert abs(ixy) < 1e-9 * ixx
    low, high = outline.bounds()
    np.testing.assert_allclose(high - low, (150.0, 172.0), rtol=1e-9)
    assert outline.centroid[1] == pytest.approx(80.9, abs=0.1)
    crown = outline.part(rail("60E1").head_names)
    assert crown.bounds()[1, 1] == pytest.approx(172.0)


@pytest.mark.parametrize("name", SECTIONS)
def test_bundled_sections_are_found_in_any_case(name):
    """Every bundled name, also in small letters, gives its rail in mm with a word on how certain it is."""
    found = bundled_section(name.lower())
    assert found.unit == "mm"
    assert found.title.startswith(name[:4])
    assert found.certainty.endswith(".")


def test_crowns_differ():
    """The three crowns of 136RE have the areas 13.31, 13.33 and 13.36 in2; the usual one is that of 10 in."""
    areas = [bundled_section(name).section.area / 25.4**2 for name in ("136RE-8", "136RE", "136RE-14")]
    np.testing.assert_allclose(areas, (13.31, 13.33, 13.36), atol=5e-3)


def test_unknown_names_are_refused_with_the_nearest():
    """A name that is not there is refused, with those there are and the nearest; a 60E1 has no choice of crown."""
    with pytest.raises(InputError, match="did you mean 136RE"):
        bundled_section("136RA")
    with pytest.raises(InputError, match="leave it out"):
        rail("60E1", crown_radius_in=10.0)
