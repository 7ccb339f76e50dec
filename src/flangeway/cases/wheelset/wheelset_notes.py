"""What the inputs of a wheelset imply, and what is unusual about them, in sentences."""

from flangeway.railway.profiles.named import as_paths
from flangeway.railway.profiles.profile_file import FIELD_WORN, MIRRORED, side_notices
from flangeway.railway.track.placements import SIDES, RigidTrack, usual_gauge
from flangeway.railway.track.wheelset_loads import FromSpeed, superelevation_angle
from flangeway.railway.track.wheelset_problem import WheelsetOnTrack
from flangeway.system.templates import sentences


def side_warnings(track: RigidTrack) -> list[str]:
    """Return a warning for each rail that was mirrored, or is worn more at the side that no flange reaches."""
    paths = {"track.rail" if track.side(side).rail is None else f"track.{side}.rail": side for side in SIDES[::-1]}
    warnings = []
    for path, side in paths.items():
        rail = track.rail_of(side)
        mirrored = [notice for notice in rail.notices if notice.startswith(MIRRORED)]
        warnings += [as_paths(notice, path) for notice in mirrored or side_notices(rail.running_surface)]
    return warnings


def derived(wheelset: WheelsetOnTrack) -> list[str]:
    """Return in sentences what follows from other inputs, where the gauge is measured, and what profiles assume."""
    track, load = wheelset.track, wheelset.load
    height = load.superelevation_mm if load.curve is None else load.curve.height_mm(track.base_mm)
    wheels = [wheelset.wheelset.wheel_of(side) for side in SIDES[::-1]]
    return sentences(
        "flangeway.cases.wheelset",
        "notes.txt",
        wheelset=wheelset,
        usual_gauge=usual_gauge,
        height=height,
        tilt=superelevation_angle(height, track.base_mm),
        depths=[track.gauge_point(side).depth_mm for side in SIDES],
        wheels=wheels,
        profiles=dict.fromkeys([*wheels, *(track.rail_of(side) for side in SIDES[::-1])]),
        of_side=(MIRRORED, FIELD_WORN),
    )


def unusual(wheelset: WheelsetOnTrack) -> list[str]:
    """Return what is unusual about the inputs, in sentences."""
    curve = wheelset.load.curve
    if curve is None or isinstance(curve.superelevation_mm, FromSpeed) or curve.superelevation_mm >= 0.0:
        return []
    height = curve.superelevation_mm
    return [f"superelevation_mm = {height:g}: adverse cant, the inner rail of the curve is {-height:g} mm higher"]
