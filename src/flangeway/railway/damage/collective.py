"""Collectives: states of running with their shares of the distance, and how profiles of all of them are exchanged."""

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from typing import Any

from flangeway.errors import InputError
from flangeway.railway.profiles.bundled import RailProfile, WheelProfile
from flangeway.railway.track.placements import SIDES, Side
from flangeway.railway.track.wheelset_problem import Role, WheelsetProblem
from flangeway.system.file_content import packaged_text, toml_data

SHARES_TOLERANCE = 1e-6
"""Difference of the sum of the shares from 1 that is rounding."""
RADIUS = "load.curve.radius_m"
RADII = (RADIUS, "load.curve.radius_ft")
SurfaceKey = tuple[Role, Side]
"""Whose profile: with the mean of both sides, ``right`` stands for both."""


@dataclass(frozen=True, eq=False)
class RunningState:
    """A wheelset in one state of running.

    - `name`: for reports.
    - `share`: of the distance (wheels) or of the axles (rails), > 0.
    - `problem`: the wheelset with friction, as for `flangeway.railway.wheelset.spatial_result.solve_spatial`.
    """

    name: str
    share: float
    problem: WheelsetProblem

    @property
    def mirrored(self) -> "RunningState":
        """The state as a mirror in the middle of the track shows it: right is left, with equal profiles."""
        return replace(self, problem=self.problem.mirrored())


@dataclass(frozen=True, eq=False)
class Collective:
    """States whose shares sum to 1.

    Parameters
    ----------
    states
        One or more, all with the same profiles of what wears. Its partners may differ: new and worn rails under a wheel
        that wears, say, each with its share.
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
            if state.problem.friction is None:
                raise InputError(
                    f"{state.name} without friction", "states that roll with friction", "give rolling.friction"
                )
            if not (state.problem.has_alike_sides or self.separate):
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
        if any(not state.problem.has_alike_sides for state in self.states):
            return False
        remaining = [(state.share, state.problem) for state in self.states]
        for state in (state.mirrored for state in self.states):
            if (state.share, state.problem) not in remaining:
                return False
            remaining.remove((state.share, state.problem))
        return True

    def worn_at(self, role: Role, side: Side) -> dict[SurfaceKey, float]:
        """Whose profiles wear by a wheel or a rail of a side, and by which part of it."""
        if not self.separate:
            return {(role, "right"): 0.5}
        return {(role, worn_side): 0.5 for worn_side in SIDES} if self.is_symmetric else {(role, side): 1.0}

    def profiles(self, roles: Sequence[Role]) -> dict[SurfaceKey, WheelProfile | RailProfile]:
        """New profiles of bodies that wear; an `InputError` if states have different ones of them."""
        profiles: dict[SurfaceKey, WheelProfile | RailProfile] = {}
        sides: Sequence[Side] = SIDES if self.separate else ("right",)
        for state in self.states:
            track, wheelset = state.problem.track, state.problem.wheels
            for role in roles:
                for side in sides:
                    profile = wheelset.wheel_of(side) if role == "wheel" else track.rail_of(side)
                    if profiles.setdefault((role, side), profile) != profile:
                        raise InputError(
                            f"{state.name}: {side} {role} {profile.title}, and {profiles[role, side].title} before",
                            f"one {role} that wears",
                            f"leave out the wear of {role}s, which may then differ, or give all states the same",
                        )
        return profiles

    def problem_with(self, state: RunningState, profiles: Mapping[SurfaceKey, Any]) -> WheelsetProblem:
        """The problem of a state with other profiles; one for both sides makes the sides alike."""
        tables: dict[Role, str] = {"rail": "track", "wheel": "wheelset"}
        changes = {
            table: {side: {role: profiles.get((role, side), profiles[role, "right"])} for side in SIDES}
            for role, table in tables.items()
            if (role, "right") in profiles
        }
        return state.problem.replaced(**changes)


def ranges_of(state: Mapping[str, Any]) -> dict[str, Sequence[Any]]:
    """The inputs of a state that run over a range."""
    return {key: value for key, value in state.items() if isinstance(value, list | tuple)}


def parts_of(state: Mapping[str, Any]) -> list[dict[str, Any]]:
    """States in the place of one whose inputs run over ranges.

    A state stands for a share of the distance. Inputs that are pairs run together from the first to the second number,
    evenly spread over the share, a radius by its curvature. Each of its equal ``parts`` is computed in its middle. Wear
    lies where the contact is: middles of equal parts cover the surface evenly, other points of quadrature do not.

    - `state`: ``name``, ``share`` and ``parts`` (1 without it), and inputs: numbers, words, or pairs of numbers.

    An `InputError` if a range is no pair of numbers, a radius in it is 0 or changes its hand, or parts have no range.
    """
    ranges, number, name = ranges_of(state), state.get("parts", 1), state["name"]
    for key, pair in ranges.items():
        numbers = [number for number in pair if isinstance(number, int | float) and math.isfinite(number)]
        if len(pair) != 2 or len(numbers) != 2 or (key in RADII and not numbers[0] * numbers[1] > 0.0):
            raise InputError(
                f"{name}: {key} = {list(pair)}",
                "a number, or the two ends of a range; of radii both > 0 or both < 0",
                "correct it",
            )
    if number > 1 and not ranges:
        raise InputError(f"{name}: {number} parts of a state without ranges", "inputs with [first, last]", "add one")
    parts = []
    for part in range(number):
        at = {key: _between(key, pair, (part + 0.5) / number) for key, pair in ranges.items()}
        of_part = {"name": f"{name}, {part + 1} of {number}" if number > 1 else name, "share": state["share"] / number}
        parts.append({key: value for key, value in state.items() if key != "parts"} | at | of_part)
    return parts


def _between(key: str, ends: Sequence[float], fraction: float) -> float:
    first, last = (1.0 / end if key in RADII else end for end in ends)
    value = first + (last - first) * fraction
    return 1.0 / value if key in RADII else value


COLLECTIVES: dict[str, list[dict[str, Any]]] = toml_data(packaged_text(__package__, "collectives.toml"), "")
"""States of bundled collectives as `parts_of` takes them, with the paths of the inputs of the case ``wheelset``.

Their shares, speeds and radii are assumed, not measured: name them as such."""
