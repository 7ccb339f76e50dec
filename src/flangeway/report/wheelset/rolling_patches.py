"""The patches of a wheelset that rolls: pictures and numbers of friction."""

from flangeway.cases.wheelset.wheelset_quantities import patch_name
from flangeway.cases.wheelset.wheelset_run import WheelsetRun
from flangeway.contact.rolling.fastsim import SimplifiedRolling
from flangeway.contact.rolling.rolling_result import Rolling
from flangeway.railway.track.placements import SIDE_SIGN
from flangeway.report.page.record import Figures, Picture
from flangeway.report.rolling.rolling_maps import ShownRolling, rolling_figure
from flangeway.report.rolling.shakedown_figure import shakedown_figure
from flangeway.report.wheelset.wheelset_patches import patch_map

MAPS, SHAKEDOWN = "rolling.png", "shakedown.png"
CAPTIONS = {
    MAPS: "Each patch from above, ahead is up: where it sticks and slips, with arrows of the tractions on the wheel; "
    "slip velocity; frictional power over the area.",
    SHAKEDOWN: "Maximum pressure over the shear strength and traction coefficient of each patch, among the limits of "
    "a circular patch and of a line contact. Above the highest limit steel yields under each wheel.",
}
AXES = {
    "creepage": "and creep force: of the wheel on the rail: ahead, and along the rail's surface to the right; spin "
    "and its moment counter-clockwise seen from above",
    "T-gamma": "energy that friction dissipates over the distance rolled: its power over the speed; N is J/m. Without "
    "and with spin: creep forces times creepages at the centre of the patch, and spin moment times spin",
}


def rolling_pictures(run: WheelsetRun) -> list[Picture]:
    """Pictures of the patches that roll; none without friction."""
    result, strength, units = run.space, run.space.yield_MPa, run.case.units
    # right of the track to the right, lengths from the middle of the rail's profile
    shown = [
        ShownRolling(
            patch_name(each.patch),
            each.forces,
            each.speed_m_s,
            patch_map(result, each.patch.side).origin,
            SIDE_SIGN[each.patch.side],
        )
        for each in result.rolling
        if isinstance(each.forces, Rolling | SimplifiedRolling)
    ]
    points = [(patch_name(each.patch), each.used_friction, each.patch.ellipse.max_pressure) for each in result.rolling]
    figures: Figures = {}
    if shown:
        figures[MAPS] = lambda: rolling_figure(shown, units)
    if points and strength is not None:
        figures[SHAKEDOWN] = lambda: shakedown_figure(points, strength, units)
    return [Picture(name, draw, CAPTIONS[name], chapter="Rolling") for name, draw in figures.items()]
