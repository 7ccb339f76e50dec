"""The case of one patch that rolls: closed forms, given forces, shifts, and its files."""

import csv
import io
from types import SimpleNamespace

import meshio
import numpy as np
import pytest
from rich.console import Console

from flangeway.cases import load_case
from flangeway.exact import PointContact, contact_modulus
from flangeway.report.case_outputs import case_record, write_case
from flangeway.report.page.record import print_record

SMALL = {"cells_along": 14, "cells_across": 12, "curve": "none"}
"""Inputs of radii and rolling."""
PLANE = 210e3 / (1.0 - 0.3**2)


def run(**inputs):
    return load_case("rolling-patch", **(inputs if "motion" in inputs else {**SMALL, **inputs})).run()


def numbers(**inputs):
    return SimpleNamespace(**run(**inputs).summary)


def test_radii_give_hertz_and_large_creepage_the_limit_of_friction():
    """Semi-axes and maximum pressure within 2 % of Hertz; at 5 % creepage the force is friction times the load."""
    found = numbers(longitudinal_creepage=0.04, lateral_creepage=-0.03)
    hertz = PointContact(80e3, 300.0, 460.0, contact_modulus(PLANE, PLANE))
    assert (found.semi_axis_across_mm, found.semi_axis_along_mm) == pytest.approx(hertz.semi_axes, rel=0.02)
    assert found.max_pressure_MPa == pytest.approx(hertz.max_pressure, rel=0.02)
    assert (found.longitudinal_force_kN, found.lateral_force_kN) == pytest.approx((-0.8 * 24.0, 0.6 * 24.0), rel=1e-3)
    assert found.slipping_share == 1.0


def test_given_forces_are_met_by_the_creepages_that_are_found():
    """Forces given ahead and to the right come out, and their creepages, given, have these forces."""
    found = numbers(longitudinal_force_kN=-9.0, lateral_force_kN=4.0, spin_creepage_per_m=0.1)
    again = numbers(
        longitudinal_creepage=found.longitudinal_creepage,
        lateral_creepage=found.lateral_creepage,
        spin_creepage_per_m=0.1,
    )
    for each, limit in ((found, 1e-5), (again, 1e-3)):
        assert each.longitudinal_force_kN == pytest.approx(-9.0, rel=limit)
        assert each.lateral_force_kN == pytest.approx(4.0, rel=limit)


def test_a_shift_is_that_of_cattaneo_and_mindlin():
    """Spheres shifted by 0.875 of the limit stick within half of the radius; friction's work is positive."""
    found = numbers(
        motion={"kind": "shift", "longitudinal_force_kN": -0.875 * 24.0},
        patch={"radius_along_mm": 300.0},
    )
    assert np.sqrt(1.0 - found.slipping_share) == pytest.approx(0.5, abs=0.02)
    assert found.longitudinal_creepage is None
    assert found.theories == []
    assert found.shift_ahead_mm > 0.0
    assert found.dissipated_N_mm > 0.0


@pytest.mark.parametrize("theory", ["exact", "polach"])
def test_without_friction_there_is_no_force_by_any_theory(theory):
    """A coefficient of 0 is contact without friction: no force, no power, no curve."""
    found = run(friction=0.0, theory=theory, curve="longitudinal")
    assert found.status.converged
    assert not found.curve
    assert len(found.theories) > 3
    for each in found.theories:
        assert (each.forces.along, each.forces.across, each.forces.moment) == (0.0, 0.0, 0.0)


def test_the_curve_has_all_theories_from_zero_to_the_limit():
    """Each theory starts at no force with the slope of linear theory; all but this one end near the limit."""
    curve = run(curve="lateral", curve_points=9, longitudinal_creepage=0.0).curve
    assert list(curve) == ["exact", "fastsim", "fastrip", "polach", "linear"]
    for name, points in curve.items():
        forces = 1e-3 * np.array([point.forces.across for point in points])
        assert forces[0] == pytest.approx(0.0, abs=1e-9)
        assert (np.diff(forces) < 1e-9).all()
        assert forces[-1] == pytest.approx(-72.0 if name == "linear" else -24.0, rel=0.1)


def test_files_hold_the_forces_of_the_cells(tmp_path):
    """All files are there; pressures and tractions times area are the forces, in the table and in ParaView."""
    found = run(lateral_creepage=5e-4, curve="longitudinal", curve_points=3)
    files = write_case(found, tmp_path)
    assert {file.name for file in files} == {
        *("rolling.png", "tractions.png", "creep-curve.png", "creep-curve.csv", "cells.csv", "patch.vtu"),
        *("report.html", "summary.json"),
    }
    with (tmp_path / "cells.csv").open(encoding="utf-8") as file:
        rows = [{key: float(value) for key, value in row.items()} for row in csv.DictReader(file)]
    area = float(found.contact.areas[0, 0])
    for key, wanted in (
        ("pressure_MPa", 80.0), ("traction_ahead_MPa", 1e-3 * found.state.forces.along),
        ("traction_right_MPa", 1e-3 * found.state.forces.across),
    ):  # fmt: skip
        assert 1e-3 * area * sum(row[key] for row in rows) == pytest.approx(wanted, rel=1e-4)
    surface = meshio.read(tmp_path / "patch.vtu")
    corners = surface.cells[0].data
    assert surface.point_data["traction_MPa"][corners][:, 0].sum(axis=0) * area * 1e-3 == pytest.approx(
        [1e-3 * found.state.forces.across, 1e-3 * found.state.forces.along, 0.0], rel=1e-5
    )
    record = case_record(found)
    console = Console(file=io.StringIO(), width=80)
    print_record(console, record)
    for text in (console.file.getvalue(), (tmp_path / "report.html").read_text(encoding="utf-8")):
        assert f"{1e-3 * found.state.forces.along:.4f}".removeprefix("-") in text
    assert record.scene is not None
    shown = [field.key for field in record.scene().fields]
    wanted = "pressure_MPa", "traction_MPa", "slip_velocity_m_s", "frictional_power_W_mm2", "flash_temperature_K"
    assert shown == list(wanted)


def test_pressures_from_a_file_are_those_of_the_run_that_wrote_it(tmp_path):
    """`cells.csv` of a run, read as pressures beside a case file, gives its creep forces; half of it half the force."""
    motion = {"lateral_creepage": 5e-4, "spin_creepage_per_m": 0.2}
    before = run(**motion)
    write_case(before, tmp_path)
    lines = "\n".join(f"{key} = {value}" for key, value in motion.items())
    text = (
        f'case = "rolling-patch"\npatch = {{ kind = "file", file = "cells.csv" }}\n[motion]\ncurve = "none"\n{lines}\n'
    )
    (tmp_path / "patch.toml").write_text(text, encoding="utf-8")
    found = SimpleNamespace(**load_case(tmp_path / "patch.toml").run().summary)
    assert found.force_kN == pytest.approx(80.0, rel=1e-5)
    for name in ("longitudinal_force_kN", "lateral_force_kN", "spin_moment_Nm"):
        assert getattr(found, name) == pytest.approx(before.summary[name], rel=1e-4)
    header, *rows = (tmp_path / "cells.csv").read_text(encoding="utf-8").splitlines()
    right = [row for row in rows if float(row.split(",")[0]) > 0.0]
    (tmp_path / "cells.csv").write_text("\n".join([header, *right]), encoding="utf-8")
    half = SimpleNamespace(**load_case(tmp_path / "patch.toml").run().summary)
    assert half.force_kN == pytest.approx(40.0, rel=1e-5)
    assert half.semi_axis_across_mm < 0.7 * found.semi_axis_across_mm


def test_flash_temperature_and_reduced_slope_reach_the_summary():
    """The summary has the maximum of the cells; friction falls with it; half a slope is half a small force."""
    plain = run(longitudinal_creepage=0.02)
    summary = plain.parts()
    assert summary["flash_temperature_K"] == plain.state.forces.flash_temperatures.max()
    falls = {"falling": {"kinetic": 0.1, "between_C": [30.0, 200.0]}}
    warm = run(longitudinal_creepage=0.02, **falls).parts()
    assert abs(warm["longitudinal_force_kN"]) < 0.9 * abs(summary["longitudinal_force_kN"])
    assert "Polach" not in [row["theory"] for row in warm["theories"]]
    small = [run(longitudinal_creepage=1e-5, slope={"initial": factor}).state.forces.along for factor in (1.0, 0.5)]
    assert small[1] == pytest.approx(small[0] / 2.0, rel=0.01)
