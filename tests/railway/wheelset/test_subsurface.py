"""Stresses below the contact, along the inward normal."""

import numpy as np
import pytest

from flangeway.cases import WheelsetTangentCase
from flangeway.railway.wheelset.subsurface import (
    maximum_on,
    maximum_shear,
    stresses_below,
)
from flangeway.railway.wheelset.wheelset_result import solve_wheelset


@pytest.fixture(scope="module")
def light():
    """A wheelset with so little load that its contact is small beside wheel and rail, as Hertz assumes."""
    values = {"axle_load_kN": 6.0, "contact_size_mm": 0.1, "order": 2}
    return solve_wheelset(WheelsetTangentCase.from_values(values).problem())


@pytest.mark.parametrize("body", ["rail", "wheel"])
def test_a_small_contact_has_the_shear_of_hertz(light, body):
    """Under a small load the maximum in-plane shear is 0.300 p0 at 0.786 a (Johnson, 1985, 4.2), within 3 and 6 %."""
    for patch in light.patches:
        found = maximum_shear(light, patch, body)
        assert found.value_MPa == pytest.approx(0.3003 * patch.hertz.max_pressure, rel=0.03)
        assert found.depth_mm == pytest.approx(0.7862 * patch.hertz.half_width, rel=0.06)


@pytest.mark.parametrize("body", ["rail", "wheel"])
def test_the_line_has_the_stresses_of_hertz(light, body):
    """The normal stresses along, across and out of the normal are those of Hertz to 4 % of the pressure."""
    for patch in light.patches:
        line = stresses_below(light, patch, body, 3.0 * patch.hertz.half_width)
        down = (line.points[-1] - line.points[0]) / line.distances[-1]
        xx, yy, xy, out_of_plane = line.stresses.components.T
        across = down[0] ** 2 * xx + down[1] ** 2 * yy + 2.0 * down[0] * down[1] * xy
        exact_along, exact_across, _ = patch.hertz.stresses(0.0, line.distances).T
        wanted = exact_along, exact_across, 0.3 * (exact_along + exact_across)  # plane strain
        inside = line.distances > 0.1
        for found, exact in zip((xx + yy - across, across, out_of_plane), wanted, strict=True):
            assert np.abs(found - exact)[inside].max() < 0.04 * patch.hertz.max_pressure


def test_the_line_starts_on_the_surface_and_goes_inwards(light):
    """The line starts at the centre of pressure, to a hundredth of a mm, runs into the body and stays in it."""
    for patch in light.patches:
        for body, place, inward in (("rail", patch.rail_point_mm, -1.0), ("wheel", patch.wheel_point_mm, 1.0)):
            line = stresses_below(light, patch, body)
            assert np.linalg.norm(line.points[0] - place) < 0.01
            assert inward * (line.points[-1] - line.points[0])[1] > 0.99 * line.distances[-1]
            assert line.distances[-1] == pytest.approx(4.0 * patch.pressure.half_width)
            assert np.isfinite(line.stresses.components).all()


def test_a_cubic_finds_the_top_between_jumps():
    """Hertz's shear stress in steps of a tenth of the half width has its top where the smooth one has it, to 3 %."""
    depths = np.linspace(0.0, 4.0, 201)
    middles = 0.1 * np.floor(depths / 0.1) + 0.05
    found = maximum_on(depths, middles - middles**2 / np.hypot(1.0, middles))
    assert found.value_MPa == pytest.approx(0.3003, rel=0.005)
    assert found.depth_mm == pytest.approx(0.7862, rel=0.03)
