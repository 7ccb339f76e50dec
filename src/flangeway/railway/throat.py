"""Other radii of the throat beside the flange of the approximate AAR-1B."""

import math
from dataclasses import replace

import numpy as np

from flangeway.errors import InputError
from flangeway.geometry import Arc, Line, Outline, Segment
from flangeway.geometry.arrays import as_point
from flangeway.railway.flange_root import IDENTIFIED
from flangeway.railway.profiles import WheelProfile


def with_wide_throat(profile: WheelProfile, radius_mm: float) -> WheelProfile:
    """Return an AAR-1B with another radius of the wide arc between tread and narrow arc, tangent to both.

    Parameters
    ----------
    profile
        Wheel with segments ``throat_R1``, ``throat_R2`` and ``tread_1:20``.
    radius_mm
        Radius, larger than that of the narrow arc.

    Raises
    ------
    InputError
        If the wheel has no such arcs, or no arc of the radius is tangent to both neighbours.

    """
    parts: dict[str, Segment] = dict(zip(profile.outline.names, profile.outline.segments, strict=True))
    narrow, wide, tread = (parts.get(part) for part in ("throat_R1", "throat_R2", "tread_1:20"))
    if profile.title == IDENTIFIED or not (
        isinstance(narrow, Arc) and isinstance(wide, Arc) and isinstance(tread, Line)
    ):
        raise InputError(f"wide_throat_radius_mm for {profile.title}", "AAR-1B", "leave it out")
    along, off = tread.tangent(0.0)[0], tread.normal(0.0)[0]
    # the outline has the wheel on its left: the throat's hollow arcs have their centres on its right
    arm = np.array(narrow.centre) - np.array(tread.start)
    depth, place = float(arm @ off), float(arm @ along)
    square = (radius_mm - narrow.radius) ** 2 - (radius_mm - depth) ** 2
    if radius_mm <= narrow.radius or square <= 0.0:
        raise InputError(
            f"wide_throat_radius_mm = {radius_mm:g}",
            f"more than {0.5 * (narrow.radius + depth):.1f} mm",
            "leave it out for 38.1 mm",
        )
    foot = np.array(tread.start) + (place + math.sqrt(square)) * along
    centre = foot + radius_mm * off
    ray = np.array(narrow.centre) - centre
    joint = as_point(centre + radius_mm * ray / np.hypot(*ray))
    parts["throat_R1"] = Arc(narrow.start, joint, narrow.centre, narrow.counter_clockwise)
    parts["throat_R2"] = Arc(joint, as_point(foot), as_point(centre), wide.counter_clockwise)
    parts["tread_1:20"] = Line(as_point(foot), tread.end)
    return replace(profile, outline=Outline.from_segments(parts.values(), parts.keys()))
