"""Patch tests of plane elasticity, on curved edges too: what a method must reproduce exactly."""

import math
from functools import cache

import numpy as np
import pytest

from flangeway.elements import (
    DiagonalStabilisation,
    IdentityStabilisation,
    Lagrange,
    SpectralStabilisation,
    Stabilisation,
    TraceStabilisation,
    Virtual,
)
from flangeway.geometry import Placement, Region, Section, Spline, circle, square
from flangeway.materials import Elastic, Orthotropic
from flangeway.mesh import PolyMesh, curved, dual, dual_section, triangulate, triangulate_section
from flangeway.post import cell_stresses, corner_stresses
from flangeway.problems import Elasticity
from flangeway.space import Space
from tests.given_displacement import solved
from tests.rates.test_elasticity_rates import mixed


def mixed_mesh() -> PolyMesh:
    """Quadrilaterals on the left, triangles on the right, inner points moved off the grid."""
    grid = mixed(4)
    inside = ((grid.points > 0.0) & (grid.points < 1.0)).all(axis=1)
    points = grid.points.copy()
    points[inside] += np.random.default_rng(1).uniform(-0.05, 0.05, (inside.sum(), 2))
    return PolyMesh(points, grid.cell_offsets, grid.cell_points, cell_sets=grid.cell_sets)


@cache
def triangles() -> PolyMesh:
    return triangulate(square(1.0), size=0.3)


def space_of(name: str, order: int) -> Space:
    if name == "fem":
        return Space(triangles(), Lagrange(order))
    if name == "vem":
        return Space(dual(triangles()), Virtual(order))
    if name == "vem on triangles":
        return Space(triangles(), Virtual(order))
    return Space(mixed_mesh(), {"polygons": Virtual(order), "triangles": Lagrange(order)})


NAMES = ("fem", "vem", "vem on triangles", "mixed")
CASES = [(name, order) for name in NAMES for order in (1, 2, 3, 4) if order < 4 or name.startswith("vem")] + [
    ("vem", 5),
    ("vem", 6),
]  # there is no Lagrange triangle of order 4


def polynomial(order: int, centre: float = 0.0):
    """A displacement of a degree with random coefficients: itself, its gradient (n, 2, 2) and second derivatives.

    It is one of twice the distances from a place on the diagonal, which are up to 1 in a square of side 1 about it.
    """
    coefficients = 1e-3 * np.random.default_rng(order).normal(size=(2, (order + 1) * (order + 2) // 2))
    powers = [(total - j, j) for total in range(order + 1) for j in range(total + 1)]

    def derivative(points: np.ndarray, dx: int, dy: int) -> np.ndarray:
        x, y = 2.0 * (points.T - centre)
        result = np.zeros((len(points), 2))
        for column, (a, b) in zip(coefficients.T, powers, strict=True):
            if a >= dx and b >= dy:
                factor = 2.0 ** (dx + dy) * math.perm(a, dx) * math.perm(b, dy)
                result += factor * (x ** (a - dx) * y ** (b - dy))[:, None] * column
        return result

    def gradient(points: np.ndarray) -> np.ndarray:
        return np.stack((derivative(points, 1, 0), derivative(points, 0, 1)), axis=2)

    def second(points: np.ndarray) -> np.ndarray:
        mixed = derivative(points, 1, 1)
        rows = [[derivative(points, 2, 0), mixed], [mixed, derivative(points, 0, 2)]]
        return np.moveaxis(np.array(rows), (0, 1), (2, 3))

    return lambda points: derivative(points, 0, 0), gradient, second


@pytest.mark.parametrize("hypothesis", ["plane_strain", "plane_stress"])
@pytest.mark.parametrize(("name", "order"), CASES)
def test_a_polynomial_of_the_order_is_reproduced(name: str, order: int, hypothesis: str) -> None:
    """With the boundary values and the body force of a polynomial of degree k, the solution is it, to 1e-9 at nodes."""
    space = space_of(name, order)
    material = Orthotropic((200.0, 80.0, 60.0), (0.3, 0.2, 0.25), 50.0, 0.4, hypothesis)
    exact, gradient, second = polynomial(order)

    def force(points: np.ndarray) -> np.ndarray:
        return -np.einsum("ijkl,nklj->ni", material.stiffness, second(points))

    solution = solved(space, material, exact, force)
    at_nodes = exact(space.nodes)
    assert np.abs(solution.displacements[: space.n_nodes] - at_nodes).max() < 1e-9 * np.abs(at_nodes).max()
    corners = corner_stresses(solution.problem, solution.displacements).components
    stress = np.einsum("ijkl,nkl->nij", material.stiffness, gradient(space.mesh.points[space.mesh.cell_points]))
    expected = np.stack((stress[:, 0, 0], stress[:, 1, 1], stress[:, 0, 1]), axis=1)
    assert np.abs(corners[:, :3] - expected).max() < 1e-8 * np.abs(expected).max()


STABILISATIONS = [
    IdentityStabilisation(),
    DiagonalStabilisation(0.5),
    SpectralStabilisation(0.5),
    TraceStabilisation(0.1),
    TraceStabilisation(2.0),
]


@pytest.mark.parametrize("stabilisation", STABILISATIONS, ids=repr)
@pytest.mark.parametrize("order", [1, 2, 3])
def test_every_stabilisation_passes(stabilisation: Stabilisation, order: int) -> None:
    """A polynomial of degree k is reproduced whatever the stabilisation and its factor, compressible or nearly not."""
    space = Space(dual(triangles()), Virtual(order, stabilisation))
    exact, _, second = polynomial(order)
    for material in (Elastic(70.0, 0.2), Elastic(70.0, 0.499)):

        def force(points: np.ndarray, tensor: np.ndarray = material.stiffness) -> np.ndarray:
            return -np.einsum("ijkl,nklj->ni", tensor, second(points))

        solution = solved(space, material, exact, force)
        at_nodes = exact(space.nodes)
        assert np.abs(solution.displacements[: space.n_nodes] - at_nodes).max() < 1e-9 * np.abs(at_nodes).max()


@pytest.mark.parametrize("shift", [0.5, 3.0])
@pytest.mark.parametrize(("name", "order"), CASES)
def test_a_body_of_revolution_swells_uniformly(name: str, order: int, shift: float) -> None:
    """About an axis, touching it or not, u_r = r and u_z = z are reproduced to 1e-10, with three equal strains."""
    space = space_of(name, order)
    space = Space(space.mesh.placed(Placement(0.0, (shift, 0.0))), space.element)
    material = Elastic(210e3, 0.3, "axisymmetric")
    solution = solved(space, material, lambda points: points)
    assert np.abs(solution.displacements[: space.n_nodes] - space.nodes).max() < 1e-10
    bulk = 210e3 / (1.0 - 2.0 * 0.3)
    corners = corner_stresses(solution.problem, solution.displacements).components
    assert np.abs(corners - bulk * np.array([1.0, 1.0, 0.0, 1.0])).max() < 1e-8 * bulk
    volume = 2.0 * np.pi * space.mesh.cell_areas @ space.mesh.cell_centroids[:, 0]
    assert solution.energy == pytest.approx(1.5 * bulk * volume, rel=1e-9)


GRADIENT = np.array([[1.2e-3, -0.7e-3], [2.1e-3, 0.4e-3]])
SHIFT = np.array([0.3e-3, -0.1e-3])
OUTER, INNER = circle(2.0), circle(1.0, (0.2, 0.0))


@cache
def mesh_of(name: str) -> PolyMesh:
    """A ring with coarse arcs, a disc in a ring, and a closed spline."""
    if name == "interface":
        section = Section({"ring": Region(OUTER, (INNER,)), "disc": Region(INNER)})
        return dual_section(curved(triangulate_section(section, size=0.9), section))
    mesh = triangulate(OUTER, size=0.9, holes=[INNER])
    if name == "spline":
        angle = np.linspace(0.0, 2.0 * np.pi, 9)
        wave = np.stack(((2.0 + 0.1 * np.cos(4.0 * angle)) * np.cos(angle), 2.0 * np.sin(angle)), axis=1)
        wave[-1] = wave[0]
        return dual(curved(mesh, [Spline(wave), INNER]))
    return curved(mesh, [OUTER, INNER]) if name == "triangles" else dual(mesh, outline=[OUTER, INNER])


CURVED_CASES = [("ring", Virtual(k)) for k in (1, 2, 3, 4, 5, 6)]
CURVED_CASES += [(name, Virtual(k)) for name in ("interface", "spline") for k in (2, 4)]
CURVED_CASES += [("triangles", element) for element in (Lagrange(2), Lagrange(3), Virtual(2))]


@pytest.mark.parametrize(("name", "element"), CURVED_CASES, ids=repr)
def test_a_linear_displacement_is_reproduced_on_curved_edges(name: str, element) -> None:
    """Displacements are linear to 1e-10 and stresses uniform to 1e-8, for every order, with a few coarse arcs."""
    mesh = mesh_of(name)
    assert mesh.curves is not None
    space = Space(mesh, element)
    material = Elastic(210e3, 0.3)
    solution = solved(space, material, lambda p: p @ GRADIENT.T + SHIFT)
    wanted = space.nodes @ GRADIENT.T + SHIFT
    assert np.abs(solution.displacements[: space.n_nodes] - wanted).max() < 1e-10 * np.abs(wanted).max()
    stress = np.einsum("ijkl,kl->ij", material.stiffness, GRADIENT)
    found = cell_stresses(solution.problem, solution.displacements).components[:, :3]
    assert np.abs(found - stress[[0, 1, 0], [0, 1, 1]]).max() < 1e-8 * np.abs(stress).max()


@pytest.mark.parametrize(
    ("name", "element"), [("ring", Virtual(3)), ("interface", Virtual(2)), ("triangles", Lagrange(2))]
)
def test_rigid_motions_cost_nothing_on_curved_edges(name: str, element) -> None:
    """Both translations and the rotation have no force on any unknown, and nothing else is without energy."""
    space = Space(mesh_of(name), element)
    matrix = Elasticity(space, Elastic(1.0, 0.3)).stiffness()
    values = np.linalg.eigvalsh(matrix.full().toarray())
    assert np.abs(values[:3]).max() < 1e-11 * values[-1]
    assert values[3] > 1e-6 * values[-1]
