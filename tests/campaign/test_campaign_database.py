"""Tables of a campaign are the same however it ran, and a damaged database is mended or refused."""

import sqlite3
from contextlib import closing
from pathlib import Path

import pytest

from flangeway import InputError
from flangeway.campaign import results
from flangeway.campaign.database import export_writers
from tests.campaign.conftest import computed

CAMPAIGN = (
    'case = "torsion"\n[inputs]\nsection = "60E1"\nsize = 20.0\n[vary]\norder = [1, 2]\nmethod = ["fem", "vem"]\n'
)


def exported(database: Path) -> bytes:
    file = database.with_name("results.csv")
    export_writers(results(database), "csv")["results.csv"](file)
    return file.read_bytes()


def change(database: Path, statement: str) -> None:
    with closing(sqlite3.connect(database)) as connection:
        connection.execute(statement)
        connection.commit()


@pytest.fixture(scope="module")
def database(tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("campaign")
    computed(folder, CAMPAIGN)
    return folder / "c.sqlite"


def test_nothing_of_the_run_is_in_the_results(database: Path) -> None:
    """No column depends on the machine or on what it computed before."""
    names = list(results(database).rows)
    assert any("torsion_constant" in name for name in names)
    assert not [name for name in names if "memory" in name or "timing" in name or "seconds" in name]


def test_deleted_rows_are_computed_again(database: Path) -> None:
    """A row that was deleted waits, and its result is byte for byte the same."""
    before = exported(database)
    change(database, 'DELETE FROM rows WHERE "row" IN (2, 3)')
    assert exported(database) != before
    computed(database.parent, CAMPAIGN)
    assert exported(database) == before


@pytest.mark.parametrize("cell", ["'1.2.3'", "x'00ff'"])
def test_a_broken_number_is_refused(database: Path, cell: str) -> None:
    """The message names the row and the column."""
    column = next(name for name in results(database).rows if "torsion_constant" in name)
    with closing(sqlite3.connect(database)) as connection:
        (kept,) = connection.execute(f'SELECT "{column}" FROM rows WHERE "row" = 1').fetchone()
    change(database, f'UPDATE rows SET "{column}" = {cell} WHERE "row" = 1')
    with pytest.raises(InputError, match=f"row 1 .*{column}"):
        results(database)
    change(database, f'UPDATE rows SET "{column}" = {kept!r} WHERE "row" = 1')
    assert results(database).is_done
