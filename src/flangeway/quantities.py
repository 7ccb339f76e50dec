"""A number is defined once: one `Quantity` is a key of ``summary.json``, a row of tables, and a column of CSV files.

A kind of result has a list of quantities. From the same list come

- `values`: the entry of ``summary.json``, by keys with the unit at the end, metric;
- `columns`: a table of numbers, for CSV, campaigns and data frames, in either system of units;
- `labels` and `texts`: the rows or columns of tables for the terminal and the page, in either system of units;
- `reference`: the page that explains the keys.
"""

import math
from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass, replace
from functools import partial
from typing import Any, Generic, TypeAlias, TypeVar

from flangeway.results import ResultTable
from flangeway.units import Units, UsUnit, us_unit

T_contra = TypeVar("T_contra", contravariant=True)
"""Kind of object that has the quantity; what has a quantity of a kind has it as one of a narrower kind."""
Part = TypeVar("Part")
Whole = TypeVar("Whole")
MISSING = "–"
"""Text of a value that does not exist."""
MAX_PLAIN = 1e12
"""Size from which numbers are powers of ten."""
MIN_DIGITS = 3
"""Significant digits that a converted number keeps at least: 70 mm are 2.76 in, not 2.8."""
_SUPERSCRIPTS = str.maketrans("⁰¹²³⁴⁵⁶μ", "0123456u")


@dataclass(frozen=True)
class Quantity(Generic[T_contra]):
    """One number, or a few numbers of a kind, of an object.

    Parameters
    ----------
    key
        Name for programs, without the unit: ``max_pressure``.
    label
        Name for people, without the unit: ``maximum pressure``; two spaces before it put it below the one above it.
        Without a label it is for programs alone, and no table has it.
    of
        Function of the object that returns the number, a text, or None where there is none; with `parts` a sequence.
    unit
        Metric unit, such as ``MPa``, ``mm²``, ``kN/mm``, ``1/m``; empty for numbers without unit and for texts.
    form
        Format of the number for people, such as ``.1f``, see `plain_text`.
    parts
        Names of the components, such as ``("x", "y", "z")``.
    meaning
        What the reference says of it beyond the label.
    factor
        Number by which the value of `of` is multiplied, such as 1e-3 for a force in N that is reported in kN.
    remark
        Function of the object that returns why the number is approximate, None if it is not; tables mark it and print
        the reason.

    """

    key: str
    label: str
    of: Callable[[T_contra], Any]
    unit: str = ""
    form: str = ".4g"
    parts: tuple[str, ...] = ()
    meaning: str = ""
    factor: float = 1.0
    remark: Callable[[T_contra], str | None] = lambda _: None

    @property
    def name(self) -> str:
        """Key with the metric unit: ``max_pressure_MPa``."""
        return f"{self.key}_{key_unit(self.unit)}" if self.unit else self.key

    def value(self, source: T_contra) -> Any:
        """Return the number of an object, metric; a list of them if it has parts; None where there is none."""
        value = self.of(source)
        value = value.tolist() if hasattr(value, "tolist") else value
        if value is None or isinstance(value, str | bool):
            return value
        if self.parts:
            return [None if entry is None else _scaled(entry, self.factor) for entry in value]
        return _scaled(value, self.factor)

    def numbers(self, source: T_contra, units: Units = "metric") -> list[Any]:
        """Return the numbers, one for each part, in a system of units."""
        value, other = self.value(source), self._other(units)
        numbers = [value] if not self.parts else value if value is not None else [None] * len(self.parts)
        return [other.of(number) if other else number for number in numbers]

    def column_names(self, units: Units = "metric") -> list[str]:
        """Keys with the unit, one for each part: ``centre_x_mm``."""
        other = self._other(units)
        unit = key_unit(other.name if other else self.unit)
        ending = f"_{unit}" if unit else ""
        return [f"{self.key}_{part}{ending}" for part in self.parts] or [f"{self.key}{ending}"]

    def labels(self, units: Units = "metric") -> list[str]:
        """Names for people with the unit, one for each part: ``centre of pressure, x, mm``."""
        other = self._other(units)
        unit = other.name if other else self.unit
        names = [f"{self.label}, {part}" for part in self.parts] or [self.label]
        return [f"{name}, {unit}" if unit else name for name in names]

    def texts(self, source: T_contra, units: Units = "metric") -> list[str]:
        """Return the numbers of an object as texts, one for each part."""
        other = self._other(units)
        return [number_text(number, self.form, other) for number in self.numbers(source)]

    def fact(self, source: T_contra, units: Units = "metric") -> tuple[str, str]:
        """Return the text with its unit, and the label, for a tile of the page."""
        other = self._other(units)
        text = " / ".join(self.texts(source, units))
        return f"{text} {other.name if other else self.unit}".strip(), self.label.strip()

    def _other(self, units: Units) -> UsUnit | None:
        return us_unit(self.unit) if units == "us" and self.unit else None


Quantities: TypeAlias = tuple[Quantity[T_contra], ...]
"""All numbers of a kind of object that a table or a part of the summary has."""


def of_part(part: Callable[[Whole], Part | None], *quantities: Quantity[Part]) -> Quantities[Whole]:
    """Return quantities of a part as those of the whole; None where the whole does not have the part."""

    def of(function: Callable[[Part], Any], whole: Any) -> Any:
        value = part(whole)
        return None if value is None else function(value)

    of_whole: Quantities[Any] = tuple(
        replace(quantity, of=partial(of, quantity.value), factor=1.0, remark=partial(of, quantity.remark))
        for quantity in quantities
    )
    return of_whole


def key_unit(unit: str) -> str:
    """Return a unit as keys have it: ``kN/mm`` is ``kN_per_mm``, ``1/m`` is ``per_m``, ``mm²`` is ``mm2``."""
    words = unit.translate(_SUPERSCRIPTS).removeprefix("1").replace("/", "_per_").replace(" ", "_")
    return "percent" if words == "%" else words.strip("_")


def values(quantities: Iterable[Quantity[T_contra]], source: T_contra) -> dict[str, Any]:
    """Return the numbers of an object by their names with units, metric, as ``summary.json`` has them."""
    return {quantity.name: quantity.value(source) for quantity in quantities}


def present(quantities: Iterable[Quantity[T_contra]], source: T_contra) -> list[Quantity[T_contra]]:
    """Return the quantities that an object has."""
    return [quantity for quantity in quantities if quantity.value(source) is not None]


def column_names(quantities: Iterable[Quantity[Any]], units: Units = "metric") -> list[str]:
    """Return the keys with units, one for each part."""
    return [name for quantity in quantities for name in quantity.column_names(units)]


def numbers(quantities: Iterable[Quantity[T_contra]], source: T_contra, units: Units = "metric") -> list[Any]:
    """Return the numbers of an object, one for each of `column_names`."""
    return [number for quantity in quantities for number in quantity.numbers(source, units)]


def columns(
    quantities: Sequence[Quantity[T_contra]], sources: Sequence[T_contra], units: Units = "metric"
) -> ResultTable:
    """Return a table of numbers with a row for each object, in a system of units."""
    rows = [numbers(quantities, source, units) for source in sources]
    names = column_names(quantities, units)
    return ResultTable({name: [row[number] for row in rows] for number, name in enumerate(names)})


def reference(quantities: Iterable[Quantity[Any]]) -> list[tuple[str, str, str]]:
    """Return name with unit, unit, and meaning of quantities, a row each, for the page that explains keys."""
    rows = []
    for quantity in quantities:
        # a label below another one says less than the key
        words = quantity.label if quantity.label[:1].strip() else quantity.key.replace("_", " ")
        sub = quantity.label.strip() if words != quantity.label else ""
        rows.append((quantity.name, quantity.unit, ": ".join(filter(None, (words, sub, quantity.meaning)))))
    return rows


def number_text(value: Any, form: str, unit: UsUnit | None = None) -> str:
    """Return the text of a metric number in its unit, or in another one with as many significant digits.

    - `value`: a text is returned as it is; None is a dash.
    - `form`: format in the metric unit.
    """
    if value is None or isinstance(value, str):
        return MISSING if value is None else value
    if isinstance(value, bool):
        return "yes" if value else "no"
    if unit is None:
        return plain_text(value, form)
    converted, stem = float(unit.of(value)), form.rstrip("f")
    if not form.endswith("f"):
        return plain_text(converted, form)
    # decimals of the same relative precision, and at least three significant digits of what is above one
    decimals = int(stem.rpartition(".")[2]) + round(math.log10(unit.metric))
    if abs(value) >= 1.0:
        decimals = max(decimals, MIN_DIGITS - 1 - math.floor(math.log10(abs(converted))))
    return plain_text(converted, f".{max(decimals, 0)}f")


def plain_text(value: float, form: str) -> str:
    """Return the text of a number: zero has no sign, and a large one all its digits in the place of a power of ten."""
    text = format(value, form)
    if "e+" in text and abs(value) < MAX_PLAIN:
        text = format(float(text), ".0f")
    return text if text.strip("-+0.%") else text.lstrip("-")


def measured(value: float, unit: str, units: Units = "metric", form: str = ".4g") -> str:
    """Return the text of a metric number and its unit in a system of units, such as ``7.874 in`` for 200 mm."""
    other = us_unit(unit) if units == "us" else None
    return f"{number_text(value, form, other)} {other.name if other else unit}".rstrip()


def _scaled(value: Any, factor: float) -> Any:
    return value * factor if factor != 1.0 else value
