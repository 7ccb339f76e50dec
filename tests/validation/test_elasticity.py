"""Mixed meshes of the study of plane elasticity, and its codes."""

import numpy as np
import pytest

from flangeway.cases.bodies.cook import CookCode
from studies.elasticity import patch_space


@pytest.mark.parametrize("space", [CookCode("H", 1, 2).space(), patch_space("HE", 2)], ids=["membrane", "patch"])
def test_mixed_configurations_have_both_methods(space):
    """Codes with H and HE use virtual elements for all cells at the boundary and Lagrange triangles inside."""
    mesh = space.mesh
    outer = np.zeros(mesh.n_edges, dtype=bool)
    outer[mesh.edge_numbers(mesh.boundary_edges)] = True
    at_rim = np.add.reduceat(outer[mesh.cell_edges], mesh.cell_offsets[:-1]) > 0
    assert np.array_equal(np.flatnonzero(at_rim), np.sort(mesh.cell_sets["polygons"]))
    assert np.array_equal(np.flatnonzero(~at_rim), np.sort(mesh.cell_sets["triangles"]))
    assert {type(batch.element).__name__ for batch in space.batches()} == {"Lagrange", "Virtual"}
