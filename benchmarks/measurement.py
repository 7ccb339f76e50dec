"""One measurement beside a peer, printed as one JSON line."""

import json
import time
from collections.abc import Callable
from dataclasses import dataclass
from importlib.metadata import PackageNotFoundError, version
from typing import TypeVar

Result = TypeVar("Result")


@dataclass(frozen=True)
class Measurement:
    """Times and accuracies of the same work done by flangeway and by a peer.

    Parameters
    ----------
    work
        What was done.
    peer
        Name of the peer's package.
    ours_s, peer_s
        Best times in seconds; the peer's is None if it could not be run.
    ours_accuracy, peer_accuracy
        Relative errors of a quantity known exactly.
    note
        Why the peer could not be run, or what its time leaves out.

    """

    work: str
    peer: str
    ours_s: float
    peer_s: float | None
    ours_accuracy: float
    peer_accuracy: float | None
    note: str = ""

    def line(self) -> str:
        """The JSON line."""
        return json.dumps(
            {
                "work": self.work,
                "peer": self.peer,
                "ours_s": round(self.ours_s, 5),
                "peer_s": None if self.peer_s is None else round(self.peer_s, 5),
                "ratio": None if self.peer_s is None else round(self.peer_s / self.ours_s, 2),
                "ours_accuracy": self.ours_accuracy,
                "peer_accuracy": self.peer_accuracy,
                "versions": {name: _version(name) for name in ("flangeway", "numpy", "scipy", self.peer)},
                "note": self.note,
            }
        )


def _version(name: str) -> str:
    try:
        return version(name)
    except PackageNotFoundError:
        return "not installed"


def best_time(work: Callable[[], Result], repeats: int = 5) -> tuple[float, Result]:
    """Shortest time of several repeats, and the last result."""
    best = float("inf")
    for _ in range(repeats):
        start = time.perf_counter()
        result = work()
        best = min(best, time.perf_counter() - start)
    return best, result
