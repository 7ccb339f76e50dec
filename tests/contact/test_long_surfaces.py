"""Long surfaces: the path is chosen by the memory that it needs, and a part of the loads is solved at a time."""

import sys

import numpy as np
import pytest

from flangeway.contact import Multiplier, SegmentToSegment
from flangeway.solve import CondensedBodies, SparseBodies, condensed_bytes
from tests.contact.steel_boxes import BoxDiscretisation, pressed_boxes


def test_the_path_that_is_chosen_has_the_same_answer(monkeypatch: pytest.MonkeyPatch) -> None:
    """Condensed below the limit, sparse above it with few loads at a time: both agree to 1e-9."""
    meshes = BoxDiscretisation(0.31, "fem", 2), BoxDiscretisation(0.23, "vem", 1)
    case = pressed_boxes(*meshes, SegmentToSegment(), Multiplier(), rotation_rad=0.3)
    condensed = case.solve()
    assert isinstance(condensed.response, CondensedBodies)
    needed = condensed_bytes(condensed.system.surface_nodes)
    assert needed > 8 * 6 * max(2 * len(each.nodes) for each in condensed.system.surface_nodes) ** 2
    monkeypatch.setattr(sys.modules["flangeway.contact.press"], "MOST_DENSE", needed - 1)
    monkeypatch.setattr("flangeway.solve.sparse.ENTRIES_AT_ONCE", 1000)
    sparse = case.solve()
    assert isinstance(sparse.response, SparseBodies)
    assert sparse.status.converged
    np.testing.assert_allclose(sparse.forces, condensed.forces, rtol=1e-9)
    pressures = condensed.state.forces
    np.testing.assert_allclose(sparse.state.forces, pressures, atol=1e-9 * pressures.max())
