"""Loads, supports and reactions of elastic bodies against what statics and Hooke's law say."""

import numpy as np
import pytest

from flangeway.elements import Lagrange, Virtual
from flangeway.errors import InputError
from flangeway.geometry import Placement, square
from flangeway.materials import Elastic, Orthotropic
from flangeway.mesh import PolyMesh, dual, rectangle_grid, triangulate
from flangeway.post import cell_stresses, corner_stresses, reactions, relative_nodal_residual
from flangeway.problems import (
    BodyForce,
    ElasticField,
    Elasticity,
    Gravity,
    PrescribedDisplacement,
    Pressure,
    RigidHandle,
    Spring,
    TemperatureChange,
    Traction,
    fixed,
)
from flangeway.solve import solve_elasticity
from flangeway.space import Space

STEEL = Elastic(1000.0, 0.3, density=2.0, expansion=1e-3)
SYMMETRY = (PrescribedDisplacement("bottom", y=0.0), PrescribedDisplacement("left", x=0.0))
SPACES = {
    "triangles 1": lambda mesh: Space(mesh, Lagrange(1)),
    "triangles 2": lambda mesh: Space(mesh, Lagrange(2)),
    "triangles 3": lambda mesh: Space(mesh, Lagrange(3)),
    "polygons 1": lambda mesh: Space(dual(mesh), Virtual(1)),
    "polygons 2": lambda mesh: Space(dual(mesh), Virtual(2)),
    "polygons 4": lambda mesh: Space(dual(mesh), Virtual(4)),
}


def block(width: float = 2.0, height: float = 1.0) -> PolyMesh:
    return rectangle_grid(width, height, 6, 4)


@pytest.fixture(params=sorted(SPACES))
def space(request) -> Space:
    """A block of 2 by 1 with each kind of element."""
    return SPACES[request.param](block())


def at_nodes(solution):
    """Nodes and their displacements."""
    nodes = solution.problem.space.nodes
    return nodes, solution.displacements[: len(nodes)]


def test_uniaxial_tension_in_plane_stress(space: Space) -> None:
    """A traction on one side stretches by t / E and narrows by nu t / E."""
    material = Elastic(1000.0, 0.3, "plane_stress")
    solution = solve_elasticity(
        Elasticity(space, material, thickness=0.2, loads=[Traction("right", (5.0, 0.0))], supports=SYMMETRY)
    )
    nodes, moved = at_nodes(solution)
    assert moved == pytest.approx(nodes * np.array([5e-3, -1.5e-3]), abs=1e-12)
    assert solution.energy == pytest.approx(0.5 * 5.0 * 5e-3 * 2.0 * 0.2)
    assert solution.load_work == pytest.approx(2.0 * solution.energy)
    assert solution.status.converged


def test_pressure_all_around_compresses_evenly(space: Space) -> None:
    """Under pressure on all sides the in-plane stress is minus the pressure, wherever the sides lie."""
    loads = [Pressure(name, 3.0) for name in ("bottom", "right", "top", "left")]
    supports = [fixed((0.0, 0.0)), PrescribedDisplacement((2.0, 0.0), y=0.0)]
    solution = solve_elasticity(Elasticity(space, STEEL, loads=loads, supports=supports))
    expected = np.array([-3.0, -3.0, 0.0, -1.8])
    assert corner_stresses(solution.problem, solution.displacements).components - expected == pytest.approx(
        0.0, abs=1e-8
    )
    assert np.abs(solution.nodal_reactions).max() < 1e-9


def test_weight_of_a_column(space: Space) -> None:
    """The reaction is the weight, at any order; from order 2 on a column under its weight settles quadratically."""
    material = Elastic(1000.0, 0.0, density=2.0)
    solution = solve_elasticity(
        Elasticity(space, material, thickness=0.5, loads=[Gravity((0.0, -9.0))], supports=[fixed("bottom")])
    )
    assert reactions(solution)[0].force == pytest.approx([0.0, 2.0 * 9.0 * 2.0 * 0.5], abs=1e-9)
    if space.order > 1:
        nodes, moved = at_nodes(solution)
        y = nodes[:, 1]
        assert moved[:, 1] == pytest.approx(-18.0 / 1000.0 * (y - y**2 / 2.0), abs=1e-12)


def test_body_force_may_be_a_function_or_act_on_a_set() -> None:
    """The sum of the forces is the integral of the function over its cells."""
    mesh = block()
    mesh = mesh.with_cell_set("right half", mesh.cell_centroids[:, 0] > 1.0)
    problem = Elasticity(
        Space(mesh, Virtual(3)),
        STEEL,
        loads=[BodyForce(lambda p: np.stack((p[:, 0] ** 2, p[:, 1]), axis=1), cells="right half")],
        supports=[fixed("left")],
    )
    force = reactions(solve_elasticity(problem))[0].force
    assert force == pytest.approx([-7.0 / 3.0, -0.5])


def test_traction_may_be_a_function() -> None:
    """A linear traction has its resultant and its moment."""
    problem = Elasticity(
        Space(block(), Lagrange(2)),
        STEEL,
        loads=[Traction("top", lambda p: np.stack((0.0 * p[:, 0], 3.0 * p[:, 0]), axis=1))],
        supports=[fixed("bottom")],
    )
    reaction = reactions(solve_elasticity(problem))[0]
    assert reaction.force == pytest.approx([0.0, -6.0], abs=1e-10)
    assert reaction.moment == pytest.approx(-8.0)


@pytest.mark.parametrize("hypothesis", ["plane_strain", "plane_stress", "axisymmetric"])
def test_free_thermal_expansion(space: Space, hypothesis: str) -> None:
    """A body that is free to expand has no stress but, in plane strain, -E alpha T out of the plane."""
    material = Elastic(1000.0, 0.3, hypothesis, expansion=1e-3)
    supports = SYMMETRY[:1] if hypothesis == "axisymmetric" else SYMMETRY
    solution = solve_elasticity(Elasticity(space, material, loads=[TemperatureChange(20.0)], supports=supports))
    nodes, moved = at_nodes(solution)
    strain = 0.02 * (1.3 if hypothesis == "plane_strain" else 1.0)
    assert moved == pytest.approx(strain * nodes, abs=1e-9)
    out_of_plane = -1000.0 * 0.02 if hypothesis == "plane_strain" else 0.0
    expected = np.array([0.0, 0.0, 0.0, out_of_plane])
    stress = cell_stresses(solution.problem, solution.displacements).components
    assert stress - expected == pytest.approx(0.0, abs=1e-7)
    energy = 0.5 * out_of_plane**2 / 1000.0 * 2.0
    assert solution.energy == pytest.approx(energy, abs=1e-9)


def test_a_temperature_that_varies_bends_a_strip() -> None:
    """A strip heated linearly over its height bends freely into a parabola without stress."""
    material = Elastic(1000.0, 0.3, "plane_stress", expansion=1e-3)
    supports = [fixed((0.0, 0.0)), PrescribedDisplacement((2.0, 0.0), y=0.0)]
    problem = Elasticity(
        Space(block(), Lagrange(2)), material, loads=[TemperatureChange(lambda p: 10.0 * p[:, 1])], supports=supports
    )
    solution = solve_elasticity(problem)
    assert corner_stresses(problem, solution.displacements).components == pytest.approx(0.0, abs=1e-9)
    nodes, moved = at_nodes(solution)
    bottom = nodes[:, 1] == 0.0
    assert moved[bottom, 1] == pytest.approx(0.01 / 2.0 * nodes[bottom, 0] * (2.0 - nodes[bottom, 0]), abs=1e-12)


@pytest.mark.parametrize("element", [Lagrange(1), Lagrange(2), Virtual(3)])
def test_heat_may_act_on_a_part(element) -> None:
    """Heating the upper half, whose material expands upwards only, lifts the top by it and stresses nothing."""
    mesh = block()
    upper = mesh.cell_centroids[:, 1] > 0.5
    mesh = mesh.with_cell_set("upper", upper).with_cell_set("lower", ~upper)
    wood = Orthotropic((20.0, 10.0, 10.0), (0.3, 0.3, 0.3), 5.0, hypothesis="plane_stress", expansion=(0.0, 1e-3, 0.0))
    materials = {"upper": wood, "lower": Elastic(1000.0, 0.3, "plane_stress")}
    heat = TemperatureChange(lambda p: 10.0 + 0.0 * p[:, 0], cells="upper")
    problem = Elasticity(Space(mesh, element), materials, loads=[heat], supports=[fixed("bottom")])
    solution = solve_elasticity(problem)
    assert corner_stresses(problem, solution.displacements).components == pytest.approx(0.0, abs=1e-10)
    nodes, moved = at_nodes(solution)
    assert moved[:, 1] == pytest.approx(0.01 * np.maximum(nodes[:, 1] - 0.5, 0.0), abs=1e-12)
    assert solution.energy == pytest.approx(0.0, abs=1e-12)


def test_springs_carry_the_load(space: Space) -> None:
    """On a bed of springs a pressed block sinks by pressure over stiffness, and the springs bear it all."""
    material = Elastic(1000.0, 0.0)
    bed = Spring("bottom", y=50.0)
    side = PrescribedDisplacement("left", x=0.0)
    solution = solve_elasticity(Elasticity(space, material, loads=[Pressure("top", 5.0)], supports=[bed, side]))
    nodes, moved = at_nodes(solution)
    assert moved[:, 1] == pytest.approx(-0.1 - 5e-3 * nodes[:, 1], abs=1e-11)
    assert reactions(solution)[0].force == pytest.approx([0.0, 10.0], abs=1e-9)
    assert solution.spring_energy == pytest.approx(0.5 * 50.0 * 0.1**2 * 2.0)
    assert solution.load_work == pytest.approx(2.0 * (solution.energy + solution.spring_energy))


def test_a_spring_at_a_point_in_a_turned_frame() -> None:
    """A spring along a direction pulls back along it, by its stiffness times the displacement."""
    spring = Spring((2.0, 1.0), x=7.0, angle=0.5)
    problem = Elasticity(
        Space(block(), Lagrange(1)), STEEL, loads=[Traction("right", (0.0, 2.0))], supports=[fixed("left"), spring]
    )
    solution = solve_elasticity(problem)
    direction = np.array([np.cos(0.5), np.sin(0.5)])
    stretch = solution.displacement_at_node((2.0, 1.0)) @ direction
    held, pulled = reactions(solution)
    assert pulled.force == pytest.approx(-7.0 * stretch * direction)
    assert held.force + pulled.force == pytest.approx([0.0, -2.0])


@pytest.mark.parametrize("angle", [0.3, np.pi / 2.0, -2.0])
def test_turned_supports_are_the_turned_problem(angle: float) -> None:
    """Turning mesh, load and supports turns the displacements."""
    mesh = block()
    turn = Placement.about((0.0, 0.0), angle)
    results = []
    for body, at in ((mesh, 0.0), (mesh.placed(turn), angle)):
        c, s = np.cos(at), np.sin(at)
        supports = [
            PrescribedDisplacement("bottom", x=0.01, y=lambda p: 0.02 * np.hypot(*p.T), angle=at),
            PrescribedDisplacement("left", x=0.01, angle=at),
        ]
        load = Traction("right", (3.0 * c, 3.0 * s))
        problem = Elasticity(Space(body, Lagrange(2)), STEEL, loads=[load], supports=supports)
        results.append(solve_elasticity(problem))
    straight, turned = (result.displacements for result in results)
    c, s = np.cos(angle), np.sin(angle)
    assert turned == pytest.approx(straight @ np.array([[c, s], [-s, c]]), abs=1e-12)
    assert results[0].energy == pytest.approx(results[1].energy)


def test_a_free_handle_stays_rigid_and_carries_force_and_moment(space: Space) -> None:
    """A loaded handle moves as a rigid line, and the clamp balances its force and moment."""
    handle = RigidHandle("top", force=(1.0, -2.0), moment=0.7, pivot=(0.3, 1.5))
    solution = solve_elasticity(Elasticity(space, STEEL, supports=[fixed("bottom"), handle]))
    x, y, rotation = solution.handle_motions[0]
    nodes = solution.problem.support_nodes(handle)
    arm = space.nodes[nodes] - np.array([0.3, 1.5])
    rigid = np.stack((x - rotation * arm[:, 1], y + rotation * arm[:, 0]), axis=1)
    assert abs(rotation) > 1e-5
    assert solution.displacements[nodes] == pytest.approx(rigid, abs=1e-14)
    clamp, own = reactions(solution)
    assert clamp.force == pytest.approx([-1.0, 2.0])
    assert clamp.moment == pytest.approx(-(0.7 + 0.3 * -2.0 - 1.5 * 1.0))
    assert own.force == pytest.approx([0.0, 0.0], abs=1e-9)
    assert solution.load_work == pytest.approx(2.0 * solution.energy)


def test_a_moved_handle_reacts_with_what_a_loaded_one_needs() -> None:
    """Prescribing the motion that a force caused gives that force and moment as reaction."""
    space = Space(dual(block()), Virtual(2))
    loaded = solve_elasticity(
        Elasticity(space, STEEL, supports=[fixed("bottom"), RigidHandle("top", force=(1.0, -2.0), moment=0.7)])
    )
    x, y, rotation = loaded.handle_motions[0]
    moved = solve_elasticity(
        Elasticity(space, STEEL, supports=[fixed("bottom"), RigidHandle("top", x=x, y=y, rotation=rotation)])
    )
    assert moved.displacements == pytest.approx(loaded.displacements, abs=1e-13)
    handle = reactions(moved)[1]
    assert handle.force == pytest.approx([1.0, -2.0])
    assert handle.moment == pytest.approx(0.7 + 1.0 * -2.0 - 1.0 * 1.0)


def test_a_support_on_a_handle_s_end_guides_it() -> None:
    """A handle whose end slides along a wall cannot leave it, and the wall bears what it takes."""
    space = Space(block(), Lagrange(2))
    supports = [fixed("bottom"), RigidHandle("top", force=(0.0, -1.0)), PrescribedDisplacement("left", x=0.0)]
    solution = solve_elasticity(Elasticity(space, STEEL, supports=supports))
    assert solution.displacement_at_node((0.0, 1.0))[0] == pytest.approx(0.0, abs=1e-15)
    total = sum(reaction.force for reaction in reactions(solution))
    assert total == pytest.approx([0.0, 1.0], abs=1e-10)


def test_gravity_and_pressure_on_a_ring() -> None:
    """Forces on a body of revolution are summed around its axis: weight is density times its volume."""
    mesh = rectangle_grid(2.0, 1.0, 6, 4, origin=(1.0, 0.0))
    material = Elastic(1000.0, 0.3, "axisymmetric", density=2.0)
    for space in (Space(mesh, Lagrange(2)), Space(dual(mesh), Virtual(1)), Space(dual(mesh), Virtual(3))):
        problem = Elasticity(
            space,
            material,
            loads=[Gravity((0.0, -10.0)), Pressure("top", 5.0)],
            supports=[PrescribedDisplacement("bottom", y=0.0)],
        )
        area = np.pi * (9.0 - 1.0)
        assert reactions(solve_elasticity(problem))[0].force[1] == pytest.approx(area * (2.0 * 10.0 + 5.0))


def test_a_handle_on_a_ring_moves_along_the_axis_only() -> None:
    """A rigid end plate pulled along the axis of a tube keeps its radius; its force is the sum around the axis."""
    mesh = rectangle_grid(0.5, 2.0, 3, 8, origin=(1.0, 0.0))
    material = Elastic(1000.0, 0.0, "axisymmetric")
    supports = [PrescribedDisplacement("bottom", y=0.0), RigidHandle("top", force=(0.0, 10.0))]
    solution = solve_elasticity(Elasticity(Space(mesh, Lagrange(2)), material, supports=supports))
    area = np.pi * (1.5**2 - 1.0)
    assert solution.handle_motions[0] == pytest.approx([0.0, 10.0 * 2.0 / (1000.0 * area), 0.0], abs=1e-12)
    assert reactions(solution)[0].force == pytest.approx([0.0, -10.0])


def test_a_mesh_for_a_space_and_a_word_for_a_material_are_told() -> None:
    """The two first arguments of a problem are checked: the message says what to make of them."""
    with pytest.raises(InputError, match=r"Elasticity\(space=PolyMesh.*(\n.*)*write Space\(mesh, element\)"):
        Elasticity(block(), STEEL)  # type: ignore[arg-type]
    space = Space(block(), Lagrange(1))
    for material in ("steel", {"all": "steel"}):
        with pytest.raises(InputError, match=r"material='steel'.*(\n.*)*make an Elastic"):
            Elasticity(space, material)  # type: ignore[arg-type]


GRID = rectangle_grid(2.0, 1.0, 8, 4)
MATERIAL = Elastic(100.0, 0.3)


@pytest.mark.parametrize("space", [Space(GRID, Lagrange(1)), Space(dual(GRID), Virtual(2)), Space(GRID, Lagrange(3))])
def test_all_reactions_balance_the_loads(space: Space) -> None:
    """Forces and moments of every kind of support and of all loads add up to nothing."""
    supports = [
        PrescribedDisplacement("bottom", y=0.01, angle=0.2),
        Spring("right", x=30.0, y=5.0, angle=-0.4),
        PrescribedDisplacement((2.0, 0.0), x=0.003),
        RigidHandle("top", y=-0.02, moment=0.4, pivot=(0.5, 1.0)),
        PrescribedDisplacement("left", x=0.0),
    ]
    loads = [Traction("left", (1.0, 2.0)), BodyForce((0.5, -0.25)), Pressure("right", 0.3)]
    solution = solve_elasticity(Elasticity(space, MATERIAL, loads=loads, supports=supports))
    answer = reactions(solution)
    assert [reaction.support for reaction in answer] == supports
    applied = np.array([1.0 + 1.0 - 0.3, 2.0 - 0.5])
    assert sum(reaction.force for reaction in answer) == pytest.approx(-applied, abs=1e-9)
    moments = -0.5 * 1.0 + (1.0 * -0.5 - 0.5 * 1.0) + 0.5 * 0.3 + 0.4
    assert sum(reaction.moment for reaction in answer) == pytest.approx(-moments, abs=1e-9)


def test_a_corner_held_by_two_supports_is_shared_by_direction() -> None:
    """At a corner, the horizontal force belongs to the support that holds x and the vertical one to that of y."""
    supports = [PrescribedDisplacement("left", x=0.0), PrescribedDisplacement("bottom", y=0.0)]
    loads = [Traction("right", (3.0, 0.0)), Traction("top", (0.0, 2.0))]
    solution = solve_elasticity(Elasticity(Space(GRID, Lagrange(2)), MATERIAL, loads=loads, supports=supports))
    left, bottom = reactions(solution)
    assert left.force == pytest.approx([-3.0, 0.0], abs=1e-10)
    assert left.moment == pytest.approx(0.5 * 3.0)
    assert bottom.force == pytest.approx([0.0, -4.0], abs=1e-10)
    assert bottom.moment == pytest.approx(-4.0)


def test_supports_that_hold_the_same_share_equally() -> None:
    """Two supports of the same edges carry half each."""
    loads = [Traction("right", (3.0, 1.0))]
    solution = solve_elasticity(
        Elasticity(Space(GRID, Lagrange(1)), MATERIAL, loads=loads, supports=[fixed("left"), fixed("left")])
    )
    first, second = reactions(solution)
    assert first.force == pytest.approx(second.force)
    assert first.force == pytest.approx([-1.5, -0.5])


def solved(element):
    """A square under traction, weight and warmth, and which of its components are held."""
    mesh = triangulate(square(1.0), size=0.25)
    space = Space(mesh if isinstance(element, Lagrange) else dual(mesh), element)
    steel = Elastic(210e3, 0.3, expansion=1e-5)
    loads = [Traction("right", (3.0, 5.0)), BodyForce((0.0, -2.0)), TemperatureChange(20.0)]
    solution = solve_elasticity(Elasticity(space, steel, loads=loads, supports=[fixed("left")]))
    held = np.zeros((space.n_nodes, 2), dtype=np.bool_)
    held[solution.problem.support_nodes(fixed("left"))] = True
    return solution, held


@pytest.mark.parametrize("element", [Lagrange(1), Lagrange(2), Virtual(1), Virtual(2), Virtual(3)], ids=str)
def test_a_solution_is_in_equilibrium_at_every_node(element):
    """Loads on edges, in cells and by warmth are in equilibrium with stresses at nodes and in cells to round-off."""
    solution, held = solved(element)
    nothing = np.zeros((solution.problem.space.n_nodes, 2))
    assert relative_nodal_residual(solution, nothing, held) < 1e-11
    assert relative_nodal_residual(solution, nothing, np.zeros_like(held)) > 0.1  # what the support carries


def test_a_moved_node_and_a_missing_force_are_seen():
    """One node moved by a millionth of the size, and a force that is not in the displacements, are no equilibrium."""
    solution, held = solved(Virtual(2))
    space = solution.problem.space
    node = int(np.flatnonzero(~held.any(axis=1))[0])
    wrong = solution.displacements.copy()
    wrong[node] += 1e-6
    nothing, force = np.zeros((space.n_nodes, 2)), np.zeros((space.n_nodes, 2))
    force[node] = 0.1
    assert relative_nodal_residual(ElasticField(solution.problem, wrong), nothing, held) > 1e-3
    assert relative_nodal_residual(solution, force, held) > 1e-3
