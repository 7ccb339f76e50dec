"""MiniProf files: ``.ban`` for rails and ``.whl`` for wheels.

The head of the file has lines ``Key=value``, of which ``ColumnDef`` names the columns, ``XYPoints`` counts the points
and ``WheelDiameterTaperline`` places the tape line; an empty line and one point a line follow. Files of old versions
have ``MINIPROF`` in one of their first three lines, words without keys, and points behind the first empty line.
Everything after ``"``, ``!`` or ``%`` is a comment. Lengths are mm, unless the user gives another unit. The second
column of rails points up and that of wheels towards the flange's tip, unless the shape shows the contrary, since
programs differ; the first column of wheels counts from the flange's back.
"""

import re

from flangeway.errors import InputError
from flangeway.geometry import FloatArray
from flangeway.railway.profiles.formats.raw_profile import (
    Kind,
    RawProfile,
    keys_and_rows,
    leading_numbers,
    number_of,
    points_in,
    text_of,
)
from flangeway.railway.profiles.formats.two_column import one_line

TAPE_MM = 70.0  # usual distance of the tape line from the flange's back (EN 13715)

_N_FIRST_LINES = 3
_REFERENCE = "".join(
    f"RefPoint{i}={['0.0000, 0.0000', '10.0000, 0.0000', '0.0000, 5.0000'][(i - 1) % 3]}\n" for i in range(1, 10)
)


def read_miniprof(text: str, kind: Kind) -> RawProfile:
    """Return the profile in a MiniProf file.

    An `InputError` if it has several profiles, no columns X and Y, no points, or not as many points as its header.

    - `kind`: from the ending of its name.
    """
    lines = text.splitlines()
    if any(line.strip().startswith("[FileInfo]") for line in lines[:_N_FIRST_LINES]):
        raise InputError(
            "a MiniProf file of several profiles", "one profile a file", "save the profile that you want alone"
        )
    if any("MINIPROF" in line for line in lines[:_N_FIRST_LINES]):  # words without keys, up to the first empty line
        lines = [""] * lines.index("") + lines[lines.index("") :] if "" in lines else []
    header, rows = keys_and_rows((n, re.split(r'["!%]', line, maxsplit=1)[0]) for n, line in enumerate(lines, 1))
    line, columns = header.get("columndef", (0, ""))
    names = [name.strip().upper() for name in columns.split(",")] if columns else ["X", "Y"]
    if "X" not in names or "Y" not in names:
        raise InputError(f"line {line}: ColumnDef={columns}", "columns X and Y", "save the file with both")
    points, numbers = points_in(rows, names.index("X"), names.index("Y"))
    notices: list[str] = []
    if text_of(header, "xypoints"):
        line, text = header["xypoints"]
        wanted = number_of(text, "XYPoints", line)
        if len(points) < 0.9 * wanted:
            raise InputError(
                f"{len(points)} points in a file with XYPoints={wanted:g}",
                "as many points as XYPoints",
                "the file was cut off: save it again, or correct XYPoints",
            )
        if len(points) != wanted:
            notices.append(f"The header has XYPoints={wanted:g}, the file {len(points)} points; all of them are taken.")
    offsets = [text_of(header, key) for key in ("xoffset", "yoffset")]
    if any(offset and leading_numbers(offset) not in ([], [0.0]) for offset in offsets):
        notices.append(f"XOffset and YOffset ({', '.join(offsets)}) are not applied.")
    side = [f"{key}={text}" for key in ("Rail", "Side") if (text := text_of(header, key.lower()))]
    if side:
        notices.append(
            f"The header has {', '.join(side)}; the profile is used as it is, --mirror makes it the other side."
        )
    line, value = header.get("wheeldiametertaperline", (0, ""))
    tape = number_of(value, "WheelDiameterTaperline", line) if value and kind == "wheel" else None
    title = next(filter(None, (text_of(header, key) for key in ("mpdn", "comment", "filename", "uof1"))), "")
    return RawProfile(
        points,
        numbers,
        unit="mm",
        unit_is_sure=False,
        kind=kind,
        upwards=kind == "rail",
        tape_mm=tape,
        title=title,
        notices=tuple(notices),
    )


def write_miniprof(points: FloatArray, kind: Kind, title: str, back_mm: float = TAPE_MM) -> str:
    """Return points (n, 2) in mm as a MiniProf file.

    Rails: from the top, second column up. Wheels: from the flange's back, second column towards the flange's tip.

    - `points`: in this package's frame of a rail's running surface or a wheel.
    - `title`: goes into ``MPDN``.
    - `back_mm`: distance of the flange's back from the tape line of a wheel; goes into ``WheelDiameterTaperline``.
    """
    shown = points if kind == "rail" else points * [1.0, -1.0] + [back_mm, 0.0]
    tape = f"WheelDiameterTaperline={back_mm!r}\n" if kind == "wheel" else ""
    rows = "".join(f"{x:.9f} {y:.9f}\n" for x, y in shown)
    name = re.sub(r'["!%=]', " ", one_line(title))
    return (
        f"ProgramName=flangeway\nMPDN={name}\nMPTypeNo=299\nMPSerNo=0\nXoffset=0.0000\nYoffset=0.0000\n"
        f"{_REFERENCE}{tape}ColumnDef=X,Y\nXYPoints={len(points)}\nChars=UTF8\n\n{rows}"
    )
