"""What the command line says where nothing can be written, and of inputs beyond any wheelset."""

import subprocess
import sys
from pathlib import Path

import pytest

from flangeway.cases import load_case

FULL = Path("/dev/full")
COARSE = {"size_scale": 6.0, "mesh.order": 1, "support": "continuous"}


@pytest.mark.skipif(not FULL.exists(), reason="no device that is always full")
@pytest.mark.parametrize("words", [["--help"], ["profile", "60E1", "--json", "--no-pictures"], ["--version"]])
def test_a_full_output_is_a_message_and_a_failure(words, tmp_path):
    """Texts and results that cannot be written end with status 1 and one message, long or short ones."""
    with FULL.open("w") as full:
        done = subprocess.run(
            [sys.executable, "-m", "flangeway", *words],
            stdout=full,
            stderr=subprocess.PIPE,
            text=True,
            cwd=tmp_path,
            check=False,
        )
    assert done.returncode == 1
    assert "cannot be written" in done.stderr
    assert "internal error" not in done.stderr
    assert "Exception ignored" not in done.stderr


@pytest.mark.parametrize("lateral", [-1e30, 1e4])
def test_a_lateral_position_beyond_any_track_is_no_equilibrium(lateral):
    """No wheel stands at a lateral position of kilometres: not converged, in the words of the key."""
    status = load_case("wheelset", **COARSE, lateral_mm=lateral).run().status
    assert not status.converged
    assert "lateral_mm" in status.message
