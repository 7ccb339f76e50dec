"""The block's benchmark, the growth and the page of all benchmarks, on small problems."""

import re
from pathlib import Path

import numpy as np
import pytest

from benchmarks import growth, report
from benchmarks.__main__ import ABOUTS
from benchmarks.hertz_block import HERTZ, mesh_block, press_block
from benchmarks.hertz_block_peers import bodies
from benchmarks.measurement import Measurement
from benchmarks.peers import PeerMissingError, run_python
from benchmarks.peers.calculix_deck import deck


def test_the_block_is_the_published_contact() -> None:
    """A half cylinder of 100 mm under 2000 N/mm touches on 2 x 1.4856 mm with 857.07 MPa by Hertz."""
    assert HERTZ.half_width == pytest.approx(1.4856, abs=5e-5)
    assert HERTZ.max_pressure == pytest.approx(857.07, abs=5e-3)


@pytest.mark.parametrize("n_steps", [1, 3])
def test_the_block_finds_hertz_under_the_load(n_steps: int) -> None:
    """On a coarse mesh, in one step or several, the load is borne to 1e-8 and the pressure is within 1 %."""
    found = press_block(mesh_block(0.15, 0.3), n_steps)
    assert found.force_error is not None
    assert found.force_error < 1e-8
    assert abs(found.peak_error) < 0.01
    assert abs(found.half_width_error) < 0.01


def test_the_peers_get_the_same_nodes() -> None:
    """Triangles of order 2 and their quarters are counter-clockwise, of one area, and middles lie on the circle."""
    block = mesh_block(0.3, 0.4)
    upper, lower = bodies(block)
    assert len(upper.points) + len(lower.points) == block.n_nodes
    for body in (upper, lower):
        areas = []
        for corners in (body.triangles[:, :3], body.quarters):
            a, b, c = (body.points[corners[:, i]] for i in range(3))
            doubled = (b - a)[:, 0] * (c - a)[:, 1] - (b - a)[:, 1] * (c - a)[:, 0]
            assert (doubled > 0.0).all()
            areas.append(float(doubled.sum()) / 2.0)
        assert areas[0] == pytest.approx(areas[1], rel=1e-4)
    middles = upper.points[upper.contact[:, 2]]
    assert np.hypot(middles[:, 0], middles[:, 1] - 100.0) == pytest.approx(100.0, abs=1e-9)


def test_calculix_gets_each_contact_edge_once() -> None:
    """The deck names one face of a triangle for every contact edge of both bodies."""
    upper, lower = bodies(mesh_block(0.3, 0.4))
    first = len(upper.points)
    text = deck(
        np.vstack((upper.points, lower.points)),
        (upper.triangles, lower.triangles + first),
        (upper.contact[:, :2], lower.contact[:, :2] + first),
        (upper.held, lower.held + first),
        young=210e3,
        poisson=0.3,
        penalty=1e7,
        approach=0.05,
        n_steps=1,
    )
    assert len(re.findall(r"^\d+,S[123]$", text, re.MULTILINE)) == len(upper.contact) + len(lower.contact)


def test_a_missing_peer_is_named(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """A peer that is not installed raises an error with the command that installs it."""
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path))
    with pytest.raises(PeerMissingError, match=re.escape("sh benchmarks/peers/install.sh kratos")):
        run_python("kratos", "kratos_block.py")


def test_growth_tells_exponents() -> None:
    """Small sizes solve to round-off, and an exponent is the slope of the logarithms."""
    *sizes, last = growth.quick()
    assert len(sizes) == len(growth.QUICK)
    assert all(size.ours_accuracy is not None and size.ours_accuracy < 1e-9 for size in sizes)
    assert all(size.more["peak_mb"] >= size.more["before_mb"] > 0 for size in sizes)
    assert set(last.more["exponents"]) == {"assembly", "factor", "solve", "total", "peak_mb"}
    squares = growth.Growth(tuple({"unknowns": n, "total": n**1.5} for n in (10, 100, 1000)))
    assert squares.exponent("total") == pytest.approx(1.5)


def test_the_page_holds_what_was_recorded(tmp_path: Path) -> None:
    """The page has what is measured, rows with the recorded times, ratios and accuracies, versions and the machine."""
    met = Measurement("some work", "peer", 0.5, 2.0, 1e-3, 2e-2, "a note", "1.2", 3.0, {"peak_mb": 7, "asked_mb": None})
    missed = Measurement(
        "more work", "peer", 0.5, 0.6, None, None, "", "1.2", 3.0, {"peak_mb": 1234.5, "asked_mb": 9.5}
    )
    missing = Measurement("other work", "rival", 0.5, None, None, None, "not installed", "", 2.0)
    alone = Measurement("growth", "none", 5.0, None, None, None, more={"exponents": {"factor": 1.25, "solve": 1.1}})
    report.record("one-name", [met, missed, missing, alone], tmp_path)
    abouts = {"other": "Not recorded.", "one-name": "What it is.\n\n    Time is from ``a`` to b.\n    "}
    page = report.write(abouts, tmp_path, tmp_path / "page.md").read_text(encoding="utf-8")
    assert "| 1 | some work | peer 1.2 | 0.5 | 2 | 4 | 3 | 0.001 | 0.02 |" in page
    assert "| 2 | more work | peer 1.2 | 0.5 | 0.6 | **1.2** | 3 |  |  |" in page
    assert "| 3 | other work | rival | 0.5 | not measured |  | 2 |  |  |" in page
    assert "| 4 | growth |  | 5 |  |  |  |  |  |" in page
    assert "- 1: a note\n- 3: not installed" in page
    assert "|  | peak mb | goal mb |\n| --- | --- | --- |\n| 1 | 7 |  |\n| 2 | 1234 | 9.5 |" in page
    assert "|  | measured | factor | solve |\n| --- | --- | --- | --- |\n| 4 | exponents | 1.25 | 1.1 |" in page
    assert "| [One name](#one-name) | more work | peer 1.2 | **1.2** | 3 |" in page
    assert "\n\n## One name\n\n" in page
    assert "What it is.\n\nTime is from `a` to b." in page
    assert "processors" in page
    assert "; flangeway " in page
    assert "Not recorded" not in page


def test_a_part_measured_again_keeps_the_others(tmp_path: Path) -> None:
    """What is recorded under one name replaces that alone, and parts stand in the order of the names given."""
    for name, work in (("second", "old"), ("first", "kept"), ("second", "new")):
        report.record(name, [Measurement(work, "none", 1.0, None, None, None)], tmp_path)
    page = report.write({"first": "", "second": ""}, tmp_path, tmp_path / "page.md").read_text(encoding="utf-8")
    assert page.index("## First") < page.index("| kept |") < page.index("## Second") < page.index("| new |")
    assert "| old |" not in page


def test_the_page_of_performance_is_made_of_the_records(tmp_path):
    """The page in the documentation is what the kept records of measurements make, to the letter."""
    page = report.write(ABOUTS, page=tmp_path / "performance.md")
    assert page.read_text(encoding="utf-8") == report.PAGE.read_text(encoding="utf-8")
    assert len(list(report.RECORDS.glob("*.json"))) == len(ABOUTS)
