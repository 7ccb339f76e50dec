"""The benchmark of the block on small problems, and what its peers are given."""

import numpy as np
import pytest

from benchmarks.friction import FRICTION, push_block
from benchmarks.hertz_block import HERTZ, mesh_block, press_block
from benchmarks.hertz_block_peers import bodies

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
