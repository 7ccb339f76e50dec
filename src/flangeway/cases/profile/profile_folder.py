"""All profiles of a folder: gauge measures, wear against the nearest bundled profile, conicity with a partner."""

import math
from collections.abc import Callable, Iterator
from dataclasses import dataclass, replace
from functools import cache
from pathlib import Path

from flangeway.cases.case import Progress
from flangeway.cases.profile.profile_run import MEASURES, TOP_OFF_MM, ProfileRun
from flangeway.cases.rigid.rigid_case import find_geometry_case
from flangeway.cases.rigid.rigid_run import conicities_of
from flangeway.cases.wheelset.wheelset_profiles import USUAL_BODIES
from flangeway.errors import InputError
from flangeway.quantities import Quantities, Quantity, columns
from flangeway.railway.profiles.bundled import RailProfile
from flangeway.railway.profiles.formats.raw_profile import Kind
from flangeway.railway.profiles.joining import body_distance_mm, nominal_profile, on_plain_body
from flangeway.railway.profiles.measures import measures
from flangeway.railway.profiles.profile_file import FORMATS, frame_origin, read_profile
from flangeway.railway.rigid.conicity import REFERENCE_AMPLITUDE_MM, RollingRadiusDifference
from flangeway.railway.rigid.rigid_geometry import RigidGeometry
from flangeway.results import Result, ResultTable
from flangeway.system.operating_system import number_of_cores
from flangeway.system.workers import LostWorkerError, computed_here
from flangeway.units import joined, sentence

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


def _wear(key: str) -> Callable[[FolderProfile], float | None]:
    return lambda row: row.wear_mm.get(key)


def _of_run(quantity: Quantity[ProfileRun]) -> Quantity[FolderProfile]:
    return Quantity(quantity.key, quantity.label, lambda row: quantity.value(row.run), quantity.unit, "z.2f")


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
FOLDER_QUANTITIES: Quantities[FolderProfile] = (
    Quantity("file", "file", "file"),
    Quantity("kind", "kind", "run.profile.kind"),
    Quantity("nominal", "nominal", "nominal"),
    *map(_of_run, MEASURES[:4]),
    *(Quantity(key, label, _wear(key), "mm", "z.2f") for words in WEAR.values() for key, label in words.items()),
    Quantity("conicity", sentence("conicity at {:g mm}", REFERENCE_AMPLITUDE_MM), "conicity", form=".3f"),
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
    for number, found in enumerate(_each([(file, partner, nominal) for file in files]), 1):
        progress(f"{number} of {len(files)} files")
        if isinstance(found, FolderProfile):
            profiles.append(found)
        else:
            refused.append(sentence("{}; allowed is {}", found.given, found.allowed))
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
    for (file, *_), found in computed_here(works, _profile, n_workers):
        if isinstance(found, LostWorkerError):
            yield InputError(f"{file.name}: {found}", "a file that fits into memory", "give it alone")
        else:
            yield found


def _profile(work: Work) -> FolderProfile | InputError:
    """Profile of a file, or why it is refused."""
    try:
        return _read(*work)
    except InputError as reason:
        return reason


def _read(file: Path, partner: str | None, named: str | None) -> FolderProfile:
    run = ProfileRun(read_profile(file))
    profile, kind = run.profile, run.profile.kind
    of_kind = named is not None and isinstance(nominal_profile(named), RailProfile) == (kind == "rail")
    gaps = {
        name: gap
        for name in ([named] if named and of_kind else USUAL_BODIES[kind])
        if (gap := body_distance_mm(profile, name)) is not None
    }
    nominal = min(gaps, key=lambda name: gaps[name]) if gaps else None
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
        notice = sentence("No conicity on {}: {}.", partner, reason.given)
        return FolderProfile(run, file.name, nominal, wear, None, notice)


@cache
def _nominal_measures(name: str) -> dict[str, float]:
    nominal = nominal_profile(name)
    return measures(nominal.running_surface, "rail" if isinstance(nominal, RailProfile) else "wheel")


def _conicity(run: ProfileRun, partner: str) -> float:
    """Equivalent conicity of a wheelset in standard gauge that has a profile on both sides."""
    usual = find_geometry_case("s1002-60e1", {"wheel" if run.profile.kind == "rail" else "rail": partner})
    track, wheelset, body = usual.track(), usual.wheelset(), on_plain_body(run.profile)
    if isinstance(body, RailProfile):
        track = replace(track, rail=body)
    else:
        radius = usual.wheel_radius_mm + body.flange_height_mm
        wheelset = replace(wheelset, wheel=body, radius_mm=radius)
    geometry = RigidGeometry.of(track, wheelset)
    locus = geometry.scanned(REACH_MM, STEP_MM)
    if len(locus.lateral_mm) < 2:
        raise InputError("contact in the middle of the track alone", "contact on both sides of it", "look at the pair")
    conicities = conicities_of(RollingRadiusDifference.of(locus), REFERENCE_AMPLITUDE_MM)
    conicity = (conicities.at_reference() or {}).get("integration", math.nan)
    if math.isnan(conicity):
        raise InputError(
            joined("; ", conicities.notices),
            sentence("an amplitude of {:g mm}", REFERENCE_AMPLITUDE_MM),
            "look at the profile alone",
        )
    return conicity
