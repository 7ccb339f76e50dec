"""Stresses inside a half-space beside Love's square and Hertz's axis."""

import numpy as np
import pytest

from flangeway.exact.half_space_stresses import pressure_stresses


def test_a_square_under_pressure_has_the_stresses_of_love() -> None:
    """On the vertical through the middle of a unit square, nu = 0.28, they are those that CONTACT prints."""
    side = np.array([[-0.5, 0.5]])
    places = np.array([[1e-5, depth, 1e-5] for depth in (1e-9, 0.5, 1.0, 2.5)])
    found = pressure_stresses(side, side, np.ones((1, 1)), places, 0.28)
    expected = [(-0.779977, -1.0), (-0.076223, -0.700842), (0.0039711, -0.336086), (0.0044575, -0.071611)]
    assert found[:, [2, 1]] == pytest.approx(np.array(expected), abs=5e-5)
    # CONTACT's example has a shear traction along x too, which changes nothing along z but a little at its points
    assert np.abs(found[:, 3:]).max() < 1e-4


def test_below_a_circular_patch_stresses_are_those_of_hertz() -> None:
    """On the axis s_dd = -p0 / (1 + d^2/a^2) and s_xx as Johnson (1985, 3.45) gives them, to 1e-4 p0."""
    ends = np.linspace(-1.0, 1.0, 101)
    middles = (ends[1:] + ends[:-1]) / 2.0
    pressures = np.sqrt(np.maximum(1.0 - middles[:, None] ** 2 - middles**2, 0.0))
    cells = np.stack((ends[:-1], ends[1:]), axis=1)
    depth = np.array([0.2, 0.48, 1.0, 2.0])
    found = pressure_stresses(cells, cells, pressures, np.stack((0 * depth, depth, 0 * depth), axis=1), 0.3)
    across = -1.3 * (1.0 - depth * np.arctan(1.0 / depth)) + 0.5 / (1.0 + depth**2)
    assert found[:, 1] == pytest.approx(-1.0 / (1.0 + depth**2), abs=2e-4)
    assert found[:, 0] == pytest.approx(across, abs=2e-4)


def test_stresses_are_in_equilibrium_with_the_load() -> None:
    """Over a plane at any depth s_dd sums to the load, and s_xx + s_dd + s_zz follows from the displacements' trace."""
    side, grid = np.array([[-1.0, 1.0]]), np.linspace(-60.0, 60.0, 241)
    x, z = (each.ravel() for each in np.meshgrid(grid, grid))
    found = pressure_stresses(side, side, np.ones((1, 1)), np.stack((x, np.full(len(x), 1.5), z), axis=1), 0.3)
    assert found[:, 1].sum() * 0.25 == pytest.approx(-4.0, rel=1e-3)
    assert abs(found[:, 3].sum()) < 1e-9
