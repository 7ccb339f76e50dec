"""Published numbers beside the computed ones: CSV files of a reproduction, and tables for page and terminal."""

import csv
import re
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import asdict, dataclass
from pathlib import Path

from flangeway.report.page.tables import SummaryTable
from flangeway.results import Result, ResultTable
from flangeway.system.file_content import packaged_rows


@dataclass(frozen=True)
class ReproducedNumber:
    """A published number and the computed one: a row of ``table.csv``."""

    table: int | str  # number of the published table, or a name such as ``"Figure 57"``
    code: str  # row of that table
    quantity: str  # what it is
    unit: str  # its unit
    published: float  # published value, or the exact one
    computed: float  # computed value
    relative_difference: float
    """``computed / published - 1``, or ``computed - published`` where zero or round-off is compared."""
    limit: str  # maximum difference in words, such as ``"15 %"``; empty for a number that is shown only
    within: bool  # whether it is within its limit; for a number that is shown only, within that of its kind
    note: str  # reading, or the reason for a difference

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

    - `table`, `code`, `quantity`, `unit`, `note`: as in `ReproducedNumber`.
    - `values`: published and computed number.
    - `limit`: maximum absolute value of the difference.
    - `words`: the limit in words, by default as a number or in per cent; empty for a number that is shown only.
    - `within`: whether it is within its limit, if the difference does not decide.
    """
    published, computed = (float(value) for value in values)
    difference = computed / published - 1.0 if published else computed
    if words is None:
        words = percent(limit) if published else f"{limit:g}"
    if within is None:
        within = abs(difference) <= limit
    return ReproducedNumber(table, code, quantity, unit, published, computed, difference, words, bool(within), note)


@dataclass(frozen=True, eq=False, kw_only=True)
class Reproduced(Result):
    """What a reproduction computes, whatever its study."""

    numbers: tuple[ReproducedNumber, ...]  # published, or exact, and computed numbers side by side
    seconds: float  # wall-clock time

    @property
    def table(self) -> ResultTable:
        """Published and computed numbers, a row each."""
        return ResultTable.of_rows(map(asdict, self.numbers))

    @property
    def failures(self) -> tuple[str, ...]:
        """Sentences on what failed besides the numbers, such as a solution that did not converge."""
        return ()

    @property
    def passed(self) -> bool:
        """Whether nothing failed and all numbers with a limit are within."""
        return not self.failures and all(number.within for number in self.numbers if number.required)


Row = Mapping[str, object]  # values of a row of a CSV file by column


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
    """Rows of a published table in ``studies/data`` by column; lines that begin with ``#`` state the source."""
    return packaged_rows("studies", name)


ROUND_OFF = 1e-10  # numbers below it are shown as such, not with digits that change with the machine
MIN_CHANGE = 1e-5  # relative differences below it are shown as such

SHOWN_ONLY = "shown only"
PLAIN = r"\d[\d.]*(?:e-?\d+)?"  # a limit in words that is a number without a unit
NAMES = {"n_dof": "unknowns", "h": "maximum element diameter"}  # quantities that have another name on the page
COMPARED = ("published or exact", "computed", "difference", "limit", "within")


def digits(value: float, n: int = 4) -> str:
    """Return a number with n significant digits, whole numbers with all of theirs; or that it is round-off."""
    if 0.0 < abs(value) < ROUND_OFF:
        return f"< {ROUND_OFF:g}"
    if abs(value) < 1e7 and (value.is_integer() or abs(value) >= 10.0 ** (n - 1)):
        return f"{value:.0f}"
    return _short(re.sub(r"\.(?=e|$)", "", f"{value:#.{n}g}"))


def published(number: ReproducedNumber) -> str:
    """Return the published number as it is printed, an exact one with six digits."""
    return _short(f"{number.published:.6g}")


def share(value: float) -> str:
    """Return a part of a whole in per cent."""
    return f"{digits(100.0 * value, 2)} %"


def relative(difference: float) -> str:
    """Return a relative difference in per cent with its sign and two digits, or that it is small."""
    if abs(difference) < MIN_CHANGE:
        return f"< {100.0 * MIN_CHANGE:g} %"
    return f"+{share(difference)}" if difference > 0.0 else share(difference)


def numbers_table(numbers: Sequence[ReproducedNumber]) -> SummaryTable:
    """Return all numbers, one a row."""
    rows = tuple((_quantity(n, n.quantity), n.code, *_compared(n)) for n in numbers)
    return SummaryTable(f"All {len(numbers)} numbers", ("quantity", "code", *COMPARED), rows)


def worst_table(numbers: Iterable[ReproducedNumber]) -> SummaryTable:
    """Return the largest deviation of each quantity of each table, and how many of all are within."""
    groups: dict[tuple[str, bool], list[ReproducedNumber]] = {}
    for number in numbers:
        name = _quantity(number, number.quantity.partition(", ")[0])
        groups.setdefault((name, number.required), []).append(number)
    rows = []
    for (name, _), members in groups.items():
        # rounded, so that the choice among equals is the same on all machines
        worst = min(members, key=lambda n: (n.within, -round(abs(n.relative_difference), 6)))
        of = worst.quantity.partition(", ")[2]
        code = f"{worst.code}, {of}" if of else worst.code
        *values, limit, within = _compared(worst)
        if worst.required:
            within = f"{sum(n.within for n in members)} of {len(members)}"
            within = within if all(n.within for n in members) else f"**{within}**"
            limit = _range([*dict.fromkeys(_compared(n)[3] for n in members)])
        rows.append((name, code, *values, limit, within))
    head = ("quantity", "largest deviation", *COMPARED)
    # those with a limit first
    rows.sort(key=lambda row: row[-2] == SHOWN_ONLY)
    return SummaryTable("Largest deviation of each quantity", head, tuple(rows))


def reasons(numbers: Iterable[ReproducedNumber]) -> list[str]:
    """Return a line of Markdown for each of the numbers `outside` with its reason."""
    return [f"{'**Not within:**' if number.required else 'Shown only:'} {text}" for number, text in outside(numbers)]


def outside(numbers: Iterable[ReproducedNumber]) -> list[tuple[ReproducedNumber, str]]:
    """Return each number that is not within its limit, and one for each reason to show one without a limit.

    Of notes with the same reason, the text after their last colon, the first is returned. Beside each number is a
    sentence on it.
    """
    found, known = [], set()
    for n in numbers:
        reason = n.note.rpartition(": ")[2]
        if n.within or (not n.required and reason in known):
            continue
        known.add(reason)
        values = f"{digits(n.computed)} for {published(n)}"
        found.append((n, _short(f"{_quantity(n, n.quantity)}, {n.code}, {values}; {n.note}")))
    return found


def _range(limits: list[str]) -> str:
    """Different limits in words: from the least to the largest one, if all are numbers, or all in per cent."""
    for kind in (PLAIN, f"{PLAIN} %"):
        if len(limits) > 1 and all(re.fullmatch(kind, each) for each in limits):
            limits = sorted(limits, key=lambda each: float(each.removesuffix(" %")))
            return f"{limits[0]} to {limits[-1]}"
    return " or ".join(limits)


def _short(text: str) -> str:
    """Write 1e-09 as 1e-9."""
    return text.replace("e-0", "e-")


def _table(name: int | str) -> str:
    """Return a table's name; bare numbers are those of the published tables and sections."""
    if isinstance(name, int):
        return f"Table {name}"
    return f"Section {name}" if name[0].isdigit() else name


def _quantity(number: ReproducedNumber, name: str) -> str:
    """Return table, quantity and unit."""
    shown = f"{_table(number.table)}: {NAMES.get(name, name).replace('_', ' ')}"
    unit = re.sub(r"\^([2-6])", lambda power: "²³⁴⁵⁶"[int(power[1]) - 2], number.unit)
    return shown if unit in ("", "1") else f"{shown}, {unit}"


def _compared(number: ReproducedNumber) -> tuple[str, str, str, str, str]:
    """Return the cells of `COMPARED`."""
    apart = number.computed - number.published
    if number.published == 0.0 or abs(apart) < ROUND_OFF:
        difference = digits(number.relative_difference, 2)
    elif number.required and re.fullmatch(PLAIN, number.limit):
        difference = f"{'+' * (apart > 0.0)}{digits(apart, 2)}"
    else:
        difference = relative(number.relative_difference)
    within = ("yes" if number.within else "**no**") if number.required else ""
    limit = _short(number.limit) or SHOWN_ONLY
    return published(number), digits(number.computed), difference, limit, within
