"""Nonlinear materials: consistent tangents, patch tests on polygons, cycles with hardening, supports, wrong input."""

import numpy as np
import pytest

from flangeway.elements import Lagrange, Virtual
from flangeway.errors import InputError
from flangeway.geometry import square
from flangeway.materials import Elastic, J2Plasticity, NeoHooke, Orthotropic
from flangeway.mesh import agglomerated, dual, rectangle_grid, triangulate
from flangeway.problems import (
    Elasticity,
    PrescribedDisplacement,
    RigidHandle,
    Spring,
    TemperatureChange,
    Traction,
    fixed,
)
from flangeway.solve import StepSettings, solve_elasticity, solve_nonlinear
from flangeway.space import Space
from flangeway_studies.forms import mapped, membrane

ELASTIC = Elastic(200.0, 0.3)
MATERIALS = {
    "neo-Hooke": NeoHooke(ELASTIC),
    "perfect": J2Plasticity(ELASTIC, 0.3),
    "hardening": J2Plasticity(ELASTIC, 0.3, isotropic=7.0, kinematic=11.0),
}
RNG = np.random.default_rng(3)
GRADIENTS = 0.01 * RNG.standard_normal((20, 2, 2))
IN_SPACE = 0.01 * np.random.default_rng(5).standard_normal((20, 3, 3))


@pytest.mark.parametrize("gradients", [GRADIENTS, IN_SPACE], ids=["plane", "space"])
@pytest.mark.parametrize("name", MATERIALS)
def test_the_tangent_is_the_derivative_of_the_stress(name, gradients):
    """Central differences of the stress, from a history with plastic strain, agree to 2e-6 of the largest entry."""
    material, d = MATERIALS[name], gradients.shape[1]
    history = material.respond(gradients[::-1], np.zeros((20, material.n_history))).history
    tangent = material.respond(gradients, history).tangent
    for i, j in np.ndindex(d, d):
        step = np.zeros((d, d))
        step[i, j] = 1e-7
        up, down = (material.respond(gradients + sign * step, history).stress for sign in (1.0, -1.0))
        np.testing.assert_allclose((up - down) / 2e-7, tangent[..., i, j], atol=2e-6 * np.abs(tangent).max())


def test_the_stress_of_neo_hooke_is_the_derivative_of_its_energy_and_turns_with_the_body():
    """Of G / 2 (tr F^T F - 2 - 2 ln J) + L / 2 (ln J)^2; a rotation before or after the stretch turns the stress."""
    material, lame, shear = NeoHooke(ELASTIC), float(ELASTIC.matrix[0, 1]), ELASTIC.shear_modulus

    def energy(gradient):
        f = gradient + np.eye(2)
        log = np.log(np.linalg.det(f))
        return shear / 2.0 * ((f**2).sum() - 2.0 - 2.0 * log) + lame / 2.0 * log**2

    gradient = np.array([[0.4, 0.2], [-0.3, 0.1]])
    stress = material.respond(gradient[None], np.zeros((1, 0))).stress[0]
    for i, j in np.ndindex(2, 2):
        step = np.zeros((2, 2))
        step[i, j] = 1e-6
        assert stress[i, j] == pytest.approx((energy(gradient + step) - energy(gradient - step)) / 2e-6, rel=1e-6)
    turn = np.array([[0.6, -0.8], [0.8, 0.6]])
    turned = material.respond((turn @ (gradient + np.eye(2)) - np.eye(2))[None], np.zeros((1, 0))).stress[0]
    np.testing.assert_allclose(turned, turn @ stress, atol=1e-11)


def test_a_shear_cycle_with_kinematic_hardening_is_the_known_one():
    """Pure shear: yield at k = sy / sqrt 3, hardening slope G H / (H + 3 G); reversed yield 2 k below the peak."""
    hard = 11.0
    material, shear, k = J2Plasticity(ELASTIC, 0.3, kinematic=hard), ELASTIC.shear_modulus, 0.3 / np.sqrt(3.0)
    history, found = np.zeros((1, 5)), []
    for gamma in (0.02, 0.02 - 2.0 * k / shear, -0.02):
        stress, _, history = material.respond(np.array([[[0.0, gamma], [0.0, 0.0]]]), history)
        found.append(stress[0, 0, 1])
    slope = shear * hard / (hard + 3.0 * shear)
    peak = k + slope * (0.02 - k / shear)
    np.testing.assert_allclose(found, [peak, peak - 2.0 * k, peak - 2.0 * k - slope * (0.04 - 2.0 * k / shear)])


MESHES = {
    "triangles": lambda: triangulate(square(1.0), size=0.3),
    "duals": lambda: dual(triangulate(square(1.0), size=0.3)),
    "not convex": lambda: agglomerated(triangulate(square(1.0), size=0.12), 15),
}


@pytest.mark.parametrize("name", MATERIALS)
@pytest.mark.parametrize(("mesh", "element"), [("triangles", Lagrange(2)), ("duals", Virtual(1)), ("duals", Virtual(4)),
                                               ("not convex", Virtual(2))])  # fmt: skip
def test_patch(name, mesh, element):
    """A linear displacement of the boundary is found inside, with the material's own stress at all points."""
    material, slope = MATERIALS[name], np.array([[0.01, 0.02], [-0.004, 0.003]]) * (20.0 if name == "neo-Hooke" else 1)
    space = Space(MESHES[mesh](), element)
    sides = [
        PrescribedDisplacement(side, x=lambda p: p @ slope[0], y=lambda p: p @ slope[1])
        for side in space.mesh.edge_sets
    ]
    (solution,) = solve_nonlinear(Elasticity(space, ELASTIC, supports=sides), material)
    assert solution.status.converged
    np.testing.assert_allclose(solution.displacements[: space.n_nodes], space.nodes @ slope.T, atol=1e-11)
    stress = material.respond(slope[None], np.zeros((1, material.n_history))).stress
    np.testing.assert_allclose(solution.stress, np.broadcast_to(stress, solution.stress.shape), atol=1e-9)


def test_supports_and_materials_of_cell_sets_are_those_of_elasticity():
    """Small loads with a spring, a rigid handle and two materials: the linear solution to 1e-5, thickness included."""
    mesh = MESHES["duals"]()
    mesh = mesh.with_cell_set("low", mesh.cell_centroids[:, 1] < 0.0).with_cell_set(
        "high", mesh.cell_centroids[:, 1] >= 0.0
    )
    stiff = Elastic(600.0, 0.2)
    supports = [Spring("left", x=30.0, y=40.0), RigidHandle("right", y=1e-7, force=(2e-6, 0.0), moment=1e-6)]
    loads = [Traction("top", (1e-6, 2e-6))]
    problem = Elasticity(Space(mesh, Virtual(2)), {"low": ELASTIC, "high": stiff}, 2.0, loads, supports)
    expected = solve_elasticity(problem).displacements
    laws = {"low": NeoHooke(ELASTIC), "high": J2Plasticity(stiff, 0.3)}
    (solution,) = solve_nonlinear(problem, laws)
    assert solution.status.converged
    np.testing.assert_allclose(solution.displacements, expected, atol=1e-5 * np.abs(expected).max())


def test_beyond_the_collapse_load_the_status_says_so():
    """A perfectly plastic bar pulled beyond its limit is not converged, after shorter steps."""
    space = Space(rectangle_grid(1.0, 1.0, 2, 2), Lagrange(2))
    supports = [PrescribedDisplacement("left", x=0.0), PrescribedDisplacement("bottom", y=0.0)]
    problem = Elasticity(space, ELASTIC, loads=[Traction("right", (1.0, 0.0))], supports=supports)
    limit = 0.3 * 2.0 / np.sqrt(3.0)
    steps = StepSettings(smallest=0.25)
    below, beyond = solve_nonlinear(problem, MATERIALS["perfect"], [0.99 * limit, 1.01 * limit], steps=steps)
    assert below.status.converged
    assert not beyond.status.converged
    assert beyond.factor < 1.01 * limit


WRONG = {
    "yield_stress": lambda _: J2Plasticity(ELASTIC, 0.0),
    "kinematic": lambda _: J2Plasticity(ELASTIC, 1.0, kinematic=-1.0),
    "plane strain": lambda _: NeoHooke(Elastic(1.0, 0.3, "plane_stress")),
    "NeoHooke with": lambda _: NeoHooke(Orthotropic((1.0, 1.0, 1.0), (0.1, 0.1, 0.1), 1.0)),
    "plane_stress": lambda s: solve_nonlinear(Elasticity(s, Elastic(1.0, 0.3, "plane_stress")), NeoHooke(ELASTIC)),
    "a NonlinearMaterial": lambda s: solve_nonlinear(Elasticity(s, ELASTIC), ELASTIC),
    "with heat": lambda s: solve_nonlinear(
        Elasticity(s, Elastic(1.0, 0.3, expansion=1.0), loads=[TemperatureChange(1.0)]), NeoHooke(ELASTIC)
    ),
    "move as a whole|holds": lambda s: solve_nonlinear(Elasticity(s, ELASTIC), NeoHooke(ELASTIC)),
}


@pytest.mark.parametrize("words", WRONG)
def test_wrong_input_is_named(words):
    """Each error says what was wrong."""
    with pytest.raises(InputError, match=words):
        WRONG[words](Space(rectangle_grid(1.0, 1.0, 2, 2), Lagrange(1)))


CELLS = (
    ("triangles", 16, Lagrange(2)),
    ("duals", 10, Virtual(2)),
    ("not convex", 7, Virtual(2)),
    ("duals", 6, Virtual(3)),
)


def test_kinds_of_cells_agree_on_a_membrane_at_finite_strain():
    """With G = 40 and Lame's constant 100, kinds of cells agree to 0.5 % on a displacement of 9.7; forces balance."""
    rubber, found = NeoHooke(Elastic(800.0 / 7.0, 5.0 / 14.0)), []
    for kind, n, element in CELLS:
        loads, supports = [Traction("right", (0.0, 4.0))], [fixed("left")]
        problem = Elasticity(
            Space(mapped(kind, n, n, membrane), element), rubber.elastic, loads=loads, supports=supports
        )
        (solution,) = solve_nonlinear(problem, rubber)
        assert solution.status.converged
        np.testing.assert_allclose(solution.nodal_forces.sum(axis=0), [0.0, -64.0], atol=4e-5)
        found.append(solution.displacements[problem.node_at((48.0, 60.0)), 1])
    assert np.ptp(found) < 5e-3 * np.mean(found)
