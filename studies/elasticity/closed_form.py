"""Bodies whose exact solution is known: Kirsch's plate, Lamé's cylinder, an L-shaped body, a square under tension."""

from collections.abc import Callable, Iterator
from dataclasses import dataclass

import numpy as np

from flangeway.cases.bodies.cook import (
    ENERGY,
    NEARLY_INCOMPRESSIBLE,
    cook_grid,
    method_space,
    published_virtual,
    solve_cook,
)
from flangeway.elements import Element, Lagrange, Virtual
from flangeway.errors import InputError
from flangeway.exact import PlateWithHole, ThickCylinder
from flangeway.exact.notch import Notch
from flangeway.geometry import polygon
from flangeway.materials import Elastic
from flangeway.mesh import PolyMesh, dual, rectangle_grid, triangulate
from flangeway.post import corner_stresses, recovered_stresses, stresses_at
from flangeway.post.adaptive import Measure, RefinementRow, adapt, refine_adaptively, refine_uniformly, stress_errors
from flangeway.problems import Elasticity, PrescribedDisplacement, Pressure, Traction
from flangeway.solve import ElasticitySolution, solve_elasticity
from flangeway.space import Space
from flangeway.types import Floats
from studies.published_numbers import ReproducedNumber, compare

YOUNG, POISSON = 1000.0, 0.3
PLATE, PLATE_SIDE = PlateWithHole(radius=1.0, tension=5.0), 4.0
CYLINDER = ThickCylinder(inner_radius=1.0, outer_radius=2.0, inner_pressure=10.0)
METHODS = {"F": Lagrange(2), "V": published_virtual(2)}
LIMITS = {"Kirsch": 5e-3, "Lamé": 1e-3}
SOFT_STRESS_LIMIT = 0.02  # for stresses of nearly incompressible material


def kirsch_plate(n: int, *, geometric: bool = False) -> PolyMesh:
    """A quarter of a square with a hole, in 2 n^2 triangles that grow outwards; the arc is named left.

    - `geometric`: they grow with the radius.
    """
    grid = rectangle_grid(1.0, 1.0, n, n)
    share, angle = grid.points[:, 0], grid.points[:, 1] * np.pi / 2.0
    direction = np.stack((np.cos(angle), np.sin(angle)), axis=1)
    outer = PLATE_SIDE / direction.max(axis=1)
    radius = outer**share if geometric else 1.0 + share**1.5 * (outer - 1.0)
    points = radius[:, None] * direction
    return PolyMesh(points, grid.cell_offsets, grid.cell_points, edge_sets=grid.edge_sets)


def solve_kirsch(n: int, method: str) -> ElasticitySolution:
    """Plane strain with the exact tractions on the outer sides."""
    mesh = kirsch_plate(n) if method == "F" else dual(kirsch_plate(n))
    supports = [PrescribedDisplacement("bottom", y=0.0), PrescribedDisplacement("top", x=0.0)]
    loads = [Traction("right", plate_traction)]
    return solve_elasticity(
        Elasticity(Space(mesh, METHODS[method]), Elastic(YOUNG, POISSON), loads=loads, supports=supports)
    )


def plate_traction(points: Floats) -> Floats:
    """Tractions (n, 2) of Kirsch's solution on the outer sides of `kirsch_plate` at points (n, 2)."""
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
    stresses = recovered_stresses(solution).nodal.components
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
    inside = recovered_stresses(solution).nodal.components[solution.problem.node_at((1.0, 0.0)), hoop]
    wanted = float(CYLINDER.hoop_stress(radii[:1])[0])
    yield _number("Lamé", code, "hoop stress at the inner wall", "stress", wanted, float(inside))


MATERIAL = Elastic(1.0, 0.3)
EXACT = Notch(shear_modulus=1.0 / 2.6, kolosov=3.0 - 4.0 * 0.3)
COOK_NORM = float(np.sqrt(2.0 * ENERGY))


def l_shape(n: int, cells: str = "quadrilaterals") -> PolyMesh:
    """The square from (-1, -1) to (1, 1) without its lower left quarter, with the edge sets ``outer`` and ``notch``.

    - `n`: number of squares along a length of one.
    - `cells`: ``"quadrilaterals"``, ``"triangles"``, or ``"polygons"``, the dual of these.
    """
    grid = rectangle_grid(
        2.0,
        2.0,
        2 * n,
        2 * n,
        cells="quadrilaterals" if cells == "quadrilaterals" else "triangles",
        origin=(-1.0, -1.0),
    )
    kept = (grid.cell_centroids > 0.0).any(axis=1)
    size = int(grid.cell_sizes[0])
    used, corners = np.unique(grid.cell_points.reshape(-1, size)[kept], return_inverse=True)
    offsets = np.arange(kept.sum() + 1, dtype=np.int32) * size
    mesh = PolyMesh(grid.points[used], offsets, corners.astype(np.int32).ravel())
    if cells == "polygons":
        mesh = dual(mesh)
    middles = np.abs(mesh.points[mesh.boundary_edges].mean(axis=1))
    outer = (middles > 1.0 - 1e-9).any(axis=1)
    return mesh.with_edge_set("outer", mesh.boundary_edges[outer]).with_edge_set("notch", mesh.boundary_edges[~outer])


def solve_l_shape(mesh: PolyMesh, element: Element) -> ElasticitySolution:
    """Plane strain with the exact displacements along ``outer`` and a free notch."""
    held = PrescribedDisplacement(
        "outer", x=lambda p: EXACT.displacements(p)[:, 0], y=lambda p: EXACT.displacements(p)[:, 1]
    )
    return solve_elasticity(Elasticity(Space(mesh, element), MATERIAL, supports=[held]))


@dataclass(frozen=True)
class RefinedBody:
    """A body to be refined, whose error against a known solution can be measured."""

    name: str
    solve: Callable[[PolyMesh, Element], ElasticitySolution]
    measure: Measure
    norm: float = 1.0  # energy norm of the known solution, of which tolerances are fractions

    def uniform(self, element: Element, mesh: PolyMesh, n_levels: int) -> list[RefinementRow]:
        """Solve on a mesh and on its uniform refinements."""
        return refine_uniformly(lambda each: self.solve(each, element), mesh, self.measure, n_levels)

    def adaptive(
        self, element: Element, mesh: PolyMesh, *, tolerance: float, most_steps: int = 50
    ) -> list[RefinementRow]:
        """Refine a mesh by the recovered stresses' error estimate; takes elements that allow hanging points."""
        return refine_adaptively(
            lambda each: self.solve(each, element),
            mesh,
            self.measure,
            tolerance=self.norm * tolerance,
            most_steps=most_steps,
        )


L_SHAPE = RefinedBody("L-shape", solve_l_shape, lambda found: stress_errors(found, EXACT.stresses, degree=12))
"""The degree is high because the exact stresses are no polynomials."""


def cook_reference(tolerance: float) -> ElasticitySolution:
    """Cook's membrane of order 3 on an adaptive mesh; the tolerance is relative to the exact energy norm."""
    run = adapt(
        lambda mesh: solve_cook(Space(mesh, Virtual(3))),
        cook_grid(4),
        lambda solution: recovered_stresses(solution).cell_errors,
        tolerance=tolerance * COOK_NORM,
    )
    return run.last.solution


def refined_cook(reference: ElasticitySolution) -> RefinedBody:
    """Cook's membrane, its errors against a reference, see `cook_reference`."""

    def measure(solution: ElasticitySolution) -> tuple[float, float]:
        return stress_errors(solution, lambda points: stresses_at(reference, points).components[:, :3], degree=3)

    return RefinedBody("Cook", lambda mesh, element: solve_cook(Space(mesh, element)), measure, COOK_NORM)


SIDE, SIZE, TENSION = 1.0, 0.22, 1.0
PATCH_YOUNG, PATCH_POISSON = 20e3, 1.0 / 3.0
"""Lengths in cm, stresses in kN/cm^2. The text does not give the published side, mesh and tension: none matters."""

PATCH_METHODS = ("FD", "VD", "VV", "HE")


@dataclass(frozen=True)
class PatchCode:
    """One configuration, such as ``VVPTO1`` (Moherdaui 2021, Figure 52)."""

    method: str
    """``"FD"`` for Lagrange triangles, ``"VD"`` for virtual triangles, ``"VV"`` for virtual polygons, ``"HE"`` for
    Lagrange triangles inside and virtual quadrilaterals with two aligned edges at the boundary."""
    order: int  # order of the elements

    def __post_init__(self) -> None:
        if self.method not in PATCH_METHODS:
            raise InputError(f"PatchCode(method={self.method!r})", ", ".join(PATCH_METHODS), "choose one of these")

    def __str__(self) -> str:
        return f"{self.method}PTO{self.order}"

    @property
    def published(self) -> bool:
        """Whether Moherdaui (2021) shows or names it."""
        return self.method in ("FD", "VV") and self.order <= 2


@dataclass(frozen=True, eq=False)
class PatchRow:
    """One solution."""

    code: PatchCode  # its configuration
    n_unknowns: int  # components of displacement at nodes; those inside cells are condensed
    stresses: tuple[float, float, float]
    """Value of a corner with the maximum difference from the exact one, over the tension: xx, xy, yy."""
    displacement_error: float  # maximum error of a node's displacement over the maximum displacement
    solution: ElasticitySolution  # the solution

    @property
    def stress_error(self) -> float:
        """Maximum error of a stress over the tension."""
        xx, xy, yy = self.stresses
        return max(abs(xx - 1.0), abs(xy), abs(yy))


def patch_codes(orders: tuple[int, ...] = (1, 2, 3, 4)) -> tuple[PatchCode, ...]:
    """All configurations; there is no Lagrange triangle of order 4."""
    return tuple(
        PatchCode(method, order) for order in orders for method in PATCH_METHODS if order < 4 or method in ("VD", "VV")
    )


def patch_row(code: PatchCode) -> PatchRow:
    """Pull the square to the right, held on the left along x and in one corner along y, in plane strain."""
    space = _space(code)
    material = Elastic(PATCH_YOUNG, PATCH_POISSON)
    supports = [PrescribedDisplacement("left", x=0.0), PrescribedDisplacement((0.0, 0.0), y=0.0)]
    solution = solve_elasticity(
        Elasticity(space, material, loads=[Traction("right", (TENSION, 0.0))], supports=supports)
    )
    stresses = corner_stresses(solution.problem, solution.displacements).components[:, [0, 2, 1]] / TENSION
    exact = np.array([1.0, 0.0, 0.0])
    worst = np.abs(stresses - exact).argmax(axis=0)
    xx, xy, yy = stresses[worst, [0, 1, 2]].tolist()
    stretch = np.array([1.0 - PATCH_POISSON**2, -PATCH_POISSON * (1.0 + PATCH_POISSON)]) * TENSION / PATCH_YOUNG
    wanted = space.nodes * stretch
    error = np.abs(solution.displacements[: space.n_nodes] - wanted).max() / np.abs(wanted).max()
    return PatchRow(code, 2 * space.n_nodes, (xx, xy, yy), float(error), solution)


def _space(code: PatchCode) -> Space:
    corners = [(0.0, 0.0), (SIDE, 0.0), (SIDE, SIDE), (0.0, SIDE)]
    triangles = triangulate(polygon(corners, names=("bottom", "right", "top", "left")), size=SIZE)
    if code.method == "VD":
        element: Element = published_virtual(code.order)
        return Space(triangles, element)
    if code.method == "FD":
        return Space(triangles, Lagrange(code.order))
    return method_space(triangles, code.method[0], code.order)
