"""Compliance of surfaces in three dimensions, and contact with it, beside the half-space's closed forms."""

from functools import cache

import numpy as np
import pytest
from scipy.optimize import brentq
from scipy.special import ellipe, ellipk

from flangeway.contact.patch.normal_contact import Convolution, solve_normal
from flangeway.elements import Lagrange, Virtual
from flangeway.errors import InputError
from flangeway.geometry import polygon
from flangeway.materials import Elastic
from flangeway.mesh import Refinement, dual, triangulate
from flangeway.problems import Elasticity
from flangeway.problems.harmonic import Harmonic
from flangeway.solve.surface_compliance import ComplianceTable, SurfaceCells, compliance_table
from flangeway.space import Space

YOUNG, POISSON = 210e3, 0.3
SIZE, HALF, BLOCK = 0.6, 9.0, 100.0  # mm


def cells_of(element):
    """A row of cells of 0.6 mm in the middle of the top of a block that is held at its base."""
    corners = [(-BLOCK, -BLOCK), (BLOCK, -BLOCK), (BLOCK, 0.0), (HALF, 0.0), (-HALF, 0.0), (-BLOCK, 0.0)]
    along = np.linspace(-HALF, HALF, 31)
    zone = Refinement(np.stack((along, np.zeros(31)), axis=1), size=SIZE, growth=0.4)
    mesh = triangulate(polygon(corners), size=30.0, refinements=[zone])
    mesh = dual(mesh) if isinstance(element, Virtual) else mesh
    edges, points = mesh.boundary_edges, mesh.points
    ends = points[edges]
    base = edges[(np.abs(ends[:, :, 1] + BLOCK) < 1e-9).all(axis=1)]
    top = edges[(np.abs(ends[:, :, 1]) < 1e-9).all(axis=1) & (np.abs(ends[:, :, 0]) < HALF + 1e-9).all(axis=1)]
    top = top[np.argsort(-points[top[:, 0], 0])]
    space = Space(mesh.with_edge_set("base", base), element)
    problem = Harmonic(Elasticity(space, Elastic(YOUNG, POISSON)), held={"base": "xyz"})
    return SurfaceCells(problem, top, np.linspace(0.0, 2.0 * HALF, 31))


@cache
def table(order=2) -> ComplianceTable:
    """Table of the block with finite elements."""
    return compliance_table(cells_of(Lagrange(order)), 1e-3, 2.5 * np.pi / SIZE, 1e-3)


@pytest.mark.parametrize("element", [Lagrange(2), Virtual(1), Virtual(2)])
@pytest.mark.parametrize("wavenumber", [1e-3, 0.3, 8.0])
def test_the_compliance_at_a_wavenumber_is_positive_definite(element, wavenumber) -> None:
    """C(k) is symmetric and has positive eigenvalues, for every element."""
    values = cells_of(element).compliance(wavenumber)
    np.testing.assert_array_equal(values, values.T)
    assert np.linalg.eigvalsh(values).min() > 0.0


def test_far_forces_act_as_on_a_half_space() -> None:
    """Normal and longitudinal displacement at 6 mm along z are those of Boussinesq's point force, but for a constant.

    A pull along the normal moves what is beside it away from it: u_z = +(1 + nu)(1 - 2 nu) / (2 pi E z).
    """
    found = table().influence(SIZE, 21).reshape(21, 30, 3, 30, 3)[:, 15, :, 15, :]
    distances = SIZE * np.arange(21)
    exact = (1.0 - POISSON**2) / (np.pi * YOUNG)
    rise = found[5, 1, 1] - found[20, 1, 1]
    assert rise == pytest.approx(exact * (1.0 / distances[5] - 1.0 / distances[20]), rel=0.02)
    sideways = (1.0 + POISSON) * (1.0 - 2.0 * POISSON) / (2.0 * np.pi * YOUNG * distances[10])
    assert found[10, 2, 1] == pytest.approx(sideways, rel=0.05)
    np.testing.assert_allclose(found[:, 1, 2], -found[:, 2, 1], atol=0.02 * abs(found[1, 2, 1]))


def test_a_uniform_pressure_on_a_square_gives_loves_mean_displacement() -> None:
    """The mean displacement of a square under a uniform pressure is 2.9732 (1 - nu^2) p a / (pi E), to 1 %."""
    n = 8
    influence = Convolution(table().influence(SIZE, 32, axes=(1,)))
    forces = np.zeros(influence.shape)
    place = np.ix_(np.arange(11, 11 + n), np.arange(12, 12 + n))
    forces[place] = SIZE**2
    mean = influence(forces)[place].mean()
    exact = (1.0 - POISSON**2) / (np.pi * YOUNG) * 2.9732 * n * SIZE
    assert mean - n**2 * SIZE**2 * _block_constant() == pytest.approx(exact, rel=1e-2)


def _block_constant() -> float:
    """Displacement by a unit force that the finite block lacks of the half-space, from a distance of 10 cells."""
    found = table().influence(SIZE, 11, axes=(1,))[10, 15, 15]
    return float(found - (1.0 - POISSON**2) / (np.pi * YOUNG * 10.0 * SIZE))


@pytest.mark.parametrize("radii", [(254.0, 460.0), (300.0, 300.0), (100.0, 500.0)])
def test_two_blocks_with_curved_surfaces_touch_as_hertz_says(radii) -> None:
    """Pressure to 0.5 %, approach to 0.7 %, semi-axes to 5 % of a cell's share of Hertz's ellipse."""
    across, along = min(radii), max(radii)
    modulus = YOUNG / (1.0 - POISSON**2) / 2.0
    sum_of_curvatures = (1.0 / across + 1.0 / along) / 2.0
    ratio = across / along
    square = (
        brentq(lambda m: (ellipe(m) / (1.0 - m) - ellipk(m)) / (ellipk(m) - ellipe(m)) * ratio - 1.0, 1e-9, 1.0 - 1e-9)
        if ratio < 1.0
        else 0.0
    )
    force = 2.0 / 3.0 * np.pi * 5.0**3 * 2.0 * modulus * sum_of_curvatures / 3.0  # half widths of some 5 mm
    long = (3.0 * force * ellipe(square) / (2.0 * np.pi * modulus * (1.0 - square) * sum_of_curvatures)) ** (1.0 / 3.0)
    short = long * np.sqrt(1.0 - square)
    peak = 3.0 * force / (2.0 * np.pi * long * short)
    approach = peak / modulus * short * ellipk(square)

    cells = table().cells
    influence = Convolution(2.0 * table().influence(SIZE, 40, axes=(1,)))
    x, z = cells.middles[:, 0], SIZE * (np.arange(40) - 19.5)
    gaps = x[:, None] ** 2 / (2.0 * across) + z**2 / (2.0 * along)
    found = solve_normal(influence, gaps, force=force)
    assert found.status.converged
    assert found.forces.sum() == pytest.approx(force, rel=1e-9)
    assert (found.forces >= 0.0).all()
    assert abs(found.gaps[found.forces > 0.0]).max() < 1e-4 * approach
    assert found.gaps.min() > -1e-4 * approach
    pressures = found.forces / (cells.widths[:, None] * SIZE)
    assert pressures.max() == pytest.approx(peak, rel=5e-3)
    # of an ellipsoid of pressure the mean square of a coordinate is a fifth of the semi-axis squared
    assert np.sqrt(5.0 * (found.forces.sum(axis=1) * x**2).sum() / force) == pytest.approx(short, abs=0.05 * SIZE)
    assert np.sqrt(5.0 * (found.forces.sum(axis=0) * z**2).sum() / force) == pytest.approx(long, abs=0.05 * SIZE)
    assert found.approach - 2.0 * force * _block_constant() == pytest.approx(approach, rel=7e-3)
    again = solve_normal(influence, gaps, approach=found.approach, start=found.forces)
    assert again.forces.sum() == pytest.approx(force, rel=1e-4)


def test_the_error_of_the_interpolation_is_one_that_was_met() -> None:
    """The table at wavenumbers that were left out differs by no more than three times the error that it states."""
    found = table()
    middles = np.exp((np.log(found.wavenumbers[:-1:6]) + np.log(found.wavenumbers[1::6])) / 2.0)
    scale = abs(found.values * found.wavenumbers[:, None, None]).max()
    from scipy.interpolate import CubicSpline  # noqa: PLC0415

    logs, scaled = np.log(found.wavenumbers), found.values * found.wavenumbers[:, None, None]
    spline = CubicSpline(logs, scaled, bc_type="natural")
    for wavenumber in middles:
        exact = wavenumber * found.cells.compliance(float(wavenumber))
        assert abs(spline(np.log(wavenumber)) - exact).max() < 3.0 * max(found.error, 1e-3) * scale


def test_wrong_cells_are_refused() -> None:
    """Edges that do not follow each other, and a prism that nothing holds, end in clear errors."""
    cells = cells_of(Lagrange(1))
    with pytest.raises(InputError, match="follow each other"):
        SurfaceCells(cells.problem, cells.edges[::-1])
    loose = Harmonic(cells.problem.elasticity)
    with pytest.raises(InputError, match="without strain"):
        SurfaceCells(loose, cells.edges).compliance(1e-9)
