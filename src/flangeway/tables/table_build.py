"""Makes a table of creep forces: positions by many processes, jumps of the patches located, errors checked between."""

import itertools
import time
from collections import deque
from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass, field, replace
from typing import Any

import numpy as np

from flangeway.campaign.workers import LocalWorkers, LostWorkerError, computed
from flangeway.cases.wheelset.spatial_wheelset_case import SpatialWheelsetCase
from flangeway.cases.wheelset.wheelset_inputs import CURVE_KEYS
from flangeway.errors import InputError
from flangeway.railway.wheelset.running_surfaces import running_surfaces
from flangeway.system.disk_cache import Cache
from flangeway.system.operating_system import number_of_cores
from flangeway.system.versions import versions
from flangeway.tables import creep_sampling
from flangeway.tables.creep_table import AXES, FORMAT, OF_PATCH, SIDES, CreepTable
from flangeway.tables.table_positions import FRICTION, Arrays, PositionTask, compute_position

JUMP_MM = 0.1
"""Distance of lateral positions to which a jump of the patches is located."""
N_POINTS, N_BETWEEN = 24, 3
"""Random creepages at which each patch of the table is checked, and those of patches between its positions."""
MAX_POSITIONS = 2000
MAX_PASSES = 4
"""Passes in which lateral positions are added where the table is not within its tolerance."""
REPORT_S = 2.0
FREE_KEYS = tuple(key for key in SpatialWheelsetCase.position_keys if key not in CURVE_KEYS)
"""Inputs of a wheelset that the axes of a table replace, and friction and motion, which are free."""

Position = tuple[float, float, float]
Progress = Callable[[str], None]


@dataclass(frozen=True)
class TableRequest:
    """A table to be made.

    Parameters
    ----------
    case
        Wheelset and track.
    lateral_mm, yaw_mrad, load_kN
        Positions: rising, one or more of each.
    tolerance
        Error of the force over the limit of friction, up to which the table is refined.

    Raises
    ------
    InputError
        If an axis is empty or does not rise, the tolerance is not positive, or the case prescribes positions.

    """

    case: SpatialWheelsetCase
    lateral_mm: Sequence[float]
    yaw_mrad: Sequence[float]
    load_kN: Sequence[float]  # noqa: N815
    tolerance: float = 0.05

    def __post_init__(self) -> None:
        for name in AXES:
            values = np.asarray(getattr(self, name), dtype=np.float64)
            if (
                values.ndim != 1
                or not len(values)
                or not np.isfinite(values).all()
                or not (np.diff(values) > 0.0).all()
            ):
                raise InputError(f"{name} = {values.tolist()}", "one number or more, rising", "correct the range")
        if not 0.0 < self.tolerance <= 1.0:
            raise InputError(
                f"tolerance = {self.tolerance:g}", "a number above 0, up to 1", "0.05 is 5 % of the limit of friction"
            )
        given = [key for key in FREE_KEYS if key in self.case.model_fields_set]
        if self.case.model != "spatial" or given:
            raise InputError(
                f"a table of a case with {', '.join(given) or 'model = plane'}",
                "a wheelset in three dimensions; position and load are the table's axes, friction and motion free",
                "leave it out",
            )
        number = len(self.lateral_mm) * len(self.yaw_mrad) * len(self.load_kN)
        if number > MAX_POSITIONS:
            raise InputError(f"{number} positions", f"up to {MAX_POSITIONS}", "make several tables of it")


def make_table(request: TableRequest, *, workers: int | None = None, progress: Progress = lambda _: None) -> CreepTable:
    """Compute a table.

    Positions that are done are kept in the user's cache: after an interruption the same call goes on from there. In a
    script it must be below ``if __name__ == "__main__":``, since worker processes import the script.

    Parameters
    ----------
    request
        What to compute.
    workers
        Number of processes; as many as cores if left out, 1: this process.
    progress
        Called with a sentence as positions are done.

    Raises
    ------
    InputError
        If a position has no contact on both wheels, or there is no worker.

    """
    if workers is not None and workers < 1:
        raise InputError(f"workers = {workers}", "one worker or more", "leave it out to use all cores")
    start = time.perf_counter()
    n_workers, cache = workers or number_of_cores(), Cache.of_user()
    if n_workers > 1 and cache is not None:  # once for all of them
        running_surfaces(request.case.problem(), request.case.spatial_model(), cache=cache, progress=progress)
    build = _Build(request, n_workers, progress)
    table = build.table()
    return replace(table, metadata={**table.metadata, "seconds": round(time.perf_counter() - start, 1)})


@dataclass(eq=False)
class _Build:
    """One call of `make_table`.

    - `lateral`: lateral positions so far.
    - `contacts`, `sampled`, `checked`: what was computed, by position.
    """

    request: TableRequest
    n_workers: int
    progress: Progress
    lateral: list[float] = field(init=False)
    contacts: dict[Position, Arrays] = field(default_factory=dict)
    sampled: dict[Position, Arrays] = field(default_factory=dict)
    checked: dict[Position, Arrays] = field(default_factory=dict)

    def __post_init__(self) -> None:
        self.lateral = [float(each) for each in self.request.lateral_mm]

    def table(self) -> CreepTable:
        """All of it."""
        self._locate_jumps()
        for left in reversed(range(MAX_PASSES)):
            self._run("table", self._positions(), self.sampled, N_POINTS)
            found = self._assembled()
            errors = self._errors_between(found)
            wrong = {
                error["lateral_mm"]
                for error in errors
                if error["force"] > self.request.tolerance and not error["jump"] and error["width_mm"] > JUMP_MM
            }
            if not (left and wrong) or len(self._positions()) + len(wrong) > MAX_POSITIONS:
                break
            self.lateral = sorted({*self.lateral, *wrong})
            self._locate_jumps()
        return replace(found, metadata={**found.metadata, "checks": self._checks(errors)})

    def _positions(self) -> list[Position]:
        return list(
            itertools.product(self.lateral, map(float, self.request.yaw_mrad), map(float, self.request.load_kN))
        )

    def _run(self, kind: str, positions: Iterable[Position], store: dict[Position, Arrays], n_points: int = 0) -> None:
        """Compute what is missing."""
        tasks = [
            PositionTask(self.request.case, each, kind, self.request.tolerance, n_points)
            for each in positions
            if each not in store
        ]
        begun, last = time.monotonic(), 0.0
        label = {"contact": "contacts", "table": "positions", "check": "positions between"}[kind]
        for done, (task, found) in enumerate(self._results(tasks), 1):
            store[task.position] = found
            now = time.monotonic()
            if now - last >= REPORT_S or done == len(tasks):
                last = now
                left = (now - begun) / done * (len(tasks) - done)
                self.progress(f"{done} of {len(tasks)} {label}; {left:.0f} s left")

    def _results(self, tasks: list[PositionTask]) -> Iterable[tuple[PositionTask, Arrays]]:
        if self.n_workers == 1 or len(tasks) < 2:
            yield from ((task, compute_position(task)) for task in tasks)
            return
        workers: LocalWorkers[PositionTask, Arrays] = LocalWorkers(min(self.n_workers, len(tasks)), compute_position)
        try:
            for task, found in computed(workers, deque(tasks)):
                if isinstance(found, LostWorkerError):
                    raise InputError(
                        f"position {task.position}: {found}", "a machine with enough memory", "give fewer workers"
                    )
                yield task, found
        finally:
            workers.stop()

    def _locate_jumps(self) -> None:
        """Add the lateral positions on both sides of each jump of the patches."""
        self._run("contact", self._positions(), self.contacts)
        ends: set[float] = set()
        for yaw, load in itertools.product(self.request.yaw_mrad, self.request.load_kN):
            spans = list(itertools.pairwise(self.lateral))
            while spans:
                wide = []
                for low, high in spans:
                    if all(self._joined((low, yaw, load), (high, yaw, load))):
                        continue
                    if high - low > JUMP_MM:
                        wide.append((low, high))
                    else:
                        ends |= {low, high}
                middles = [round((low + high) / 2.0, 6) for low, high in wide]
                self._run("contact", [(middle, yaw, load) for middle in middles], self.contacts)
                spans = [
                    each
                    for (low, high), middle in zip(wide, middles, strict=True)
                    for each in ((low, middle), (middle, high))
                ]
        self.lateral = sorted({*self.lateral, *ends})
        self._run("contact", self._positions(), self.contacts)

    def _joined(self, one: Position, other: Position) -> tuple[bool, bool]:
        """Whether the patches of each side go over into those of another position: as many, and they overlap."""
        first, second = (self.contacts[each] for each in (one, other))
        return tuple(_go_over(first, second, side) for side in range(2))  # type: ignore[return-value]

    def _assembled(self) -> CreepTable:
        """The table without its checks."""
        axes = [
            np.array(each, dtype=np.float64) for each in (self.lateral, self.request.yaw_mrad, self.request.load_kN)
        ]
        shape = tuple(map(len, axes))
        places = dict(zip(self._positions(), np.ndindex(shape), strict=True))
        most = max(int(np.bincount(found["side"], minlength=2).max()) for found in self.sampled.values())
        sizes = {name: (3,) if name == "position_mm" else (2,) * more for name, more in OF_PATCH.items()}
        values: dict[str, Any] = {name: np.zeros((*shape, 2, most, *size)) for name, size in sizes.items()}
        values["forces"] = np.zeros((*shape, 2, most, *map(len, creep_sampling.AXES), 3), dtype=np.float32)
        values["axle_vertical_mm_roll_rad"] = np.zeros((*shape, 2))
        for position, place in places.items():
            found = self.sampled[position]
            values["axle_vertical_mm_roll_rad"][place] = found["axle"]
            for side in range(2):
                mine = found["side"] == side
                for name in (*OF_PATCH, "forces"):
                    values[name][place][side, : mine.sum()] = found[name][mine]
        values["joined"] = self._cells(shape)
        names = (*AXES, "slip", "spin_angle_rad", "creep_angle_rad")
        return CreepTable({**dict(zip(names, (*axes, *creep_sampling.AXES), strict=True)), **values}, self._metadata())

    def _cells(self, shape: tuple[int, ...]) -> np.ndarray[Any, Any]:
        """Whether all patches around a cell of the axes go over into each other, by cell and side."""
        nodes = np.empty(shape, dtype=object)
        for position, place in zip(self._positions(), np.ndindex(shape), strict=True):
            nodes[place] = position
        joined = np.ones((*(max(n - 1, 1) for n in shape), 2), dtype=np.bool_)
        for cell in np.ndindex(joined.shape[:3]):
            around = nodes[tuple(slice(place, place + 2) for place in cell)]
            for axis in range(3):
                if around.shape[axis] == 2:
                    low, high = np.split(around, 2, axis=axis)
                    for pair in zip(low.ravel(), high.ravel(), strict=True):
                        joined[cell] &= self._joined(*pair)
        return joined

    def _errors_between(self, table: CreepTable) -> list[dict[str, Any]]:
        """Compare with exact forces in the middle of each lateral interval, at random yaws and loads."""
        random = np.random.default_rng(0)
        points: dict[Position, float] = {}
        for low, high in itertools.pairwise(self.lateral):
            yaw, load = (
                round(float(random.uniform(axis[0], axis[-1])), 6)
                for axis in (self.request.yaw_mrad, self.request.load_kN)
            )
            points[round((low + high) / 2.0, 6), yaw, load] = high - low
        self._run("check", points, self.checked, N_BETWEEN)
        return [
            error | {"lateral_mm": position[0], "width_mm": width}
            for position, width in points.items()
            for error in _differences(table, position, self.checked[position])
        ]

    def _checks(self, between: list[dict[str, Any]]) -> dict[str, Any]:
        """What the checks found, for the metadata."""
        used = [self.sampled[each] for each in self._positions()]
        force, moment = (
            np.concatenate([each[f"{name}_errors"].ravel() for each in used]) for name in ("force", "moment")
        )
        smooth = [each for each in between if not each["jump"]]
        jumps = sorted({(each["side"], each["lateral_mm"], each["width_mm"]) for each in between if each["jump"]})
        return {
            "tolerance": self.request.tolerance,
            "within_tolerance": bool(
                max(force.max(), *(each["force"] for each in smooth), 0.0) <= self.request.tolerance
            ),
            "between_creepages": {**_sizes(force), "moment": _sizes(moment)},
            "between_positions": {
                **_sizes([each["force"] for each in smooth]),
                "normal_force": _sizes([each["normal_force"] for each in smooth]),
            },
            "jumps": [dict(zip(("side", "lateral_mm", "width_mm"), each, strict=True)) for each in jumps],
            "exact_solutions": int(sum(each["n_exact"].sum() for each in used)),
            "not_converged": int(sum(each["n_failed"].sum() for each in used)),
        }

    def _metadata(self) -> dict[str, Any]:
        inputs = self.request.case.model_dump(mode="json", exclude_none=True, exclude=set(FREE_KEYS))
        return {"format": FORMAT, "versions": versions(), "case": inputs}


def _go_over(first: Arrays, second: Arrays, side: int) -> bool:
    """Whether the patches of a side at two positions are as many and overlap on the rail."""
    one, other = (each["side"] == side for each in (first, second))
    if one.sum() != other.sum():
        return False
    apart = np.linalg.norm(first["rail_point_mm"][one] - second["rail_point_mm"][other], axis=1)
    reach = first["radius_mm"][one] + second["radius_mm"][other]
    return bool((apart <= reach).all())


def _differences(table: CreepTable, position: Position, exact: Arrays) -> list[dict[str, Any]]:
    """Errors of a table at one position, by side and creepage, over the limit of friction of the whole wheel."""
    contacts = table.contacts(*position)
    found = []
    for side, name in enumerate(SIDES):
        mine = exact["side"] == side
        normal = float(exact["normal_force_N"][mine].sum())
        here = contacts["normal_force_N"][0, side]
        if mine.sum() != (here > 0.0).sum():
            found.append({"side": name, "jump": True})
            continue
        for number in range(exact["creepages"].shape[1]):
            creepages = np.zeros((1, *contacts["normal_force_N"].shape[1:], 3))
            creepages[0, side, : mine.sum()] = exact["creepages"][mine, number]
            forces = table.forces(*position, creepages, friction=FRICTION)[0, side, : mine.sum()]
            error = forces - exact["exact"][mine, number]
            found.append(
                {
                    "side": name,
                    "jump": False,
                    "force": float(np.hypot(error[:, 0], error[:, 1]).sum()) / (FRICTION * normal),
                    "normal_force": float(np.abs(here.sum() - normal)) / normal,
                }
            )
    return found


def _sizes(errors: Any) -> dict[str, Any]:
    """Number, maximum and root mean square of errors."""
    values = np.asarray(errors, dtype=np.float64)
    if not values.size:
        return {"n": 0, "max": None, "rms": None}
    return {"n": values.size, "max": float(values.max()), "rms": float(np.sqrt((values**2).mean()))}
