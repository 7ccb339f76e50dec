"""Bodies whose stresses are known in closed form: Kirsch's plate with a hole, Lame's thick cylinder."""

from collections.abc import Iterator

import numpy as np

from flangeway.cases.bodies.cook import NEARLY_INCOMPRESSIBLE, published_virtual
from flangeway.elements import Lagrange
from flangeway.exact import PlateWithHole, ThickCylinder
from flangeway.materials import Elastic
from flangeway.mesh import PolyMesh, dual, rectangle_grid
from flangeway.post import recovered_stresses
from flangeway.problems import Elasticity, PrescribedDisplacement, Pressure, Traction
from flangeway.solve import ElasticitySolution, solve_elasticity
from flangeway.space import Space
from flangeway.types import Floats
from flangeway.validation.published_numbers import ReproducedNumber, compare

YOUNG, POISSON = 1000.0, 0.3
PLATE, PLATE_SIDE = PlateWithHole(radius=1.0, tension=5.0), 4.0
CYLINDER = ThickCylinder(inner_radius=1.0, outer_radius=2.0, inner_pressure=10.0)
METHODS = {"F": Lagrange(2), "V": published_virtual(2)}
LIMITS = {"Kirsch": 5e-3, "Lamé": 1e-3}
SOFT_STRESS_LIMIT = 0.02
"""For stresses of nearly incompressible material."""


def kirsch_plate(n: int) -> PolyMesh:
    """A quarter of a square with a hole, in 2 n^2 triangles that grow outwards; the arc is named left."""
    grid = rectangle_grid(1.0, 1.0, n, n)
    share, angle = grid.points[:, 0] ** 1.5, grid.points[:, 1] * np.pi / 2.0
    direction = np.stack((np.cos(angle), np.sin(angle)), axis=1)
    outer = PLATE_SIDE / direction.max(axis=1)
    points = (1.0 + share * (outer - 1.0))[:, None] * direction
    return PolyMesh(points, grid.cell_offsets, grid.cell_points, edge_sets=grid.edge_sets)


def solve_kirsch(n: int, method: str) -> ElasticitySolution:
    """Plane strain with the exact tractions on the outer sides."""
    mesh = kirsch_plate(n) if method == "F" else dual(kirsch_plate(n))
    supports = [PrescribedDisplacement("bottom", y=0.0), PrescribedDisplacement("top", x=0.0)]
    loads = [Traction("right", _plate_traction)]
    return solve_elasticity(
        Elasticity(Space(mesh, METHODS[method]), Elastic(YOUNG, POISSON), loads=loads, supports=supports)
    )


def _plate_traction(points: Floats) -> Floats:
    stress = PLATE.stresses(points)
    on_right = np.isclose(points[:, 0], PLATE_SIDE)
    return np.where(on_right[:, None], stress[:, [0, 2]], stress[:, [2, 1]])


def solve_lame_quarter(n: int, method: str, poisson: float = POISSON) -> ElasticitySolution:
    """A quarter in plane strain under internal pressure, n cells across the wall and 3 n around."""
    grid = rectangle_grid(1.0, 1.0, n, 3 * n)
    radius, angle = 1.0 + grid.points[:, 0], grid.points[:, 1] * np.pi / 2.0
    points = np.stack((radius * np.cos(angle), radius * np.sin(angle)), axis=1)
    mesh = PolyMesh(points, grid.cell_offsets, grid.cell_points, edge_sets=grid.edge_sets)
    held = [PrescribedDisplacement("bottom", y=0.0), PrescribedDisplacement("top", x=0.0)]
    return _pressed(mesh, method, Elastic(YOUNG, poisson), held)


def solve_lame_ring(n: int, method: str, poisson: float = POISSON) -> ElasticitySolution:
    """A slice of the body of revolution that cannot lengthen, n cells across the wall."""
    mesh = rectangle_grid(1.0, 0.5, n, n // 2, origin=(1.0, 0.0))
    held = [PrescribedDisplacement("bottom", y=0.0), PrescribedDisplacement("top", y=0.0)]
    return _pressed(mesh, method, Elastic(YOUNG, poisson, "axisymmetric"), held)


def _pressed(
    triangles: PolyMesh, method: str, material: Elastic, held: list[PrescribedDisplacement]
) -> ElasticitySolution:
    mesh = triangles if method == "F" else dual(triangles)
    loads = [Pressure("left", CYLINDER.inner_pressure)]
    return solve_elasticity(Elasticity(Space(mesh, METHODS[method]), material, loads=loads, supports=held))


def closed_form_numbers() -> Iterator[ReproducedNumber]:
    """Kirsch's and Lamé's values by triangles and polygons of order 2."""
    for method, n in (("F", 32), ("V", 64)):
        yield from _kirsch_numbers(method, solve_kirsch(n, method))
    for method in METHODS:
        for name, solve in (("plane strain", solve_lame_quarter), ("axisymmetric", solve_lame_ring)):
            for poisson in (POISSON, NEARLY_INCOMPRESSIBLE):
                yield from _lame_numbers(f"{method}O2 {name}, nu = {poisson:g}", solve(16, method, poisson), poisson)


def _number(body: str, code: str, quantity: str, unit: str, exact: float, computed: float) -> ReproducedNumber:
    limit, note = LIMITS[body], "closed form"
    if f"{NEARLY_INCOMPRESSIBLE:g}" in code and "stress" in quantity:
        limit, note = SOFT_STRESS_LIMIT, f"{note}; its mean stress is a small change of volume times a large modulus"
    return compare(body, code, quantity, unit, (exact, computed), limit, note)


def _kirsch_numbers(method: str, solution: ElasticitySolution) -> Iterator[ReproducedNumber]:
    problem = solution.problem
    code = f"{method}O2"
    top, side = problem.node_at((0.0, 1.0)), problem.node_at((1.0, 0.0))
    stresses = recovered_stresses(solution).nodal().components
    for place, exact, stress in (("xx above", 3.0, stresses[top, 0]), ("yy beside", -1.0, stresses[side, 1])):
        ratio = float(stress) / PLATE.tension
        yield _number("Kirsch", code, f"stress {place} the hole over the tension", "1", exact, ratio)
    modulus = YOUNG / (2.0 * (1.0 + POISSON))
    wanted = float(PLATE.displacements(np.array([[1.0, 0.0]]), modulus, 3.0 - 4.0 * POISSON)[0, 0])
    moved = float(solution.displacements[side, 0])
    yield _number("Kirsch", code, "displacement of the hole's side", "length", wanted, moved)


def _lame_numbers(code: str, solution: ElasticitySolution, poisson: float) -> Iterator[ReproducedNumber]:
    radii = np.array([CYLINDER.inner_radius, CYLINDER.outer_radius])
    exact = CYLINDER.radial_displacement(radii, YOUNG, poisson).tolist()
    for name, radius, wanted in zip(("inner", "outer"), radii.tolist(), exact, strict=True):
        computed = float(solution.displacement_at_node((radius, 0.0))[0])
        yield _number("Lamé", code, f"displacement of the {name} wall", "length", wanted, computed)
    hoop = 3 if solution.problem.axisymmetric else 1
    inside = recovered_stresses(solution).nodal().components[solution.problem.node_at((1.0, 0.0)), hoop]
    wanted = float(CYLINDER.hoop_stress(radii[:1])[0])
    yield _number("Lamé", code, "hoop stress at the inner wall", "stress", wanted, float(inside))
