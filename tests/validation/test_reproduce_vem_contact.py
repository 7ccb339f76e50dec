"""Node-to-node contact with inserted nodes: `flangeway reproduce vem-contact`."""

from dataclasses import replace

import pytest

from studies.vem_contact.vem_contact_chapter import VEM_CONTACT
from studies.vem_contact.vem_contact_reproduced import (
    CODES,
    LEVELS,
    PAIRINGS,
    RATIOS,
    VemContactReproduction,
    hertz_row,
    hertz_rows,
    reproduce_vem_contact,
    short_edge_row,
)


@pytest.mark.ci
def test_all_numbers_are_as_on_the_page(same_as_page) -> None:
    """Patch tests to round-off, pressures of three pairings and with short edges, every row in the file."""
    found = reproduce_vem_contact()
    assert found.passed
    same_as_page(VEM_CONTACT.chapter, found, whole=True)
    assert len(hertz_rows(found)) == len(CODES) * len(LEVELS) * len(PAIRINGS) + 2 * len(RATIOS)
    assert all(row["cpu_s"] > 0.0 for row in hertz_rows(found))


def test_inserted_nodes_give_the_pressure_of_averages_without_averages() -> None:
    """Order 2 on M1: the maximum is Hertz's to 0.5 %, as by segments; nodes against segments are five times as far."""
    rows = {pairing: hertz_row("VDO2", 1, pairing) for pairing in PAIRINGS}
    assert all(row.converged for row in rows.values())
    assert rows["node-to-node"].peak == pytest.approx(1.0, abs=5e-3)
    assert rows["node-to-segment"].rms > 5.0 * rows["node-to-node"].rms
    assert rows["node-to-node"].force == pytest.approx(rows["segment-to-segment"].force, rel=1e-3)
    assert rows["node-to-node"].n_constraints > rows["segment-to-segment"].n_constraints
    found = VemContactReproduction(numbers=(), seconds=0.0, patches=(), rows=tuple(rows.values()), short=())
    assert found.passed
    worse = replace(rows["node-to-node"], rms=1.0), replace(rows["segment-to-segment"], converged=False)
    found = replace(found, rows=(*worse, rows["node-to-segment"]))
    assert [text.split(":")[0] for text in found.failures] == ["VDO2M1, segment-to-segment", "VDO2M1"]


def test_short_edges_leave_force_and_pressure_as_they_are() -> None:
    """Order 1 on M1: edges of a hundredth and of a millionth give the same force to 1e-4 and errors to 10 %."""
    long, short = (short_edge_row("VVO1", 1, ratio) for ratio in (1e-2, 1e-6))
    assert long.n_constraints == short.n_constraints
    assert short.force == pytest.approx(long.force, rel=1e-4)
    assert short.rms == pytest.approx(long.rms, rel=0.1)
    assert short.peak < 1.1
