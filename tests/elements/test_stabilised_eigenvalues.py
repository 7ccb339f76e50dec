"""Eigenvalues of stabilised stiffnesses stay near those that the elements have without stabilisation."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from flangeway.elements import NoStabilisation, Virtual
from flangeway.elements.monomials import n_monomials
from flangeway.materials import Elastic
from flangeway.mesh import PolyMesh
from flangeway.problems import Elasticity
from flangeway.space import Space

ABOVE, BELOW = 100.0, 5000.0
"""Factors that docs/theory/elements.md states: of the largest eigenvalue upwards, of the smallest downwards."""


@st.composite
def stars(draw):
    """Polygon (n, 2) of 4 to 100 vertices that are 0.1 to 1 from its middle, in directions of any steps to 1 : 5."""
    n = draw(st.one_of(st.integers(4, 14), st.just(100)))
    random = np.random.default_rng(draw(st.integers(0, 10**6)))
    steps = random.uniform(0.2, 1.0, n)
    angles = np.cumsum(steps * 2.0 * np.pi / steps.sum())
    radii = random.uniform(draw(st.sampled_from([0.1, 0.5, 1.0])), 1.0, n)
    return radii[:, None] * np.column_stack((np.cos(angles), np.sin(angles)))


def eigenvalues(points, element, poisson):
    """Of the stiffness of one cell, smallest first."""
    mesh = PolyMesh(points, [0, len(points)], np.arange(len(points)))
    problem = Elasticity(Space(mesh, element), Elastic(1.0, poisson))
    (batch,) = problem.space.batches()
    return np.linalg.eigvalsh(problem.cell_stiffness(batch)[..., 0])


@pytest.mark.parametrize("order", [1, 2, 3])
@settings.get_profile("costly")
@given(points=stars(), poisson=st.sampled_from([0.0, 0.3, 0.4999]))
def test_no_eigenvalue_leaves_the_range_of_the_elements_own(order, points, poisson):
    """But for three rigid motions, eigenvalues are within the stated factors of those of the strains that it has."""
    own = eigenvalues(points, Virtual(order, NoStabilisation()), poisson)[3 - 2 * n_monomials(order) :]
    stabilised = eigenvalues(points, Virtual(order), poisson)[3:]
    assert stabilised[-1] < ABOVE * own[-1]
    assert stabilised[0] > own[0] / BELOW
