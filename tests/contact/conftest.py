"""What the tests of contact share: how well the two sides of contacts balance."""

from collections.abc import Callable

import numpy as np
import pytest

from flangeway.contact import ContactSolution


def _imbalance(solution: ContactSolution) -> float:
    forces = solution.resultants
    size = max(float(np.abs(part.body.mesh.points).max()) for part in solution.system.parts)
    scale = np.array([1.0, 1.0, size]) * max(float(np.abs(forces[..., :2]).max()), np.finfo(np.float64).tiny)
    return float((np.abs(forces.sum(axis=1)) / scale).max())


@pytest.fixture(scope="session")
def imbalance() -> Callable[[ContactSolution], float]:
    """Maximum difference of force or moment between the two sides of a contact, over its force and the bodies' size."""
    return _imbalance
