"""What all reproductions share: a published number beside the computed one, and the files of both."""

import csv
from collections.abc import Sequence
from dataclasses import dataclass, fields
from importlib.resources import files
from pathlib import Path
from typing import Any, Protocol


@dataclass(frozen=True)
class ReproducedNumber:
    """A published number and the computed one: a row of ``table.csv``.

    Parameters
    ----------
    table
        Number of the published table, or the name of what stands for one, such as ``"Figure 57"``.
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
        Maximum difference that counts as within, in words such as ``"15 %"``; empty for a number that is shown only.
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


class Reproduced(Protocol):
    """What a reproduction leaves, whatever it computes."""

    @property
    def numbers(self) -> Sequence[ReproducedNumber]:
        """Published and computed numbers side by side."""

    @property
    def passed(self) -> bool:
        """Whether the numbers are as near to the published ones as they must be."""

    @property
    def seconds(self) -> float:
        """Wall-clock time."""


def write_rows(path: Path, rows: Sequence[Any], kind: type) -> None:
    """Write frozen rows as CSV, one column a field, numbers with 8 digits."""
    names = [field.name for field in fields(kind)]
    with path.open("w", encoding="utf-8", newline="") as stream:
        writer = csv.writer(stream, lineterminator="\n")
        writer.writerow(names)
        for row in rows:
            values = [getattr(row, name) for name in names]
            writer.writerow([f"{v:.8g}" if isinstance(v, float) else v for v in values])


def published_rows(name: str) -> list[dict[str, str]]:
    """Rows of a published table that comes with the package, by the names of its columns.

    Parameters
    ----------
    name
        Name of the file in ``study/data``; its lines that begin with ``#`` tell the source and are left out.

    """
    text = (files("flangeway.validation") / "data" / name).read_text(encoding="utf-8")
    return list(csv.DictReader(line for line in text.splitlines() if not line.startswith("#")))
