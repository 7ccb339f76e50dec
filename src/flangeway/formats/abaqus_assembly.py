"""Abaqus decks as blocks, those of parts and instances written out as one list of nodes and elements."""

import math
from collections.abc import Iterator
from dataclasses import dataclass, field

import numpy as np

from flangeway.errors import InputError
from flangeway.types import Floats

FLAT = 1e-9
MAX_COORDINATE = 1e30


@dataclass(frozen=True)
class DeckBlock:
    """A keyword in capitals, parameters by their names in capitals, words of its data lines, and the lines of all."""

    keyword: str
    parameters: dict[str, str]
    rows: tuple[tuple[str, ...], ...]
    line: int
    lines: tuple[int, ...] = ()

    @property
    def place(self) -> str:
        """How messages call it."""
        return f"*{self.keyword} in line {self.line}"

    def place_of(self, entry: tuple[str, ...] | str) -> str:
        """How messages call one of its rows, or the row of one of its words."""
        rows = zip(self.lines, self.rows, strict=False)
        line = next((line for line, row in rows if row is entry or any(word is entry for word in row)), 0)
        return f"line {line} in the block of {self.place}" if line else self.place


def _blocks(text: str) -> Iterator[DeckBlock]:
    """Keywords of a deck with their data lines, comments left out."""
    keyword, parameters, rows, line = "", {}, [], 0  # type: tuple[str, dict[str, str], list[tuple[str, ...]], int]
    pending = ""
    lines: list[int] = []
    for number, raw in enumerate(text.splitlines(), 1):
        row = pending + raw.strip()
        pending = ""
        if not row or row.startswith("**"):
            continue
        if not row.startswith("*"):
            if keyword:
                words = [word.strip() for word in row.split(",")]
                rows.append(tuple(words[:-1] if words[-1] == "" else words))
                lines.append(number)
            continue
        if row.endswith(","):
            pending = row
            continue
        if keyword:
            yield DeckBlock(keyword, parameters, tuple(rows), line, tuple(lines))
        words = [word.strip() for word in row[1:].split(",")]
        pairs = [word.partition("=") for word in words[1:] if word]
        parameters = {key.strip().upper(): value.strip().strip('"') for key, _, value in pairs}
        keyword, rows, lines, line = " ".join(words[0].upper().split()), [], [], number
    if keyword:
        yield DeckBlock(keyword, parameters, tuple(rows), line, tuple(lines))


def flat_blocks(text: str) -> list[DeckBlock]:
    """Return the keywords of a deck of parts and instances as those of one without; others as they are.

    Each keeps its line. Every instance gets its own numbers and an element set of its name. Sets and surfaces keep
    their names; those whose name several instances have are called ``instance:name``. An `InputError` if an instance is
    of a part that is not there, or is moved out of the plane.
    """
    blocks = list(_blocks(text))
    if not {"PART", "INSTANCE"} <= {block.keyword for block in blocks}:
        return blocks
    return list(_Flattener(blocks).run())


@dataclass
class _Instance:
    """One instance: its part's blocks, its place, the offset of its numbers, and its names."""

    name: str
    blocks: list[DeckBlock]
    turn: Floats
    shift: Floats
    offset: int
    names: dict[str, str] = field(default_factory=dict)


class _Flattener:
    """One call of `flat_blocks`."""

    def __init__(self, blocks: list[DeckBlock]) -> None:
        self.parts: dict[str, list[DeckBlock]] = {}
        self.instances: dict[str, _Instance] = {}
        self.assembly: list[DeckBlock] = []
        self.model: list[DeckBlock] = []
        self._sort(blocks)
        self._name_sets()

    def run(self) -> Iterator[DeckBlock]:
        for instance in self.instances.values():
            for block in instance.blocks:
                yield from self._in_instance(instance, block)
            numbers = [
                _whole(row[0], block) for block in instance.blocks if block.keyword == "ELEMENT" for row in block.rows
            ]
            if len(self.instances) > 1 and numbers:
                limits = (str(min(numbers) + instance.offset), str(max(numbers) + instance.offset), "1")
                yield DeckBlock("ELSET", {"ELSET": instance.name, "GENERATE": ""}, (limits,), 0)
        for block in self.assembly:
            yield from self._in_assembly(block)
        for block in self.model:
            rows = tuple(tuple(self._global(word) for word in row) for row in block.rows)
            yield DeckBlock(block.keyword, block.parameters, rows, block.line, block.lines)

    def _sort(self, blocks: list[DeckBlock]) -> None:
        place: list[DeckBlock] = self.model
        instance: _Instance | None = None
        for block in blocks:
            if block.keyword == "PART":
                place = self.parts.setdefault(block.parameters.get("NAME", ""), [])
            elif block.keyword in ("END PART", "END ASSEMBLY"):
                place = self.model
            elif block.keyword == "ASSEMBLY":
                place = self.assembly
            elif block.keyword == "INSTANCE":
                instance = self._instance(block)
                self.instances[instance.name] = instance
            elif block.keyword == "END INSTANCE":
                instance = None
            elif instance is not None:
                instance.blocks.append(block)
            else:
                place.append(block)

    def _instance(self, block: DeckBlock) -> _Instance:
        part = block.parameters.get("PART", "")
        if part not in self.parts:
            known = ", ".join(self.parts)
            raise InputError(f"{block.place} of the part '{part}'", f"the parts {known}", "export the deck again")
        numbers = [[_real(word, block) for word in row] for row in block.rows]
        shift = np.array((numbers[0] + [0.0, 0.0, 0.0])[:3]) if numbers else np.zeros(3)
        turn, centre = np.eye(2), np.zeros(2)
        if len(numbers) > 1:
            if len(numbers[1]) != 7:
                raise InputError(f"{block.place}: {', '.join(block.rows[1])}", "two points and an angle", "repair it")
            axis = np.array(numbers[1][3:6]) - np.array(numbers[1][:3])
            if abs(axis[0]) + abs(axis[1]) > FLAT * abs(axis[2]):
                raise InputError(
                    f"{block.place}, which is turned out of the plane", "rotations about z", "turn it in the program"
                )
            angle = math.copysign(math.radians(numbers[1][6]), axis[2] * numbers[1][6])
            turn = np.array([[math.cos(angle), -math.sin(angle)], [math.sin(angle), math.cos(angle)]])
            centre = np.array(numbers[1][:2])
        # first shifted, then turned about an axis of the assembly
        others = [each.offset for each in self.instances.values()]
        offset = 10 * max(others) + self._most() if others else 0
        name = block.parameters.get("NAME", part)
        return _Instance(name, list(self.parts[part]), turn, turn @ (shift[:2] - centre) + centre, offset)

    def _most(self) -> int:
        """A power of ten above all numbers of the parts."""
        rows = [row for blocks in self.parts.values() for block in blocks for row in block.rows]
        digits = max((len(word) for row in rows for word in row[:1] if word.isdigit()), default=1)
        return 10**digits

    def _name_sets(self) -> None:
        used: dict[str, int] = {}
        for instance in self.instances.values():
            for name in {name for block in instance.blocks for name in _defined(block)}:
                used[name] = used.get(name, 0) + 1
        for instance in self.instances.values():
            for block in instance.blocks:
                for name in _defined(block):
                    instance.names[name] = name if used[name] == 1 else f"{instance.name}:{name}"

    def _in_instance(self, instance: _Instance, block: DeckBlock) -> Iterator[DeckBlock]:
        rows: list[tuple[str, ...]] = []
        if block.keyword == "NODE":
            for row in block.rows:
                x, y = instance.turn @ [_real(word, block) for word in (*row[1:3], "0", "0")[:2]] + instance.shift
                number = _whole(row[0], block) + instance.offset
                rows.append((str(number), repr(float(x)), repr(float(y)), *row[3:4])[: len(row)])
        elif block.keyword == "ELEMENT":
            rows = [tuple(str(_whole(word, block) + instance.offset) for word in row) for row in block.rows]
        elif block.keyword in ("NSET", "ELSET", "SURFACE"):
            generated = "GENERATE" in block.parameters
            rows = [self._moved(row, instance, generated) for row in block.rows]
        else:
            rows = [tuple(row) for row in block.rows]
        parameters = {
            key: instance.names.get(value, value) if key in ("NSET", "ELSET", "NAME") else value
            for key, value in block.parameters.items()
        }
        yield DeckBlock(block.keyword, parameters, tuple(rows), block.line, block.lines)

    def _in_assembly(self, block: DeckBlock) -> Iterator[DeckBlock]:
        parameters = {key: value for key, value in block.parameters.items() if key != "INSTANCE"}
        instance = self.instances.get(block.parameters.get("INSTANCE", ""))
        if instance is not None and block.keyword in ("NSET", "ELSET", "SURFACE"):
            rows = tuple(self._moved(row, instance, "GENERATE" in parameters) for row in block.rows)
        elif block.keyword == "NODE":
            return  # reference points: no element has them
        else:
            rows = tuple(tuple(self._global(word) for word in row) for row in block.rows)
        yield DeckBlock(block.keyword, parameters, rows, block.line, block.lines)

    def _moved(self, row: tuple[str, ...], instance: _Instance, generated: bool) -> tuple[str, ...]:
        """Members of a set with the numbers and names of an instance; the step of a range stays."""
        words = []
        for place, word in enumerate(row):
            number = word.lstrip("-").isdigit() and not (generated and place == 2)
            words.append(str(int(word) + instance.offset) if number else instance.names.get(word, word))
        return tuple(words)

    def _global(self, word: str) -> str:
        """A name such as ``Upper-1.Top``, or a number of an instance, as it is called now."""
        owner, point, name = word.partition(".")
        if not point or owner not in self.instances:
            return word
        instance = self.instances[owner]
        return str(int(name) + instance.offset) if name.isdigit() else instance.names.get(name, name)


def _defined(block: DeckBlock) -> list[str]:
    """Names of sets and surfaces that a block makes."""
    keys = {"NODE": "NSET", "ELEMENT": "ELSET", "NSET": "NSET", "ELSET": "ELSET", "SURFACE": "NAME"}
    name = block.parameters.get(keys.get(block.keyword, ""), "")
    return [name] if name else []


def _whole(word: str, block: DeckBlock) -> int:
    try:
        return int(word)
    except ValueError as reason:
        raise InputError(f"{block.place_of(word)}: {word[:40]}", "whole numbers", "repair the line") from reason


def _real(word: str, block: DeckBlock) -> float:
    try:
        value = float(word.upper().replace("D", "E"))
    except ValueError as reason:
        raise InputError(f"{block.place_of(word)}: {word[:40]}", "a number and coordinates", "repair it") from reason
    if not abs(value) <= MAX_COORDINATE:
        raise InputError(f"{block.place_of(word)}: {word[:40]}", f"coordinates up to {MAX_COORDINATE:g}", "repair it")
    return value
