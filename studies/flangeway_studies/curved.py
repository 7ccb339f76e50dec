"""Exact solutions on curved edges and on chords: orders of convergence, and pressures of a half disc on a block."""

import math
from collections.abc import Callable, Iterator
from itertools import pairwise, product

import numpy as np

from flangeway.contact import Contact, Multiplier, SegmentToSegment, Surface, press
from flangeway.elements import Element, Lagrange, Virtual, polygon_quadrature
from flangeway.exact import LineContact
from flangeway.geometry import Arc, Contour, Line, Outline, Placement, circle, rectangle
from flangeway.geometry.arrays import norms
from flangeway.materials import Elastic
from flangeway.mesh import PolyMesh, Refinement, curved, dual, triangulate
from flangeway.mesh.curved import Curves as EdgeCurves
from flangeway.post import corner_stresses, pressure_patches
from flangeway.post.recovery import stress_errors
from flangeway.problems import AppliedLoad, Body, Elasticity, Part, Pressure, Torsion, Traction
from flangeway.solve import solve_elasticity, solve_torsion
from flangeway.space import Space
from flangeway.types import Floats
from flangeway_studies.elasticity import CYLINDER, HELD, MATERIAL, PLATE, kirsch_plate, plate_traction, ring_sector
from flangeway_studies.hertz import rms_from_hertz
from flangeway_studies.study import Limit, Row, Run

ELEMENTS: dict[str, Element] = {f"V{k}": Virtual(k) for k in (1, 2, 3, 4)} | {f"F{k}": Lagrange(k) for k in (2, 3)}
LEVELS = (8, 16, 32, 64)  # cells across the wall; the last for order 2, which needs more until chords show
PEAK_LEVEL = 16
BODIES = ("Lamé", "torsion", "Kirsch")
CHORDS = 1.5  # order of the error in energy that chords add
RATE_LIMIT, CHORDS_LIMIT, PEAK_LIMIT = 0.25, 0.35, 5e-3
RADII = 1.0, 2.0
BLIND = "the shear on a chord is odd about its middle: no work on quadratic edges"

STEEL = Elastic(210e3, 0.3)
DISC = Outline.from_segments(
    [Arc((-1.0, 1.0), (1.0, 1.0), (0.0, 1.0), True), Line((1.0, 1.0), (-1.0, 1.0))], ["arc", "cut"]
)
BLOCK = rectangle(2.0, 1.0, (0.0, -0.5))
DEPTH, HALF_WIDTH = 3e-3, 0.04  # approach, and about half of the width of the contact, over the radius
CANDIDATES = 0.08  # distance from the middle up to which edges can touch
INSIDE = 0.9  # part of the half width inside which pressures are compared: Hertz's falls steeply at its ends
COARSER = 1.13  # ratio of the block's edges to those of the disc
TRIANGLES = 16  # of the disc to the half width
PRESSURE_LIMITS = {1: 0.015, 2: 0.005, 3: 0.005}  # of the difference; 0.003 are Hertz's half-spaces


def lame_stresses(points: Floats) -> Floats:
    """Stresses xx, yy, xy of Lamé's tube at points (n, 2), shape (n, 3)."""
    radius = norms(points)
    cosine, sine = points.T / radius
    radial, hoop = CYLINDER.radial_stress(radius), CYLINDER.hoop_stress(radius)
    xx, yy = radial * cosine**2 + hoop * sine**2, radial * sine**2 + hoop * cosine**2
    return np.stack((xx, yy, (radial - hoop) * sine * cosine), axis=1)


def solved(body: str, element: Element, level: int, *, on_curves: bool) -> tuple[float, float]:
    """Relative error in energy, and stress above Kirsch's hole over the tension (nan elsewhere), mean of the cells."""

    def space(triangles: PolyMesh, curves: EdgeCurves) -> Space:
        mesh = curved(triangles, curves) if on_curves else triangles
        return Space(dual(mesh) if isinstance(element, Virtual) else mesh, element)

    circles: list[Contour] = [circle(radius) for radius in RADII]
    if body == "torsion":
        return _twisted(space(_ring(level), circles)), math.nan
    exact: Callable[[Floats], Floats]
    if body == "Lamé":
        triangles, exact = ring_sector(level, level), lame_stresses
        loads: list[AppliedLoad] = [Pressure("left", CYLINDER.inner_pressure)]
    else:
        triangles, exact = kirsch_plate(level, geometric=True), PLATE.stresses
        circles, loads = [circle(PLATE.radius)], [Traction("right", plate_traction)]
    # straight sides are lines, which are nearer to the points on them
    names = ["bottom", "top", *(["right"] if body == "Kirsch" else [])]
    ends = np.concatenate([triangles.points[triangles.edge_set(name)] for name in names]).tolist()
    lines = [Contour((Line(tuple(start), tuple(end)),), ("side",)) for start, end in ends]
    problem = Elasticity(space(triangles, [*circles, *lines]), MATERIAL, loads=loads, supports=HELD)
    solution = solve_elasticity(problem)
    error, size = stress_errors(solution, exact, degree=2 * element.order + 2)
    if body == "Lamé":
        return error / size, math.nan
    mesh, top = problem.space.mesh, problem.node_at((0.0, PLATE.radius))
    stresses = corner_stresses(problem, solution.displacements).components[mesh.cell_points == top]
    return error / size, stresses[:, 0].mean() / PLATE.tension


def _ring(n: int) -> PolyMesh:
    """A whole ring, n cells across and 8 n around."""
    sector = ring_sector(n, 8 * n, 2.0 * math.pi)
    _, first, numbers = np.unique(sector.points.round(9), axis=0, return_index=True, return_inverse=True)
    return PolyMesh(sector.points[first], sector.cell_offsets, numbers.ravel()[sector.cell_points].astype(np.int32))


def _twisted(space: Space) -> float:
    """Error of a ring in torsion by Prandtl's function; its shear stresses are those of the true ring, (-y, x)."""
    problem = Torsion(space, 1.0, "prandtl")
    function = solve_torsion(problem).function
    squares = np.zeros(2)
    for batch in space.batches():
        reconstruction, stress = problem.cell_shear_stresses(batch, function)
        points, weights = polygon_quadrature(batch.outline, 2 * space.order)
        values = np.einsum("sae,aqe->sqe", stress, reconstruction.at(points)[: stress.shape[1]])
        exact = np.stack((-points[:, 1], points[:, 0]))
        squares += [np.sum(field**2 * weights) for field in (values - exact, exact)]
    return math.sqrt(squares[0] / squares[1])


def pressures(order: int, triangles: int, *, on_curves: bool) -> tuple[float, float]:
    """Press a half disc onto a block, segment-to-segment with multipliers weighted by biorthogonal functions.

    On curved edges the gap is that from the circle; for order 1, whose edges are chords, by a point beside each.
    Returns the root mean square difference of the pressure from Hertz's, and that of the nodes from the means of their
    neighbours, over Hertz's maximum.
    """
    size, parts, surfaces = HALF_WIDTH / triangles, [], []
    zone = np.array([[-1.5 * HALF_WIDTH, 0.0], [1.5 * HALF_WIDTH, 0.0]])
    for name, outline, held, side, factor in (
        ("disc", DISC, "cut", "arc", 1.0),
        ("block", BLOCK, "bottom", "top", COARSER),
    ):
        curve = outline if on_curves and name == "disc" else None
        mesh = dual(triangulate(outline, size=0.25, refinements=[Refinement(zone, size * factor, 0.3)], outline=curve))
        parts.append(Part(name, Body(name, mesh, Virtual(order), STEEL, held)))
        edges = mesh.edge_set(side)
        ends = mesh.points[edges]
        near = (np.abs(ends[..., 0]) < CANDIDATES).all(axis=1) & (ends[..., 1] < 0.5).all(axis=1)
        surfaces.append(Surface(parts[-1], edges[near], curve))
    contact = Contact(surfaces[0], surfaces[1], SegmentToSegment(weighting="dual"), Multiplier())
    solution = press([contact], motion={parts[0]: Placement(0.0, (0.0, -DEPTH))})
    theory = LineContact(float(solution.forces[0, 1]), 1.0, STEEL.plane_modulus / 2.0)
    (patch,) = pressure_patches(solution.system, solution.state)
    x, values = patch.points[:, 0], patch.pressures
    within = INSIDE * theory.half_width
    apart = values - np.interp(x, (x[:-2] + x[2:]) / 2.0, (values[:-2] + values[2:]) / 2.0)
    oscillation = np.sqrt(np.mean(apart[np.abs(x) < within] ** 2)) / theory.max_pressure
    return rms_from_hertz(x, values, theory, within), oscillation


def rows(run: Run) -> Iterator[Row]:
    """Orders of all bodies by all elements, stresses at the hole, and pressures."""
    peaks: dict[str, float] = {}
    for body, (name, element) in product(BODIES, ELEMENTS.items()):
        # the function of torsion is quadratic: round-off follows soon
        levels = (4, 8) if body == "torsion" else LEVELS[1:] if element.order == 2 else LEVELS[:-1]
        errors: dict[bool, list[float]] = {}
        for on_curves, label in ((True, "curved edges"), (False, "chords")):
            solutions = [solved(body, element, level, on_curves=on_curves) for level in levels]
            errors[on_curves] = [error for error, _ in solutions]
            if body == "Kirsch" and on_curves and name[0] == "V":
                peaks[name] = solutions[levels.index(PEAK_LEVEL)][1]
            if name[0] == "V":
                style = "o-" if on_curves else "s--"
                run.curve("errors", body, f"order {name[1]}, {label}", levels, errors[on_curves], style)
        rate = math.log2(errors[True][-2] / errors[True][-1])
        limit = Limit(f"{RATE_LIMIT:g} below it", rate >= element.order - RATE_LIMIT)
        yield Row(body, name, "order of the energy error on curved edges", "1", rate, element.order, limit)
        if element.order > 1:
            coarse, fine = (math.sqrt(errors[False][at] ** 2 - errors[True][at] ** 2) for at in (-2, -1))
            blind = name == "F2" and body != "torsion"
            rate, quantity = math.log2(coarse / fine), "order of the energy error that chords add"
            yield Row(body, name, quantity, "1", rate, CHORDS, None if blind else f"{CHORDS_LIMIT:g}", BLIND * blind)
    for name in ("V2", "V3", "V4"):
        yield Row("Kirsch", name, "stress above the hole over the tension", "1", peaks[name], 3.0, PEAK_LIMIT)
    for (before, coarse), (after, fine) in pairwise(peaks.items()):
        run.require(
            abs(fine - 3.0) < abs(coarse - 3.0), f"the stress at the hole is no better by {after} than by {before}"
        )
    for order, pressure_limit in PRESSURE_LIMITS.items():
        arcs, chords = (pressures(order, TRIANGLES, on_curves=on_curves) for on_curves in (True, False))
        quantity = "difference of the pressure on"
        yield Row("Hertz", f"V{order}", f"{quantity} curved edges", "1", arcs[0], 0.0, pressure_limit)
        yield Row("Hertz", f"V{order}", f"{quantity} chords", "1", chords[0], 0.0)
        run.require(
            arcs[1] < 0.5 * chords[1], f"V{order}: pressures oscillate by {arcs[1]:.2g}, {chords[1]:.2g} on chords"
        )
