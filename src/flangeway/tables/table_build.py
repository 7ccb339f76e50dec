"""Makes a table of creep forces: positions by many processes, jumps of the patches located, errors checked between."""

import itertools
import time
from collections.abc import Iterable, Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property
from typing import Any, Self

import numpy as np

from flangeway.cases.wheelset.wheelset_case import Wheelset
from flangeway.errors import InputError
from flangeway.records import entries_of
from flangeway.system.disk_cache import Cache
from flangeway.system.output_folder import versions
from flangeway.system.workers import LostWorkerError, computed_here, n_processes
from flangeway.tables import creep_sampling
from flangeway.tables.creep_table import AXES, FORMAT, OF_PATCH, SIDES, CreepTable
from flangeway.tables.table_positions import CHECKED_FRICTIONS, Arrays, PositionTask, compute_position
from flangeway.types import Floats, Ints, Progress, floats

JUMP_MM = 0.1
"""Distance of lateral positions to which a jump of the patches is located."""
N_POINTS = 16
"""Random creepages at which each patch of the table is checked."""
N_RANDOM, N_CREEPAGES = 48, 6
"""Random positions at which the table's error is measured, and creepages of each wheel there."""
N_CONTROL_POINTS, MAX_CONTROL_ERRORS = 500, 0.05
"""Further random points, and how many of them may be expected above the claimed error."""
TAIL_FRACTION = 0.1
"""Share of the largest errors, whose excess over the others falls exponentially."""
MAX_POSITIONS = 2000
MAX_PASSES = 4
"""Passes in which lateral positions are added while the claimed error is above the tolerance."""
REPORT_S = 2.0
STAGES = {"contact": "positions of contact", "table": "creep forces at positions", "check": "exact at random positions"}
"""What the progress calls the kinds of tasks; how many stages there are is known at the end only."""
FREE = ("position", "rolling", "load.axle_load_kN", "load.car")
"""Inputs of a wheelset that the axes of a table replace, and friction and motion, which are free."""

Position = tuple[float, float, float]


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

    case: Wheelset
    lateral_mm: Sequence[float]
    yaw_mrad: Sequence[float]
    load_kN: Sequence[float]  # noqa: N815
    tolerance: float = 0.1

    def __post_init__(self) -> None:
        for name in AXES:
            values = floats(getattr(self, name))
            if (
                values.ndim != 1
                or not len(values)
                or not np.isfinite(values).all()
                or not (np.diff(values) > 0.0).all()
            ):
                raise InputError(f"{name} = {values.tolist()}", "one number or more, rising", "correct the range")
        if not 0.0 < self.tolerance <= 1.0:
            raise InputError(
                f"tolerance = {self.tolerance:g}", "a number above 0, up to 1", "0.1 is 10 % of the limit of friction"
            )
        changed = [entry.name for entry in entries_of(self.case) if not entry.is_default]
        given = [name for name in changed if name.startswith(FREE)]
        if self.case.contact.kind != "spatial" or given:
            raise InputError(
                f"a table of a case with {', '.join(given) or 'contact.kind = plane'}",
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
    start = time.perf_counter()
    n_workers = n_processes(workers)
    if n_workers > 1 and Cache.of_user() is not None:  # once for all of them
        request.case.prepared(progress)
    table = _Build(request, n_workers, progress).table()
    return replace(table, metadata={**table.metadata, "seconds": round(time.perf_counter() - start, 1)})


@dataclass(frozen=True, eq=False)
class _Build:
    """One call of `make_table`.

    - `further`: lateral positions besides those of the request.
    - `contacts`, `sampled`, `checked`: what was computed, by position.
    """

    request: TableRequest
    n_workers: int
    progress: Progress
    further: frozenset[float] = frozenset()
    contacts: dict[Position, Arrays] = field(default_factory=dict)
    sampled: dict[Position, Arrays] = field(default_factory=dict)
    checked: dict[Position, Arrays] = field(default_factory=dict)

    def table(self) -> CreepTable:
        """All of it.

        A loop of its own: each pass has a new random sample of errors, and positions of all passes stay.
        """
        build = self._with_jumps()
        for number in range(MAX_PASSES):
            for wave in build._waves():
                build._run("table", wave, build.sampled, N_POINTS)
            table = build._assembled()
            errors = build._errors_between(table, number)
            checks = build._checks(table, errors)
            wrong = build._intervals_above(errors)
            n_added = len(wrong) * len(build._positions()) // len(build.lateral)
            if checks["within_tolerance"] or not wrong or len(build._positions()) + n_added > MAX_POSITIONS:
                break
            if number < MAX_PASSES - 1:
                claimed = checks["claimed_error"]
                self.progress(f"claimed error {claimed:.2%}: {len(wrong)} more lateral positions, then a new sample")
                build = build._with_lateral(wrong)._with_jumps()
        return replace(table, metadata={**table.metadata, "checks": checks})

    def _with_lateral(self, further: set[float]) -> Self:
        """With further lateral positions."""
        return replace(self, further=self.further | further)

    @cached_property
    def lateral(self) -> list[float]:
        """Lateral positions in order."""
        return sorted({*map(float, self.request.lateral_mm), *self.further})

    def _intervals_above(self, errors: list[dict[str, Any]]) -> set[float]:
        """Middles of the lateral intervals with the largest error and with those above the tolerance."""
        middles: dict[float, float] = {}
        for error in errors:
            index = min(int(np.searchsorted(self.lateral, error["lateral_mm"], side="right")), len(self.lateral) - 1)
            low, high = self.lateral[max(index - 1, 0)], self.lateral[index]
            if high - low > JUMP_MM and not error["jump"]:
                middle = round((low + high) / 2.0, 6)
                middles[middle] = max(error["force"], middles.get(middle, 0.0))
        least = min(self.request.tolerance, max(middles.values(), default=0.0))
        return {middle for middle, error in middles.items() if error >= least}

    def _waves(self) -> list[list[Position]]:
        """Positions in groups, each with neighbours in those before whose forces serve as first guess.

        Lateral positions by halving at the middle yaw and load, then other loads, then other yaws.
        """
        yaw, load = (axis[len(axis) // 2] for axis in self._axes[1:])
        groups, step = [self.lateral[:1]], 1 << max(len(self.lateral) - 2, 0).bit_length()
        while step:
            groups.append(self.lateral[step :: 2 * step])
            step //= 2
        waves = [[(lateral, yaw, load) for lateral in group] for group in groups]
        waves.append([position for position in self._positions() if position[1] == yaw])
        return [*waves, self._positions()]

    def _near(self, position: Position) -> Arrays | None:
        """What the table's positions next to a position have beyond FASTSIM, of those with the same patches.

        The next one over yaw, which hardly matters, or both beside it, or the next one over load, or on one side.
        """
        sides = self.contacts[position]["side"]
        known = [
            near_position for near_position, numbers in self.sampled.items() if np.array_equal(numbers["side"], sides)
        ]

        def nearest(axis: int, beyond: float = 0.0) -> list[Position]:
            """The nearest one that differs in one number only; above (1) or below (-1) if it says so."""
            there = [
                other
                for other in known
                if all(other[k] == position[k] for k in range(3) if k != axis)
                and (other[axis] - position[axis]) * beyond >= 0.0
            ]
            return [min(there, key=lambda other: abs(other[axis] - position[axis]))] if there else []

        below, above = nearest(0, -1.0), nearest(0, 1.0)
        over_yaw, over_load = nearest(1), nearest(2)
        if over_yaw or not (below and above):
            chosen = over_yaw or over_load or below or above
            return self.sampled[chosen[0]] if chosen else None
        (low,), (high,) = below, above
        share = (position[0] - low[0]) / (high[0] - low[0])
        between = (1.0 - share) * self.sampled[low]["beyond"] + share * self.sampled[high]["beyond"]
        return {"side": sides, "beyond": between.astype(np.float32)}

    @property
    def _axes(self) -> tuple[list[float], list[float], list[float]]:
        """Lateral positions, yaws and loads."""
        return self.lateral, [*map(float, self.request.yaw_mrad)], [*map(float, self.request.load_kN)]

    def _positions(self) -> list[Position]:
        return [*itertools.product(*self._axes)]

    def _run(self, kind: str, positions: Iterable[Position], store: dict[Position, Arrays], n_points: int = 0) -> None:
        """Compute what is missing."""
        positions = list(positions)
        images = {
            position: self._image(position) if kind != "check" else position
            for position in positions
            if position not in store
        }
        tasks = [
            PositionTask(
                *(self.request.case, position, kind, self.request.tolerance, n_points),
                self._near(position) if kind == "table" else None,
            )
            for position in dict.fromkeys(images.values())
            if position not in store
        ]
        begun, last = time.monotonic(), 0.0
        label = STAGES[kind]
        for done, (task, numbers) in enumerate(self._results(tasks), 1):
            store[task.position] = numbers
            now = time.monotonic()
            if now - last >= REPORT_S or done == len(tasks):
                last = now
                left = (now - begun) / done * (len(tasks) - done)
                self.progress(f"{label}: {done} of {len(tasks)}; {left:.0f} s left of this stage")
        for position, image in images.items():
            if position not in store:
                store[position] = _mirrored(store[image])

    def _image(self, position: Position) -> Position:
        """The position that is computed for it: itself, or the mirror image."""
        lateral, yaw, load = position
        return max(position, (0.0 - lateral, 0.0 - yaw, load)) if self.request.case.is_symmetric else position

    def _results(self, tasks: list[PositionTask]) -> Iterable[tuple[PositionTask, Arrays]]:
        for task, numbers in computed_here(tasks, compute_position, self.n_workers):
            if isinstance(numbers, LostWorkerError):
                raise InputError(
                    f"position {task.position}: {numbers}", "a machine with enough memory", "give fewer workers"
                )
            yield task, numbers

    def _with_jumps(self) -> Self:
        """With the lateral positions on both sides of each jump of the patches."""
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
                    span
                    for (low, high), middle in zip(wide, middles, strict=True)
                    for span in ((low, middle), (middle, high))
                ]
        build = self._with_lateral(ends)
        build._run("contact", build._positions(), build.contacts)
        return build

    def _joined(self, one: Position, other: Position) -> tuple[bool, bool]:
        """Whether the patches of each side go over into those of another position: as many, and they overlap."""
        first, second = (self.contacts[position] for position in (one, other))
        return tuple(_go_over(first, second, side) for side in range(2))  # type: ignore[return-value]

    def _assembled(self) -> CreepTable:
        """The table without its checks."""
        axes = [np.array(axis, dtype=np.float64) for axis in self._axes]
        shape = tuple(map(len, axes))
        entries = dict(zip(self._positions(), np.ndindex(shape), strict=True))
        most = max(int(np.bincount(numbers["side"], minlength=2).max()) for numbers in self.sampled.values())
        sizes = {name: (3,) if name == "position_mm" else (2,) * more for name, more in OF_PATCH.items()}
        values: dict[str, Any] = {name: np.zeros((*shape, 2, most, *size)) for name, size in sizes.items()}
        values["forces"] = np.zeros((*shape, 2, most, *map(len, creep_sampling.AXES), 3), dtype=np.float32)
        values["axle_vertical_mm_roll_rad"] = np.zeros((*shape, 2))
        for position, entry in entries.items():
            numbers = self.sampled[position]
            values["axle_vertical_mm_roll_rad"][entry] = numbers["axle"]
            for side in range(2):
                of_side = numbers["side"] == side
                for name in (*OF_PATCH, "forces"):
                    values[name][entry][side, : of_side.sum()] = numbers[name][of_side]
        values["joined"] = self._cells(shape)
        names = (*AXES, "slip", "spin_angle_rad", "creep_angle_rad")
        return CreepTable({**dict(zip(names, (*axes, *creep_sampling.AXES), strict=True)), **values}, self._metadata())

    def _cells(self, shape: tuple[int, ...]) -> np.ndarray[Any, Any]:
        """Whether all patches around a cell of the axes go over into each other, by cell and side."""
        nodes = dict(zip(np.ndindex(shape), self._positions(), strict=True))
        joined = np.ones((*(max(n - 1, 1) for n in shape), 2), dtype=np.bool_)
        for cell in np.ndindex(joined.shape[:3]):
            corners = itertools.product(*((index, index + 1) for index in cell))
            for one, other in itertools.combinations((corner for corner in corners if corner in nodes), 2):
                if sum(a != b for a, b in zip(one, other, strict=True)) == 1:  # an edge of the cell
                    joined[cell] &= self._joined(nodes[one], nodes[other])
        return joined

    def _errors_between(self, table: CreepTable, number: int) -> list[dict[str, Any]]:
        """Compare with exact forces at random positions and creepages, at others in each pass."""
        random = np.random.default_rng(number)
        ends = [(axis[0], axis[-1]) for axis in self._axes]
        points: list[Position] = [
            tuple(round(float(random.uniform(*limits)), 6) for limits in ends)  # type: ignore[misc]
            for _ in range(N_RANDOM)
        ]
        self._run("check", points, self.checked, N_CREEPAGES)
        return [
            error | {"lateral_mm": position[0], "place": number}
            for number, position in enumerate(points)
            for error in _differences(table, position, self.checked[position])
        ]

    def _checks(self, table: CreepTable, between: list[dict[str, Any]]) -> dict[str, Any]:
        """What the checks found, for the metadata."""
        used = [self.sampled[position] for position in self._positions()]
        force, moment = (
            np.concatenate([numbers[f"{name}_errors"].ravel() for numbers in used]) for name in ("force", "moment")
        )
        smooth, jumping = ([error for error in between if error["jump"] == jump] for jump in (False, True))
        claimed = claimed_error(*(np.array([error[name] for error in smooth]) for name in ("force", "place")))
        jumps = [
            {"side": name, "lateral_mm": (low + high) / 2.0, "width_mm": high - low}
            for side, name in enumerate(SIDES)
            for (low, high), cells in zip(
                itertools.pairwise(self.lateral), table.values["joined"][..., side], strict=False
            )
            if not cells.all()
        ]
        return {
            "tolerance": self.request.tolerance,
            "claimed_error": claimed,
            "frictions": list(CHECKED_FRICTIONS),
            "within_tolerance": claimed <= self.request.tolerance,
            "between_creepages": {**_sizes(force), "moment": _sizes(moment)},
            "between_positions": {
                **_sizes([error["force"] for error in smooth]),
                "normal_force": _sizes([error["normal_force"] for error in smooth]),
            },
            "where_patches_jump": _sizes([error["force"] for error in jumping]),
            "jumps": jumps,
            "exact_solutions": int(sum(numbers["n_exact"].sum() for numbers in used)),
            "not_converged": int(sum(numbers["n_failed"].sum() for numbers in used)),
        }

    def _metadata(self) -> dict[str, Any]:
        inputs = self.request.case.model_dump(
            mode="json", exclude_none=True, exclude={"position": True, "rolling": True, "load": {"axle_load_kN", "car"}}
        )
        return {"format": FORMAT, "versions": versions(), "case": inputs}


def _go_over(first: Arrays, second: Arrays, side: int) -> bool:
    """Whether the patches of a side at two positions are as many and overlap on the rail."""
    one, other = (numbers["side"] == side for numbers in (first, second))
    if one.sum() != other.sum():
        return False
    apart = np.linalg.norm(first["rail_point_mm"][one] - second["rail_point_mm"][other], axis=1)
    reach = first["radius_mm"][one] + second["radius_mm"][other]
    return bool((apart <= reach).all())


def _mirrored(numbers: Arrays) -> Arrays:
    """What a position has whose lateral position and yaw are opposite: numbers of patches are in right-hand forms."""
    order = np.argsort(1 - numbers["side"], kind="stable")
    other = {name: values if name in ("axle", "friction") else values[order] for name, values in numbers.items()}
    other |= {"side": 1 - other["side"], "axle": numbers["axle"] * [1.0, -1.0]}
    if "position_mm" in other:
        other["position_mm"] = other["position_mm"] * [-1.0, 1.0, 1.0]
    return other


def _differences(table: CreepTable, position: Position, exact: Arrays) -> list[dict[str, Any]]:
    """Errors of the sum of a wheel's creep forces at one position, by side and creepage, over the limit of friction.

    The coefficient of friction is another one at each position.

    Patches jump where the table has other ones than the position.
    """
    contacts, errors, friction = table.contacts(*position), [], float(exact["friction"])
    for side, name in enumerate(SIDES):
        of_side, here = exact["side"] == side, contacts["normal_force_N"][0, side]
        normal = float(exact["normal_force_N"][of_side].sum())
        forces = exact["exact"][of_side].sum(axis=0)
        for creepages, force in zip(exact["creepages"][of_side][0], forces, strict=True):
            error = table.forces(*position, creepages, friction=friction)[0, side].sum(axis=0) - force
            errors.append(
                {
                    "side": name,
                    "jump": bool(of_side.sum() != (here > 0.0).sum()),
                    "force": float(np.hypot(error[0], error[1])) / (friction * normal),
                    "normal_force": float(np.abs(here.sum() - normal)) / normal,
                }
            )
    return errors


def claimed_error(errors: Floats, positions: Ints) -> float:
    """Error that hardly any further random point exceeds: expected are `MAX_CONTROL_ERRORS` of `N_CONTROL_POINTS`.

    Errors above the largest tenth's least one are taken to fall exponentially beyond it, of which the mean excess is
    known from the positions in that tenth only: the predictive distribution is a Pareto distribution (Pickands, 1975,
    Annals of Statistics 3, for the tail; Geisser, 1993, Predictive Inference, for the exponential one).

    - `errors`: at independent random points, (n,).
    - `positions`: number of the position of each, (n,): those of one position are not independent of each other.
    """
    if not len(errors):
        return 0.0
    order = np.argsort(-errors)
    n_tail = max(round(TAIL_FRACTION * len(errors)), 1)
    tail, n_places = errors[order[:n_tail]], len(np.unique(positions[order[:n_tail]]))
    least = float(errors[order[min(n_tail, len(errors) - 1)]])
    rarer = n_tail / len(errors) * N_CONTROL_POINTS / MAX_CONTROL_ERRORS
    return least + n_places * float(tail.mean() - least) * (max(rarer, 1.0) ** (1.0 / n_places) - 1.0)


def _sizes(errors: Any) -> dict[str, Any]:
    """Number, maximum and root mean square of errors."""
    values = floats(errors)
    if not values.size:
        return {"n": 0, "max": None, "rms": None}
    return {"n": values.size, "max": float(values.max()), "rms": float(np.sqrt((values**2).mean()))}
