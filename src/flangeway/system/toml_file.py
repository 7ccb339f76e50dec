"""What case files and campaigns share: a file in TOML, and the lines of its keys."""

import re
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path
from typing import Any, ClassVar, Self

from flangeway.errors import InputError, located
from flangeway.system.file_content import limited_bytes, toml_data, utf8_text
from flangeway.types import Key

MAX_BYTES = 5_000_000

_HEADER = re.compile(r"\s*(\[\[?)([\w.\s\"'-]+)\]\]?\s*(?:#.*)?$")
_NAME = r"(?:[\w-]+|\"[^\"]*\"|'[^']*')"
_KEY = re.compile(rf"\s*({_NAME}(?:\s*\.\s*{_NAME})*)\s*=")


@dataclass(frozen=True)
class TomlKind:
    """What messages about a file in TOML say: its name, what may be given instead, and advice for each fault."""

    name: str
    instead: str
    get_one: str
    lines: str
    too_large: str


@dataclass(frozen=True)
class TomlFile:
    """A file in TOML, its text, and the data in it."""

    file: Path
    text: str
    data: dict[str, Any]

    kind: ClassVar[TomlKind]

    @classmethod
    def read(cls, file: Path) -> Self:
        """Read a file; an `InputError` if it cannot be read, is larger than `MAX_BYTES`, or is no TOML in UTF-8."""
        kind = cls.kind
        try:
            size, content = limited_bytes(file, MAX_BYTES)
        except (OSError, ValueError) as reason:  # a zero byte in the name is the latter
            raise InputError(
                f"{kind.name} {file}: {getattr(reason, 'strerror', None) or reason}",
                f"a file that can be read{kind.instead}",
                kind.get_one,
            ) from reason
        if size > MAX_BYTES:
            raise InputError(
                f"{kind.name} {file} of {size} bytes", f"a file of up to {MAX_BYTES} bytes", kind.too_large
            )
        with located(f"{file}: "):
            text = utf8_text(content)
            return cls(file, text, toml_data(text, kind.lines))

    def place(self, key: Key) -> str:
        """File and line of a key, or of the nearest one above it, for the start of a message."""
        lines = self._lines
        for end in range(len(key), 0, -1):
            if key[:end] in lines:
                return f"{self.file}, line {lines[key[:end]]}: "
        return f"{self.file}: "

    @cached_property
    def _lines(self) -> dict[Key, int]:
        """Line of each table and key."""
        lines: dict[Key, int] = {}
        items: dict[Key, int] = {}
        table: Key = ()
        for number, row in enumerate(self.text.split("\n"), 1):
            if header := _HEADER.match(row):
                table = ()
                names = _names(header[2])
                for place, name in enumerate(names):
                    table = (*table, name)
                    if place == len(names) - 1 and header[1] == "[[":
                        items[table] = items.get(table, -1) + 1
                    if table in items:
                        table = (*table, items[table])
                lines.setdefault(table, number)
            elif key := _KEY.match(row):
                names = _names(key[1])
                for end in range(1, len(names) + 1):
                    lines.setdefault((*table, *names[:end]), number)
        return lines


def _names(dotted: str) -> list[str]:
    """Parts of a name with points between them; a point inside quotation marks is part of a name."""
    return [name.strip("\"'") for name in re.findall(_NAME, dotted)]
