"""Campaigns on a cluster: a scheduler and workers that are separate processes."""

import re
import signal
import subprocess
import sys
import time

import pytest

from flangeway.campaign import Campaign, results, run_campaign
from flangeway.campaign.campaign_run import RowTask, compute
from flangeway.errors import InputError, MissingLibraryError
from flangeway.system import workers
from tests.processes import environment

pytestmark = [pytest.mark.ci, pytest.mark.filterwarnings("ignore")]  # warnings: of the libraries of the cluster

CAMPAIGN = """
case = "wheelset-tangent"
[inputs]
size_scale = 8
[vary]
lateral_mm = [0.5, 1.0, 1.5]
inclination = [0.025, 0.03]
"""


def dask(log, *arguments):
    with log.open("w") as said:
        return subprocess.Popen(
            [sys.executable, "-m", "dask", *map(str, arguments)], stderr=said, stdout=said,
            env=environment(),
        )  # fmt: skip


@pytest.fixture
def scheduler(tmp_path, monkeypatch):
    """Start a scheduler and two workers, each a process of its own; return its address and all three.

    Nothing comes from the cache: an equilibrium that starts from a cached one differs from it in the last digits.
    """
    pytest.importorskip("distributed")
    monkeypatch.setenv("FLANGEWAY_CACHE", "off")
    log = tmp_path / "scheduler.log"
    processes = [dask(log, "scheduler", "--host", "127.0.0.1", "--port", 0, "--no-dashboard", "--no-show")]
    try:
        found = None
        while found is None:
            assert processes[0].poll() is None, log.read_text()
            time.sleep(0.05)
            found = re.search(r"Scheduler at:\s+(tcp://\S+)", log.read_text())
        for number in range(2):
            options = ("--nthreads", 1, "--no-nanny", "--no-dashboard")
            processes.append(dask(tmp_path / f"worker{number}.log", "worker", found[1], *options))
        yield found[1], processes
    finally:
        for process in processes:
            process.kill()
            process.wait()


def test_two_workers_of_a_cluster_one_of_them_killed_give_the_table_of_one_machine(scheduler, tmp_path):
    """Rows go to both workers of a cluster; one is killed on the way; each number is that of this process alone.

    To 1e-9: rows that are computed again after the kill start from another neighbour.
    """
    address, (_, *workers) = scheduler
    file = tmp_path / "c.toml"
    file.write_text(CAMPAIGN, encoding="utf-8")
    campaign = Campaign.from_file(file)
    seen = []

    def kill_one(now):
        seen.append(now.n_done)
        if now.n_done and workers[0].poll() is None:
            workers[0].send_signal(signal.SIGKILL)
            workers[0].wait()

    end = run_campaign(campaign, tmp_path / "c.sqlite", scheduler=address, progress=kill_one)
    assert workers[0].poll() == -signal.SIGKILL
    assert 0 < next(n for n in seen if n) < len(campaign.rows)
    assert end.all_converged
    assert end.n_done == 6
    found = results(tmp_path / "c.sqlite")
    for first, rows in campaign.chunks:
        for row in rows:
            for name, value in compute(RowTask(row, first)).result.values.items():
                stored = found.rows[name][row.number - 1]
                assert stored == (value if isinstance(value, str) else pytest.approx(value, rel=1e-9, abs=1e-12)), name


def test_a_scheduler_that_is_not_there_is_reported(monkeypatch, tmp_path):
    """A wrong address: the message names it, what is allowed, and how a scheduler is started."""
    pytest.importorskip("distributed")
    file = tmp_path / "c.toml"
    file.write_text(CAMPAIGN, encoding="utf-8")
    monkeypatch.setattr(workers, "CONNECT_S", 0.5)
    for address in ("tcp://127.0.0.1:9", "nonsense"):
        with pytest.raises(InputError, match="scheduler") as caught:
            run_campaign(Campaign.from_file(file), tmp_path / "c.sqlite", scheduler=address)
        assert address in caught.value.given
        assert "dask scheduler" in caught.value.advice


def test_a_scheduler_that_ends_is_told_and_rows_are_kept(scheduler, tmp_path):
    """The scheduler ends on the way: a message, and what is done is in the table."""
    address, (its_process, *_) = scheduler
    file = tmp_path / "c.toml"
    file.write_text(CAMPAIGN, encoding="utf-8")

    def end_scheduler(now):
        if now.n_done and not ended:
            ended.append(now.n_done)
            its_process.kill()

    ended = []
    start = time.monotonic()
    with pytest.raises(InputError, match="it is gone"):
        run_campaign(Campaign.from_file(file), tmp_path / "c.sqlite", scheduler=address, progress=end_scheduler)
    assert time.monotonic() - start < 300.0
    assert results(tmp_path / "c.sqlite").rows["status"].count("converged") >= ended[0] > 0


def test_a_missing_library_is_reported(monkeypatch, tmp_path):
    """Without dask the message says what to install."""
    monkeypatch.setitem(sys.modules, "distributed", None)
    file = tmp_path / "c.toml"
    file.write_text(CAMPAIGN, encoding="utf-8")
    with pytest.raises(MissingLibraryError, match=r"pip install 'flangeway\[campaign\]'"):
        run_campaign(Campaign.from_file(file), tmp_path / "c.sqlite", scheduler="tcp://127.0.0.1:8786")
