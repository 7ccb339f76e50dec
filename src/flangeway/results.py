"""What all results share: a short text, a table of numbers, a view in notebooks, and a picture."""

import csv
import html
import io
import math
import re
from collections.abc import Iterable, Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from flangeway.errors import InputError, short
from flangeway.units import Units, us_key
from flangeway.views import views

SHOWN_ROWS = 12
MAX_TEXT = 150
"""Letters of the text between the brackets: one line of a terminal or two."""
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


class Shown:
    """What has many numbers in it: its text is one line, its picture what it is about."""

    def __init_subclass__(cls, **options: Any) -> None:
        super().__init_subclass__(**options)
        if "__repr__" not in cls.__dict__:
            cls.__repr__ = Shown.__repr__  # type: ignore[method-assign]  # before a dataclass makes its own

    def __repr__(self) -> str:
        names = getattr(self, "__dataclass_fields__", {})  # not what is cached beside them
        words = ", ".join(f"{name}={_word(getattr(self, name))}" for name in names)
        return f"{type(self).__name__}({words if len(words) <= MAX_TEXT else f'{words[:MAX_TEXT]}…'})"

    def plot(self, **options: Any) -> Any:
        """Draw it, and return the figure, which notebooks show; `savefig` writes it.

        - `options`: those of the function that draws it, see `flangeway.report.plot_result`.
        """
        return views().plot_result(self, **options)


class Result(Shown):
    """What a computation returns; its table has the numbers."""

    @property
    def table(self) -> ResultTable:
        """Its numbers."""
        raise NotImplementedError

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
