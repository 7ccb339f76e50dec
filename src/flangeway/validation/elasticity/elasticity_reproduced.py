"""Plane elasticity (Moherdaui 2021, chapter 5) computed again: what ``flangeway reproduce elasticity`` computes."""

import math
import time
from collections.abc import Iterator, Sequence
from dataclasses import dataclass

from flangeway.cases.bodies.cook import (
    NEARLY_INCOMPRESSIBLE,
    NEARLY_INCOMPRESSIBLE_WORK,
    CookCode,
    CookRow,
    cook_adaptive,
    cook_grid,
    cook_reference,
    cook_row,
    cook_uniform,
)
from flangeway.cases.case import Progress
from flangeway.elements import Virtual
from flangeway.post.refinement import RefinementRow
from flangeway.validation.elasticity.closed_form import ClosedFormValue, closed_form_values
from flangeway.validation.elasticity.l_shape import adaptive_rows, l_shape, uniform_rows
from flangeway.validation.elasticity.patch_test import PatchRow, patch_codes, patch_row
from flangeway.validation.published_numbers import ReproducedNumber, percent, published_rows

COOK = "Section 5.3.2"
METHODS = ("F", "V", "H")

PATCH_LIMIT = 1e-9
COOK_LIMIT = 1e-3
COOK_COARSEST_LIMIT = 0.1
INCOMPRESSIBLE_LIMIT = 0.01
CLOSED_FORM_LIMITS = {"Kirsch": 5e-3, "Lamé": 1e-3}
SOFT_STRESS_LIMIT = 0.02
"""Stresses of nearly incompressible material: its mean stress is a small change of volume times a large modulus."""

FEWER_UNKNOWNS = 10.0
"""How many times fewer unknowns adaptive refinement of the L-shaped body needs, at least, for uniform's least error."""

_NOT_PUBLISHED = {
    "VD": "virtual triangles: not published for this problem",
    "HE": "triangles inside, virtual elements at the boundary (Figure 68): not published for this problem",
}


@dataclass(frozen=True)
class RefinementCase:
    """Uniform and adaptive refinement of one body with one order.

    Parameters
    ----------
    body
        ``"Cook"`` or ``"L-shape"``.
    order
        Order of the virtual elements.
    uniform, adaptive
        The solutions, coarsest first.

    """

    body: str
    order: int
    uniform: tuple[RefinementRow, ...]
    adaptive: tuple[RefinementRow, ...]

    @property
    def saving(self) -> float:
        """Unknowns of the finest uniform mesh over those of the first adaptive one with no larger error, or nan."""
        finest = self.uniform[-1]
        reached = (row.n_unknowns for row in self.adaptive if row.error <= finest.error)
        return finest.n_unknowns / next(reached, math.nan)


@dataclass(frozen=True)
class IncompressibleRow:
    """The nearly incompressible membrane: a row of ``nearly_incompressible.csv``.

    Parameters
    ----------
    code
        Configuration.
    n_unknowns
        Components of displacement at nodes.
    load_work
        Work of the load, twice the strain energy.
    reference
        The same by orders 3 and 4 on fine meshes.
    relative_difference
        ``load_work / reference - 1``.

    """

    code: str
    n_unknowns: int
    load_work: float
    reference: float
    relative_difference: float


@dataclass(frozen=True, eq=False)
class ElasticityReproduction:
    """Chapter 5 computed again, with what belongs beside it.

    Parameters
    ----------
    patch
        Patch tests.
    cook
        Cook's membrane with the published material.
    incompressible
        The same, nearly incompressible.
    refinements
        Uniform against adaptive refinement.
    numbers
        Published and computed numbers side by side.
    seconds
        Wall-clock time.

    """

    patch: tuple[PatchRow, ...]
    cook: tuple[CookRow, ...]
    incompressible: tuple[CookRow, ...]
    refinements: tuple[RefinementCase, ...]
    numbers: tuple[ReproducedNumber, ...]
    seconds: float

    @property
    def incompressible_rows(self) -> tuple[IncompressibleRow, ...]:
        """The nearly incompressible membrane's work."""
        reference = NEARLY_INCOMPRESSIBLE_WORK
        return tuple(
            IncompressibleRow(
                str(row.code),
                row.n_unknowns,
                row.solution.load_work,
                reference,
                row.solution.load_work / reference - 1.0,
            )
            for row in self.incompressible
        )

    @property
    def locking_free(self) -> bool:
        """Whether order 2 is near enough to the nearly incompressible reference on every mesh."""
        pairs = zip(self.incompressible, self.incompressible_rows, strict=True)
        return all(
            abs(row.relative_difference) <= INCOMPRESSIBLE_LIMIT for given, row in pairs if given.code.order == 2
        )

    @property
    def passed(self) -> bool:
        """Whether all numbers are within their limits, order 2 does not lock, and refinement pays as it must."""
        paid = all(case.saving >= FEWER_UNKNOWNS for case in self.refinements if case.body == "L-shape")
        return all(number.within for number in self.numbers) and self.locking_free and paid


def reproduce_elasticity(*, quick: bool = False, progress: Progress = lambda _: None) -> ElasticityReproduction:
    """Compute the patch test and Cook's membrane again.

    Parameters
    ----------
    quick
        Compute the two coarser of the four meshes of the membrane, orders 1 and 2 of the patch test, and refine the
        other bodies less far.
    progress
        Called with a sentence at each stage.

    """
    start = time.perf_counter()
    patch = []
    for code in patch_codes((1, 2) if quick else (1, 2, 3, 4)):
        progress(f"patch test: {code}")
        patch.append(patch_row(code))
    cook, incompressible = [], []
    for cook_code in _cook_codes((1, 2) if quick else (1, 2, 3, 4)):
        progress(f"Cook's membrane: {cook_code}")
        cook.append(cook_row(cook_code))
        incompressible.append(cook_row(cook_code, NEARLY_INCOMPRESSIBLE))
    progress("plate with a hole and thick cylinder")
    numbers = [*_patch_numbers(patch), *_cook_numbers(cook), *map(_closed_form_number, closed_form_values())]
    refinements = tuple(_refinements(quick, progress))
    seconds = time.perf_counter() - start
    return ElasticityReproduction(
        tuple(patch), tuple(cook), tuple(incompressible), refinements, tuple(numbers), seconds
    )


def _cook_codes(levels: Sequence[int]) -> Iterator[CookCode]:
    for order in (1, 2):
        for method in METHODS if order == 2 else METHODS[:2]:
            for level in levels:
                yield CookCode(method, level, order)


def _patch_numbers(rows: Sequence[PatchRow]) -> Iterator[ReproducedNumber]:
    for row in rows:
        for name, wanted, value in zip(("11", "12", "22"), (1.0, 0.0, 0.0), row.stresses, strict=True):
            difference = value - wanted
            note = "the value farthest from the published one; difference over the tension"
            if not row.code.published:
                note = f"{_NOT_PUBLISHED.get(row.code.method, 'order not published')}; {note}"
            yield ReproducedNumber(
                "Figure 56", str(row.code), f"stress T{name}", "tension", wanted, value, difference,
                f"{PATCH_LIMIT:g}", abs(difference) <= PATCH_LIMIT, note,
            )  # fmt: skip


def _cook_numbers(rows: Sequence[CookRow]) -> Iterator[ReproducedNumber]:
    """A number is within if it is within 0.1 % (order 2 on M4), or nearer than on the mesh before (any other)."""
    published = [(row["quantity"], row["unit"], float(row["value"])) for row in published_rows("cook_membrane.csv")]
    before: dict[str, float] = {}
    for row in rows:
        code = row.code
        for (name, unit, wanted), value in zip(published, (row.energy, row.middle, row.corner), strict=True):
            difference = value / wanted - 1.0
            series = f"{code.method}{code.order} {name}"
            if code.level == 4 and code.order == 2:
                within, limit = abs(difference) <= COOK_LIMIT, percent(COOK_LIMIT)
            elif series in before:
                within, limit = True, "nearer than on the mesh before"
            else:
                within, limit = abs(difference) <= COOK_COARSEST_LIMIT, percent(COOK_COARSEST_LIMIT)
            within = within and abs(difference) < before.get(series, math.inf)
            before[series] = abs(difference)
            note = _NOT_PUBLISHED["HE"] if code.method == "H" else ""
            yield ReproducedNumber(COOK, str(code), name, unit, wanted, value, difference, limit, within, note)


def _closed_form_number(value: ClosedFormValue) -> ReproducedNumber:
    difference = value.computed / value.exact - 1.0
    soft = f"{NEARLY_INCOMPRESSIBLE:g}" in value.code and "stress" in value.quantity
    limit = SOFT_STRESS_LIMIT if soft else CLOSED_FORM_LIMITS[value.body]
    note = "closed form"
    if soft:
        note += "; its mean stress is a small change of volume times a large modulus"
    return ReproducedNumber(
        value.body, value.code, value.quantity, value.unit, value.exact, value.computed, difference,
        percent(limit), abs(difference) <= limit, note,
    )  # fmt: skip


def _refinements(quick: bool, progress: Progress) -> Iterator[RefinementCase]:
    """Refine both bodies with both orders; the numbers of levels and the tolerances are for uniform's least error."""
    n_cook = 4 if quick else 6
    n_l_shape = {1: 5, 2: 4} if quick else {1: 5, 2: 5}
    cook_tolerances = {1: 0.04, 2: 0.015} if quick else {1: 0.015, 2: 0.004}
    l_shape_tolerances = {1: 0.15, 2: 0.12} if quick else {1: 0.1, 2: 0.01}
    progress("a reference for Cook's membrane")
    reference = cook_reference(1e-3 if quick else 3e-4)
    for order in (1, 2):
        element = Virtual(order)
        progress(f"refining Cook's membrane, order {order}")
        uniform = cook_uniform(element, cook_grid(4), n_cook, reference=reference)
        adaptive = cook_adaptive(element, cook_grid(4), tolerance=cook_tolerances[order], reference=reference)
        yield RefinementCase("Cook", order, tuple(uniform), tuple(adaptive))
        progress(f"refining the L-shaped body, order {order}")
        uniform = uniform_rows(element, l_shape(4), n_l_shape[order])
        adaptive = adaptive_rows(element, l_shape(4), tolerance=l_shape_tolerances[order])
        yield RefinementCase("L-shape", order, tuple(uniform), tuple(adaptive))
