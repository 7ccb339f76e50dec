"""Case files: templates, every kind of mistake, settings, keys without effect, the schema, and text of all kinds."""

import json
import os
import re
from datetime import timedelta
from pathlib import Path
from typing import Any

import pytest
from hypothesis import HealthCheck, example, given, settings
from hypothesis import strategies as st

from flangeway.cases import CASES, load_case, schema, write_template
from flangeway.cases.case_file import check_case, read_case
from flangeway.errors import InputError
from flangeway.records import GivenText
from flangeway.system.file_content import file_content
from flangeway.system.output_folder import refuse_unwritable
from flangeway.units import us_key

COARSE = {
    "wheelset": {"size_scale": 8.0, "mesh.order": 1, "track.support": "fixed", "patch_cells": 10},
    "hertz": {"size_mm": 1.0, "indentation_mm": 1.0},
    "torsion": {"size": 20.0},
    "crane-wheel": {"order": 1},
    "roller": {"order": 1, "crown_radius_mm": 20.0},
    "crossed-cylinders": {"order": 1},
    "spatial": {"tolerance": 0.1, "bodies.bar.order": 1, "bodies.wheel.order": 1},
    "rolling-patch": {"cells_along": 8, "cells_across": 8, "curve_points": 3},
    "two-bodies": {"bodies.cylinder.size_mm": 20.0, "bodies.2.size_mm": 20.0},
}


def file_of(folder, text, name="case.toml"):
    path = folder / name
    path.write_text(text, encoding="utf-8")
    return path


OF_FILES = (["rail"], ["wheel"], ["friction"], ["superelevation_mm"])
"""Inputs of a wheelset that are a value, or a table in its place, whose keys `flangeway cases` explains."""


@pytest.mark.parametrize("name", CASES)
def test_a_new_file_is_the_case_with_its_defaults_and_explains_every_key(tmp_path, name):
    """What `init` writes is read, checked, and has the values of the case without inputs (or of its example).

    It names each key of the kinds by default, set or as a comment, below a line with its meaning and its range.
    """
    case = load_case(file_of(tmp_path, write_template(CASES[name])))
    assert type(case) is CASES[name]
    check_case(case)
    without = CASES[name].from_values(CASES[name].example)
    assert case == without
    lines = write_template(CASES[name]).splitlines()
    assert max(map(len, lines)) <= 240  # the diameters of an axle
    for caption, rows in CASES[name].tables_of_inputs():
        if not rows:
            continue
        for key, _, allowed, meaning in rows:
            name = f"{caption}.{key}".replace("[]", "").removeprefix(".")
            tables = any(line.strip("# ") in (f"[[{name}]]", f"[{name}]", f"[{name}.NAME]") for line in lines)
            found = [n for n, line in enumerate(lines) if line.lstrip("# ").startswith(f"{key} =")]
            is_in_place = any(part.endswith(":") for part in caption.split()) or name.split(".")[-2:-1] in OF_FILES
            assert found or tables or is_in_place, key
            if not tables and not is_in_place:
                texts = [" ".join(line.strip("# ") for line in lines[max(n - 5, 0) : n]) for n in found]
                assert any(meaning.split()[0] in text and allowed.split()[0] in text for text in texts), key


PRESETS = {"roller", "crossed-cylinders"}  # of the same computation as crane-wheel


@pytest.mark.parametrize(
    "name", [pytest.param(name, marks=[pytest.mark.ci] if name in PRESETS else []) for name in CASES]
)
def test_every_case_runs_from_its_file(tmp_path, name):
    """Each case runs on a coarse mesh from its file, converges, and has its inputs in a summary of plain numbers."""
    run = read_case(file_of(tmp_path, write_template(CASES[name])), COARSE[name]).run()
    assert run.status.converged
    assert run.summary["status"]["converged"] is True
    assert run.summary["case"]["name"] == name
    assert '""' not in json.dumps({**run.summary, "case": {}}, allow_nan=False)  # what is not there is null


def test_files_are_found_beside_the_case_file(tmp_path, monkeypatch):
    """A relative path of an outline counts from the case file's folder, from wherever it is run."""
    (tmp_path / "cases" / "drawn").mkdir(parents=True)
    drawing = 'unit = "mm"\n[outer]\npoints = [[0.0, 0.0], [4.0, 0.0], [4.0, 3.0], [0.0, 3.0]]\n'
    file_of(tmp_path / "cases" / "drawn", drawing, "box.toml")
    path = file_of(tmp_path / "cases", 'case = "torsion"\nsection = "drawn/box.toml"\nsize = 1.0\n')
    monkeypatch.chdir(tmp_path)
    case = load_case("cases/case.toml")
    check_case(case, path)
    assert case.run().summary["area_mm2"] == pytest.approx(12.0)


def test_files_without_an_ending_replace_neither_kinds_nor_bundled_profiles(tmp_path):
    """A word names a kind, rail or wheel though the folder has a file of that name; with a folder it names the file."""
    for name in ("whole", "rim", "60E2", "S1002"):
        (tmp_path / name).write_text("no profile", encoding="utf-8")
    file = tmp_path / "case.toml"
    text = 'case = "wheelset"\ntrack.rail = "60E2"\nwheelset.wheel = "S1002"\nwheelset.section = "whole"\n'
    file.write_text(text, encoding="utf-8")
    assert read_case(file) == load_case("wheelset", rail="60E2", section="whole")
    file.write_text(text.replace('"60E2"', '"./60E2"'), encoding="utf-8")
    with pytest.raises(InputError, match="60E2"):
        check_case(read_case(file), str(file))


def test_lengths_of_the_axle_are_written_as_a_reader_would(tmp_path):
    """No number of a new file of a wheelset has more than eight digits behind the point."""
    assert not re.findall(r"\d\.\d{9,}", write_template(CASES["wheelset"]))


def test_settings_go_before_the_file(tmp_path):
    """A setting replaces the file's value, also inside tables, by number or by name."""
    path = file_of(tmp_path, write_template(CASES["two-bodies"]))
    given = {"thickness_mm": "3", "bodies.block.poisson": "0.25", "motions.1.push_N": "[0.0, -5.0]"}
    case = read_case(path, {key: GivenText(text) for key, text in given.items()})
    assert case.thickness_mm == 3.0
    assert [body.poisson for body in case.bodies] == [0.3, 0.25]
    assert case.motions[0].push_N == (0.0, -5.0)


def test_the_schema_has_every_key_with_its_range():
    """The JSON Schema of each case lists its inputs with descriptions and bounds, and refuses other keys."""
    by_name = {name: json.loads(json.dumps(schema(case))) for name, case in CASES.items()}
    for name, case in CASES.items():
        us = {unit.name for unit in map(us_key, case.model_fields) if unit}
        assert set(by_name[name]["properties"]) == {"flangeway", "case", *case.model_fields} | us
        assert by_name[name]["additionalProperties"] is False
        assert all("description" in value for value in by_name[name]["properties"].values())
    assert by_name["torsion"]["properties"]["order"]["maximum"] == 6
    assert by_name["hertz"]["properties"]["radius_mm"]["exclusiveMinimum"] == 0.0
    assert by_name["two-bodies"]["required"] == ["case", "bodies"]
    assert by_name["two-bodies"]["$defs"]["BodyTable"]["additionalProperties"] is False
    for found in by_name.values():
        references = {word for word in json.dumps(found).split('"') if word.startswith("#/$defs/")}
        assert {word.removeprefix("#/$defs/") for word in references} <= set(found["$defs"])


def test_every_unit_is_in_its_name():
    """Inputs that are lengths, forces, stresses or angles bear their unit; the rest has none."""
    without = {
        *("inclination", "tolerance", "growth", "slack", "penalty_factor", "size_scale", "size", "hold"),
        *("poisson", "lower_poisson", "upper_poisson", "position"),
        *("friction", "kinetic", "flange_friction", "upper_friction", "curve_end"),
        *("longitudinal_creepage", "lateral_creepage", "initial", "remaining", "rate"),
        *("moments", "torque"),  # of sections, in N times their unit
        *("points", "from", "line_to", "arc_to", "through", "centre", "radius"),  # of outlines, as in their files
    }
    units = (
        *("_mm", "_MPa", "_N", "_kN", "_rad", "_mrad", "_deg", "_in", "_m", "_t", "_km_h", "_MPa_mm", "_N_mm3", "_K"),
        *("_per_s", "_kNm", "_kNm_per_mrad", "_kg_m3", "_per_K", "_m_s2", "_N_mm", "_C"),
    )
    for case in CASES.values():
        for _, rows in case.tables_of_inputs():
            for key, _, allowed, _ in rows:
                if "a number" in allowed and "table" not in allowed:
                    assert key in without or key.endswith(units), key


PRESSED = write_template(CASES["two-bodies"]).replace("size_mm = 0.08", "size_mm = 1.0").replace("0.1, ", "1.0, ")
ROWS = [row for row in PRESSED.splitlines() if row and row[0] != "#" and not row.startswith(("flangeway", "case"))]
WORDS = st.sampled_from((
    "0", "-1", "1", "3", "1e300", "nan", "inf", "true", "[]", "{}", '""', '"top"', '"punch"', '"c"', "[0, 0]", "[[]]",
    "[1e300, 0]", "[[0, 0], [5, 0], [5, 5]]", "{ width_mm = 10, height_mm = 1e-9 }", '"x.msh"', "1979-05-27",
    "[[0, 0]]", f"0x{'f' * 5000}",
))  # fmt: skip
CHANGES = st.tuples(st.integers(0, len(ROWS) - 1), st.sampled_from(["value", "drop", "double", "swap"]), WORDS)


@settings(deadline=timedelta(minutes=5), suppress_health_check=list(HealthCheck))
@example(changes=[(ROWS.index('secondary_edges = "rim"'), "value", "[]")])  # a list of nothing
@example(changes=[(ROWS.index("size_mm = 5.0"), "value", f"0x{'f' * 5000}")])  # Python writes no such number
@given(changes=st.lists(CHANGES, min_size=1, max_size=3))
def test_a_damaged_case_is_sound_or_refused_when_checked(tmp_path, changes):
    """Lines of a case dropped, doubled, moved or with other values: it is checked through, or refused by its name."""
    rows = list(ROWS)
    for number, kind, word in changes:
        row = number % len(rows)
        key = rows[row].partition("=")[0]
        changed = {
            "value": [f"{key}= {word}"],
            "drop": [],
            "double": [rows[row]] * 2,
            "swap": rows[row : row + 2][::-1],
        }
        rows[row : row + (2 if kind == "swap" else 1)] = changed[kind]
    path = file_of(tmp_path, "\n".join(['case = "two-bodies"', *rows]))
    case, refused = None, None
    try:
        case = load_case(path)
        check_case(case, path)
    except InputError as error:
        refused = error
    assert case.bodies if refused is None else str(path) in refused.given


@pytest.mark.parametrize("name", ["shift.toml", "wheel-life.toml"])
def test_files_of_other_commands_name_their_command(name):
    """A file of a campaign or of wear is refused with the command that computes it."""
    command = {"shift.toml": "campaign", "wheel-life.toml": "damage"}[name]
    file = Path(__file__).parents[2] / "examples" / name
    with pytest.raises(InputError) as refused:
        load_case(file)
    assert f"`flangeway {command} {file}`" in refused.value.advice


TWO_BLOCKS: dict[str, Any] = {
    "bodies": [
        {"name": "block", "rectangle": {"width_mm": 2.0, "height_mm": 2.0, "centre_mm": [0.0, 1.0]}, "size_mm": 1.0},
        {"name": "base", "rectangle": {"width_mm": 4.0, "height_mm": 2.0, "centre_mm": [0.0, -1.0]}, "size_mm": 1.0},
    ],
    "supports": [{"body": "block", "edges": "top"}, {"body": "base", "edges": "bottom"}],
    "motions": [{"body": "block", "shift_mm": [0.0, -0.001]}],
}


def contact(**values: object) -> dict[str, Any]:
    sides = {"secondary": "block", "secondary_edges": "bottom", "primary": "base", "primary_edges": "top"}
    return TWO_BLOCKS | {"contacts": [sides | values]}


@pytest.mark.parametrize(
    ("choice", "kind", "key", "value"),
    [
        ("enforcement", "multiplier", "penalty_MPa_mm", 1e5),
        ("enforcement", "penalty", "penetration_mm", 1e-3),
        ("pairing", "segment-to-segment", "slack", 0.05),
        ("pairing", "node-to-segment", "weighting", "dual"),
    ],
)
def test_a_key_without_effect_is_refused(choice: str, kind: str, key: str, value: object) -> None:
    """The message names the table's place, the key and the kinds that have it."""
    with pytest.raises(InputError, match=rf"contacts\[1\]\.{choice}\.{key}: only .* ha(s|ve) one"):
        load_case("two-bodies", **contact(**{choice: {"kind": kind, key: value}}))


def test_an_input_of_a_kind_beside_it_is_told_its_place() -> None:
    """The message names the path of an input that was written one table too high."""
    with pytest.raises(InputError, match=r"did you mean contacts\[1\]\.enforcement\.penalty_MPa_mm\?"):
        load_case("two-bodies", **contact(enforcement="penalty", penalty_MPa_mm=10.0))


def test_a_table_that_the_file_lacks(tmp_path: Path) -> None:
    """`--set steps.number=2` makes the table; an unknown key in it is refused as in a file."""
    file = tmp_path / "case.toml"
    blocks = "".join(
        f'[[bodies]]\nname = "{name}"\nsize_mm = 1\nrectangle = {{width_mm = 2.0, height_mm = 2.0, centre_mm = {at}}}\n'
        for name, at in (("block", [0.0, 1.0]), ("base", [0.0, -1.0]))
    )
    file.write_text(f'case = "two-bodies"\n{blocks}', encoding="utf-8")
    assert read_case(file, {"steps.number": 2}).model_dump()["steps"]["number"] == 2
    with pytest.raises(InputError, match="nmber"):
        read_case(file, {"steps.nmber": 2})


def test_the_root_is_no_folder_for_results() -> None:
    """Neither `/` nor a path that leads there is taken."""
    for folder in (Path("/"), Path("/tmp/..")):
        with pytest.raises(InputError, match="root"):
            refuse_unwritable(folder)


@pytest.mark.skipif(not hasattr(os, "mkfifo"), reason="named pipes are of POSIX")
def test_a_pipe_is_refused_at_once(tmp_path: Path) -> None:
    """A named pipe that nobody writes into is neither a case file nor a profile."""
    pipe = tmp_path / "case.toml"
    os.mkfifo(pipe)
    with pytest.raises(InputError, match="pipe"):
        read_case(pipe)
    with pytest.raises(InputError, match="pipe"):
        file_content(pipe, "a profile")
