"""Patch tests of plane elasticity: what a method must reproduce exactly."""

import numpy as np
import pytest
from scipy.sparse.linalg import spsolve

from flangeway.elements import Lagrange, Virtual
from flangeway.geometry import square
from flangeway.materials import Elastic
from flangeway.mesh import PolyMesh, dual, rectangle_grid, triangulate
from flangeway.post import cell_stresses
from flangeway.problems import Elasticity
from flangeway.space import Space

GRADIENT = np.array([[1.2e-3, -0.7e-3], [2.1e-3, 0.4e-3]])
SHIFT = np.array([0.3e-3, -0.1e-3])


def mixed_mesh() -> PolyMesh:
    """Quadrilaterals on the left, triangles on the right, inner points moved off the grid."""
    grid = rectangle_grid(1.0, 1.0, 4, 4, cells="quadrilaterals")
    quads = grid.cell_points.reshape(-1, 4)
    right = grid.cell_centroids[:, 0] > 0.5
    triangles = quads[right][:, [0, 1, 2, 0, 2, 3]].reshape(-1, 3)
    sizes = np.concatenate((np.full((~right).sum(), 4), np.full(len(triangles), 3)))
    inside = ((grid.points > 0.0) & (grid.points < 1.0)).all(axis=1)
    points = grid.points.copy()
    points[inside] += np.random.default_rng(1).uniform(-0.05, 0.05, (inside.sum(), 2))
    numbers = np.arange(len(sizes))
    return PolyMesh(
        points,
        np.concatenate(([0], np.cumsum(sizes))),
        np.concatenate((quads[~right].ravel(), triangles.ravel())),
        cell_sets={"polygons": numbers[sizes == 4], "triangles": numbers[sizes == 3]},
        edge_sets=grid.edge_sets,
    )


def spaces(order: int) -> dict[str, Space]:
    triangles = triangulate(square(1.0), size=0.3)
    polygons = dual(triangles)
    return {
        "fem": Space(triangles, Lagrange(order)),
        "vem": Space(polygons, Virtual(order)),
        "vem on triangles": Space(triangles, Virtual(order)),
        "mixed": Space(mixed_mesh(), {"polygons": Virtual(order), "triangles": Lagrange(order)}),
    }


NAMES = ("fem", "vem", "vem on triangles", "mixed")


def solved(problem: Elasticity, values: np.ndarray) -> np.ndarray:
    """Displacements (n_dofs, 2) with the given values (n_nodes, 2) on the boundary and no load."""
    space = problem.space
    held = np.zeros((space.n_dofs, 2), dtype=bool)
    held[space.edge_nodes(space.mesh.boundary_edges).ravel()] = True
    held = held.ravel()
    displacement = np.zeros(2 * space.n_dofs)
    displacement[: values.size] = values.ravel()
    displacement[~held] = 0.0
    stiffness = problem.stiffness().full().tocsc()
    displacement[~held] = spsolve(stiffness[~held][:, ~held], -(stiffness @ displacement)[~held])
    return displacement.reshape(-1, 2)


@pytest.mark.parametrize("hypothesis", ["plane_strain", "plane_stress"])
@pytest.mark.parametrize("order", [1, 2])
@pytest.mark.parametrize("name", NAMES)
def test_a_linear_displacement_is_reproduced(name: str, order: int, hypothesis: str) -> None:
    """With a linear displacement on the boundary, inside is linear and the stress uniform, to 1e-11."""
    space = spaces(order)[name]
    material = Elastic(210e3, 0.3, hypothesis)
    problem = Elasticity(space, material)
    exact = space.nodes @ GRADIENT.T + SHIFT
    displacement = solved(problem, exact)
    assert np.abs(displacement[: space.n_nodes] - exact).max() < 1e-11 * np.abs(exact).max()
    stress = np.einsum("ijkl,kl->ij", material.stiffness, GRADIENT)
    normal = np.sum(material.out_of_plane * GRADIENT)
    expected = np.array([stress[0, 0], stress[1, 1], stress[0, 1], normal])
    computed = cell_stresses(problem, displacement).components
    assert np.abs(computed - expected).max() < 1e-11 * np.abs(stress).max()


@pytest.mark.parametrize("order", [1, 2])
@pytest.mark.parametrize("name", NAMES)
def test_rigid_motions_cost_nothing_and_only_these(name: str, order: int) -> None:
    """Two translations and a rotation have no energy; every other displacement has."""
    space = spaces(order)[name]
    stiffness = Elasticity(space, Elastic(1.0, 0.3)).stiffness().full().toarray()
    scale = np.abs(stiffness).max()
    x, y = space.nodes.T
    rigid = np.zeros((3, space.n_dofs, 2))
    rigid[0, :, 0] = rigid[1, :, 1] = 1.0
    if space.n_dofs > space.n_nodes:
        interior = np.zeros((space.n_dofs - space.n_nodes, 2))
        for batch in space.batches():
            if batch.element.n_interior() == 0:
                continue
            value = batch.element.reconstruct(batch.vertices)
            interior[batch.dofs[-1] - space.n_nodes] = value.frame.origin.T
        x, y = np.vstack((space.nodes, interior)).T
    rigid[2] = np.stack((-y, x), axis=1)
    for motion in rigid.reshape(3, -1):
        assert abs(motion @ stiffness @ motion) < 1e-11 * scale * (motion @ motion)
    values = np.linalg.eigvalsh(stiffness)
    assert (np.abs(values[:3]) < 1e-11 * scale).all()
    assert values[3] > 1e-4 * scale


@pytest.mark.parametrize("name", NAMES)
def test_the_energy_of_a_linear_displacement_is_exact(name: str) -> None:
    """Half u K u of a linear displacement is half stress times strain times the volume."""
    space = spaces(1)[name]
    material = Elastic(70.0, 0.33)
    problem = Elasticity(space, material, thickness=2.5)
    u = (space.nodes @ GRADIENT.T).ravel()
    strain = (GRADIENT + GRADIENT.T) / 2.0
    exact = 2.5 * np.einsum("ij,ijkl,kl", strain, material.stiffness, strain)
    assert u @ problem.stiffness().full() @ u == pytest.approx(exact, rel=1e-12)
