"""The published Hertz problem (chapter 6.2.2, Tables 9 to 14) computed again, and computed without its oscillations.

As published: node-to-segment, a penalty per node, straight edges, ten load steps. The penalty is taken as Table 10
prints it, and halved with each refinement, so that it falls with the elements' size (by 2 on M1 to 16 on M4): with that
reading the extremes of Tables 12 to 14 come out, and the pressures of Figure 76. Beside it: segment-to-segment with
multipliers weighted by biorthogonal functions, the gap measured between the circles.
"""

import time
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from functools import cache
from typing import Literal

from flangeway.cases.case import Progress
from flangeway.contact import Multiplier, NodeToSegment, Penalty, SegmentToSegment
from flangeway.elements.stabilisation import TraceStabilisation
from flangeway.errors import FlangewayError
from flangeway.exact import LineContact
from flangeway.post import StressLine, stresses_along
from flangeway.problems import ElasticField
from flangeway.solve import Status
from flangeway.types import Floats
from flangeway.validation.hertz.half_disc import Cells, HalfDisc, Method
from flangeway.validation.hertz.hertz_discs import HertzProblem, HertzSolution, SurfacePressure, solve_hertz
from flangeway.validation.published_numbers import Reproduced, ReproducedNumber, compare, published_rows

Variant = Literal["printed", "halved", "segments"]
"""Node-to-segment with the penalty printed, or halved with each refinement; segment-to-segment with multipliers."""

CODES = ("FDO1", "VVO1", "FDO2", "VVO2", "VDO2", "HEO2")
"""Method, cells and order: finite, virtual, hybrid; Delaunay, Voronoi, edge-refined (Table 8)."""
LEVELS = (1, 2, 3, 4)
QUICK_LEVELS = (1, 2, 3)
FINE = 3
"""Level from which the tighter limits hold."""

REFERENCE_FORCE = 251.84
"""Force in kN of the published reference solution, from which its p0 = 671.51 kN/cm^2 and a = 0.239 cm follow."""
EXTREMES = {
    12: ("principal_3", "min minimum principal stress"),
    13: ("in_plane_shear", "max maximum shear stress"),
    14: ("von_mises", "max von Mises stress"),
}
"""Published tables of extreme stresses: name among `HertzSolution.extremes`, and quantity."""

STRESS_LIMIT = 0.03
"""Maximum relative difference from a published extreme."""
STRESS_CODES = ("VVO1", "VVO2")
"""Rows whose extremes have a limit; those of the others depend on the mesh through their oscillations."""
FORCE_LIMITS = {1: 0.01, 2: 0.005}
"""Maximum relative difference of the force by order; of order 2 at M1 and M2 it is that of order 1."""
EXACT_LIMITS = {"force": 0.005, "sigma_3": 0.01, "half width": 0.02, "pressure": 0.015, "oscillation": 0.005}
"""Limits of segment-to-segment contact against Hertz's theory, at order 2 on M3 and M4."""

AS_PRINTED = "(penalty as printed)"
"""Suffix of the quantities of Tables 12 to 14 computed with the penalty as Table 10 prints it."""
VARIANTS: dict[Variant, str] = {
    "printed": "node-to-segment, penalty as printed",
    "halved": "node-to-segment, penalty halved with each refinement",
    "segments": "segment-to-segment with multipliers between the circles",
}
"""Names of the variants."""

SLACK = 0.02
"""Nodes keep the edge that they faced within this fraction of it; otherwise some configurations cycle."""
LINE_POINTS = 201


@dataclass(frozen=True, eq=False)
class HertzRow:
    """One configuration on one mesh.

    Parameters
    ----------
    code, level
        Such as ``"VVO2"`` and 4 for VVO2 on M4.
    variant
        See `Variant`.
    status
        How it ended.
    n_unknowns
        Unknowns of both discs.
    size
        Edge length of the secondary triangles, one edge or one polygon's width.
    iterations
        Newton iterations of each load step.
    force
        Force between the discs.
    extremes
        See `HertzSolution.extremes`.
    half_width
        Half of the loaded length of the secondary disc.
    theory
        Hertz's contact under the same force.
    pressure
        Pressure at the nodes of the zone.
    points, nodal_forces
        Positions of the loaded secondary nodes and the forces on them, shapes (n, 2).
    line
        Stresses of the primary disc down the line of symmetry to a depth of 1 cm.
    fields
        Displacements of both discs.
    timings_s
        See `HertzSolution.timings_s`.

    """

    code: str
    level: int
    variant: Variant
    status: Status
    n_unknowns: int
    size: float
    iterations: tuple[int, ...]
    force: float
    extremes: dict[str, float]
    half_width: float
    theory: LineContact
    pressure: SurfacePressure
    points: Floats
    nodal_forces: Floats
    line: StressLine
    fields: tuple[ElasticField, ElasticField]
    timings_s: dict[str, float]

    @property
    def name(self) -> str:
        """Published code with the mesh, such as ``VVO2M4``."""
        return f"{self.code}M{self.level}"

    @property
    def pressure_difference(self) -> float:
        """Maximum difference of the pressure from Hertz's over p0, without the element at each end of the contact."""
        return self.pressure.maximum_difference(self.theory, self.size)


@dataclass(frozen=True, eq=False, kw_only=True)
class HertzReproduction(Reproduced):
    """The Hertz problem computed again.

    Parameters
    ----------
    rows
        Configurations in the order of the tables; node-to-segment first.

    """

    rows: tuple[HertzRow, ...]

    def of(self, variant: Variant) -> tuple[HertzRow, ...]:
        """Rows of one variant."""
        return tuple(row for row in self.rows if row.variant == variant)

    @property
    def failures(self) -> tuple[str, ...]:
        """Configurations that did not converge."""
        failed = [row for row in self.rows if not row.status.converged]
        return tuple(f"{row.name}, {VARIANTS[row.variant]}: {row.status.message}" for row in failed)


@cache
def _published() -> dict[tuple[str, str], dict[str, str]]:
    rows = published_rows("hertz_tables_9_to_14.csv")
    return {(row["table"] if row["code"] else row["quantity"], row["code"]): row for row in rows}


def published_value(key: str, code: str, level: int) -> float:
    """Published number by table and code, or by the quantity of Tables 9 and 10 without a code."""
    return float(_published()[key, code][f"M{level}"])


def published_problem(code: str, level: int, variant: Variant = "printed") -> HertzProblem:
    """Return a published configuration, or the same discs with segment-to-segment contact between their circles.

    Parameters
    ----------
    code
        One of `CODES`.
    level
        Mesh, 1 to 4.
    variant
        With ``"segments"`` virtual elements have their default stabilisation: the published one, half of the trace, is
        many times too stiff for the shapes of edges that polynomials miss, and multipliers answer to it.

    """
    kind: Cells = {"D": "triangles", "V": "polygons", "E": "edge-refined"}[code[1]]  # type: ignore[assignment]
    method: Method = "vem" if code[0] == "V" else "fem"
    stabilisation = None if variant == "segments" else TraceStabilisation()
    secondary, primary = (
        HalfDisc(
            published_value(f"element size Delaunay {side}", "", level),
            kind,
            method,
            int(code[3]),
            stabilisation=stabilisation,
        )
        for side in ("slave", "master")
    )
    if variant == "segments":
        return HertzProblem(secondary, primary, Multiplier(), SegmentToSegment(weighting="dual"), curved=True)
    mesh = "Voronoi" if kind == "polygons" else "Delaunay"
    value = published_value(f"penalty {mesh}", "", level)
    if variant == "halved":
        value /= 2.0**level
    return HertzProblem(secondary, primary, Penalty(value, per="node"), NodeToSegment(slack=SLACK))


def reproduce_hertz(
    *, quick: bool = False, levels: Sequence[int] = LEVELS, progress: Progress = lambda _: None
) -> HertzReproduction:
    """Compute all configurations again, and those of order 2 with segment-to-segment contact; without M4 if `quick`."""
    start = time.perf_counter()
    chosen = [level for level in levels if not quick or level in QUICK_LEVELS]
    rows: list[HertzRow] = []
    numbers: list[ReproducedNumber] = []
    for variant, name in VARIANTS.items():
        for code in CODES:
            for level in chosen if variant != "segments" or code.endswith("2") else ():
                progress(f"{code}M{level}, {name}")
                row = hertz_row(code, level, variant)
                rows.append(row)
                numbers += _exact_numbers(row) if variant == "segments" else _published_numbers(row)
    return HertzReproduction(rows=tuple(rows), numbers=tuple(numbers), seconds=time.perf_counter() - start)


def hertz_row(code: str, level: int, variant: Variant) -> HertzRow:
    """Compute one configuration; see `published_problem`. Without any contact it is a `FlangewayError`."""
    solution = solve_hertz(published_problem(code, level, variant))
    if solution.patch is None:
        raise FlangewayError(f"{code}M{level}, {VARIANTS[variant]}: {solution.status.message}")
    return HertzRow(
        code,
        level,
        variant,
        solution.status,
        solution.model.n_unknowns,
        solution.model.problem.secondary.size,
        solution.iterations,
        solution.force,
        solution.extremes,
        solution.patch.half_width,
        solution.theory,
        solution.pressure,
        solution.patch.points,
        solution.patch.forces,
        _symmetry_line(solution),
        solution.fields,
        solution.timings_s,
    )


def _symmetry_line(solution: HertzSolution) -> StressLine:
    """Down into the primary disc from below the chord that its mesh has at the apex."""
    disc = solution.model.problem.primary
    below = 1.1 * disc.size**2 / (8.0 * disc.radius)
    return stresses_along(solution.fields[1], (0.0, -below), (0.0, -1.0), LINE_POINTS)


def _published_numbers(row: HertzRow) -> Iterator[ReproducedNumber]:
    """Force and extremes; those of the other reading with a suffix."""
    printed = row.variant == "printed"
    limit = FORCE_LIMITS[int(row.code[3])] if row.level >= FINE else FORCE_LIMITS[1]
    note = f"published for the reference solution; {sum(row.iterations)} Newton iterations"
    if not printed:
        note += ": the lower penalty is more compliant"
    name = "force" if printed else "force (penalty halved with each refinement)"
    words = None if printed else ""
    yield compare("6.2.2", row.name, name, "kN", (REFERENCE_FORCE, row.force), limit, note, words=words)
    for table, (key, quantity) in EXTREMES.items():
        published = published_value(str(table), row.code, row.level)
        reference = published_value(str(table), "ABAQUS", row.level)
        note = _deviation(row, published, reference, row.extremes[key])
        name = f"{quantity} {AS_PRINTED}" if printed else quantity
        values, words = (published, row.extremes[key]), None if not printed and row.code in STRESS_CODES else ""
        yield compare(table, row.name, name, "kN/cm^2", values, STRESS_LIMIT, note, words=words)


def _deviation(row: HertzRow, published: float, reference: float, computed: float) -> str:
    """Pressure oscillation, and the reason for a difference."""
    oscillation = f"pressure oscillates by {100.0 * row.pressure.oscillation:.1f} % rms"
    if abs(computed / published - 1.0) <= STRESS_LIMIT:
        return oscillation
    theirs, ours = (100.0 * (value / reference - 1.0) for value in (published, computed))
    against = f"published is {theirs:+.1f} %, computed {ours:+.1f} % from the published reference {reference:g}"
    if row.variant == "printed":
        reason = "a penalty halved with each refinement gives a smaller difference"
    elif row.code == "FDO1":
        reason = "the extreme is one triangle's constant and changes by several per cent with the mesh"
    else:
        reason = "the extreme is one vertex's value and follows the oscillation of the forces, mesh by mesh"
    return f"{oscillation}; {against}: {reason}"


def _exact_numbers(row: HertzRow) -> Iterator[ReproducedNumber]:
    exact = published_problem(row.code, row.level).theory(REFERENCE_FORCE)
    note = "segment-to-segment, multipliers, gap between the circles"
    fine = row.level >= FINE
    if not fine:
        note += "; limits are for M3 and M4"
    for quantity, unit, published, computed, key in (
        ("force", "kN", REFERENCE_FORCE, row.force, "force"),
        ("min minimum principal stress", "kN/cm^2", -exact.max_pressure, row.extremes["principal_3"], "sigma_3"),
        ("half width", "cm", exact.half_width, row.half_width, "half width"),
        ("maximum difference from Hertz's pressure", "over p0", 0.0, row.pressure_difference, "pressure"),
        ("oscillation of the pressure", "over p0", 0.0, row.pressure.oscillation, "oscillation"),
    ):
        words = None if fine else ""
        yield compare("Hertz", row.name, quantity, unit, (published, computed), EXACT_LIMITS[key], note, words=words)
