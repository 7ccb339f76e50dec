"""The benchmark of the block on small problems, and what its peers are given."""

import pytest

from benchmarks.friction import FRICTION, push_block
from benchmarks.hertz_block import mesh_block, press_block

pytestmark = pytest.mark.ci


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
