"""Pieces of closed outlines, and a rail or wheel from one: its head, base, running surface and cut."""

from dataclasses import replace

import numpy as np

from flangeway.errors import InputError
from flangeway.geometry import Contour, FloatArray, Line, Outline, Placement, Point, Segment, as_point
from flangeway.railway.profiles.bundled import RailProfile, WheelProfile
from flangeway.railway.profiles.profile_file import MeasuredProfile, side_notices

_HEAD_SHARE = 0.6  # of the height: above it the widest point belongs to the head
_SAME = 1e-6
_FLAT = 1e-6
_SPACING_MM = 0.05


def whole_profile(measured: MeasuredProfile) -> RailProfile | WheelProfile:
    """Return a rail or wheel whose file holds its whole outline.

    A rail's origin is put to the middle of its base. Its head reaches from the widest point of the upper part at one
    side over the top to that at the other; its base are the sides at the lowest height. A wheel's running surface is
    all but the straight cut on top and the upright faces below it. An `InputError` if the file holds a running surface
    only, a rail has no flat base, or a wheel no level cut.
    """
    outline = measured.surface
    if not isinstance(outline, Outline):
        raise InputError(
            "a running surface without a body", "a closed outline", "join it to a nominal rail or wheel with --join"
        )
    certainty, source = "As the file draws it.", f"File: {measured.format}."
    if measured.kind == "rail":
        whole = _rail(outline, measured.title, certainty, source)
        return replace(whole, notices=(*measured.notices, *side_notices(whole.running_surface)))
    profile = _wheel(outline, measured.title, measured.flange_back_mm, certainty, source)
    return replace(profile, notices=measured.notices)


def _rail(outline: Outline, title: str, certainty: str, source: str) -> RailProfile:
    low = outline.bounds()[0]
    size = outline.size
    base = [i for i, segment in enumerate(outline.segments) if segment.bounds[1, 1] - low[1] <= _FLAT * size]
    if not base:
        raise InputError("a rail without a flat base", "a straight side at the lowest height", "check the outline")
    ends = np.array([p for i in base for p in (outline.segments[i].start, outline.segments[i].end)])
    middle = 0.5 * float(ends[:, 0].min() + ends[:, 0].max())
    shifted = outline.transformed(Placement(translation=(-middle, -float(low[1]))))
    named = _renamed(shifted, dict.fromkeys(base, "base"), "side")
    field, gauge = _widest(named, 1.0), _widest(named, -1.0)
    pieces = [("head", segment) for _, segment in pieces_between(named, field, gauge)]
    pieces += pieces_between(named, gauge, field)
    whole = Outline.named(pieces)
    return RailProfile(title, whole, ("head",), ("base",), certainty, source)


def _widest(outline: Outline, side: float) -> float:
    """Return the length along a rail's outline of the widest point of its head at a side, the lowest of several."""
    top = outline.top
    best = (-np.inf, 0.0, 0.0)
    for i, segment in enumerate(outline.segments):
        parameters = np.linspace(0.0, 1.0, max(int(segment.length / _SPACING_MM), 2))
        points: FloatArray = segment.point(parameters)
        for (x, y), parameter in zip(points.tolist(), parameters.tolist(), strict=True):
            if y > _HEAD_SHARE * top:
                best = max(best, (round(side * x, 6), -y, float(outline.offsets[i] + parameter * segment.length)))
    return best[2]


def _wheel(outline: Outline, title: str, flange_back_mm: float, certainty: str, source: str) -> WheelProfile:
    high = outline.top
    names: dict[int, str] = {}
    for i, segment in enumerate(outline.segments):
        if isinstance(segment, Line) and segment.bounds[0, 1] >= high - _FLAT * outline.size:
            names[i] = "cut"
    if not names:
        raise InputError("a wheel without a level cut on top", "a straight, level side on top", "check the outline")
    n = outline.n_segments
    for step, name in ((-1, "outer_face"), (1, "back_face")):
        i = next(i for i in names if names[i] == "cut" and (i + step) % n not in names)
        while _is_upright(outline.segments[(i + step) % n]) and (i + step) % n not in names:
            i = (i + step) % n
            names[i] = name
    named = _renamed(outline, names, "running")
    height = -named.bottom
    return WheelProfile(title, named, ("running",), height, flange_back_mm, certainty, source)


def _is_upright(segment: Segment) -> bool:
    return isinstance(segment, Line) and abs(segment.start[0] - segment.end[0]) <= 1e-3 * segment.length


def _renamed(outline: Outline, names: dict[int, str], other: str) -> Outline:
    return Outline.from_segments(outline.segments, [names.get(i, other) for i in range(outline.n_segments)])


def point_at(outline: Outline, place: float) -> Point:
    """Return the point at a length along an outline."""
    i = int(outline.numbers_at(np.array(place)))
    return as_point(outline.segments[i].point((place - outline.offsets[i]) / outline.segments[i].length)[0])


def pieces_between(outline: Contour, first: float, last: float) -> list[tuple[str, Segment]]:
    """Return the named pieces of an outline from one length along it forwards to another."""
    total = float(outline.offsets[-1])
    last = last if last > first else last + total
    pieces: list[tuple[str, Segment]] = []
    for lap in (0.0, total):
        for i, segment in enumerate(outline.segments):
            low, high = outline.offsets[i : i + 2] + lap
            start, end = max(first, low), min(last, high)
            if end - start <= _SAME:
                continue
            cuts = [(at - low) / segment.length for at in (start, end) if low + _SAME < at < high - _SAME]
            parts = segment.split(cuts) if cuts else (segment,)
            inside = 1 if start > low + _SAME else 0
            pieces.append((outline.names[i], parts[inside]))
    return pieces
