"""Plane elasticity (Moherdaui 2021, chapter 5) computed again: what ``flangeway reproduce elasticity`` computes."""

import math
import time
from collections.abc import Iterator, Sequence
from dataclasses import asdict, dataclass

from flangeway.cases.bodies.cook import (
    NEARLY_INCOMPRESSIBLE,
    NEARLY_INCOMPRESSIBLE_WORK,
    CookCode,
    CookRow,
    cook_grid,
    cook_row,
)
from flangeway.cases.case import Progress
from flangeway.elements import Virtual
from flangeway.post.adaptive import RefinementRow
from studies.elasticity.closed_form import (
    L_SHAPE,
    PatchRow,
    closed_form_numbers,
    cook_reference,
    l_shape,
    patch_codes,
    patch_row,
    refined_cook,
)
from studies.published_numbers import Reproduced, ReproducedNumber, Row, compare, published_rows

COOK = "Section 5.3.2"
COOK_VALUES = ("energy", "middle", "corner")  # attributes of a `CookRow` with the numbers published
METHODS = ("F", "V", "H")

PATCH_LIMIT = 1e-9
COOK_LIMIT = 1e-3
COOK_COARSEST_LIMIT = 0.1
INCOMPRESSIBLE_LIMIT = 0.01
FEWER_UNKNOWNS = 10.0
"""Minimum ratio of the unknowns of uniform to those of adaptive refinement of the L-shaped body, at the same error."""

_NOT_PUBLISHED = {
    "VD": "virtual triangles: not published for this problem",
    "HE": "triangles inside, virtual elements at the boundary (Figure 68): not published for this problem",
}


@dataclass(frozen=True)
class RefinementCase:
    """Uniform and adaptive refinement of one body with one order."""

    body: str  # ``"Cook"`` or ``"L-shape"``
    order: int  # order of the virtual elements
    uniform: tuple[RefinementRow, ...]
    adaptive: tuple[RefinementRow, ...]  # uniform, adaptive: the solutions, coarsest first

    @property
    def saving(self) -> float:
        """Unknowns of the finest uniform mesh over those of the first adaptive one with no larger error, or nan."""
        finest = self.uniform[-1]
        reached = (row.n_unknowns for row in self.adaptive if row.error <= finest.error)
        return finest.n_unknowns / next(reached, math.nan)


@dataclass(frozen=True)
class IncompressibleRow:
    """The nearly incompressible membrane: a row of ``nearly_incompressible.csv``."""

    code: str  # configuration
    n_unknowns: int  # components of displacement at nodes
    load_work: float  # work of the load, twice the strain energy
    reference: float  # the same by orders 3 and 4 on fine meshes
    relative_difference: float  # ``load_work / reference - 1``


@dataclass(frozen=True, eq=False, kw_only=True)
class ElasticityReproduction(Reproduced):
    """Chapter 5 computed again, with related problems."""

    patch: tuple[PatchRow, ...]  # patch tests
    cook: tuple[CookRow, ...]  # cook's membrane with the published material
    incompressible: tuple[IncompressibleRow, ...]  # the same configurations, nearly incompressible
    refinements: tuple[RefinementCase, ...]  # uniform against adaptive refinement

    @property
    def failures(self) -> tuple[str, ...]:
        """Order 2 that locks, and refinements of the L-shaped body that save too few unknowns."""
        locking = [
            f"{row.code}: the work of the load with Poisson's ratio {NEARLY_INCOMPRESSIBLE:g} differs by "
            f"{100.0 * row.relative_difference:+.3g} % from the reference"
            for row in self.incompressible
            if row.code.endswith("O2") and not abs(row.relative_difference) <= INCOMPRESSIBLE_LIMIT
        ]
        saving = [
            f"{case.body}, order {case.order}: adaptive refinement saves a factor of {case.saving:.3g} of unknowns, "
            f"less than {FEWER_UNKNOWNS:g}"
            for case in self.refinements
            if case.body == "L-shape" and not case.saving >= FEWER_UNKNOWNS
        ]
        return (*locking, *saving)


def reproduce_elasticity(*, quick: bool = False, progress: Progress = lambda _: None) -> ElasticityReproduction:
    """Compute chapter 5 again; if `quick`, two of four meshes of Cook's membrane and less refinement."""
    start = time.perf_counter()
    patch = []
    for code in patch_codes((1, 2) if quick else (1, 2, 3, 4)):
        progress(f"patch test: {code}")
        patch.append(patch_row(code))
    cook, incompressible = [], []
    for cook_code in _cook_codes((1, 2) if quick else (1, 2, 3, 4)):
        progress(f"Cook's membrane: {cook_code}")
        cook.append(cook_row(cook_code))
        soft, reference = cook_row(cook_code, NEARLY_INCOMPRESSIBLE), NEARLY_INCOMPRESSIBLE_WORK
        work = soft.solution.load_work
        incompressible.append(
            IncompressibleRow(str(cook_code), soft.n_unknowns, work, reference, work / reference - 1.0)
        )
    progress("plate with a hole and thick cylinder")
    numbers = [*_patch_numbers(patch), *_cook_numbers(cook), *closed_form_numbers()]
    return ElasticityReproduction(
        patch=tuple(patch),
        cook=tuple(cook),
        incompressible=tuple(incompressible),
        refinements=tuple(_refinements(quick, progress)),
        numbers=tuple(numbers),
        seconds=time.perf_counter() - start,
    )


def incompressible_rows(found: ElasticityReproduction) -> list[Row]:
    """Rows of ``nearly_incompressible.csv``."""
    return [asdict(row) for row in found.incompressible]


def refinement_rows(found: ElasticityReproduction) -> list[Row]:
    """Rows of ``refinement.csv``; errors as in `flangeway.post.adaptive.RefinementRow`."""
    return [
        {
            "body": case.body,
            "order": case.order,
            "refinement": row.refinement,
            "n_cells": row.mesh.n_cells,
            "n_unknowns": row.n_unknowns,
            "error": row.error,
            "estimated_error": row.estimated_error,
        }
        for case in found.refinements
        for row in (*case.uniform, *case.adaptive)
    ]


def _cook_codes(levels: Sequence[int]) -> Iterator[CookCode]:
    for order in (1, 2):
        for method in METHODS if order == 2 else METHODS[:2]:
            for level in levels:
                yield CookCode(method, level, order)


def _patch_numbers(rows: Sequence[PatchRow]) -> Iterator[ReproducedNumber]:
    for row in rows:
        for name, wanted, value in zip(("11", "12", "22"), (1.0, 0.0, 0.0), row.stresses, strict=True):
            note = "value with the maximum deviation; difference relative to the tension"
            if not row.code.published:
                note = f"{_NOT_PUBLISHED.get(row.code.method, 'order not published')}; {note}"
            words = f"{PATCH_LIMIT:g}"
            yield compare(
                "Figure 56",
                str(row.code),
                f"stress T{name}",
                "tension",
                (wanted, value),
                PATCH_LIMIT,
                note,
                words=words,
            )


def _cook_numbers(rows: Sequence[CookRow]) -> Iterator[ReproducedNumber]:
    """A number is within if it is within 0.1 % (order 2 on M4), or nearer than on the mesh before (any other)."""
    published = [(row["quantity"], row["unit"], float(row["value"])) for row in published_rows("cook_membrane.csv")]
    before: dict[str, float] = {}
    for row in rows:
        code = row.code
        for (name, unit, wanted), value in zip(published, map(row.__getattribute__, COOK_VALUES), strict=True):
            error = abs(value / wanted - 1.0)
            series, limit, words = f"{code.method}{code.order} {name}", COOK_COARSEST_LIMIT, None
            if code.level == 4 and code.order == 2:
                limit = COOK_LIMIT
            elif series in before:
                limit, words = math.inf, "error below that of the previous mesh"
            within = error <= limit and error < before.get(series, math.inf)
            before[series] = error
            note = _NOT_PUBLISHED["HE"] if code.method == "H" else ""
            yield compare(COOK, str(code), name, unit, (wanted, value), limit, note, words=words, within=within)


def _refinements(quick: bool, progress: Progress) -> Iterator[RefinementCase]:
    """Refine both bodies with both orders; the numbers of levels and the tolerances are for uniform's least error."""
    progress("a reference for Cook's membrane")
    cook = refined_cook(cook_reference(1e-3 if quick else 3e-4))
    n_cook, cook_tolerances = (4, (0.04, 0.015)) if quick else (6, (0.015, 0.004))
    n_l_shape, l_shape_tolerances = ((5, 4), (0.15, 0.12)) if quick else ((5, 5), (0.1, 0.01))
    for order in (1, 2):
        element = Virtual(order)
        for body, mesh, n_levels, tolerances in (
            (cook, cook_grid(4), n_cook, cook_tolerances),
            (L_SHAPE, l_shape(4), n_l_shape[order - 1], l_shape_tolerances),
        ):
            progress(f"refining {body.name}, order {order}")
            uniform = body.uniform(element, mesh, n_levels)
            adaptive = body.adaptive(element, mesh, tolerance=tolerances[order - 1])
            yield RefinementCase(body.name, order, tuple(uniform), tuple(adaptive))
