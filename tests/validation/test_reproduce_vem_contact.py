"""Node-to-node contact with inserted nodes: `flangeway reproduce vem-contact`."""

import pytest

from studies.vem_contact.vem_contact_reproduced import (
    short_edge_row,
)


def test_short_edges_leave_force_and_pressure_as_they_are() -> None:
    """Order 1 on M1: edges of a hundredth and of a millionth give the same force to 1e-4 and errors to 10 %."""
    long, short = (short_edge_row("VVO1", 1, ratio) for ratio in (1e-2, 1e-6))
    assert long.n_constraints == short.n_constraints
    assert short.force == pytest.approx(long.force, rel=1e-4)
    assert short.rms == pytest.approx(long.rms, rel=0.1)
    assert short.peak < 1.1
