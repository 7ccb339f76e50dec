"""Random trees of bodies: files and records say the same, wrong leaves are named with their line, and schemas agree."""

import jsonschema
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from flangeway.cases.bodies.bodies_run import TwoBodiesCase
from flangeway.cases.case_file import (
    CASE_FILES,
    CASES,
    find_case,
    read_case,
    schema,
    toml_value,
    write_case_file,
    write_template,
)
from flangeway.errors import InputError
from flangeway.records import key_text, leaves
from flangeway.system.file_content import toml_data

NUMBERS = st.floats(-1e3, 1e3).map(lambda number: number + 0.0)
POSITIVE = st.floats(1e-3, 1e6)
PAIRS = st.tuples(NUMBERS, NUMBERS).map(list)
NAMES = st.sampled_from(["roller", "block", "ring"])
EDGES = NAMES | st.lists(NAMES, min_size=1, max_size=2)


def tables(needed, **others):
    """Tables with all needed keys and some of the others."""
    return st.fixed_dictionaries(needed, optional=others)


def kind(name, needed=None, **others):
    return tables({"kind": st.just(name), **(needed or {})}, **others)


MATERIAL = {"young_MPa": POSITIVE, "poisson": st.floats(-0.9, 0.49), "density_kg_m3": POSITIVE}
SHAPE = st.one_of(
    st.fixed_dictionaries({"rectangle": tables({"width_mm": POSITIVE, "height_mm": POSITIVE}, centre_mm=PAIRS)}),
    st.fixed_dictionaries({"disc": tables({"radius_mm": POSITIVE}, half=st.sampled_from(["upper", "lower"]))}),
)
FINE = tables({"size_mm": POSITIVE, "at_mm": st.lists(PAIRS, min_size=1, max_size=3)}, growth=st.floats(0.01, 1.0))
OF_FILE = tables(
    {"file": st.just("mesh.msh")},
    unit=st.sampled_from(["cm", "in"]),
    cells=EDGES,
    materials=st.dictionaries(NAMES, tables({}, **MATERIAL), max_size=2),
)
REST = tables(
    {"name": NAMES},
    **MATERIAL,
    method=st.sampled_from(["fem", "vem", "vem-triangles"]),
    order=st.sampled_from([1, 2]),
    size_mm=POSITIVE,
    shift_mm=PAIRS,
    fine=st.lists(FINE, max_size=2),
)


def both(one, other):
    """Tables with the keys of two."""
    return st.builds(lambda left, right: left | right, one, other)


DRAWN = both(SHAPE, REST)
BODY = DRAWN | both(OF_FILE, REST)
LINE = {"at_x_mm": NUMBERS, "box_mm": st.lists(NUMBERS, min_size=4, max_size=4)}
ALONG = tables({"body": NAMES, "edges": EDGES}, **LINE)
AT = tables({"body": NAMES, "point_mm": PAIRS})
CELLS = tables({"body": NAMES}, cells=NAMES)
LOAD = st.one_of(
    both(ALONG, st.one_of(tables({"pressure_MPa": NUMBERS}), tables({"traction_MPa": PAIRS}))),
    both(ALONG | AT, tables({"force_N": PAIRS})),
    both(CELLS, tables({"body_force_N_mm3": PAIRS}) | tables({"temperature_K": NUMBERS})),
    tables({"body": NAMES, "gravity_m_s2": PAIRS}),
)
SUPPORT = both(ALONG | AT, tables({}, hold=st.sampled_from(["x", "y", "xy"]), x_mm=NUMBERS))
SPRING = both(ALONG, tables({}, x_MPa_mm=POSITIVE)) | both(AT, tables({}, y_N_mm=POSITIVE))
MOTION = tables({"body": NAMES}, leg=st.integers(1, 3), shift_mm=PAIRS) | tables({"body": NAMES, "push_N": PAIRS})
PENALTY = st.sampled_from(["penalty_MPa_mm", "nodal_penalty_N_per_mm"]).flatmap(
    lambda key: st.fixed_dictionaries({}, optional={key: POSITIVE})
)
ENFORCEMENT = st.one_of(
    st.sampled_from(["multiplier", "penalty", "augmented-lagrange"]),
    kind("multiplier"),
    st.builds(lambda penalty: {"kind": "penalty"} | penalty, PENALTY),
    st.builds(lambda penalty, rest: rest | penalty, PENALTY, kind("augmented-lagrange", penetration_mm=POSITIVE)),
    kind("barrier", {"barrier_N_per_mm": POSITIVE, "reach_mm": POSITIVE}),
)
PAIRING = st.one_of(
    st.sampled_from(["segment-to-segment", "node-to-segment", "node-to-node"]),
    kind("segment-to-segment", weighting=st.sampled_from(["standard", "dual"])),
    kind("node-to-segment", slack=st.floats(1e-6, 1e-3)),
)
CONTACT = tables(
    {"secondary": NAMES, "primary": NAMES},
    secondary_edges=EDGES,
    friction=st.floats(0.0, 1.0),
    curved=st.booleans(),
    pairing=PAIRING,
    enforcement=ENFORCEMENT,
)


def trees(body):
    return tables(
        {"bodies": st.lists(body, min_size=1, max_size=3)},
        thickness_mm=POSITIVE,
        hypothesis=st.sampled_from(["plane-strain", "plane-stress", "axisymmetric"]),
        supports=st.lists(SUPPORT, max_size=2),
        loads=st.lists(LOAD, max_size=2),
        springs=st.lists(SPRING, max_size=1),
        motions=st.lists(MOTION, max_size=2),
        contacts=st.lists(CONTACT, max_size=2),
        steps=tables({}, number=st.integers(1, 1000)),
    )


SCHEMA = schema(TwoBodiesCase)
VALIDATOR = jsonschema.Draft202012Validator(SCHEMA)


@settings(max_examples=40, deadline=None)
@given(trees(BODY))
def test_files_and_records_say_the_same(values):
    """Values, the record, its file, and the record of the file: both records are equal, and so are both files."""
    case = TwoBodiesCase.from_values(values)
    text = write_case_file(case)
    data = toml_data(text, "")
    again = TwoBodiesCase.from_values({key: data[key] for key in data if key not in ("flangeway", "case")})
    assert again == case
    assert write_case_file(again) == text
    assert not [*VALIDATOR.iter_errors(data)]
    assert not [*VALIDATOR.iter_errors({"case": "two-bodies", **values})]


def changed(values, key, value):
    """Values with another one at a path."""
    if not key:
        return value
    inner = changed(values[key[0]], key[1:], value)
    if isinstance(values, dict):
        return values | {key[0]: inner}
    return [inner if number == key[0] else entry for number, entry in enumerate(values)]


def written(values):
    """Lines of a case file, a key each, and the line of each key of the case and of its lists of tables, from 1."""
    lines, numbers = ['case = "two-bodies"'], {}
    of_lists = {key: rows for key, rows in values.items() if isinstance(rows, list)}
    for key in values.keys() - of_lists.keys():
        lines.append(f"{key} = {toml_value(values[key])}")
        numbers[key,] = len(lines)
    for key, rows in of_lists.items():
        for number, row in enumerate(rows):
            lines.append(f"[[{key}]]")
            for name, value in row.items():
                lines.append(f"{name} = {toml_value(value)}")
                numbers[key, number, name] = len(lines)
    return "\n".join(lines), numbers


@settings(max_examples=40, deadline=None)
@given(trees(DRAWN), st.data())
def test_a_wrong_leaf_is_named_with_its_line_and_refused_by_the_schema(tmp_path_factory, values, data):
    """A truth value in place of a number or a name, a number in place of a truth value: key and line are named."""
    key, value = data.draw(st.sampled_from([*leaves(values)]))
    wrong = changed(values, key, 7 if isinstance(value, bool) else True)
    assert [*VALIDATOR.iter_errors({"case": "two-bodies", **wrong})]
    text, lines = written(wrong)
    file = tmp_path_factory.mktemp("tree") / "case.toml"
    file.write_text(text, encoding="utf-8")
    with pytest.raises(InputError) as refused:
        read_case(file)
    assert f"line {lines.get(key[:3]) or lines[key[:1]]}: " in refused.value.given
    *_, name = (item for item in key if isinstance(item, str))
    assert f"{key_text(key[: key.index(name) + 1])}" in refused.value.given
    assert name in refused.value.advice or name in refused.value.allowed


PLATE = {"name": "plate", "rectangle": {"width_mm": 2.0, "height_mm": 1.0}}
ON = {"body": "plate", "edges": "top"}


@pytest.mark.parametrize(
    ("values", "path", "words"),
    [
        ({"loads": [{**ON, "pressure_MPa": 1.0, "force_N": [0.0, 1.0]}]}, "loads[1]: ", ("force_N", "pressure_MPa")),
        ({"loads": [ON]}, "loads[1]", ("pressure_MPa", "gravity_m_s2")),
        ({"loads": [{"body": "plate", "point_mm": [0.0, 0.0], "pressure_MPa": 1.0}]}, "loads[1]: ", ("point_mm",)),
        ({"loads": [{**ON, "gravity_m_s2": [0.0, -9.81]}]}, "loads[1]: ", ("edges", "gravity_m_s2")),
        ({"loads": [{**ON, "cells": "a", "traction_MPa": [0.0, 1.0]}]}, "loads[1]: ", ("cells", "traction_MPa")),
        ({"supports": [{"body": "plate"}]}, "supports[1]: ", ("edges", "box_mm")),
        ({"supports": [{**ON, "point_mm": [0.0, 0.0]}]}, "supports[1]: ", ("edges", "point_mm")),
        ({"springs": [{**ON, "x_N_mm": 1.0}]}, "springs[1]: ", ("x_N_mm", "x_MPa_mm")),
        (
            {"motions": [{"body": "plate", "push_N": [0.0, 1.0], "shift_mm": [0.0, 1.0]}]},
            "motions[1]: ",
            ("push_N", "shift_mm"),
        ),
        ({"bodies": [{"name": "plate"}]}, "bodies[1]: ", ("rectangle", "disc", "outline", "file")),
        ({"bodies": [PLATE | {"disc": {"radius_mm": 1.0}}]}, "bodies[1]: ", ("rectangle", "disc")),
        ({"bodies": [PLATE | {"unit": "in"}]}, "bodies[1]: ", ("unit", "file")),
        ({"bodies": [PLATE | {"layers": ["A"]}]}, "bodies[1]: ", ("layers", "file")),
        ({"bodies": [PLATE | {"fine": [{"size_mm": 0.1}]}]}, "bodies[1].fine[1]: ", ("edges", "at_mm")),
        ({"bodies": []}, "bodies", ()),
    ],
)
def test_what_excludes_or_lacks_each_other_is_refused(values, path, words):
    """Two loads in one table, none, one in the wrong place, a shape too many: reader and schema refuse them."""
    case = {"bodies": [PLATE]} | values
    with pytest.raises(InputError) as refused:
        TwoBodiesCase.from_values(case)
    assert path in refused.value.given
    assert all(word in str(refused.value) for word in words)
    assert [*VALIDATOR.iter_errors({"case": "two-bodies", **case})]


BODIES = sorted(name for name in CASE_FILES if find_case(name).name == "two-bodies")


@pytest.mark.parametrize("name", BODIES)
def test_the_schema_has_the_bundled_files_and_no_other_keys(name):
    """The schema validates every bundled file, and refuses it with an unknown key in any of its tables."""
    file = toml_data(CASE_FILES[name].read_text(encoding="utf-8"), "")
    assert not [*VALIDATOR.iter_errors(file)]
    known = {key[:-1] for key, _ in leaves(file) if isinstance(key[-1], str) and "outline" not in key}
    for table in known:
        inner = file
        for item in table:
            inner = inner[item]
        assert [*VALIDATOR.iter_errors(changed(file, table, {**inner, "unknown": 1}))], key_text(table)


@pytest.mark.parametrize("name", ["two-bodies", "hertz"])
def test_schemas_have_the_files_to_begin_with(name):
    """The schema of a case validates what `flangeway init` writes, in US units too."""
    validator = jsonschema.Draft202012Validator(schema(CASES[name]))
    for units in ("metric", "us"):
        assert not [*validator.iter_errors(toml_data(write_template(CASES[name], units), ""))]
