"""What ``flangeway profile`` computes of one profile, from a file or by name, or of all profiles of a folder."""

import math
from collections import Counter
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, replace
from functools import cache, cached_property
from pathlib import Path
from typing import Any

import numpy as np

from flangeway.cases.rigid_run import conicities_of, find_geometry_case
from flangeway.errors import InputError
from flangeway.geometry import Contour, Outline
from flangeway.quantities import Quantities, Quantity, columns, of_part, values
from flangeway.railway.profiles.bundled import RailProfile, WheelProfile
from flangeway.railway.profiles.formats.two_column import Kind
from flangeway.railway.profiles.joining import (
    BUNDLED_NAMES,
    Joined,
    body_distance_mm,
    joined,
    nominal_profile,
    on_plain_body,
    whole_profile,
)
from flangeway.railway.profiles.named import USUAL_BODIES, with_body
from flangeway.railway.profiles.orientation import Orientation, ReadOptions, measures, only_face, worn_side
from flangeway.railway.profiles.profile_file import (
    FORMATS,
    READABLE,
    MeasuredProfile,
    frame_origin,
    profile_text,
    read_profile,
    sections_of,
)
from flangeway.railway.profiles.smoothing import Smoothing
from flangeway.railway.rigid.conicity import REFERENCE_AMPLITUDE_MM, RollingRadiusDifference
from flangeway.railway.rigid.rigid_side import RigidCurve
from flangeway.results import Result, ResultTable
from flangeway.system.memory_limits import peak_memory_bytes
from flangeway.system.operating_system import number_of_cores
from flangeway.system.output_folder import versions
from flangeway.system.workers import LostWorkerError, computed_here
from flangeway.types import Progress

# --- A profile from a file or by name, checked, measured, joined and converted, as ``flangeway profile`` does it.


FRAMES = {
    "top": "x = 0 in the middle of the head, away from the track's middle; y = 0 at the top of the rail, up",
    "base": "x = 0 in the middle of the base, away from the track's middle; y = 0 at its underside, up",
    "gauge": "x = 0 at the gauge face, away from the track's middle; y = 0 at the top of the rail, up",
    "tape": "x = 0 on the tape line, away from the track's middle; y = 0 on the tread there, up",
}
"""Meaning of the coordinates, by the origin of the frame."""

VERTICAL = {True: "up", False: "down"}
MIN_CURVATURE_PER_MM = 1e-9  # below it a curve is straight
TOP_OFF_MM = 0.05  # height of a rail's top from the file's y = 0 above which the frame says where it is

_SPACING_MM = 0.25
_DEVIATION_MM = 2e-4


@dataclass(frozen=True, eq=False)
class ProfileRun(Result):
    """A profile with its body and joints."""

    profile: MeasuredProfile  # running surface, or whole outline, as it was read
    body: RailProfile | WheelProfile | None = None
    """Whole rail or wheel: bundled, from a closed outline, or joined; None for a running surface alone."""
    join: Joined | None = None  # how it was joined, None if it was not

    @cached_property
    def running(self) -> Contour:
        """The running surface, of a whole rail in the frame of its base."""
        return self.profile.surface if self.body is None or self.join is not None else self.body.running_surface

    @cached_property
    def measures(self) -> dict[str, float]:
        """Gauge measures of the running surface."""
        return measures(self.running, self.profile.kind)

    @property
    def frame(self) -> str:
        """Meaning of the coordinates; a file's origin need not be on the head's top."""
        # the origin of a whole rail is on its base, also if that of its file was at the top
        if self.profile.kind == "rail" and self.body is not None:
            return FRAMES["base"]
        origin, top = frame_origin(self.profile), self.profile.surface.top
        if self.profile.kind == "wheel" or origin == "base" or abs(top) <= TOP_OFF_MM:
            return FRAMES[origin]
        return FRAMES[origin].replace(
            "at the top of the rail, up", f"where the file has it, up: the rail's top lies at {top:.3f}"
        )

    @property
    def notices(self) -> list[str]:
        """Sentences on what was left out, bridged, smoothed or assumed."""
        return list(dict.fromkeys((*self.profile.notices, *(self.body.notices if self.body else ()))))

    @cached_property
    def summary(self) -> dict[str, Any]:
        """Content of ``profile.json``."""
        taken, body = self.profile.orientation, self.body
        return {
            "title": self.profile.title,
            **values(QUANTITIES, self),
            "how": dict(taken.how),
            "order_reversed": taken.reversed_order,
            "shift_mm": list(taken.shift_mm),
            "frame": self.frame,
            "joints": [vars(joint) for joint in self.join.joints] if self.join else [],
            "certainty": body.certainty if body else None,
            "source": body.source if body else None,
            "notices": self.notices,
            "peak_memory_MB": peak_memory_bytes() / 1e6,
            "versions": versions(),
        }

    @property
    def table(self) -> ResultTable:
        """Its measures."""
        return ResultTable.of_numbers(values(QUANTITIES, self))


def _how(key: str, read: Callable[[Orientation], str]) -> Callable[[ProfileRun], str]:
    """Return how a property of the file was interpreted, and where that comes from."""
    return lambda run: f"{read(run.profile.orientation)} ({run.profile.orientation.how[key]})"


def _radius(run: ProfileRun, sign: float) -> float | None:
    curvature = max(sign * segment.curvature for segment in run.running.segments)
    return 1.0 / curvature if curvature > MIN_CURVATURE_PER_MM else None


def _worn_more_at(run: ProfileRun) -> str | None:
    if run.profile.kind == "wheel":
        return None
    points = _along(run.running)
    face, side = only_face(points), worn_side(points)
    if face is not None:
        return f"not seen: only the face of the {face} is measured"
    return "neither" if side is None else f"{side.name}, by {side.more_mm:.2f} mm ({side.measure})"


def _measure(key: str, label: str) -> Quantity[ProfileRun]:
    return Quantity(key, label, lambda run: run.measures.get(f"{key}_mm"), "mm", ".3f")


MEASURES: Quantities[ProfileRun] = tuple(
    _measure(key, label)
    for key, label in {
        "flange_height": "flange height Sh",
        "flange_thickness": "flange thickness Sd",
        "flange_slope": "flange slope qR",
        "head_width": "head width at 14 mm",
        "gauge_drop": "gauge drop at 25 mm",
        "field_drop": "field drop at 25 mm",
        "gauge_half_width": "gauge half width at 14 mm",
        "field_half_width": "field half width at 14 mm",
    }.items()
)
"""Gauge measures of wheels (EN 15313), and of heads: widths 14 mm below the top, drops 25 mm beside the middle."""


def _smoothing(run: ProfileRun) -> Smoothing | None:
    return run.profile.smoothing


QUANTITIES: Quantities[ProfileRun] = (
    Quantity("kind", "kind", _how("kind", lambda taken: taken.kind)),
    Quantity("format", "format", lambda run: run.profile.format),
    Quantity("unit", "unit of the file", _how("unit", lambda taken: taken.unit)),
    Quantity("vertical_axis", "vertical axis in the file", _how("up", lambda t: f"positive {VERTICAL[t.upwards]}")),
    Quantity("mirrored", "mirrored", _how("side", lambda taken: "yes" if taken.mirrored else "no")),
    Quantity("origin", "origin of the file", _how("origin", lambda taken: taken.origin)),
    Quantity("tape", "tape line from the flange's back", lambda run: run.profile.orientation.tape_mm, "mm", "g"),
    Quantity("points", "points", lambda run: len(run.profile.points), form="d"),
    Quantity("arcs", "lines and arcs", lambda run: run.profile.surface.n_segments, form="d"),
    Quantity("length", "arc length", lambda run: run.running.length, "mm", ".3f"),
    Quantity("minimum", "minimum", lambda run: run.running.bounds()[0], "mm", ".3f", ("x", "y")),
    Quantity("maximum", "maximum", lambda run: run.running.bounds()[1], "mm", ".3f", ("x", "y")),
    Quantity("minimum_convex_radius", "minimum convex radius", lambda run: _radius(run, 1.0), "mm"),
    Quantity("minimum_concave_radius", "minimum concave radius", lambda run: _radius(run, -1.0), "mm"),
    *MEASURES,
    Quantity("worn_more_at", "worn more at", _worn_more_at),
    *of_part(
        _smoothing,
        Quantity("noise", "noise of the points", lambda smoothing: smoothing.noise_um, "μm", ".3g"),
        Quantity("wavelength", "smoothed by a wavelength of", lambda smoothing: smoothing.wavelength_mm, "mm", "g"),
        Quantity("rms_deviation", "deviation, root mean square", lambda smoothing: smoothing.rms_um, "μm", ".2f"),
        Quantity("maximum_deviation", "deviation, maximum", lambda smoothing: smoothing.maximum_um, "μm", ".2f"),
        Quantity("limit", "limit of the deviation", lambda smoothing: smoothing.limit_um, "μm", ".3g"),
        Quantity("points_at_limit", "points at the limit", lambda smoothing: smoothing.n_held, form="d"),
    ),
    Quantity("joined_to", "joined to", lambda run: run.join and run.join.nominal.title),
    Quantity(
        "gap",
        "gap to nominal",
        lambda run: run.join and [joint.gap_mm for joint in run.join.joints],
        "mm",
        ".3f",
        ("first end", "second end"),
    ),
    Quantity(
        "worn_area",
        "worn area",
        lambda run: run.join and run.join.nominal.outline.area - run.join.profile.outline.area,
        "mm²",
        ".1f",
    ),
    Quantity("area", "area of the whole section", lambda run: run.body and run.body.outline.area, "mm²", ".1f"),
)
"""What is reported of a profile; what there is not is None."""


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
    return ProfileRun(profile, body, done)


def _as_cases_see_it(profile: MeasuredProfile, name: str) -> tuple[str, ...]:
    """Return what a case says of a profile beyond its own notices: what contact leaves out, or why it is refused."""
    try:
        body = with_body(profile, name, profile.kind)
        RigidCurve.from_contour(body.running_surface)
    except InputError as reason:
        return (f"Cases refuse it: {reason.given}; allowed is {reason.allowed}; {reason.advice}.",)
    return tuple(notice for notice in body.notices if notice.startswith(("Beyond", "What lies below")))


def run_profiles(names: Sequence[str], options: ReadOptions, join: str | None = None) -> list[ProfileRun]:
    """Read several profiles, see `run_profile`; of a file of slices without a position all slices.

    Profiles with the same title, as from one instrument, have the names of their files in it.
    """
    runs, files = [], []
    for name in names:
        positions = sections_of(Path(name)) if options.position is None else ()
        all_options = [replace(options, position=position) for position in positions] or [options]
        runs += [run_profile(name, one, join) for one in all_options]
        files += [Path(name).name] * len(all_options)
    titles = Counter(run.profile.title for run in runs)
    return [
        run if titles[run.profile.title] == 1 else _renamed(run, f"{run.profile.title}, {file}")
        for run, file in zip(runs, files, strict=True)
    ]


def _renamed(run: ProfileRun, title: str) -> ProfileRun:
    return replace(run, profile=replace(run.profile, title=title))


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
    return ProfileRun(profile, body)


# --- All profiles of a folder: gauge measures, wear against the nearest bundled profile, conicity with a partner.


PARTNERS: dict[Kind, tuple[str, str]] = {"rail": ("S1002", "AAR-1B"), "wheel": ("60E1", "136RE")}
"""Partner of a European profile, and of an American one."""
AMERICAN = ("136RE", "AAR-1B", "heavy-haul")
SIGNS: dict[Kind, dict[str, tuple[str, float]]] = {
    "wheel": {"tread_wear": ("flange_height_mm", 1.0), "flange_wear": ("flange_thickness_mm", -1.0)},
    "rail": {"side_wear": ("head_width_mm", -1.0)},
}
"""Measure that wear changes, and the sign of its change, by the name of the wear; see `WEAR`."""
REACH_MM, STEP_MM = 7.0, 0.1  # lateral displacements of the conicity
FILES_A_WORKER = 10  # a file takes half a second, a worker three until it has begun


@dataclass(frozen=True, eq=False)
class FolderProfile:
    """A profile of a folder.

    - `run`: the profile as it was read.
    - `file`: name of its file.
    - `nominal`: bundled profile that it lies nearest to; None if it fits none.
    - `wear_mm`: wear by name; see `WEAR`.
    - `conicity`: equivalent conicity at `REFERENCE_AMPLITUDE_MM`, both sides alike; None where there is none.
    - `notice`: why there is no conicity.
    """

    run: ProfileRun
    file: str
    nominal: str | None
    wear_mm: dict[str, float]
    conicity: float | None
    notice: str = ""

    @property
    def notices(self) -> tuple[str, ...]:
        """What was repaired, assumed or left out of the file, and why there is no conicity."""
        return (*self.run.notices, self.notice) if self.notice else tuple(self.run.notices)

    @property
    def worst_mm(self) -> float:
        """Largest wear; that of a profile without a nominal one counts as none."""
        return max(self.wear_mm.values(), default=0.0)


@dataclass(frozen=True, eq=False)
class ProfileFolder(Result):
    """The profiles of a folder, the most worn first, sentences on files that are refused, and the given nominal one."""

    profiles: tuple[FolderProfile, ...]
    refused: tuple[str, ...]
    nominal: str | None = None

    @property
    def table(self) -> ResultTable:
        """Measures, wear and conicity, a row a profile."""
        return columns(FOLDER_QUANTITIES, self.profiles)


WEAR: dict[Kind, dict[str, str]] = {
    "wheel": {"tread_wear": "tread wear", "flange_wear": "flange wear"},
    "rail": {"top_wear": "top wear", "side_wear": "side wear at 14 mm"},
}
"""Wear by kind and name.

Wheels, by the measures of EN 15313: what the flange is higher than the nominal one, which is the wear of the tread at
the tape line, and what it is thinner. Rails: what the top is lower than the nominal one, if the file counts from the
base or from the top of the new rail; and what the head is narrower than the nominal one at the depth below its top at
which gauges are measured (EN 13848-1).
"""


def _wear(key: str, label: str) -> Quantity[FolderProfile]:
    return Quantity(key, label, lambda profile: profile.wear_mm.get(key), "mm", ".2f")


_MAIN_MEASURES: Quantities[FolderProfile] = of_part(
    lambda profile: profile.run, *(replace(measure, form=".2f") for measure in MEASURES[:4])
)
FOLDER_QUANTITIES: Quantities[FolderProfile] = (
    Quantity("file", "file", lambda profile: profile.file),
    Quantity("kind", "kind", lambda profile: profile.run.profile.kind),
    Quantity("nominal", "nominal", lambda profile: profile.nominal),
    *_MAIN_MEASURES,
    *(_wear(key, label) for words in WEAR.values() for key, label in words.items()),
    Quantity("conicity", f"conicity at {REFERENCE_AMPLITUDE_MM:g} mm", lambda profile: profile.conicity, form=".3f"),
)
"""What is reported of each profile."""


def run_folder(
    folder: Path, partner: str | None = None, nominal: str | None = None, progress: Progress = lambda _: None
) -> ProfileFolder:
    """Read all profiles of a folder.

    It is an `InputError` if there is no folder, or none of its files is a profile.
    - `partner`: bundled rail for wheels or wheel for rails; None: by `PARTNERS`.
    - `nominal`: bundled profile that those of its kind were when new; None: the nearest one of each, which may be
      another one where heads are worn by more than rails differ.
    """
    if nominal is not None:
        nominal_profile(nominal)
    if not folder.is_dir():
        raise InputError(f"folder {folder}", "a folder with files of profiles", "give the folder, not a file of it")
    files = sorted(file for file in folder.iterdir() if file.suffix.lower() in FORMATS)
    profiles, refused = [], []
    for number, outcome in enumerate(_each([(file, partner, nominal) for file in files]), 1):
        progress(f"{number} of {len(files)} files")
        if isinstance(outcome, FolderProfile):
            profiles.append(outcome)
        else:
            refused.append(f"{outcome.given}; allowed is {outcome.allowed}")
    if not profiles:
        raise InputError(
            f"folder {folder} with {len(files)} files of profiles, none of which can be read",
            f"files with the endings {', '.join(FORMATS)}",
            "look at one: " + refused[0] if refused else "check the name of the folder",
        )
    profiles.sort(key=lambda row: (-row.worst_mm, row.file))
    return ProfileFolder(tuple(profiles), tuple(sorted(refused)), nominal)


Work = tuple[Path, str | None, str | None]
"""A file, its partner, and its nominal profile."""


def _each(works: list[Work]) -> Iterator[FolderProfile | InputError]:
    """Profiles or reasons why files are refused, in any order: by all cores where there are many files."""
    n_workers = min(number_of_cores(), math.ceil(len(works) / FILES_A_WORKER))
    for (file, *_), outcome in computed_here(works, _profile, n_workers):
        if isinstance(outcome, LostWorkerError):
            yield InputError(f"{file.name}: {outcome}", "a file that fits into memory", "give it alone")
        else:
            yield outcome


def _profile(work: Work) -> FolderProfile | InputError:
    """Profile of a file, or why it is refused."""
    try:
        return _read(*work)
    except InputError as reason:
        return reason


def nearest_nominal(profile: MeasuredProfile, named: str | None = None) -> str | None:
    """Return the bundled profile that a measured one was when new: the named one if of its kind, or the nearest.

    None if none fits.
    """
    of_kind = named is not None and isinstance(nominal_profile(named), RailProfile) == (profile.kind == "rail")
    gaps = {
        name: gap
        for name in ([named] if named and of_kind else USUAL_BODIES[profile.kind])
        if (gap := body_distance_mm(profile, name)) is not None
    }
    return min(gaps, key=lambda name: gaps[name]) if gaps else None


def _read(file: Path, partner: str | None, named: str | None) -> FolderProfile:
    run = ProfileRun(read_profile(file))
    profile, kind = run.profile, run.profile.kind
    nominal = nearest_nominal(profile, named)
    wear: dict[str, float] = {}
    if nominal is not None:
        new, worn = _nominal_measures(nominal), run.measures
        signed = SIGNS[kind]
        wear = {name: sign * (worn[key] - new[key]) for name, (key, sign) in signed.items() if key in worn}
        top, on_base = profile.surface.top, frame_origin(profile) == "base"
        if kind == "rail" and (on_base or top < -TOP_OFF_MM):
            wear["top_wear"] = nominal_profile(nominal).outline.top * on_base - top
    partner = partner or PARTNERS[kind][nominal in AMERICAN]
    try:
        return FolderProfile(run, file.name, nominal, wear, _conicity(run, partner))
    except InputError as reason:
        notice = f"No conicity on {partner}: {reason.given}."
        return FolderProfile(run, file.name, nominal, wear, None, notice)


@cache
def _nominal_measures(name: str) -> dict[str, float]:
    nominal = nominal_profile(name)
    return measures(nominal.running_surface, "rail" if isinstance(nominal, RailProfile) else "wheel")


def _conicity(run: ProfileRun, partner: str) -> float:
    """Equivalent conicity of a wheelset in standard gauge that has a profile on both sides."""
    body = on_plain_body(run.profile)
    rail, wheel = (body, partner) if isinstance(body, RailProfile) else (partner, body)
    geometry = find_geometry_case("s1002-60e1", {"track.rail": rail, "wheelset.wheel": wheel}).geometry()
    locus = geometry.scanned(REACH_MM, STEP_MM)
    if len(locus.lateral_mm) < 2:
        raise InputError("contact in the middle of the track alone", "contact on both sides of it", "look at the pair")
    conicities = conicities_of(RollingRadiusDifference.of(locus), REFERENCE_AMPLITUDE_MM)
    conicity = (conicities.at_reference or {}).get("integration", math.nan)
    if math.isnan(conicity):
        raise InputError(
            "; ".join(conicities.notices),
            f"an amplitude of {REFERENCE_AMPLITUDE_MM:g} mm",
            "look at the profile alone",
        )
    return conicity
