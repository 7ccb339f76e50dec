"""The published torsion constants (Tables 4 to 7) computed again: what ``flangeway reproduce torsion`` computes."""

import math
import time
from collections.abc import Iterator, Sequence
from dataclasses import asdict, dataclass
from functools import cache
from typing import Literal

import numpy as np

from flangeway.cases.case import Progress
from flangeway.elements import Lagrange, Virtual
from flangeway.errors import InputError
from flangeway.exact import EquilateralTriangle, Rectangle, TorsionSection
from flangeway.geometry import Outline, polygon, square
from flangeway.mesh import PolyMesh, dual, triangulate
from flangeway.problems import Torsion
from flangeway.problems.torsion_problem import Formulation, Load
from flangeway.solve import TorsionSolution, solve_torsion
from flangeway.space import Space
from studies.published_numbers import Reproduced, ReproducedNumber, Row, compare, published_rows

Method = Literal["F", "V"]
Cells = Literal["D", "V"]
Section = Literal["S", "T"]

SQUARE_EDGES = (10.0, 13.9, 20.0, 39.73)
TRIANGLE_EDGES = (16.0, 21.0, 31.0, 60.9)
"""Edges on a side for M1 to M4: Gmsh then makes the published numbers of points, or nearly."""


@dataclass(frozen=True)
class TorsionCode:
    """One code of Table 3, such as ``VVSM3O2``."""

    method: Method  # ``"F"`` for Lagrange, ``"V"`` for virtual elements
    cells: Cells  # ``"D"`` for triangles, ``"V"`` for their dual polygons
    section: Section  # ``"S"`` for the square, ``"T"`` for the equilateral triangle, of area one
    level: int  # refinement, 1 to 4
    order: int  # order of the elements, 1 or 2

    def __str__(self) -> str:
        return f"{self.method}{self.cells}{self.section}M{self.level}O{self.order}"

    @classmethod
    def parse(cls, code: str) -> "TorsionCode":
        """Read a code of Table 3."""
        for known in torsion_codes():
            if str(known) == code:
                return known
        raise InputError(f"torsion code {code!r}", "a code of Table 3 such as FDSM1O1 or VVTM4O2", "correct it")


@dataclass(frozen=True, eq=False)
class TorsionRow:
    """One computed row of Tables 4 to 7."""

    table: int  # number of the published table, 4 to 7
    formulation: Formulation  # ``"warping"`` or ``"prandtl"``
    load: Load  # reading of Prandtl's load, see `Torsion`
    code: TorsionCode  # mesh and element
    size: float  # maximum diameter of the cells
    n_dofs: int  # unknowns of the space, all counted
    n_free: int  # unknowns that are solved for
    exact: float  # torsion constant in closed form
    solution: TorsionSolution  # the solution

    @property
    def torsion_constant(self) -> float:
        """Computed torsion constant."""
        return self.solution.torsion_constant

    @property
    def relative_error(self) -> float:
        """Relative error with its sign: positive if the computed constant is too large."""
        return self.torsion_constant / self.exact - 1.0


def torsion_codes() -> tuple[TorsionCode, ...]:
    """The 48 codes of Table 3, in its order."""
    pairs: tuple[tuple[Method, Cells], ...] = (("F", "D"), ("V", "D"), ("V", "V"))
    sections: tuple[Section, ...] = ("S", "T")
    return tuple(
        TorsionCode(method, cells, section, level, order)
        for section in sections
        for method, cells in pairs
        for order in (1, 2)
        for level in (1, 2, 3, 4)
    )


def torsion_section(section: Section) -> tuple[Outline, TorsionSection]:
    """Outline of a section of area one, and its exact solution in the same coordinates."""
    if section == "S":
        return square(1.0), Rectangle(1.0, 1.0)
    exact = EquilateralTriangle(2.0 / 3.0**0.25)
    return polygon(exact.corners), exact


@cache
def torsion_mesh(section: Section, cells: Cells, level: int) -> PolyMesh:
    """Mesh of Table 3: a triangulation by Gmsh (Delaunay), or its dual polygons."""
    if cells == "V":
        return dual(torsion_mesh(section, "D", level))
    outline, _ = torsion_section(section)
    side = outline.segments[0].length
    n_edges = (SQUARE_EDGES if section == "S" else TRIANGLE_EDGES)[level - 1]
    return triangulate(outline, size=side / n_edges)


def torsion_row(code: TorsionCode, formulation: Formulation, load: Load = "projected") -> TorsionRow:
    """Compute one row; the published VVO1 rows of Tables 6 and 7 come out with the load ``"vertex_mean"``."""
    mesh = torsion_mesh(code.section, code.cells, code.level)
    space = Space(mesh, Virtual(code.order) if code.method == "V" else Lagrange(code.order))
    problem = Torsion(space, formulation=formulation, load=load)
    held = np.unique(space.edge_nodes(problem.boundary.outer)).size if formulation == "prandtl" else 1
    return TorsionRow(
        table=4 + (code.section == "T") + 2 * (formulation == "prandtl"),
        formulation=formulation,
        load=load,
        code=code,
        size=float(mesh.cell_diameters.max()),
        n_dofs=space.n_dofs,
        n_free=space.n_dofs - held,
        exact=torsion_section(code.section)[1].torsion_constant,
        solution=solve_torsion(problem),
    )


def torsion_rows(*, levels: tuple[int, ...] = (1, 2, 3, 4)) -> Iterator[TorsionRow]:
    """Rows of Tables 4 to 7 in their order: 96 in the published reading, and 8 more in the other one.

    The other reading, the projected load of Prandtl's function on dual polygons of order 1, follows its row.
    """
    formulations: tuple[Formulation, ...] = ("warping", "prandtl")
    for formulation in formulations:
        for code in torsion_codes():
            if code.level not in levels:
                continue
            both = formulation == "prandtl" and code.cells == "V" and code.order == 1
            if both:
                yield torsion_row(code, formulation, "vertex_mean")
            yield torsion_row(code, formulation, "projected")


def published_reading(row: TorsionRow) -> bool:
    """Whether a row is in the reading that the published tables need."""
    both = row.formulation == "prandtl" and row.code.cells == "V" and row.code.order == 1
    return (row.load == "vertex_mean") == both


def convergence_rate(sizes: np.ndarray, errors: np.ndarray) -> float:
    """Exponent p of the least-squares fit ``error = c size^p`` in logarithms."""
    return float(np.polyfit(np.log(sizes), np.log(np.abs(errors)), 1)[0])


LIMITS = {"h": 0.15, "n_dof": 0.05, "torsion_constant": 1e-3, "relative_error": 0.15}
"""Maximum relative difference from the published number, by quantity."""

LEAST_WITHIN = 90 / 96  # fraction of the published errors that must be within their limit

MAX_RATE_DIFFERENCE = 0.15
"""Maximum difference of a rate of convergence over unknowns from that of the published errors."""

_NEIGHBOURS = np.linspace(0.96, 1.04, 9)
_OTHER_READING = "load and constant by the projection (3.81), more accurate than the published vertex averages"
_PUBLISHED_READING = "load and constant by vertex averages, as in the published column"
_UNITS = {"h": "side of area 1", "n_dof": "1", "torsion_constant": "area squared", "relative_error": "1"}


@dataclass(frozen=True)
class ReproducedRate:
    """Rates of convergence, fitted to the errors of four refinements: a row of ``rates.csv``.

    Over unknowns, ``error = c n^(-p/2)``, and over h, ``error = c h^p``. That over unknowns is compared: h is the
    maximum diameter of an element, which depends on details of the mesh generator.
    """

    table: int  # number of the published table
    code: str  # code without the refinement, such as ``VVSO2``
    expected: int  # rate of theory, twice the order
    published: float
    computed: float  # published, computed: rates of the published and computed errors over unknowns
    published_over_h: float
    computed_over_h: float  # published_over_h, computed_over_h: rates over h
    within: bool  # whether those over unknowns differ by `MAX_RATE_DIFFERENCE` at most


@dataclass(frozen=True, eq=False, kw_only=True)
class TorsionReproduction(Reproduced):
    """Tables 4 to 7 computed again."""

    computed: tuple[TorsionRow, ...]  # solutions in the order of the tables, both readings of Prandtl's load
    published: tuple[dict[str, float], ...]  # published h, number of unknowns, constant and error of each
    rates: tuple[ReproducedRate, ...]  # rates of convergence; none if not all refinements were computed

    @property
    def errors(self) -> tuple[ReproducedNumber, ...]:
        """The published errors in the published reading, one for each row of the tables."""
        return tuple(number for number in self.numbers if number.quantity == "relative_error")

    @property
    def n_within(self) -> int:
        """How many of `errors` are within their limit."""
        return sum(number.within for number in self.errors)

    @property
    def passed(self) -> bool:
        """Whether enough errors and all rates are within their limits."""
        enough = self.n_within >= math.ceil(LEAST_WITHIN * len(self.errors))
        return enough and all(rate.within for rate in self.rates)


def reproduce_torsion(*, quick: bool = False, progress: Progress = lambda _: None) -> TorsionReproduction:
    """Compute Tables 4 to 7 again; if `quick`, the two coarser of the four refinements, without rates."""
    start = time.perf_counter()
    published = _published()
    computed: list[TorsionRow] = []
    numbers: list[ReproducedNumber] = []
    for row in torsion_rows(levels=(1, 2) if quick else (1, 2, 3, 4)):
        progress(f"table {row.table}: {row.code}")
        computed.append(row)
        numbers += _numbers(row, published[row.table, str(row.code)])
    found = tuple(published[row.table, str(row.code)] for row in computed)
    rates = () if quick else tuple(_rates(computed, found))
    return TorsionReproduction(
        computed=tuple(computed),
        published=found,
        rates=rates,
        numbers=tuple(numbers),
        seconds=time.perf_counter() - start,
    )


def rate_rows(found: TorsionReproduction) -> list[Row]:
    """Rows of ``rates.csv``."""
    return [asdict(rate) for rate in found.rates]


def _published() -> dict[tuple[int, str], dict[str, float]]:
    rows = published_rows("torsion_tables_4_to_7.csv")
    return {(int(row["table"]), row["code"]): {key: float(row[key]) for key in LIMITS} for row in rows}


def _numbers(row: TorsionRow, published: dict[str, float]) -> Iterator[ReproducedNumber]:
    main = published_reading(row)
    for quantity, value in _values(row).items():
        if not main and quantity in ("h", "n_dof"):
            continue
        within = abs(value / published[quantity] - 1.0) <= LIMITS[quantity]
        note = _PUBLISHED_READING if row.load == "vertex_mean" else "" if main else _OTHER_READING
        if main and quantity == "relative_error" and not within:
            note = _reason(row, published[quantity])
        name = quantity if main else f"{quantity} (projected load)"
        values, words = (published[quantity], value), None if main else ""
        yield compare(row.table, str(row.code), name, _UNITS[quantity], values, LIMITS[quantity], note, words=words)


def _values(row: TorsionRow) -> dict[str, float]:
    """Return the computed numbers of a row; Prandtl's unknowns are counted without those held, as published."""
    return {
        "h": row.size,
        "n_dof": float(row.n_dofs if row.formulation == "warping" else row.n_free),
        "torsion_constant": float(row.torsion_constant),
        "relative_error": float(abs(row.relative_error)),
    }


def _reason(row: TorsionRow, published: float) -> str:
    """Say how far the error of a row depends on the mesh, found on meshes of nearly the same size."""
    outline, exact = torsion_section(row.code.section)
    side = outline.segments[0].length
    n_edges = (SQUARE_EDGES if row.code.section == "S" else TRIANGLE_EDGES)[row.code.level - 1]
    element = next(iter(row.solution.problem.space.batches())).element
    errors = []
    for factor in _NEIGHBOURS.tolist():
        triangles = triangulate(outline, size=side / (n_edges * factor))
        space = Space(triangles if row.code.cells == "D" else dual(triangles), element)
        solution = solve_torsion(Torsion(space, formulation=row.formulation, load=row.load))
        errors.append(float(abs(solution.torsion_constant / exact.torsion_constant - 1.0)))
    low, high = min(errors), max(errors)
    between = "between them" if low <= published <= high else "not between them"
    return (
        f"the published mesh is not known and the error depends on it: on {len(errors)} meshes of sizes within 4 % "
        f"it is {low:.3g} to {high:.3g}, and the published {published:.3g} lies {between}"
    )


def _rates(computed: Sequence[TorsionRow], published: Sequence[dict[str, float]]) -> Iterator[ReproducedRate]:
    groups: dict[tuple[int, str], list[int]] = {}
    for number, row in enumerate(computed):
        if published_reading(row):
            name = f"{row.code.method}{row.code.cells}{row.code.section}O{row.code.order}"
            groups.setdefault((row.table, name), []).append(number)
    for (table, name), members in groups.items():
        theirs = [published[i] for i in members]
        ours = [_values(computed[i]) for i in members]
        unknowns = [_rate([x["n_dof"] ** -0.5 for x in each], each) for each in (theirs, ours)]
        over_h = [_rate([x["h"] for x in each], each) for each in (theirs, ours)]
        expected = 2 * computed[members[0]].code.order
        within = abs(unknowns[1] - unknowns[0]) <= MAX_RATE_DIFFERENCE
        yield ReproducedRate(table, name, expected, unknowns[0], unknowns[1], over_h[0], over_h[1], within)


def _rate(sizes: Sequence[float], values: Sequence[dict[str, float]]) -> float:
    return convergence_rate(np.array(sizes), np.array([each["relative_error"] for each in values]))
