"""A profile from a file or by name, checked, measured, joined and converted, as ``flangeway profile`` does it."""

from collections import Counter
from collections.abc import Sequence
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Any

import numpy as np

from flangeway.cases.wheelset.wheelset_profiles import with_body
from flangeway.errors import InputError
from flangeway.geometry import Arc, Contour, Outline
from flangeway.railway.profiles.bundled import RailProfile, WheelProfile
from flangeway.railway.profiles.formats.raw_profile import Kind
from flangeway.railway.profiles.joining import BUNDLED_NAMES, Joined, joined, nominal_profile
from flangeway.railway.profiles.measures import measures, only_face, worn_side
from flangeway.railway.profiles.orientation import Orientation
from flangeway.railway.profiles.profile_file import (
    READABLE,
    MeasuredProfile,
    ReadOptions,
    frame_origin,
    profile_text,
    read_profile,
    sections_of,
)
from flangeway.railway.profiles.smoothing import Smoothing
from flangeway.railway.profiles.whole_outline import whole_profile
from flangeway.railway.rigid.rigid_curve import RigidCurve
from flangeway.results import Result, ResultTable
from flangeway.system.memory_limits import peak_memory_bytes
from flangeway.system.versions import versions

FRAMES = {
    "top": "x = 0 in the middle of the head, away from the track's middle; y = 0 at the top of the rail, up",
    "base": "x = 0 in the middle of the base, away from the track's middle; y = 0 at its underside, up",
    "gauge": "x = 0 at the gauge face, away from the track's middle; y = 0 at the top of the rail, up",
    "tape": "x = 0 on the tape line, away from the track's middle; y = 0 on the tread there, up",
}
"""Meaning of the coordinates, by the origin of the frame."""

NO_MEASURES = ("read_as", "versions", "peak_memory_MB", "timings_s")
"""Keys of the summary that say nothing of the profile."""
TOP_OFF_MM = 0.05  # height of a rail's top from the file's y = 0 above which the frame says where it is

_SPACING_MM = 0.25
_DEVIATION_MM = 2e-4


@dataclass(frozen=True, eq=False)
class ProfileRun(Result):
    """A profile with its body, joints and summary."""

    profile: MeasuredProfile  # running surface, or whole outline, as it was read
    body: RailProfile | WheelProfile | None
    """Whole rail or wheel: bundled, from a closed outline, or joined; None for a running surface alone."""
    join: Joined | None  # how it was joined, None if it was not
    summary: dict[str, Any] = field(default_factory=dict)  # content of ``profile.json``

    @property
    def table(self) -> ResultTable:
        """Its measures."""
        return ResultTable.of_numbers({key: self.summary[key] for key in self.summary if key not in NO_MEASURES})


def run_profile(name_or_file: str, options: ReadOptions | None = None, join: str | None = None) -> ProfileRun:
    """Read a profile from a file, or take a bundled one by its name.

    It is an `InputError` if there is neither, the file is wrong, or the profile does not fit the body.
    - `name_or_file`: a name such as ``"S1002"``, or a file; see `flangeway.railway.profiles.profile_file.READABLE`.
    - `options`: options for what the file does not declare.
    - `join`: name of the nominal rail or wheel that gives the body.
    """
    given = options or ReadOptions()
    path = Path(name_or_file)
    if path.suffix.lower() not in READABLE and not path.exists() and len(path.parts) == 1:
        if given != ReadOptions() or join is not None:
            raise InputError(f"options of a file for the bundled {name_or_file}", "a file", "leave them out")
        return _bundled(name_or_file)
    profile = read_profile(path, given)
    done = joined(profile, join) if join is not None else None
    body: RailProfile | WheelProfile | None = done.profile if done is not None else None
    if isinstance(profile.surface, Outline):
        body = whole_profile(profile)
    if join is None:
        profile = replace(profile, notices=(*profile.notices, *_as_cases_see_it(profile, name_or_file)))
    return ProfileRun(profile, body, done, _summary(profile, body, done))


def _as_cases_see_it(profile: MeasuredProfile, name: str) -> tuple[str, ...]:
    """Return what a case says of a profile beyond its own notices: what contact leaves out, or why it is refused."""
    try:
        body = with_body(profile, name, profile.kind)
        RigidCurve.from_contour(body.running_surface)
    except InputError as reason:
        return (f"Cases refuse it: {reason.given}; allowed is {reason.allowed}; {reason.advice}.",)
    return tuple(each for each in body.notices if each.startswith("Beyond"))


def run_profiles(names: Sequence[str], options: ReadOptions, join: str | None = None) -> list[ProfileRun]:
    """Read several profiles, see `run_profile`; of a file of slices without a position all slices.

    Profiles with the same title, as from one instrument, have the names of their files in it.
    """
    found, files = [], []
    for name in names:
        places = sections_of(Path(name)) if options.position is None else ()
        each = [replace(options, position=place) for place in places] or [options]
        found += [run_profile(name, one, join) for one in each]
        files += [Path(name).name] * len(each)
    titles = Counter(run.profile.title for run in found)
    return [
        run if titles[run.profile.title] == 1 else _renamed(run, f"{run.profile.title}, {file}")
        for run, file in zip(found, files, strict=True)
    ]


def _renamed(run: ProfileRun, title: str) -> ProfileRun:
    return replace(run, profile=replace(run.profile, title=title), summary={**run.summary, "title": title})


def converted(run: ProfileRun, ending: str) -> str:
    """Return the text of a file of another format; CSV and DXF hold the whole outline if there is one.

    It is an `InputError` if the format is unknown or cannot hold the profile.
    """
    body = run.body
    if ending in (".csv", ".dxf") and body is not None:
        # the origin of a joined rail is on its base
        origin = "base" if isinstance(body, RailProfile) else frame_origin(run.profile)
        return profile_text(run.profile, ending, body.outline, origin)
    if body is not None and isinstance(run.profile.surface, Outline):
        return profile_text(_running_surface(run.profile, body), ending)
    return profile_text(run.profile, ending)


def _running_surface(profile: MeasuredProfile, body: RailProfile | WheelProfile) -> MeasuredProfile:
    """Return the running surface of a profile whose file holds the whole outline."""
    surface = body.running_surface
    taken = profile.orientation
    if profile.kind == "rail":
        taken = Orientation(**{**vars(taken), "origin": "base"})
    return MeasuredProfile(profile.title, profile.format, taken, _along(surface), surface, None)


def _along(surface: Contour) -> np.ndarray[Any, np.dtype[np.float64]]:
    return surface.sampled(spacing=_SPACING_MM, max_deviation=_DEVIATION_MM)


def _bundled(name: str) -> ProfileRun:
    try:
        body = nominal_profile(name)
    except InputError as reason:
        raise InputError(
            f"a profile called {name!r}",
            f"{BUNDLED_NAMES}, or a file that ends with {', '.join(READABLE)}",
            reason.advice,
        ) from reason
    how = dict.fromkeys(("kind", "unit", "up", "side", "origin", "tape line"), "bundled")
    kind: Kind
    kind, origin, tape = (
        ("rail", "base", None) if isinstance(body, RailProfile) else ("wheel", "tape", body.flange_back_mm)
    )
    taken = Orientation(kind, "mm", True, False, False, origin, tape, (0.0, 0.0), how)
    surface = body.running_surface
    profile = MeasuredProfile(body.title, "bundled", taken, _along(surface), surface, None)
    return ProfileRun(profile, body, None, _summary(profile, body, None))


def _summary(profile: MeasuredProfile, body: RailProfile | WheelProfile | None, join: Joined | None) -> dict[str, Any]:
    taken, surface = profile.orientation, profile.surface
    running = body.running_surface if body is not None and join is None else surface
    low, high = running.bounds()
    curvatures = np.array([segment.curvature for segment in running.segments])
    arcs = sum(isinstance(segment, Arc) for segment in surface.segments)
    # the origin of a whole rail is on its base, also if that of its file was at the top
    on_base = profile.kind == "rail" and body is not None
    return {
        "title": profile.title,
        "format": profile.format,
        "kind": profile.kind,
        "read_as": {
            "unit": taken.unit,
            "second_coordinate_up": taken.upwards,
            "mirrored": taken.mirrored,
            "order_reversed": taken.reversed_order,
            "origin": taken.origin,
            "tape_line_from_flange_back_mm": taken.tape_mm,
            "shift_mm": list(taken.shift_mm),
            "how": dict(taken.how),
        },
        "frame": FRAMES["base"] if on_base else _frame(profile),
        "points": len(profile.points),
        "length_mm": running.length,
        "lower_left_mm": low.tolist(),
        "upper_right_mm": high.tolist(),
        "lines": surface.n_segments - arcs,
        "arcs": arcs,
        "smallest_convex_radius_mm": _radius(curvatures.max(initial=0.0)),
        "smallest_hollow_radius_mm": _radius(-curvatures.min(initial=0.0)),
        "measures": measures(running, profile.kind),
        "worn_side": None if profile.kind == "wheel" or (side := worn_side(_along(running))) is None else vars(side),
        "only_face": None if profile.kind == "wheel" else only_face(_along(running)),
        "smoothing": None if profile.smoothing is None else _smoothing_summary(profile.smoothing),
        "join": None if join is None else _join_summary(join),
        "area_mm2": body.outline.area if body is not None else None,
        "certainty": body.certainty if body is not None else "",
        "source": body.source if body is not None else "",
        "notices": list(dict.fromkeys((*profile.notices, *(body.notices if body is not None else ())))),
        "peak_memory_MB": peak_memory_bytes() / 1e6,
        "versions": versions(),
    }


def _smoothing_summary(smoothing: Smoothing) -> dict[str, Any]:
    return {
        "noise_um": smoothing.noise_um,
        "wavelength_mm": smoothing.wavelength_mm,
        "rms_deviation_um": smoothing.rms_um,
        "maximum_deviation_um": smoothing.maximum_um,
        "limit_um": smoothing.limit_um,
        "points_held_to_limit": smoothing.n_held,
    }


def _join_summary(join: Joined) -> dict[str, Any]:
    return {
        "nominal": join.nominal.title,
        "area_less_than_nominal_mm2": join.nominal.outline.area - join.profile.outline.area,
        "joints": [
            {"name": j.name, "end_mm": list(j.end), "landing_mm": list(j.landing), "gap_mm": j.gap_mm}
            for j in join.joints
        ],
    }


def _frame(profile: MeasuredProfile) -> str:
    """Return the meaning of the coordinates; a file's origin need not be on the head's top."""
    text, top = FRAMES[frame_origin(profile)], float(profile.surface.bounds()[1, 1])
    if profile.kind == "rail" and frame_origin(profile) != "base" and abs(top) > TOP_OFF_MM:
        text = text.replace(
            "at the top of the rail, up", f"where the file has it, up: the rail's top lies at {top:.3f}"
        )
    return text


def _radius(curvature: float) -> float | None:
    return 1.0 / curvature if curvature > 1e-9 else None
