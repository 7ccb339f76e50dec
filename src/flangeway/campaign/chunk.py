"""Rows that one worker computes together, and what the coordinator expects of its workers."""

import threading
import time
from collections import OrderedDict
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from functools import partial
from typing import Protocol

import numpy as np

from flangeway.campaign.campaign import Row
from flangeway.campaign.columns import RowResult, numbers_of, plane_patch, spatial_row, summary_row, wheelset_row
from flangeway.cases.case import RunnableCase
from flangeway.cases.wheelset.spatial_wheelset_case import SpatialWheelsetCase
from flangeway.cases.wheelset.wheelset_case import WheelsetCase
from flangeway.errors import FlangewayError, MissingLibraryError, unforeseen
from flangeway.post.contact_checks import roughness
from flangeway.railway.positions.many_positions import Positions, PositionTable, solve_positions
from flangeway.railway.positions.prepared_wheelset import PreparedWheelset, prepare
from flangeway.railway.spatial.running_surfaces import running_surfaces
from flangeway.railway.spatial.spatial_result import solve_position
from flangeway.railway.spatial.spatial_wheelset import SpatialWheelset
from flangeway.railway.track.placements import SIDES
from flangeway.railway.track.wheelset_load import WheelsetLoad
from flangeway.railway.track.wheelset_problem import Prescribed, WheelsetProblem
from flangeway.railway.wheelset.wheelset_result import solve_wheelset
from flangeway.system.disk_cache import Cache
from flangeway.system.versions import versions

_ALONE = threading.Lock()
KEPT = 2  # wheelsets that a worker keeps prepared; each takes some hundred megabytes

_prepared: OrderedDict[str, PreparedWheelset | SpatialWheelset] = OrderedDict()


@dataclass(frozen=True)
class Chunk:
    """Rows that one worker computes together.

    - `prepared_for`: for positions of the same bodies, which are prepared once: the first row of all with these bodies.
      None: each row is computed alone.
    - `losses`: how many workers have died of it.
    - `shear`: whether the maximum shear stresses below the contacts of wheelsets are wanted.
    - `n_alike`: number of rows of the whole campaign with the same bodies.
    """

    rows: tuple[Row, ...]
    prepared_for: Row | None = None
    losses: int = 0
    shear: bool = False
    n_alike: int = 1


@dataclass(frozen=True)
class Outcome:
    """Result of a worker.

    - `version`: the worker's version of flangeway.
    """

    results: tuple[RowResult, ...]
    version: str


@dataclass(frozen=True)
class Lost:
    """A worker died while it computed a chunk.

    - `workers`: how many died of it.
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

        A `MissingLibraryError` if the system of a worker lacks a library.
        """

    def stop(self) -> None:
        """End all that still runs; what it computes is dropped."""


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
            return _position_rows(whole, chunk.rows, shear=chunk.shear, n_alike=chunk.n_alike)
        except MissingLibraryError:
            raise
        except Exception as reason:
            return tuple(_failed(reason, 0.0) for _ in chunk.rows)
    return tuple(_guarded(partial(_computed, row.computed, chunk.shear)) for row in chunk.rows)


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


def _computed(case: RunnableCase, shear: bool, start: float) -> RowResult:
    if isinstance(case, WheelsetCase):
        result = solve_wheelset(case.problem())
        return wheelset_row(result, time.perf_counter() - start, shear=shear)
    return summary_row(case.run().summary, time.perf_counter() - start)


def _spatial(whole: SpatialWheelset, case: RunnableCase, start: float) -> RowResult:
    """Compute a position in three dimensions, of bodies that are prepared."""
    if not isinstance(case, SpatialWheelsetCase):
        raise TypeError("positions are of wheelsets")
    prescribed = Prescribed(case.lateral_mm, case.vertical_mm, case.roll_rad)
    model = case.spatial_model()
    result = solve_position(whole.at(case.load(), prescribed, model.yaw_rad, model.rolling), {})
    return spatial_row(result, time.perf_counter() - start)


def _position_rows(whole: PreparedWheelset, rows: Sequence[Row], *, shear: bool, n_alike: int) -> tuple[RowResult, ...]:
    """Compute plane positions of the same bodies, prepared with the weight of one row: the same for all chunks."""
    problems = [_problem(row) for row in rows]
    results: dict[int, RowResult] = {}
    # tilt, prescribed vertical position and roll are the same for a whole table of positions
    groups: dict[tuple[float | None, ...], list[int]] = {}
    for number, problem in enumerate(problems):
        _, vertical, roll = problem.prescribed.components
        groups.setdefault((problem.load.tilt_rad, vertical, roll), []).append(number)
    for numbers in groups.values():
        start = time.perf_counter()
        prepared = replace(whole, model=replace(whole.model, problem=problems[numbers[0]]))
        positions = Positions(
            np.array([_lateral(problems[number].prescribed) for number in numbers]),
            np.array([problems[number].load.vertical_N for number in numbers]),
            np.array([problems[number].load.lateral_N for number in numbers]),
        )
        table = solve_positions(prepared, positions, shear=shear, n_alike=n_alike)
        seconds = (time.perf_counter() - start) / len(numbers)
        for place, number in enumerate(numbers):
            results[number] = _row(prepared, table, place, seconds)
    return tuple(results[number] for number in range(len(rows)))


def _of(row: Row) -> PreparedWheelset | SpatialWheelset:
    """Return the prepared wheelset of a row, from an earlier chunk if there is one."""
    if row.identity not in _prepared:
        problem = _problem(row)
        if isinstance(row.computed, SpatialWheelsetCase):
            model = row.computed.spatial_model()
            surfaces = running_surfaces(problem, model, cache=Cache.of_user())
            _prepared[row.identity] = SpatialWheelset(problem, surfaces, model)
        else:
            # in the middle of level track, which rigid wheels can always reach
            in_the_middle = replace(problem, load=WheelsetLoad(problem.load.vertical_N), prescribed=Prescribed())
            _prepared[row.identity] = prepare(in_the_middle, cache=Cache.of_user())
        while len(_prepared) > KEPT:
            _prepared.popitem(last=False)
    _prepared.move_to_end(row.identity)
    return _prepared[row.identity]


def _problem(row: Row) -> WheelsetProblem:
    if not isinstance(row.computed, WheelsetCase | SpatialWheelsetCase):
        raise TypeError("positions are of wheelsets")
    return row.computed.problem()


def _lateral(prescribed: Prescribed) -> float:
    return np.nan if prescribed.lateral_mm is None else prescribed.lateral_mm


def _row(prepared: PreparedWheelset, table: PositionTable, place: int, seconds: float) -> RowResult:
    if not table.converged[place]:
        message = "; ".join(line.strip() for line in table.messages.get(place, "no equilibrium").splitlines())
        return RowResult("not converged", message, seconds=seconds)
    patches = table.patches[place]
    edges = [patch.side for patch in patches if patch.at_edge]
    if edges:
        message = (
            f"the {edges[0]} contact reaches the end of the running surface, so contact beyond it is missing; "
            "check the profiles and the load"
        )
        return RowResult("not converged", message, seconds=seconds)
    lost = [side for side in SIDES if not any(patch.side == side for patch in patches)]
    warnings = [f"the {' and '.join(lost)} wheel does not touch its rail"] if lost else []
    for patch in patches:
        warnings += roughness(patch.n_segments, patch.oscillation, f"the {patch.side} contact", "lower size_scale")
    lateral, vertical, roll = table.position[place].tolist()
    forces = [float(np.hypot(*patch.force_on_wheel_N)) for patch in patches]
    hertz = [
        prepared.model.hertz_at(patch.side, patch.wheel_point_mm, patch.rail_point_mm, force)
        for patch, force in zip(patches, forces, strict=True)
    ]
    values, rows = numbers_of((lateral, vertical, roll), list(map(plane_patch, patches, hertz)))
    return RowResult("converged", "contact forces and load are in equilibrium", tuple(warnings), values, rows, seconds)
