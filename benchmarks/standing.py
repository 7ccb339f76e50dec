"""Whether a wheelset in three dimensions finds its position: bundled wheels, rails, loads and curves drawn at random.

Each of 600 combinations ends as converged, as derailed or overturned (no equilibrium of the rigid wheelset without
friction), as one that friction cannot hold, or as a failure. Each converged one is checked apart from the solver: by
the sums of its own cells' forces, by the least gap of the deformed bodies outside of the patches on cells over the
whole running surfaces, and by the least force of a cell. Seconds are those of the processor, running surfaces ready.
"""

import random
import time
from collections import Counter
from collections.abc import Iterator
from dataclasses import dataclass
from functools import lru_cache
from typing import Any

import numpy as np

from benchmarks.measurement import NO_PEER, Measurement
from flangeway.cases.wheelset.wheelset_case import Wheelset
from flangeway.contact.patch.patch_grid import PatchGrid
from flangeway.errors import InputError
from flangeway.railway.profiles.bundled import RAILS, REFERENCE_WHEELS, WHEELS
from flangeway.railway.track.placements import SIDE_SIGN, SIDES, Side, Track, WheelPair
from flangeway.railway.track.rolling import RollingMotion
from flangeway.railway.track.wheelset_loads import Load
from flangeway.railway.wheelset.running_surfaces import running_surfaces
from flangeway.railway.wheelset.side_contact import GriddedSide, SideState, SideSurfaces
from flangeway.railway.wheelset.side_newton import transferred, transferred_creep
from flangeway.railway.wheelset.spatial_result import SpatialResult, solve_position
from flangeway.railway.wheelset.spatial_wheelset import SpatialWheelset
from flangeway.system.disk_cache import Cache

COUNT, QUICK_COUNT, SEED = 600, 6, 29
SPEED_m_s = 15.0
SMALL_FORCES_KN = (0.0, 0.1, 1.0)
"""Drawn in a quarter of all: the wheelset hardly moves from the middle of the track."""
REFUSED = ("derail", "overturn", "the other wheel lifts", "no position holds")
"""Words of the messages by which a rigid wheelset without friction is refused."""
NOT_HELD = ("climbs", "carries its load", "not balanced", "not transmit")
"""Words of the messages that name the force that friction does not hold."""
CELL_MM, STRIP_MM, REACH_MM = 1.0, 2.0, 60.0
"""Cells of the whole running surface on which the gap outside of the patches is checked, and their reach along it."""
MAX_FORCE, MAX_OVERLAP_MM = 1e-6, 2e-3
"""Residual of the sums over the load, and overlap outside of the patches, above which an equilibrium is wrong."""


@dataclass(frozen=True)
class Combination:
    """One wheelset of the campaign; `yaw_stiffness`: in kN m per mrad, None where the yaw is 0; `friction`: or 0."""

    wheel: str
    rail: str
    inclination: float
    axle_load_kN: float  # noqa: N815 (units in names)
    lateral_force_kN: float  # noqa: N815
    friction: float
    curve_radius_m: float | None
    yaw_stiffness: float | None

    @property
    def wheelset(self) -> SpatialWheelset:
        """The wheelset with its running surfaces."""
        motion = None
        if self.friction:
            turning = 0.0 if self.curve_radius_m is None else 1e3 * SPEED_m_s / self.curve_radius_m
            motion = RollingMotion(
                friction=self.friction,
                speed_km_h=3.6 * SPEED_m_s,
                yaw_rate_mrad_per_s=turning,
                yaw_stiffness_kNm_per_mrad=self.yaw_stiffness,
            )
        case = _case(self.wheel, self.rail, self.inclination).replaced(
            load=Load(axle_load_kN=self.axle_load_kN, lateral_force_kN=self.lateral_force_kN), rolling=motion
        )
        return SpatialWheelset(case, _surfaces(self.wheel, self.rail, self.inclination))


def _case(wheel: str, rail: str, inclination: float) -> Wheelset:
    return Wheelset(track=Track(rail=rail, inclination=inclination), wheelset=WheelPair(wheel=wheel))


@lru_cache(maxsize=64)
def _surfaces(wheel: str, rail: str, inclination: float) -> dict[Side, SideSurfaces]:
    return running_surfaces(_case(wheel, rail, inclination), cache=Cache.of_user())


def combinations(count: int = COUNT) -> list[Combination]:
    """The first combinations of the campaign, always the same."""
    draw = random.Random(SEED)
    drawn = []
    for _ in range(count):
        rolls = draw.random() < 0.5
        small = draw.random() < 0.25
        wheel, rail = draw.choice((*WHEELS, *REFERENCE_WHEELS)), draw.choice(RAILS)
        inclination, axle_load = draw.choice((0.0, 0.025, 0.05)), draw.uniform(60.0, 320.0)
        force = draw.choice(SMALL_FORCES_KN) if small else draw.uniform(0.0, 60.0)
        radius = draw.choice((None, 150.0, 300.0, 600.0, 1000.0, 3000.0))
        sign, friction = draw.choice((-1.0, 1.0)), draw.uniform(0.1, 0.5)
        stiffness = draw.choice((None, None, 0.0, 10.0))
        drawn.append(
            Combination(
                wheel, rail, inclination, round(axle_load, 1), round(force, 2), round(friction, 2) if rolls else 0.0,
                sign * radius if rolls and radius is not None else None, stiffness if rolls else None,
            )
        )  # fmt: skip
    return drawn


def stand(one: Combination) -> dict[str, Any]:
    """How a combination ends, its seconds of processor, and its checks."""
    _surfaces(one.wheel, one.rail, one.inclination)
    start, result = time.process_time(), None
    try:
        result = solve_position(one.wheelset, {})
        converged, message = result.status.converged, result.status.message
    except InputError as error:
        converged, message = False, str(error)
    except Exception as error:  # a failure of the campaign, not its end
        converged, message = False, f"{type(error).__name__}: {error}"
    end: dict[str, Any] = {"processor_s": time.process_time() - start, "message": message}
    if converged:
        assert result is not None
        checked = checks(result)
        wrong = checked["force"] > MAX_FORCE or checked["overlap_mm"] > MAX_OVERLAP_MM
        position = result.equilibrium.position
        return end | checked | {"end": "wrong" if wrong else "converged", "lateral_mm": position.lateral_mm}
    if any(word in message for word in REFUSED):
        return end | {"end": "derailed or overturned"}
    return end | {"end": "not held" if one.friction and any(word in message for word in NOT_HELD) else "failed"}


def checks(result: SpatialResult) -> dict[str, float]:
    """Sum of the cells' forces and the load, over the load; overlap outside of the patches; least force of a cell."""
    state, problem = result.equilibrium.state, result.problem
    along, onto = problem.forces.in_track
    total, overlap, least = np.array([along, -onto]), 0.0, 0.0
    for side in SIDES:
        one = state.sides[side]
        on_wheel = one.forces.sum(axis=1) @ one.normals
        if state.rolled is not None:
            on_wheel = on_wheel + state.rolled.creep[side].resultant[:2]
        total = total + on_wheel * (SIDE_SIGN[side], 1.0)
        overlap = max(overlap, _overlap(one))
        least = min(least, float(one.forces.min()))
    held = [value is not None for value in problem.position.components[:2]]
    return {"force": float(np.abs(np.where(held, 0.0, total)).max()) / onto, "overlap_mm": overlap, "least_N": least}


def _overlap(state: SideState) -> float:
    """Largest overlap of the deformed bodies outside of the cells of a side, mm, on even cells of the whole surface."""
    inner, surfaces = state.grid.grid, state.grid.surfaces
    low, high = np.sort(surfaces.rail_stations[[0, -1], 1])
    ends = np.linspace(low, high, int((high - low) / CELL_MM) + 1)
    first, last = (int(np.floor(z / STRIP_MM)) for z in (inner.along[0] - REACH_MM, inner.along[-1] + REACH_MM))
    whole = GriddedSide(surfaces, PatchGrid.on_planes(ends, STRIP_MM, first, last - 1), state.pose)
    forces = transferred(state, whole)
    values = whole.deformed(state.pose, forces, transferred_creep(state, whole)[:, 0])[3]
    gaps = values + whole.influence(forces)
    cells = whole.grid.cells[:, None]
    across = ((cells[..., 1] > inner.cells[:, 0]) & (cells[..., 0] < inner.cells[:, 1])).any(axis=1)
    along = (whole.grid.along > inner.along[0] - STRIP_MM) & (whole.grid.along < inner.along[-1] + STRIP_MM)
    outside = ~np.outer(across, along)
    return max(0.0, -float(gaps[outside].min(initial=0.0)))


def measurements() -> Iterator[Measurement]:
    """The whole campaign."""
    yield _campaign(COUNT)


def quick() -> Iterator[Measurement]:
    """A few combinations."""
    yield _campaign(QUICK_COUNT)


def _campaign(count: int) -> Measurement:
    drawn = combinations(count)
    ends = [stand(one) for one in drawn]
    counts = Counter(end["end"] for end in ends)
    seconds = [end["processor_s"] for end in ends]
    failures = [
        vars(one) | {"message": end["message"]}
        for one, end in zip(drawn, ends, strict=True)
        if end["end"] in ("failed", "wrong")
    ]
    forces = [end["force"] for end in ends if "force" in end]
    return Measurement(
        f"{count} wheelsets drawn at random", NO_PEER, float(np.mean(seconds)), None, max(forces, default=None), None,
        "mean seconds of processor of a position, running surfaces ready",
        more={
            "ends": dict(counts), "slowest_s": max(seconds), "failures": failures,
            "without_friction_s": _mean(drawn, seconds, rolls=False),
            "with_friction_s": _mean(drawn, seconds, rolls=True),
        },
    )  # fmt: skip


def _mean(drawn: list[Combination], seconds: list[float], *, rolls: bool) -> float | None:
    chosen = [time for one, time in zip(drawn, seconds, strict=True) if bool(one.friction) == rolls]
    return float(np.mean(chosen)) if chosen else None
