"""Run a campaign: distribute the rows that are not done, compute them in chunks, and store their results."""

import re
import threading
import time
from collections import Counter, deque
from collections.abc import Callable
from dataclasses import dataclass
from itertools import pairwise
from pathlib import Path
from typing import Any

from flangeway.campaign.campaign import Campaign, Row
from flangeway.campaign.database import WAITING, CampaignDatabase, RowResult, row_of
from flangeway.cases.case import RunnableCase
from flangeway.cases.case_file import MAX_PREPARED
from flangeway.errors import FlangewayError, InputError, MissingLibraryError, unforeseen
from flangeway.system.disk_cache import LatestValues
from flangeway.system.output_folder import versions
from flangeway.system.workers import ClusterWorkers, LocalWorkers, Workers, computed, n_processes

# --- Rows that one worker computes together.


_ALONE = threading.Lock()
_prepared: LatestValues[Any] = LatestValues(MAX_PREPARED)


@dataclass(frozen=True)
class RowTask:
    """A row that a worker computes.

    - `prepared_for`: for positions of the same bodies, which are prepared once: the first row of all with these bodies.
      None: the row is computed alone.
    """

    row: Row
    prepared_for: Row | None = None


@dataclass(frozen=True)
class Outcome:
    """Result of a worker.

    - `version`: the worker's version of flangeway.
    """

    result: RowResult
    version: str


def compute(task: RowTask) -> Outcome:
    """Compute a row; one that fails reports the reason.

    A `MissingLibraryError` if the system lacks a library: then every row would fail.
    """
    with _ALONE:  # threads of one worker would share objects that are not thread-safe
        return Outcome(_result(task.row.case, task.prepared_for), versions()["flangeway"])


def _result(case: RunnableCase, first: Row | None) -> RowResult:
    """Compute a case, on the bodies prepared for a row if there is one; the time of preparing them does not count."""
    start = None
    try:
        bodies = None if first is None else _prepared.get(first.identity, first.case.prepared)
        start = time.perf_counter()
        run = case.run() if bodies is None else case.run_on(bodies)
        return row_of(case, run, time.perf_counter() - start)
    except MissingLibraryError:
        raise
    except Exception as reason:
        return _failed(reason, 0.0 if start is None else time.perf_counter() - start)


def _failed(reason: Exception, seconds: float) -> RowResult:
    lines = reason.lines if isinstance(reason, InputError) else str(reason).splitlines()
    reported = re.sub(r"\s*\n\s*", "; ", "\n".join(lines))
    return RowResult("failed", reported if isinstance(reason, FlangewayError) else unforeseen(reason), seconds=seconds)


# --- Run a campaign: distribute the rows that are not done, and store their results.


@dataclass(frozen=True)
class CampaignProgress:
    """How far a campaign is.

    - `counts`: number of rows by status: ``waiting``, ``converged``, ``not converged``, ``failed``.
    - `seconds_left`: estimated time for the other rows; None as long as this call has computed none.
    """

    n_rows: int
    counts: dict[str, int]
    seconds_left: float | None

    @property
    def n_done(self) -> int:
        """Number of rows that are done."""
        return self.n_rows - self.counts.get(WAITING, 0)

    @property
    def all_converged(self) -> bool:
        """Whether every row is done and converged."""
        return self.counts.get("converged", 0) == self.n_rows


Progress = Callable[[CampaignProgress], None]


def run_campaign(
    campaign: Campaign,
    database: str | Path,
    *,
    workers: int | None = None,
    scheduler: str | None = None,
    fresh: bool = False,
    progress: Progress = lambda _: None,
) -> CampaignProgress:
    """Compute the rows of a campaign that are not in its database yet.

    However it ends, by an error, Ctrl-C or a killed process, the rows that were reported are kept and the same call
    continues with the others. In a script it must be below ``if __name__ == "__main__":``, since worker processes
    import the script.

    Parameters
    ----------
    campaign
        What to compute.
    database
        The SQLite file, on a local disk; made if needed.
    workers
        Number of processes of this machine; as many as it has cores if left out.
    scheduler
        Address of a scheduler of `dask.distributed` whose workers compute instead.
    fresh
        Whether to drop the stored results.
    progress
        Called when rows are stored, and once at the beginning.

    Returns
    -------
    CampaignProgress
        The end.

    Raises
    ------
    InputError
        If there is no worker, the database is that of another campaign or another process writes it, the scheduler
        is not there, or its workers have another version.
    MissingLibraryError
        If the system lacks a library.
    """
    if workers is not None and scheduler is not None:
        raise InputError("workers and scheduler", "one of both", "a cluster's workers are started on its machines")
    n_most = n_processes(workers)  # before anything is written
    with CampaignDatabase(Path(database), fresh=fresh) as store:
        store.begin(campaign)
        run = _Run(campaign, store, progress)
        if run.tasks:
            n_workers = min(n_most, len(run.tasks))
            held: Workers[RowTask, Outcome] = (
                ClusterWorkers(scheduler, compute) if scheduler else LocalWorkers(n_workers, compute)
            )
            try:
                run.go(held)
            finally:
                held.stop()
        return run.report()


class _Run:
    """One call of `run_campaign`."""

    def __init__(self, campaign: Campaign, store: CampaignDatabase, progress: Progress) -> None:
        waiting = store.waiting()
        self.tasks: deque[RowTask] = deque()
        # by the number of a row, the next one of its chunk: the worker that has the bodies becomes free for it
        self._following: dict[int, RowTask] = {}
        for first, rows in campaign.chunks:
            tasks = [RowTask(row, first) for row in rows if row.number in waiting]
            self.tasks.extend(tasks[:1])
            self._following |= {task.row.number: after for task, after in pairwise(tasks)}
        self._store, self._progress = store, progress
        self._n_rows, self._n_before = len(campaign.rows), len(campaign.rows) - len(waiting)
        self._start = time.monotonic()
        self._counts = Counter(store.counts())
        self.report()

    def go(self, workers: Workers[RowTask, Outcome]) -> None:
        """Have all rows computed and each stored as it ends; a row of which its worker dies fails."""
        version = versions()["flangeway"]
        for task, outcome in computed(workers, self.tasks):
            if task.row.number in self._following:
                self.tasks.appendleft(self._following[task.row.number])
            if isinstance(outcome, Outcome):
                if outcome.version != version:
                    raise InputError(
                        f"a worker with flangeway {outcome.version}",
                        f"workers with flangeway {version}, as here",
                        "install the same version on all machines, and start the workers again",
                    )
                self._keep(task.row, outcome.result)
            else:
                self._keep(task.row, RowResult("failed", f"the worker died that computed this row: {outcome}"))

    def report(self) -> CampaignProgress:
        """Report the progress."""
        counts = dict(self._counts)
        waiting = counts.get(WAITING, 0)
        done = self._n_rows - waiting - self._n_before
        left = (time.monotonic() - self._start) / done * waiting if done else None
        now = CampaignProgress(self._n_rows, counts, left)
        self._progress(now)
        return now

    def _keep(self, row: Row, result: RowResult) -> None:
        if self._store.store(row, result):
            self._counts[WAITING] -= 1
            self._counts[result.status] += 1
        self.report()
