"""A body that is not held is reported with its free motion; wrong input is refused in words."""

import re

import numpy as np
import pytest

from flangeway.elements import Lagrange, Virtual
from flangeway.errors import InputError
from flangeway.materials import Elastic
from flangeway.mesh import PolyMesh, rectangle_grid
from flangeway.post import displacements_at, force_through_cut, locate, recovered_stresses, stresses_along, stresses_at
from flangeway.problems import (
    BodyForce,
    Elasticity,
    Gravity,
    PrescribedDisplacement,
    Pressure,
    RigidHandle,
    Spring,
    Traction,
    fixed,
)
from flangeway.solve import solve_elasticity
from flangeway.space import Space

GRID = rectangle_grid(1.0, 1.0, 4, 4)
MATERIAL = Elastic(1.0, 0.3)
X, Y = PrescribedDisplacement("left", x=0.0), PrescribedDisplacement("bottom", y=0.0)


def problem(supports=(), loads=(), mesh: PolyMesh = GRID, material=MATERIAL, **more) -> Elasticity:
    return Elasticity(Space(mesh, Lagrange(2)), material, supports=supports, loads=loads, name="upper", **more)


@pytest.mark.parametrize(
    ("supports", "motion"),
    [
        ([], "can slide in x, slide in y and turn: nothing holds it"),
        ([Y], "can slide in x$"),
        ([X], "can slide in y$"),
        ([PrescribedDisplacement("bottom", y=0.0, angle=0.5)], r"can slide along \(0.878, 0.479\)$"),
        ([fixed((1.0, 0.0))], r"can turn about \(1, 0\)$"),
        ([PrescribedDisplacement((0.0, 0.0), x=0.0)], "can slide in y and turn about"),
        ([PrescribedDisplacement((0.0, 0.0), x=0.0), PrescribedDisplacement((0.0, 1.0), x=0.0)], "can slide in y$"),
        (
            [PrescribedDisplacement((1.0, 1.0), x=0.0), PrescribedDisplacement((0.0, 0.5), y=0.0)],
            r"turn about \(0, 1\)",
        ),
        ([Spring("bottom", y=1.0)], "can slide in x$"),
        ([RigidHandle("top", y=0.0, rotation=0.0)], "can slide in x$"),
        ([RigidHandle("top", x=0.0, y=0.0, pivot=(0.25, 1.0))], r"can turn about \(0.25, 1\)$"),
        ([RigidHandle("top"), Y], "can slide in x$"),
    ],
)
def test_the_free_motion_is_named(supports: list, motion: str) -> None:
    """Whatever mixture of supports is missing, the message says how the body can still move."""
    with pytest.raises(InputError, match="body `upper` ") as error:
        solve_elasticity(problem(supports))
    assert error.value.given.startswith("body `upper` can ")
    assert re.search(motion, error.value.given), error.value.given


@pytest.mark.parametrize(
    "supports",
    [
        [X, Y],
        [fixed((0.0, 0.0)), PrescribedDisplacement((1.0, 0.0), y=0.0)],
        [Y, Spring((0.5, 1.0), x=1e-3)],
        [RigidHandle("top", x=0.0, y=0.0, rotation=0.0)],
        [RigidHandle("top"), X, Y],
        [PrescribedDisplacement("bottom", y=0.0, angle=0.4), PrescribedDisplacement((0.0, 0.0), x=0.0)],
    ],
)
def test_what_is_just_held_is_solved(supports: list) -> None:
    """Supports that are just enough give a solution under a load, in balance."""
    solution = solve_elasticity(problem(supports, [Traction("right", (0.3, 0.1))]))
    assert solution.status.converged
    assert solution.energy > 0.0


def test_an_axisymmetric_body_only_slides_along_its_axis() -> None:
    """A ring needs to be held along its axis only."""
    ring = rectangle_grid(1.0, 1.0, 3, 3, origin=(1.0, 0.0))
    material = Elastic(1.0, 0.3, "axisymmetric")
    with pytest.raises(InputError, match="can slide in y"):
        solve_elasticity(problem([], [Pressure("left", 1.0)], ring, material))
    assert solve_elasticity(problem([Y], [Pressure("left", 1.0)], ring, material)).energy > 0.0


def test_each_piece_of_a_mesh_must_be_held() -> None:
    """Of two blocks the one that is loose is named; joined by a handle, both are held."""
    both = GRID.merged(rectangle_grid(1.0, 1.0, 2, 2, origin=(3.0, 0.0)))
    left = [fixed((0.0, 0.0)), fixed((0.0, 1.0))]
    with pytest.raises(InputError, match=r"piece with the cell at \(3\.\d+, 0\.\d+\), can slide in x, slide in y"):
        solve_elasticity(problem(left, [], both))
    joined = [*left, RigidHandle("top")]
    assert solve_elasticity(problem(joined, [Traction("right", (0.0, 1.0))], both)).energy > 0.0


def test_pieces_joined_at_a_point_can_turn_about_it() -> None:
    """Two squares that share one corner are a hinge: the loose one turns about the corner."""
    points = np.array([[0, 0], [1, 0], [1, 1], [0, 1], [2, 1], [2, 2], [1, 2]], dtype=np.float64)
    hinge = PolyMesh(points, np.array([0, 4, 8]), np.array([0, 1, 2, 3, 2, 4, 5, 6]))
    hinge = hinge.with_edge_set("bottom", [[0, 1]])
    body = Elasticity(Space(hinge, Virtual(1)), MATERIAL, supports=[fixed("bottom")])
    with pytest.raises(InputError, match=r"can turn about \(1, 1\)"):
        solve_elasticity(body)


FLAT = Elastic(1.0, 0.3, "plane_stress")
TWO = GRID.with_cell_set("a", np.arange(16)).with_cell_set("b", np.arange(16, 32))
OVERLAPPING = GRID.with_cell_set("a", np.arange(10)).with_cell_set("b", np.arange(8, 32))
AXI = Elastic(1.0, 0.3, "axisymmetric")


@pytest.mark.parametrize(
    ("wrong", "words"),
    [
        (lambda: problem(loads=[Traction("rigth", (1.0, 0.0))]), "rigth.*\n.*bottom, left, right, top"),
        (lambda: problem(supports=[RigidHandle("grip")]), "grip"),
        (lambda: problem(supports=[fixed((0.13, 0.2))]), r"\(0.13, 0.2\).*\n.*the nearest is"),
        (lambda: problem(loads=[BodyForce((1.0, 0.0), cells="core")]), "core"),
        (lambda: problem(loads=[Gravity((0.0, -9.81))]), "density"),
        (lambda: Traction("right", 5.0), "two finite numbers"),
        (lambda: Pressure("right", (1.0, 2.0)), "a finite number"),
        (lambda: PrescribedDisplacement("left"), "without x, y and z"),
        (lambda: PrescribedDisplacement((0.0,), x=0.0), r"a point \(x, y\)"),
        (lambda: Spring("left"), "one of them positive"),
        (lambda: RigidHandle("top", y=0.1, force=(0.0, 1.0)), "force y"),
        (lambda: problem(material={"steel": MATERIAL}), "steel"),
        (lambda: problem(material={"a": MATERIAL, "b": MATERIAL}, mesh=OVERLAPPING), "in 2 of the given cell sets"),
        (lambda: problem(material={"a": MATERIAL, "b": FLAT}, mesh=TWO), "plane_strain and plane_stress"),
        (lambda: problem(material=AXI, thickness=2.0), "summed around the axis"),
        (lambda: problem(material=AXI, mesh=rectangle_grid(2.0, 1.0, 2, 2, origin=(-1.0, 0.0))), "radii x >= 0"),
        (lambda: problem(supports=["left"]), "RigidHandle"),
    ],
)
def test_wrong_items_are_refused(wrong, words: str) -> None:
    """Each wrong load, support, material or body is refused before anything is computed, with what is allowed."""
    with pytest.raises(InputError, match=words) as error:
        wrong()
    assert error.value.allowed
    assert error.value.advice


@pytest.mark.parametrize(
    ("wrong", "words"),
    [
        (lambda: problem([fixed("bottom"), PrescribedDisplacement("left", x=0.1)]), r"contradict.*\(0, 0\)"),
        (lambda: problem([RigidHandle("top"), RigidHandle("left"), Y]), "another at the point"),
        (lambda: problem([RigidHandle("top", x=0.2), X, Y]), "contradict.*handle `top`"),
        (lambda: problem([X, Y], [Traction("right", lambda p: p[:, 0])]), "gives shape"),
        (lambda: problem([X, Y], [Pressure("right", lambda p: p[:, 0] * np.nan)]), "not finite at"),
        (lambda: problem([RigidHandle("top", x=0.1)], material=AXI), "motion along the axis"),
    ],
)
def test_wrong_problems_are_refused_by_the_solver(wrong, words: str) -> None:
    """Contradictions and functions of a wrong shape are input errors, not numbers."""
    with pytest.raises(InputError, match=words):
        solve_elasticity(wrong())


@pytest.mark.parametrize(
    ("wrong", "words"),
    [
        (lambda s: stresses_at(s, [(0.5, 0.5), (2.0, 0.0)]), r"\(2, 0\) outside of body `upper`"),
        (lambda s: displacements_at(s, [(-1.0, 0.0)]), "outside"),
        (lambda s: stresses_along(s, (0.0, 0.0), (0.0, 0.0)), "two different points"),
        (lambda s: stresses_along(s, (0.0, 0.0), (1.0, 0.0), 1), "2 or more"),
        (lambda s: stresses_along(s, (2.0, 0.0), (3.0, 0.0)), "crosses the body"),
        (lambda s: force_through_cut(s, (0.0, 2.0), (1.0, 2.0)), "crosses the body"),
        (lambda s: locate(s.problem.space.mesh, [0.0, 1.0]), r"shape \(n, 2\)"),
    ],
)
def test_wrong_places_are_refused(wrong, words: str) -> None:
    """Points, lines and cuts outside of the body are named."""
    solution = solve_elasticity(problem([X, Y]))
    with pytest.raises(InputError, match=words):
        wrong(solution)


def test_recovery_needs_enough_cells() -> None:
    """A mesh of two triangles has too few cells for a recovered stress."""
    small = rectangle_grid(1.0, 1.0, 1, 1)
    solution = solve_elasticity(problem([X, Y], mesh=small))
    with pytest.raises(InputError, match="too few cells"):
        recovered_stresses(solution)
