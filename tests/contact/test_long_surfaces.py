"""Long surfaces: the path is chosen by the memory that it needs, and a part of the loads is solved at a time."""

import sys

import numpy as np
import pytest

from flangeway.contact import Multiplier, SegmentToSegment
from flangeway.solve import CondensedBodies, SparseBodies, condensed_bytes
from tests.contact.steel_boxes import BoxDiscretisation, pressed_boxes
from tests.contact.test_friction import blocks, pushed


def test_the_path_that_is_chosen_has_the_same_answer(monkeypatch: pytest.MonkeyPatch) -> None:
    """Condensed below the limit, sparse above it with few loads at a time: both agree to 1e-9."""
    meshes = BoxDiscretisation(0.31, "fem", 2), BoxDiscretisation(0.23, "vem", 1)
    case = pressed_boxes(*meshes, SegmentToSegment(), Multiplier(), rotation_rad=0.3)
    condensed = case.solve()
    assert isinstance(condensed.response, CondensedBodies)
    needed = condensed_bytes(condensed.system.surface_nodes)
    assert needed > 8 * 6 * max(2 * len(each.nodes) for each in condensed.system.surface_nodes) ** 2
    monkeypatch.setattr(sys.modules["flangeway.contact.press"], "MOST_DENSE_BYTES", needed - 1)
    monkeypatch.setattr("flangeway.solve.sparse.ENTRIES_AT_ONCE", 1000)
    sparse = case.solve()
    assert isinstance(sparse.response, SparseBodies)
    assert sparse.status.converged
    np.testing.assert_allclose(sparse.forces, condensed.forces, rtol=1e-9)
    pressures = condensed.state.forces
    np.testing.assert_allclose(sparse.state.forces, pressures, atol=1e-9 * pressures.max())


def test_friction_without_a_dense_matrix_has_the_same_answer(monkeypatch: pytest.MonkeyPatch) -> None:
    """Above the limits bodies and constraints are solved in one sparse factorisation: pressed and pushed to and fro."""

    def solved():
        path = (0.0, -0.01), (0.004, 0.0), (-0.003, 0.0)
        return pushed(blocks(SegmentToSegment(), Multiplier(), order=2), *path)

    dense = solved()
    assert isinstance(dense.response, CondensedBodies)
    monkeypatch.setattr(sys.modules["flangeway.contact.press"], "MOST_DENSE_BYTES", 1e4)
    monkeypatch.setattr("flangeway.contact.newton.MOST_DENSE_EQUATIONS", 0)
    monkeypatch.setattr("flangeway.solve.active_set.equations", None)  # which solves dense ones
    sparse = solved()
    assert isinstance(sparse.response, SparseBodies)
    assert sparse.status.converged, sparse.status.message
    assert dense.state.friction is not None
    assert sparse.state.friction is not None
    assert dense.state.friction.sticks.any()
    assert dense.dissipated_work.any()
    atol = 1e-9 * dense.state.forces.max()
    np.testing.assert_allclose(sparse.state.forces, dense.state.forces, atol=atol)
    np.testing.assert_allclose(sparse.state.friction.forces, dense.state.friction.forces, atol=atol)
