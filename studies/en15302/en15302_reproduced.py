"""The benchmark of EN 15302: what ``flangeway reproduce conicity`` computes."""

import time
from collections.abc import Callable, Iterator
from dataclasses import dataclass

import numpy as np

from flangeway.cases.rigid.rigid_case import GeometryCase, find_geometry_case
from flangeway.railway.rigid.conicity import RollingRadiusDifference, equivalent_conicity
from flangeway.types import Floats
from studies.published_numbers import Reproduced, ReproducedNumber, Row, compare, published_rows

COMBINATIONS: dict[str, tuple[str, str, float]] = {
    "E1": ("A", "A", 0.0), "E2": ("B", "B", 0.0), "E3": ("H", "H", 0.0), "E4": ("I", "I", 0.0),
    "E5": ("A", "A", 1.0), "E6": ("B", "B", 1.0), "E7": ("H", "H", 1.0), "E8": ("I", "I", 1.0),
    "E9": ("A", "B", 0.0), "C": ("C", "C", 0.0),
}  # fmt: skip
"""Right wheel, left wheel, and by how much the left radius is smaller, in mm."""
TOLERANCE, LARGEST_PART = 0.05, 0.5
"""The standard allows a conicity to be off by the lesser of this number and this part of it."""
DIFFERENCE_LIMIT_MM = 0.002
HALF_DIGIT = 5e-4
"""Half of the last digit in which the standard gives its results."""
STEP_MM, REACH_MM = 0.01, 12.0
SHOWN_MM = (1.0, 2.0, 3.0, 4.0, 5.0, 6.0, 7.0)


@dataclass(frozen=True, eq=False)
class Combination:
    """Results of one combination of profiles beside the standard's.

    Parameters
    ----------
    name
        One of `COMBINATIONS`.
    case
        Inputs of ``flangeway geometry``.
    difference
        Computed rolling radius difference.
    lateral_mm, reference_mm
        Lateral displacements and the standard's differences there, (n,).
    amplitudes_mm, reference, conicity
        Amplitudes, and the standard's and the computed conicity, (m,).

    """

    name: str
    case: GeometryCase
    difference: RollingRadiusDifference
    lateral_mm: Floats
    reference_mm: Floats
    amplitudes_mm: Floats
    reference: Floats
    conicity: Floats

    @property
    def title(self) -> str:
        """Wheels, and the difference of their diameters."""
        right, left, smaller = COMBINATIONS[self.name]
        more = f", {920.0 - 2.0 * smaller:g} mm left" if smaller else ""
        number = "" if self.name in (right, left) else f"{self.name}: "
        return f"{number}{right if right == left else f'{right} right, {left} left'}{more}"

    @property
    def tolerances(self) -> Floats:
        """What the standard allows, and the rounding where it allows nothing, (m,)."""
        return np.maximum(np.minimum(TOLERANCE, LARGEST_PART * self.reference), HALF_DIGIT)

    @property
    def errors_mm(self) -> Floats:
        """Difference of the rolling radius differences, (n,)."""
        return np.abs(self.difference(self.lateral_mm) - self.reference_mm)


@dataclass(frozen=True, eq=False, kw_only=True)
class ConicityReproduction(Reproduced):
    """The benchmark computed again.

    Parameters
    ----------
    combinations
        Results of all combinations.

    """

    combinations: tuple[Combination, ...]


def combination(name: str) -> Combination:
    """Compute one of `COMBINATIONS`, as ``flangeway geometry en15302`` does."""
    right, left, smaller = COMBINATIONS[name]
    inputs: dict[str, object] = {"wheel": f"R-519-{right}"}
    if left != right:
        inputs["left_wheel"] = f"R-519-{left}"
    if smaller:
        inputs["left_wheel_radius_mm"] = 460.0 - smaller
    case = find_geometry_case("en15302", inputs)
    geometry = case.geometry()
    low, high = geometry.limits(REACH_MM, roll=False)
    steps = np.arange(np.ceil(low / STEP_MM), np.floor(high / STEP_MM) + 1.0)
    found = RollingRadiusDifference.of(geometry.locus(steps * STEP_MM, roll=False))
    rows = [row for row in published_rows("en15302.csv") if row["case"] == name]
    (lateral, reference_mm), (amplitudes, reference) = (
        np.array([(float(row["y"]), float(row["value"])) for row in rows if row["quantity"] == quantity]).T
        for quantity in ("difference", "conicity")
    )
    conicity = equivalent_conicity(found, amplitudes)
    return Combination(name, case, found, lateral, reference_mm, amplitudes, reference, conicity)


def combination_numbers(found: Combination) -> Iterator[ReproducedNumber]:
    """Worst difference of the radii, worst conicity over its tolerance, and conicities at whole amplitudes."""
    n = len(found.lateral_mm)
    worst = float(found.errors_mm.max())
    yield compare(
        "EN 15302, J", found.title, "error of the rolling radius difference, worst of all", "mm", (0.0, worst),
        DIFFERENCE_LIMIT_MM, f"{n} lateral displacements",
    )  # fmt: skip
    used = np.abs(found.conicity - found.reference) / found.tolerances
    yield compare(
        "EN 15302, K", found.title, "error of the conicity over its tolerance, worst of all", "",
        (0.0, float(used.max())), 1.0, f"{len(used)} amplitudes",
    )  # fmt: skip
    for at in np.flatnonzero(np.isin(found.amplitudes_mm, SHOWN_MM)):
        pair = float(found.reference[at]), float(found.conicity[at])
        tolerance = float(found.tolerances[at])
        yield compare(
            "EN 15302, K", f"{found.title}, {found.amplitudes_mm[at]:g} mm", "conicity", "", pair, tolerance,
            words=f"{tolerance:g}", within=abs(pair[1] - pair[0]) <= tolerance,
        )  # fmt: skip


def reproduce_conicity(
    *,
    quick: bool = False,  # noqa: ARG001 (all of it takes seconds)
    progress: Callable[[str], None] = lambda _: None,
) -> ConicityReproduction:
    """Compute all combinations, also if `quick`."""
    start = time.perf_counter()
    found = []
    for name in COMBINATIONS:
        progress(f"EN 15302, {name}")
        found.append(combination(name))
    return ConicityReproduction(
        combinations=tuple(found),
        numbers=tuple(number for each in found for number in combination_numbers(each)),
        seconds=time.perf_counter() - start,
    )


def conicity_table(found: ConicityReproduction) -> list[Row]:
    """Rows of ``conicity.csv``."""
    return [
        {"case": each.name, "amplitude_mm": a, "reference": r, "tolerance": t, "computed": c}
        for each in found.combinations
        for a, r, t, c in zip(
            *(v.tolist() for v in (each.amplitudes_mm, each.reference, each.tolerances, each.conicity)), strict=True
        )
    ]


def difference_table(found: ConicityReproduction) -> list[Row]:
    """Rows of ``rolling_radius_difference.csv``."""
    return [
        {"case": each.name, "lateral_mm": y, "reference_mm": r, "computed_mm": c}
        for each in found.combinations
        for y, r, c in zip(
            *(v.tolist() for v in (each.lateral_mm, each.reference_mm, each.difference(each.lateral_mm))), strict=True
        )
    ]
