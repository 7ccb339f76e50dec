"""Plane elasticity (Moherdaui 2021, chapter 5): patch test, Cook's membrane, Kirsch's plate, Lamé's cylinder."""

import math
from collections.abc import Iterator
from dataclasses import replace
from itertools import product

import numpy as np

from flangeway.elements import Lagrange
from flangeway.geometry import polygon
from flangeway.materials import Elastic
from flangeway.mesh import PolyMesh, dual, rectangle_grid, triangulate
from flangeway.post import corner_stresses, recovered_stresses
from flangeway.problems import Elasticity, PrescribedDisplacement, Pressure, Traction
from flangeway.solve import ElasticitySolution, solve_elasticity
from flangeway.space import Space
from flangeway.types import Floats
from flangeway_studies.cook import (
    NEARLY_INCOMPRESSIBLE,
    NEARLY_INCOMPRESSIBLE_WORK,
    CookCode,
    method_space,
    published_virtual,
    solve_cook,
    vertical_displacements,
)
from flangeway_studies.hole import PlateWithHole
from flangeway_studies.study import Limit, Row, Run, published_rows
from flangeway_studies.thick_cylinder import ThickCylinder

PATCH_METHODS = ("FD", "VD", "VV", "HE")
"""Lagrange triangles, virtual triangles, virtual polygons, and Lagrange triangles inside with virtual quadrilaterals
that have two aligned edges at the boundary (Figure 68)."""
PATCH_LIMIT = 1e-9  # of the stresses over the tension
SIDE, SIZE, TENSION = 1.0, 0.22, 1.0
PATCH_MATERIAL = Elastic(20e3, 1.0 / 3.0)
"""Lengths in cm, stresses in kN/cm^2. The text does not give the published side, mesh and tension: none matters."""
NOT_PUBLISHED = {
    "VD": "virtual triangles: not published for this problem",
    "HE": "triangles inside, virtual elements at the boundary (Figure 68): not published for this problem",
}

COOK = "Section 5.3.2"
COOK_LIMIT, COARSEST_LIMIT, INCOMPRESSIBLE_LIMIT = 1e-3, 0.1, 0.01
"""Of order 2 on the finest mesh; of the coarsest meshes; of order 2 on every mesh with Poisson's ratio 0.4999."""
COOK_METHODS = {"F": "Lagrange triangles", "V": "virtual polygons", "H": "triangles, virtual at the boundary"}

YOUNG, POISSON = 1000.0, 0.3
MATERIAL = Elastic(YOUNG, POISSON)
PLATE, PLATE_SIDE = PlateWithHole(radius=1.0, tension=5.0), 4.0
CYLINDER = ThickCylinder(inner_radius=1.0, outer_radius=2.0, inner_pressure=10.0)
HELD = [PrescribedDisplacement("bottom", y=0.0), PrescribedDisplacement("top", x=0.0)]
ELEMENTS = {"F": Lagrange(2), "V": published_virtual(2)}
KIRSCH_LIMIT, LAME_LIMIT = 5e-3, 1e-3
SOFT_STRESS_LIMIT = 0.02
SOFT_NOTE = "closed form; its mean stress is a small change of volume times a large modulus"


def rows(run: Run) -> Iterator[Row]:
    """Rows of all problems."""
    for order, method in product((1, 2, 3, 4), PATCH_METHODS):
        if order < 4 or method in ("VD", "VV"):  # there is no Lagrange triangle of order 4
            yield from _patch_rows(method, order)
    yield from _cook_rows(run)
    yield from _kirsch_rows()
    for letter, (name, axisymmetric), poisson in product(
        ELEMENTS, (("plane strain", False), ("axisymmetric", True)), (POISSON, NEARLY_INCOMPRESSIBLE)
    ):
        code = f"{letter}O2 {name}, nu = {poisson:g}"
        yield from _lame_rows(code, solve_lame(16, letter, poisson, axisymmetric=axisymmetric), poisson)


def patch_space(method: str, order: int) -> Space:
    """Mesh and elements of the patch test."""
    corners = [(0.0, 0.0), (SIDE, 0.0), (SIDE, SIDE), (0.0, SIDE)]
    triangles = triangulate(polygon(corners, names=("bottom", "right", "top", "left")), size=SIZE)
    return Space(triangles, published_virtual(order)) if method == "VD" else method_space(triangles, method[0], order)


def _patch_rows(method: str, order: int) -> Iterator[Row]:
    """Pull the square to the right, held on the left along x and in one corner along y, in plane strain."""
    supports = [PrescribedDisplacement("left", x=0.0), PrescribedDisplacement((0.0, 0.0), y=0.0)]
    loads = [Traction("right", (TENSION, 0.0))]
    solution = solve_elasticity(Elasticity(patch_space(method, order), PATCH_MATERIAL, loads=loads, supports=supports))
    stresses = corner_stresses(solution.problem, solution.displacements).components[:, [0, 2, 1]] / TENSION
    exact = (1.0, 0.0, 0.0)
    worst = np.abs(stresses - exact).argmax(axis=0)
    published = method in ("FD", "VV") and order <= 2
    note = "" if published else f"{NOT_PUBLISHED.get(method, 'order not published')}; "
    for name, wanted, value in zip(("11", "12", "22"), exact, stresses[worst, [0, 1, 2]].tolist(), strict=True):
        limit = Limit(f"{PATCH_LIMIT:g}", abs(value - wanted) <= PATCH_LIMIT)
        text = f"{note}value with the maximum deviation; difference relative to the tension"
        yield Row("Figure 56", f"{method}PTO{order}", f"stress T{name}", "tension", value, wanted, limit, text)


def _cook_rows(run: Run) -> Iterator[Row]:
    """Within is 0.1 % (order 2 on M4), or nearer than on the mesh before (any other)."""
    published = published_rows("cook_membrane.csv")
    soft = []
    for order, method in product((1, 2), COOK_METHODS):
        if (order, method) == (1, "H"):
            continue
        before, unknowns, energies, works = [math.inf] * len(published), [], [], []
        for level in (1, 2, 3, 4):
            code = CookCode(method, level, order)
            space = code.space()
            solution = solve_cook(space)
            values = (solution.energy, *vertical_displacements(solution))
            for at, (given, value) in enumerate(zip(published, values, strict=True)):
                wanted = float(given["value"])
                error, note = abs(value / wanted - 1.0), NOT_PUBLISHED["HE"] * (method == "H")
                limit = COOK_LIMIT if (level, order) == (4, 2) else COARSEST_LIMIT if level == 1 else math.inf
                words = "error below that of the previous mesh" if limit == math.inf else f"{100.0 * limit:g} %"
                within = Limit(words, error <= limit and error < before[at])
                before[at] = error
                yield Row(COOK, str(code), given["quantity"], given["unit"], value, wanted, within, note)
            unknowns.append(2 * space.n_nodes)
            energies.append(abs(solution.energy / float(published[0]["value"]) - 1.0))
            work = solve_cook(space, NEARLY_INCOMPRESSIBLE).load_work
            works.append(abs(work / NEARLY_INCOMPRESSIBLE_WORK - 1.0))
            limit_soft = INCOMPRESSIBLE_LIMIT if order == 2 else None
            quantity = f"work of the load with nu = {NEARLY_INCOMPRESSIBLE:g}"
            soft.append(Row("Cook", str(code), quantity, "force", work, NEARLY_INCOMPRESSIBLE_WORK, limit_soft))
        for panel, errors in (("energy, nu = 1/3", energies), (f"work, nu = {NEARLY_INCOMPRESSIBLE:g}", works)):
            run.curve("cook", panel, f"{COOK_METHODS[method]}, order {order}", unknowns, errors, "o-")
    yield from soft


def kirsch_plate(n: int, *, geometric: bool = False) -> PolyMesh:
    """A quarter of a square with a hole, in 2 n^2 triangles that grow outwards; the arc is named left.

    - `geometric`: they grow with the radius.
    """
    grid = rectangle_grid(1.0, 1.0, n, n)
    share, angle = grid.points[:, 0], grid.points[:, 1] * np.pi / 2.0
    direction = np.stack((np.cos(angle), np.sin(angle)), axis=1)
    outer = PLATE_SIDE / direction.max(axis=1)
    radius = outer**share if geometric else 1.0 + share**1.5 * (outer - 1.0)
    return replace(grid, points=radius[:, None] * direction)


def plate_traction(points: Floats) -> Floats:
    """Tractions (n, 2) of Kirsch's solution on the outer sides of `kirsch_plate` at points (n, 2)."""
    stress = PLATE.stresses(points)
    on_right = np.isclose(points[:, 0], PLATE_SIDE)
    return np.where(on_right[:, None], stress[:, [0, 2]], stress[:, [2, 1]])


def _kirsch_rows() -> Iterator[Row]:
    """Plane strain with the exact tractions on the outer sides."""
    for letter, n in (("F", 32), ("V", 64)):
        mesh = kirsch_plate(n) if letter == "F" else dual(kirsch_plate(n))
        loads = [Traction("right", plate_traction)]
        problem = Elasticity(Space(mesh, ELEMENTS[letter]), MATERIAL, loads=loads, supports=HELD)
        solution, code = solve_elasticity(problem), f"{letter}O2"
        top, side = problem.node_at((0.0, 1.0)), problem.node_at((1.0, 0.0))
        stresses = recovered_stresses(solution).nodal.components
        for location, exact, stress in (("xx above", 3.0, stresses[top, 0]), ("yy beside", -1.0, stresses[side, 1])):
            quantity = f"stress {location} the hole over the tension"
            ratio = stress / PLATE.tension
            yield Row("Kirsch", code, quantity, "1", ratio, exact, KIRSCH_LIMIT, "closed form")
        exact = PLATE.displacements(np.array([[1.0, 0.0]]), MATERIAL.shear_modulus, 3.0 - 4.0 * POISSON)[0, 0]
        value = solution.displacements[side, 0]
        yield Row(
            "Kirsch", code, "displacement of the hole's side", "length", value, exact, KIRSCH_LIMIT, "closed form"
        )


def ring_sector(n_across: int, n_around: int, turn: float = np.pi / 2.0) -> PolyMesh:
    """Triangles of a sector of the cylinder's section."""
    grid = rectangle_grid(1.0, 1.0, n_across, n_around)
    x, y = grid.points.T
    radius = CYLINDER.inner_radius + (CYLINDER.outer_radius - CYLINDER.inner_radius) * x
    points = np.stack((radius * np.cos(turn * y), radius * np.sin(turn * y)), axis=1)
    return replace(grid, points=points)


def solve_lame(n: int, letter: str, poisson: float, *, axisymmetric: bool) -> ElasticitySolution:
    """A quarter of the cylinder in plane strain, or a slice of the body of revolution, n cells across the wall."""
    if axisymmetric:
        triangles = rectangle_grid(1.0, 0.5, n, n // 2, origin=(1.0, 0.0))
        held = [PrescribedDisplacement("bottom", y=0.0), PrescribedDisplacement("top", y=0.0)]
    else:
        triangles, held = ring_sector(n, 3 * n), HELD
    material = Elastic(YOUNG, poisson, "axisymmetric" if axisymmetric else "plane_strain")
    space = Space(triangles if letter == "F" else dual(triangles), ELEMENTS[letter])
    loads = [Pressure("left", CYLINDER.inner_pressure)]
    return solve_elasticity(Elasticity(space, material, loads=loads, supports=held))


def _lame_rows(code: str, solution: ElasticitySolution, poisson: float) -> Iterator[Row]:
    radii = np.array([CYLINDER.inner_radius, CYLINDER.outer_radius])
    exact = CYLINDER.radial_displacement(radii, YOUNG, poisson).tolist()
    for name, radius, wanted in zip(("inner", "outer"), radii.tolist(), exact, strict=True):
        value, quantity = solution.displacement_at_node((radius, 0.0))[0], f"displacement of the {name} wall"
        yield Row("Lamé", code, quantity, "length", value, wanted, LAME_LIMIT, "closed form")
    hoop = 3 if solution.problem.axisymmetric else 1
    value = recovered_stresses(solution).nodal.components[solution.problem.node_at((1.0, 0.0)), hoop]
    limit, note = (LAME_LIMIT, "closed form") if poisson == POISSON else (SOFT_STRESS_LIMIT, SOFT_NOTE)
    wanted = CYLINDER.hoop_stress(radii[:1])[0]
    yield Row("Lamé", code, "hoop stress at the inner wall", "stress", value, wanted, limit, note)
