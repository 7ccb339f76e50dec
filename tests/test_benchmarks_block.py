"""The benchmark of the block on small problems, and what its peers are given."""

import re
from pathlib import Path

import numpy as np
import pytest

from benchmarks.friction import FRICTION, memory, push_block
from benchmarks.hertz_block import HERTZ, mesh_block, press_block
from benchmarks.hertz_block_peers import bodies
from benchmarks.peers import PeerMissingError, run_python
from benchmarks.peers.calculix_deck import deck

pytestmark = pytest.mark.ci


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


def test_the_pushed_block_has_cattaneos_and_mindlins_traction() -> None:
    """On a coarse mesh the tangential traction in the middle is within 2 % under the forces found."""
    block = mesh_block(0.15, 0.3)
    found = push_block(block, press_block(block).approach)
    assert 0.05 < found.tangential_force / found.force < FRICTION
    assert abs(found.centre_traction_error(FRICTION)) < 0.02


def test_tractions_come_nearer_to_those_of_a_finer_mesh() -> None:
    """Edges of 0.15 mm are nearer to those of 0.07 mm than edges of 0.3 mm, within 2.5 % of mu p0."""
    coarse, middle, fine = (
        push_block(block, press_block(block).approach) for block in (mesh_block(h, 0.3) for h in (0.3, 0.15, 0.07))
    )
    differences = [each.traction_difference(fine, FRICTION) for each in (coarse, middle, fine)]
    assert differences[0] > differences[1] > differences[2] == 0.0
    assert differences[1] < 0.025


def test_memory_is_that_of_a_process_of_its_own() -> None:
    """The peak is measured for the number of unknowns asked, and is plausible."""
    more = memory(120).more
    assert 50.0 < more["peak_memory_MB"] < 2000.0


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
