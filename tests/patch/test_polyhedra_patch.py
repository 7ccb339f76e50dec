"""Uniform strains on polyhedra: exact in every point, with displacements or tractions given, heat and springs."""

import numpy as np
import pytest

from flangeway.elements import Virtual
from flangeway.materials import Elastic, Orthotropic
from flangeway.mesh import PolyhedralMesh
from flangeway.post import reactions, relative_nodal_residual
from flangeway.problems import (
    Elasticity,
    Gravity,
    PrescribedDisplacement,
    Pressure,
    Spring,
    TemperatureChange,
    Traction,
)
from flangeway.solve import solve_elasticity
from flangeway.space import Space
from tests.polyhedra import BOX, boxes

YOUNG, POISSON = 210000.0, 0.3
STEEL = Elastic(YOUNG, POISSON, density=7.85e-9, expansion=1.2e-5)
GRADIENT = 1e-3 * np.array([[0.1, 0.2, -0.3], [0.05, -0.1, 0.2], [0.3, 0.1, 0.15]])
"""The field `patch_degree_1` of three_dimensions.json."""
STRAIN = (GRADIENT + GRADIENT.T) / 2.0
LAME, SHEAR = YOUNG * POISSON / (1.0 + POISSON) / (1.0 - 2.0 * POISSON), YOUNG / 2.0 / (1.0 + POISSON)
STRESS = LAME * np.trace(STRAIN) * np.eye(3) + 2.0 * SHEAR * STRAIN
COMPONENTS = ((0, 0), (1, 1), (2, 2), (0, 1), (1, 2), (0, 2))
SIDES = ("x-", "x+", "y-", "y+", "z-", "z+")
MESHES = boxes()


@pytest.fixture(params=MESHES)
def mesh(request) -> PolyhedralMesh:
    return MESHES[request.param]


def stresses(solution) -> np.ndarray:
    """Stresses at the centroids of all cells, (n_cells, 6)."""
    result = np.empty((solution.space.mesh.n_cells, 6))
    for batch in solution.space.batches():
        result[batch.cells] = solution.problem.cell_stresses(batch, solution.displacements)[1][:, 0].T
    return result


def corner(mesh: PolyhedralMesh, *place: float) -> tuple[float, float, float]:
    """The point of the mesh at a place."""
    x, y, z = mesh.points[np.linalg.norm(mesh.points - place, axis=1).argmin()].tolist()
    return x, y, z


def held_at_corners(mesh: PolyhedralMesh) -> list[PrescribedDisplacement]:
    """Six supports that hold the rigid motions alone."""
    return [
        PrescribedDisplacement(corner(mesh, *BOX[:3]), x=0.0, y=0.0, z=0.0),
        PrescribedDisplacement(corner(mesh, BOX[3], 0.0, 0.0), y=0.0, z=0.0),
        PrescribedDisplacement(corner(mesh, 0.0, BOX[4], 0.0), z=0.0),
    ]


def test_given_boundary_displacements_strain_every_cell_alike(mesh):
    """With a linear displacement given on the boundary the points inside have it too, and stresses are uniform."""
    supports = [
        PrescribedDisplacement(name, *(lambda p, row=row: p @ row for row in GRADIENT[:2]), z=lambda p: p @ GRADIENT[2])
        for name in SIDES
    ]
    solution = solve_elasticity(Elasticity(Space(mesh, Virtual(1)), STEEL, supports=supports))
    assert np.abs(solution.displacements - mesh.points @ GRADIENT.T).max() < 1e-13 * 1e-3 * BOX[4] * 10.0
    assert np.abs(stresses(solution) - [STRESS[pair] for pair in COMPONENTS]).max() < 1e-11 * np.abs(STRESS).max()
    assert solution.energy == pytest.approx(0.5 * np.sum(STRESS * STRAIN) * np.prod(BOX[3:]), rel=1e-12)


def test_tractions_of_a_uniform_stress_give_it_in_every_cell(mesh):
    """Tractions sigma n on all sides, with six supports that then carry nothing, give the stress sigma."""
    normals = {name: (1.0 if name[1] == "+" else -1.0) * np.eye(3)["xyz".index(name[0])] for name in SIDES}
    loads = [Traction(name, tuple(STRESS @ normal)) for name, normal in normals.items()]
    supports = held_at_corners(mesh)
    solution = solve_elasticity(Elasticity(Space(mesh, Virtual(1)), STEEL, loads=loads, supports=supports))
    assert np.abs(stresses(solution) - [STRESS[pair] for pair in COMPONENTS]).max() < 1e-10 * np.abs(STRESS).max()
    carried = np.abs([reaction.force for reaction in reactions(solution)]).max()
    assert carried < 1e-10 * np.abs(STRESS).max()


def test_a_free_body_grows_by_heat_without_stress(mesh):
    """A uniform rise of temperature stretches a body that is held at its corners, without any stress."""
    load = TemperatureChange(100.0)
    solution = solve_elasticity(
        Elasticity(Space(mesh, Virtual(1)), STEEL, loads=[load], supports=held_at_corners(mesh))
    )
    assert np.abs(solution.displacements - 1.2e-3 * mesh.points).max() < 1e-14
    assert np.abs(stresses(solution)).max() < 1e-9
    assert solution.energy == pytest.approx(0.0, abs=1e-9)


def test_a_pressed_block_on_springs_sinks_uniformly(mesh):
    """Pressure p on a block between smooth walls and a bed of stiffness k: it sinks by p / k, reactions balance."""
    walls = [PrescribedDisplacement(side, **{side[0]: 0.0}) for side in ("x-", "x+", "y-", "y+")]
    bed, pressure = Spring("z-", z=500.0), 30.0
    problem = Elasticity(Space(mesh, Virtual(1)), STEEL, loads=[Pressure("z+", pressure)], supports=[*walls, bed])
    solution = solve_elasticity(problem)
    strain = pressure / (LAME + 2.0 * SHEAR)
    exact = -pressure / 500.0 - strain * mesh.points[:, 2]
    assert np.abs(solution.displacements[:, 2] - exact).max() < 1e-12
    below = reactions(solution)[-1]
    assert below.force == pytest.approx([0.0, 0.0, pressure * 2.0], abs=1e-9)
    assert below.moment == pytest.approx([pressure * 2.0, -pressure * 1.0, 0.0], abs=1e-9)
    zero = np.zeros((problem.space.n_nodes, 3))
    held = np.diff(solution.constraints.transform.indptr).reshape(-1, 3) == 0
    assert relative_nodal_residual(solution, zero, held) < 1e-11


def test_the_weight_is_the_sum_of_the_reactions(mesh):
    """A body on its base has its weight as reaction, at its centre of gravity."""
    loads, supports = [Gravity((0.0, 0.0, -9810.0))], [PrescribedDisplacement("z-", x=0.0, y=0.0, z=0.0)]
    solution = solve_elasticity(Elasticity(Space(mesh, Virtual(1)), STEEL, loads=loads, supports=supports))
    (base,) = reactions(solution)
    weight = 7.85e-9 * 9810.0 * np.prod(BOX[3:])
    assert base.force == pytest.approx([0.0, 0.0, weight], abs=1e-9 * weight)
    assert base.moment == pytest.approx([weight * BOX[4] / 2.0, -weight * BOX[3] / 2.0, 0.0], abs=1e-9 * weight)


def test_orthotropic_bodies_have_their_own_modulus_in_each_direction(mesh):
    """Pulled along z an orthotropic body stretches by sigma / E3 and narrows by nu13 and nu23."""
    wood = Orthotropic((1.0e4, 2.0e4, 3.0e4), (0.2, 0.1, 0.15), 4.0e3, longitudinal=(5.0e3, 6.0e3))
    loads = [Traction("z+", (0.0, 0.0, 12.0)), Traction("z-", (0.0, 0.0, -12.0))]
    solution = solve_elasticity(Elasticity(Space(mesh, Virtual(1)), wood, loads=loads, supports=held_at_corners(mesh)))
    # nu31 / E3 = nu13 / E1 and nu32 / E3 = nu23 / E2
    strains = 12.0 * np.array([-0.15 / 1.0e4, -0.1 / 2.0e4, 1.0 / 3.0e4])
    assert np.abs(solution.displacements - mesh.points * strains).max() < 1e-14
