"""One position of a wheelset for a table: its patches without friction, and creep forces of each."""

from collections.abc import Mapping
from dataclasses import dataclass
from functools import lru_cache
from typing import Any

import numpy as np
from numpy.typing import NDArray

from flangeway.cases.wheelset.wheelset_case import Wheelset
from flangeway.contact.rolling.exact_rolling import roll
from flangeway.contact.rolling.friction import Friction
from flangeway.errors import InputError
from flangeway.railway.track.placements import SIDES
from flangeway.railway.wheelset.spatial_result import solve_position
from flangeway.railway.wheelset.spatial_wheelset import SpatialWheelset
from flangeway.railway.wheelset.wheel_patch import WheelPatch, rolling_contact_of
from flangeway.solve import Status
from flangeway.system.disk_cache import Cache, cached
from flangeway.tables import creep_sampling
from flangeway.tables.creep_sampling import SampledPatch, random_points, refined
from flangeway.tables.creep_table import FORMAT, OF_PATCH
from flangeway.types import Floats

FRICTION = 0.3
"""For which forces are computed; over the limit of friction they are functions of creepages over it, nearly."""
CHECKED_FRICTIONS = (0.1, 0.6)
"""Coefficients between which that of each position is drawn at which the table's error is measured."""

Arrays = Mapping[str, NDArray[Any]]


@dataclass(frozen=True)
class PositionTask:
    """What is to be computed at a position.

    - `position`: lateral position in mm, yaw in mrad, axle load in kN.
    - `kind`: ``contact``; ``table``, with forces at all creepages; ``check``, with forces at some random creepages.
    - `tolerance`: of the table, over the limit of friction.
    - `n_points`: number of random creepages of each patch.
    - `near`: what a ``table`` of a position nearby has, whose forces beyond FASTSIM's are similar.
    """

    case: Wheelset
    position: tuple[float, float, float]
    kind: str = "contact"
    tolerance: float = 1.0
    n_points: int = 0
    near: Arrays | None = None

    @property
    def own_case(self) -> Wheelset:
        """The case at this position."""
        lateral, yaw, load = self.position
        return self.case.replaced(position={"lateral_mm": lateral, "yaw_mrad": yaw}, load={"axle_load_kN": load})


def compute_position(task: PositionTask) -> Arrays:
    """Patches from the left side to the right, on each from the field side to the gauge side; kept in the cache.

    Raises
    ------
    InputError
        If there is no contact at the position that a table may have.

    """
    parts = task.own_case.model_dump_json(), task.kind, task.tolerance, task.n_points
    near = () if task.near is None else (task.near["side"], task.near["beyond"])
    parts = *parts, *creep_sampling.AXES, creep_sampling.DIRECTIONS, CHECKED_FRICTIONS, *near
    return cached(Cache.of_user(), lambda: _computed(task), "creep-position", FORMAT, *parts)


@lru_cache(maxsize=1)
def _prepared(bodies: str) -> SpatialWheelset:
    prepared = Wheelset.model_validate_json(bodies).prepared()
    assert isinstance(prepared, SpatialWheelset)
    return prepared


def _computed(task: PositionTask) -> Arrays:
    result = solve_position(_prepared(task.case.model_dump_json()).at(task.own_case), {})
    if not result.status.converged:
        raise _refused(task, result.status)
    axle = np.append(result.equilibrium.position.axle(result.problem.wheels), 0.0)
    patches = sorted(result.patches, key=lambda patch: (SIDES.index(patch.side), -patch.rail_point_mm[0]))
    checks = task.kind == "check"
    friction = float(_random(task).uniform(*CHECKED_FRICTIONS)) if checks else FRICTION
    sampled = [SampledPatch(rolling_contact_of(patch, Friction(friction))) for patch in patches]
    rows = [_numbers(patch, forces, axle) for patch, forces in zip(patches, sampled, strict=True)]
    sides, more = np.array([row["side"] for row in rows]), []
    near = task.near if task.near is not None and np.array_equal(task.near["side"], sides) else None
    for number, patch in enumerate(sampled if task.kind != "contact" else ()):
        # the same creepages for the same position and side
        points = random_points(task.n_points, _random(task, sides[number]))
        if not checks:
            more.append(_sampled(patch, points, task.tolerance, None if near is None else near["beyond"][number]))
        else:
            beside = [sample for sample, side in zip(sampled, sides, strict=True) if side == sides[number]]
            more.append(_checked(patch, max(beside, key=lambda sample: sample.contact.force), points))
    arrays = {name: np.array([row[name] for row in rows]) for name in rows[0]}
    arrays |= {name: np.array([numbers[name] for numbers in more]) for name in (more[0] if more else ())}
    vertical, roll = result.equilibrium.position.vertical_mm, result.equilibrium.position.roll_rad
    return {**arrays, "axle": np.array([vertical, roll]), "friction": np.array(friction)}


def _random(task: PositionTask, *more: float) -> np.random.Generator:
    return np.random.default_rng([abs(round(1e6 * number)) for number in (*task.position, *more)])


def _refused(task: PositionTask, status: Status) -> InputError:
    lateral, yaw, load = task.position
    return InputError(
        f"lateral_mm = {lateral:g}, yaw_mrad = {yaw:g}, load_kN = {load:g}: {status.message}",
        "positions at which both wheels are in contact",
        "give a smaller range",
    )


def _numbers(patch: WheelPatch, sampled: SampledPatch, axle: Floats) -> dict[str, Any]:
    """Numbers of a patch, those of `OF_PATCH` and its side."""
    values = (
        sampled.contact.force, patch.contact_angle_rad, patch.state.pose.whole_roll, patch.rolling_radius_mm,
        patch.centre_mm - axle, patch.rail_point_mm, patch.wheel_point_mm, np.array(patch.semi_axes),
        patch.max_pressure, sampled.free, sampled.stiffness, sampled.radius,
    )  # fmt: skip
    return {"side": SIDES.index(patch.side), **dict(zip(OF_PATCH, values, strict=True))}


def _sampled(patch: SampledPatch, points: Floats, tolerance: float, near: Floats | None) -> dict[str, Any]:
    """Forces at all creepages, with as many exact solutions as the tolerance needs."""
    forces, errors, directions = refined(patch, points, tolerance, near)
    return {
        "forces": forces.forces.astype(np.float32), "beyond": forces.beyond.astype(np.float32),
        "directions": directions,
        "n_exact": patch.n_exact, "n_failed": patch.n_failed,
        "force_errors": errors.force, "moment_errors": errors.moment,
    }  # fmt: skip


def _checked(patch: SampledPatch, most: SampledPatch, points: Floats) -> dict[str, Any]:
    """Exact forces at creepages, of all patches of a side those of the most loaded one: longitudinal, lateral, spin."""
    motions = [most.motion(*point).moved(*most.free.tolist()) for point in points.tolist()]
    rollings = [roll(patch.bodies, motion) for motion in motions]
    return {
        "creepages": np.array([(motion.along, motion.across, motion.spin) for motion in motions]),
        "exact": np.array([(rolling.along, rolling.across, rolling.moment) for rolling in rollings]),
    }
