"""The cases by name and in TOML files: reading them, their identity, and files to begin with."""

import hashlib
import importlib
import itertools
import json
import math
import os
import re
import textwrap
from collections.abc import Collection, Iterable, Iterator, Mapping, Sequence
from pathlib import Path
from typing import Any, get_origin

from pydantic.fields import FieldInfo

from flangeway.cases.bodies.bodies_run import TwoBodiesCase
from flangeway.cases.bodies.presets import HertzCase
from flangeway.cases.case import OF_REPORT, RunnableCase
from flangeway.cases.rolling_patch_case import RollingPatchCase
from flangeway.cases.section_run import TorsionCase
from flangeway.cases.spatial_case import CraneWheelCase, CrossedCylindersCase, RollerCase, SpatialCase
from flangeway.cases.summary import mapped
from flangeway.cases.wheelset.wheelset_case import Wheelset
from flangeway.errors import InputError, located, short
from flangeway.railway.profiles.formats.slice_files import files_of
from flangeway.records import (
    TAG,
    Record,
    allowed,
    alternatives,
    are_tables,
    closest,
    default_of,
    fields_of,
    key_text,
    kind_of,
    path_by_ending,
    records_in,
    tables_in,
    with_settings,
)
from flangeway.system.file_content import TomlFile, TomlKind, is_file, names_file
from flangeway.system.output_folder import versions
from flangeway.types import Key
from flangeway.units import Units, UsUnit, us_key

# --- The cases by name, and in TOML files: ``case = "wheelset-curve"`` and the inputs of that case as keys.


CASES: dict[str, type[RunnableCase]] = {
    case.name: case
    for case in (
        Wheelset,
        *(HertzCase, TorsionCase, TwoBodiesCase),
        *(CraneWheelCase, RollerCase, CrossedCylindersCase, SpatialCase, RollingPatchCase),
    )
}
"""Types of the cases by name."""

CASE_FILES = {file.stem: file for file in sorted((Path(__file__).parent / "files").glob("*.toml"))}
"""Case files that are distributed with the program, by name; cases of bodies with all their tables."""

FORMAT = 1  # number of the format that this version writes; files of lower numbers are read, higher ones refused
ENDING = ".toml"

FILE_KEYS = ("rail", "wheel", "section", "file")
"""Inputs that may name a file; paths in a case file are relative to its folder."""
OPTION_OF_ENDING = {
    **dict.fromkeys((".ban", ".prr", ".rail", ".slcs"), "--rail"),
    **dict.fromkeys((".whl", ".prw", ".wheel", ".slcw"), "--wheel"),
}
PROFILE_ENDINGS = (*OPTION_OF_ENDING, ".csv", ".dxf", ".mpt")
MESH_ENDINGS = (".msh", ".inp", ".vtu", ".vtk", ".xdmf", ".med", ".bdf", ".nas")
FILE_ENDINGS = (ENDING, ".txt", ".dat", *PROFILE_ENDINGS, *MESH_ENDINGS)


def find_case(name: str) -> type[RunnableCase]:
    """Return the type of the case with a name.

    Raises
    ------
    InputError
        If there is none; the message lists those there are and names the nearest.

    """
    if name in CASE_FILES:
        return _text_of(name).case()[0]
    if name not in CASES:
        names = [*CASES, *CASE_FILES]
        raise InputError(f"there is no case called {name!r}", f"one of: {', '.join(names)}", closest(name, names))
    return CASES[name]


def file_title(name: str) -> str:
    """Title of a case file that is distributed with the program: its first line."""
    return CASE_FILES[name].read_text(encoding="utf-8").partition("\n")[0].removeprefix("# ")


def is_case_file(name: str | Path) -> bool:
    """Whether a name means a case file, one that is distributed with the program too, not a case."""
    path = Path(name)
    return str(name) in CASE_FILES or path.suffix.lower() in (ENDING, *PROFILE_ENDINGS, *MESH_ENDINGS) or is_file(path)


def load_case(name_or_file: str | Path, **settings: Any) -> RunnableCase:
    """Return the case of a name with its defaults, or that of a case file.

    Parameters
    ----------
    name_or_file
        Name of a case, or a TOML file.
    settings
        Inputs that go before those of the file.

    Raises
    ------
    InputError
        If there is no such case or file, or an input is wrong; of files the message names file, line and key.

    """
    return read_case(name_or_file, settings)


def read_case(name_or_file: str | Path, settings: Mapping[str, Any] | None = None) -> RunnableCase:
    """Return a case as `load_case` does.

    - `name_or_file`: name of a case, or a TOML file.
    - `settings`: inputs that go before those of the file. Those inside tables are named by points, items of a list by
      their numbers from 1 or by their ``name``: ``bodies.disc.size_mm``.
    """
    given = dict(settings or {})
    if not is_case_file(name_or_file):
        return _by_name(str(name_or_file), given)
    text = _text_of(name_or_file)
    case, values = text.case()
    inputs = with_settings(case, resolved(text, values, text.file.parent), given)
    replaced = {path_by_ending(case, key)[0] for key in given}

    def where(key: Key) -> str:
        return "" if key and key[0] in replaced else text.place(key)

    return case.from_values(inputs, where)


def _by_name(name: str, settings: Mapping[str, Any]) -> RunnableCase:
    case = find_case(name)
    values = with_settings(case, {}, settings)
    missing = [key for key in case.example if case.model_fields[key].is_required() and key not in values]
    if missing:
        raise InputError(
            f"the case {case.name} without {' and '.join(missing)}",
            f"a case file with {' and '.join(missing)}",
            f"`flangeway init {case.name}` writes one to begin with, `flangeway run {case.name}.toml` computes it",
        )
    return case.from_values(values)


def _text_of(name: str | Path) -> "CaseText":
    """Text of a case file, or of a bundled one by its name; meshes, outlines and profiles are inputs and refused."""
    file = CASE_FILES.get(str(name), Path(name))
    _refuse_other_file(file)
    return CaseText.read(file)


def _refuse_other_file(file: Path) -> None:
    """Refuse meshes, outlines and profiles, which are inputs of a case and no case themselves."""
    ending = file.suffix.lower()
    if ending in MESH_ENDINGS or ending in PROFILE_ENDINGS:
        what, advice = (
            "a mesh or a deck",
            f'name it in a case file, file = "{file}"; `flangeway init two-bodies` writes one',
        )
        if ending in PROFILE_ENDINGS:
            what, option = "an outline or a profile", OPTION_OF_ENDING.get(ending, "--wheel (or --rail)")
            run = f"`flangeway run wheelset {option} {file}`"
            advice = run if ending in OPTION_OF_ENDING else f"{run} for a profile; else {advice}"
        raise InputError(
            f"{file}, which is {what}, not a case",
            "the name of a case, or a case file (.toml), which gives materials, supports, loads and contacts",
            advice,
        )


def check_case(case: RunnableCase, file: str | Path | None = None) -> None:
    """Raise `InputError` for what is wrong beyond single values; the message names the file, if one is given."""
    try:
        case.check()
    except InputError as reason:
        location = "" if file is None else _text_of(file).place(_key_in(reason.given))
        raise InputError(location + reason.given, reason.allowed, reason.advice) from reason


def _key_in(message: str) -> Key:
    """Key that a message starts with, as `key_text` writes it."""
    path = re.match(r"\w+(?:\[\d+\]|\.\w+)*", message)
    key: list[str | int] = []
    for name, number in re.findall(r"(\w+)(?:\[(\d+)\])?", path[0] if path else ""):
        key += [name] if not number else [name, int(number) - 1]
    return tuple(key)


OF_COMMANDS = {"vary": "campaign", "table": "campaign", "evolution": "damage"}
"""Keys of TOML files that are no cases, and the commands that take them."""


class CaseText(TomlFile):
    """A case file."""

    kind = TomlKind(
        name="case file",
        instead=", or the name of a case",
        get_one="correct the name; `flangeway init NAME` writes a case file",
        lines='lines such as gauge_mm = 1435.0 or rail = "60E1"',
        too_large="give meshes in files of their own",
    )

    def case(self) -> tuple[type[RunnableCase], dict[str, Any]]:
        """Type of the case, and its inputs; an `InputError` if it is a file of another command."""
        for key, command in OF_COMMANDS.items():
            if key in self.data:
                raise InputError(
                    f"{self.place((key,))}{key}, which a file of `flangeway {command}` has",
                    "a case file, whose inputs are the inputs of one case",
                    f"`flangeway {command} {self.file}` computes it",
                )
        name, values = self.name_and_values()
        with located(self.place(("case",))):
            return find_case(name if isinstance(name, str) else short(name)), values

    def name_and_values(self) -> tuple[Any, dict[str, Any]]:
        """Value of the key ``case``, and the inputs."""
        values = dict(self.data)
        self._refuse_other_format(values.pop("flangeway", FORMAT))
        if "case" not in values:
            raise InputError(
                f"{self.file}: no key case",
                'a line such as case = "wheelset" at the top',
                "add it; `flangeway cases` lists the names"
                + (", `flangeway section` reads outlines" if "outer" in values or "parts" in values else ""),
            )
        return values.pop("case"), values

    def _refuse_other_format(self, number: Any) -> None:
        location = self.place(("flangeway",))
        if isinstance(number, bool) or not isinstance(number, int) or number < 1:
            raise InputError(
                f"{location}flangeway = {short(number)}", f"the number of the file's format, {FORMAT}", "leave it out"
            )
        if number > FORMAT:
            raise InputError(
                f"{location}flangeway = {short(number)}, a newer format than this version reads",
                f"up to {FORMAT} in flangeway {versions()['flangeway']}",
                "install a newer flangeway, or write the file anew with `flangeway init`",
            )


def resolved(file: TomlFile, values: Mapping[str, Any], folder: Path, above: Key = ()) -> dict[str, Any]:
    """Inputs of a file with the names of other files made independent of the current folder.

    Parameters
    ----------
    file, values
        The file, and inputs in it; those inside tables may be named by points.
    folder
        Its folder, to which names of files are relative.
    above
        Key of the table that the inputs are in.

    Raises
    ------
    InputError
        If a name with the ending of a file, or with a folder, names none.

    """

    def path(key: Key, name: Any) -> Any:
        last = next(str(item) for item in reversed(key) if not isinstance(item, int))
        if last.rpartition(".")[2] not in FILE_KEYS or not isinstance(name, str):
            return name
        if names_file(name, folder):
            return str(folder / name)
        if Path(name).suffix.lower() in FILE_ENDINGS or "/" in name:
            parts = [part for item in key for part in (item.split(".") if isinstance(item, str) else (item,))]
            raise InputError(
                f"{file.place((*above, *parts))}{key_text(key)} = {short(name)}: there is no such file",
                f"a file, its path relative to the case file's folder {folder.resolve()}",
                "correct the path, or copy the file there",
            )
        return name

    made: dict[str, Any] = mapped(values, path)
    return made


# --- Identity of cases by the content of their inputs, and of the bodies that several cases share.


MAX_PREPARED = 3
"""Bodies that a process keeps prepared; those of a wheelset take some hundred megabytes."""


def case_content(case: RunnableCase, without: Collection[str] = ()) -> dict[str, Any]:
    """Return the inputs of a case, files by their content: their folder does not matter.

    - `without`: inputs to leave out besides those of the report.
    """
    values = case.model_dump(mode="json", exclude={*OF_REPORT, *without})

    def by_content(key: Key, value: Any) -> Any:
        return _file_hash(value) if key[-1] in FILE_KEYS and isinstance(value, str) else value

    return {"case": case.name, **mapped(values, by_content)}


def bodies_key(case: RunnableCase) -> str:
    """Return a hash of the inputs that shape the bodies: cases that share it share their `prepared` bodies."""
    return hash_of(case_content(case, case.position_keys))


def hash_of(value: Any) -> str:
    """Return a hash of tables, lists, numbers and texts."""
    text = json.dumps(value, sort_keys=True, ensure_ascii=False)
    return hashlib.sha256(text.encode()).hexdigest()


def _file_hash(name: str) -> str:
    path = Path(name)
    if not is_file(path):
        return name
    content = [file.read_bytes() for file in files_of(path) if is_file(file)]
    return f"sha256 {hashlib.sha256(b''.join(content)).hexdigest()}"


# --- Case files to begin with: every key with its meaning, unit, range and default; and the JSON Schema of all cases.


WIDTH = 110


def write_template(case: type[RunnableCase], units: Units = "metric") -> str:
    """Return the text of a case file.

    Inputs that most users change are set, the others are comments with their defaults: the file computes the same as
    the case without inputs, up to round-off where its keys have US units.
    """
    example = dict(case.example) | ({"units": units} if units == "us" else {})
    lines = [
        f"#:schema {case.name}.schema.json",
        f"# {case.title}.",
        "#",
        f"# Compute it with `flangeway run` and this file's name. `flangeway cases {case.name}` explains the keys;",
        "# lines that start with # are comments: remove the # to set a key.",
        f"# `flangeway schema {case.name} --to {case.name}.schema.json` lets editors complete them.",
        "",
        f"flangeway = {FORMAT}  # format of this file",
        f'case = "{case.name}"',
    ]
    return "\n".join([*lines, *_template_of([case], (), example, case.essential, units)]) + "\n"


def write_case_file(case: RunnableCase) -> str:
    """Return the text of a case file that computes a case again: all inputs that are not the defaults, with all digits.

    Names of files are as given, in tables relative to the current folder; a case file reads them from its own folder.
    """
    return toml_text({"flangeway": FORMAT, "case": case.name, **case.changed})


def write_python(case: Record) -> str:
    """Return the text of a Python script that makes a case again: ``case = `` constructors with all that is no default.

    Names of files are as given.

    Raises
    ------
    InputError
        If an input is an object of a script, which has no name.
    """
    from rich.pretty import pretty_repr  # noqa: PLC0415 (few commands write scripts)

    names: dict[str, set[str]] = {}
    for kind in _kinds_in(case):
        names.setdefault(_home(kind), set()).add(kind.__name__)
    imports = list[str]()
    for module, of_module in sorted(names.items()):
        line = f"from {module} import {', '.join(sorted(of_module))}"
        items = "".join(f"    {name},\n" for name in sorted(of_module))
        imports.append(line if len(line) <= WIDTH else f"from {module} import (\n{items})")
    # a keyword of Python is no name of an argument
    text = re.sub(r"\(from=(\([^()]*\))\)", r'(**{"from": \1})', pretty_repr(case, max_width=WIDTH))
    return "\n".join([*imports, "", f"case = {text}\n"])


def _kinds_in(value: Any) -> Iterator[type[Record]]:
    """Yield the types of the records in a value; an `InputError` for what has no text in Python."""
    inner: Iterable[Any] = value if isinstance(value, list | tuple) else ()
    if isinstance(value, Record):
        yield type(value)
        inner = [getattr(value, key) for key in value.changed]
    elif isinstance(value, Mapping):
        inner = value.values()
    elif not (inner or isinstance(value, str | bool | int | float | list | tuple | None)):
        raise InputError(
            f"{short(value)}, an object of a script", "names of profiles and of files", "name a file in its place"
        )
    for item in inner:
        yield from _kinds_in(item)


def _home(kind: type[Record]) -> str:
    """Return the shortest package from which a type of records is imported, else its module."""
    packages = itertools.accumulate(kind.__module__.split("."), "{}.{}".format)
    return next(name for name in packages if getattr(importlib.import_module(name), kind.__name__, None) is kind)


def toml_text(values: Mapping[str, Any]) -> str:
    """Return tables, lists and values as TOML."""
    return "\n".join(_toml_lines(values, ())) + "\n"


def _toml_lines(table: Mapping[str, Any], above: tuple[str, ...]) -> list[str]:
    """Lines of a table: plain values, then the tables in it and the lists of tables under their headers."""
    lines, inner = list[str](), list[str]()
    for key, value in table.items():
        path = (*above, _toml_key(key))
        if isinstance(value, Mapping):
            inside = _toml_lines(value, path)
            inner += ["", f"[{'.'.join(path)}]", *inside] if (inside and inside[0]) or (above and not value) else inside
        elif isinstance(value, list) and value and all(isinstance(item, Mapping) for item in value):
            for item in value:
                inner += ["", f"[[{'.'.join(path)}]]", *_toml_lines(item, path)]
        elif value is not None:
            seen = (
                os.path.relpath(value)
                if above and key in FILE_KEYS and isinstance(value, str) and names_file(value)
                else value
            )
            lines.append(f"{path[-1]} = {toml_value(seen)}")
    return [*lines, *inner]


def _toml_key(key: str) -> str:
    """Write a key, in quotation marks where it is no bare one, as the name of a cell set may be."""
    return key if re.fullmatch(r"[A-Za-z0-9_-]+", key) else json.dumps(key, ensure_ascii=False)


def _template_of(
    records: list[type[Record]], above: tuple[str, ...], example: Mapping[str, Any], essential: Sequence[str],
    units: Units,
) -> list[str]:  # fmt: skip
    """Lines of a table: keys with their meanings, those of the example and the essential ones set, then its tables.

    - `records`: kinds that have the table together.
    - `above`: path of its table.
    """
    lines, inner = list[str](), list[str]()
    for key, field in fields_of(records).items():
        path, tables = (*above, key), tables_in(field.annotation)
        if not are_tables(field.annotation):
            value = example.get(key, default_of(field))
            active = key in example or ".".join(path) in essential
            lines += ["", *_entry(key, field, value, units, active=active)]
            continue
        origins = {get_origin(kind) for kind in alternatives(field.annotation)}
        name, items = ".".join(path) + (".NAME" if dict in origins else ""), example.get(key, [])
        items = items if isinstance(items, list) else [items]
        is_set = bool(items) or any(entry.startswith(f"{name}.") for entry in essential)
        header = f"[[{name}]]" if list in origins else f"[{name}]"
        default = type(default_of(field))
        table = next((kinds for kinds in tables if default in kinds), tables[0])
        words = f" ({', '.join(f'{TAG} = {kind_of(kind)}' for kind, *_ in tables)})" if len(tables) > 1 else ""
        inner += ["", "", *_comment(f"{field.description}{words}")]
        body = _template_of(table, path, items[0] if items else _tagged(table[0]), essential, units)
        # a table that is not set is a comment with all that is in it, and so are the other kinds of one
        inner += [header, *body] if is_set else _commented([header, *body])
        for other in tables:
            if other is not table and not is_set:
                inner += _commented(_template_of(other, path, _tagged(other[0]), (), units))
        for item in items[1:]:
            inner += ["", header, *(_line(entry, value, units) for entry, value in item.items())]
    return [*lines, *inner]


def _tagged(record: type[Record]) -> dict[str, Any]:
    """Value of the field ``kind`` of a record that has one."""
    return {} if kind_of(record) is None else {TAG: kind_of(record)}


def _commented(lines: list[str]) -> list[str]:
    """Lines as comments; empty ones and comments as they are."""
    return [line if line[:1] in ("", "#") else f"# {line}" for line in lines]


def _comment(text: str) -> list[str]:
    return textwrap.wrap(text, WIDTH, initial_indent="# ", subsequent_indent="# ", break_long_words=False,
                         break_on_hyphens=False)  # fmt: skip


def _entry(key: str, field: FieldInfo, value: Any, units: Units, *, active: bool) -> list[str]:
    """Comment and line of a key."""
    unit = us_key(key) if units == "us" else None
    lines = _comment(f"{field.description} ({allowed(field, unit)})")
    if value is None or value == []:
        return [*lines, f"# {unit.name if unit else key} ="]
    return [*lines, ("" if active else "# ") + _line(key, value, units)]


def _line(key: str, value: Any, units: Units) -> str:
    """Line of a key with a value."""
    values = {key: value} if units == "metric" else _with_us_keys({key: value})
    return "".join(f"{name} = {toml_value(entry)}" for name, entry in values.items())


def _with_us_keys(value: Any) -> Any:
    """Return tables, also those in lists, with keys and numbers in US units."""
    if isinstance(value, list):
        return [_with_us_keys(entry) for entry in value]
    if not isinstance(value, Mapping):
        return value
    units = {key: us_key(key) for key in value}
    return {
        unit.name if unit else key: unit.of(value[key]) if unit else _with_us_keys(value[key])
        for key, unit in units.items()
    }


def toml_value(value: Any) -> str:
    """Write a value as TOML; lists and tables in one line."""
    if isinstance(value, bool):
        return str(value).lower()
    if isinstance(value, int | float):
        if isinstance(value, float) and not math.isfinite(value):
            raise ValueError(f"no number to write: {value}")
        return repr(value)
    if isinstance(value, str):
        return json.dumps(value, ensure_ascii=False)
    if isinstance(value, Record):
        value = value.changed
    if isinstance(value, Mapping):
        return "{ " + ", ".join(f"{_toml_key(key)} = {toml_value(entry)}" for key, entry in value.items()) + " }"
    return "[" + ", ".join(toml_value(entry) for entry in value) + "]"


def schema(case: type[RunnableCase]) -> dict[str, Any]:
    """Return the JSON Schema of the files of a case, with keys, units, ranges and meanings.

    Editors use it for completion and to mark mistakes, as those with Taplo where the first line of a file is
    ``#:schema wheelset.schema.json``.
    """
    tables = _tables_of(case)
    for table in tables:
        table.described_fields()
        table.model_rebuild(force=True)  # a model that has checked values keeps what it knew then
    described = case.model_json_schema()
    definitions = described.pop("$defs", {})
    names = {table.__name__: table for table in tables}
    for name, definition in definitions.items():
        _accept_all_spellings(definition, names.get(name))
    _accept_all_spellings(described, case)
    return {
        "$schema": "https://json-schema.org/draft/2020-12/schema",
        "title": case.title,
        "type": "object",
        "properties": {
            "flangeway": {"const": FORMAT, "description": "format of the file; may be left out"},
            "case": {"const": case.name, "description": case.title},
            **described["properties"],
        },
        "required": ["case", *described.get("required", [])],
        **{key: described[key] for key in ("allOf",) if key in described},
        "additionalProperties": False,
        "$defs": definitions,
    }


def _tables_of(table: type[Record]) -> list[type[Record]]:
    """Return the tables inside a table, inner ones first, and itself."""
    inner = [kind for field in table.model_fields.values() for kind in records_in(field.annotation)]
    return [*(nested for kind in inner for nested in _tables_of(kind)), table]


_BOUNDS = ("minimum", "maximum", "exclusiveMinimum", "exclusiveMaximum")


def _accept_all_spellings(table: dict[str, Any], record: type[Record] | None) -> None:
    """Add to the description of a table what its reader accepts besides: US keys, kinds as texts, and what it excludes.

    Of a needed input the metric key or the one with a US unit is needed.
    """
    for described in table.get("properties", {}).values():
        _accept_kinds(described)
    units = {key: unit for key in table.get("properties", {}) if (unit := us_key(key))}
    for key, unit in units.items():
        table["properties"].setdefault(unit.name, _in_us(table["properties"][key], unit))

    def written(*keys: str) -> dict[str, Any]:
        names = [name for key in keys for name in (key, *([units[key].name] if key in units else []))]
        return {"anyOf": [{"required": [name]} for name in names]}

    conditions = [written(key) for key in table.get("required", []) if key in units]
    conditions += [{"not": {"required": [key, unit.name]}} for key, unit in units.items()]
    if record is not None:
        pairs = [pair for group in record.exclusive for pair in itertools.combinations(group, 2)]
        conditions += [{"not": {"allOf": [written(one), written(other)]}} for one, other in pairs]
        conditions += [written(*group) for group in record.needed]
        conditions += [{"anyOf": [{"not": written(key)}, written(other)]} for key, other in record.needs]
    if "required" in table:
        table["required"] = [key for key in table["required"] if key not in units]
    if conditions:
        table["allOf"] = conditions


def _accept_kinds(described: dict[str, Any]) -> None:
    """Let a table of one of several kinds leave out its kind, or be the name of it alone."""
    kinds = described.pop("discriminator", {}).get("mapping", {})
    if kinds:
        described["anyOf"] = [*described.pop("oneOf"), {"enum": [*kinds]}]
    for inner in (*described.get("anyOf", ()), described.get("items", {})):
        if inner:
            _accept_kinds(inner)


def _in_us(described: Any, unit: UsUnit) -> Any:
    """Return the description of an input with its limits in a US unit, and without its default."""
    if isinstance(described, list):
        return [_in_us(entry, unit) for entry in described]
    if not isinstance(described, dict):
        return described
    return {
        key: unit.of(value) if key in _BOUNDS else _in_us(value, unit)
        for key, value in described.items()
        if key not in ("default", "title")
    }
