"""Rows that one worker computes together."""

import threading
import time
from collections import OrderedDict
from collections.abc import Callable
from dataclasses import dataclass, replace
from functools import partial

from flangeway.campaign.campaign import Row
from flangeway.campaign.columns import RowResult, row_of
from flangeway.cases.case import RunnableCase
from flangeway.cases.wheelset.spatial_wheelset_case import SpatialWheelsetCase
from flangeway.cases.wheelset.wheelset_case import WheelsetCase
from flangeway.cases.wheelset.wheelset_run import WheelsetRun
from flangeway.errors import FlangewayError, MissingLibraryError, unforeseen
from flangeway.railway.track.wheelset_load import WheelsetLoad
from flangeway.railway.track.wheelset_problem import Prescribed, WheelsetProblem
from flangeway.railway.wheelset.plane_wheelset import PlaneWheelset
from flangeway.railway.wheelset.spatial_wheelset import SpatialWheelset
from flangeway.railway.wheelset.wheelset_model import build_model
from flangeway.railway.wheelset.wheelset_result import solve_condensed
from flangeway.system.disk_cache import Cache
from flangeway.system.versions import versions

_ALONE = threading.Lock()
MAX_PREPARED = 2  # wheelsets that a worker keeps prepared; each takes some hundred megabytes

_prepared: OrderedDict[str, PlaneWheelset | SpatialWheelset] = OrderedDict()


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
    if chunk.prepared_for is not None:
        try:
            whole = _of(chunk.prepared_for)
            if isinstance(whole, SpatialWheelset):
                return tuple(_guarded(partial(_spatial, whole, row.case)) for row in chunk.rows)
            return tuple(_guarded(partial(_plane, whole, row)) for row in chunk.rows)
        except MissingLibraryError:
            raise
        except Exception as reason:
            return tuple(_failed(reason, 0.0) for _ in chunk.rows)
    return tuple(_guarded(partial(_computed, row.computed)) for row in chunk.rows)


def _guarded(compute_row: Callable[[float], RowResult]) -> RowResult:
    start = time.perf_counter()
    try:
        return compute_row(start)
    except MissingLibraryError:
        raise
    except Exception as reason:
        return _failed(reason, time.perf_counter() - start)


def _failed(reason: Exception, seconds: float) -> RowResult:
    reported = "; ".join(line.strip() for line in str(reason).splitlines())
    return RowResult("failed", reported if isinstance(reason, FlangewayError) else unforeseen(reason), seconds=seconds)


def _computed(case: RunnableCase, start: float) -> RowResult:
    run = case.run()
    return row_of(case, run, time.perf_counter() - start)


def _spatial(whole: SpatialWheelset, case: RunnableCase, start: float) -> RowResult:
    """Compute a position in three dimensions, of bodies that are prepared."""
    if not isinstance(case, SpatialWheelsetCase):
        raise TypeError("positions are of wheelsets")
    return row_of(case, case.run_on(whole), time.perf_counter() - start)


def _plane(whole: PlaneWheelset, row: Row, start: float) -> RowResult:
    """Compute a plane position of bodies that are condensed."""
    case = row.computed
    if not isinstance(case, WheelsetCase):
        raise TypeError("positions are of wheelsets")
    result = solve_condensed(whole.at(case.problem()))
    seconds = time.perf_counter() - start
    return row_of(case, WheelsetRun(case, result, seconds), seconds)


def _of(row: Row) -> PlaneWheelset | SpatialWheelset:
    """Return the prepared wheelset of a row, from an earlier chunk if there is one."""
    if row.identity not in _prepared:
        problem = _problem(row)
        if isinstance(row.computed, SpatialWheelsetCase):
            _prepared[row.identity] = row.computed.prepared()
        else:
            # in the middle of level track, which rigid wheels can always reach
            in_the_middle = replace(problem, load=WheelsetLoad(problem.load.vertical_N), prescribed=Prescribed())
            model = build_model(in_the_middle, whole=True, cache=Cache.of_user())
            _prepared[row.identity] = PlaneWheelset.of(model, cache=Cache.of_user())
        while len(_prepared) > MAX_PREPARED:
            _prepared.popitem(last=False)
    _prepared.move_to_end(row.identity)
    return _prepared[row.identity]


def _problem(row: Row) -> WheelsetProblem:
    if not isinstance(row.computed, WheelsetCase | SpatialWheelsetCase):
        raise TypeError("positions are of wheelsets")
    return row.computed.problem()
