"""Rails and wheels of cases by the names that users give: bundled ones, or files of profiles."""

import re
from dataclasses import replace
from functools import lru_cache
from pathlib import Path
from typing import Any

from flangeway.errors import InputError
from flangeway.geometry import Outline
from flangeway.railway.profiles.bundled import (
    RAILS,
    REFERENCE_RAIL,
    REFERENCE_WHEELS,
    WHEELS,
    RailProfile,
    WheelProfile,
    bundled_name,
    rail,
    wheel,
)
from flangeway.railway.profiles.flange_root import IDENTIFIED, identified_wheel
from flangeway.railway.profiles.formats.raw_profile import Kind
from flangeway.railway.profiles.joining import body_distance_mm, joined, nominal_profile, on_plain_body
from flangeway.railway.profiles.orientation import ReadOptions
from flangeway.railway.profiles.profile_file import (
    FIELD_WORN,
    MIRRORED,
    READABLE,
    MeasuredProfile,
    read_profile,
    side_notices,
)
from flangeway.railway.profiles.whole_outline import whole_profile
from flangeway.railway.track.placements import Side, Track, Wheelset
from flangeway.system.file_content import is_file
from flangeway.units import sentence, with_texts

READ_AS_IT_IS = ReadOptions()
USUAL_BODIES: dict[Kind, tuple[str, ...]] = {"rail": ("136RE", "60E1"), "wheel": WHEELS}
"""Bodies that a file gets by itself; others, whose heads are much alike, are taken where they are named."""
PLAIN = "plain"  # body of a rail or wheel that fits no bundled one: a block beside its running surface


def profile_named(
    name: str,
    kind: Kind,
    options: ReadOptions = READ_AS_IT_IS,
    key: str = "",
    *,
    body: str | None = None,
    other: str | None = None,
    crown_radius_in: float | None = None,
) -> Any:
    """Return a bundled rail or wheel, a file's running surface on the body of a bundled one, or a file's whole outline.

    It is an `InputError` if there is none of that name, or the file is that of the other kind, cannot be read or does
    not fit the body.
    - `name`: of a bundled profile, or of a file.
    - `options`: what the file does not contain: unit, mirror, distance of the tape line.
    - `key`: name of the input, for messages: the options are called after it, such as ``rail_unit``; the kind if empty.
    - `body`: the bundled profile for a file's running surface; None: the other side's if it fits, else that of
      `USUAL_BODIES` nearest to most of the surface.
    - `other`: the profile of the other side.
    - `crown_radius_in`: radius of a 136RE's crown; None: the usual one.
    """
    key = key or kind
    if not _means_file(name):
        _refuse_other_kind(name, kind)
        _refuse_options(name, options, key)
        if kind == "rail":
            return rail(name, crown_radius_in=crown_radius_in)
        return identified_wheel() if name == IDENTIFIED else wheel(name)
    measured = _read(name, kind, options, key)
    if measured.kind != kind:
        raise InputError(
            f"{key} = {name}, which is the profile of a {measured.kind}",
            f"a {kind}",
            "exchange the keys rail and wheel",
        )
    return with_body(measured, name, key, body, other)


def _refuse_options(name: str, options: ReadOptions, key: str) -> None:
    for option, value in vars(options).items():
        if value not in (None, False):
            wrong = position_key(key) if option == "position" else f"{key}_{option}"
            raise InputError(f"{wrong} of the bundled {name}", "a file", f"leave {wrong} out")


def position_key(key: str) -> str:
    """Name of the input with the position of a section in a file of slices, of one of the inputs with a profile."""
    return f"{key}_position_mm" if key.endswith("rail") else f"{key}_angle_deg"


_joined = lru_cache(maxsize=8)(joined)  # the nearest body is joined to see whether it fits, so it is joined already


def with_body(
    measured: MeasuredProfile, name: str, key: str, body: str | None = None, other: str | None = None
) -> RailProfile | WheelProfile:
    """Return a rail or wheel from what was read of a file, with its own body or that of a bundled one.

    Parameters and errors as of `profile_named`.
    """
    kind = measured.kind
    if isinstance(measured.surface, Outline):
        return whole_profile(measured)
    bodies = (*(RAILS if kind == "rail" else WHEELS), PLAIN)
    body = body or _nearest_body(measured, other)
    if body != PLAIN:
        try:
            wanted = nominal_profile(body)
        except InputError as reason:
            raise InputError(
                f"{kind}_body = {body}", ", ".join(bodies), "choose the one nearest to the measured profile"
            ) from reason
        if isinstance(wanted, RailProfile) != (kind == "rail"):
            raise InputError(f"{kind}_body = {body}", ", ".join(bodies), f"a {kind} needs the body of a {kind}")
    try:
        return on_plain_body(measured) if body == PLAIN else _joined(measured, body).profile
    except InputError as reason:
        others = [other_body for other_body in bodies if other_body != body and _fits(measured, other_body)]
        advice = (
            f"flangeway profile {name} --join {body} shows how it is read; options give what the file does not contain"
        )
        if others:
            advice = f"is it the profile of another {kind}? Give {kind}_body = {' or '.join(others)}"
        given, allowed = (_as_keys(text, key) for text in (reason.given, reason.allowed))
        raise InputError(f"{key} = {name}: " + given, allowed, advice) from reason


def _as_keys(text: str, key: str) -> str:
    """Return a text that names options of ``flangeway profile`` with the keys that do the same in a case."""

    def changed(part: str) -> str:
        part = re.sub(r"--unit (mm|cm|m|in|ft)\b", rf"{key}_unit = \1", part)
        part = part.replace("--no-mirror", f"{key}_mirror = false")
        for option, name in (("unit", "unit"), ("mirror", "mirror"), ("tape", "tape_mm")):
            part = re.sub(rf"--{option}\b", f"{key}_{name}", part)
        return re.sub(r"--position( in \w+)?", position_key(key), part)

    return with_texts(text, changed)


def _read(name: str, kind: Kind, options: ReadOptions, key: str) -> MeasuredProfile:
    """Read a file; where neither file nor shape shows whether it is a rail or a wheel, the key decides."""
    try:
        try:
            measured = read_profile(name, options)
        except InputError as reason:
            if "--kind" not in reason.allowed:
                raise
            measured = read_profile(name, replace(options, kind=kind))
    except InputError as reason:
        given, allowed, advice = (_as_keys(text, key) for text in (reason.given, reason.allowed, reason.advice))
        if "--" in f"{allowed} {advice}":
            advice += f": options of `flangeway profile {name}`, whose --to writes a file for {kind}"
        raise InputError(f"{key} = " + given, allowed, advice) from reason
    return replace(measured, notices=tuple(_as_keys(notice, key) for notice in measured.notices))


def _fits(measured: MeasuredProfile, body: str) -> bool:
    try:
        on_plain_body(measured) if body == PLAIN else _joined(measured, body)
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


def _refuse_other_kind(name: str, kind: Kind) -> None:
    names = {"rail": (*RAILS, REFERENCE_RAIL), "wheel": (*WHEELS, *REFERENCE_WHEELS)}
    other: Kind = "wheel" if kind == "rail" else "rail"
    if bundled_name(name) in names[other]:
        raise InputError(
            f"{kind} = {name}, which is a {other}",
            ", ".join(names[kind]),
            "exchange the keys rail and wheel",
        )


def _means_file(name: str) -> bool:
    path = Path(name)
    return path.suffix.lower() in READABLE or is_file(path)


def profile_notes(track: Track, wheelset: Wheelset) -> list[str]:
    """Return how far the profiles can be trusted, and what was assumed when their files were read, in sentences."""
    both: tuple[Side, Side] = ("right", "left")
    wheels = [("Wheel", profile) for profile in dict.fromkeys(wheelset.wheel_of(side) for side in both)]
    rails = [("Rail", profile) for profile in dict.fromkeys(track.rail_of(side) for side in both)]
    profiles: list[tuple[str, RailProfile | WheelProfile]] = [*wheels, *rails]
    notices = [(notice, profile.title) for _, profile in profiles for notice in profile.notices]
    return [
        *(sentence("{} {}. {}", word, profile.title, profile.certainty) for word, profile in profiles),
        *(notice + f" ({title})" for notice, title in notices if not notice.startswith((MIRRORED, FIELD_WORN))),
    ]


def side_warnings(track: Track) -> list[str]:
    """Return a warning for each rail that was mirrored, or is worn more at the side that no flange reaches."""
    warnings = []
    for side, key in (("right", "rail"), ("left", "left_rail")):
        if side == "right" or not track.is_symmetric:
            one = track.rail_of("left" if side == "left" else "right")
            mirrored = [notice for notice in one.notices if notice.startswith(MIRRORED)]
            warnings += [_as_keys(notice, key) for notice in mirrored or side_notices(one.running_surface)]
    return warnings
