"""Campaigns that are killed, interrupted, or lose workers: nothing is lost, nothing is twice in the table."""

import json
import os
import re
import signal
import sqlite3
import subprocess
import sys
import time
from pathlib import Path

import pytest

from flangeway.campaign.database import CampaignDatabase
from flangeway.errors import InputError
from tests.processes import environment

SYNTHETIC = '''
"""A case that takes a moment, and one that kills its worker."""
import os, pathlib, signal, time
from dataclasses import dataclass
from typing import Any, ClassVar
from pydantic import Field
from flangeway.solve import Status
from flangeway.cases.case import (RunnableCase)
from flangeway.cases.case_file import CASES

@dataclass
class SumRun:
    case: Any
    status: Status
    summary: dict

class SumCase(RunnableCase):
    name: ClassVar[str] = "sum"
    title: ClassVar[str] = "A sum"
    a: float = Field(0.0, le=1000.0)
    b: float = 0.0
    deadly: bool = False
    folder: str = ""
    def check(self): pass
    def run(self, progress=lambda _: None):
        if self.folder:
            with open(pathlib.Path(self.folder, f"{self.a:g}"), "a") as file: file.write("x")
        if self.deadly and self.a == 3: os.kill(os.getpid(), signal.SIGKILL)
        if self.a == 7: raise ValueError("seven cannot be summed")
        time.sleep(float(os.environ.get("SUM_SECONDS", "0")))
        status = Status(self.a != 5, "five does not converge" if self.a == 5 else "done", 1)
        return SumRun(self, status, {"total": self.a + self.b / 3.0})

CASES["sum"] = SumCase
'''

DRIVER = '''
import os, random, signal, sys, time
import sum_case
from flangeway.campaign import Campaign, run_campaign

def one(file, database, reported=None):
    def progress(now):
        if reported is not None: os.write(reported, b"x" if now.n_done else b"0")
    run_campaign(Campaign.from_file(file), database, workers=2, progress=progress)

def killed(file, database, chance, after_rows):
    """Start a coordinator and kill it at a random instant; whether it still ran."""
    reader, writer = os.pipe()
    before = len(os.sched_getaffinity(0))
    child = os.fork()
    if child == 0:
        os.close(reader)
        one(file, database, writer)
        os._exit(0)
    os.close(writer)
    if after_rows:  # the report at the start names rows that were done before
        os.read(reader, 1)
        os.read(reader, 1)
    time.sleep(chance.uniform(0.0, 0.2 if after_rows else 0.4))
    os.kill(child, signal.SIGKILL)
    _, status = os.waitpid(child, 0)
    os.close(reader)
    return os.WIFSIGNALED(status)

if __name__ == "__main__":
    file, database, n_kills = sys.argv[1], sys.argv[2], int(sys.argv[3])
    chance = random.Random(5)
    hits = sum(killed(file, database, chance, number % 5 == 4) for number in range(n_kills))
    print(hits, flush=True)
    one(file, database)
'''


@pytest.fixture
def synthetic(tmp_path):
    """Write the synthetic case and its driver; return a function that runs the driver."""
    (tmp_path / "sum_case.py").write_text(SYNTHETIC, encoding="utf-8")
    (tmp_path / "drive.py").write_text(DRIVER, encoding="utf-8")

    def run(file, database, n_kills=0, **others):
        done = subprocess.run(
            [sys.executable, "drive.py", file, database, str(n_kills)],
            cwd=tmp_path, capture_output=True, text=True, check=False, timeout=300, env=environment(tmp_path, **others),
        )  # fmt: skip
        assert done.returncode == 0, done.stderr
        return done.stdout

    return run


def tables(database):
    """Rows of a database with their results, without the times."""
    with sqlite3.connect(database) as connection:
        assert connection.execute("PRAGMA integrity_check").fetchone() == ("ok",)
        found = connection.execute("SELECT * FROM rows ORDER BY 1").fetchall()
        timed = connection.execute("SELECT count(*) FROM timings").fetchone()[0]
    assert timed == len(found)
    return found


@pytest.mark.ci
def test_twenty_kills_at_random_instants_leave_the_table_of_an_undisturbed_run(synthetic, tmp_path):
    """Twenty coordinators are killed, in their start and while they store rows; the table is the same, exactly.

    Only those rows are computed again that were not stored yet.
    """
    (tmp_path / "calls").mkdir()
    folder = json.dumps(str(tmp_path / "calls"))
    (tmp_path / "c.toml").write_text(
        f'case = "sum"\n[inputs]\nfolder = {folder}\n[vary]\na = {{ from = 1, to = 100, n = 100 }}\n'
    )
    hits = synthetic("c.toml", "killed.sqlite", 20, SUM_SECONDS="0.03")
    assert int(hits) == 20
    calls = [len(path.read_text()) for path in (tmp_path / "calls").iterdir()]
    assert len(calls) == 100
    # two workers had a row each, and each may have had the next before the last one was stored
    assert 100 <= sum(calls) <= 100 + 20 * 4
    synthetic("c.toml", "whole.sqlite")
    assert tables(tmp_path / "killed.sqlite") == tables(tmp_path / "whole.sqlite")
    rows = tables(tmp_path / "whole.sqlite")
    statuses = [row[2] for row in rows]
    assert (len(rows), statuses.count("converged"), statuses.count("failed")) == (100, 98, 1)


def test_a_row_that_kills_its_workers_fails_with_the_reason_and_the_rest_goes_on(synthetic, tmp_path):
    """A row of which its worker dies alone is failed and says so; errors and missing equilibria do not stop others."""
    (tmp_path / "c.toml").write_text(
        'case = "sum"\n[inputs]\ndeadly = true\n[vary]\na = [1, 2, 3, 4, 5, 6, 7, 8]\n', encoding="utf-8"
    )
    synthetic("c.toml", "c.sqlite")
    rows = tables(tmp_path / "c.sqlite")
    reported = {json.loads(row[3])["a"]: (row[2], json.loads(row[4])["message"]) for row in rows}
    assert [reported[a][0] for a in (1, 2, 4, 6, 8)] == ["converged"] * 5
    assert reported[3][0] == "failed"
    assert "worker died" in reported[3][1]
    assert reported[5] == ("not converged", "five does not converge")
    assert reported[7][0] == "failed"
    assert reported[7][1].startswith("internal error, ValueError (seven cannot be summed) in ")


MAIN = """
import sum_case
from flangeway.cli import main
main()
"""


def start(folder, *arguments, own_group=False):
    """Start the command with the synthetic case known to it."""
    return subprocess.Popen(
        [sys.executable, "-c", MAIN, "campaign", *map(str, arguments)], cwd=folder, text=True,
        stdout=subprocess.PIPE, stderr=subprocess.PIPE, env=environment(folder, SUM_SECONDS="0.1"),
        start_new_session=own_group,
    )  # fmt: skip


def wait_for_rows(database, n_rows, process):
    """Wait until some rows are done."""
    deadline = time.monotonic() + 300.0
    while time.monotonic() < deadline:
        time.sleep(0.05)
        assert process.poll() is None, process.communicate()
        if database.is_file():
            with sqlite3.connect(database) as connection:
                if connection.execute("SELECT 1 FROM sqlite_master WHERE name = 'timings'").fetchone():
                    (done,) = connection.execute("SELECT count(*) FROM timings").fetchone()
                    if done >= n_rows:
                        return
    raise AssertionError("no rows")


def workers_of(process):
    """Ids of the worker processes of a coordinator: children of the server that forks them."""
    below = children(process.pid)
    return [pid for child in below for pid in children(child)]


def children(pid):
    return [int(child) for child in Path(f"/proc/{pid}/task/{pid}/children").read_text().split()]


def is_alive(pid):
    stat = Path(f"/proc/{pid}/stat")
    try:
        return stat.read_text().rpartition(")")[2].split()[0] != "Z"
    except OSError:
        return False


def n_done(database):
    with sqlite3.connect(database) as connection:
        return connection.execute("SELECT count(*) FROM rows WHERE status != 'waiting'").fetchone()[0]


@pytest.mark.ci
def test_the_command_is_killed_refused_interrupted_and_goes_on(synthetic, tmp_path, interruptible):
    """Workers die with a killed coordinator; a second one is refused; Ctrl-C keeps what is done; then all is done."""
    file, database = tmp_path / "c.toml", tmp_path / "out" / "c" / "campaign.sqlite"
    file.write_text('case = "sum"\n[vary]\na = { from = 11, to = 70, n = 60 }\n', encoding="utf-8")
    first = start(tmp_path, file)
    wait_for_rows(database, 1, first)
    with pytest.raises(InputError, match="another process writes"):
        CampaignDatabase(database)
    workers = workers_of(first)
    assert len(workers) == len(os.sched_getaffinity(0))
    first.kill()
    first.communicate(timeout=300)
    deadline = time.monotonic() + 120.0
    while any(map(is_alive, workers)):
        assert time.monotonic() < deadline, "workers outlived the coordinator"
        time.sleep(0.05)

    before = n_done(database)
    interrupted = start(tmp_path, file)
    wait_for_rows(database, before + 1, interrupted)
    interrupted.send_signal(signal.SIGINT)
    out, err = interrupted.communicate(timeout=300)
    assert interrupted.returncode == 130
    assert "goes on from there" in err
    assert "Traceback" not in err
    assert out == ""
    assert before < n_done(database) < 60

    last = start(tmp_path, file)
    out, err = last.communicate(timeout=300)
    assert last.returncode == 0, err
    assert "60 converged" in out
    assert re.search(r"\d+ of 60 rows; (time left not known yet|\d+:\d\d:\d\d left|done)", err)


def test_an_interruption_while_workers_start_prints_no_traceback(synthetic, tmp_path, interruptible):
    """Ctrl-C goes to all processes of the terminal; those that are still importing end without a traceback."""
    (tmp_path / "c.toml").write_text('case = "sum"\n[vary]\na = { from = 11, to = 70, n = 60 }\n', encoding="utf-8")
    process = start(tmp_path, tmp_path / "c.toml", own_group=True)
    deadline = time.monotonic() + 300.0
    while len(children(process.pid)) < 2:  # the server of forks and the tracker of resources
        assert time.monotonic() < deadline
        time.sleep(0.002)
    time.sleep(0.1)
    os.killpg(process.pid, signal.SIGINT)
    _, err = process.communicate(timeout=300)
    assert process.returncode == 130
    assert "Traceback" not in err
