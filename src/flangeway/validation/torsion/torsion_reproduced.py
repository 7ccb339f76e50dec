"""The published torsion constants (Tables 4 to 7) computed again: what ``flangeway reproduce torsion`` computes."""

import math
import time
from collections.abc import Iterator, Sequence
from dataclasses import asdict, dataclass

import numpy as np

from flangeway.cases.case import Progress
from flangeway.mesh import dual, triangulate
from flangeway.problems import Torsion
from flangeway.solve import solve_torsion
from flangeway.space import Space
from flangeway.validation.published_numbers import Reproduced, ReproducedNumber, Row, compare, published_rows
from flangeway.validation.torsion.torsion_meshes import (
    SQUARE_EDGES,
    TRIANGLE_EDGES,
    TorsionRow,
    convergence_rate,
    published_reading,
    torsion_rows,
    torsion_section,
)

LIMITS = {"h": 0.15, "n_dof": 0.05, "torsion_constant": 1e-3, "relative_error": 0.15}
"""Maximum relative difference from the published number, by quantity."""

LEAST_WITHIN = 90 / 96
"""Fraction of the published errors that must be within their limit."""

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

    Parameters
    ----------
    table
        Number of the published table.
    code
        Code without the refinement, such as ``VVSO2``.
    expected
        Rate of theory, twice the order.
    published, computed
        Rates of the published and computed errors over unknowns.
    published_over_h, computed_over_h
        Rates over h.
    within
        Whether those over unknowns differ by `MAX_RATE_DIFFERENCE` at most.

    """

    table: int
    code: str
    expected: int
    published: float
    computed: float
    published_over_h: float
    computed_over_h: float
    within: bool


@dataclass(frozen=True, eq=False, kw_only=True)
class TorsionReproduction(Reproduced):
    """Tables 4 to 7 computed again.

    Parameters
    ----------
    computed
        Solutions in the order of the tables, both readings of Prandtl's load.
    published
        Published h, number of unknowns, constant and error of each.
    rates
        Rates of convergence; none if not all refinements were computed.

    """

    computed: tuple[TorsionRow, ...]
    published: tuple[dict[str, float], ...]
    rates: tuple[ReproducedRate, ...]

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
