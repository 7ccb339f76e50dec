"""The benchmark of plane elasticity runs on small meshes, and all programs in it agree."""

import os
import re
import subprocess
import sys
from pathlib import Path

import pytest

pytest.importorskip("skfem")
ROOT = Path(__file__).parents[1]


def run(*arguments: str) -> subprocess.CompletedProcess[str]:
    """``python -m benchmarks`` with arguments."""
    command = [sys.executable, "-m", "benchmarks", *arguments]
    return subprocess.run(command, cwd=ROOT, env=os.environ.copy(), capture_output=True, text=True, check=False)


def test_the_quick_run_prints_its_table_and_all_agree() -> None:
    """All eight measurements print a time and memory, and results of the programs agree to 1e-10."""
    done = run("elasticity", "--quick")
    assert done.returncode == 0, done.stderr
    lines = done.stdout.splitlines()
    timed = [re.search(r" (\d+\.\d{3}) +\d+\.\d{3} .* (\d+) +(\d+)$", line) for line in lines]
    times = [[float(number) for number in found.groups()] for found in timed if found]
    assert len(times) == 8
    assert all(seconds > 0.0 and peak >= before > 0.0 for seconds, peak, before in times)
    differences = [float(number) for number in re.findall(r"differ by (\S+)", done.stdout)]
    assert len(differences) == 3
    assert max(differences) < 1e-10


def test_quick_is_refused_where_it_does_nothing() -> None:
    """The option is refused for benchmarks that have no small meshes, and the message names the one that has."""
    done = run("torsion-assembly", "--quick")
    assert done.returncode == 2
    assert "python -m benchmarks elasticity --quick" in done.stderr
