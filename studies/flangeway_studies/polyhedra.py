"""Bodies of polyhedra: patch test, Lamé's ball, Cook's membrane in space, torsion, a hot core, contact."""

import math
from collections.abc import Callable, Iterator, Mapping
from dataclasses import replace
from itertools import pairwise

import numpy as np

from flangeway.contact import FaceSurface, RigidSphere, SpatialContact, SpatialSolution, press_spatial
from flangeway.elements import Virtual
from flangeway.materials import Elastic, J2Plasticity
from flangeway.mesh import PolyhedralMesh, matched, octree, quadtree, rectangle_grid
from flangeway.post import reactions
from flangeway.problems import (
    ElasticField,
    Elasticity,
    PrescribedDisplacement,
    Pressure,
    TemperatureChange,
    Traction,
    fixed,
)
from flangeway.solve import solve_elasticity, solve_nonlinear
from flangeway.space import Space
from flangeway.types import Bools, Floats
from flangeway_studies.study import Limit, Row, Run

GRADIENT = 1e-3 * np.array([[0.1, 0.2, -0.3], [0.05, -0.1, 0.2], [0.3, 0.1, 0.15]])
STEEL = Elastic(210000.0, 0.3, expansion=1.2e-5)
PLANE_MODULUS = STEEL.young / (1.0 - STEEL.poisson**2)
SHRUNK = -100.0 * (1.0 - 2.0 * STEEL.poisson) / STEEL.young
"""Strain under 100 MPa from all sides."""
HELD = {(0.0, 0.0, 0.0): "xyz", (20.0, 0.0, 0.0): "yz", (0.0, 20.0, 0.0): "z"}
GUIDED = {(0.0, 0.0, 40.0): "xy", (20.0, 0.0, 40.0): "y"}
"""Components of displacements that are prescribed at corners of the lower and of the upper block."""
SYMMETRY = [PrescribedDisplacement("x", x=0.0), PrescribedDisplacement("y", y=0.0), PrescribedDisplacement("z", z=0.0)]
PRESSURE_LIMIT, RADIUS_LIMIT, PLASTIC_LIMIT = 0.005, 0.01, 0.005
PATCH_LIMIT, BALL_LIMIT, COOK_LIMIT, TORSION_LIMIT, HEAT_LIMIT = 1e-12, 0.01, 0.015, 0.025, 0.01
COOK = {0.3: (3.4034, 341.16), 0.4999: (3.4111, 341.73)}
"""Deflection in y at (48, 52, 5) and work of the load by Poisson's ratio: NGSolve, hexahedra of orders 3 to 6."""
HILL = {180.0: (0.07289244741, 0.02679454042), 220.0: (0.1043878564, 0.03657315457)}
"""Displacements in mm of the surfaces of the plastic ball by the pressure inside: Hill (1950), in closed form."""
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
    yield from _contact_rows(run)
    yield from _plastic_rows(run)


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


def radial(solution: ElasticField[PolyhedralMesh], radius: float) -> float:
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


def sphere_on_block(radius: float, n: int) -> SpatialSolution:
    """Press a rigid sphere of 50 mm on a quarter of a block by Hertz's force for a radius of contact.

    The block is 20 mm wide and high and clamped below, with n cells along the radius about the middle of its top.
    """
    size, sphere = 20.0, 50.0
    levels = math.ceil(math.log2(size * n / radius))

    def finer(centres: Floats, sides: Floats) -> Bools:
        away = np.linalg.norm(centres - (0.0, 0.0, size), axis=1)
        return sides > 1.001 * np.maximum(size / 2**levels, 0.5 * (away - 1.25 * radius))

    mesh = octree((size, size, size), (1, 1, 1), finer=finer, levels=levels)
    mesh = mesh.with_face_set("patch", lambda p: (p[:, 2] == size) & (np.hypot(p[:, 0], p[:, 1]) < 2.0 * radius))
    supports = [PrescribedDisplacement("x-", x=0.0), PrescribedDisplacement("y-", y=0.0), fixed("z-", 3)]
    block = Elasticity(Space(mesh, Virtual(1)), STEEL, supports=supports, name="block")
    ball, force = RigidSphere((0.0, 0.0, size + sphere), sphere), 4.0 / 3.0 * PLANE_MODULUS * radius**3 / sphere
    return press_spatial([SpatialContact(FaceSurface(block, "patch"), ball)], {ball: (0.0, 0.0, -force / 4.0)})


def tilted_blocks() -> tuple[PolyhedralMesh, PolyhedralMesh]:
    """Two blocks whose meshes do not match, together 20 x 20 x 40.

    They are split by the plane through (10, 10, 20) that is tilted by 20 degrees about y: hexahedra with 5 x 5, and
    prisms over 7 x 7 squares. The interface is ``z+`` of the first and ``z-`` of the second.
    """
    squares = rectangle_grid(20.0, 20.0, 5, 5, cells="quadrilaterals"), rectangle_grid(20.0, 20.0, 7, 7)
    meshes = [PolyhedralMesh.extruded(plane, np.linspace(0.0, 1.0, 6)) for plane in squares]
    for number, mesh in enumerate(meshes):
        x, y, t = mesh.points.T
        middle = 20.0 + np.tan(np.deg2rad(20.0)) * (x - 10.0)
        z = middle + t * (40.0 - middle) if number else t * middle
        meshes[number] = replace(mesh, points=np.column_stack((x, y, z)))
    return meshes[0], meshes[1]


def _held(
    corners: Mapping[tuple[float, float, float], str], stretch: float, turn: Floats
) -> list[PrescribedDisplacement]:
    """Supports of turned blocks at corners, by their components, that agree with displacements ``stretch x``."""
    points = {corner: turn @ corner for corner in corners}
    return [
        PrescribedDisplacement(
            (points[corner] + 0.0).tolist(),
            **{axis: float(value) for axis, value in zip("xyz", stretch * points[corner], strict=True) if axis in axes},
        )
        for corner, axes in corners.items()
    ]


def pressed_blocks(turn: Floats, *, cut: bool) -> SpatialSolution:
    """Two tilted blocks that touch without friction, turned by a matrix, with 100 MPa on all their other faces."""
    blocks = tilted_blocks()
    if cut:
        blocks = matched(blocks[0], "z+", blocks[1], "z-")
    lower, upper = (
        Elasticity(
            Space(replace(mesh, points=mesh.points @ turn.T), Virtual(1)),
            STEEL,
            loads=[Pressure(name, 100.0) for name in ("left", "right", "bottom", "top", end)],
            supports=_held(corners, SHRUNK, turn),
        )
        for mesh, end, corners in zip(blocks, ("z-", "z+"), (HELD, GUIDED), strict=True)
    )
    return press_spatial([SpatialContact(FaceSurface(upper, "z-"), FaceSurface(lower, "z+"))])


def _contact_rows(run: Run) -> Iterator[Row]:
    """Hertz's sphere at three loads, and two blocks whose meshes do not match."""
    for radius in (0.5, 1.0, 2.0):
        solution = sphere_on_block(radius, 8 if run.quick else 12)
        (contact,) = solution.contacts
        pressure, code = contact.pressures.max(), f"radius of contact {radius:g} mm"
        hertz, (computed, _) = 2.0 * PLANE_MODULUS * radius / math.pi / 50.0, contact.semi_axes((0.0, 0.0, 20.0))
        yield Row("rigid sphere", code, "maximum pressure", "MPa", pressure, hertz, PRESSURE_LIMIT)
        yield Row("rigid sphere", code, "radius", "mm", computed, radius, RADIUS_LIMIT)
    for name, bound in (("common faces", 1e-10), ("nodes on faces", None)):
        (contact,) = pressed_blocks(np.eye(3), cut=bound is not None).contacts
        error = np.abs(contact.pressures / 100.0 - 1.0).max()
        yield Row("tilted blocks", f"contact, {name}", "deviation of the pressure", "1", error, 0.0, bound)


def plastic_ball(pressure: float, n: int, layers: int) -> tuple[float, float]:
    """Radial displacements inside and outside of a hollow ball, radii 100 and 200, that yields at 240 MPa."""
    mesh = ball_octant(np.geomspace(100.0, 200.0, layers + 1), n)
    problem = Elasticity(Space(mesh, Virtual(1)), STEEL, loads=[Pressure("inside", pressure)], supports=SYMMETRY)
    (solution,) = solve_nonlinear(problem, J2Plasticity(STEEL, 240.0))
    return radial(solution, 100.0), radial(solution, 200.0)


def _plastic_rows(run: Run) -> Iterator[Row]:
    """Hill's ball at two pressures."""
    for pressure, exact in HILL.items():
        values = plastic_ball(pressure, *((6, 16) if run.quick else (8, 32)))
        limit = 4.0 * PLASTIC_LIMIT if run.quick else PLASTIC_LIMIT
        for name, value, wanted in zip(("inside", "outside"), values, exact, strict=True):
            yield Row("Hill's ball", f"{pressure:g} MPa", f"displacement, {name}", "mm", value, wanted, limit)
