"""Rows that one worker computes together."""

import re
import threading
import time
from dataclasses import dataclass
from typing import Any

from flangeway.campaign.campaign import Row
from flangeway.campaign.columns import RowResult, row_of
from flangeway.cases.case import RunnableCase
from flangeway.cases.case_identity import MAX_PREPARED
from flangeway.errors import FlangewayError, InputError, MissingLibraryError, unforeseen
from flangeway.system.latest_values import LatestValues
from flangeway.system.versions import versions
from flangeway.units import joined, with_texts

_ALONE = threading.Lock()
_prepared: LatestValues[Any] = LatestValues(MAX_PREPARED)


@dataclass(frozen=True)
class Chunk:
    """Rows that one worker computes together.

    - `prepared_for`: for positions of the same bodies, which are prepared once: the first row of all with these bodies.
      None: each row is computed alone.
    """

    rows: tuple[Row, ...]
    prepared_for: Row | None = None


@dataclass(frozen=True)
class Outcome:
    """Result of a worker.

    - `version`: the worker's version of flangeway.
    """

    results: tuple[RowResult, ...]
    version: str


def compute(chunk: Chunk) -> Outcome:
    """Compute the rows of a chunk; a row that fails reports the reason and does not stop the others.

    A `MissingLibraryError` if the system lacks a library: then every row would fail.
    """
    with _ALONE:  # threads of one worker would share objects that are not thread-safe
        return Outcome(_results(chunk), versions()["flangeway"])


def _results(chunk: Chunk) -> tuple[RowResult, ...]:
    bodies, first = None, chunk.prepared_for
    try:
        if first is not None:
            bodies = _prepared.get(first.identity, first.case.prepared)
    except MissingLibraryError:
        raise
    except Exception as reason:
        return tuple(_failed(reason, 0.0) for _ in chunk.rows)
    return tuple(_row(row.case, bodies) for row in chunk.rows)


def _row(case: RunnableCase, bodies: Any) -> RowResult:
    """Compute a case, on prepared bodies if these are not None."""
    start = time.perf_counter()
    try:
        run = case.run() if bodies is None else case.run_on(bodies)
        return row_of(case, run, time.perf_counter() - start)
    except MissingLibraryError:
        raise
    except Exception as reason:
        return _failed(reason, time.perf_counter() - start)


def _failed(reason: Exception, seconds: float) -> RowResult:
    lines = reason.lines if isinstance(reason, InputError) else str(reason).splitlines()
    reported = with_texts(joined("\n", lines), lambda text: re.sub(r"\s*\n\s*", "; ", text))
    return RowResult("failed", reported if isinstance(reason, FlangewayError) else unforeseen(reason), seconds=seconds)
