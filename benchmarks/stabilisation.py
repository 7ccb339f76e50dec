"""The candidates for the default stabilisation of displacements: their errors on four kinds of polygons, orders 1 to 4.

For each order and candidate one line. ``cook``: displacement of Cook's membrane at the middle of the loaded side over
its reference, minus one, and ``cook soft`` the work of the load for nu = 0.4999; ``smooth`` and ``smooth soft``: errors
of a trigonometric displacement in L2 and, of the stresses, in the energy norm. Each is a list over `MESHES`: dual
polygons, Voronoi cells, stars with the triangles between their rays, and (orders 1 and 2) 100-gons, 36 cells of Cook's
membrane and 64 of the square for Voronoi cells. ``hertz``: maximum pressure between two discs over Hertz's, minus one,
and oscillation over the maximum pressure (orders 1 and 2). Times mean nothing.
"""

import time
from collections.abc import Iterator
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray
from scipy.spatial import Voronoi

from benchmarks.measurement import NO_PEER, Measurement
from flangeway.contact import press
from flangeway.contact.bodies_model import build_bodies
from flangeway.elements import (
    DiagonalStabilisation,
    IdentityStabilisation,
    SpectralStabilisation,
    Stabilisation,
    TraceStabilisation,
    Virtual,
    polygon_quadrature,
)
from flangeway.geometry import Placement, square
from flangeway.materials import Elastic
from flangeway.mesh import PolyMesh, dual, triangulate
from flangeway.post import displacements_at
from flangeway.problems import Body, BodyForce, Elasticity, PrescribedDisplacement
from flangeway.solve import StepSettings, solve_elasticity
from flangeway.space import Space
from flangeway_studies.cook import (
    MIDDLE,
    NEARLY_INCOMPRESSIBLE,
    NEARLY_INCOMPRESSIBLE_WORK,
    cook_triangles,
    solve_cook,
)
from flangeway_studies.hertz import largest_patch, oscillation, published_case

Floats = NDArray[np.float64]

CANDIDATES: tuple[Stabilisation, ...] = (
    TraceStabilisation(),
    TraceStabilisation(1.0 / 6.0),
    IdentityStabilisation(),
    DiagonalStabilisation(),
    DiagonalStabilisation(0.5),
    SpectralStabilisation(0.5),
    SpectralStabilisation(),
)
MESHES = ("dual", "voronoi", "stars", "100-gons")
ORDERS = (1, 2, 3, 4)
HIGHEST_100 = 2
COOK_MIDDLE = 30.7494
DISC_SIZES = {"size_mm": 0.06, "lower_size_mm": 0.05}


def measurements(*, orders: tuple[int, ...] = ORDERS) -> Iterator[Measurement]:
    """All candidates."""
    cook = {"dual": _with_sides(dual(cook_triangles(1)))} | _squares(6, 3, 6, cook=True)
    smooth = {"dual": dual(triangulate(square(1.0), size=0.15))} | _squares(8, 4, 4, cook=False)
    for order in orders:
        names = MESHES if order <= HIGHEST_100 else MESHES[:-1]
        for candidate in CANDIDATES:
            start = time.perf_counter()
            element = Virtual(order, candidate)
            found: dict[str, object] = {"cook": [_cook(cook[name], element) for name in names]}
            found["cook soft"] = [_cook(cook[name], element, NEARLY_INCOMPRESSIBLE) for name in names]
            found["smooth"] = [_smooth(smooth[name], element, 0.3) for name in names]
            found["smooth soft"] = [_smooth(smooth[name], element, NEARLY_INCOMPRESSIBLE) for name in names]
            if order <= HIGHEST_100:
                found["hertz"] = _hertz(order, candidate)
            seconds = time.perf_counter() - start
            yield Measurement(f"order {order}, {candidate}", NO_PEER, seconds, None, None, None, more=found)


def quick() -> Iterator[Measurement]:
    """Order 1."""
    yield from measurements(orders=(1,))


def _squares(voronoi: int, stars: int, hundred: int, *, cook: bool) -> dict[str, PolyMesh]:
    """Meshes of the unit square with so many cells a side, or of the membrane."""
    cells = {"voronoi": _voronoi(voronoi), "stars": _stars(stars), "100-gons": _many_sided(hundred)}
    meshes = {name: _joined(each) for name, each in cells.items()}
    return {name: _with_sides(_membrane(mesh)) for name, mesh in meshes.items()} if cook else meshes


def _joined(cells: list[Floats]) -> PolyMesh:
    points, number = np.unique(np.round(np.vstack(cells), 9), axis=0, return_inverse=True)
    offsets = np.cumsum([0, *map(len, cells)]).astype(np.int32)
    return PolyMesh(points.astype(np.float64), offsets, number.ravel().astype(np.int32))


def _voronoi(n: int) -> list[Floats]:
    """Voronoi cells of points moved off a grid, mirrored at the sides."""
    places = (np.arange(n) + 0.5) / n
    seeds = np.array(np.meshgrid(places, places)).reshape(2, -1).T
    seeds = np.clip(seeds + np.random.default_rng(0).uniform(-0.35, 0.35, seeds.shape) / n, 0.05 / n, 1.0 - 0.05 / n)
    mirrored = [np.where(np.arange(2) == axis, 2.0 * side - seeds, seeds) for axis in (0, 1) for side in (0.0, 1.0)]
    diagram = Voronoi(np.vstack([seeds, *mirrored]))
    cells = []
    for region in diagram.point_region[: len(seeds)]:
        corners = np.clip(diagram.vertices[diagram.regions[region]], 0.0, 1.0)
        x, y = (corners - corners.mean(axis=0)).T
        cells.append(corners[np.argsort(np.arctan2(y, x))])
    return cells


def _corners(n: int) -> Iterator[Floats]:
    for low in np.ndindex(n, n):
        yield (np.array(low) + np.array([(0, 0), (1, 0), (1, 1), (0, 1)])) / n


def _stars(n: int) -> list[Floats]:
    """Squares, each a star with its tips at the corners and four triangles."""
    cells: list[Floats] = []
    for tips in _corners(n):
        middles = (tips + np.roll(tips, -1, axis=0)) / 2.0
        dents = tips.mean(axis=0) + 0.25 * (middles - tips.mean(axis=0))
        cells.append(np.stack((tips, dents), axis=1).reshape(-1, 2))
        cells += [np.array([tips[i], tips[(i + 1) % 4], dents[i]]) for i in range(4)]
    return cells


def _many_sided(n: int) -> list[Floats]:
    """Squares with 25 edges along each side."""
    along = np.arange(25)[:, None] / 25
    return [
        np.vstack([a + along * (b - a) for a, b in zip(c, np.roll(c, -1, axis=0), strict=True)]) for c in _corners(n)
    ]


def _membrane(mesh: PolyMesh) -> PolyMesh:
    s, t = mesh.points.T
    points = np.stack((48.0 * s, 44.0 * s + t * (44.0 - 28.0 * s)), axis=1)
    return PolyMesh(points, mesh.cell_offsets, mesh.cell_points)


def _with_sides(mesh: PolyMesh) -> PolyMesh:
    edges = mesh.boundary_edges
    for name, x in (("left", 0.0), ("right", 48.0)):
        mesh = mesh.with_edge_set(name, edges[(np.abs(mesh.points[edges][..., 0] - x) < 1e-9).all(axis=1)])
    return mesh


def _cook(mesh: PolyMesh, element: Virtual, poisson: float = 1.0 / 3.0) -> float:
    solution = solve_cook(Space(mesh, element), poisson)
    if poisson == NEARLY_INCOMPRESSIBLE:
        return round(solution.load_work / NEARLY_INCOMPRESSIBLE_WORK - 1.0, 4)
    return round(float(displacements_at(solution, [MIDDLE])[0, 1]) / COOK_MIDDLE - 1.0, 4)


def _displacement(points: Floats) -> Floats:
    """A displacement without change of volume."""
    x, y = np.pi * points.T
    return np.stack((np.sin(x) * np.cos(y), -np.cos(x) * np.sin(y)), axis=1)


def _smooth(mesh: PolyMesh, element: Virtual, poisson: float) -> tuple[float, float]:
    """Relative errors in L2 and in the energy norm."""
    material = Elastic(1.0, poisson)
    shear = material.shear_modulus
    support = PrescribedDisplacement(
        "boundary", lambda points: _displacement(points)[:, 0], lambda points: _displacement(points)[:, 1]
    )
    space = Space(mesh.with_edge_set("boundary", mesh.boundary_edges), element)
    force = BodyForce(lambda points: 2.0 * np.pi**2 * shear * _displacement(points))
    problem = Elasticity(space, material, loads=[force], supports=[support])
    found = solve_elasticity(problem).displacements
    totals = np.zeros(4)
    for batch in space.batches():
        reconstruction, stresses = problem.cell_stresses(batch, found)
        points, weights = polygon_quadrature(batch.outline, 2 * element.order + 2)
        flat = points.swapaxes(1, 2).reshape(-1, 2)
        values = reconstruction.at(points)
        computed = np.einsum("aqe,ame,mei->qei", values, reconstruction.projected_value, found[batch.dofs])
        exact = _displacement(flat).reshape(computed.shape)
        x, y = np.pi * flat.T
        normal = 2.0 * shear * np.pi * np.cos(x) * np.cos(y)
        wanted = np.stack((normal, -normal, 0.0 * normal), axis=1).reshape(*weights.shape, 3)
        apart = np.einsum("sae,aqe->qes", stresses[:3], values[: stresses.shape[1]]) - wanted
        compliance = np.linalg.inv(material.matrix[:3, :3])
        totals[:2] += [np.einsum("qei,qe->", squared, weights) for squared in ((computed - exact) ** 2, exact**2)]
        totals[2:] += [np.einsum("qes,st,qet,qe->", stress, compliance, stress, weights) for stress in (apart, wanted)]
    return float(f"{np.sqrt(totals[0] / totals[1]):.2g}"), float(f"{np.sqrt(totals[2] / totals[3]):.2g}")


def _hertz(order: int, candidate: Stabilisation) -> tuple[float, float]:
    case = published_case("VVO1", 1, "segments").model_copy(update=DISC_SIZES)
    model = build_bodies(case.general())
    contact, sides = model.contacts[0], []
    for side in (contact.secondary, contact.primary):
        assert isinstance(side.part.body, Body)
        body = replace(side.part.body, element=Virtual(order, candidate))
        sides.append(replace(side, part=replace(side.part, body=body)))
    motion = {sides[0].part: Placement(0.0, (0.0, -case.indentation_mm))}
    steps = StepSettings(1.0 / 3.0, 1.0 / 3.0)
    solution = press([replace(contact, secondary=sides[0], primary=sides[1])], motion, steps=steps)
    pressures = largest_patch(solution)[1].pressures
    highest = float(pressures.max()) / case.theory(float(solution.forces[0, 1])).max_pressure - 1.0
    return round(highest, 4), round(oscillation(pressures), 4)
