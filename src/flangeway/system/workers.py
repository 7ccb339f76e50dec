"""Workers: processes of this machine, or those of a cluster, reached through a scheduler of Dask."""

import multiprocessing
import os
import signal
import threading
from abc import ABC, abstractmethod
from collections import deque
from collections.abc import Callable, Iterator, Sequence
from concurrent.futures import FIRST_COMPLETED, CancelledError, Future, ProcessPoolExecutor, wait
from concurrent.futures.process import BrokenProcessPool
from contextlib import contextmanager
from multiprocessing import resource_tracker
from multiprocessing.connection import wait as wait_for
from typing import Any, Generic, TypeVar

from flangeway.errors import FlangewayError, InputError
from flangeway.system.operating_system import (
    environment,
    interrupts_blocked,
    number_of_cores,
    optional_module,
    worker_start_method,
)

Work = TypeVar("Work")
Found = TypeVar("Found")

# read when NumPy and the core are imported: one thread each, or processes wait for each other's
ONE_THREAD = {"OPENBLAS_NUM_THREADS": "1", "OMP_NUM_THREADS": "1", "MKL_NUM_THREADS": "1", "RAYON_NUM_THREADS": "1"}
CONNECT_S = 10.0  # time for a scheduler to answer
CLOSE_S = 2.0  # time to part from a scheduler
POLL_S = 1.0  # time between two looks at a cluster, whose workers come and go
CHUNKS_PER_THREAD = 2
"""Chunks that wait at each thread of a cluster, so that none is idle while the coordinator stores results."""


def n_processes(workers: int | None) -> int:
    """Number of processes to take: as many as cores if none is given; an `InputError` below one."""
    if workers is not None and workers < 1:
        raise InputError(f"workers = {workers}", "one worker or more", "leave it out to use all cores")
    return workers or number_of_cores()


class LostWorkerError(Exception):
    """A worker died; `certain` if it is known that it died of this work, not of what another worker computed."""

    def __init__(self, reason: str, *, certain: bool) -> None:
        super().__init__(reason)
        self.certain = certain


class Workers(ABC, Generic[Work, Found]):
    """Those who compute."""

    @property
    @abstractmethod
    def n_at_once(self) -> int:
        """How many works may be under way; an `InputError` if the workers cannot be reached any more."""

    @abstractmethod
    def submit(self, work: Work) -> "Future[Found]":
        """Have a work computed."""

    @abstractmethod
    def result(self, future: "Future[Found]") -> Found:
        """Return a result, or raise `LostWorkerError`."""

    @abstractmethod
    def stop(self) -> None:
        """End all that still runs; what it computes is dropped."""


def computed(workers: Workers[Work, Found], queue: deque[Work]) -> Iterator[tuple[Work, Found | LostWorkerError]]:
    """Have all works of a queue computed, and yield them with their results in the order in which these come.

    Where a worker dies, all that was under way is computed again, each alone: so it is known of which it dies. That one
    comes with the error. The caller may put works into the queue meanwhile.
    """
    running: dict[Future[Found], Work] = {}
    suspects: deque[Work] = deque()
    is_alone = False
    while queue or suspects or running:
        if suspects and not running:
            work, is_alone = suspects.popleft(), True
            running[workers.submit(work)] = work
        while queue and not suspects and not (is_alone and running) and len(running) < workers.n_at_once:
            is_alone = False
            work = queue.popleft()
            running[workers.submit(work)] = work
        workers.n_at_once  # noqa: B018 (refuses to wait for a scheduler that is gone)
        for future in wait(running, timeout=POLL_S, return_when=FIRST_COMPLETED).done:
            work = running.pop(future)
            result: Found | LostWorkerError
            try:
                result = workers.result(future)
            except LostWorkerError as reason:
                if not (is_alone or reason.certain):
                    suspects.append(work)
                    continue
                result = reason
            yield work, result


class LocalWorkers(Workers[Work, Found]):
    """Processes of this machine, which end when this one does, however it ends.

    - `n_workers`: how many, one or more.
    - `compute`: what they do with a work, a function of a module.
    """

    def __init__(self, n_workers: int, compute: Callable[[Work], Found]) -> None:
        self._n_workers, self._compute = n_workers, compute
        # forks of a fresh process that has imported what is needed: nothing of this one comes along, and a new worker
        # is there at once
        self._context: Any = multiprocessing.get_context(worker_start_method())
        if worker_start_method() == "forkserver":
            self._context.set_forkserver_preload([compute.__module__])
            resource_tracker.ensure_running()  # it would unblock SIGINT while it starts
        self._others = set(multiprocessing.active_children())
        self._pool = self._new()
        try:
            self._started(_ready).result()
        except BrokenProcessPool as reason:
            raise InputError(
                "worker processes that ended before they began",
                "a script that does nothing when it is imported",
                'put what your script does below a line: if __name__ == "__main__":',
            ) from reason
        except BaseException:
            self.stop()
            raise

    @property
    def n_at_once(self) -> int:
        """See `Workers`."""
        return self._n_workers

    def submit(self, work: Work) -> "Future[Found]":
        """See `Workers`."""
        try:
            return self._started(self._compute, work)
        except BrokenProcessPool:
            self._pool = self._new()
            return self._started(self._compute, work)

    def result(self, future: "Future[Found]") -> Found:
        """See `Workers`."""
        try:
            return future.result()
        except BrokenProcessPool as reason:
            raise LostWorkerError("its process was killed, for example for lack of memory", certain=False) from reason

    def stop(self) -> None:
        """See `Workers`."""
        for process in set(multiprocessing.active_children()) - self._others:
            process.kill()
        # waits for the pool's thread, which ends with its processes: while that one closes its pipes the interpreter
        # must not end, or it writes to a closed pipe and prints a traceback
        self._pool.shutdown(cancel_futures=True)

    def _new(self) -> ProcessPoolExecutor:
        return ProcessPoolExecutor(self._n_workers, mp_context=self._context, initializer=_begin)

    def _started(self, work: Callable[..., Any], *arguments: Any) -> "Future[Any]":
        with _environment():  # a process may begin here
            return self._pool.submit(work, *arguments)


def computed_here(
    works: Sequence[Work], compute: Callable[[Work], Found], n_workers: int
) -> Iterator[tuple[Work, Found | LostWorkerError]]:
    """Have works computed by processes of this machine, as `computed` does, or by this one if one is enough.

    - `compute`: a function of a module.
    - `n_workers`: number of processes, at most.
    """
    n_workers = min(n_workers, len(works))
    if n_workers < 2:
        yield from ((work, compute(work)) for work in works)
        return
    workers = LocalWorkers(n_workers, compute)
    try:
        yield from computed(workers, deque(works))
    finally:
        workers.stop()


@contextmanager
def _environment() -> Iterator[None]:
    """Set the variables of a new process that the user has not set, and block Ctrl-C in it, also while it imports."""
    missing = {name: value for name, value in ONE_THREAD.items() if name not in os.environ}
    with environment(missing), interrupts_blocked():
        yield


def _begin() -> None:
    """Begin the life of a worker."""
    signal.signal(signal.SIGINT, signal.SIG_IGN)  # Ctrl-C is for the coordinator
    threading.Thread(target=_end_with_parent, daemon=True).start()


def _ready() -> None:
    """Show that a worker has begun."""


def _end_with_parent() -> None:
    parent = multiprocessing.parent_process()
    if parent is not None:
        wait_for([parent.sentinel])
        os._exit(1)


class ClusterWorkers(Workers[Work, Found]):
    """Workers of a scheduler of `dask.distributed`; they may come and go while the campaign runs.

    A `MissingLibraryError` if the library is not installed. An `InputError` if nothing answers at the address.

    - `address`: where the scheduler listens: ``tcp://host:8786``.
    - `compute`: what they do with a work, a function of a module.
    """

    def __init__(self, address: str, compute: Callable[[Work], Found]) -> None:
        self._dask, self._address, self._compute = _distributed(), address, compute
        try:
            self._client = self._dask.Client(address, timeout=CONNECT_S, set_as_default=False)
        except (OSError, ValueError, TypeError) as reason:
            raise self._unreachable(f"{reason}".partition("\n")[0]) from reason
        # not pure: the name of a task is not made of what it computes, a lost work may come again
        self._executor = self._client.get_executor(pure=False)

    @property
    def n_at_once(self) -> int:
        """See `Workers`."""
        if self._client.status != "running":
            raise self._unreachable("it is gone")
        try:
            return CHUNKS_PER_THREAD * sum(self._client.nthreads().values())
        except OSError as reason:
            raise self._unreachable("it is gone") from reason

    def submit(self, work: Work) -> "Future[Found]":
        """See `Workers`."""
        future: Future[Found] = self._executor.submit(self._compute, work)
        return future

    def result(self, future: "Future[Found]") -> Found:
        """See `Workers`; the scheduler itself has tried again until it is certain."""
        try:
            return future.result()
        except self._dask.KilledWorker as reason:
            raise LostWorkerError(f"{reason}".partition("\n")[0], certain=True) from reason
        except CancelledError as reason:
            raise self._unreachable("it is gone") from reason
        except FlangewayError:
            raise
        except Exception as reason:
            raise InputError(
                f"a worker of {self._address} that cannot compute: {type(reason).__name__}: {reason}",
                "workers with the same flangeway, and your own cases, as here",
                "install them there, and start the workers again",
            ) from reason

    def stop(self) -> None:
        """See `Workers`."""
        if self._client.status == "running":
            self._executor.shutdown(wait=False)
        self._client.close(timeout=CLOSE_S)

    def _unreachable(self, reason: str) -> InputError:
        return InputError(
            f"scheduler {self._address}: {reason}",
            "the address of a scheduler that runs, such as tcp://host:8786",
            "start one with `dask scheduler`; it prints its address. Rows that are done are kept: "
            "the same command goes on",
        )


def _distributed() -> Any:
    remedy = "; without --scheduler processes of this machine compute"
    return optional_module("distributed", "a campaign on a cluster needs dask.distributed", remedy)
