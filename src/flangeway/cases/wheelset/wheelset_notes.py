"""What the inputs of a wheelset imply, and what is unusual about them, in sentences."""

from flangeway.railway.profiles.bundled import RailProfile, WheelProfile
from flangeway.railway.profiles.named import as_paths
from flangeway.railway.profiles.profile_file import FIELD_WORN, MIRRORED, side_notices
from flangeway.railway.track.placements import SIDES, RigidTrack, usual_gauge
from flangeway.railway.track.wheelset_loads import FromSpeed, superelevation_angle
from flangeway.railway.track.wheelset_problem import WheelsetOnTrack


def gauge_note(track: RigidTrack) -> str:
    """Return where the gauge is measured, in a sentence."""
    heads = "unworn rails" if track.gauge_at == "unworn" else "rails"
    left, right = (track.gauge_point(side).depth_mm for side in SIDES)
    width = track.measured_gauge_mm
    text = f"The gauge of {track.gauge_mm:g} mm is measured {left:.2f} (left) and {right:.2f} mm (right) below the "
    text += f"tops of the {heads}"
    if width is not None and track.gauge_at != "within-depth":
        text += f"; down to {track.gauge_depth_mm:g} mm below the tops the heads are {width:.2f} mm apart"
    return f"{text}."


def profile_notes(wheelset: WheelsetOnTrack) -> list[str]:
    """Return where the gauge is measured, how far the profiles can be trusted, and what was assumed of their files."""
    track = wheelset.track
    wheels = [wheelset.wheelset.wheel_of(side) for side in SIDES[::-1]]
    rails = [track.rail_of(side) for side in SIDES[::-1]]
    profiles: dict[RailProfile | WheelProfile, None] = dict.fromkeys([*wheels, *rails])
    return [
        gauge_note(track),
        *(f"{'Wheel' if profile in wheels else 'Rail'} {profile.title}. {profile.certainty}" for profile in profiles),
        *(
            notice + f" ({profile.title})"
            for profile in profiles
            for notice in profile.notices
            if not notice.startswith((MIRRORED, FIELD_WORN))
        ),
    ]


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
    """Return in sentences what follows from other inputs: distance of the wheels and base of the superelevation."""
    track, sentences = wheelset.track, list[str]()
    if wheelset.wheelset.back_to_back_mm is None:
        usual = usual_gauge(track.gauge_mm)
        distance, gauge = f"{usual.back_to_back_mm:g} mm", f"{track.gauge_mm:g} mm"
        sentences.append(f"Back to back {distance}, from the gauge of {gauge}: {usual.source}.")
    load, base = wheelset.load, track.base_mm
    height = load.superelevation_mm if load.curve is None else load.curve.height_mm(base)
    if height:
        which = "track.superelevation_base_mm"
        if track.superelevation_base_mm is None:
            which = "the gauge and 65 mm, the distance of the running circles"
        tilt = superelevation_angle(height, base)
        sentences.append(
            f"Superelevation {height:.4g} mm over a base of {base:g} mm: {which}, tilt of the track {tilt:.5f} rad."
        )
    return sentences


def unusual(wheelset: WheelsetOnTrack) -> list[str]:
    """Return what is unusual about the inputs, in sentences."""
    curve = wheelset.load.curve
    if curve is None or isinstance(curve.superelevation_mm, FromSpeed) or curve.superelevation_mm >= 0.0:
        return []
    height = curve.superelevation_mm
    return [f"superelevation_mm = {height:g}: adverse cant, the inner rail of the curve is {-height:g} mm higher"]
