"""Rows that one worker computes together."""

import threading
import time
from dataclasses import dataclass

from flangeway.campaign.campaign import Row
from flangeway.campaign.columns import RowResult, summary_row, wheelset_row
from flangeway.campaign.position_rows import position_rows
from flangeway.cases.case import RunnableCase
from flangeway.cases.wheelset.wheelset_case import WheelsetCase
from flangeway.errors import FlangewayError, MissingLibraryError, unforeseen
from flangeway.railway.wheelset.wheelset_result import solve_wheelset
from flangeway.system.versions import versions

_ALONE = threading.Lock()


@dataclass(frozen=True)
class Chunk:
    """Rows that one worker computes together.

    Parameters
    ----------
    rows
        The rows.
    prepared_for
        For positions of the same bodies, which are prepared once: the first row of all with these bodies. None: each
        row is computed alone.
    losses
        How many workers have died of it.
    shear
        Whether the maximum shear stresses below the contacts of wheelsets are wanted.
    n_alike
        Number of rows of the whole campaign with the same bodies.

    """

    rows: tuple[Row, ...]
    prepared_for: Row | None = None
    losses: int = 0
    shear: bool = False
    n_alike: int = 1


@dataclass(frozen=True)
class Outcome:
    """What a worker gives back.

    Parameters
    ----------
    results
        Of each row, in their order.
    version
        The worker's version of flangeway.

    """

    results: tuple[RowResult, ...]
    version: str


def compute(chunk: Chunk) -> Outcome:
    """Compute the rows of a chunk; a row that fails says why and does not stop the others.

    Raises
    ------
    MissingLibraryError
        If the system lacks a library: then every row would fail.

    """
    with _ALONE:  # threads of one worker would share what is not made for it
        return Outcome(_results(chunk), versions()["flangeway"])


def _results(chunk: Chunk) -> tuple[RowResult, ...]:
    if chunk.prepared_for is not None:
        try:
            return position_rows(chunk.prepared_for, chunk.rows, shear=chunk.shear, n_alike=chunk.n_alike)
        except MissingLibraryError:
            raise
        except Exception as reason:
            return tuple(_failed(reason, 0.0) for _ in chunk.rows)
    return tuple(_guarded(row.case, chunk.shear) for row in chunk.rows)


def _guarded(case: RunnableCase, shear: bool) -> RowResult:
    start = time.perf_counter()
    try:
        return _computed(case, start, shear)
    except MissingLibraryError:
        raise
    except Exception as reason:
        return _failed(reason, time.perf_counter() - start)


def _failed(reason: Exception, seconds: float) -> RowResult:
    told = "; ".join(line.strip() for line in str(reason).splitlines())
    return RowResult("failed", told if isinstance(reason, FlangewayError) else unforeseen(reason), seconds=seconds)


def _computed(case: RunnableCase, start: float, shear: bool) -> RowResult:
    if isinstance(case, WheelsetCase):
        result = solve_wheelset(case.problem())
        return wheelset_row(result, time.perf_counter() - start, shear=shear)
    return summary_row(case.run().summary, time.perf_counter() - start)
