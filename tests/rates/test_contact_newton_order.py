"""Newton's method for contact converges quadratically once the active set has settled."""

import numpy as np
import pytest

from flangeway.contact import Contact, ContactSolution, Multiplier, NodeToSegment, Penalty, SegmentToSegment, press
from flangeway.contact.contact import Pairing
from flangeway.contact.enforcement import Enforcement
from flangeway.geometry import Placement, rectangle
from flangeway.study.pressed_boxes import Discretisation, Method, surface_of


def settled_residuals(solution: ContactSolution) -> np.ndarray:
    """Residuals of the iterations after the last one that changed the active set."""
    history = solution.state.history
    last = max(number for number, iteration in enumerate(history) if iteration.changed)
    return np.array([iteration.residual for iteration in history[last + 1 :]])


def fitted_order(residuals: np.ndarray) -> float:
    """Slope of each residual over the one before, both in logarithms: 2 for quadratic convergence, 1 for linear."""
    logs = np.log(residuals)
    return float(np.polyfit(logs[:-1], logs[1:], 1)[0])


@pytest.mark.parametrize("pairing", [NodeToSegment(), SegmentToSegment()], ids=["nodes", "segments"])
@pytest.mark.parametrize("enforcement", [Penalty(1e5, per="length"), Multiplier()], ids=["penalty", "multiplier"])
@pytest.mark.parametrize(("method", "order"), [("fem", 1), ("fem", 2), ("vem", 2)])
def test_quadratic_after_the_active_set_has_settled(
    pairing: Pairing, enforcement: Enforcement, method: Method, order: int
) -> None:
    """A tilted block pressed deep into a long one: the order fitted to the settled iterations is 1.6 or more."""
    short = Discretisation(0.25, method, order).part("short", rectangle(2.0, 1.0, centre=(0.0, 0.5)), "top")
    long = Discretisation(0.3, method, order).part("long", rectangle(6.0, 2.0, centre=(0.0, -1.0)), "bottom")
    contact = Contact(surface_of(short, "bottom"), surface_of(long, "top"), pairing, enforcement)
    solution = press([contact], {short: Placement(0.03, (0.0, -0.1))})
    assert solution.status.converged, solution.status.message
    assert len(solution.steps) == 1
    residuals = settled_residuals(solution)
    assert len(residuals) >= 3
    assert residuals[0] > 1e-4  # far enough from round-off to see an order
    assert fitted_order(residuals) > 1.6, residuals  # the last one is round-off and lowers it


def test_the_fit_tells_linear_from_quadratic() -> None:
    """The fitted order of a linear sequence is 1, that of a quadratic one 2."""
    assert fitted_order(0.1 ** np.arange(1.0, 6.0)) == pytest.approx(1.0)
    assert fitted_order(0.1 ** (2.0 ** np.arange(4.0))) == pytest.approx(2.0)
