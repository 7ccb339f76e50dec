"""Trees of inputs: their TOML, their wrong leaves, the endings of their paths, and their JSON schema."""

import json
from functools import cache
from pathlib import Path
from typing import Any, get_args, get_origin

import annotated_types as at
import pytest
from hypothesis import HealthCheck, assume, given, settings
from hypothesis import strategies as st
from jsonschema import Draft202012Validator
from pydantic.fields import FieldInfo

from flangeway.cases import Wheelset, schema, write_template
from flangeway.cases.case_file import CASE_FILES, read_case, toml_text, write_case_file
from flangeway.cases.rigid_run import GeometryCase, read_geometry_case
from flangeway.errors import InputError
from flangeway.records import (
    TAG,
    Record,
    alternatives,
    flattened,
    key_text,
    kind_of,
    path_by_ending,
    paths_of,
    records_in,
    with_settings,
)
from flangeway.system.file_content import toml_data

NAMES = {"rail": ("60E1", "136RE", "54E1"), "wheel": ("S1002", "AAR-1B", "heavy-haul")}
TEXTS = st.text(st.characters(codec="utf-8", exclude_categories=("Cs", "Cc")), max_size=12)
RECORDS: dict[str, type[Wheelset] | type[GeometryCase]] = {"wheelset": Wheelset, "geometry": GeometryCase}
slow = settings(suppress_health_check=[HealthCheck.function_scoped_fixture, HealthCheck.filter_too_much])


def limits(annotation: Any, metadata: Any) -> dict[str, float]:
    """Limits of a number, from the field and from the types of its annotation."""
    found = [*metadata]
    if hasattr(annotation, "__metadata__"):
        found += annotation.__metadata__
    for member in get_args(annotation):
        found += getattr(member, "__metadata__", ())
    names = {at.Gt: "gt", at.Ge: "ge", at.Lt: "lt", at.Le: "le"}
    return {names[type(limit)]: getattr(limit, names[type(limit)]) for limit in found if type(limit) in names}


def numbers(bounds: dict[str, float]) -> st.SearchStrategy[float]:
    low, high = bounds.get("gt", bounds.get("ge", -1e3)), bounds.get("lt", bounds.get("le", 1e4))
    return st.floats(low, high, exclude_min="gt" in bounds, exclude_max="lt" in bounds).map(lambda x: x + 0.0)


def value_of(key: str, annotation: Any, metadata: Any = ()) -> st.SearchStrategy[Any]:
    """A value that the type of an input allows, as TOML has it."""
    choices: list[st.SearchStrategy[Any]] = []
    bounds = limits(annotation, metadata)
    for kind in alternatives(annotation):
        if get_origin(kind) is not None and not get_args(kind):
            continue
        if kind is float:
            choices.append(numbers(bounds))
        elif kind is int:
            choices.append(st.integers(int(bounds.get("ge", 1)), int(bounds.get("le", 60))))
        elif kind is bool:
            choices.append(st.booleans())
        elif kind is str:
            choices.append(st.sampled_from(NAMES[key]) if key in NAMES else TEXTS)
        elif get_origin(kind) is tuple and get_args(kind)[-1] is ...:
            continue  # diameters of an axle, which hold together
        elif get_origin(kind) is tuple:
            choices.append(st.tuples(*(value_of(key, member) for member in get_args(kind))).map(list))
        elif isinstance(kind, type) and issubclass(kind, Record):
            choices.append(tree_of(kind))
        elif str(get_origin(kind)) == "typing.Literal":
            choices.append(st.sampled_from(get_args(kind)))
    return st.one_of(choices) if choices else st.nothing()


@cache
def tree_of(record: type[Record]) -> st.SearchStrategy[dict[str, Any]]:
    """Some inputs of a record, those needed among them, and a kind where it has one."""
    needed, optional = {}, {}
    for key, field in record.model_fields.items():
        strategy = value_of(key, field.annotation, field.metadata)
        if key == TAG:
            needed[key] = st.just(kind_of(record))
        elif field.is_required():
            needed[key] = strategy
        elif not strategy.is_empty:
            optional[key] = strategy
    return st.fixed_dictionaries(needed, optional=optional)


@pytest.mark.parametrize("name", RECORDS)
@slow
@given(data=st.data())
def test_toml_of_a_record_is_the_record(tmp_path: Path, name: str, data: st.DataObject) -> None:
    """TOML to record to TOML to record is the identity, whatever of the inputs is written."""
    record, values = RECORDS[name], data.draw(tree_of(RECORDS[name]))
    first = tmp_path / "first.toml"
    first.write_text(toml_text({"case": name, **values}), encoding="utf-8")

    def read(file: Path) -> Any:
        return read_geometry_case(file, {})[0] if record is GeometryCase else read_case(file)

    try:
        case = read(first)
    except InputError:  # inputs that exclude each other
        assume(False)
    second = tmp_path / "second.toml"
    second.write_text(write_case_file(case), encoding="utf-8")
    assert read(second) == case
    assert write_case_file(read(second)) == write_case_file(case)


def leaves_of(
    record: type[Record], above: tuple[str, ...] = (), tags: tuple[Any, ...] = ()
) -> dict[tuple[str, ...], tuple[FieldInfo, tuple[Any, ...]]]:
    """Fields of the inputs that are no tables, by their paths, and the kinds with their paths that have them."""
    leaves: dict[tuple[str, ...], tuple[FieldInfo, tuple[Any, ...]]] = {}
    tags = (*tags, ((*above, TAG), kind_of(record))) if kind_of(record) else tags
    for key, field in record.model_fields.items():
        kinds = records_in(field.annotation)
        if not kinds:
            leaves[(*above, key)] = field, tags
        for kind in kinds:
            leaves = {**leaves_of(kind, (*above, key), tags), **leaves}
    return leaves


LEAVES = {path: leaf for path, leaf in leaves_of(Wheelset).items() if path[-1] != TAG}
STRANGE = st.sampled_from([True, "wide", [1.0, "x"], {"no": 1.0}, [[]], 1979.5])


def allows(value: Any, annotation: Any, metadata: Any) -> bool:
    """Whether a value of another type, or beyond a limit, is none the less allowed."""
    kinds = alternatives(annotation)
    if isinstance(value, bool) or not isinstance(value, int | float):
        return (isinstance(value, bool) and bool in kinds) or (isinstance(value, str) and str in kinds)
    bounds = limits(annotation, metadata)
    inside = value > bounds.get("gt", -1e99) and value >= bounds.get("ge", -1e99)
    inside = inside and value < bounds.get("lt", 1e99) and value <= bounds.get("le", 1e99)
    return inside and (float in kinds or (int in kinds and float(value).is_integer()))


def nested(path: tuple[str, ...], value: Any) -> dict[str, Any]:
    """Tables with one value, and the kinds that have it."""
    tables: dict[str, Any] = {}
    for where, content in ((path, value), *(LEAVES[path][1] if path in LEAVES else ())):
        inside = tables
        for key in where[:-1]:
            inside = inside.setdefault(key, {})
        inside[where[-1]] = content
    return tables


@slow
@given(path=st.sampled_from(sorted(LEAVES)), data=st.data())
def test_a_wrong_leaf_is_reported_with_its_path_and_line(
    tmp_path: Path, path: tuple[str, ...], data: st.DataObject
) -> None:
    """A value of another type or out of range is refused, by the reader and by the schema; the line is the input's."""
    field, _ = LEAVES[path]
    bounds = limits(field.annotation, field.metadata)
    beyond = [bounds["le"] * 2 + 1.0] if "le" in bounds else []
    beyond += [bounds[name] - 1.0 for name in ("ge", "gt") if name in bounds]
    value = data.draw(st.one_of(STRANGE, *map(st.just, beyond)))
    assume(not allows(value, field.annotation, field.metadata))
    refused(tmp_path, path, nested(path, value))


@slow
@given(path=st.sampled_from(sorted(LEAVES)), word=st.sampled_from(["x", "gage", "frictoin", "kinds"]))
def test_an_unknown_key_is_reported_with_its_path_and_line(tmp_path: Path, path: tuple[str, ...], word: str) -> None:
    """A key that no table has is refused, beside those that it has."""
    wrong = (*path[:-1], word)
    values = nested(path, None)
    inside: Any = values
    for key in path[:-1]:
        inside = inside[key]
    inside[word] = inside.pop(path[-1])
    inside[word] = 1.0
    refused(tmp_path, wrong, values)


KINDS = sorted({path[:-1] for _, tags in LEAVES.values() for path, _ in tags})


@pytest.mark.parametrize("path", KINDS, ids=key_text)
def test_a_wrong_kind_is_reported_with_its_path_and_line(tmp_path: Path, path: tuple[str, ...]) -> None:
    """A kind that there is not is refused, by its name alone and in a table."""
    beside = {"load": {"curve": {"radius_m": 300.0, "speed_km_h": 60.0}}} if path[:2] == ("load", "curve") else {}
    for wrong, value in (((*path, TAG), {TAG: "rock"}), (path, "rock")):
        values = nested(path, value)
        if beside:
            values["load"]["curve"] |= beside["load"]["curve"]
        refused(tmp_path, wrong, values)


def refused(folder: Path, path: tuple[str, ...], values: dict[str, Any]) -> None:
    """Check that a file is refused with path and line of an input, and by the schema."""
    file = folder / "wrong.toml"
    text = toml_text({"case": "wheelset", **values})
    file.write_text(text, encoding="utf-8")
    with pytest.raises(InputError) as reason:
        read_case(file)
    said, name = reason.value.given, key_text(path)
    unknown = f"{path[-1]!r}{f' in {key_text(path[:-1])}' if path[:-1] else ''}"
    lines = [
        int(each.partition(":")[0]) for each in said.split(f"{file}, line ")[1:] if name in each or unknown in each
    ]
    assert lines, said
    assert any(path[-1] in text.splitlines()[line - 1] for line in lines), said
    assert not validator().is_valid(toml_data(text, ""))


@cache
def validator() -> Draft202012Validator:
    described = json.loads(json.dumps(schema(Wheelset)))
    Draft202012Validator.check_schema(described)
    return Draft202012Validator(described)


def test_every_ending_of_every_path_means_the_path() -> None:
    """An ending that is that of one path alone means it in a setting; of several the one of the fewest tables."""
    paths = list(dict.fromkeys(paths_of(Wheelset)))
    for path in paths:
        for start in range(len(path)):
            ending = path[start:]
            if ending[0] in Wheelset.model_fields and start:
                continue  # begins at the top
            same = [other for other in paths if other[-len(ending) :] == ending]
            fewest = [other for other in same if len(other) == min(map(len, same))]
            if len(fewest) > 1:
                with pytest.raises(InputError, match="write more of the path"):
                    path_by_ending(Wheelset, ".".join(ending))
            else:
                assert path_by_ending(Wheelset, ".".join(ending)) == [*fewest[0]], ending
                written = flattened(with_settings(Wheelset, {}, {".".join(ending): 1.0}))
                assert written[".".join(fewest[0])] == 1.0, ending


def test_the_schema_accepts_every_bundled_file_and_template() -> None:
    """The JSON schema validates the bundled case files of a wheelset and the file to begin with, in both units."""
    texts = [file.read_text(encoding="utf-8") for file in CASE_FILES.values()]
    texts = [text for text in texts if 'case = "wheelset"' in text]
    assert len(texts) >= 2
    for text in (*texts, write_template(Wheelset), write_template(Wheelset, "us")):
        assert not [*map(str, validator().iter_errors(toml_data(text, "")))]


@slow
@given(values=tree_of(Wheelset))
def test_the_schema_accepts_what_the_record_accepts(values: dict[str, Any]) -> None:
    """No input that the record takes is marked as wrong in an editor."""
    try:
        Wheelset.from_values(values)
    except InputError:
        assume(False)
    assert not [*map(str, validator().iter_errors({"case": "wheelset", **toml_data(toml_text(values), "")}))]
