"""Where the rigid wheelset rests and nearly touches, kept from one process to the next."""

import math
from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from flangeway.railway.rigid.elastic_start import CLIMBED_MM, CLIMBING_RAD, SCAN_MM, RigidStart, rigid_start
from flangeway.railway.rigid.rigid_contact import RigidWheelset
from flangeway.railway.track.placements import SIDES, WheelsetMotion
from flangeway.railway.track.wheelset_problem import WheelsetProblem
from flangeway.system.disk_cache import Arrays, Cache, content_key
from flangeway.types import Floats

FLANGE_MM = 1.0
"""How much farther than a rigid one an elastic wheelset may go sideways."""

CLOSE_MM = 0.2
"""Gap at the rigid rest that elastic bodies close."""

MARGIN_MM = 8.0
"""Gap at the rigid rest within which a second place may come into contact: flanges may push the rails apart."""


@dataclass(frozen=True, eq=False)
class CachedRigidStart:
    """What a model takes from the rigid wheelset.

    Parameters
    ----------
    rest
        Where it rests.
    relative_curvature_per_mm
        See `RigidStart`.
    places
        Points that touch or nearly touch by the part's name, in its profile's frame, each (n, 2).
    close
        Points about those that touch with a gap below `CLOSE_MM`, likewise: where worn profiles conform they reach
        farther than curvatures at the touch tell.

    """

    rest: RigidStart
    relative_curvature_per_mm: float
    places: Mapping[str, Floats]
    close: Mapping[str, Floats]


def cached_rigid_start(problem: WheelsetProblem, cache: Cache | None) -> CachedRigidStart:
    """Find them, or take what was found before for the same profiles, track, load and prescribed motion.

    Raises
    ------
    InputError
        As `rigid_start`.

    """
    numbers = (FLANGE_MM, CLOSE_MM, MARGIN_MM, SCAN_MM, CLIMBING_RAD, CLIMBED_MM)
    key = content_key("rest", problem.track, problem.wheelset, problem.load, problem.prescribed, numbers)
    if cache is None or key is None:
        return _found(problem)
    arrays = cache.load(key)
    if arrays is not None:
        return _unpacked(problem, arrays)
    found = _found(problem)
    arrays = {f"at {name}": places for name, places in found.places.items()}
    arrays |= {f"close {name}": places for name, places in found.close.items()}
    arrays["starts"] = np.array([motion.components for motion in found.rest.starts])
    arrays["curvature"] = np.array(found.relative_curvature_per_mm)
    cache.store(key, arrays)
    return found


def _found(problem: WheelsetProblem) -> CachedRigidStart:
    rest = rigid_start(problem)
    lateral = rest.motion.lateral_mm
    lateral_offset = math.copysign(FLANGE_MM, lateral) if abs(lateral) > FLANGE_MM else 0.0
    near = rest.near_places((0.0, 0.5 * lateral_offset, lateral_offset) if lateral_offset else (0.0,), MARGIN_MM)
    places = {f"{role}-{side}": near[side][number] for side in SIDES for number, role in enumerate(("wheel", "rail"))}
    close = rest.close_places(CLOSE_MM)
    around = {f"{role}-{side}": close[side][number] for side in SIDES for number, role in enumerate(("wheel", "rail"))}
    return CachedRigidStart(rest, rest.relative_curvature_per_mm, places, around)


def _unpacked(problem: WheelsetProblem, arrays: Arrays) -> CachedRigidStart:
    starts = tuple(WheelsetMotion(*(float(each) for each in row)) for row in arrays["starts"])
    load = problem.load if problem.prescribed.lateral_mm is None else None
    rest = RigidStart(RigidWheelset.of(problem.track, problem.wheelset), starts, load)
    places, close = (
        {name.removeprefix(kind): array for name, array in arrays.items() if name.startswith(kind)}
        for kind in ("at ", "close ")
    )
    return CachedRigidStart(rest, float(arrays["curvature"]), places, close)
