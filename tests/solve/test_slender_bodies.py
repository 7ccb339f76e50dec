"""Slender bodies keep their digits, and a status says how many are left."""

import numpy as np
import pytest

from flangeway import Body, Elastic, Elasticity, InputError, Lagrange, Space, Traction, Virtual, fixed, solve_elasticity
from flangeway.elements import Element, NoStabilisation
from flangeway.mesh import PolyMesh, rectangle_grid
from flangeway.problems import Spring
from flangeway.solve import CondensedBodies, ElasticitySolution, SurfaceNodes
from flangeway.solve.status import Status


def beam(length: float, element: Element) -> PolyMesh:
    cells = "triangles" if isinstance(element, Lagrange) else "quadrilaterals"
    return rectangle_grid(length, 1.0, int(2 * length), 2, cells=cells)


def cantilever(length: float, element: Element) -> tuple[ElasticitySolution, float]:
    """A cantilever of height 1 and modulus 1 with a unit force at its end; its deflection over Timoshenko's."""
    mesh = beam(length, element)
    load = Traction("right", (0.0, 1.0))
    solution = solve_elasticity(
        Elasticity(Space(mesh, element), Elastic(1.0, 0.0), loads=[load], supports=[fixed("left")])
    )
    tip = np.flatnonzero(mesh.points[:, 0] == mesh.points[:, 0].max())
    return solution, solution.displacements[tip, 1].mean() / (4.0 * length**3 + 2.4 * length)


@pytest.mark.parametrize("element", [Lagrange(2), Virtual(3)], ids=str)
def test_a_cantilever_a_thousand_times_as_long_as_high(element: Element) -> None:
    """Its deflection is the beam's to 2e-6, where round-off took up to 3 %, and the stated digits are a bound."""
    solution, ratio = cantilever(1000.0, element)
    assert ratio == pytest.approx(1.0, abs=2e-6)
    assert solution.status.converged
    assert solution.status.digits is not None
    assert 4.5 < solution.status.digits <= -np.log10(abs(ratio - 1.0))
    assert "digits" in solution.status.message


def test_a_factor_without_a_positive_pivot() -> None:
    """At a ratio of 3000 the factor of quadrilaterals breaks down; the deflection has the stated digits."""
    solution, ratio = cantilever(3000.0, Virtual(2))
    assert solution.status.converged
    assert solution.status.digits is not None
    assert abs(ratio - 1.0) < 10.0**-solution.status.digits < 1e-3


def test_the_short_cantilever_has_its_digits() -> None:
    """Nothing is said of digits where there are ten or more."""
    solution, _ = cantilever(5.0, Virtual(2))
    assert solution.status.digits is not None
    assert solution.status.digits > 10.0
    assert "digits" not in solution.status.message


def test_a_soft_spring_holds_a_body() -> None:
    """A block on springs of 1e-10 of its stiffness sinks by force over stiffness, to the digits of its status."""
    mesh = rectangle_grid(1.0, 1.0, 3, 3)
    springs = [Spring(point, 1e-10, 1e-10) for point in ((0.0, 0.0), (1.0, 0.0))]
    problem = Elasticity(
        Space(mesh, Lagrange(2)), Elastic(1.0, 0.3), loads=[Traction("top", (0.0, -1e-10))], supports=springs
    )
    solution = solve_elasticity(problem)
    at_spring = solution.displacements[[problem.node_at((0.0, 0.0)), problem.node_at((1.0, 0.0))], 1]
    assert at_spring == pytest.approx(-0.5, rel=1e-9)
    assert solution.status.converged


def test_a_mechanism_is_no_slender_body() -> None:
    """Elements without stabilisation are refused whether or not a load moves the mechanism."""
    space = Space(rectangle_grid(1.0, 1.0, 4, 4, cells="quadrilaterals"), Virtual(1, NoStabilisation()))
    supports = [Spring((0.0, 0.0), 1.0, 1.0), Spring((1.0, 0.0), 0.0, 1.0)]
    for loads in ([Traction("right", (1.0, 0.0))], []):
        with pytest.raises(InputError, match="without force"):
            solve_elasticity(Elasticity(space, Elastic(1.0, 0.3), loads=loads, supports=supports))


def condensed(length: float) -> CondensedBodies:
    mesh = beam(length, Virtual(2))
    body = Body("beam", mesh, Virtual(2), Elastic(1.0, 0.0), held="left")
    return CondensedBodies([SurfaceNodes(body, np.unique(body.edge_nodes(mesh.edge_sets["right"])))])


def test_condensed_bodies() -> None:
    """A flexibility's digits are those of a beam's deflection, and one without digits is refused."""
    response = condensed(100.0)
    n = response.n_nodes
    forces = np.zeros((n, 2))
    forces[:, 1] = 1.0 / n
    moved = response.displacements(np.broadcast_to(np.eye(2), (n, 2, 2)), np.arange(n), forces)
    assert response.digits is not None
    error = abs(moved[:, 1].mean() / (4.0 * 100.0**3 + 240.0) - 1.0)
    assert 5.0 < response.digits < -np.log10(error) + 0.5
    with pytest.raises(InputError, match="round-off"):
        condensed(1000.0)


def test_status() -> None:
    """Fewer than two digits are no convergence; six or more are not spoken of."""
    status = Status(True, "done", 1)
    assert status.with_digits(7.0).message == "done"
    assert status.with_digits(4.0).converged
    assert not status.with_digits(1.5).converged
    assert status.with_digits(None) == status
