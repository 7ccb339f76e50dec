"""Sections from files: TOML, CSV of lines and arcs, DXF."""

from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

from flangeway.errors import InputError, located
from flangeway.formats.drawn_section import DrawnSection
from flangeway.formats.outline_csv import csv_section
from flangeway.formats.outline_dxf import dxf_section
from flangeway.formats.outline_toml import toml_section
from flangeway.system.file_content import file_content, utf8_text

ENDINGS = (".toml", ".csv", ".dxf")


def read_section(path: str | Path, *, unit: str | None = None, mirrored: bool = False) -> DrawnSection:
    """Read a section; the ending of the file's name gives its format.

    An `InputError` if the file cannot be read, is no section, or its outline is wrong; the message names the place.

    - `path`: file that ends with ``.toml``, ``.csv`` or ``.dxf``.
    - `unit`: unit of length of a file that does not name one (CSV and DXF).
    - `mirrored`: whether the file (CSV) holds one half only, to be mirrored about x = 0.
    """
    file = Path(path)
    ending = file.suffix.lower()
    if ending not in ENDINGS:
        raise InputError(
            f"file {file} with the ending {ending!r}", f"{', '.join(ENDINGS)}", "save the outline in one of these"
        )
    if mirrored and ending != ".csv":
        raise InputError(f"--mirror for {file}", "half outlines in a CSV file", "draw the whole outline")
    content = file_content(file, "an outline")
    readers: dict[str, Callable[[], DrawnSection]] = {
        ".toml": lambda: toml_section(_text(content), unit=unit),
        ".csv": lambda: csv_section(_text(content), unit=unit, mirrored=mirrored),
        ".dxf": lambda: dxf_section(content, unit=unit),
    }
    with located(f"{file}: "):
        found = readers[ending]()
    return found if found.title else replace(found, title=file.stem)


def _text(content: bytes) -> str:
    text = utf8_text(content)
    if "\0" in text:
        raise InputError("bytes that are no text (a zero byte)", "text in UTF-8", "check the format of the file")
    return text
