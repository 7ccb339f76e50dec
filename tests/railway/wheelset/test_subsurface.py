"""Stresses below the contact, along the inward normal, and warnings where they are not to be relied on."""

import numpy as np
import pytest

from flangeway.cases.case_file import load_case
from flangeway.post import cell_stresses
from flangeway.railway.profiles.orientation import conforming
from flangeway.railway.wheelset.plane_patch import (
    maximum_on,
    stresses_below,
)
from flangeway.railway.wheelset.plane_wheelset import solve_wheelset
from flangeway.railway.wheelset.wheelset_checks import below_contacts
from flangeway.report.wheelset.wheelset_page import results_table


@pytest.fixture(scope="module")
def light():
    """A wheelset with so little load that its contact is small beside wheel and rail, as Hertz assumes."""
    values = {"axle_load_kN": 6.0, "contact_size_mm": 0.1, "order": 2}
    return solve_wheelset(load_case("wheelset-tangent", **values))


@pytest.mark.parametrize("body", ["rail", "wheel"])
def test_a_small_contact_has_the_shear_of_hertz(light, body):
    """Under a small load the maximum in-plane shear is 0.300 p0 at 0.786 a (Johnson, 1985, 4.2), within 3 and 6 %."""
    for patch in light.patches:
        found, _ = patch.below[body]
        assert found.value_MPa == pytest.approx(0.3003 * patch.hertz.max_pressure, rel=0.03)
        assert found.depth_mm == pytest.approx(0.7862 * patch.hertz.half_width, rel=0.06)


@pytest.mark.parametrize("body", ["rail", "wheel"])
def test_the_line_has_the_stresses_of_hertz(light, body):
    """The normal stresses along, across and out of the normal are those of Hertz to 4 % of the pressure."""
    for patch in light.patches:
        line = stresses_below(patch, body, 3.0 * patch.hertz.half_width)
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
            line = stresses_below(patch, body)
            assert np.linalg.norm(line.points[0] - place) < 0.01
            assert inward * (line.points[-1] - line.points[0])[1] > 0.99 * line.distances[-1]
            assert line.distances[-1] == pytest.approx(4.0 * patch.half_width)
            assert np.isfinite(line.stresses.components).all()


def test_a_cubic_finds_the_top_between_jumps():
    """Hertz's shear stress in steps of a tenth of the half width has its top where the smooth one has it, to 3 %."""
    depths = np.linspace(0.0, 4.0, 201)
    middles = 0.1 * np.floor(depths / 0.1) + 0.05
    found = maximum_on(depths, middles - middles**2 / np.hypot(1.0, middles))
    assert found.value_MPa == pytest.approx(0.3003, rel=0.005)
    assert found.depth_mm == pytest.approx(0.7862, rel=0.03)


@pytest.fixture(scope="module")
def usual():
    """Contacts of Hertz: 136RE and AAR-1B."""
    return load_case("wheelset-tangent", size_scale=5.0).run()


@pytest.fixture(scope="module")
def pushed():
    """A wheel that runs at the gauge side of an upright head: the web is bent, and stressed more than the contact."""
    return load_case("wheelset-tangent", size_scale=5.0, inclination=-0.05).run()


@pytest.fixture(scope="module")
def conformed():
    """S1002 on 60E1 at 1:40, which touch where the tread's curvature changes."""
    values = {"size_scale": 5.0, "rail": "60E1", "wheel": "S1002", "gauge_mm": 1435.0, "back_to_back_mm": 1360.0}
    return load_case("wheelset-tangent", **values).run()


def rail_stresses(run):
    """Maximum von Mises stress of the rails' cells below the contacts, and anywhere."""
    model, below, anywhere = run.result.model, 0.0, 0.0
    for name in ("rail-left", "rail-right"):
        mises = cell_stresses(model.parts[name].body.elasticity, run.result.displacements[name]).von_mises
        below = max(below, mises[below_contacts(model, run.result.patches, name)].max())
        anywhere = max(anywhere, mises.max())
    return below, anywhere


def test_yield_is_warned_of_by_the_stress_below_the_contact(pushed):
    """The factor of the warning is that of cells within two half widths of a contact, not that of the web."""
    strength = 510.0
    (warning,) = [each for each in pushed.warnings if "exceed" in each]
    assert "below the contacts" in warning
    below, anywhere = rail_stresses(pushed)
    assert f"{below / strength:.1f} times in the rail" in warning
    assert anywhere > 1.2 * below
    # below a contact of Hertz von Mises reaches 0.56 of the maximum pressure
    pressure = max(each["max_pressure_MPa"] for each in pushed.summary["patches"])
    assert below == pytest.approx(0.56 * pressure, rel=0.25)


def test_hertz_is_left_out_where_profiles_conform(usual, conformed):
    """Hertz's pressure stands beside a contact of constant curvature, not beside one that conforms."""
    assert all(contact["hertz_pressure_MPa"] for contact in usual.summary["patches"])
    assert all(contact["hertz_pressure_MPa"] is None for contact in conformed.summary["patches"])
    rows = {row[0].strip(): row[1:] for row in results_table(conformed).rows}
    assert set(rows["Hertz, MPa"]) == set(rows["Hertz, mm"]) == {"–"}
    assert any("Hertz's theory is left out" in each for each in conformed.case.assumptions(conformed.result))
    assert not any("Hertz" in each for each in usual.case.assumptions(usual.result))


def test_the_criterion_follows_load_and_curvature(usual):
    """A small contact on constant curvatures is one of Hertz's; a wide one, or one at a change, is not."""
    patch, model = usual.result.patches[1], usual.result.model
    wheel, rail = model.problem.wheels.wheel_of("right"), model.problem.track.rail_of("right")
    places = patch.wheel_point_mm, patch.rail_point_mm
    found = [conforming(wheel, places[0], rail, places[1], width) for width in (0.1, 6.0, 40.0)]
    assert found == [False, False, True]
    # at the end of the crown its radius of 254 mm becomes one of 31.75 mm
    end = np.array(rail.outline.part(["crown"]).segments[0].end)
    assert conforming(wheel, places[0], rail, end, 6.0)


def test_the_maximum_stress_below_a_wide_contact_is_not_that_of_the_web(conformed):
    """The maximum shear and von Mises stresses below a contact are sought within two half widths."""
    for contact in conformed.summary["patches"]:
        for body in ("in_rail", "in_wheel"):
            for name in ("max_in_plane_shear", "max_von_mises"):
                assert contact[f"{body}_{name}_depth_mm"] <= 2.0 * contact["half_width_mm"] * (1.0 + 1e-9)
