"""One position of a wheelset for a table: its patches without friction, and creep forces of each."""

from collections.abc import Mapping
from dataclasses import dataclass
from functools import lru_cache
from typing import Any

import numpy as np
from numpy.typing import NDArray

from flangeway.cases.wheelset.spatial_wheelset_case import SpatialWheelsetCase
from flangeway.contact.rolling.creepages import Creepages
from flangeway.contact.rolling.friction import Friction
from flangeway.errors import InputError
from flangeway.railway.track.placements import SIDES
from flangeway.railway.track.wheelset_problem import Prescribed
from flangeway.railway.wheelset.rolling.patch_rolling import rolling_contact_of
from flangeway.railway.wheelset.running_surfaces import running_surfaces
from flangeway.railway.wheelset.spatial_result import solve_position
from flangeway.railway.wheelset.spatial_wheelset import SpatialWheelset
from flangeway.railway.wheelset.wheel_patch import SpatialPatch
from flangeway.solve import Status
from flangeway.system.disk_cache import Cache, content_key
from flangeway.tables import creep_sampling
from flangeway.tables.creep_sampling import SampledPatch, check, random_points, sample
from flangeway.tables.creep_table import FORMAT, OF_PATCH
from flangeway.types import Floats

FRICTION = 0.3
"""For which forces are computed; over the limit of friction they are functions of creepages over it."""

Arrays = Mapping[str, NDArray[Any]]


@dataclass(frozen=True)
class PositionTask:
    """What is to be computed at a position.

    - `position`: lateral position in mm, yaw in mrad, axle load in kN.
    - `kind`: ``contact``; ``table``, with forces at all creepages; ``check``, with forces at some random creepages.
    - `tolerance`: of the table, over the limit of friction.
    - `n_points`: number of random creepages of each patch.
    """

    case: SpatialWheelsetCase
    position: tuple[float, float, float]
    kind: str = "contact"
    tolerance: float = 1.0
    n_points: int = 0

    @property
    def own_case(self) -> SpatialWheelsetCase:
        """The case at this position."""
        lateral, yaw, load = self.position
        values = {"lateral_mm": lateral, "yaw_mrad": yaw, "axle_load_kN": load}
        return SpatialWheelsetCase.from_values({**self.case.model_dump(exclude_unset=True), **values})


def compute_position(task: PositionTask) -> Arrays:
    """Patches from the left side to the right, on each from the field side to the gauge side; kept in the cache.

    Raises
    ------
    InputError
        If there is no contact at the position that a table may have.

    """
    cache = Cache.of_user()
    parts = task.own_case.model_dump_json(), task.kind, task.tolerance, task.n_points
    key = content_key("creep-position", FORMAT, *parts, *creep_sampling.AXES, creep_sampling.DIRECTIONS)
    return _computed(task) if cache is None or key is None else cache.get(key, lambda: _computed(task))


@lru_cache(maxsize=1)
def _prepared(bodies: str) -> SpatialWheelset:
    case = SpatialWheelsetCase.model_validate_json(bodies)
    problem, model = case.problem(), case.spatial_model()
    return SpatialWheelset(problem, running_surfaces(problem, model, cache=Cache.of_user()), model)


def _computed(task: PositionTask) -> Arrays:
    case = task.own_case
    prescribed = Prescribed(case.lateral_mm, None, None)
    whole = _prepared(task.case.model_dump_json()).at(case.load(), prescribed, case.spatial_model().yaw_rad)
    result = solve_position(whole, {})
    if not result.status.converged:
        raise _refused(task, result.status)
    axle = np.append(result.equilibrium.position.axle(whole.problem.wheelset), 0.0)
    patches = sorted(result.patches, key=lambda patch: (SIDES.index(patch.side), -patch.rail_point_mm[0]))
    rows, more = [], []
    for number, patch in enumerate(patches):
        sampled = SampledPatch(rolling_contact_of(patch, Friction(FRICTION)))
        rows.append(_numbers(patch, sampled, axle))
        if task.kind != "contact":
            # the same creepages for the same position, others for every patch
            random = np.random.default_rng([abs(round(1e6 * each)) for each in (*task.position, number)])
            more.append((_sampled if task.kind == "table" else _checked)(sampled, task, random))
    found = {name: np.array([row[name] for row in rows]) for name in rows[0]}
    found |= {name: np.array([each[name] for each in more]) for name in (more[0] if more else ())}
    vertical, roll = result.equilibrium.position.vertical_mm, result.equilibrium.position.roll_rad
    return {**found, "axle": np.array([vertical, roll])}


def _refused(task: PositionTask, status: Status) -> InputError:
    lateral, yaw, load = task.position
    return InputError(
        f"lateral_mm = {lateral:g}, yaw_mrad = {yaw:g}, load_kN = {load:g}: {status.message}",
        "positions at which both wheels are in contact",
        "give a smaller range",
    )


def _numbers(patch: SpatialPatch, sampled: SampledPatch, axle: Floats) -> dict[str, Any]:
    """Numbers of a patch, those of `OF_PATCH` and its side."""
    values = (
        sampled.contact.force, patch.contact_angle_rad, patch.state.pose.whole_roll, patch.rolling_radius_mm,
        patch.centre_mm - axle, patch.rail_point_mm, patch.wheel_point_mm, np.array(patch.ellipse.semi_axes),
        patch.ellipse.max_pressure, sampled.free, sampled.stiffness, sampled.radius,
    )  # fmt: skip
    return {"side": SIDES.index(patch.side), **dict(zip(OF_PATCH, values, strict=True))}


def _sampled(patch: SampledPatch, task: PositionTask, random: np.random.Generator) -> dict[str, Any]:
    """Forces at all creepages, with as many exact solutions as the tolerance needs."""
    points = random_points(task.n_points, random)
    for directions in creep_sampling.DIRECTIONS:
        found = sample(patch, directions, creep_sampling.AXES)
        errors = check(patch, found, points, creep_sampling.AXES)
        if errors.expected_maximum <= task.tolerance:
            break
    return {
        "forces": found.forces.astype(np.float32), "directions": directions, "n_exact": found.n_exact,
        "n_failed": found.n_failed, "force_errors": errors.force, "moment_errors": errors.moment,
    }  # fmt: skip


def _checked(patch: SampledPatch, task: PositionTask, random: np.random.Generator) -> dict[str, Any]:
    """Exact forces at random creepages: longitudinal, lateral, spin; along, across, moment over the limit."""
    found = [patch.coupled(*point) for point in random_points(task.n_points, random).tolist()]
    motions: list[Creepages] = [each.motion for each in found]
    return {
        "creepages": np.array([(each.along, each.across, each.spin) for each in motions]),
        "exact": np.array([(each.along, each.across, each.moment) for each in found]),
    }
