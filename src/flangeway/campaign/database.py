"""The SQLite file of a campaign: its rows, their results and its progress; and both as tables."""

import csv
import json
import sqlite3
from collections.abc import Iterable, Iterator, Mapping, Sequence
from contextlib import ExitStack, closing, contextmanager
from dataclasses import dataclass, field
from datetime import UTC, datetime
from functools import partial
from pathlib import Path
from typing import IO, Any

import numpy as np

from flangeway.campaign.campaign import Campaign, Row
from flangeway.cases.case import RunnableCase
from flangeway.cases.case_file import hash_of
from flangeway.cases.summary import RunResult, plain_numbers
from flangeway.errors import InputError
from flangeway.results import Result, ResultTable
from flangeway.system.file_content import path_of
from flangeway.system.operating_system import lock_file, optional_module
from flangeway.system.output_folder import Writer, versions
from flangeway.types import Floats
from flangeway.units import Units

# --- A row of a campaign: how it ended, and its numbers by columns.


Value = float | int | str | None


@dataclass(frozen=True)
class RowResult:
    """What one run gave.

    - `status`: ``converged``, ``not converged`` or ``failed``.
    - `message`: how it ended, in a sentence.
    - `warnings`: what limits it.
    - `values`: results by column, empty unless converged.
    - `patches`: patches by column, without the number of the row.
    - `seconds`: time that it took, its share of what is computed for several rows at once.
    """

    status: str
    message: str
    warnings: tuple[str, ...] = ()
    values: Mapping[str, Value] = field(default_factory=dict)
    patches: tuple[Mapping[str, Value], ...] = ()
    seconds: float = 0.0


def row_of(case: RunnableCase, run: RunResult, seconds: float) -> RowResult:
    """Return the numbers of a run, which its case names."""
    message, warnings = run.status.message, tuple(case.warnings_of(run))
    if not run.status.converged:
        return RowResult("not converged", message, warnings, seconds=seconds)
    # None for what is not finite; SQLite knows neither
    patches = tuple(map(plain_numbers, case.patch_rows(run)))
    return RowResult("converged", message, warnings, plain_numbers(case.row(run)), patches, seconds)


def as_cell(value: Any) -> Value:
    """Return an input as it is stored: numbers and text as they are, tables and lists as JSON."""
    if isinstance(value, bool):
        return int(value)
    if value is None or isinstance(value, float | int | str):
        return value
    return json.dumps(value, ensure_ascii=False)


# --- The SQLite file of a campaign: its rows, their results and its progress; and both as tables, for other programs.


FORMAT = "flangeway campaign 3"
WAITING = "waiting"
FORMATS = ("csv", "parquet")

Columns = dict[str, list[Value]]
StoredRow = tuple[int, str, str, str, str | None, str | None]
"""Number, identity, status, varied inputs and result in JSON, and checksum of a row."""

_TABLES = (
    "CREATE TABLE meta (key TEXT PRIMARY KEY, value TEXT NOT NULL)",
    'CREATE TABLE rows ("row" INTEGER PRIMARY KEY, identity TEXT NOT NULL UNIQUE, status TEXT NOT NULL, '
    "varied TEXT NOT NULL, result TEXT, checksum TEXT)",
    'CREATE TABLE timings ("row" INTEGER PRIMARY KEY, seconds REAL NOT NULL, finished TEXT NOT NULL)',
)


class CampaignDatabase:
    """The SQLite file of a campaign, open for writing by this process alone; use it as a context.

    Each transaction stores the results of whole rows and is on the disk before the next begins (write-ahead log,
    synchronous FULL), so a killed process or a power failure loses no row that was reported. While it is written,
    others may read it. An `InputError` if another process has it open, or it is not the file of a campaign.

    - `path`: the file; made if needed.
    - `fresh`: whether to drop its content.
    """

    def __init__(self, path: Path, *, fresh: bool = False) -> None:
        self.path = path
        with ExitStack() as opened:
            self._lock = opened.enter_context(_locked(path))
            try:
                self._connection = opened.enter_context(closing(_connected(path)))
                try:
                    refuse_other_file(self._connection, path)
                except sqlite3.DatabaseError as reason:  # a damaged file
                    if isinstance(reason, sqlite3.OperationalError) or not fresh:
                        raise
                if fresh:
                    self._connection.close()
                    for ending in ("-wal", "-shm", ""):
                        path.with_name(path.name + ending).unlink(missing_ok=True)
                    self._connection = opened.enter_context(closing(_connected(path)))
                self._connection.execute("PRAGMA journal_mode=WAL")
                self._connection.execute("PRAGMA synchronous=FULL")
            except sqlite3.Error as reason:
                raise unusable(path, reason) from reason
            self._opened = opened.pop_all()

    def __enter__(self) -> "CampaignDatabase":
        return self

    def __exit__(self, *_: object) -> None:
        self._opened.close()

    def begin(self, campaign: Campaign) -> None:
        """Store the rows of a campaign as waiting, those too that are missing in the file of this campaign.

        An `InputError` if the file is that of another campaign.
        """
        stored = _facts(self._connection).get("identity")
        if stored is None:
            self._create(campaign)
        elif stored == campaign.identity:
            with self._transaction():
                damaged = [(number,) for number in _damaged(_stored_rows(self._connection))]
                self._connection.executemany("DELETE FROM rows WHERE row = ?", damaged)
                self._insert_rows(campaign)
                # what is left of rows that somebody has deleted, or damaged
                self._connection.execute(
                    'DELETE FROM timings WHERE "row" IN (SELECT "row" FROM rows WHERE status = ?)', (WAITING,)
                )
        else:
            raise InputError(
                f"{self.path} with results of another campaign: {self._difference(campaign)}",
                "the campaign that it was begun with",
                "take --fresh to compute all anew, or another folder with --out",
            )

    def waiting(self) -> frozenset[int]:
        """Numbers of the rows without a result."""
        numbers = self._connection.execute("SELECT row FROM rows WHERE status = ?", (WAITING,))
        return frozenset(number for (number,) in numbers)

    def counts(self) -> dict[str, int]:
        """Number of rows by status."""
        return dict(self._connection.execute("SELECT status, count(*) FROM rows GROUP BY status ORDER BY status"))

    def store(self, row: Row, result: RowResult) -> bool:
        """Store the result of a row; one that has a result keeps it, and False is returned.

        An `InputError` if the disk does not take it.
        """
        with self._transaction():
            return self._store(row, result)

    def _store(self, row: Row, result: RowResult) -> bool:
        patches = [_cells(patch) for patch in result.patches]
        parts = {"message": result.message, "warnings": result.warnings, "values": _cells(result.values)}
        text = _json(parts | {"patches": patches})
        checksum = hash_of((row.number, row.identity, result.status, _json(_cells(row.varied)), text))
        changed = self._connection.execute(
            "UPDATE rows SET status = ?, result = ?, checksum = ? WHERE row = ? AND status = ?",
            (result.status, text, checksum, row.number, WAITING),
        )
        if changed.rowcount == 1:
            now = datetime.now(UTC).isoformat(timespec="milliseconds")
            self._connection.execute("INSERT INTO timings VALUES (?, ?, ?)", (row.number, result.seconds, now))
        return changed.rowcount == 1

    def _create(self, campaign: Campaign) -> None:
        facts = {
            "format": FORMAT,
            "identity": campaign.identity,
            "name": campaign.name,
            "case": campaign.case.name,
            "keys": campaign.keys,
            "columns": campaign.columns,
            "known_columns": campaign.known_columns,
            "patch_columns": campaign.patch_columns,
            "inputs": campaign.rows[0].content,
            "versions": versions(),
        }
        with self._transaction():
            for statement in _TABLES:
                self._connection.execute(statement)
            rows = ((key, _json(value)) for key, value in facts.items())
            self._connection.executemany("INSERT INTO meta VALUES (?, ?)", rows)
            self._insert_rows(campaign)

    def _insert_rows(self, campaign: Campaign) -> None:
        """Store the rows that are not there as waiting."""
        self._connection.executemany(
            "INSERT OR IGNORE INTO rows VALUES (?, ?, ?, ?, NULL, NULL)",
            ((row.number, row.identity, WAITING, _json(_cells(row.varied))) for row in campaign.rows),
        )

    def _difference(self, campaign: Campaign) -> str:
        stored = {identity for (identity,) in self._connection.execute("SELECT identity FROM rows")}
        wanted = {row.identity for row in campaign.rows}
        version = _facts(self._connection)["versions"]["flangeway"]
        if version != versions()["flangeway"]:
            return f"it was begun with flangeway {version}, this is {versions()['flangeway']}"
        if stored == wanted:
            return "the same rows in another order, or with other results"
        return (
            f"{len(wanted - stored)} of {len(wanted)} rows are not in it, {len(stored - wanted)} of it are not wanted"
        )

    @contextmanager
    def _transaction(self) -> Iterator[None]:
        try:
            self._connection.execute("BEGIN IMMEDIATE")
            try:
                yield
            except BaseException:
                self._connection.execute("ROLLBACK")
                raise
            self._connection.execute("COMMIT")
        except sqlite3.Error as reason:
            raise unusable(self.path, reason) from reason


def _connected(path: Path) -> sqlite3.Connection:
    connection = sqlite3.connect(path, isolation_level=None)
    connection.text_factory = partial(str, encoding="utf-8", errors="replace")  # a damaged text has another checksum
    return connection


def _json(value: Any) -> str:
    return json.dumps(value, ensure_ascii=False)


def _cells(values: Mapping[str, Any]) -> dict[str, Value]:
    """Values as tables have them."""
    return {name: as_cell(value) for name, value in values.items()}


def _facts(connection: sqlite3.Connection) -> dict[str, Any]:
    """What is stored of the campaign, by key; nothing in a database without tables."""
    if not connection.execute("SELECT 1 FROM sqlite_master WHERE name = 'meta'").fetchone():
        return {}
    return {key: json.loads(value) for key, value in connection.execute("SELECT key, value FROM meta")}


def _stored_rows(connection: sqlite3.Connection) -> list[StoredRow]:
    return connection.execute('SELECT * FROM rows ORDER BY "row"').fetchall()


def _damaged(rows: Iterable[StoredRow]) -> list[int]:
    """Numbers of the rows with a result that is not the one which was stored."""
    return [
        number for number, *cells, checksum in rows if cells[1] != WAITING and checksum != hash_of((number, *cells))
    ]


def unusable(path: Path, reason: Exception) -> InputError:
    """Return the error about a file that cannot be used."""
    return InputError(
        f"database {path}: {reason}",
        "the file of a campaign, on a local disk with room to write",
        "choose another folder with --out; rows that were reported are kept; --fresh drops a damaged file",
    )


def refuse_other_file(connection: sqlite3.Connection, path: Path) -> None:
    """Refuse a database that is not of a campaign, or of another format; one without tables is none yet."""
    if not connection.execute("SELECT 1 FROM sqlite_master WHERE type = 'table'").fetchone():
        return
    try:
        stored = _facts(connection).get("format", "no campaign")
    except ValueError:
        stored = "another format"
    if stored != FORMAT:
        raise InputError(f"database {path}, which contains {stored}", FORMAT, "choose another folder with --out")


def refuse_unusable(path: Path) -> None:
    """Refuse a file that is no database, or another one than of a campaign; see `refuse_other_file`."""
    try:
        with closing(_connected(path)) as connection:
            refuse_other_file(connection, path)
    except sqlite3.Error as reason:
        raise unusable(path, reason) from reason


def _locked(path: Path) -> IO[bytes]:
    """Lock a file beside the database; the system unlocks it when this process ends, however it ends."""
    beside = path.with_name(f"{path.name}.lock")
    try:
        path.parent.mkdir(parents=True, exist_ok=True)
        file = beside.open("ab")
    except OSError as reason:
        raise unusable(path, reason) from reason
    try:
        lock_file(file)
    except OSError as reason:
        file.close()
        raise InputError(
            f"database {path}, which another process writes",
            "one coordinator for a campaign",
            "wait for it to end or stop it; the same command then goes on",
        ) from reason
    return file


@dataclass(frozen=True, eq=False)
class CampaignTable(Result):
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

    @property
    def table(self) -> ResultTable:
        """The rows; those of the contacts are ``ResultTable(patches)``."""
        return ResultTable(self.rows)

    def numbers(self, column: str) -> Floats:
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
        rows_by_reason: dict[tuple[str, str], list[int]] = {}
        for number, status, message in zip(self.rows["row"], self.rows["status"], self.rows["message"], strict=True):
            if status in ("failed", "not converged"):
                rows_by_reason.setdefault((str(status), str(message)), []).append(int(number or 0))
        return rows_by_reason


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
    path = path_of("results", database)
    if not path.is_file():
        raise InputError(f"database {path}, which is not there", "the file of a campaign", "run the campaign first")
    try:
        with closing(_connected(path)) as connection:
            refuse_other_file(connection, path)
            facts, rows = _facts(connection), _stored_rows(connection)
    except (sqlite3.Error, ValueError) as reason:
        raise unusable(path, reason) from reason
    if damaged := _damaged(rows):
        raise InputError(
            f"database {path}: the numbers of row {', '.join(map(str, damaged))} are not those that were stored",
            "the file as a campaign wrote it",
            "run the campaign again: it computes these rows anew",
        )
    return _table(facts, rows)


def _table(facts: Mapping[str, Any], rows: Sequence[StoredRow]) -> CampaignTable:
    """Both tables, their columns in an order that does not depend on the order in which rows were done."""
    keys, lines, patches = tuple(facts["keys"]), list[dict[str, Any]](), list[dict[str, Any]]()
    for number, _, status, varied, text, _ in rows:
        result = {"message": None, "warnings": None, "values": {}, "patches": []} if text is None else json.loads(text)
        result["warnings"] = text and _json(result["warnings"])
        lines.append(result.pop("values") | result | {"row": number, "status": status} | json.loads(varied))
        patches += sorted(
            ({"row": number} | patch for patch in result["patches"]), key=lambda patch: (patch["side"], patch["number"])
        )
    own = ("row", "status", "message", "warnings")
    names = facts["columns"] or facts["known_columns"]
    names = names or sorted({name for line in lines for name in line} - {*own, *keys, "patches"})
    names = [*own[:2], *keys, *(name for name in names if name not in keys), *own[2:]]
    both = [
        {name: [line.get(name) for line in of_table] for name in columns}
        for columns, of_table in ((names, lines), (facts["patch_columns"], patches))
    ]
    return CampaignTable(facts["name"], facts["case"], keys, facts["inputs"], *both)


def export_writers(table: CampaignTable, kind: str, units: Units = "metric") -> dict[str, Writer]:
    """Return functions that write both tables, by the files' names.

    An `InputError` if it is neither. A `MissingLibraryError` if Parquet's library is not installed.

    - `kind`: ``"csv"`` or ``"parquet"``, which is metric.
    - `units`: units of the numbers of CSV files.
    """
    refuse_format(kind)
    tables = {"results": table.rows, "patches": table.patches}
    if kind == "csv":
        return {
            f"{name}.csv": _csv_writer(ResultTable(columns).in_units(units).columns) for name, columns in tables.items()
        }
    library = _parquet()
    return {f"{name}.parquet": _parquet_writer(library, columns) for name, columns in tables.items()}


def refuse_format(kind: str) -> None:
    """Refuse a format that tables are not written in, or whose library is not installed; see `export_writers`."""
    if kind not in FORMATS:
        raise InputError(f"format {kind!r}", " or ".join(FORMATS), "choose one of these")
    if kind == "parquet":
        _parquet()


def _csv_writer(columns: Mapping[str, Any]) -> Writer:
    def write(path: Path) -> None:
        with path.open("w", encoding="utf-8", newline="") as file:
            writer = csv.writer(file)
            writer.writerow(columns)
            writer.writerows(zip(*columns.values(), strict=True))

    return write


def _parquet_writer(library: Any, columns: Columns) -> Writer:
    import pyarrow as arrow  # noqa: PLC0415 (optional)

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
    return optional_module("pyarrow.parquet", "Parquet files need pyarrow", ", or take --export csv")
