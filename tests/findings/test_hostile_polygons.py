"""Hostile cells: thin V shapes, spirals, stars, a hundred sides. Three motions without energy; digits are reported."""

import warnings

import numpy as np
import pytest

from flangeway.elements import StabilisationFree, Virtual
from flangeway.errors import InputError
from flangeway.materials import Elastic
from flangeway.mesh import PolyMesh
from flangeway.problems import Elasticity, PrescribedDisplacement, Traction, fixed
from flangeway.solve import solve_elasticity
from flangeway.space import Space

MATERIAL = Elastic(1.0, 0.3)
STRESS = np.array([[1.0, 0.4], [0.4, -0.3]])


def vee(thickness):
    return np.array(
        [[0.0, 0.0], [1.0, 1.0], [1.0, 1.0 + thickness], [0.0, thickness], [-1.0, 1.0 + thickness], [-1.0, 1.0]]
    )


def spiral(thickness, turns=2, n=40):
    angle = np.linspace(0.0, 2.0 * np.pi * turns, n)
    radius, unit = 0.2 + angle / 10.0 / np.pi, np.stack((np.cos(angle), np.sin(angle)), axis=1)
    return np.concatenate(((radius + thickness)[:, None] * unit, (radius[:, None] * unit)[::-1]))


def star(n, inner):
    angle = np.pi * np.arange(2 * n) / n
    return np.where(np.arange(2 * n) % 2, inner, 1.0)[:, None] * np.stack((np.cos(angle), np.sin(angle)), axis=1)


SHAPES = {
    "V of 1e-2": vee(1e-2),
    "V of 1e-3": vee(1e-3),
    "spiral": spiral(0.02),
    "thin spiral": spiral(1e-3),
    "100 sides": star(50, 1.0),
    "star of 100 sides": star(50, 0.1),
    "star with thin rays": star(7, 1e-2),
}
ELEMENTS = [Virtual(1), Virtual(2), Virtual(3), Virtual(4), StabilisationFree(1), StabilisationFree(2)]


def one_cell(points):
    """Mesh of one cell whose edges have names."""
    n = np.arange(len(points))
    edges = np.stack((n, np.roll(n, -1)), axis=1)
    return PolyMesh(points, [0, len(points)], n, edge_sets={f"edge {i}": edges[i : i + 1] for i in n})


@pytest.mark.parametrize("element", [Virtual(1), Virtual(2)])
@pytest.mark.parametrize("name", SHAPES)
def test_three_motions_have_no_energy(name, element):
    """Three eigenvalues of the cell's stiffness are round-off, and the fourth is a hundred times larger or more."""
    problem = Elasticity(Space(one_cell(SHAPES[name]), element), MATERIAL)
    (batch,) = problem.space.batches()
    values = np.linalg.eigvalsh(problem.cell_stiffness(batch)[..., 0])
    assert np.abs(values[:3]).max() < 1e-15 * values[-1] * 5.0
    assert values[3] > 1e-13 * 0.5 * values[-1]
    assert values[3] > 1e2 * np.abs(values[:3]).max()


@pytest.mark.parametrize("element", ELEMENTS)
@pytest.mark.parametrize("name", SHAPES)
def test_an_answer_is_right_or_says_how_many_digits_are(name, element):
    """Uniform stress under its tractions: the error is that of the digits in the status, or the input is refused."""
    points = SHAPES[name]
    mesh = one_cell(points)
    loads = []
    for i, (a, b) in enumerate(zip(points, np.roll(points, -1, axis=0), strict=True)):
        normal = np.array([(b - a)[1], -(b - a)[0]]) / np.linalg.norm(b - a)
        loads.append(Traction(f"edge {i}", tuple(STRESS @ normal)))
    xx, yy, twice_xy = np.linalg.solve(MATERIAL.matrix[:3, :3], [STRESS[0, 0], STRESS[1, 1], STRESS[0, 1]])
    exact = (points - points[0]) @ np.array([[xx, twice_xy / 2.0], [twice_xy / 2.0, yy]])
    far = int(np.abs(points[:, 0] - points[0, 0]).argmax())
    supports = [fixed(tuple(points[0])), PrescribedDisplacement(tuple(points[far]), y=float(exact[far, 1]))]
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        try:
            solution = solve_elasticity(Elasticity(Space(mesh, element), MATERIAL, loads=loads, supports=supports))
        except InputError:
            solution = None
    may_be_refused = isinstance(element, StabilisationFree) or (name == "V of 1e-3" and element.order > 2)
    assert solution is not None or may_be_refused
    if solution is None:
        return
    error = np.abs(solution.displacements[: len(points)] - exact).max() / np.abs(exact).max()
    digits = solution.status.digits
    assert error < 10.0 ** (1.7 - digits)
    if error > 1e-4:
        assert f"{digits:.0f} digits" in solution.status.message or not solution.status.converged
