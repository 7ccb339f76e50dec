"""Flow by the divergence-free element on meshes with symmetries, beside Poiseuille's and Taylor's solutions."""

import numpy as np
import pytest

from flangeway.elements import Virtual
from flangeway.forms import Plate, mass, stiffness, stokes, stokes_matrix
from flangeway.geometry import square
from flangeway.materials import Elastic
from flangeway.mesh import dual, quadtree, rectangle_grid, triangulate, voronoi
from flangeway.space import Space


def _grid(width, height, nx, ny, origin=(0.0, 0.0)):
    return rectangle_grid(width, height, nx, ny, cells="quadrilaterals", origin=origin)


MESHES = {
    "one square": lambda: _grid(1.0, 1.0, 1, 1),
    "squares": lambda: _grid(1.0, 1.0, 4, 4),
    "large squares elsewhere": lambda: _grid(1e4, 1e4, 3, 3, (3e4, -7e4)),
    "small squares": lambda: _grid(1e-5, 1e-5, 3, 3),
    "flat rectangles": lambda: _grid(1.0, 1.0, 2, 30),
    "squares of three sizes": lambda: quadtree(1.0, 1.0, 2, 2, finer=lambda points, _: points[:, 0] < 0.5, levels=2),
    "halved squares": lambda: rectangle_grid(1.0, 1.0, 3, 3),
    "triangles": lambda: triangulate(square(1.0), size=0.3),
    "dual": lambda: dual(triangulate(square(1.0), size=0.25)),
    "Voronoi": lambda: voronoi(square(1.0), 20, seed=1),
}


@pytest.mark.parametrize("order", [2, 4])
@pytest.mark.parametrize("name", MESHES)
def test_poiseuille_flow_is_exact(name, order):
    """Velocity (y/h)^2 and pressure 2 mu x / h^2, polynomials of the element's degrees: to round-off on every mesh."""
    mesh, viscosity = MESHES[name](), 3.0
    base, height = mesh.points[:, 1].min(), np.ptp(mesh.points[:, 1])

    def flow(points):
        return np.stack((((points[:, 1] - base) / height) ** 2, 0.0 * points[:, 0]), axis=1)

    solution = stokes(mesh, order, viscosity=viscosity, velocity=flow)
    points, weights, velocity, _, pressure = solution.at_quadrature(2 * order)
    exact = 2.0 * viscosity * points[:, 0] / height**2
    exact -= (weights @ exact) / weights.sum()
    np.testing.assert_allclose(velocity, flow(points), atol=1e-9)
    np.testing.assert_allclose(pressure, exact, atol=1e-7 * np.abs(exact).max())


def test_taylor_vortices_on_squares_converge_with_the_order_of_the_element():
    """Velocities (sin x cos y, -cos x sin y) with the force 2 u: errors in L2 fall eightfold with half the size."""

    def vortices(points):
        x, y = points.T
        return np.stack((np.sin(x) * np.cos(y), -np.cos(x) * np.sin(y)), axis=1)

    errors = []
    for n in (4, 8, 16):
        solution = stokes(_grid(3.0, 3.0, n, n), 2, lambda points: 2.0 * vortices(points), velocity=vortices)
        points, weights, velocity, *_ = solution.at_quadrature(6)
        errors.append(np.sqrt(weights @ ((velocity - vortices(points)) ** 2).sum(axis=1)))
    assert (np.log2(np.divide(errors[:-1], errors[1:])) > 2.8).all()


FORMS = {
    "flow": lambda mesh, order: stokes_matrix(Space(mesh, Virtual(order))),
    "elastic stiffness": lambda mesh, order: stiffness(Space(mesh, Virtual(order)), Elastic(1.0, 0.3).stiffness),
    "mass": lambda mesh, order: mass(Space(mesh, Virtual(order))),
    "varying stiffness": lambda mesh, order: stiffness(Space(mesh, Virtual(order)), lambda points: 1.0 + points[:, 0]),
    "plate": lambda mesh, order: Plate(mesh, min(order, 3)).stiffness(),
}


@pytest.mark.parametrize("order", [2, 3, 4])
@pytest.mark.parametrize("form", FORMS)
def test_round_off_of_symmetric_meshes_is_that_of_others(form, order):
    """Entries that cancel on squares do not count as inaccurate: round-off as on triangles, within a factor of 20."""
    round_off = [np.max(FORMS[form](MESHES[name](), order).round_off) for name in ("squares", "triangles")]
    assert round_off[0] < 20.0 * round_off[1]
