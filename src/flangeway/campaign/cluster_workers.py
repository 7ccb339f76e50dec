"""Workers of a cluster, reached through a scheduler of Dask."""

import importlib
import threading
from typing import Any

from flangeway.campaign.chunk import Chunk, Lost, Outcome, compute
from flangeway.errors import FlangewayError, InputError, MissingLibraryError

CONNECT_S = 10.0
CHUNKS_A_THREAD = 2
"""Chunks that wait at each thread of a worker, so that none is idle while the coordinator stores results."""


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
