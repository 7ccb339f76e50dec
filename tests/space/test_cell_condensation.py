"""Unknowns inside cells, eliminated from a stiffness that depends on a wavenumber."""

import numpy as np
import pytest

from flangeway.elements import Lagrange, Virtual
from flangeway.materials import Elastic
from flangeway.mesh import dual, rectangle_grid
from flangeway.problems import Elasticity
from flangeway.problems.harmonic import Harmonic
from flangeway.space import InnerUnknowns, Space, assemble_condensed


@pytest.mark.parametrize("element", [Virtual(2), Virtual(4), Lagrange(3)])
def test_what_is_left_is_what_cells_condensed_one_by_one_assemble_to(element) -> None:
    """At each wavenumber the matrix on the nodes is that of condensed cells to 1e-12, for several element types."""
    mesh = rectangle_grid(2.0, 1.0, 3, 2)
    space = Space(dual(mesh) if isinstance(element, Virtual) else mesh, element)
    harmonic = Harmonic(Elasticity(space, Elastic(2.0, 0.3)))
    kept = np.ones(3 * space.n_dofs, dtype=np.bool_)
    at_nodes = kept & (np.arange(len(kept)) < 3 * space.n_nodes)
    on_nodes = harmonic.parts[0].restricted(at_nodes)
    inner = InnerUnknowns.of(space, harmonic.parts, kept, on_nodes)
    for wavenumber in (0.0, 0.7, 5.0):
        exact = assemble_condensed(
            space,
            lambda batch, k=wavenumber: sum(part * k**power for power, part in enumerate(harmonic._cell_parts(batch))),
            n_components=3,
        ).matrix
        found = inner.eliminated(harmonic.stiffness(wavenumber).restricted(at_nodes).values, wavenumber)
        np.testing.assert_allclose(found, exact.values, atol=1e-12 * abs(exact.values).max())
        assert on_nodes.n == 3 * space.n_nodes < 3 * space.n_dofs
