"""The AAR-1B with other arcs of its flange root, of which one is identified from a published position."""

import math
from dataclasses import replace
from typing import cast

import numpy as np
from numpy.typing import NDArray

from flangeway.errors import InputError
from flangeway.geometry import Arc, Line, Outline, Placement, Segment
from flangeway.geometry.arrays import Point, as_point, norms
from flangeway.railway.profiles.bundled import IDENTIFIED, WheelProfile

GAUGE_HEIGHT_MM = 9.525  # depth below the tape line, 3/8 in, at which the standard measures the flange's thickness


def with_flange_root(profile: WheelProfile, wide_radius_mm: float) -> WheelProfile:
    """Return an AAR-1B with another radius of the wide arc of its flange root, the arcs moved so that all fits.

    Taper, height, thickness and angle of the flange stay, the radius of the narrow arc and the slope (30 degrees) at
    which it follows the wide one too. Narrow arc and flange face move by what keeps the thickness at `GAUGE_HEIGHT_MM`.
    An `InputError` if the wheel has no such arcs, or they do not fit between tread and tip of the flange.

    - `profile`: wheel with segments ``flange_root_R1``, ``flange_root_R2`` and ``tread_1:20``.
    - `wide_radius_mm`: radius of the wide arc.
    """
    parts, narrow, wide, tread = _root_of(profile, "another flange root")
    face, tip, land = parts["flange_face_75deg"], cast(Arc, parts["flange_tip_front"]), parts["flange_tip_land"]
    factor = wide_radius_mm / wide.radius
    along = tread.tangent(0.0)[0]
    grown = (factor - 1.0) * (np.array(wide.start) - wide.end)
    gauge = _gauge_point(narrow)
    arm = np.array(narrow.centre) + grown - gauge
    square = float(arm @ along) ** 2 - float(arm @ arm) + narrow.radius**2
    if wide_radius_mm > narrow.radius and square > 0.0:
        on_tread = (np.sqrt(square) - float(arm @ along)) * along
        moved = grown + on_tread
        foot = np.array(tread.start) + on_tread
        slope = face.tangent(0.0)[0]
        above_tip = narrow.start[1] + moved[1] - tip.end[1]
        shift = np.array((moved[0] - moved[1] * slope[0] / slope[1], 0.0))
        if (
            above_tip > 0.0 > narrow.start[1] + moved[1] + GAUGE_HEIGHT_MM
            and foot[0] < tread.end[0]
            and (narrow.end[1] + moved[1] > -GAUGE_HEIGHT_MM)
        ):
            centre = foot + factor * (np.array(wide.centre) - wide.end)
            parts["flange_tip_land"] = Line(land.start, _moved(land.end, shift))
            parts["flange_tip_front"] = tip.transformed(Placement(translation=as_point(shift)))
            parts["flange_face_75deg"] = Line(_moved(tip.end, shift), _moved(narrow.start, moved))
            parts["flange_root_R1"] = narrow.transformed(Placement(translation=as_point(moved)))
            parts["flange_root_R2"] = Arc(
                _moved(narrow.end, moved), as_point(foot), as_point(centre), wide.counter_clockwise
            )
            parts["tread_1:20"] = Line(as_point(foot), tread.end)
            return replace(profile, outline=Outline.named(parts.items()))
    raise InputError(
        f"a wide arc of {wide_radius_mm:g} mm in the flange root of {profile.title}",
        "a radius, such as 30 to 60 mm, with which the flange keeps its height, thickness and angle",
        "leave it out for that of the file",
    )


def with_wide_flange_root(profile: WheelProfile, radius_mm: float) -> WheelProfile:
    """Return an AAR-1B with another radius of the wide arc between tread and narrow arc, tangent to both.

    The narrow arc keeps its place, and the slope between the arcs changes; see `with_flange_root` for the other way. An
    `InputError` if the wheel has no such arcs, or no arc of the radius is tangent to both neighbours.

    - `profile`: wheel with segments ``flange_root_R1``, ``flange_root_R2`` and ``tread_1:20``.
    - `radius_mm`: radius, larger than that of the narrow arc.
    """
    parts, narrow, wide, tread = _root_of(profile, "a wide arc of the flange root", but=IDENTIFIED)
    along, off = tread.tangent(0.0)[0], tread.normal(0.0)[0]
    # the outline has the wheel on its left: the flange root's hollow arcs have their centres on its right
    arm = np.array(narrow.centre) - np.array(tread.start)
    depth, along_arm = float(arm @ off), float(arm @ along)
    square = (radius_mm - narrow.radius) ** 2 - (radius_mm - depth) ** 2
    if radius_mm <= narrow.radius or square <= 0.0:
        raise InputError(
            f"a wide arc of {radius_mm:g} mm",
            f"more than {0.5 * (narrow.radius + depth):.1f} mm",
            "leave it out for 38.1 mm",
        )
    foot = np.array(tread.start) + (along_arm + math.sqrt(square)) * along
    centre = foot + radius_mm * off
    ray = np.array(narrow.centre) - centre
    joint = as_point(centre + radius_mm * ray / norms(ray))
    parts["flange_root_R1"] = Arc(narrow.start, joint, narrow.centre, narrow.counter_clockwise)
    parts["flange_root_R2"] = Arc(joint, as_point(foot), as_point(centre), wide.counter_clockwise)
    parts["tread_1:20"] = Line(as_point(foot), tread.end)
    return replace(profile, outline=Outline.named(parts.items()))


def _root_of(profile: WheelProfile, wanted: str, but: str = "") -> tuple[dict[str, Segment], Arc, Arc, Segment]:
    """Return all segments by name; narrow arc, wide arc and tread.

    An `InputError` for what is wanted if the wheel has no such segments, or is the one called `but`.
    """
    parts = profile.outline.by_name
    if profile.title == but or "flange_face_75deg" not in parts:
        raise InputError(f"{wanted} for {profile.title}", "AAR-1B", "leave it out")
    return parts, cast(Arc, parts["flange_root_R1"]), cast(Arc, parts["flange_root_R2"]), parts["tread_1:20"]


def _gauge_point(narrow: Arc) -> NDArray[np.float64]:
    """Return the point of the narrow arc at which the flange's thickness is measured."""
    lateral_offset = float(np.sqrt(narrow.radius**2 - (narrow.centre[1] + GAUGE_HEIGHT_MM) ** 2))
    return np.array((narrow.centre[0] - lateral_offset, -GAUGE_HEIGHT_MM))


def _moved(point: Point, shift: NDArray[np.float64]) -> Point:
    return as_point(np.array(point) + shift)
