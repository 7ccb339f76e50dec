"""Rows that differ in position and load only: their bodies are meshed and condensed once."""

import time
from collections import OrderedDict
from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from flangeway.campaign.campaign import Row
from flangeway.campaign.columns import PatchNumbers, RowResult, numbers_of
from flangeway.cases.wheelset.wheelset_case import WheelsetCase
from flangeway.post.contact_checks import roughness
from flangeway.railway.positions.many_positions import Positions, PositionTable, solve_positions
from flangeway.railway.positions.positions_patches import PositionPatch
from flangeway.railway.positions.prepared_wheelset import PreparedWheelset, prepare
from flangeway.railway.track.placements import SIDES
from flangeway.railway.track.wheelset_load import Load
from flangeway.railway.track.wheelset_problem import Prescribed, WheelsetProblem
from flangeway.system.disk_cache import Cache

KEPT = 2
"""Wheelsets that a worker keeps prepared; each takes some hundred megabytes."""

_prepared: OrderedDict[str, PreparedWheelset] = OrderedDict()


def position_rows(prepared_for: Row, rows: Sequence[Row], *, shear: bool, n_alike: int) -> tuple[RowResult, ...]:
    """Compute positions of the same bodies.

    Parameters
    ----------
    prepared_for
        Row whose weight the bodies are prepared with: the same for all chunks, so that meshes are.
    rows
        The rows; they differ in position and load only.
    shear
        Whether the maximum shear stresses below the contacts are wanted.
    n_alike
        Number of rows of the whole campaign with these bodies.

    """
    problems = [_problem(row) for row in rows]
    whole = _of(prepared_for)
    results: dict[int, RowResult] = {}
    # tilt and given vertical motion and roll are of the whole table of positions
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


def _of(row: Row) -> PreparedWheelset:
    """Return the prepared wheelset of a row, from an earlier chunk if there is one."""
    if row.identity not in _prepared:
        problem = _problem(row)
        # in the middle of level track, which rigid wheels can always reach
        in_the_middle = replace(problem, load=Load(problem.load.vertical_N), prescribed=Prescribed())
        _prepared[row.identity] = prepare(in_the_middle, cache=Cache.of_user())
        while len(_prepared) > KEPT:
            _prepared.popitem(last=False)
    _prepared.move_to_end(row.identity)
    return _prepared[row.identity]


def _problem(row: Row) -> WheelsetProblem:
    if not isinstance(row.case, WheelsetCase):
        raise TypeError("positions are of wheelsets")
    return row.case.problem()


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
    values, rows = numbers_of((lateral, vertical, roll), [_numbers(prepared, patch) for patch in patches])
    return RowResult("converged", "contact forces and load are in equilibrium", tuple(warnings), values, rows, seconds)


def _numbers(prepared: PreparedWheelset, patch: PositionPatch) -> PatchNumbers:
    force = float(np.hypot(*patch.force_on_wheel_N))
    return PatchNumbers(patch, prepared.model.hertz_at(patch.side, patch.wheel_point_mm, patch.rail_point_mm, force))
