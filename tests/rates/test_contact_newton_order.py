"""Newton's method for contact converges quadratically once the active set has settled."""

from itertools import pairwise

import numpy as np
import pytest

from flangeway.contact import (
    Contact,
    ContactSolution,
    Multiplier,
    NodeToSegment,
    Pairing,
    Penalty,
    SegmentToSegment,
    press,
)
from flangeway.contact.enforcement import Enforcement
from flangeway.geometry import Placement, rectangle
from tests.contact.steel_boxes import BoxDiscretisation, Method, surface_of


def settled_steps(solution: ContactSolution) -> np.ndarray:
    """Residuals before and after each iteration that kept the active set; its square is above round-off.

    Nodes that penetrate after convergence get a constraint, so that the active set may settle more than once.
    """
    history = solution.state.history
    steps = [
        (before.residual, after.residual)
        for before, after in pairwise(history)
        if not (before.changed or after.changed) and before.residual**2 > np.finfo(float).eps / 4.0
    ]
    return np.array(steps)


def orders(steps: np.ndarray) -> np.ndarray:
    """Logarithm of each residual over that of the one before: near 2 for quadratic convergence, near 1 for linear."""
    return np.log(steps[:, 1]) / np.log(steps[:, 0])


@pytest.mark.parametrize("pairing", [NodeToSegment(), SegmentToSegment()], ids=["nodes", "segments"])
@pytest.mark.parametrize("enforcement", [Penalty(1e5, per="length"), Multiplier()], ids=["penalty", "multiplier"])
@pytest.mark.parametrize(("method", "order"), [("fem", 1), ("fem", 2), ("vem", 2)])
def test_quadratic_after_the_active_set_has_settled(
    pairing: Pairing, enforcement: Enforcement, method: Method, order: int, monkeypatch: pytest.MonkeyPatch
) -> None:
    """A tilted block pressed deep into a long one: the order of every settled iteration is above 1.6.

    Of iterations with their own derivatives: the last one takes those of the one before where this is enough.
    """
    monkeypatch.setattr("flangeway.contact.newton.CLOSE", 0.0)
    short = BoxDiscretisation(0.25, method, order).part("short", rectangle(2.0, 1.0, centre=(0.0, 0.5)), "top")
    long = BoxDiscretisation(0.3, method, order).part("long", rectangle(6.0, 2.0, centre=(0.0, -1.0)), "bottom")
    contact = Contact(surface_of(short, "bottom"), surface_of(long, "top"), pairing, enforcement)
    solution = press([contact], {short: Placement(0.03, (0.0, -0.1))})
    assert solution.status.converged, solution.status.message
    assert len(solution.steps) == 1
    steps = settled_steps(solution)
    assert len(steps) >= 2
    assert steps[:, 0].max() > 1e-4  # far enough from round-off to see an order
    assert orders(steps).min() > 1.6, steps
