"""A pressure that oscillates is recognised beside edge peaks, and is printed with the reason not to rely on it."""

import json
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from flangeway.cases.bodies.presets import HertzCase
from flangeway.cases.bodies.two_bodies import TwoBodiesCase
from flangeway.post.pressure import oscillation_of
from flangeway.report.bodies.bodies_page import results_table
from flangeway.report.case_outputs import write_case


def punch(**changes: Any) -> TwoBodiesCase:
    """A flat punch of quadratic elements pushed on a block."""
    contact = {"secondary": "punch", "secondary_edges": "bottom", "primary": "block", "primary_edges": "top", **changes}
    near = {"at_mm": [[-6.0, 0.0], [6.0, 0.0]], "size_mm": 0.42}
    return TwoBodiesCase.from_values(
        {
            "bodies": [
                {
                    "name": "punch",
                    "rectangle": {"width_mm": 10.0, "height_mm": 10.0, "centre_mm": [0.0, 5.0]},
                    "size_mm": 0.5,
                    "order": 2,
                },
                {
                    "name": "block",
                    "rectangle": {"width_mm": 60.0, "height_mm": 30.0, "centre_mm": [0.0, -15.0]},
                    "size_mm": 3.0,
                    "order": 2,
                    "fine": [near],
                },
            ],
            "supports": [{"body": "punch", "edges": "top"}, {"body": "block", "edges": "bottom"}],
            "motions": [{"body": "punch", "push_N": [0.0, -1000.0]}],
            "contacts": [contact],
        }
    )


@pytest.mark.parametrize("peak", [1.0, 5.0, 20.0, 100.0])
def test_a_peak_does_not_hide_an_alternating_pressure(peak: float) -> None:
    """Nodes of 0.77 and 1.23 in turn oscillate by 46 % whatever peaks are at the ends; smooth ones by less than 2 %."""
    for n in (8, 15, 40):
        pressures = 1.0 + 0.23 * (-1.0) ** np.arange(n)
        pressures[[0, -1]] = peak
        assert oscillation_of(pressures) == pytest.approx(0.46)
        for shift in np.linspace(0.05, 0.95, 10):
            places = 2.0 * (np.arange(n) + shift) / n - 1.0
            assert oscillation_of(np.sqrt(1.0 - places**2)) < 0.02
            assert oscillation_of(1.0 / np.sqrt(1.0 - places**2)) < 0.02


def test_an_oscillating_pressure_is_printed_with_its_mark(tmp_path: Path) -> None:
    """Pressures of nodes and multipliers under a flat punch are warned about, and marked wherever they are printed."""
    run = punch(pairing="node-to-segment", enforcement="multiplier").run()
    assert run.status.converged
    assert any("oscillates by" in notice for notice in run.summary["notices"])
    (contact,) = run.summary["contacts"]
    remark = contact["max_pressure_remark"]
    assert remark.startswith("oscillates by ")
    assert contact["patches"][0]["max_pressure_remark"] == remark
    (shown,) = (text for name, text in results_table(run).rows if "maximum pressure" in name)
    assert (shown, shown.remark) == (f"{contact['max_pressure_MPa']:.6g}", remark)
    write_case(run, tmp_path)
    assert json.loads((tmp_path / "summary.json").read_text())["contacts"][0]["max_pressure_remark"] == remark
    page = (tmp_path / "report.html").read_text()
    # in the tile and in the table
    assert page.count(f'title="{remark}"') >= 2
    assert f"≈ {remark}" in page


def test_too_few_segments_are_a_mark() -> None:
    """A contact of a few segments has its number beside the pressure, in the results of the Hertz case too."""
    run = HertzCase.from_values({"size_mm": 1.0}).run()
    (contact,) = run.summary["contacts"]
    assert "wide" in contact["max_pressure_remark"]
    assert run.summary["results"]["max_pressure_remark"] == contact["max_pressure_remark"]
    rows = dict(results_table(run).rows)
    assert not any("remark" in name for name in rows)
    assert ["wide" in text.remark for name, text in rows.items() if name.startswith("maximum pressure, MPa")] == [True]
