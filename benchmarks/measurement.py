"""One measurement beside a peer, printed as one JSON line, and programs that take turns."""

import json
import time
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any, TypeVar

from benchmarks.peers import PeerMissingError
from flangeway.system.output_folder import version_of

Result = TypeVar("Result")

NO_PEER = "none"
"""Peer of what is measured for flangeway alone."""
ITSELF = "flangeway"
"""Peer of what is measured beside another way of the same program."""
OWN = ("flangeway", "numpy", "scipy")
"""Packages of flangeway whose versions are kept with each measurement."""


@dataclass(frozen=True)
class Measurement:
    """Times and accuracies of the same work done by flangeway and by a peer.

    Parameters
    ----------
    work
        What was done.
    peer
        Name of the peer, or `NO_PEER` or `ITSELF`.
    ours_s, peer_s
        Best times in seconds; the peer's is None if it could not be run.
    ours_accuracy, peer_accuracy
        Relative errors of a quantity known exactly; None where the work has none.
    note
        Why the peer could not be run, or what its time leaves out.
    peer_version
        The peer's version; left out: that of the package of its name.
    asked
        The least ratio that flangeway is to reach, if there is one.
    more
        What else was measured, by name.

    """

    work: str
    peer: str
    ours_s: float
    peer_s: float | None
    ours_accuracy: float | None
    peer_accuracy: float | None
    note: str = ""
    peer_version: str | None = None
    asked: float | None = None
    more: Mapping[str, Any] = field(default_factory=dict)

    @property
    def ratio(self) -> float | None:
        """The peer's time over ours."""
        return None if self.peer_s is None else self.peer_s / self.ours_s

    def record(self) -> dict[str, Any]:
        """All that is printed."""
        versions = {name: version_of(name) for name in OWN}
        if self.peer != NO_PEER:
            versions[self.peer] = self.peer_version or version_of(self.peer)
        result = {
            "work": self.work,
            "peer": self.peer,
            "ours_s": round(self.ours_s, 5),
            "peer_s": None if self.peer_s is None else round(self.peer_s, 5),
            "ratio": None if self.ratio is None else round(self.ratio, 2),
            "ours_accuracy": self.ours_accuracy,
            "peer_accuracy": self.peer_accuracy,
            "versions": versions,
            "note": self.note,
        }
        if self.asked is not None:
            result["asked"] = self.asked
        return result | dict(self.more)

    def line(self) -> str:
        """The JSON line."""
        return json.dumps(self.record())


def timed(work: Callable[[], Result], clock: Callable[[], float] = time.perf_counter) -> tuple[float, Result]:
    """Seconds on the clock, or on another one such as that of the processor, and the result."""
    start = clock()
    result = work()
    return clock() - start, result


def best_time(
    work: Callable[[], Result], repeats: int = 5, clock: Callable[[], float] = time.perf_counter
) -> tuple[float, Result]:
    """Shortest time of several repeats, and the last result."""
    best = float("inf")
    for _ in range(repeats):
        seconds, result = timed(work, clock)
        best = min(best, seconds)
    return best, result


def fastest_in_turns(
    jobs: Mapping[str, Callable[[], Result]], rounds: Mapping[str, int], seconds: Callable[[Result], float]
) -> dict[str, Result | PeerMissingError]:
    """Run jobs in turns, so that a busy machine slows all of them; return the fastest result of each.

    Parameters
    ----------
    jobs
        What is run, by name.
    rounds
        How often each is run.
    seconds
        The time that a result took.

    """
    best: dict[str, Result | PeerMissingError] = {}
    for number in range(max(rounds.values())):
        for name, job in jobs.items():
            known = best.get(name)
            if number >= rounds[name] or isinstance(known, PeerMissingError):
                continue
            try:
                result = job()
            except PeerMissingError as error:
                best[name] = error
                continue
            if known is None or seconds(result) < seconds(known):
                best[name] = result
    return best


def taken(run: Result | PeerMissingError) -> Result:
    """A result of `fastest_in_turns` that takes no peer, or whose peer is known to be there."""
    assert not isinstance(run, PeerMissingError)
    return run


def fastest(runs: Sequence[Result | PeerMissingError], seconds: Callable[[Result], float]) -> Result | PeerMissingError:
    """The fastest of several runs of one peer, or that it is missing."""
    missing = next((run for run in runs if isinstance(run, PeerMissingError)), None)
    return missing or min((taken(run) for run in runs), key=seconds)
