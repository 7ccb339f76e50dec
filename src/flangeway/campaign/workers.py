"""Workers: processes of this machine, or those of a cluster, reached through a scheduler of Dask."""

import importlib
import multiprocessing
import os
import signal
import threading
from collections.abc import Callable, Iterator
from contextlib import contextmanager, suppress
from dataclasses import dataclass
from multiprocessing import resource_tracker
from multiprocessing.connection import Connection, wait
from multiprocessing.process import BaseProcess
from typing import Any, Generic, TypeVar

from flangeway.campaign.chunk import Chunk, Lost, Outcome, compute
from flangeway.errors import FlangewayError, InputError, MissingLibraryError
from flangeway.system.operating_system import interrupts_blocked, worker_start_method

Work = TypeVar("Work")
Found = TypeVar("Found")

READY = "ready"
# read when NumPy and the core are imported: one thread each, or processes wait for each other's
ONE_THREAD = {"OPENBLAS_NUM_THREADS": "1", "OMP_NUM_THREADS": "1", "MKL_NUM_THREADS": "1", "RAYON_NUM_THREADS": "1"}
STOP_S = 2.0
CONNECT_S = 10.0
CHUNKS_A_THREAD = 2
"""Chunks that wait at each thread of a worker, so that none is idle while the coordinator stores results."""
MOST_FAILED_STARTS = 3


@dataclass(eq=False)
class _Worker(Generic[Work]):
    """A process, the connection to it, and its chunk."""

    process: BaseProcess
    line: Connection
    ready: bool = False
    chunk: Work | None = None


class LocalWorkers(Generic[Work, Found]):
    """Processes of this machine, each with its own connection.

    So it is known which chunk a process computed that died. The processes end when this one does, however it ends.

    - `n_workers`: how many, one or more.
    - `compute`: what they do with a chunk, a function of a module.
    """

    def __init__(self, n_workers: int, compute: Callable[[Work], Found]) -> None:
        self._compute = compute
        # forks of a fresh process that has imported what is needed: nothing of this one comes along, and a new worker
        # is there at once
        self._context: Any = multiprocessing.get_context(worker_start_method())
        self._workers: list[_Worker[Work]] = []
        self._failed_starts = 0
        if worker_start_method() == "forkserver":
            self._context.set_forkserver_preload([compute.__module__])
            resource_tracker.ensure_running()  # it would unblock SIGINT while it starts
        try:
            for _ in range(n_workers):
                self._workers.append(self._new())
        except BaseException:
            self.stop()
            raise

    @property
    def n_free(self) -> int:
        """See `Workers`."""
        return sum(worker.ready and worker.chunk is None for worker in self._workers)

    def start(self, chunk: Work) -> None:
        """See `Workers`."""
        worker = next(worker for worker in self._workers if worker.ready and worker.chunk is None)
        worker.chunk = chunk
        with suppress(OSError):  # it has ended: reported by `finished`
            worker.line.send(chunk)

    def finished(self, seconds: float) -> list[tuple[Work, Found | Lost]]:
        """See `Workers`."""
        found: list[tuple[Work, Found | Lost]] = []
        waiting = {worker.line: worker for worker in self._workers}
        for line in wait(list(waiting), timeout=seconds):
            worker = waiting[line]  # type: ignore[index]
            try:
                message = worker.line.recv()
            except (EOFError, OSError):
                found += self._replaced(worker)
                continue
            if isinstance(message, FlangewayError):
                raise message
            if message == READY:
                worker.ready, self._failed_starts = True, 0
            elif worker.chunk is not None:
                found.append((worker.chunk, message))
                worker.chunk = None
        return found

    def stop(self) -> None:
        """See `Workers`."""
        for worker in self._workers:
            worker.process.kill()
        for worker in self._workers:
            worker.process.join(STOP_S)
            worker.line.close()  # closed before, a worker that starts would print a traceback
        self._workers.clear()

    def _new(self) -> _Worker[Work]:
        mine, its = self._context.Pipe()
        process = self._context.Process(target=_serve, args=(its, self._compute), daemon=True)
        with _environment():
            process.start()
        its.close()  # else it would stay open when the process dies
        return _Worker(process, mine)

    def _replaced(self, worker: _Worker[Work]) -> Iterator[tuple[Work, Lost]]:
        """Replace a process that ended, and return its chunk as lost."""
        worker.line.close()
        worker.process.join()
        self._failed_starts += not worker.ready
        if self._failed_starts >= MOST_FAILED_STARTS:
            raise InputError(
                f"{self._failed_starts} worker processes that ended before they began, the last one "
                f"{_ending(worker.process.exitcode)}",
                "a script that does nothing when it is imported",
                'put what your script does below a line: if __name__ == "__main__":',
            )
        self._workers[self._workers.index(worker)] = self._new()
        if worker.chunk is not None:
            yield worker.chunk, Lost(_ending(worker.process.exitcode))


def _ending(code: int | None) -> str:
    if code is not None and code < 0:
        return f"killed by signal {-code}, {signal.Signals(-code).name}"
    return f"ended with status {code}"


@contextmanager
def _environment() -> Iterator[None]:
    """Set the variables of a new process that the user has not set, and block Ctrl-C in it, also while it imports."""
    missing = [name for name in ONE_THREAD if name not in os.environ]
    os.environ.update({name: ONE_THREAD[name] for name in missing})
    try:
        with interrupts_blocked():
            yield
    finally:
        for name in missing:
            os.environ.pop(name, None)


def _serve(line: "Connection[Any, Any]", compute: Callable[[Any], Any]) -> None:
    """Compute what comes over the line until it ends; the life of a worker."""
    signal.signal(signal.SIGINT, signal.SIG_IGN)  # Ctrl-C is for the coordinator
    threading.Thread(target=_end_with_parent, daemon=True).start()
    with suppress(EOFError, ConnectionError):  # the coordinator has ended
        line.send(READY)
        while True:
            chunk = line.recv()
            try:
                line.send(compute(chunk))
            except FlangewayError as reason:
                line.send(reason)


def _end_with_parent() -> None:
    parent = multiprocessing.parent_process()
    if parent is not None:
        wait([parent.sentinel])
        os._exit(1)


class ClusterWorkers:
    """Workers of a scheduler of `dask.distributed`; they may come and go while the campaign runs.

    A `MissingLibraryError` if the library is not installed. An `InputError` if nothing answers at the address.

    - `address`: where the scheduler listens: ``tcp://host:8786``.
    """

    def __init__(self, address: str) -> None:
        self._dask = _distributed()
        self._address = address
        try:
            self._client = self._dask.Client(address, timeout=CONNECT_S, set_as_default=False)
        except (OSError, ValueError, TypeError) as reason:
            raise self._unreachable(f"{reason}".partition("\n")[0]) from reason
        self._chunks: dict[Any, Chunk] = {}
        self._done = threading.Event()

    @property
    def n_free(self) -> int:
        """See `Workers`."""
        try:
            threads = sum(self._client.nthreads().values())
        except OSError as reason:
            raise self._unreachable("it is gone") from reason
        return max(CHUNKS_A_THREAD * threads - len(self._chunks), 0)

    def start(self, chunk: Chunk) -> None:
        """See `Workers`."""
        # not pure: the name of a task is not made of what it computes, a lost chunk may come again
        future = self._client.submit(compute, chunk, pure=False)
        self._chunks[future] = chunk
        future.add_done_callback(lambda _: self._done.set())

    def finished(self, seconds: float) -> list[tuple[Chunk, Outcome | Lost]]:
        """See `Workers`."""
        if self._done.wait(seconds):
            self._done.clear()
        if self._client.status != "running":
            raise self._unreachable("it is gone")
        return [(self._chunks.pop(future), self._outcome(future)) for future in list(self._chunks) if future.done()]

    def stop(self) -> None:
        """See `Workers`."""
        if self._client.status == "running":
            self._client.cancel(list(self._chunks), force=True)
        self._chunks.clear()
        self._client.close(timeout=2.0)

    def _outcome(self, future: Any) -> Outcome | Lost:
        try:
            outcome = future.result()
        except self._dask.KilledWorker as reason:
            return Lost(f"{reason}".partition("\n")[0], workers=reason.allowed_failures + 1)
        except self._dask.CancelledError as reason:
            raise self._unreachable("it is gone") from reason
        except FlangewayError:
            raise
        except Exception as reason:
            raise InputError(
                f"a worker of {self._address} that cannot compute: {type(reason).__name__}: {reason}",
                "workers with the same flangeway, and your own cases, as here",
                "install them there, and start the workers again",
            ) from reason
        if not isinstance(outcome, Outcome):
            raise TypeError("a worker gives an outcome")
        return outcome

    def _unreachable(self, reason: str) -> InputError:
        return InputError(
            f"scheduler {self._address}: {reason}",
            "the address of a scheduler that runs, such as tcp://host:8786",
            "start one with `dask scheduler`; it prints its address. Rows that are done are kept: "
            "the same command goes on",
        )


def _distributed() -> Any:
    try:
        return importlib.import_module("distributed")
    except ImportError as reason:
        raise MissingLibraryError(
            "a campaign on a cluster needs dask.distributed, which is not installed\n"
            "  what to do: pip install 'flangeway[campaign]'; without --scheduler processes of this machine compute"
        ) from reason
