"""The SQLite file of a campaign: its rows, their results and its progress."""

import fcntl
import json
import sqlite3
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from pathlib import Path
from typing import IO

from flangeway.campaign.campaign import Campaign, Row
from flangeway.campaign.columns import (
    PATCH_COLUMNS,
    PATCH_SHEAR_COLUMNS,
    WHEELSET_COLUMNS,
    WHEELSET_SHEAR_COLUMNS,
    RowResult,
    as_cell,
)
from flangeway.cases.wheelset.wheelset_case import WheelsetCase
from flangeway.errors import InputError
from flangeway.system.versions import versions

FORMAT = "flangeway campaign 1"
WAITING = "waiting"
OWN_COLUMNS = ("row", "identity", "status", "message", "warnings")

_TABLES = """
CREATE TABLE meta (key TEXT PRIMARY KEY, value TEXT NOT NULL);
CREATE TABLE rows ("row" INTEGER PRIMARY KEY, identity TEXT NOT NULL UNIQUE, status TEXT NOT NULL,
                   message TEXT, warnings TEXT);
CREATE TABLE patches ({patches}, PRIMARY KEY ("row", side, number));
CREATE TABLE timings ("row" INTEGER PRIMARY KEY, seconds REAL NOT NULL, finished TEXT NOT NULL);
"""


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
        self._lock = _locked(path)
        try:
            self._connection = sqlite3.connect(path, isolation_level=None)
            try:
                try:
                    refuse_other_file(self._connection, path)
                except sqlite3.OperationalError:
                    raise
                except sqlite3.DatabaseError:  # a damaged file
                    if not fresh:
                        raise
                if fresh:
                    self._connection.close()
                    for ending in ("-wal", "-shm", ""):
                        path.with_name(path.name + ending).unlink(missing_ok=True)
                    self._connection = sqlite3.connect(path, isolation_level=None)
                self._connection.execute("PRAGMA journal_mode=WAL")
                self._connection.execute("PRAGMA synchronous=FULL")
            except BaseException:
                self._connection.close()
                raise
        except sqlite3.Error as reason:
            self._lock.close()
            raise unusable(path, reason) from reason
        except BaseException:
            self._lock.close()
            raise

    def __enter__(self) -> "CampaignDatabase":
        return self

    def __exit__(self, *_: object) -> None:
        self._connection.close()
        self._lock.close()

    def begin(self, campaign: Campaign) -> None:
        """Store the rows of a campaign as waiting, or make sure that they are those stored before.

        An `InputError` if the file is that of another campaign.
        """
        stored = self._stored_identity()
        if stored is None:
            self._create(campaign)
        elif stored != campaign.identity:
            raise InputError(
                f"{self.path} with results of another campaign: {self._difference(campaign)}",
                "the campaign that it was begun with",
                "take --fresh to compute all anew, or another folder with --out",
            )

    def waiting(self) -> frozenset[int]:
        """Numbers of the rows without a result."""
        found = self._connection.execute("SELECT row FROM rows WHERE status = ?", (WAITING,))
        return frozenset(number for (number,) in found)

    def counts(self) -> dict[str, int]:
        """Number of rows by status."""
        return dict(self._connection.execute("SELECT status, count(*) FROM rows GROUP BY status ORDER BY status"))

    def store(self, rows: Sequence[Row], results: Sequence[RowResult]) -> list[str]:
        """Store the results of rows, all or none; rows that have one keep it.

        Returned: status of each row that was waiting. An `InputError` if the disk does not take them.
        """
        with self._transaction():
            return [result.status for row, result in zip(rows, results, strict=True) if self._store(row, result)]

    def _store(self, row: Row, result: RowResult) -> bool:
        values = {name: value for name, value in result.values.items() if name not in row.varied}
        known = self._columns()
        for name in values:
            if name.lower() not in known:
                self._connection.execute(f"ALTER TABLE rows ADD COLUMN {quoted(name)}")
        warnings = json.dumps(list(result.warnings), ensure_ascii=False)
        cells = {"status": result.status, "message": result.message, "warnings": warnings, **values}
        changed = self._connection.execute(
            f"UPDATE rows SET {', '.join(f'{quoted(name)} = ?' for name in cells)} WHERE row = ? AND status = ?",
            (*cells.values(), row.number, WAITING),
        )
        if changed.rowcount != 1:
            return False
        for patch in result.patches:
            cells = {"row": row.number, **patch}
            self._connection.execute(
                f"INSERT INTO patches ({', '.join(map(quoted, cells))}) VALUES ({', '.join('?' * len(cells))})",
                tuple(cells.values()),
            )
        self._connection.execute(
            "INSERT INTO timings VALUES (?, ?, strftime('%Y-%m-%dT%H:%M:%fZ'))", (row.number, result.seconds)
        )
        return True

    def _create(self, campaign: Campaign) -> None:
        results = WHEELSET_COLUMNS if issubclass(campaign.case, WheelsetCase) else ()
        patches = [*PATCH_COLUMNS, *(PATCH_SHEAR_COLUMNS if campaign.shear else ())]
        columns = [*campaign.keys, *(name for name in results if name not in campaign.keys)]
        columns += WHEELSET_SHEAR_COLUMNS if campaign.shear else ()
        with self._transaction():
            for statement in _TABLES.format(patches=", ".join(map(quoted, patches))).split(";")[:-1]:
                self._connection.execute(statement)
            for name in columns:
                self._connection.execute(f"ALTER TABLE rows ADD COLUMN {quoted(name)}")
            facts = {
                "format": FORMAT,
                "identity": campaign.identity,
                "name": campaign.name,
                "case": campaign.case.name,
                "keys": json.dumps(campaign.keys),
                "columns": json.dumps(campaign.columns),
                "inputs": json.dumps(campaign.rows[0].content, ensure_ascii=False),
                "versions": json.dumps(versions()),
            }
            self._connection.executemany("INSERT INTO meta VALUES (?, ?)", facts.items())
            names = ("row", "identity", "status", *campaign.keys)
            self._connection.executemany(
                f"INSERT INTO rows ({', '.join(map(quoted, names))}) VALUES ({', '.join('?' * len(names))})",
                (
                    (row.number, row.identity, WAITING, *(as_cell(row.varied[key]) for key in campaign.keys))
                    for row in campaign.rows
                ),
            )

    def _stored_identity(self) -> str | None:
        if not self._connection.execute("SELECT 1 FROM sqlite_master WHERE name = 'meta'").fetchone():
            return None
        found = self._connection.execute("SELECT value FROM meta WHERE key = 'identity'").fetchone()
        return str(found[0])

    def _difference(self, campaign: Campaign) -> str:
        stored = {identity for (identity,) in self._connection.execute("SELECT identity FROM rows")}
        wanted = {row.identity for row in campaign.rows}
        before = self._connection.execute("SELECT value FROM meta WHERE key = 'versions'").fetchone()[0]
        version = json.loads(before)["flangeway"]
        if version != versions()["flangeway"]:
            return f"it was begun with flangeway {version}, this is {versions()['flangeway']}"
        if stored == wanted:
            return "the same rows in another order, or with other results"
        return (
            f"{len(wanted - stored)} of {len(wanted)} rows are not in it, {len(stored - wanted)} of it are not wanted"
        )

    def _columns(self) -> set[str]:
        return {name.lower() for _, name, *_ in self._connection.execute("PRAGMA table_info(rows)")}

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


def quoted(name: str) -> str:
    """Name of a column in SQL."""
    return '"' + name.replace('"', '""') + '"'


def unusable(path: Path, reason: Exception) -> InputError:
    """Return the error about a file that cannot be used."""
    return InputError(
        f"database {path}: {reason}",
        "the file of a campaign, on a local disk with room to write",
        "choose another folder with --out; rows that were reported are kept; --fresh drops a damaged file",
    )


def refuse_other_file(connection: sqlite3.Connection, path: Path) -> None:
    """Refuse a database that is not of a campaign, or of another format; one without tables is none yet."""
    tables = {name for (name,) in connection.execute("SELECT name FROM sqlite_master WHERE type = 'table'")}
    if not tables:
        return
    found = connection.execute("SELECT value FROM meta WHERE key = 'format'").fetchone() if "meta" in tables else None
    if found is None or found[0] != FORMAT:
        what = "no campaign" if found is None else repr(found[0])
        raise InputError(f"database {path}, which contains {what}", repr(FORMAT), "choose another folder with --out")


def _locked(path: Path) -> IO[bytes]:
    """Lock a file beside the database; the system unlocks it when this process ends, however it ends."""
    beside = path.with_name(f"{path.name}.lock")
    try:
        path.parent.mkdir(parents=True, exist_ok=True)
        file = beside.open("ab")
    except OSError as reason:
        raise unusable(path, reason) from reason
    try:
        fcntl.flock(file, fcntl.LOCK_EX | fcntl.LOCK_NB)
    except OSError as reason:
        file.close()
        raise InputError(
            f"database {path}, which another process writes",
            "one coordinator for a campaign",
            "wait for it to end or stop it; the same command then goes on",
        ) from reason
    return file
