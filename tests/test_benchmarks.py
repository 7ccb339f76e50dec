"""The benchmarks run on small problems, with and without the programs that they compare with; their page."""

import json
import os
import subprocess
import sys
from pathlib import Path
from typing import Any

import pytest

from benchmarks import report
from benchmarks.__main__ import ABOUTS, CAMPAIGNS
from benchmarks.friction import FRICTION, push_block
from benchmarks.hertz_block import mesh_block, press_block

pytestmark = pytest.mark.ci

ROOT = Path(__file__).parents[1]
KEYS = {"work", "peer", "ours_s", "peer_s", "ratio", "ours_accuracy", "peer_accuracy", "versions"}


def run(*arguments: str, cache: Path) -> subprocess.CompletedProcess[str]:
    """``python -m benchmarks`` with arguments, its peers looked for in a folder."""
    command = [sys.executable, "-m", "benchmarks", *arguments]
    environment = os.environ | {"XDG_CACHE_HOME": str(cache)}
    return subprocess.run(command, cwd=ROOT, env=environment, capture_output=True, text=True, check=False)


@pytest.mark.parametrize(("name", "n_lines", "worst"), [("torsion-assembly", 6, 1e-10), ("torsion-sections", 4, 1e-3)])
def test_without_peers_a_line_tells_how_to_install_them(name: str, n_lines: int, worst: float, tmp_path: Path) -> None:
    """Each line is JSON with all keys, our time and a small error; a missing peer's says how to install it."""
    lines_without_peers(name, n_lines, worst, tmp_path)


def lines_without_peers(name: str, n_lines: int, worst: float, cache: Path) -> list[dict[str, Any]]:
    """All lines of a benchmark, checked."""
    done = run("--quick", name, cache=cache)
    assert done.returncode == 0, done.stderr
    lines = [json.loads(line) for line in done.stdout.splitlines()]
    assert len(lines) == n_lines
    for line in lines:
        assert set(line) >= KEYS
        assert line["ours_s"] > 0.0
        assert line["ours_accuracy"] is None or abs(line["ours_accuracy"]) < worst
        if line["peer"] not in {"scipy", "flangeway"}:
            assert line["peer_s"] is None
            assert f"sh benchmarks/peers/install.sh {line['peer']}" in line["note"]
    return lines


def test_scipy_solves_the_same_equations(tmp_path: Path) -> None:
    """SuperLU's solution of the benchmark's equations leaves a residual of round-off, as ours does."""
    lines = lines_without_peers("elasticity", 11, 1e-10, tmp_path)
    found = [line for line in lines if line["peer"] == "scipy"]
    assert len(found) == 2
    assert all(max(line["ours_accuracy"], line["peer_accuracy"]) < 1e-13 for line in found)


@pytest.mark.parametrize("n_steps", [1, 3])
def test_the_block_finds_hertz_under_the_load(n_steps: int) -> None:
    """On a coarse mesh, in one step or several, the load is borne to 1e-8 and the pressure is within 1 %."""
    found = press_block(mesh_block(0.15, 0.3), n_steps)
    assert found.force_error is not None
    assert found.force_error < 1e-8
    assert abs(found.peak_error) < 0.01
    assert abs(found.half_width_error) < 0.01


def test_the_pushed_block_has_cattaneos_and_mindlins_traction() -> None:
    """On a coarse mesh the tangential traction in the middle is within 2 % under the forces found."""
    block = mesh_block(0.15, 0.3)
    found = push_block(block, press_block(block).approach)
    assert 0.05 < found.tangential_force / found.force < FRICTION
    assert abs(found.centre_traction_error(FRICTION)) < 0.02


def test_the_page_of_performance_is_made_of_the_records(tmp_path: Path) -> None:
    """The page in the documentation is what the kept records of measurements make, to the letter."""
    page = report.write(ABOUTS, page=tmp_path / "performance.md")
    assert page.read_text(encoding="utf-8") == report.PAGE.read_text(encoding="utf-8")
    assert {path.stem for path in report.RECORDS.glob("*.json")} == set(ABOUTS) - CAMPAIGNS
