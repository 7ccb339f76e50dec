"""Newton's method for contact converges quadratically once the active set has settled."""

import numpy as np
import pytest

from flangeway.contact import ContactSolution, Multiplier, NodeToSegment, Penalty, SegmentToSegment
from flangeway.contact.contact import Pairing
from flangeway.contact.enforcement import Enforcement
from flangeway.geometry import Placement
from flangeway.study.contact_cases import ContactCase, Discretisation, Method, block_on_long_block

ROUND_OFF = 1e-13


def settled_changes(solution: ContactSolution) -> np.ndarray:
    """Changes of the displacements in the iterations after the last one that changed the active set."""
    history = solution.state.history
    last = max(number for number, iteration in enumerate(history) if iteration.changed)
    changes = np.array([iteration.change for iteration in history[last + 1 :]])
    return changes[changes > ROUND_OFF]


def fitted_order(changes: np.ndarray) -> float:
    """Slope of each change over the one before, both in logarithms: 2 for quadratic convergence, 1 for linear."""
    logs = np.log(changes)
    return float(np.polyfit(logs[:-1], logs[1:], 1)[0])


@pytest.mark.parametrize("pairing", [NodeToSegment(), SegmentToSegment()], ids=["nodes", "segments"])
@pytest.mark.parametrize("enforcement", [Penalty(1e5, per="length"), Multiplier()], ids=["penalty", "multiplier"])
@pytest.mark.parametrize(("method", "order"), [("fem", 1), ("fem", 2), ("vem", 2)])
def test_quadratic_after_the_active_set_has_settled(
    pairing: Pairing, enforcement: Enforcement, method: Method, order: int
) -> None:
    """A tilted block pressed deep into a long one: the order fitted to the settled iterations is 1.7 or more."""
    case = block_on_long_block(
        Discretisation(0.25, method, order), Discretisation(0.3, method, order), pairing, enforcement
    )
    solution = ContactCase(case.contacts, {case.part("upper"): Placement(0.03, (0.0, -0.1))}).solve()
    assert solution.status.converged, solution.status.message
    assert len(solution.steps) == 1
    changes = settled_changes(solution)
    assert len(changes) >= 3
    assert changes[0] > 1e-3  # far enough from round-off to see an order
    assert fitted_order(changes) > 1.7, changes


def test_the_fit_tells_linear_from_quadratic() -> None:
    """The fitted order of a linear sequence is 1, that of a quadratic one 2."""
    assert fitted_order(0.1 ** np.arange(1.0, 6.0)) == pytest.approx(1.0)
    assert fitted_order(0.1 ** (2.0 ** np.arange(4.0))) == pytest.approx(2.0)
