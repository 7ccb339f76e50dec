"""Rails and wheels as users name them: bundled ones, files of profiles with their options, or profiles of a script."""

import re
from dataclasses import replace
from functools import lru_cache
from pathlib import Path
from typing import Annotated, TypeAlias

import annotated_types as at
from pydantic.json_schema import SkipJsonSchema

from flangeway.errors import InputError
from flangeway.geometry import Outline
from flangeway.railway.profiles.bundled import (
    RAILS,
    REFERENCE_RAIL,
    REFERENCE_WHEELS,
    SECTIONS,
    WHEELS,
    RailProfile,
    WheelProfile,
    bundled_name,
    rail,
    wheel,
)
from flangeway.railway.profiles.formats.two_column import Kind
from flangeway.railway.profiles.joining import body_distance_mm, joined, nominal_profile, on_plain_body, whole_profile
from flangeway.railway.profiles.orientation import ReadOptions
from flangeway.railway.profiles.profile_file import READABLE, MeasuredProfile, read_profile
from flangeway.records import LengthUnit, Record
from flangeway.system.file_content import names_file

USUAL_BODIES: dict[Kind, tuple[str, ...]] = {"rail": ("136RE", "60E1"), "wheel": WHEELS}
"""Bodies that a file gets by itself; others, whose heads are much alike, are taken where they are named."""
PLAIN = "plain"  # body of a rail or wheel that fits no bundled one: a block beside its running surface


class ProfileFile(Record):
    """The file of a profile, and what it does not say itself."""

    file: str
    """file that `flangeway profile` reads"""
    unit: LengthUnit | None = None
    """unit of length, if the file does not name one (default: mm)"""
    body: str | None = None
    """bundled profile with the rest of the body for a running surface, or plain (default: that of the other side, else
    the nearest)"""


class RailFile(ProfileFile):
    """The file of a rail's profile."""

    mirror: bool | None = None
    """whether the file contains a left-hand rail, to be mirrored (default: by its worn side)"""
    position_mm: float | None = None
    """section of a .slcs file, along the track"""


class WheelFile(ProfileFile):
    """The file of a wheel's profile."""

    mirror: bool = False
    """whether the file contains a left-hand wheel, to be mirrored"""
    tape_mm: Annotated[float, at.Ge(40.0), at.Le(110.0)] | None = None
    """tape line from the flange's back (default: from the file, else measured, else 70)"""
    angle_deg: float | None = None
    """section of a .slcw file, around the axle"""


RailInput: TypeAlias = str | RailFile | SkipJsonSchema[RailProfile]
"""A rail by the name of a bundled one or of a file, by a file with options, or as a script has it."""
WheelInput: TypeAlias = str | WheelFile | SkipJsonSchema[WheelProfile]
"""A wheel in the same ways."""


def name_of(profile: str | ProfileFile | RailProfile | WheelProfile) -> str:
    """Return what reports call a rail or wheel: its name, that of its file, or its title."""
    if isinstance(profile, RailProfile | WheelProfile):
        return profile.title
    return Path(profile.file if isinstance(profile, ProfileFile) else profile).name


def profile_of(
    profile: str | ProfileFile | RailProfile | WheelProfile,
    kind: Kind,
    path: str = "",
    other: str | ProfileFile | RailProfile | WheelProfile | None = None,
) -> RailProfile | WheelProfile:
    """Return the rail or wheel that a user names.

    Parameters
    ----------
    profile
        Name of a bundled profile or of a file, file with options, or the profile itself.
    kind
        Whether it is a rail or a wheel.
    path
        Path of the input, for messages; the kind if empty.
    other
        The profile of the other side, whose body a file gets where it fits.

    Raises
    ------
    InputError
        If there is none of that name, or the file is that of the other kind, cannot be read or does not fit its body.

    """
    path = path or kind
    if isinstance(profile, RailProfile | WheelProfile):
        return profile
    if isinstance(profile, str) and not means_file(profile):
        return _bundled(profile, kind, path)
    file = profile if isinstance(profile, ProfileFile) else (RailFile if kind == "rail" else WheelFile)(file=profile)
    measured = _read(file, kind, path)
    if measured.kind != kind:
        raise InputError(
            f"{path} = {file.file}, which is the profile of a {measured.kind}", f"a {kind}", "exchange rail and wheel"
        )
    return with_body(measured, file.file, path, file.body, other if isinstance(other, str) else None)


def _bundled(name: str, kind: Kind, path: str) -> RailProfile | WheelProfile:
    names = {"rail": (*RAILS, REFERENCE_RAIL), "wheel": (*WHEELS, *REFERENCE_WHEELS)}
    if bundled_name(name) in names["wheel" if kind == "rail" else "rail"]:
        what = "wheel" if kind == "rail" else "rail"
        raise InputError(f"{path} = {name}, which is a {what}", ", ".join(names[kind]), "exchange rail and wheel")
    if kind == "wheel":
        return wheel(name)
    section, radius = SECTIONS.get(bundled_name(name), (name, None))
    return rail(section, crown_radius_in=radius)


def means_file(name: str) -> bool:
    """Whether a name is that of a file, by its ending or because there is one."""
    return Path(name).suffix.lower() in READABLE or names_file(name)


_joined = lru_cache(maxsize=8)(joined)  # the nearest body is joined to see whether it fits, so it is joined already


def with_body(
    measured: MeasuredProfile, name: str, path: str, body: str | None = None, other: str | None = None
) -> RailProfile | WheelProfile:
    """Return a rail or wheel from what was read of a file, with its own body or that of a bundled one.

    Parameters and errors as of `profile_of`.
    """
    kind = measured.kind
    if isinstance(measured.surface, Outline):
        if body is not None and other in (None, name):
            raise InputError(
                f"{path}.body = {body} for {name}, which is the whole outline", "a running surface", "leave body out"
            )
        return whole_profile(measured)
    bodies = (*(RAILS if kind == "rail" else WHEELS), PLAIN)
    body = body or _nearest_body(measured, other)
    if body != PLAIN:
        try:
            nominal = nominal_profile(body)
        except InputError as reason:
            raise InputError(
                f"{path}.body = {body}", ", ".join(bodies), "choose the one nearest to the measured profile"
            ) from reason
        if isinstance(nominal, RailProfile) != (kind == "rail"):
            raise InputError(f"{path}.body = {body}", ", ".join(bodies), f"a {kind} needs the body of a {kind}")
    try:
        return _on_body(measured, body)
    except InputError as reason:
        others = [other_body for other_body in bodies if other_body != body and _fits(measured, other_body)]
        advice = (
            f"flangeway profile {name} --join {body} shows how it is read; options say what the file does not contain"
        )
        if others:
            advice = f"is it the profile of another {kind}? Set {path}.body = {' or '.join(others)}"
        given, allowed = (as_paths(text, path) for text in (reason.given, reason.allowed))
        raise InputError(f"{path} = {name}: " + given, allowed, advice) from reason


def as_paths(text: str, path: str) -> str:
    """Return a text that names options of ``flangeway profile`` with the inputs that do the same in a case."""
    text = re.sub(r"--unit (mm|cm|m|in|ft)\b", rf"{path}.unit = \1", text)
    text = text.replace("--no-mirror", f"{path}.mirror = false")
    for option, name in (("unit", "unit"), ("mirror", "mirror"), ("tape", "tape_mm")):
        text = re.sub(rf"--{option}\b", f"{path}.{name}", text)
    return re.sub(r"--position( in \w+)?", f"{path}.{'position_mm' if path.endswith('rail') else 'angle_deg'}", text)


def _read(file: ProfileFile, kind: Kind, path: str) -> MeasuredProfile:
    """Read a file; where neither file nor shape shows whether it is a rail or a wheel, the input decides."""
    name = file.file
    if isinstance(file, RailFile):
        options = ReadOptions(unit=file.unit, mirror=file.mirror, position=file.position_mm)
    else:
        assert isinstance(file, WheelFile)
        options = ReadOptions(unit=file.unit, mirror=file.mirror, tape_mm=file.tape_mm, position=file.angle_deg)
    try:
        try:
            measured = read_profile(name, options)
        except InputError as reason:
            if "--kind" not in reason.allowed:
                raise
            measured = read_profile(name, replace(options, kind=kind))
    except InputError as reason:
        given, allowed, advice = (as_paths(text, path) for text in (reason.given, reason.allowed, reason.advice))
        if "--" in f"{allowed} {advice}":
            advice += f": options of `flangeway profile {name}`, whose --to writes a file for {kind}"
        raise InputError(f"{path} = " + given, allowed, advice) from reason
    return replace(measured, notices=tuple(as_paths(notice, path) for notice in measured.notices))


def _on_body(measured: MeasuredProfile, body: str) -> RailProfile | WheelProfile:
    return on_plain_body(measured) if body == PLAIN else _joined(measured, body).profile


def _fits(measured: MeasuredProfile, body: str) -> bool:
    try:
        _on_body(measured, body)
    except InputError:
        return False
    return True


def _nearest_body(measured: MeasuredProfile, other: str | None) -> str:
    """Return the other side's body if it fits, else the usual one nearest to most of the surface; see `PLAIN`."""
    names = USUAL_BODIES[measured.kind]
    known = RAILS if measured.kind == "rail" else WHEELS
    tried = dict.fromkeys((other, *names)) if other in known else names
    gaps = {name: gap for name in tried if name and (gap := body_distance_mm(measured, name)) is not None}
    nearest = sorted(gaps, key=lambda name: (name != other, gaps[name]))
    # sections of a crossing fit no rail
    last = PLAIN if measured.first_slice is not None else other if other in known else names[0]
    return next((name for name in nearest if _fits(measured, name)), last)
