"""Tables of the cells of patches, column by column beside sums, closed forms of half-spaces, and laws of friction."""

import csv
import math

import numpy as np
import pytest

from flangeway.cases import load_case
from flangeway.report.case_outputs import case_record
from flangeway.report.page.html_page import write_record


def columns(file):
    """Columns of a CSV file by name, numbers as arrays."""
    with file.open(encoding="utf-8") as lines:
        rows = list(csv.DictReader(lines))
    words = {"side", "region"}
    return {
        name: np.array([row[name] if name in words else float(row[name] or "nan") for row in rows]) for name in rows[0]
    }


def loves_displacements(x, z, half_x, half_z, pressures, compliance):
    """Displacements of a half-space at middles (n,) of rectangles under pressure: Love (1929)."""

    def part(a, b):
        return a * np.arcsinh(b / np.abs(a)) + b * np.arcsinh(a / np.abs(b))

    dx, dz = x[:, None] - x, z[:, None] - z
    ends = [sx * sz * part(dx + sx * half_x, dz + sz * half_z) for sx in (1.0, -1.0) for sz in (1.0, -1.0)]
    return compliance * sum(ends) @ pressures


@pytest.fixture(scope="module")
def crossed(tmp_path_factory):
    """Two cylinders across each other, and their table."""
    folder = tmp_path_factory.mktemp("crossed")
    run = load_case("crossed-cylinders", order=1).run()
    write_record(case_record(run), folder, pictures=False)
    return run, columns(folder / "cells.csv")


def test_cells_of_crossed_cylinders(crossed):
    """Pressures sum to 10 kN, gaps are closed, overlaps are parabolas, displacements are those of Love to 2 %."""
    run, cells = crossed
    assert (cells["pressure_MPa"] * cells["area_mm2"]).sum() == pytest.approx(10e3, rel=1e-3)
    assert np.abs(cells["gap_mm"]).max() < 1e-8
    assert cells["normal_displacement_mm"] == pytest.approx(-cells["undeformed_gap_mm"], abs=1e-8)
    s, z = cells["along_surface_mm"], cells["z_mm"]
    parabola = np.column_stack((np.ones_like(s), s**2, z**2, s * z, s, z))
    fitted, *_ = np.linalg.lstsq(parabola, cells["undeformed_gap_mm"], rcond=None)
    assert parabola @ fitted == pytest.approx(cells["undeformed_gap_mm"], abs=0.01 * run.contact.approach)
    half_x, half_z = (np.diff(np.unique(values)).min() / 2.0 for values in (s, z))
    half_x = cells["area_mm2"] / (4.0 * half_z)
    compliance = 2.0 * (1.0 - 0.3**2) / (math.pi * 210e3)
    love = loves_displacements(s, z, half_x, half_z, cells["pressure_MPa"], compliance)
    ours = cells["normal_displacement_mm"]
    # what lies further away than the patch moves all of its cells alike
    assert ours - ours.mean() == pytest.approx(love - love.mean(), abs=0.02 * np.ptp(love))


ROLLS = {
    "rolling.friction": 0.3,
    "load.curve": {"radius_m": 500, "speed_km_h": 80, "superelevation_mm": 60},
    "mesh.size_scale": 6,
    "mesh.order": 1,
    "contact.patch_cells": 10,
}


def test_cells_of_a_rolling_wheelset(tmp_path):
    """Of each patch pressures and tractions sum to its forces, power to its T-gamma, and friction bounds tractions."""
    run = load_case("wheelset", **ROLLS).run()
    write_record(case_record(run), tmp_path, pictures=False)
    cells = columns(tmp_path / "cells.csv")
    for patch in run.summary["patches"]:
        here = (cells["side"] == patch["side"]) & (cells["region"] == patch["region"])
        area, pressure = cells["area_mm2"][here], cells["pressure_MPa"][here]
        assert (pressure * area).sum() == pytest.approx(1e3 * patch["normal_force_kN"], rel=1e-3)
        traction = np.array([cells[f"traction_{word}_MPa"][here] for word in ("ahead", "right")])
        forces = 1e-3 * (traction * area).sum(axis=1)
        assert forces == pytest.approx(
            [patch["longitudinal_creep_force_kN"], patch["lateral_creep_force_kN"]], rel=1e-4, abs=1e-4
        )
        assert (np.hypot(*traction) <= 0.3 * pressure * (1.0 + 1e-3) + 1e-6).all()
        slip = np.array([cells[f"slip_velocity_{word}_m_s"][here] for word in ("ahead", "right")])
        slips = cells["stick_slip_state"][here] == 2.0
        along = -(traction * slip).sum(axis=0)[slips] / (np.hypot(*traction) * np.hypot(*slip))[slips]
        assert np.median(along) > 0.99  # slip is against the traction on the wheel
        assert np.abs(cells["gap_mm"][here]).max() < 2e-6
        point = [(cells[f"{axis}_mm"][here] * pressure * area).sum() / (pressure * area).sum() for axis in "xyz"]
        assert point == pytest.approx(patch["track_position_mm"], abs=0.05)


def test_displacements_of_cells_that_stick(tmp_path):
    """Under a shift below sliding, cells that stick are displaced by the shift, the others by less."""
    case = {"motion": {"kind": "shift", "shift_ahead_mm": 0.004}, "patch.cells_along": 24, "patch.cells_across": 16}
    run = load_case("rolling-patch", **case).run()
    write_record(case_record(run), tmp_path, pictures=False)
    cells = columns(tmp_path / "cells.csv")
    sticks = cells["stick_slip_state"] == 1.0
    assert 0.2 < sticks.mean() < 0.9
    assert np.ptp(cells["tangential_displacement_ahead_mm"][sticks]) < 1e-5
