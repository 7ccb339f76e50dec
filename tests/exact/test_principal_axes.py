"""Principal axes of sections in closed form: regular ones have none, all others their angle; pipes are meshed."""

import math

import numpy as np
import pytest

from flangeway.cases.section_run import run_section
from flangeway.errors import InputError
from flangeway.formats import DrawnSection
from flangeway.geometry import Placement, Region, Section, circle, pipe_section, polygon, rectangle, square
from flangeway.mesh import triangulate
from flangeway.post import SectionConstants


def principal_angle(region):
    """Principal angle of the exact moments in degrees, and whether all axes are principal."""
    moments = Section({"section": region}).second_moments()
    constants = object.__new__(SectionConstants)
    object.__setattr__(constants, "second_moments", moments)
    return math.degrees(constants.principal_angle), constants.all_axes_principal


@pytest.mark.parametrize("seed", range(30))
def test_regular_sections_have_no_principal_direction(seed):
    """Squares, circles, regular polygons and tubes of these, turned and with coordinates of six digits: angle 0."""
    rng = np.random.default_rng(seed)
    n, size = int(rng.integers(3, 12)), 10.0 ** rng.uniform(-2, 3)
    angles = rng.uniform(0, 6) + 2.0 * math.pi * np.arange(n) / n
    corners = np.column_stack((np.cos(angles), np.sin(angles)))
    rounding = rng.uniform(-1e-7, 1e-7, (n, 2))
    place = Placement(rng.uniform(0, 6), tuple(rng.uniform(-10, 10, 2) * size))
    regions = [
        Region(polygon(size * (corners + rounding)), (polygon(0.7 * size * (corners + rounding[::-1])),)),
        Region(polygon(size * (corners + rounding))),
        Region(square(size)),
        Region(square(2.0 * size), (circle(0.5 * size),)),
        Region(circle(size)),
        pipe_section(size, 0.1 * size),
    ]
    for region in regions:
        assert principal_angle(region.transformed(place)) == (0.0, True)


@pytest.mark.parametrize("seed", range(20))
def test_other_sections_have_their_angle(seed):
    """A rectangle a ten-thousandth longer than wide has its principal axis across its longer side, however turned."""
    rng = np.random.default_rng(seed)
    ratio, turn = 1.0 + 10.0 ** rng.uniform(-4, 1), rng.uniform(-89.0, 89.0)
    region = Region(rectangle(1.0, ratio)).transformed(Placement(math.radians(turn), (3.0, -5.0)))
    angle, none = principal_angle(region)
    assert not none
    assert angle == pytest.approx(turn, abs=1e-5)


def test_a_square_tube_says_that_all_axes_are_principal():
    """The run has the angle 0 and a notice."""
    drawn = DrawnSection("tube", Section({"section": Region(square(20.0), (square(16.0),))}), "mm")
    run = run_section(drawn)
    assert run.summary["principal_angle_deg"] == 0.0
    assert any("every axis" in notice for notice in run.notices)


def test_regions_are_triangulated_with_their_holes():
    """A pipe has its area but for the sagitta of its chords; a further hole has its own."""
    pipe = pipe_section(70.0, 17.5)
    mesh = triangulate(pipe, size=3.0)
    exact = math.pi * (35.0**2 - 17.5**2)
    assert mesh.cell_areas.sum() == pytest.approx(exact, rel=2e-3)
    assert pipe.area == pytest.approx(exact, rel=1e-12)
    more = triangulate(pipe, size=3.0, holes=[circle(3.0, (26.0, 0.0))])
    assert mesh.cell_areas.sum() - more.cell_areas.sum() == pytest.approx(9.0 * math.pi, rel=0.1)


@pytest.mark.parametrize("shape", [Section({"pipe": pipe_section(70.0, 17.5)}), [(0, 0), (1, 0), (0, 1)], "pipe"])
def test_what_is_no_region_is_refused_with_the_remedy(shape):
    """Sections, points and texts are refused, and the message names what takes them."""
    with pytest.raises(InputError, match="triangulate_section"):
        triangulate(shape, size=3.0)
