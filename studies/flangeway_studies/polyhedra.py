"""Elasticity on polyhedra: patch test, Lamé's ball, Cook's membrane in space, torsion, a hot core."""

import math
from collections.abc import Callable, Iterator
from dataclasses import replace
from itertools import pairwise

import numpy as np

from flangeway.elements import Virtual
from flangeway.materials import Elastic
from flangeway.mesh import PolyhedralMesh, quadtree, rectangle_grid
from flangeway.post import reactions
from flangeway.problems import (
    Elasticity,
    PrescribedDisplacement,
    Pressure,
    TemperatureChange,
    Traction,
    fixed,
)
from flangeway.solve import ElasticitySolution, solve_elasticity
from flangeway.space import Space
from flangeway.types import Floats
from flangeway_studies.study import Limit, Row, Run

GRADIENT = 1e-3 * np.array([[0.1, 0.2, -0.3], [0.05, -0.1, 0.2], [0.3, 0.1, 0.15]])
STEEL = Elastic(210000.0, 0.3, expansion=1.2e-5)
SYMMETRY = [PrescribedDisplacement("x", x=0.0), PrescribedDisplacement("y", y=0.0), PrescribedDisplacement("z", z=0.0)]
PATCH_LIMIT, BALL_LIMIT, COOK_LIMIT, TORSION_LIMIT, HEAT_LIMIT = 1e-12, 0.01, 0.015, 0.025, 0.01
COOK = {0.3: (3.4034, 341.16), 0.4999: (3.4111, 341.73)}
"""Deflection in y at (48, 52, 5) and work of the load by Poisson's ratio: NGSolve, hexahedra of orders 3 to 6."""
TORQUE = 113542.9737  # N mm, of Saint-Venant's series for a square of 10 mm twisted by 1e-3 per mm


def rows(run: Run) -> Iterator[Row]:
    """Rows of all problems."""
    for name, mesh in patch_meshes().items():
        supports = [PrescribedDisplacement("all", _linear(GRADIENT[0]), _linear(GRADIENT[1]), z=_linear(GRADIENT[2]))]
        solution = solve_elasticity(Elasticity(Space(mesh, Virtual(1)), STEEL, supports=supports))
        error = np.abs(solution.displacements - mesh.points @ GRADIENT.T).max() / np.abs(solution.displacements).max()
        yield Row("patch", name, "deviation from the linear field", "1", error, 0.0, PATCH_LIMIT)
    yield from _ball_rows(run)
    yield from _cook_rows(run)
    yield from _torsion_rows(run)
    yield from _heat_rows(run)


def _linear(row: Floats) -> Callable[[Floats], Floats]:
    """The function ``row . x`` of points (n, 3)."""
    return lambda points: points @ row


def patch_meshes() -> dict[str, PolyhedralMesh]:
    """A box in hexahedra, prisms, prisms with hanging nodes, and Voronoi cells."""
    squares, heights = rectangle_grid(1.0, 2.0, 3, 4, cells="quadrilaterals"), [0.0, 0.3, 0.8, 1.5]
    graded = quadtree(1.0, 2.0, 2, 3, finer=lambda centres, _: np.hypot(*centres.T) < 0.8, levels=2)
    seeds = np.random.default_rng(1).uniform(0.0, 1.0, (200, 3)) * (1.0, 2.0, 1.5)
    meshes = {
        "hexahedra": PolyhedralMesh.extruded(squares, heights),
        "prisms": PolyhedralMesh.extruded(rectangle_grid(1.0, 2.0, 3, 4), heights),
        "prisms with hanging nodes": PolyhedralMesh.extruded(graded, heights),
        "Voronoi cells": PolyhedralMesh.voronoi(seeds, (0.0, 0.0, 0.0, 1.0, 2.0, 1.5)),
    }
    return {name: mesh.with_face_set("all", mesh.boundary_faces) for name, mesh in meshes.items()}


def ball_octant(radii: Floats, n: int) -> PolyhedralMesh:
    """Octant of a hollow ball: hexahedra, three times n x n in a layer, whose faces are divided into triangles.

    Face sets: ``x``, ``y``, ``z`` in the planes of symmetry, ``inside``, ``outside``; cell sets by layers, ``0``, ...
    """
    along = np.tan(np.linspace(0.0, np.pi / 4.0, n + 1))
    numbers: dict[tuple[float, ...], int] = {}
    points: list[Floats] = []

    def number(axis: int, i: int, j: int, radius: float) -> int:
        ray = np.roll([1.0, along[i], along[j]], axis)
        place = radius * ray / np.linalg.norm(ray)
        key = tuple(np.round(place, 9).tolist())
        if key not in numbers:
            numbers[key] = len(points)
            points.append(place)
        return numbers[key]

    corners, layers = ((0, 0), (1, 0), (1, 1), (0, 1)), list(pairwise(radii))
    cells = [
        [number(axis, i + a, j + b, radius) for radius in pair for a, b in corners]
        for pair in layers
        for axis in range(3)
        for i in range(n)
        for j in range(n)
    ]
    sets = {str(layer): 3 * n * n * layer + np.arange(3 * n * n) for layer in range(len(layers))}
    mesh = PolyhedralMesh.from_elements(np.array(points), np.array(cells), cell_sets=sets).with_plane_faces()
    for axis, name in enumerate("xyz"):
        mesh = mesh.with_face_set(name, mesh.boundary_faces[mesh.face_centres[mesh.boundary_faces, axis] < 1e-9])
    inside = mesh.with_face_set("inside", lambda p: np.linalg.norm(p, axis=1) < radii[0] * (1.0 + 1e-9))
    return inside.with_face_set("outside", lambda p: np.linalg.norm(p, axis=1) > radii[-1] * (1.0 - 1e-9))


def radial(solution: ElasticitySolution[PolyhedralMesh], radius: float) -> float:
    """Mean radial displacement of the points at a radius."""
    points = solution.problem.space.mesh.points
    radii = np.linalg.norm(points, axis=1)
    at = np.abs(radii - radius) < 1e-9 * radius
    return float(np.mean(np.sum(solution.displacements[at] * points[at], axis=1) / radius))


def _ball_rows(run: Run) -> Iterator[Row]:
    """Radii 1 and 2, pressure 1 inside, E = 1."""
    for poisson, exact in ((0.3, (0.8, 0.3)), (0.4999, (0.8571142857, 0.2143285714))):
        unknowns, errors = [], []
        for n in (2, 4, 8) if run.quick else (2, 4, 8, 16):
            mesh = ball_octant(np.linspace(1.0, 2.0, n + 1), n)
            problem = Elasticity(
                Space(mesh, Virtual(1)), Elastic(1.0, poisson), loads=[Pressure("inside", 1.0)], supports=SYMMETRY
            )
            solution = solve_elasticity(problem)
            values = radial(solution, 1.0), radial(solution, 2.0)
            unknowns.append(3 * problem.space.n_dofs)
            errors.append(max(abs(value / wanted - 1.0) for value, wanted in zip(values, exact, strict=True)))
        for name, value, wanted in zip(("inside", "outside"), values, exact, strict=True):
            yield Row(
                "Lamé's ball", f"nu = {poisson:g}", f"radial displacement, {name}", "1", value, wanted, BALL_LIMIT
            )
        rate = 3.0 * math.log(errors[-2] / errors[-1]) / math.log(unknowns[-1] / unknowns[-2])
        limit = Limit("1.7 to 2.4", 1.7 <= rate <= 2.4)
        yield Row("Lamé's ball", f"nu = {poisson:g}", "order of convergence", "1", rate, 2.0, limit)
        run.curve("rates", "", f"Lamé's ball, nu = {poisson:g}", unknowns, errors, "o-")


def _cook_rows(run: Run) -> Iterator[Row]:
    """The trapezoid (0, 0) (48, 44) (48, 60) (0, 44), 10 thick, clamped at x = 0, E = 70, 100 N in y at x = 48."""
    for poisson, exact in COOK.items():
        unknowns, errors = [], []
        for n in (8, 16) if run.quick else (8, 16, 32):
            plane = rectangle_grid(1.0, 1.0, n, n, cells="quadrilaterals")
            x, y = plane.points.T
            plane = replace(plane, points=np.column_stack((48.0 * x, 44.0 * x + y * (44.0 - 28.0 * x))))
            mesh = PolyhedralMesh.extruded(plane, np.linspace(0.0, 10.0, n // 4 + 1))
            problem = Elasticity(
                Space(mesh, Virtual(1)),
                Elastic(70.0, poisson),
                loads=[Traction("right", (0.0, 100.0 / 160.0, 0.0))],
                supports=[fixed("left", 3)],
            )
            solution = solve_elasticity(problem)
            values = float(solution.displacement_at_node((48.0, 52.0, 5.0))[1]), solution.load_work
            unknowns.append(3 * problem.space.n_dofs)
            errors.append(abs(values[1] / exact[1] - 1.0))
        limit = 2.0 * COOK_LIMIT if run.quick else COOK_LIMIT
        for name, unit, value, wanted in zip(("deflection", "work"), ("mm", "N mm"), values, exact, strict=True):
            yield Row("Cook's membrane", f"nu = {poisson:g}", name, unit, value, wanted, limit)
        run.curve("rates", "", f"Cook's membrane, nu = {poisson:g}", unknowns, errors, "s--")


def _torsion_rows(run: Run) -> Iterator[Row]:
    """A bar 40 x 10 x 10 along z, one end of which turns by 0.04 in its plane; both warp freely."""
    unknowns, errors = [], []
    for n in (2, 4, 8) if run.quick else (2, 4, 8, 12):
        square = rectangle_grid(10.0, 10.0, n, n, cells="quadrilaterals", origin=(-5.0, -5.0))
        mesh = PolyhedralMesh.extruded(square, np.linspace(0.0, 40.0, 4 * n + 1))
        ends = [
            PrescribedDisplacement(name, _linear(np.array([0.0, -turn, 0.0])), _linear(np.array([turn, 0.0, 0.0])))
            for name, turn in (("z-", 0.0), ("z+", 0.04))
        ]
        held = PrescribedDisplacement((0.0, 0.0, 0.0), z=0.0)
        solution = solve_elasticity(Elasticity(Space(mesh, Virtual(1)), STEEL, supports=[*ends, held]))
        torque = float(reactions(solution)[1].moment[2])
        unknowns.append(3 * mesh.n_points)
        errors.append(abs(torque / TORQUE - 1.0))
    limit = 2.0 * TORSION_LIMIT if run.quick else TORSION_LIMIT
    yield Row("torsion", f"square of {n} x {n} cells", "torque", "N mm", torque, TORQUE, limit)
    run.curve("rates", "", "square bar, torsion", unknowns, errors, "^:")


def _heat_rows(run: Run) -> Iterator[Row]:
    """A core of radius 10, hotter by 100 K than the rest of a ball of radius 30."""
    n = 6 if run.quick else 10
    inner = np.linspace(2.0, 10.0, n + 1)
    mesh = ball_octant(np.concatenate((inner, np.linspace(10.0, 30.0, 2 * n + 1)[1:])), n)
    core = [cell for layer in range(n) for cell in mesh.cell_set(str(layer)).tolist()]
    mesh = mesh.with_cell_set("core", core)
    # what is left out inside is under the uniform stress of the core
    stress = -231.1111111
    problem = Elasticity(
        Space(mesh, Virtual(1)),
        STEEL,
        loads=[TemperatureChange(100.0, "core"), Pressure("inside", -stress)],
        supports=SYMMETRY,
    )
    solution = solve_elasticity(problem)
    for radius, wanted in ((10.0, 0.007597883598), (30.0, 0.001333333333)):
        value = radial(solution, radius)
        limit = 3.0 * HEAT_LIMIT if run.quick else HEAT_LIMIT
        yield Row(
            "hot core",
            f"{n} x {n} cells in a patch",
            f"radial displacement, r = {radius:g}",
            "mm",
            value,
            wanted,
            limit,
        )
