"""Ten thousand positions of a wheelset, lateral motion by load, on two processes; 20 by the full search as well.

Accuracy is the maximum difference of a patch's force from that of the full search, over the weight. The peer is the
full search of the same program: its time is that of as many positions at the mean of those that were searched.
"""

import os
import time
from collections.abc import Iterator
from concurrent.futures import ProcessPoolExecutor
from functools import partial
from multiprocessing import get_context
from multiprocessing.synchronize import Barrier
from pathlib import Path
from tempfile import TemporaryDirectory

import numpy as np
from numpy.typing import NDArray

from benchmarks.measurement import ITSELF, Measurement, timed
from flangeway.cases import WheelsetTangentCase
from flangeway.railway.positions.many_positions import Positions, PositionTable, solve_positions
from flangeway.railway.positions.positions_patches import patches_of
from flangeway.railway.positions.prepared_wheelset import PreparedWheelset, prepare
from flangeway.railway.track.placements import WheelsetPosition
from flangeway.railway.track.wheelset_load import WheelsetLoad
from flangeway.railway.track.wheelset_problem import Prescribed, WheelsetProblem
from flangeway.railway.wheelset.equilibrium import FIRST_PENETRATION_MM
from flangeway.system.disk_cache import Cache

Floats = NDArray[np.float64]

PAIRS = {"S1002 on 60E1": ({"wheel": "S1002", "rail": "60E1"}, 11.5), "AAR-1B on 136RE": ({}, 9.6)}
"""Inputs of the case, and lateral motion in mm up to which positions are solved: the flange touches."""

N_LATERAL, N_LOADS = 100, 100
LOADS_N = (50e3, 300e3)
N_CHECKED = 20
N_PROCESSES = 2
BUDGET_S = 100.0

_prepared: dict[str, PreparedWheelset] = {}


def measurements() -> Iterator[Measurement]:
    """Both pairs of profiles."""
    for name in PAIRS:
        yield from _pair(name)


def _problem(name: str) -> WheelsetProblem:
    return WheelsetTangentCase.from_values(PAIRS[name][0]).problem()


def _pair(name: str) -> Iterator[Measurement]:
    lateral = np.linspace(-PAIRS[name][1], PAIRS[name][1], N_LATERAL)
    loads = np.linspace(*LOADS_N, N_LOADS)
    shares = [Positions.grid(part, loads) for part in np.array_split(lateral, N_PROCESSES)]
    with TemporaryDirectory() as folder:
        condensing, prepared = timed(lambda: prepare(_problem(name), cache=Cache(Path(folder), 10**9)))
        context = get_context("spawn")
        ready = (name, folder, context.Barrier(N_PROCESSES))
        with ProcessPoolExecutor(N_PROCESSES, context, _make_ready, ready) as pool:
            list(pool.map(_is_ready, [name] * N_PROCESSES))
            seconds, found = timed(lambda: list(pool.map(partial(_solve, name, shear=False), shares)))
            shear_seconds, with_shear = timed(lambda: list(pool.map(partial(_solve, name, shear=True), shares)))
    tables = [table for table, _ in found]
    n_positions = sum(len(table.positions) for table in tables)
    processor, with_shear_processor = (sum(each for _, each in run) / n_positions for run in (found, with_shear))
    more = with_shear_processor - processor
    slow = sum(int(table.by_full_search.sum()) for table in tables)
    missing = sum(int((~table.converged).sum()) for table in tables)
    rounds = np.concatenate([table.rounds[~table.by_full_search] for table in tables]).mean()
    worst, pressure, full_s = _checked(prepared, tables)
    yield Measurement(
        f"{n_positions} positions of {name}, lateral motion by load, after condensation, {N_PROCESSES} processes",
        ITSELF,
        seconds,
        full_s * n_positions / N_PROCESSES,
        worst,
        None,
        f"budget {BUDGET_S:g} s; {1e3 * seconds * N_PROCESSES / n_positions:.1f} ms a position and process, "
        f"{1e3 * processor:.1f} ms of processor time; {rounds:.1f} iterations a position, {slow} by the full search, "
        f"{missing} not found; {N_CHECKED} drawn at random: pressures differ by {pressure:.1e}; "
        f"with maximum shear stresses {shear_seconds:.1f} s, {1e3 * more:.1f} ms of processor time more a position; "
        f"meshing and condensing {condensing:.2f} s, load average {os.getloadavg()[0]:.1f}",
    )


def _make_ready(name: str, folder: str, barrier: Barrier) -> None:
    """Prepare the wheelset in a worker, from the cache, and wait for the other workers."""
    _prepared[name] = prepare(_problem(name), cache=Cache(Path(folder), 10**9))
    barrier.wait()


def _is_ready(name: str) -> int:
    return len(_prepared[name].poses)


def _solve(name: str, positions: Positions, *, shear: bool) -> tuple[PositionTable, float]:
    start = time.process_time()
    return solve_positions(_prepared[name], positions, shear=shear), time.process_time() - start


def _checked(prepared: PreparedWheelset, tables: list[PositionTable]) -> tuple[float, float, float]:
    """Maximum differences of forces over the weight and of pressures from the full search, and its mean time."""
    rng = np.random.default_rng(20)
    worst, pressure, times = 0.0, 0.0, []
    for _ in range(N_CHECKED):
        table = tables[rng.integers(len(tables))]
        number = int(rng.integers(len(table.positions)))
        lateral, weight = float(table.positions.lateral_mm[number]), float(table.positions.vertical_N[number])
        start = time.perf_counter()
        where = prepared.model.rigid_start.geometry.locus([lateral]).motion(0)
        found = prepared.solve(WheelsetLoad(weight), Prescribed(lateral_mm=lateral), where)
        times.append(time.perf_counter() - start)
        if not found.status.converged:  # once more, from the motion that is to be checked
            motion = WheelsetPosition(*table.position[number]).moved(WheelsetPosition(vertical_mm=FIRST_PENETRATION_MM))
            found = prepared.solve(WheelsetLoad(weight), Prescribed(lateral_mm=lateral), motion)
        expected, got = patches_of(prepared, found), table.patches[number]
        if len(expected) != len(got) or not found.status.converged:
            return np.inf, np.inf, float(np.mean(times))
        for mine, theirs in zip(got, expected, strict=True):
            apart = np.subtract(mine.force_on_wheel_N, theirs.force_on_wheel_N)
            worst = max(worst, float(np.abs(apart).max()) / weight)
            pressure = max(pressure, abs(mine.max_pressure_MPa / theirs.max_pressure_MPa - 1.0))
    return worst, pressure, float(np.mean(times))
