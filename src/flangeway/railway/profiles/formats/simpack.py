"""Simpack profile files: ``.prr`` for rails and ``.prw`` for wheels.

Sections ``header.begin`` to ``header.end`` and ``spline.begin`` to ``spline.end`` hold lines ``key = value``; the
points stand between ``point.begin`` and ``point.end``: y to the right, z down, and a weight that is not used. ``!`` and
``%`` start comments. The points are changed as the header says, in the order of Simpack: smallest distance,
shift, rotation, bounds, mirrors, order, unit.
"""

import math
import re

import numpy as np
from numpy.typing import NDArray

from flangeway.errors import InputError
from flangeway.geometry import FloatArray
from flangeway.railway.profiles.formats.raw_profile import (
    KINDS,
    Kind,
    RawProfile,
    keys_and_rows,
    number_of,
    points_in,
    text_of,
)
from flangeway.railway.profiles.formats.two_column import one_line

_MM_PER_M = 1000.0


def read_simpack(text: str, kind: Kind) -> RawProfile:
    """Return the profile in a Simpack file, processed as the file asks.

    An `InputError` if sections are missing, the type is another one than that of the ending, or a number is wrong.

    - `kind`: from the ending of its name.
    """
    content: list[tuple[int, str]] = []
    sections: list[str] = []
    for number, line in enumerate(text.splitlines(), 1):
        # a comment ends a line, not inside quotes
        words = (re.match(r"(?:[^!%']|'[^']*')*", line) or [""])[0].strip()
        section, _, edge = words.rpartition(".")
        if edge == "begin":
            sections.append(section)
        elif edge == "end":
            if sections[-1:] != [section]:
                raise InputError(f"line {number}: {section}.end without its beginning", "whole sections", "check it")
            sections.pop()
        else:  # both sections have a key `type`
            content.append((number, f"header.{words}" if sections[-1:] == ["header"] else words))
    if sections:
        raise InputError(f"a section {sections[-1]}.begin without its end", "whole sections", "the file was cut off")
    keys, rows = keys_and_rows(content)
    points, lines = points_in(rows)
    sure = _refuse_other_kind(keys, kind)
    points, lines, per_metre = _processed(points, lines, keys)
    return RawProfile(
        points,
        lines,
        unit=None if per_metre is None else "mm",
        kind=kind,
        kind_is_sure=sure,
        upwards=False,
        title=text_of(keys, "comment") or text_of(keys, "file"),
    )


def _refuse_other_kind(keys: dict[str, tuple[int, str]], kind: Kind) -> bool:
    """Return whether the header declares the kind of the ending; refuse the other one."""
    line, value = keys.get("header.type", (0, ""))
    stated = {"0": KINDS[0], "1": KINDS[1]}.get(value)
    if stated is not None and stated != kind:
        raise InputError(
            f"line {line}: type = {value}, a {stated}, in a file with the ending of a {kind}",
            "an ending that agrees: .prr for rails, .prw for wheels",
            "rename the file, or correct its header",
        )
    return stated is not None


def _processed(
    points: FloatArray, lines: NDArray[np.int64], keys: dict[str, tuple[int, str]]
) -> tuple[FloatArray, NDArray[np.int64], float | None]:
    """Apply the header; return points, their lines, and the number of the file's units in a metre."""

    def value(key: str) -> float:
        line, text = keys.get(key, (0, ""))
        return number_of(text, key, line) if text else 0.0

    if value("point.dist.min") > 0.0:
        kept = [0]
        for i in range(1, len(points)):
            if abs(points[i, 0] - points[kept[-1], 0]) > value("point.dist.min"):
                kept.append(i)
        points, lines = points[kept], lines[kept]
    points = points + np.array([value("shift.y"), value("shift.z")])
    angle = value("rotate") / (value("units.ang.f") or 1.0)
    if angle:
        cosine, sine = math.cos(angle), math.sin(angle)
        points = points @ np.array([[cosine, sine], [-sine, cosine]])
    low, high = value("bound.y.min"), value("bound.y.max")
    if low < high:
        inside = (points[:, 0] >= low) & (points[:, 0] <= high)
        points, lines = points[inside], lines[inside]
    low, high = value("bound.z.min"), value("bound.z.max")
    if low < high:
        points = np.column_stack([points[:, 0], np.clip(points[:, 1], low, high)])
    points = points * [-1.0 if value("mirror.y") else 1.0, -1.0 if value("mirror.z") else 1.0]
    if value("inversion"):
        points, lines = points[::-1], lines[::-1]
    per_metre = value("units.len.f") or None
    if per_metre is not None:
        if per_metre < 0.0:
            raise InputError(f"units.len.f = {per_metre:g}", "the number of the file's units in a metre", "1000 for mm")
        points = points * (_MM_PER_M / per_metre)
    return np.ascontiguousarray(points), np.ascontiguousarray(lines), per_metre


def write_simpack(points: FloatArray, kind: Kind, title: str) -> str:
    """Return points (n, 2) in mm, in this package's frame of a rail's running surface or a wheel, as a Simpack file.

    z is written downwards, rails from the middle of the track outwards and wheels the other way, as Simpack wants.
    """
    shown = points * [1.0, -1.0]
    outwards = shown[-1, 0] >= shown[0, 0]
    if outwards == (kind == "wheel"):
        shown = shown[::-1]
    comment = re.sub(r"['!%]", " ", one_line(title))
    rows = "".join(f"      {y:.9f} {z:.9f}\n" for y, z in shown)
    return (
        "header.begin\n"
        "  version = 1\n"
        f"  type = {KINDS.index(kind)} ! 0 = rail, 1 = wheel\n"
        "header.end\n"
        "spline.begin\n"
        "  approx.smooth = 0.0\n"
        f"  comment = '{comment}'\n"
        "  mirror.y = 0\n  mirror.z = 0\n  inversion = 0\n"
        "  units.len.f = 1000.0 ! units in a metre: mm\n"
        "  units.ang.f = 1.0\n"
        f"  point.begin\n{rows}  point.end\n"
        "spline.end\n"
    )
