"""A wheel S1002 on a rail 60E1: true profiles, cut to blocks, beside C3D20 of CalculiX."""

from collections.abc import Iterator

import numpy as np

from flangeway.contact.patch.patch_body import Axis, PatchBody
from flangeway.contact.patch.patch_contact import PatchContact, press_patch
from flangeway.contact.patch.patch_grid import grid_about
from flangeway.geometry import Contour, Outline, Placement
from flangeway.railway.profiles.bundled import rail, wheel
from flangeway.railway.profiles.whole_outline import pieces_between
from flangeway.railway.track.placements import Track
from flangeway.types import Floats
from studies.spatial.patches import HERTZ_STEEL, calculix, patch_body
from studies.study import Row

GAUGE, GAUGE_DEPTH, INCLINATION, BACK_TO_BACK, RADIUS = 1435.0, 14.0, 1.0 / 40.0, 1360.0, 460.0
LATERAL = 2.0
"""Of the wheelset from the middle of the track in mm: the patch lies on two arcs of the rail's crown."""
HALF, DEPTH, LENGTH = 16.0, 25.0, 60.0
"""Half width of the blocks about the contact, their depth behind it, and their length along the rail in mm."""
APPROACH = 0.07
"""From first touch in mm."""
EDGES, CELL, WINDOW = (0.25, 3.0), 0.3, (16.8, 16.8)
"""Edges in the contact and elsewhere, cells, and window in mm."""
MESHES = ("1.2", "0.8")
"""Edges of CalculiX's elements in mm."""
LIMIT, PLACE = 0.02, 0.05
"""Largest relative difference, and distance of the centres of pressure in mm."""


def cut_surfaces() -> tuple[Contour, Contour, float]:
    """Surfaces of rail and wheel within the blocks, their first touch at the origin, and the height of the axle."""
    track, profile = Track(rail("60E1"), GAUGE, INCLINATION, gauge_depth_mm=GAUGE_DEPTH), wheel("S1002")
    place = Placement(translation=(BACK_TO_BACK / 2.0 + profile.flange_back_mm + LATERAL, 0.0))
    lower = track.rail.running_surface.transformed(track.placement("right"))
    upper = profile.running_surface.transformed(place)
    x = np.arange(lower.bounds()[0, 0] + 1.0, lower.bounds()[1, 0] - 1.0, 1e-3)
    low, high = heights(lower, x), heights(upper, x)
    first = int((high - low).argmin())
    moves = [Placement(translation=(-x[first], -float(each[first]))) for each in (low, high)]
    lower, upper = (_cut(each.transformed(move)) for each, move in zip((lower, upper), moves, strict=True))
    return lower, upper, RADIUS - float(high[first])


def heights(surface: Contour, x: Floats) -> Floats:
    """Heights of a surface at places x, to 1e-7 mm."""
    points = surface.sampled(spacing=2e-3)
    order = np.argsort(points[:, 0])
    return np.interp(x, points[order, 0], points[order, 1])


def _cut(surface: Contour) -> Contour:
    """The piece of a surface between -HALF and HALF."""
    places = np.array([[x, heights(surface, np.array([x]))[0]] for x in (-HALF, HALF)])
    segments = [segment for _, segment in pieces_between(surface, *sorted(surface.lengths_at(places).tolist()))]
    return Contour.from_segments(segments, ["surface"] * len(segments))


def profile_blocks() -> tuple[PatchBody, PatchBody]:
    """Rail held at its base, and wheel held on top, as prism and body of revolution."""
    *cut, axle = cut_surfaces()
    bodies = []
    for name, surface, level in zip(("rail", "wheel"), cut, (-DEPTH, DEPTH), strict=True):
        start, end = surface.ends
        corners, names = [(end[0], level), (start[0], level)], [*surface.names, "side", "held", "other side"]
        points = surface.sampled(spacing=0.2)
        zone = points[np.abs(points[:, 0]) < WINDOW[0] / 2.0 + 1.0]
        axis = Axis((0.0, axle)) if level > 0.0 else None
        outline = Outline.closed(surface.segments, corners, names)
        bodies.append(patch_body(name, outline, HERTZ_STEEL, zone, EDGES, axis))
    return bodies[0], bodies[1]


def pressed_profiles() -> PatchContact:
    """Both blocks under the force that CalculiX found."""
    bodies = profile_blocks()
    return press_patch(*bodies, force=calculix("profile", MESHES)["force"][0], grid=grid_about(*bodies, CELL, WINDOW))


def profile_numbers(found: PatchContact) -> Iterator[Row]:
    """Maximum pressure, semi-axes, centre and approach beside CalculiX under the same force."""
    (patch,), peer = found.patches, calculix("profile", MESHES)
    values = {"p0": patch.max_pressure, "along": patch.semi_axes[0], "across": patch.semi_axes[1]}
    for name, value in values.items():
        exact, note = peer[name]
        yield Row("S1002 on 60E1", "blocks", name, "MPa" if name == "p0" else "mm", value, exact, LIMIT, note)
    note = f"under {peer['force'][0]:.0f} N"
    yield Row("S1002 on 60E1", "blocks", "approach", "mm", found.contact.approach, APPROACH, LIMIT, note)
    centre = peer["x"][0], patch.centre[0]
    words, note = f"{PLACE:g} mm", "centre of pressure from first touch"
    yield Row("S1002 on 60E1", "blocks", "x", "mm", centre[1], centre[0], words, note)
