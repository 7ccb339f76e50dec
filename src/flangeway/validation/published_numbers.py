"""What all reproductions share: a published number beside the computed one, and the CSV files of both."""

import csv
from collections.abc import Mapping, Sequence
from dataclasses import asdict, dataclass
from importlib.resources import files
from pathlib import Path


@dataclass(frozen=True)
class ReproducedNumber:
    """A published number and the computed one: a row of ``table.csv``.

    Parameters
    ----------
    table
        Number of the published table, or a name such as ``"Figure 57"``.
    code
        Row of that table.
    quantity
        What it is.
    unit
        Its unit.
    published
        Published value, or the exact one.
    computed
        Computed value.
    relative_difference
        ``computed / published - 1``, or ``computed - published`` where zero or round-off is compared.
    limit
        Maximum difference in words, such as ``"15 %"``; empty for a number that is shown only.
    within
        Whether it is within its limit; for a number that is shown only, within that of its kind.
    note
        Reading, or the reason for a difference.

    """

    table: int | str
    code: str
    quantity: str
    unit: str
    published: float
    computed: float
    relative_difference: float
    limit: str
    within: bool
    note: str

    @property
    def required(self) -> bool:
        """Whether it has a limit, rather than being shown only."""
        return bool(self.limit)


def percent(limit: float) -> str:
    """Return a relative limit in words."""
    return f"{100.0 * limit:g} %"


def compare(
    table: int | str,
    code: str,
    quantity: str,
    unit: str,
    values: tuple[float, float],
    limit: float,
    note: str = "",
    *,
    words: str | None = None,
    within: bool | None = None,
) -> ReproducedNumber:
    """Compare a computed number with a published one; beside a published zero the difference is the computed number.

    Parameters
    ----------
    table, code, quantity, unit, note
        As in `ReproducedNumber`.
    values
        Published and computed number.
    limit
        Maximum absolute value of the difference.
    words
        The limit in words, by default as a number or in per cent; empty for a number that is shown only.
    within
        Whether it is within its limit, if the difference does not decide.

    """
    published, computed = (float(value) for value in values)
    difference = computed / published - 1.0 if published else computed
    if words is None:
        words = percent(limit) if published else f"{limit:g}"
    if within is None:
        within = abs(difference) <= limit
    return ReproducedNumber(table, code, quantity, unit, published, computed, difference, words, bool(within), note)


@dataclass(frozen=True, eq=False, kw_only=True)
class Reproduced:
    """What a reproduction computes, whatever its study.

    Parameters
    ----------
    numbers
        Published, or exact, and computed numbers side by side.
    seconds
        Wall-clock time.

    """

    numbers: tuple[ReproducedNumber, ...]
    seconds: float

    @property
    def failures(self) -> tuple[str, ...]:
        """Sentences on what failed besides the numbers, such as a solution that did not converge."""
        return ()

    @property
    def passed(self) -> bool:
        """Whether nothing failed and all numbers with a limit are within."""
        return not self.failures and all(number.within for number in self.numbers if number.required)


Row = Mapping[str, object]
"""Values of a row of a CSV file by column."""


def write_numbers(path: Path, numbers: Sequence[ReproducedNumber]) -> None:
    """Write ``table.csv``."""
    write_rows(path, [asdict(number) for number in numbers])


def write_rows(path: Path, rows: Sequence[Row]) -> None:
    """Write rows as CSV, numbers with 8 digits."""
    with path.open("w", encoding="utf-8", newline="") as stream:
        writer = csv.writer(stream, lineterminator="\n")
        writer.writerow(rows[0] if rows else ())
        for row in rows:
            writer.writerow([f"{v:.8g}" if isinstance(v, float) else v for v in row.values()])


def published_rows(name: str) -> list[dict[str, str]]:
    """Rows of a published table in ``validation/data`` by column; lines that begin with ``#`` state the source."""
    text = (files("flangeway.validation") / "data" / name).read_text(encoding="utf-8")
    return list(csv.DictReader(line for line in text.splitlines() if not line.startswith("#")))
