"""Collectives: states of running with their shares of the distance, and how profiles of all of them are exchanged."""

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from typing import Any

from flangeway.errors import InputError
from flangeway.railway.profiles.bundled import RailProfile, WheelProfile
from flangeway.railway.track.discretisation import Role
from flangeway.railway.track.placements import SIDES, Side
from flangeway.railway.track.wheelset_problem import WheelsetProblem
from flangeway.railway.wheelset.running_surfaces import SpatialModel

SHARES_TOLERANCE = 1e-6
"""Difference of the sum of the shares from 1 that is rounding."""
SurfaceKey = tuple[Role, Side]
"""Whose profile: with the mean of both sides, ``right`` stands for both."""


@dataclass(frozen=True, eq=False)
class RunningState:
    """A wheelset in one state of running.

    - `name`: for reports.
    - `share`: of the distance (wheels) or of the axles (rails), > 0.
    - `problem`, `model`: the wheelset with friction, as for `flangeway.railway.wheelset.spatial_result.solve_spatial`.
    """

    name: str
    share: float
    problem: WheelsetProblem
    model: SpatialModel

    @property
    def mirrored(self) -> "RunningState":
        """The state as a mirror in the middle of the track shows it: right is left, with equal profiles."""
        load, held, motion = self.problem.load, self.problem.prescribed, self.model.rolling
        load = replace(load, lateral_N=0.0 - load.lateral_N, tilt_rad=0.0 - load.tilt_rad)
        held = replace(held, lateral_mm=_reversed(held.lateral_mm), roll_rad=_reversed(held.roll_rad))
        if motion is not None:
            motion = replace(
                motion,
                curve_radius_m=_reversed(motion.curve_radius_m),
                yaw_rate_rad_s=0.0 - motion.yaw_rate_rad_s,
                lateral_velocity_m_s=0.0 - motion.lateral_velocity_m_s,
            )
        model = replace(self.model, yaw_rad=0.0 - self.model.yaw_rad, rolling=motion)
        return replace(self, problem=replace(self.problem, load=load, prescribed=held), model=model)


def _reversed(value: float | None) -> float | None:
    return None if value is None else 0.0 - value


@dataclass(frozen=True, eq=False)
class Collective:
    """States whose shares sum to 1.

    Parameters
    ----------
    states
        One or more, all with the same profiles and bodies.
    separate
        False: the wheels of both sides wear alike, and so do the rails, by the mean of both sides: lines have as many
        curves to the left as to the right, and wheelsets are turned. True: each side wears by itself.

    Raises
    ------
    InputError
        If there is no state, shares are not positive or do not add up, a wheelset does not roll with friction, or sides
        with different profiles wear by their mean.

    """

    states: Sequence[RunningState]
    separate: bool = False

    def __post_init__(self) -> None:
        if not self.states:
            raise InputError("a collective without states", "one state or more", "add states with their shares")
        for state in self.states:
            if not (math.isfinite(state.share) and state.share > 0.0):
                raise InputError(f"{state.name}: share = {state.share}", "a share above 0", "leave the state out")
            if state.model.rolling is None:
                raise InputError(
                    f"{state.name} without friction", "states that roll with friction", "give friction and speed_km_h"
                )
            symmetric = state.problem.track.is_symmetric and state.problem.wheelset.is_symmetric
            if not (symmetric or self.separate):
                raise InputError(
                    f"{state.name}: a left profile or radius of its own, with the mean of both sides",
                    "equal sides, or sides that wear by themselves",
                    'give sides = "separate"',
                )
        total = math.fsum(state.share for state in self.states)
        if abs(total - 1.0) > SHARES_TOLERANCE:
            raise InputError(
                f"shares of {len(self.states)} states that sum to {total:.7g}",
                "a sum of 1",
                "correct them; one passage of a wheelset counts for both of its wheels once",
            )

    @cached_property
    def is_symmetric(self) -> bool:
        """Whether it is its own mirror image: its states have equal sides, and mirrored they are the same states.

        Both sides then wear alike. Each side by itself would differ by round-off, and rigid wheels that differ by this
        touch at other places where worn surfaces conform.
        """
        if any(not (each.problem.track.is_symmetric and each.problem.wheelset.is_symmetric) for each in self.states):
            return False
        mirrored = [each.mirrored for each in self.states]
        # twice mirrored has no -0.0 either
        here, there = (
            sorted(f"{each.share!r} {each.problem!r} {each.model!r}" for each in states)
            for states in ([each.mirrored for each in mirrored], mirrored)
        )
        return here == there

    def worn_at(self, role: Role, side: Side) -> dict[SurfaceKey, float]:
        """Whose profiles wear by a wheel or a rail of a side, and by which part of it."""
        if not self.separate:
            return {(role, "right"): 0.5}
        return {(role, each): 0.5 for each in SIDES} if self.is_symmetric else {(role, side): 1.0}

    def profiles(self, roles: Sequence[Role]) -> dict[SurfaceKey, WheelProfile | RailProfile]:
        """New profiles of bodies that wear."""
        problem = self.states[0].problem
        found: dict[SurfaceKey, WheelProfile | RailProfile] = {}
        sides: Sequence[Side] = SIDES if self.separate else ("right",)
        for role in roles:
            for side in sides:
                of_side = problem.wheelset.wheel_of(side) if role == "wheel" else problem.track.rail_of(side)
                found[role, side] = of_side
        return found

    def problem_with(self, state: RunningState, profiles: Mapping[SurfaceKey, Any]) -> WheelsetProblem:
        """The problem of a state with other profiles; one for both sides makes the sides alike."""

        def left(role: Role) -> Any:
            profile = profiles.get((role, "left"))
            return None if profile is profiles[role, "right"] else profile

        track, wheelset = state.problem.track, state.problem.wheelset
        if ("rail", "right") in profiles:
            track = replace(track, rail=profiles["rail", "right"], left_rail=left("rail"))
        if ("wheel", "right") in profiles:
            wheelset = replace(wheelset, wheel=profiles["wheel", "right"], left_wheel=left("wheel"))
        return replace(state.problem, track=track, wheelset=wheelset)


@dataclass(frozen=True)
class StateInputs:
    """Inputs of a bundled state, with the keys of the case ``wheelset``."""

    share: float
    speed_km_h: float
    curve_radius_m: float | None = None
    superelevation_mm: float = 0.0
    gauge_mm: float = 1435.0
    yaw_mrad: float = 0.0
    friction: float = 0.3
    flange_friction: float | None = None

    @property
    def name(self) -> str:
        """For reports."""
        where = "tangent" if self.curve_radius_m is None else f"R = {self.curve_radius_m:g} m"
        return f"{where}, gauge {self.gauge_mm:g} mm, yaw {self.yaw_mrad:g} mrad, {self.speed_km_h:g} km/h"

    @property
    def values(self) -> dict[str, float]:
        """Inputs of the case, without the share."""
        return {key: value for key, value in vars(self).items() if value is not None and key != "share"}


def _tangent(share: float, speed: float, friction: float = 0.3) -> tuple[StateInputs, ...]:
    """Straight track: gauges and yaws of axles in their bogies spread the contact, three states."""
    return (
        StateInputs(0.4 * share, speed, gauge_mm=1435.0, yaw_mrad=0.3, friction=friction),
        StateInputs(0.3 * share, speed, gauge_mm=1432.0, yaw_mrad=-0.3, friction=friction),
        StateInputs(0.3 * share, speed, gauge_mm=1438.0, yaw_mrad=0.5, friction=friction),
    )


COLLECTIVES: dict[str, tuple[StateInputs, ...]] = {
    "tangent": _tangent(1.0, 160.0),
    "mixed-line": (
        *_tangent(0.55, 140.0),
        StateInputs(0.08, 140.0, 3000.0, 40.0),
        StateInputs(0.08, 140.0, 2000.0, 60.0),
        StateInputs(0.07, 130.0, 1500.0, 80.0),
        StateInputs(0.06, 120.0, 1000.0, 100.0),
        StateInputs(0.05, 100.0, 800.0, 100.0),
        StateInputs(0.05, 90.0, 600.0, 110.0),
        StateInputs(0.04, 80.0, 500.0, 120.0, flange_friction=0.2),
        StateInputs(0.02, 70.0, 400.0, 120.0, flange_friction=0.2),
    ),
    "metro": (
        *_tangent(0.5, 70.0),
        StateInputs(0.15, 70.0, 800.0, 50.0),
        StateInputs(0.15, 60.0, 500.0, 80.0),
        StateInputs(0.12, 50.0, 350.0, 90.0, flange_friction=0.15),
        StateInputs(0.08, 40.0, 250.0, 90.0, flange_friction=0.15),
    ),
    "heavy-haul": (
        *_tangent(0.6, 70.0, 0.35),
        StateInputs(0.15, 70.0, 1500.0, 20.0, friction=0.35),
        StateInputs(0.15, 65.0, 900.0, 40.0, friction=0.35),
        StateInputs(0.10, 60.0, 500.0, 60.0, friction=0.35, flange_friction=0.2),
    ),
}
"""Bundled collectives. Their shares, speeds and radii are assumed, not measured: name them as such."""
