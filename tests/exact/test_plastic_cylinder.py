"""Thick cylinder of a perfectly plastic steel beyond first yield; other elements are in `flangeway reproduce forms`."""

import numpy as np
import pytest

from flangeway.elements import StabilisationFree
from flangeway.space import Space
from studies.forms import half_plastic, mapped, rim_displacement, ring


def test_elements_without_stabilisation_move_the_rim_as_the_closed_form_says():
    """On duals within 0.5 % of Hill's radial displacement; the inner part has flowed."""
    solution, moved = half_plastic(Space(mapped("duals", 8, 16, ring), StabilisationFree(1)))
    assert solution.status.converged
    assert moved == pytest.approx(rim_displacement(), rel=5e-3)
    assert solution.history[np.linalg.norm(solution.points, axis=1) < 1.3, 4].min() > 0.0
