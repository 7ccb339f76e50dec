"""What the coordinator asks of its workers, be they processes of this machine or of a cluster."""

from dataclasses import dataclass
from typing import Protocol

from flangeway.campaign.chunk import Chunk, Outcome


@dataclass(frozen=True)
class Lost:
    """A worker died while it computed a chunk.

    Parameters
    ----------
    reason
        What is known of it, in a sentence.
    workers
        How many died of it.

    """

    reason: str
    workers: int = 1


class Workers(Protocol):
    """Those who compute chunks."""

    @property
    def n_free(self) -> int:
        """How many chunks may be started now."""

    def start(self, chunk: Chunk) -> None:
        """Have a chunk computed."""

    def finished(self, seconds: float) -> list[tuple[Chunk, Outcome | Lost]]:
        """Wait for chunks that are done or lost, at most some seconds.

        Raises
        ------
        MissingLibraryError
            If the system of a worker lacks a library.

        """

    def stop(self) -> None:
        """End all that still runs; what it computes is dropped."""
