"""Exact solutions on curved edges and on chords: what ``flangeway reproduce curved`` computes."""

import itertools
import math
import time
from collections.abc import Callable, Iterator
from dataclasses import asdict, dataclass, replace

import numpy as np

from flangeway.cases.case import Progress
from flangeway.elements import Element, Lagrange, Virtual, polygon_quadrature
from flangeway.geometry import Contour, Line, circle
from flangeway.materials import Elastic
from flangeway.mesh import PolyMesh, curved, dual, rectangle_grid
from flangeway.mesh.curved import Curves
from flangeway.post import corner_stresses
from flangeway.post.adaptive import stress_errors
from flangeway.problems import Elasticity, Load, PrescribedDisplacement, Pressure, Torsion, Traction
from flangeway.solve import ElasticitySolution, solve_elasticity, solve_torsion
from flangeway.space import Space
from flangeway.types import Floats
from studies.curved import curved_hertz
from studies.curved.curved_hertz import PressureRow, pressure_failures, pressure_numbers, pressures
from studies.elasticity.closed_form import (
    CYLINDER,
    PLATE,
    POISSON,
    YOUNG,
    kirsch_plate,
    plate_traction,
)
from studies.published_numbers import Reproduced, ReproducedNumber, Row, compare

ELEMENTS: dict[str, Element] = {f"V{k}": Virtual(k) for k in (1, 2, 3, 4)} | {f"F{k}": Lagrange(k) for k in (2, 3)}
LEVELS = (8, 16, 32, 64)  # cells across the wall; the last for order 2
PEAK_LEVEL = 16
BODIES = ("Lamé", "torsion", "Kirsch")
CHORDS = 1.5  # order of the error in energy that chords add
RATE_LIMIT, CHORDS_LIMIT = 0.25, 0.35
RADII = 1.0, 2.0
HELD = [PrescribedDisplacement("bottom", y=0.0), PrescribedDisplacement("top", x=0.0)]


@dataclass(frozen=True)
class CurvedRow:
    """One solution: a row of ``errors.csv``."""

    body: str  # ``"Lamé"``, ``"Kirsch"`` or ``"torsion"``
    element: str  # V: polygons, F: triangles, with the order
    curved: bool  # whether edges are curved, or chords
    level: int  # cells across the wall
    n_unknowns: int  # of the space, for one field
    energy_error: float  # relative error in the energy norm
    peak: float  # stress above the hole over the tension, exactly 3; nan elsewhere


@dataclass(frozen=True, eq=False, kw_only=True)
class CurvedReproduction(Reproduced):
    """Errors on curved edges and on chords."""

    rows: tuple[CurvedRow, ...]
    pressures: tuple[PressureRow, ...]

    def rate(self, body: str, element: str, *, curved: bool) -> float:
        """Order of the error in energy between the two finest meshes."""
        coarse, fine = self.errors(body, element, curved=curved)[-2:]
        return math.log2(coarse / fine)

    def chord_rate(self, body: str, element: str) -> float:
        """Order of what chords add to the error: the root of the difference of the squares with and without them."""
        both = (self.errors(body, element, curved=curved)[-2:] for curved in (False, True))
        coarse, fine = (math.sqrt(chords**2 - arcs**2) for chords, arcs in zip(*both, strict=True))
        return math.log2(coarse / fine)

    def errors(self, body: str, element: str, *, curved: bool) -> list[float]:
        """Relative errors in energy, coarsest first."""
        wanted = (body, element, curved)
        return [row.energy_error for row in self.rows if (row.body, row.element, row.curved) == wanted]

    @property
    def failures(self) -> tuple[str, ...]:
        """Orders that do not improve the stress at the hole, or whose pressures are no smoother on curved edges."""
        peaks = _peak_errors(self.rows)
        return tuple(pressure_failures(self.pressures)) + tuple(
            f"the error of the stress at the hole is {after:.2g} with order {k + 1} and {before:.2g} with order {k}"
            for k, (before, after) in enumerate(itertools.pairwise(peaks), start=1)
            if not after < before
        )


def _peak_errors(rows: tuple[CurvedRow, ...]) -> list[float]:
    """Errors of the stress at the hole by polygons of orders 1 to 4 on curved edges."""
    return [abs(row.peak - 3.0) for row in rows if row.curved and row.element[0] == "V" and row.peak == row.peak]


def _bent(grid: PolyMesh, turn: float) -> PolyMesh:
    """The unit square bent to a ring's sector between `RADII`."""
    (inner, outer), (x, y) = RADII, grid.points.T
    radius = inner + (outer - inner) * x
    points = np.stack((radius * np.cos(turn * y), radius * np.sin(turn * y)), axis=1)
    return PolyMesh(points, grid.cell_offsets, grid.cell_points, edge_sets=grid.edge_sets)


def _ring(n: int) -> PolyMesh:
    """A whole ring, n cells across and 8 n around."""
    sector = _bent(rectangle_grid(1.0, 1.0, n, 8 * n), 2.0 * math.pi)
    _, first, numbers = np.unique(sector.points.round(9), axis=0, return_index=True, return_inverse=True)
    return PolyMesh(sector.points[first], sector.cell_offsets, numbers.ravel()[sector.cell_points].astype(np.int32))


def lame_stresses(points: Floats) -> Floats:
    """Stresses xx, yy, xy of Lamé's tube at points (n, 2), shape (n, 3)."""
    radius = np.hypot(*points.T)
    cosine, sine = points.T / radius
    radial, hoop = CYLINDER.radial_stress(radius), CYLINDER.hoop_stress(radius)
    xx, yy = radial * cosine**2 + hoop * sine**2, radial * sine**2 + hoop * cosine**2
    return np.stack((xx, yy, (radial - hoop) * sine * cosine), axis=1)


def _mesh(triangles: PolyMesh, curves: Curves | None, element: Element) -> PolyMesh:
    mesh = triangles if curves is None else curved(triangles, curves)
    return dual(mesh) if isinstance(element, Virtual) else mesh


def solved(body: str, element: Element, level: int, *, on_curves: bool) -> tuple[float, float, int]:
    """Relative error in energy, stress above the hole over the tension (nan elsewhere), and number of unknowns."""
    circles: list[Contour] = [circle(radius) for radius in RADII]
    if body == "torsion":
        return _twisted(Space(_mesh(_ring(level), circles if on_curves else None, element), element))
    exact: Callable[[Floats], Floats]
    if body == "Lamé":
        triangles, curves, exact = (
            _bent(rectangle_grid(1.0, 1.0, level, level), math.pi / 2.0),
            circles,
            lame_stresses,
        )
        loads: list[Load] = [Pressure("left", CYLINDER.inner_pressure)]
    else:
        triangles, curves, exact = kirsch_plate(level, geometric=True), [circle(PLATE.radius)], PLATE.stresses
        loads = [Traction("right", plate_traction)]
    mesh = _mesh(triangles, _with_sides(triangles, curves) if on_curves else None, element)
    problem = Elasticity(Space(mesh, element), Elastic(YOUNG, POISSON), loads=loads, supports=HELD)
    solution = solve_elasticity(problem)
    error, size = stress_errors(solution, exact, degree=2 * element.order + 2)
    return error / size, _peak(solution) if body == "Kirsch" else math.nan, problem.space.n_dofs


def _with_sides(mesh: PolyMesh, circles: list[Contour]) -> list[Contour]:
    """The circles, and the straight sides as lines, which are nearer to the points on them."""
    names = ["bottom", "top", *(["right"] if mesh.points.max() > RADII[1] else [])]
    ends = np.concatenate([mesh.points[mesh.edge_set(name)] for name in names]).tolist()
    return [*circles, *(Contour((Line(tuple(start), tuple(end)),), ("side",)) for start, end in ends)]


def _peak(solution: ElasticitySolution) -> float:
    """Mean of the stresses of the cells above the hole, over the tension."""
    mesh = solution.problem.space.mesh
    top = solution.problem.node_at((0.0, PLATE.radius))
    stresses = corner_stresses(solution.problem, solution.displacements).components[mesh.cell_points == top]
    return float(stresses[:, 0].mean()) / PLATE.tension


def _twisted(space: Space) -> tuple[float, float, int]:
    """The ring in torsion by Prandtl's function; its shear stresses are those of the true ring, (-y, x)."""
    problem = Torsion(space, 1.0, "prandtl")
    function = solve_torsion(problem).function
    squares = np.zeros(2)
    for batch in space.batches():
        reconstruction, stress = problem.cell_shear_stresses(batch, function)
        points, weights = polygon_quadrature(batch.outline, 2 * space.order)
        values = np.einsum("sae,aqe->sqe", stress, reconstruction.at(points)[: stress.shape[1]])
        exact = np.stack((-points[:, 1], points[:, 0]))
        squares += [float(np.sum(field**2 * weights)) for field in (values - exact, exact)]
    return math.sqrt(squares[0] / squares[1]), math.nan, space.n_dofs


def levels(body: str, element: Element) -> tuple[int, ...]:
    """Cells across the wall that are computed; order 2 needs more of them until chords show."""
    if body == "torsion":  # its function is quadratic: round-off follows soon
        return (4, 8)
    return LEVELS if element.order == 2 else LEVELS[:-1]


def reproduce_curved(*, quick: bool = False, progress: Progress = lambda _: None) -> CurvedReproduction:  # noqa: ARG001
    """Compute all bodies by all elements, on curved edges and on chords; with or without `quick` the same."""
    start = time.perf_counter()
    rows = []
    for body in BODIES:
        for name, element in ELEMENTS.items():
            progress(f"{body}: {name}")
            for on_curves in (True, False):
                for level in levels(body, element):
                    error, peak, n = solved(body, element, level, on_curves=on_curves)
                    peak = peak if level == PEAK_LEVEL else math.nan
                    rows.append(CurvedRow(body, name, on_curves, level, n, error, peak))
    progress("Hertz")
    contacts = tuple(
        pressures(order, level, on_curves=on_curves)
        for order, on_curves, level in itertools.product(curved_hertz.ORDERS, (True, False), curved_hertz.LEVELS)
    )
    found = CurvedReproduction(numbers=(), rows=tuple(rows), pressures=contacts, seconds=0.0)
    numbers = (*_numbers(found), *pressure_numbers(contacts))
    return replace(found, numbers=numbers, seconds=time.perf_counter() - start)


def _numbers(found: CurvedReproduction) -> Iterator[ReproducedNumber]:
    for body in BODIES:
        for name, element in ELEMENTS.items():
            rate = found.rate(body, name, curved=True)
            yield compare(
                body, name, "order of the energy error on curved edges", "1", (element.order, rate), RATE_LIMIT,
                "exact order", words=f"{RATE_LIMIT:g} below it", within=rate >= element.order - RATE_LIMIT,
            )  # fmt: skip
            if element.order > 1:
                rate = found.chord_rate(body, name)
                blind = name == "F2" and body != "torsion"
                note = "; the shear on a chord is odd about its middle: no work on quadratic edges" if blind else ""
                yield compare(
                    body, name, "order of the energy error that chords add", "1", (CHORDS, rate), CHORDS_LIMIT,
                    f"exact order{note}", words="" if blind else f"{CHORDS_LIMIT:g}",
                    within=abs(rate - CHORDS) <= CHORDS_LIMIT,
                )  # fmt: skip
    for row in found.rows:
        if row.peak == row.peak and row.curved and row.element in ("V2", "V3", "V4"):
            yield compare("Kirsch", row.element, "stress above the hole over the tension", "1", (3.0, row.peak), 5e-3)


def error_rows(found: CurvedReproduction) -> list[Row]:
    """Rows of ``errors.csv``."""
    return [asdict(row) for row in found.rows]


def pressure_rows(found: CurvedReproduction) -> list[Row]:
    """Rows of ``pressures.csv``."""
    return [asdict(row) for row in found.pressures]
