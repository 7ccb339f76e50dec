"""Influence coefficients of a half-space beside Love's closed forms and integrals of the point forces."""

import numpy as np
import pytest

from flangeway.errors import InputError
from flangeway.exact import half_space_influence

YOUNG, POISSON, STRIP = 3.0, 0.3, 0.7
BOUNDS = np.array([-1.0, -0.2, 0.5, 1.6, 2.0])


def test_a_square_under_pressure_sinks_as_love_says() -> None:
    """Its mean displacement is 2.9732 (1 - nu^2) p a / (pi E) with the side a, in the middle 3.5255 of the same."""
    unit = (1.0 - POISSON**2) / (np.pi * YOUNG)
    square = np.array([0.0, 1.0])
    mean = half_space_influence(YOUNG, POISSON, square, 1.0, 1, (1,))[0, 0, 0]
    middle = half_space_influence(YOUNG, POISSON, square, 1.0, 1, (1,), averaged=False)[0, 0, 0]
    assert mean == pytest.approx(4.0 * (np.log(1.0 + np.sqrt(2.0)) - (np.sqrt(2.0) - 1.0) / 3.0) * unit, rel=1e-12)
    assert middle == pytest.approx(4.0 * np.log(1.0 + np.sqrt(2.0)) * unit, rel=1e-12)


def point_forces(x, z):
    """Displacements along x, n, z by unit forces along them at the distances x and z: (3, 3, ...)."""
    r, half = np.hypot(x, z), 0.5 - POISSON
    across, along = half * x / r**2, half * z / r**2
    shear = POISSON * x * z / r**3
    rows = [
        [(1.0 - POISSON) / r + POISSON * x**2 / r**3, across, shear],
        [-across, (1.0 - POISSON) / r, -along],
        [shear, along, (1.0 - POISSON) / r + POISSON * z**2 / r**3],
    ]
    return np.array(rows) / (2.0 * np.pi * YOUNG / (2.0 + 2.0 * POISSON))


@pytest.mark.parametrize("averaged", [True, False])
def test_coefficients_are_integrals_of_point_forces(averaged) -> None:
    """All nine coefficients between cells apart from each other, of any widths, agree with quadrature to 1e-12."""
    nodes, weights = np.polynomial.legendre.leggauss(30)
    middles, halves = (BOUNDS[1:] + BOUNDS[:-1]) / 2.0, np.diff(BOUNDS) / 2.0
    found = half_space_influence(YOUNG, POISSON, BOUNDS, STRIP, 4, averaged=averaged).reshape(4, 4, 3, 4, 3)
    for i, j, number in ((3, 0, 1), (2, 0, 3), (0, 3, 2), (1, 3, 3)):
        at, over = (nodes, weights / 2.0) if averaged else (np.zeros(1), np.ones(1))
        x = (middles[i] + halves[i] * at)[:, None] - (middles[j] + halves[j] * nodes)
        z = (STRIP * number + STRIP / 2.0 * at)[:, None] - STRIP / 2.0 * nodes
        kernel = point_forces(*np.broadcast_arrays(x[:, :, None, None], z))
        exact = np.einsum("ijpqrs,p,q,r,s->ij", kernel, over, weights / 2.0, over, weights / 2.0)
        np.testing.assert_allclose(found[number, i, :, j], exact, atol=1e-12 * abs(exact).max())


def test_wrong_cells_are_refused() -> None:
    """Ends that do not rise end in a clear error."""
    with pytest.raises(InputError, match="rising ends"):
        half_space_influence(YOUNG, POISSON, BOUNDS[::-1], STRIP, 3)
