"""Where the rigid wheelset rests and nearly touches, kept from one process to the next."""

import math
from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from flangeway.railway.rigid.elastic_start import CLIMBED_MM, CLIMBING_RAD, SCAN_MM, RigidRest, rigid_rest
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
class KnownRest:
    """What a model takes from the rigid wheelset.

    Parameters
    ----------
    rest
        Where it rests.
    relative_curvature_per_mm
        See `RigidRest`.
    places
        Points that touch or nearly touch by the part's name, in its profile's frame, each (n, 2).
    close
        Points about those that touch with a gap below `CLOSE_MM`, likewise: where worn profiles conform they reach
        farther than curvatures at the touch tell.

    """

    rest: RigidRest
    relative_curvature_per_mm: float
    places: Mapping[str, Floats]
    close: Mapping[str, Floats]


def known_rest(problem: WheelsetProblem, cache: Cache | None) -> KnownRest:
    """Find them, or take what was found before for the same profiles, track, load and prescribed motion.

    Raises
    ------
    InputError
        As `rigid_rest`.

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


def _found(problem: WheelsetProblem) -> KnownRest:
    rest = rigid_rest(problem)
    lateral = rest.motion.lateral_mm
    aside = math.copysign(FLANGE_MM, lateral) if abs(lateral) > FLANGE_MM else 0.0
    near = rest.near_places((0.0, 0.5 * aside, aside) if aside else (0.0,), MARGIN_MM)
    places = {f"{role}-{side}": near[side][number] for side in SIDES for number, role in enumerate(("wheel", "rail"))}
    close = rest.close_places(CLOSE_MM)
    around = {f"{role}-{side}": close[side][number] for side in SIDES for number, role in enumerate(("wheel", "rail"))}
    return KnownRest(rest, rest.relative_curvature_per_mm, places, around)


def _unpacked(problem: WheelsetProblem, arrays: Arrays) -> KnownRest:
    starts = tuple(WheelsetMotion(*(float(each) for each in row)) for row in arrays["starts"])
    load = problem.load if problem.prescribed.lateral_mm is None else None
    rest = RigidRest(RigidWheelset.of(problem.track, problem.wheelset), starts, load)
    places, close = (
        {name.removeprefix(kind): array for name, array in arrays.items() if name.startswith(kind)}
        for kind in ("at ", "close ")
    )
    return KnownRest(rest, float(arrays["curvature"]), places, close)
