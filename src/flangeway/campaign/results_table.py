"""The results of a campaign as columns, and as files for other programs."""

import csv
import importlib
import json
import sqlite3
from collections.abc import Callable
from contextlib import closing
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from flangeway.campaign.columns import WHEELSET_COLUMNS, Value
from flangeway.campaign.database import OWN_COLUMNS, WAITING, quoted, refuse_other_file, unusable
from flangeway.errors import InputError, MissingLibraryError

Columns = dict[str, list[Value]]
FORMATS = ("csv", "parquet")


@dataclass(frozen=True, eq=False)
class CampaignTable:
    """Content of a campaign's database.

    Parameters
    ----------
    name, case
        Names of the campaign and of its case.
    keys
        Inputs that vary, in their order.
    inputs
        All inputs of the first row.
    rows
        Column by column, one entry a row: its number, status, message and warnings, what varies, and the results, None
        where there is none.
    patches
        Column by column, one entry a region of contact, numbered on each side from the field to the gauge.

    """

    name: str
    case: str
    keys: tuple[str, ...]
    inputs: dict[str, Any]
    rows: Columns
    patches: Columns

    def numbers(self, column: str) -> NDArray[np.float64]:
        """Return a column of numbers, not-a-number where there is none, shape (n_rows,).

        Raises
        ------
        InputError
            If there is no such column, or it contains text.

        """
        if column not in self.rows:
            raise InputError(f"column {column!r}", ", ".join(self.rows), "choose one of these")
        try:
            return np.array([np.nan if value is None else float(value) for value in self.rows[column]])
        except ValueError as reason:
            raise InputError(f"column {column!r} with text", "a column of numbers", "choose another") from reason

    @property
    def is_done(self) -> bool:
        """Whether no row waits."""
        return WAITING not in self.rows["status"]

    def failures(self) -> dict[tuple[str, str], list[int]]:
        """Numbers of the rows that failed or did not converge, by status and message."""
        found: dict[tuple[str, str], list[int]] = {}
        for number, status, message in zip(self.rows["row"], self.rows["status"], self.rows["message"], strict=True):
            if status in ("failed", "not converged"):
                found.setdefault((str(status), str(message)), []).append(int(number or 0))
        return found


def results(database: str | Path) -> CampaignTable:
    """Read the results of a campaign so far; also while it runs.

    Parameters
    ----------
    database
        The SQLite file.

    Raises
    ------
    InputError
        If it is not there, or not the file of a campaign.

    """
    path = Path(database)
    if not path.is_file():
        raise InputError(f"database {path}, which is not there", "the file of a campaign", "run the campaign first")
    try:
        with closing(sqlite3.connect(path)) as connection:
            refuse_other_file(connection, path)
            facts = dict(connection.execute("SELECT key, value FROM meta"))
            keys = tuple(json.loads(facts["keys"]))
            names = [name for _, name, *_ in connection.execute("PRAGMA table_info(rows)")]
            inputs = json.loads(facts["inputs"])
            wanted = _wanted(names, keys, json.loads(facts["columns"]))
            rows = _columns(connection, "rows", wanted, '"row"')
            of_patches = [name for _, name, *_ in connection.execute("PRAGMA table_info(patches)")]
            patches = _columns(connection, "patches", of_patches, '"row", side, number')
    except (sqlite3.Error, KeyError) as reason:
        raise unusable(path, reason) from reason
    return CampaignTable(facts["name"], facts["case"], keys, inputs, rows, patches)


def _wanted(names: list[str], keys: tuple[str, ...], columns: list[str]) -> list[str]:
    """Columns in an order that does not depend on the order in which rows were done."""
    own = [name for name in OWN_COLUMNS if name != "identity"]
    found = [name for name in names if name not in (*OWN_COLUMNS, *keys)]
    if not set(WHEELSET_COLUMNS) <= set(names):
        found.sort()
    return [*own[:2], *keys, *(columns or found), *own[2:]]


def _columns(connection: sqlite3.Connection, table: str, names: list[str], order: str) -> Columns:
    chosen = ", ".join(quoted(name) for name in names)
    rows = connection.execute(f"SELECT {chosen} FROM {table} ORDER BY {order}").fetchall()
    return {name: [row[place] for row in rows] for place, name in enumerate(names)}


def export_writers(table: CampaignTable, kind: str) -> dict[str, Callable[[Path], None]]:
    """Return functions that write both tables, by the files' names.

    An `InputError` if it is neither. A `MissingLibraryError` if Parquet's library is not installed.

    - `table`: what to write.
    - `kind`: ``"csv"`` or ``"parquet"``.
    """
    refuse_format(kind)
    tables = {"results": table.rows, "patches": table.patches}
    if kind == "csv":
        return {f"{name}.csv": _csv_writer(columns) for name, columns in tables.items()}
    library = _parquet()
    return {f"{name}.parquet": _parquet_writer(library, columns) for name, columns in tables.items()}


def refuse_format(kind: str) -> None:
    """Refuse a format that tables are not written in, or whose library is not installed; see `export_writers`."""
    if kind not in FORMATS:
        raise InputError(f"format {kind!r}", " or ".join(FORMATS), "choose one of these")
    if kind == "parquet":
        _parquet()


def _csv_writer(columns: Columns) -> Callable[[Path], None]:
    def write(path: Path) -> None:
        with path.open("w", encoding="utf-8", newline="") as file:
            writer = csv.writer(file)
            writer.writerow(columns)
            writer.writerows(
                ["" if cell is None else cell for cell in row] for row in zip(*columns.values(), strict=True)
            )

    return write


def _parquet_writer(library: Any, columns: Columns) -> Callable[[Path], None]:
    arrow = importlib.import_module("pyarrow")

    def array(values: list[Value]) -> Any:
        kinds = {type(value) for value in values if value is not None}
        if kinds == {int, float}:
            values = [None if value is None else float(value) for value in values]
        elif len(kinds) > 1:
            values = [None if value is None else str(value) for value in values]
        return arrow.array(values) if kinds else arrow.array(values, arrow.float64())

    def write(path: Path) -> None:
        library.write_table(arrow.table({name: array(values) for name, values in columns.items()}), path)

    return write


def _parquet() -> Any:
    try:
        return importlib.import_module("pyarrow.parquet")
    except ImportError as reason:
        raise MissingLibraryError(
            "Parquet files need pyarrow, which is not installed\n  what to do: pip install 'flangeway[campaign]', or "
            "take --export csv"
        ) from reason
