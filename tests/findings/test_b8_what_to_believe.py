"""Row B8: warnings and the first picture are about stresses below contacts; Hertz stands beside contacts of his."""

import numpy as np
import pytest

from flangeway.cases import WheelsetTangentCase
from flangeway.cases.rigid.rigid_case import GeometryCase
from flangeway.cases.rigid.rigid_run import run_geometry
from flangeway.railway.profiles.measures import conforming
from flangeway.report.figures.fields import part_fields
from flangeway.report.wheelset.wheelset_figure import wheelset_figure
from flangeway.report.wheelset.wheelset_page import wheelset_record
from flangeway.report.wheelset.wheelset_tables import results_table, stresses_table


@pytest.fixture(scope="module")
def usual():
    """Contacts of Hertz: 136RE and AAR-1B."""
    return WheelsetTangentCase.from_values({"size_scale": 5.0}).run()


@pytest.fixture(scope="module")
def pushed():
    """A wheel that runs at the gauge side of an upright head: the web is bent, and stressed more than the contact."""
    return WheelsetTangentCase.from_values({"size_scale": 5.0, "rail_inclination": -0.05}).run()


@pytest.fixture(scope="module")
def conformed():
    """S1002 on 60E1 at 1:40, which touch where the tread's curvature changes."""
    values = {"size_scale": 5.0, "rail": "60E1", "wheel": "S1002", "gauge_mm": 1435.0, "back_to_back_mm": 1360.0}
    return WheelsetTangentCase.from_values(values).run()


def test_b8_yield_is_warned_of_by_the_stress_below_the_contact(pushed):
    """The factor of the warning is that of cells within two half widths of a contact, not that of the web."""
    strength = 510.0
    (warning,) = [each for each in pushed.summary.warnings if "exceed" in each]
    assert "below the contacts" in warning
    rails = [row for row in pushed.summary.to_dict()["stresses"] if row["part"].startswith("rail")]
    below = max(row["max_von_mises_below_contacts_MPa"] for row in rails)
    anywhere = max(row["max_von_mises_MPa"] for row in rails)
    assert f"{below / strength:.1f} times in the rail" in warning
    assert anywhere > 1.2 * below
    # below a contact of Hertz von Mises reaches 0.56 of the maximum pressure
    pressure = max(each["max_pressure_MPa"] for each in pushed.summary.to_dict()["contacts"])
    assert below == pytest.approx(0.56 * pressure, rel=0.25)


def test_b8_a_web_beyond_yield_alone_is_no_warning(pushed):
    """Where only web and fillets pass the strength that is given, nothing is said of yielding below contacts."""
    rails = [row for row in pushed.summary.to_dict()["stresses"] if row["part"].startswith("rail")]
    between = 0.5 * (
        max(row["max_von_mises_below_contacts_MPa"] for row in pushed.summary.to_dict()["stresses"])
        + max(row["max_von_mises_MPa"] for row in rails)
    )
    run = pushed.case.model_copy(update={"yield_MPa": between}).run()
    assert not any("yield" in each for each in run.summary.warnings)


def test_b8_the_first_picture_shows_what_may_be_believed(pushed):
    """Its scale ends at the stresses above the web, and the web is hatched, which its words say."""
    fields = list(part_fields(pushed.result))
    shown = max(part.stresses.von_mises[part.above_web].max() for part in fields)
    web = max(part.stresses.von_mises[~part.above_web].max() for part in fields if part.name.startswith("rail"))
    figure = wheelset_figure(pushed, fields)
    bar = figure.axes[-1]
    assert bar.get_xlim()[1] < 1.35 * shown
    assert web > shown * 1.05
    assert "hatched: web and foot" in bar.get_xlabel()
    assert sum(patch.get_hatch() is not None for axes in figure.axes for patch in axes.patches) == 2
    assert "not valid for a rail" in wheelset_record(pushed).pictures[0].caption


def test_b8_the_report_says_what_the_limits_say(usual):
    """Summary and tables mark the stresses of web, fillets and foot as those of a slice."""
    assert any("web, fillets and foot" in each for each in usual.summary.assumptions)
    assert "web and foot. Of the slice" in stresses_table(usual.summary).note


def test_b8_hertz_is_left_out_where_profiles_conform(usual, conformed):
    """Hertz's pressure stands beside a contact of constant curvature, and is marked beside one that conforms."""
    assert all(contact["hertz_pressure_MPa"] for contact in usual.summary.to_dict()["contacts"])
    assert all(contact["hertz_pressure_MPa"] is None for contact in conformed.summary.to_dict()["contacts"])
    rows = {row[0].strip(): row[1:] for row in results_table(conformed.summary).rows}
    assert set(rows["Hertz, MPa"]) == set(rows["Hertz, mm"]) == {"conforming"}
    assert any("Hertz's theory is left out" in each for each in conformed.summary.assumptions)
    assert not any("Hertz" in each for each in usual.summary.assumptions)


def test_b8_the_criterion_follows_load_and_curvature(usual):
    """A small contact on constant curvatures is one of Hertz's; a wide one, or one at a change, is not."""
    patch, model = usual.result.patches[1], usual.result.model
    wheel, rail = model.problem.wheelset.wheel_of("right"), model.problem.track.rail_of("right")
    places = patch.wheel_point_mm, patch.rail_point_mm
    found = [conforming(wheel, places[0], rail, places[1], width) for width in (0.1, 6.0, 40.0)]
    assert found == [False, False, True]
    # at the end of the crown its radius of 254 mm becomes one of 31.75 mm
    end = np.array(rail.outline.part(["crown"]).segments[0].end)
    assert conforming(wheel, places[0], rail, end, 6.0)


def test_b8_the_maximum_stress_below_a_wide_contact_is_not_that_of_the_web(conformed):
    """The maximum shear and von Mises stresses below a contact are sought within two half widths."""
    for contact in conformed.summary.to_dict()["contacts"]:
        for body in ("in_rail", "in_wheel"):
            for name in ("max_in_plane_shear", "max_von_mises"):
                assert contact[body][f"{name}_depth_mm"] <= 2.0 * contact["half_width_mm"] * (1.0 + 1e-9)


def test_b8_the_rigid_geometry_leaves_hertz_out_too():
    """`flangeway geometry` has no estimate of Hertz for contacts that conform, and one for others."""
    coarse = {"step_mm": 1.0, "maximum_lateral_mm": 2.0, "maximum_amplitude_mm": 1.0}
    for values, conforms in (({"rail": "60E1", "wheel": "S1002", "gauge_mm": 1435.0}, True), ({}, False)):
        contacts = run_geometry("a case", GeometryCase.from_values({**coarse, **values})).summary["equilibrium"][
            "contacts"
        ]
        assert [each["hertz_max_pressure_MPa"] is None for each in contacts] == [conforms] * 2
