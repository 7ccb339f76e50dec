"""Influence coefficients and stresses of a half-space beside Love's and Hertz's closed forms and integrals."""

import numpy as np
import pytest
from scipy.integrate import quad

from flangeway.errors import InputError
from flangeway.exact import LineContact, half_space_influence
from flangeway.exact.half_space import half_space_field, half_space_stresses

YOUNG, POISSON, STRIP = 3.0, 0.3, 0.7
BOUNDS = np.array([-1.0, -0.2, 0.5, 1.6, 2.0])


def test_a_square_under_pressure_sinks_as_love_says() -> None:
    """Its mean displacement is 2.9732 (1 - nu^2) p a / (pi E) with the side a."""
    unit = (1.0 - POISSON**2) / (np.pi * YOUNG)
    square = np.array([0.0, 1.0])
    mean = half_space_influence(YOUNG, POISSON, square, 1.0, 1, (1,))[0, 0, 0]
    assert mean == pytest.approx(4.0 * (np.log(1.0 + np.sqrt(2.0)) - (np.sqrt(2.0) - 1.0) / 3.0) * unit, rel=1e-12)


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


def test_coefficients_are_integrals_of_point_forces() -> None:
    """All nine coefficients between cells apart from each other, of any widths, agree with quadrature to 1e-12."""
    nodes, weights = np.polynomial.legendre.leggauss(30)
    middles, halves = (BOUNDS[1:] + BOUNDS[:-1]) / 2.0, np.diff(BOUNDS) / 2.0
    found = half_space_influence(YOUNG, POISSON, BOUNDS, STRIP, 4).reshape(4, 4, 3, 4, 3)
    for i, j, number in ((3, 0, 1), (2, 0, 3), (0, 3, 2), (1, 3, 3)):
        over = weights / 2.0
        x = (middles[i] + halves[i] * nodes)[:, None] - (middles[j] + halves[j] * nodes)
        z = (STRIP * number + STRIP / 2.0 * nodes)[:, None] - STRIP / 2.0 * nodes
        kernel = point_forces(*np.broadcast_arrays(x[:, :, None, None], z))
        exact = np.einsum("ijpqrs,p,q,r,s->ij", kernel, over, over, over, over)
        np.testing.assert_allclose(found[number, i, :, j], exact, atol=1e-12 * abs(exact).max())


@pytest.mark.parametrize("distance", [1, 3, 50, 150])
def test_cells_far_longer_than_wide_keep_their_digits(distance) -> None:
    """Of strips 160,000 times as long as wide, the mean displacement is that of two lines, averaged over both widths.

    Lines of the length L at the distance d: mean 1/r = 2 (L arsinh(L/d) - sqrt(L^2 + d^2) + d) / L^2.
    """
    length, strip = 2000.0, 0.0125

    def lines(apart: float) -> float:
        d = strip * (distance + apart)
        mean = 2.0 * (length * np.arcsinh(length / d) - np.hypot(length, d) + d) / length**2
        return (1.0 - abs(apart)) * mean

    both = sum(quad(lines, *ends, epsabs=0.0, epsrel=1e-11)[0] for ends in ((-1.0, 0.0), (0.0, 1.0)))
    bounds = length / 2.0 * np.array([-1.0, 1.0])
    found = half_space_influence(YOUNG, POISSON, bounds, strip, distance + 1, (1,))[distance, 0, 0]
    assert found == pytest.approx((1.0 - POISSON**2) / (np.pi * YOUNG) * both, rel=1e-10)


def test_wrong_cells_are_refused() -> None:
    """Ends that do not rise end in a clear error."""
    with pytest.raises(InputError, match="rising ends"):
        half_space_influence(YOUNG, POISSON, BOUNDS[::-1], STRIP, 3)


CONTACT_POINTS = np.array(
    [
        [0.3, -0.4, 0.1, -0.864101, 0.296902, -0.566810, -0.403571, 0.183308, -0.935386],
        [0.3, -0.2, 0.1, -1.05978, 0.103830, -0.670981, -0.569934, 0.037374, -1.02690],
        [0.8, -0.2, 0.1, -0.631649, 0.061648, -0.141964, -0.130795, 0.017619, -0.030653],
        [-1.0, -0.2, 0.5, 0.107307, 0.019454, -0.045738, -0.025230, -0.0069089, 0.024520],
        [0.3, -0.2, 0.5, -0.184195, 0.053426, -0.273123, -0.071829, 0.110174, -0.689986],
        [0.8, 2.0, 0.5, -0.018456, -0.018452, -0.0053410, -0.028997, -0.012451, -0.0033882],
        [-1.0, 2.0, 1.667, -0.0004734, -0.0005499, 0.0030386, -0.0068664, -0.0068915, -0.0060704],
    ]
)
"""x, y, depth, then xx, xy, xz, yy, yz, zz as CONTACT prints them (examples/subsurf), p = 1 and q_x = 0.999."""


def test_a_square_under_pressure_and_shear_has_the_stresses_of_contact() -> None:
    """All six stresses at seven points, along x and, turned by a right angle, along z, to the printed digits."""
    square = np.array([[-0.5, 0.5]])
    # CONTACT's square is a little beside the origin, to break the symmetry
    shift = (1e-4, 2e-4)
    x, y, depth = CONTACT_POINTS[:, :3].T
    shears = np.array([[[0.999, 0.0]]])
    found = half_space_stresses(
        square + shift[0], square + shift[1], np.ones((1, 1)), np.stack((x, depth, y), axis=1), 0.28, shears
    )
    assert found[:, [0, 5, 3, 2, 4, 1]] == pytest.approx(CONTACT_POINTS[:, 3:], abs=2e-6, rel=2e-5)
    turned = half_space_stresses(
        square + shift[1],
        square + shift[0],
        np.ones((1, 1)),
        np.stack((y, depth, x), axis=1),
        0.28,
        shears[:, :, ::-1],
    )
    assert turned[:, [2, 1, 0, 4, 3, 5]] == pytest.approx(found, abs=1e-14)


def test_under_sliding_cylinders_stresses_are_those_of_mcewen() -> None:
    """Under a long strip with p = sqrt(1 - x^2) and q = 0.4 p they are those of plane strain, to 1e-4 of p0."""
    ends = -np.cos(np.linspace(0.0, np.pi, 201))
    cells = np.stack((ends[:-1], ends[1:]), axis=1)
    forces = np.diff((ends * np.sqrt(1.0 - ends**2) + np.arcsin(ends)) / 2.0)
    pressures = (forces / np.diff(ends))[:, None]
    shears = np.concatenate((0.4 * pressures, 0.0 * pressures), axis=1)[:, None]
    x, depth = np.array([-1.2, -0.8, 0.05, 0.3, 0.95]), np.array([0.1, 0.2, 0.8, 0.5, 0.3])
    places = np.stack((x, depth, 0.0 * x), axis=1)
    found = half_space_stresses(cells, np.array([[-4e3, 4e3]]), pressures, places, 0.3, shears)
    exact = LineContact.of_max_pressure(1.0, 1.0, 1.0)
    assert exact.half_width == pytest.approx(2.0)  # lengths are halved below
    plane = exact.stresses(2.0 * x, 2.0 * depth)
    plane = plane + 0.4 * np.stack((mcewen_shear(x, depth), plane[:, 2], plane[:, 0]), axis=1)
    assert found[:, [0, 1, 3]] == pytest.approx(plane, abs=1e-4)
    assert found[:, 2] == pytest.approx(0.3 * (plane[:, 0] + plane[:, 1]), abs=1e-4)


def mcewen_shear(x: np.ndarray, depth: np.ndarray) -> np.ndarray:
    """s_xx under q = sqrt(1 - x^2) (McEwen, 1949; Johnson, 1985, eq. 7.8), by the root of a complex number."""
    root = np.sqrt(1.0 - (x + 1j * depth) ** 2)
    m, n = np.abs(root.real), np.sign(x) * np.abs(root.imag)
    return n * (2.0 - (depth**2 - m**2) / (m**2 + n**2)) - 2.0 * x


def test_at_the_surface_stresses_are_the_tractions() -> None:
    """Just below a point of a loaded rectangle they are its pressure and shears, beside it zero."""
    x, z = np.array([[-1.0, 1.0]]), np.array([[-0.5, 0.5], [0.5, 2.0]])
    loads, shears = np.array([[2.0, 1.0]]), np.array([[[0.3, -0.6], [0.2, 0.1]]])
    found = half_space_stresses(x, z, loads, np.array([[0.3, 1e-7, 0.2], [0.3, 1e-7, 2.4]]), 0.3, shears)
    assert found[:, [1, 3, 4]] == pytest.approx(np.array([[-2.0, -0.3, 0.6], [0.0, 0.0, 0.0]]), abs=1e-5)


def test_below_even_cells_the_sum_by_fft_is_the_sum_of_rectangles() -> None:
    """Under random pressures and shears on 7 x 5 cells all stresses, at the surface and beside the cells too, agree."""
    loads, width, strip = np.random.default_rng(1).random((7, 5, 3)), 0.3, 0.7
    depths, margin = np.array([0.0, 0.1, 1.0, 2.0]), 2
    found = half_space_field(loads, (width, strip), depths, 0.3, margin)
    x, z = (size * (np.arange(-margin, count + margin) + 0.5) for size, count in ((width, 7), (strip, 5)))
    d, x, z = (each.ravel() for each in np.meshgrid(depths, x, z, indexing="ij"))
    ends = [
        size * np.stack((np.arange(count), np.arange(count) + 1.0), axis=1) for size, count in ((width, 7), (strip, 5))
    ]
    wanted = half_space_stresses(*ends, loads[..., 0], np.stack((x, d, z), axis=1), 0.3, loads[..., 1:])
    assert pytest.approx(wanted, abs=1e-12) == found.reshape(6, -1).T
    pressure = half_space_field(loads[..., :1], (width, strip), depths, 0.3, margin)
    shears = half_space_field(loads[..., 1:], (width, strip), depths, 0.3, margin)
    assert pressure + shears == pytest.approx(found, abs=1e-12)
