"""Normal contact on a grid of cells with random gaps, cells and materials."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from flangeway.contact.patch.normal_contact import Convolution, solve_normal
from flangeway.errors import InputError
from flangeway.exact import half_space_influence


def grid_of(seed: int) -> tuple[Convolution, np.ndarray, float]:
    """Influence on cells of random widths, gaps of two curvatures with waves on them, and a strip's width."""
    random = np.random.default_rng(seed)
    n_cells, n_strips, strip = int(random.integers(3, 9)), int(random.integers(3, 9)), float(random.uniform(0.3, 2.0))
    bounds = np.concatenate(([0.0], np.cumsum(random.uniform(0.5, 1.5, n_cells))))
    coefficients = half_space_influence(
        random.uniform(0.1, 9.0), random.uniform(0.0, 0.49), bounds, strip, n_strips, (1,)
    )
    x, z = (bounds[1:] + bounds[:-1]) / 2.0, strip * np.arange(n_strips)
    gaps = (x[:, None] - random.uniform(0.0, x[-1])) ** 2 * random.uniform(0.0, 0.2)
    gaps = gaps + (z - random.uniform(0.0, z[-1])) ** 2 * random.uniform(0.0, 0.2)
    return Convolution(coefficients), gaps + random.uniform(0.0, 0.3, gaps.shape), strip


@given(seed=st.integers(0, 10**6), force=st.floats(1e-3, 1e3))
def test_the_solution_is_complementary(seed, force) -> None:
    """No force pulls, none acts across a gap, no cells overlap, and the resultant is the load."""
    influence, gaps, _ = grid_of(seed)
    found = solve_normal(influence, gaps, force=force, tolerance=1e-10)
    assert found.status.converged
    assert found.forces.min() >= 0.0
    assert found.forces.sum() == pytest.approx(force, rel=1e-12)
    depth = influence(found.forces).max()
    assert abs(found.gaps[found.forces > 0.0]).max() < 1e-6 * depth
    assert found.gaps.min() > -1e-6 * depth
    np.testing.assert_allclose(found.gaps, gaps + influence(found.forces) - found.approach, atol=1e-12 * depth)


@given(seed=st.integers(0, 10**6), force=st.floats(1e-3, 1e3))
def test_an_approach_gives_the_force_that_it_comes_from(seed, force) -> None:
    """The same forces belong to a force and to its approach, cold and from the forces of another load."""
    influence, gaps, _ = grid_of(seed)
    found = solve_normal(influence, gaps, force=force, tolerance=1e-10)
    other = solve_normal(influence, gaps, force=0.7 * force, start=found.forces, tolerance=1e-10)
    for start in (None, other.forces):
        again = solve_normal(influence, gaps, approach=found.approach, start=start, tolerance=1e-10)
        assert again.status.converged
        np.testing.assert_allclose(again.forces, found.forces, atol=1e-5 * found.forces.max())
    assert other.approach < found.approach


@given(seed=st.integers(0, 10**6))
def test_products_by_transform_are_those_of_the_whole_matrix(seed) -> None:
    """Coefficients that are symmetric in z and others give the sums over all cells, whatever cells are loaded."""
    random = np.random.default_rng(seed)
    n, m = int(random.integers(1, 5)), int(random.integers(1, 6))
    coefficients = random.normal(size=(m, n, n))
    if seed % 2:
        coefficients = coefficients + coefficients.swapaxes(1, 2)
    else:
        coefficients[0] += coefficients[0].T
    forces = random.normal(size=(n, m)) * (random.uniform(size=(n, 1)) < 0.7)
    exact = np.zeros((n, m))
    for place in range(m):
        for source in range(m):
            one = coefficients[place - source] if place >= source else coefficients[source - place].T
            exact[:, place] += one @ forces[:, source]
    np.testing.assert_allclose(Convolution(coefficients)(forces), exact, atol=1e-12)


@pytest.mark.parametrize("wrong", [{}, {"force": 1.0, "approach": 1.0}, {"force": 0.0}, {"force": np.nan}])
def test_one_positive_force_or_one_approach_is_asked_for(wrong) -> None:
    """Neither, both, and a force that does not press end in a clear error."""
    influence, gaps, _ = grid_of(1)
    with pytest.raises(InputError, match="a force > 0 or an approach"):
        solve_normal(influence, gaps, **wrong)
