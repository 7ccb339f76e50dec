"""Orders of convergence on curved edges, and with chords."""

import math

import pytest

from flangeway.elements import Lagrange, Virtual
from studies.curved import solved

ORDERS = [("Lamé", Virtual(2), 1.75), ("Lamé", Virtual(3), 2.65), ("Lamé", Virtual(4), 3.5), ("Lamé", Lagrange(3), 2.8)]
ORDERS += [("Kirsch", Virtual(2), 1.75), ("Kirsch", Virtual(3), 2.6), ("Kirsch", Virtual(4), 3.5)]
ORDERS += [("torsion", Virtual(4), 3.6), ("torsion", Lagrange(2), 2.0)]


@pytest.mark.parametrize(("body", "element", "least"), ORDERS, ids=repr)
def test_the_energy_error_decreases_with_the_order_on_curved_edges(body: str, element, least: float) -> None:
    """From 8 to 16 cells the error on curved edges has nearly the order of the element, or a higher one."""
    levels = (4, 8) if body == "torsion" else (8, 16)
    coarse, fine = (solved(body, element, level, on_curves=True)[0] for level in levels)
    assert math.log2(coarse / fine) > least


@pytest.mark.parametrize("element", [Virtual(4), Lagrange(3)], ids=repr)
def test_with_chords_the_order_is_one_and_a_half(element) -> None:
    """The same meshes with chords err ten times as much or more with half-integer order, whatever the element."""
    coarse, fine = (solved("Lamé", element, level, on_curves=False)[0] for level in (8, 16))
    assert abs(math.log2(coarse / fine) - 1.5) < 0.2
    assert fine > 10.0 * solved("Lamé", element, 16, on_curves=True)[0]


def test_the_stress_at_the_hole_improves_with_every_order() -> None:
    """Stress over tension above Kirsch's hole: 8 %, 0.3 %, 0.02 % and 0.002 % from 3 for orders 1 to 4."""
    for order, limit in ((1, 0.08), (2, 3e-3), (3, 2e-4), (4, 2e-5)):
        peak = solved("Kirsch", Virtual(order), 8, on_curves=True)[1]
        assert abs(peak / 3.0 - 1.0) < limit
