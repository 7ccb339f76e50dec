"""Case files to begin with: every key with its meaning, unit, range and default; and the JSON Schema of all cases."""

import json
import math
import os
import textwrap
from collections.abc import Mapping
from typing import Any

from pydantic.fields import FieldInfo

from flangeway.cases.case import RunnableCase, Table, allowed, described_by, table_in
from flangeway.cases.case_file import CASES, FILE_KEYS, FORMAT
from flangeway.units import Units, UsUnit, in_us_units, us_key

WIDTH = 110


def write_template(case: type[RunnableCase], units: Units = "metric") -> str:
    """Return the text of a case file.

    Keys that most users change are set, the others are comments with their defaults: the file computes the same as
    the case without inputs, up to round-off where its keys have US units.
    """
    lines = [
        f"# {case.title}.",
        "#",
        f"# Compute it with `flangeway run` and this file's name. `flangeway cases {case.name}` explains the keys;",
        "# lines that start with # are comments: remove the # to set a key.",
        "",
        f"flangeway = {FORMAT}  # format of this file",
        f'case = "{case.name}"',
    ]
    plain = {key: field for key, field in case.model_fields.items() if table_in(field.annotation) is None}
    for key, field in plain.items():
        active = key in case.essential or key in case.example
        value = case.example.get(key, _default(field))
        if key == "units" and units == "us":
            value, active = units, True
        lines += ["", *_entry(key, field, value, units, active=active)]
    for key, field in case.model_fields.items():
        table = table_in(field.annotation)
        if table is not None:
            lines += _tables(key, field, table, case.example.get(key), units)
    return "\n".join(lines) + "\n"


def write_case_file(case: RunnableCase) -> str:
    """Return the text of a case file in the current folder with the inputs of a case that are not the defaults."""
    lines = [f"# {case.title}.", "", f"flangeway = {FORMAT}", f'case = "{case.name}"']
    tables: list[str] = []
    for key, value in case.model_dump(exclude_defaults=True).items():
        if table_in(type(case).model_fields[key].annotation) is None:
            lines.append(f"{key} = {toml_value(value)}")
            continue
        for item in value if isinstance(value, list) else [value]:
            tables += ["", f"[[{key}]]" if isinstance(value, list) else f"[{key}]"]
            for name, entry in item.items():
                seen = os.path.relpath(entry) if name in FILE_KEYS else entry
                tables.append(f"{name} = {toml_value(seen)}")
    return "\n".join([*lines, *tables]) + "\n"


def _tables(key: str, field: FieldInfo, table: type[Table], example: Any, units: Units) -> list[str]:
    """Tables of one key: those of the example, or one as a comment."""
    several = isinstance(_default(field), list) or isinstance(example, list)
    header = f"[[{key}]]" if several else f"[{key}]"
    items = example if isinstance(example, list) else [example] if example else []
    first, comment = (items[0], "") if items else ({}, "#")
    lines = ["", "", f"# {field.description}.", f"{comment} {header}".strip()]
    for name, entry in table.model_fields.items():
        lines += [comment, *_entry(name, entry, first.get(name, _default(entry)), units, active=name in first)]
    for item in items[1:]:
        lines += ["", header, *(_line(name, value, units) for name, value in item.items())]
    return lines


def _entry(key: str, field: FieldInfo, value: Any, units: Units, *, active: bool) -> list[str]:
    """Comment and line of a key."""
    unit = us_key(key) if units == "us" else None
    meaning = in_us_units(field.description or "") if units == "us" else field.description
    lines = textwrap.wrap(
        f"{meaning} ({allowed(field, unit)})",
        WIDTH,
        initial_indent="# ",
        subsequent_indent="# ",
        break_long_words=False,
        break_on_hyphens=False,
    )
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


def _default(field: FieldInfo) -> Any:
    return None if field.is_required() else field.get_default(call_default_factory=True)


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
    if isinstance(value, Table):
        value = value.model_dump(exclude_defaults=True)
    if isinstance(value, Mapping):
        return "{ " + ", ".join(f"{key} = {toml_value(entry)}" for key, entry in value.items()) + " }"
    return "[" + ", ".join(toml_value(entry) for entry in value) + "]"


def schema() -> dict[str, Any]:
    """Return the JSON Schema of case files, with the keys, units, ranges and meanings of all cases.

    Editors use it for completion and to mark mistakes, as those with Taplo where the first line of a file is
    ``#:schema flangeway.schema.json``.
    """
    choices: list[dict[str, Any]] = []
    definitions: dict[str, Any] = {}
    for name, case in CASES.items():
        described = _with_sentences(case.model_json_schema())
        definitions |= described.pop("$defs", {})
        _add_us_keys(described)
        choices.append(
            {
                "title": case.title,
                "type": "object",
                "properties": {
                    "flangeway": {"const": FORMAT, "description": "format of the file; may be left out"},
                    "case": {"const": name, "description": case.title},
                    **described["properties"],
                },
                "required": ["case", *described.get("required", [])],
                **{key: described[key] for key in ("allOf",) if key in described},
                "additionalProperties": False,
            }
        )
    for definition in definitions.values():
        _add_us_keys(definition)
    return {
        "$schema": "https://json-schema.org/draft/2020-12/schema",
        "title": "Case file of flangeway",
        "oneOf": choices,
        "$defs": definitions,
    }


def _with_sentences(described: Any) -> Any:
    """Return a description of inputs with its texts, also those of several lines, as sentences, see `described_by`."""
    if isinstance(described, list):
        return [*map(_with_sentences, described)]
    if not isinstance(described, dict):
        return described
    return {
        key: described_by(value) if key == "description" and isinstance(value, str) else _with_sentences(value)
        for key, value in described.items()
    }


_BOUNDS = ("minimum", "maximum", "exclusiveMinimum", "exclusiveMaximum")


def _add_us_keys(table: dict[str, Any]) -> None:
    """Add the keys with US units to the description of a table, of which each or the metric one is needed."""
    units = {key: unit for key in table.get("properties", {}) if (unit := us_key(key))}
    for key, unit in units.items():
        table["properties"].setdefault(unit.name, _in_us(table["properties"][key], unit))
    needed = [key for key in table.get("required", []) if key in units]
    if needed:
        table["required"] = [key for key in table["required"] if key not in units]
        table["allOf"] = [{"anyOf": [{"required": [name]} for name in (key, units[key].name)]} for key in needed]


def _in_us(described: Any, unit: UsUnit) -> Any:
    """Return the description of an input with its limits in a US unit, and without its default."""
    if isinstance(described, list):
        return [_in_us(entry, unit) for entry in described]
    if not isinstance(described, dict):
        return described
    return {
        key: unit.of(value) if key in _BOUNDS else in_us_units(value) if key == "description" else _in_us(value, unit)
        for key, value in described.items()
        if key not in ("default", "title")
    }
