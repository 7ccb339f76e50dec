"""A campaign: one case over many inputs."""

import hashlib
import json
import math
from collections.abc import Mapping
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path
from typing import Any

from flangeway.campaign.columns import POSITION_KEYS
from flangeway.cases.case import RunnableCase
from flangeway.cases.case_file import FILE_KEYS
from flangeway.cases.wheelset.wheelset_case import WheelsetCase
from flangeway.errors import InputError
from flangeway.system.file_content import is_file
from flangeway.system.versions import versions

ROWS_OF_A_CHUNK = 48
"""Most positions that one worker computes together. Fixed: a table depends neither on workers nor on interruptions."""

FEWEST_TOGETHER = 12
"""Positions of the same bodies from which on these are prepared for many positions, which takes as long as some."""


@dataclass(frozen=True)
class Row:
    """One run of a campaign.

    Parameters
    ----------
    number
        Its place in the campaign, from 1.
    varied
        The inputs that vary, as they are written in the campaign's file.
    case
        The case with all its inputs.

    """

    number: int
    varied: Mapping[str, Any]
    case: RunnableCase

    @cached_property
    def content(self) -> dict[str, Any]:
        """All inputs, files by what is in them: where a file lies does not matter."""
        return {"case": self.case.name, **_by_content(self.case.model_dump(mode="json"))}

    @cached_property
    def identity(self) -> str:
        """Hash of all inputs."""
        return _hash(self.content)

    @property
    def is_position(self) -> bool:
        """Whether it can be computed together with other positions of the same bodies."""
        case = self.case
        return (
            isinstance(case, WheelsetCase)
            and case.pairing == "segment-to-segment"
            and case.enforcement != "augmented-lagrange"
            and case.equilibria == "reached"
        )

    @cached_property
    def bodies(self) -> str:
        """Hash of the inputs that shape the bodies: rows that share it differ in position and load only."""
        skipped = POSITION_KEYS if isinstance(self.case, WheelsetCase) else ()
        return _hash({key: value for key, value in self.content.items() if key not in skipped})


@dataclass(frozen=True)
class Campaign:
    """One case over many inputs, checked: every row is a case that can be computed as far as its inputs tell.

    Read one with `Campaign.from_file`.

    Parameters
    ----------
    name
        What it is called.
    case
        Type of the case.
    keys
        Inputs that vary, in their order.
    rows
        Rows in their order.
    columns
        Columns of results to export; empty: all.
    shear
        Whether the maximum shear stresses below the contacts of wheelsets are wanted.

    """

    name: str
    case: type[RunnableCase]
    keys: tuple[str, ...]
    rows: tuple[Row, ...]
    columns: tuple[str, ...] = ()
    shear: bool = False

    def __post_init__(self) -> None:
        if not self.rows:
            raise InputError(f"campaign {self.name} without rows", "one row or more", "vary an input")
        seen: dict[str, int] = {}
        for row in self.rows:
            first = seen.setdefault(row.identity, row.number)
            if first != row.number:
                raise InputError(
                    f"campaign {self.name}: rows {first} and {row.number} with the same inputs",
                    "rows that differ, so that nothing is computed twice",
                    "leave one of them out",
                )

    @classmethod
    def from_file(cls, path: str | Path) -> "Campaign":
        """Read a campaign's file and check all of it.

        Parameters
        ----------
        path
            A TOML file with the keys ``case`` and ``table`` and the tables ``[inputs]``, ``[vary]`` and ``[results]``.

        Raises
        ------
        InputError
            If anything in it is wrong; the message names file, key, value, what is allowed and what to do.

        """
        from flangeway.campaign.campaign_file import read_campaign  # noqa: PLC0415 (it imports this module)

        return read_campaign(Path(path))

    @property
    def identity(self) -> str:
        """Hash of all rows in their order, of what is asked for, and of the version that computes them."""
        return _hash([versions()["flangeway"], self.shear, *(row.identity for row in self.rows)])

    @property
    def chunks(self) -> tuple[tuple[Row | None, tuple[Row, ...]], ...]:
        """Rows that are computed together, the same whoever computes them, after the row they are prepared for.

        Many positions of the same bodies are prepared for the first of all of them; other rows are computed alone and
        have None.
        """
        groups: dict[str, list[Row]] = {}
        for row in self.rows:
            groups.setdefault(row.bodies, []).append(row)
        chunks: list[tuple[Row | None, tuple[Row, ...]]] = []
        for group in groups.values():
            together = len(group) >= FEWEST_TOGETHER and group[0].is_position
            size = min(max(math.ceil(len(group) / 8), FEWEST_TOGETHER), ROWS_OF_A_CHUNK) if together else 1
            first = group[0] if together else None
            chunks += [(first, tuple(group[start : start + size])) for start in range(0, len(group), size)]
        return tuple(chunks)


def _hash(value: Any) -> str:
    text = json.dumps(value, sort_keys=True, ensure_ascii=False)
    return hashlib.sha256(text.encode()).hexdigest()


def _by_content(values: Any) -> Any:
    """Replace names of files by hashes of what is in them."""
    if isinstance(values, list):
        return [_by_content(value) for value in values]
    if not isinstance(values, dict):
        return values
    return {
        key: _file_hash(value) if key in FILE_KEYS and isinstance(value, str) else _by_content(value)
        for key, value in values.items()
    }


def _file_hash(name: str) -> str:
    path = Path(name)
    return f"sha256 {hashlib.sha256(path.read_bytes()).hexdigest()}" if is_file(path) else name
