"""What all results share: a short text, a table of numbers, a view in notebooks, a picture, and US customary units."""

import csv
import html
import io
import math
import re
from collections.abc import Callable, Collection, Iterable, Mapping, Sequence
from dataclasses import dataclass
from fractions import Fraction
from functools import cache
from pathlib import Path
from string import Formatter
from typing import Any, Literal

import numpy as np
from numpy.typing import NDArray

from flangeway.checks import is_number
from flangeway.errors import InputError, short
from flangeway.views import views

# --- US customary units beside the metric ones: of keys such as ``axle_load_kN``, and of texts such as "200 kN".
#
# Factors are exact: 1 in = 25.4 mm, 1 lb = 0.45359237 kg, standard gravity 9.80665 m/s² (NIST SP 811).


Units = Literal["metric", "us"]

_FOOT, _POUND = Fraction("0.3048"), Fraction("0.45359237")
_FORCE = _POUND * Fraction("9.80665")  # N in 1 lbf, and kN in 1 kip
_PRESSURE = _FORCE / Fraction("0.64516")  # MPa in 1 ksi, and GPa in 1 Msi

_BASE = {
    "km": ("mi", Fraction("1.609344")),
    "mm": ("in", Fraction("25.4")),
    "cm": ("in", Fraction("2.54")),
    "µm": ("mil", Fraction("25.4")),
    "m": ("ft", _FOOT),
    "kNm": ("kip_ft", _FORCE * _FOOT),
    "Nm": ("lbf_ft", _FORCE * _FOOT),
    "kN": ("kip", _FORCE),
    "N": ("lbf", _FORCE),
    "MPa": ("ksi", _PRESSURE),
    "GPa": ("Msi", _PRESSURE),
    "kg": ("lb", _POUND),
    "t": ("lb", _POUND / 1000),
}
"""Unit in the US, and how many metric ones it is."""
_WHOLE = {"km/h": ("mph", Fraction("1.609344")), "kg/m": ("lb/yd", _POUND / (3 * _FOOT))}
_ALIKE = ("mrad", "rad", "deg", "s", "h", "W", "J")  # in both systems
_POWERS = str.maketrans("⁰¹²³⁴⁵⁶⁻", "0123456-")

_NAME = "|".join(sorted((*_BASE, *_ALIKE), key=len, reverse=True))
_PART = rf"(?:{_NAME})(?:⁻?[²³⁴⁵⁶]|[2-6])?"
_TEXT_UNIT = rf"(?:1/)?{_PART}(?:[ /]{_PART})*"
_KEY_UNIT = re.compile(rf"_((?:per_)?{_PART}(?:_(?:per_)?{_PART})*)$")
_SPLIT = re.compile(rf"(^1/|^per_|^|/|_per_|_| )({_NAME})(⁻?[²³⁴⁵⁶]|[2-6])?")
_KEY = re.compile(r"\b[a-z]\w*_\w+\b(?!\s?=\s?(?:0\.\d|[-1-9\[]))")
"""Name in a text that may be that of an input; a value behind it is none of a `Message`, and keeps its unit."""


@dataclass(frozen=True)
class UsUnit:
    """A key or unit in the US, and how many metric units it is."""

    name: str
    metric: Fraction

    def of(self, value: Any) -> Any:
        """Return a metric number, or each one in a list, in this unit; what is no number as it is."""
        return _each(value, 1 / self.metric)

    def to_metric(self, value: Any) -> Any:
        """Return a number of this unit, or each one in a list, in the metric one; what is no number as it is."""
        return _each(value, self.metric)


def _each(value: Any, factor: Fraction) -> Any:
    if isinstance(value, list | tuple):
        return type(value)(_each(part, factor) for part in value)
    # a float times a fraction is the nearest float of the exact product of both
    return float(Fraction(float(value)) * factor) if is_number(value) and math.isfinite(value) else value


@cache
def us_unit(unit: str) -> UsUnit | None:
    """Return the unit of a text such as "kN/mm" or "mm⁴" in the US; None if it is the same there, or no unit."""
    if not re.fullmatch(_TEXT_UNIT, unit):
        return None
    converted = _converted(unit)
    return None if converted is None else UsUnit(converted[0].replace("_", " "), converted[1])


@cache
def us_key(key: str) -> UsUnit | None:
    """Return what a key such as ``axle_load_kN`` is called in the US; None if it has no unit, or the same there."""
    unit = _KEY_UNIT.search(key)
    converted = _converted(unit[1]) if unit else None
    return None if unit is None or converted is None else UsUnit(f"{key[: unit.start(1)]}{converted[0]}", converted[1])


def unit_in(key: str) -> str:
    """Return the metric unit at the end of a key of an input as texts have it, ``N/mm`` of ``stiffness_N_mm``."""
    match = _KEY_UNIT.search(key)
    return match[1].replace("per_", "").replace("_", "/") if match else ""


def _converted(unit: str) -> tuple[str, Fraction] | None:
    slash = unit.replace("_", "/")
    if slash in _WHOLE:
        name, factor = _WHOLE[slash]
        return (name if unit == slash else name.replace("/", "_")), factor
    text, factor = "", Fraction(1)
    for separator, base, power in _SPLIT.findall(unit):
        name, metric = _BASE.get(base, (base, Fraction(1)))
        exponent = int(power.translate(_POWERS)) if power else 1
        factor *= metric ** (-exponent if separator not in ("", " ") else exponent)
        text += f"{separator}{name}{power}"
    return None if factor == 1 else (text, factor)


def same_quantity(key: str, other: str) -> bool:
    """Whether two different keys are one quantity in both systems."""
    return any(unit is not None and unit.name == name for unit, name in ((us_key(key), other), (us_key(other), key)))


@dataclass(frozen=True)
class Measure:
    """A number in a sentence: its text in both systems of units, and the key before it, if it has one."""

    metric: str
    us: str
    key: str = ""


class Message(str):
    """A sentence whose numbers have units: as a text it is metric, `in_us_units` gives the other one.

    ``+``, `joined_text` and `sentence` keep the numbers, all other operations on texts return the metric text alone.
    """

    parts: tuple[str | Measure, ...]

    def __new__(cls, parts: Iterable[str | Measure]) -> "Message":
        """Make it of texts and numbers in their order."""
        parts = tuple(parts)
        message = super().__new__(cls, "".join(part.metric if isinstance(part, Measure) else part for part in parts))
        message.parts = parts
        return message

    def __getnewargs__(self) -> tuple[Any, ...]:
        """Return its parts, so that it can be copied and sent to another process."""
        return (self.parts,)

    def __add__(self, other: str) -> "Message":
        return Message((*self.parts, *_parts(other)))

    def __radd__(self, other: str) -> "Message":
        return Message((*_parts(other), *self.parts))


def _parts(text: str) -> tuple[str | Measure, ...]:
    return text.parts if isinstance(text, Message) else (text,)


def sentence(template: str, *values: Any) -> str:
    """Return a sentence with values in the fields of a template, in their order.

    - ``{:.3g mm}``: a number, or a point, with its metric unit.
    - ``{:.3g (mm)}``: without it, as before one with it: "{:g (mm)} to {:g mm}".
    - ``{gauge_mm = :g}``: a key and its value.
    - ``{65 mm}``: a number that is the same in all sentences.
    - ``{}``, ``{!r}``, ``{:.1f}``: what has no unit, as for `str.format`.
    """
    parts, left = list[str | Measure](), iter(values)
    for text, name, spec, conversion in Formatter().parse(template):
        parts.append(text)
        if name is None:
            continue
        if name[:1].isdigit():
            parts += _parts(with_unit(float(name.partition(" ")[0]), name.partition(" ")[2]))
            continue
        value, (form, _, unit) = Formatter().convert_field(next(left), conversion), (spec or "").partition(" ")
        if name:
            parts += _parts(assigned(name.removesuffix(" = "), value, form))
        elif unit:
            parts += _parts(with_unit(value, unit, form))
        else:
            parts += _parts(value if isinstance(value, Message) else format(value, form))
    return Message(parts)


def with_unit(value: float | tuple[float, ...], unit: str, form: str = "g") -> str:
    """Return a metric number and its unit for a sentence, ``12.5 mm``, or a point, ``(12.5, 3) mm``.

    - `unit`: in parentheses, ``(mm)``, it is left out.
    """
    name = "" if unit.startswith("(") else f" {unit}"
    other = us_unit(unit.strip("()"))
    metric = f"{_listed(value, form)}{name}"
    us = f"{_listed(other.of(value), form, shown)}{name and f' {other.name}'}" if other else metric
    return Message([Measure(metric, us)])


def assigned(key: str, value: Any, form: str = "") -> str:
    """Return a key and its value for a sentence, ``gauge_mm = 1435``.

    - `key`: also a path to it, ``bodies[1].size_mm``.
    - `form`: format of the metric value.
    """
    unit = us_key(key)
    metric = f"{key} = {_listed(value, form)}"
    us = f"{unit.name} = {_listed(unit.of(value), form, shown)}" if unit else metric
    return Message([Measure(metric, us, key.rpartition(".")[2])])


def _listed(value: Any, form: str, number_text: Callable[[float], str] | None = None) -> str:
    if isinstance(value, list | tuple):
        inside = ", ".join(_listed(item, form, number_text) for item in value)
        return f"[{inside}]" if isinstance(value, list) else f"({inside})"
    if not is_number(value):
        return str(value)
    return number_text(value) if number_text else format(value, form)


def joined_text(separator: str, sentences: Iterable[str]) -> str:
    """Return sentences as one, with a text between them."""
    return Message(part for number, text in enumerate(sentences) for part in (separator * (number > 0), *_parts(text)))


def with_texts(text: str, change: Callable[[str], str]) -> str:
    """Return a sentence with its texts between the numbers changed by a function."""
    return Message(part if isinstance(part, Measure) else change(part) for part in _parts(text))


def in_us_units(text: str, keys: Collection[str] | None = None) -> str:
    """Return a text with its keys of inputs, ``gauge_mm``, and the numbers of a `Message` in US units.

    - `keys`: convert these keys, and the numbers behind them, only.
    """

    def of_key(match: re.Match[str]) -> str:
        unit = us_key(match[0]) if keys is None or match[0] in keys else None
        return unit.name if unit else match[0]

    return "".join(
        (part.us if keys is None or part.key in keys else part.metric)
        if isinstance(part, Measure)
        else _KEY.sub(of_key, part)
        for part in _parts(text)
    )


def shown(value: float) -> str:
    """Return a converted number with four digits, more where it is above 10,000."""
    return f"{value:.0f}" if 1e4 <= abs(value) < 1e7 else f"{value:.4g}"


# --- What all results share: a short text, a table of numbers, a view in notebooks, and a picture.


SHOWN_ROWS = 12
LETTERS = "xyz"
UNIT = re.compile(r"_(?:mm\d?|m|MPa|N|kN|deg|rad|mrad)$")


class ResultTable:
    """Columns of equal length by their names, which have the units.

    Parameters
    ----------
    columns
        Numbers or words by the names of the columns, each with one value a row.

    """

    def __init__(self, columns: Mapping[str, Sequence[Any] | NDArray[Any]]) -> None:
        self.columns = dict(columns)
        lengths = {len(values) for values in self.columns.values()}
        if len(lengths) > 1:
            raise InputError(f"columns of {sorted(lengths)} rows", "one length", "leave out, or fill up, the others")

    @classmethod
    def of_rows(
        cls, rows: Iterable[Mapping[str, Any]], endings: Mapping[str, Sequence[str]] | None = None
    ) -> "ResultTable":
        """Return a table of rows that hold numbers, lists of some numbers, and mappings, by names.

        Two or three numbers become columns with x, y, z before the unit, or with the endings given for their name;
        longer lists are left out.
        """
        flat = [dict(_flat(row, endings or {})) for row in rows]
        return cls(
            {name: [row.get(name) for row in flat] for name in dict.fromkeys(name for row in flat for name in row)}
        )

    @classmethod
    def of_numbers(cls, values: Mapping[str, Any]) -> "ResultTable":
        """Return a table of two columns, names and numbers; what is no number is left out."""
        numbers = {name: value for name, value in _flat(values, {}) if isinstance(value, int | float)}
        return cls({"quantity": list(numbers), "value": list(numbers.values())})

    def __len__(self) -> int:
        return len(next(iter(self.columns.values()), ()))

    def rows(self, first: int | None = None) -> list[tuple[Any, ...]]:
        """Return its rows, or some of them."""
        return list(zip(*(_plain(values[:first]) for values in self.columns.values()), strict=True))

    def __repr__(self) -> str:
        cells = [tuple(self.columns), *(tuple(_text(value, 6) for value in row) for row in self.rows(SHOWN_ROWS))]
        widths = [max(map(len, column)) for column in zip(*cells, strict=True)]
        lines = ["  ".join(cell.rjust(width) for cell, width in zip(row, widths, strict=True)) for row in cells]
        return "\n".join([*lines, *self._more()])

    def _repr_html_(self) -> str:
        def line(cells: Iterable[str], tag: str) -> str:
            return "<tr>" + "".join(f"<{tag}>{html.escape(cell)}</{tag}>" for cell in cells) + "</tr>"

        body = "".join(line((_text(value, 6) for value in row), "td") for row in self.rows(SHOWN_ROWS))
        more = "".join(f"<p>{text}</p>" for text in self._more())
        return f"<table><thead>{line(self.columns, 'th')}</thead><tbody>{body}</tbody></table>{more}"

    def _more(self) -> list[str]:
        return [f"{len(self):,} rows in all"] if len(self) > SHOWN_ROWS else []

    def in_units(self, units: Units) -> "ResultTable":
        """Return it in a system of units: the names of its columns and their numbers; the other columns as they are.

        Where a quantity has a column of each system, one column is left.
        """
        other = {name: us_key(name) if units == "us" else None for name in self.columns}
        return ResultTable(
            {
                unit.name if unit else name: unit.of(_plain(self.columns[name])) if unit else self.columns[name]
                for name, unit in other.items()
            }
        )

    def csv(self, digits: int = 10) -> str:
        """Return it as CSV with some digits, for spreadsheets; what there is not is empty."""
        text = io.StringIO()
        writer = csv.writer(text, lineterminator="\n")
        writer.writerow(self.columns)
        writer.writerows([_text(value, digits, none="") for value in row] for row in self.rows())
        return text.getvalue()

    def to_csv(self, path: str | Path) -> None:
        """Write it as CSV, which spreadsheets open."""
        Path(path).write_text(self.csv(), encoding="utf-8")

    def to_dataframe(self) -> Any:
        """Return it as a data frame of pandas; an `InputError` where pandas is not installed."""
        try:
            import pandas  # noqa: PLC0415 (optional)
        except ModuleNotFoundError as reason:
            raise InputError(
                "a data frame without pandas", "an installed pandas", "install it, or take to_csv"
            ) from reason
        return pandas.DataFrame({name: _plain(values) for name, values in self.columns.items()})


class Result:
    """What a computation returns: its text is one line, its table numbers, its picture what it is about."""

    def __init_subclass__(cls, **options: Any) -> None:
        super().__init_subclass__(**options)
        if "__repr__" not in cls.__dict__:
            cls.__repr__ = Result.__repr__  # type: ignore[method-assign]  # before a dataclass makes its own

    @property
    def table(self) -> ResultTable:
        """Its numbers."""
        raise NotImplementedError

    def __repr__(self) -> str:
        names = getattr(self, "__dataclass_fields__", {})  # not what is cached beside them
        words = [f"{name}={_word(getattr(self, name))}" for name in names]
        return f"{type(self).__name__}({', '.join(words)})"

    def _repr_html_(self) -> str:
        case = getattr(self, "case", None)  # runs of cases show what the command prints
        shown = views().run_html(self) if case is not None else None
        return shown or f"<p><code>{html.escape(repr(self))}</code></p>{self.table._repr_html_()}"

    def to_dataframe(self) -> Any:
        """Return its table as a data frame of pandas; an `InputError` where pandas is not installed."""
        return self.table.to_dataframe()

    def to_csv(self, path: str | Path) -> None:
        """Write its table as CSV, which spreadsheets open."""
        self.table.to_csv(path)

    def plot(self, **options: Any) -> Any:
        """Draw it, and return the figure, which notebooks show; `savefig` writes it.

        - `options`: those of the function that draws it, see `flangeway.report.plot_result`.
        """
        return views().plot_result(self, **options)


def _flat(
    values: Mapping[str, Any], endings: Mapping[str, Sequence[str]], before: str = ""
) -> Iterable[tuple[str, Any]]:
    for key, value in values.items():
        if isinstance(value, Mapping):
            yield from _flat(value, endings, f"{before}{key}_")
        elif key in endings or (isinstance(value, list | tuple) and len(value) in (2, 3)):
            letters = endings.get(key) or LETTERS[: len(value)]
            unit = UNIT.search(key)
            stem, ending = (key[: unit.start()], unit[0]) if unit else (key, "")
            for letter, component in zip(letters, value or [None] * len(letters), strict=True):
                yield f"{before}{stem}_{letter}{ending}", component
        elif not isinstance(value, list | tuple):
            yield before + key, value


def _plain(values: Any) -> list[Any]:
    plain: list[Any] = values.tolist() if isinstance(values, np.ndarray) else list(values)
    return plain


def _text(value: Any, digits: int, none: str = "–") -> str:
    if isinstance(value, float):
        return f"{value:.{digits}g}" if math.isfinite(value) else none
    return none if value is None else str(value)


def _word(value: Any) -> str:
    """Return a short text for a value: its shape or number for what is long, else itself or its class."""
    if isinstance(value, np.ndarray):
        return f"array{value.shape}"
    if isinstance(value, list | tuple | Mapping) and len(value) > 3:
        return f"{len(value)} items"
    if isinstance(value, str | int | float | bool | np.generic | None):
        return short(value)
    if isinstance(value, list | tuple):
        return f"({', '.join(map(_word, value))})"
    return type(value).__name__
