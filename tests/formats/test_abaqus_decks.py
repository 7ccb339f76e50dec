"""Parameters of Abaqus decks that change the answer were ignored."""

import pytest

from flangeway.cases import load_case
from flangeway.errors import InputError
from flangeway.formats import read_mesh

MESH = """*NODE
1, 0., 0.
2, 2., 0.
3, 2., 1.
4, 0., 1.
11, 0., 1.
12, 2., 1.
13, 2., 2.
14, 0., 2.
*ELEMENT, TYPE=CPE4, ELSET=LOWER
1, 1, 2, 3, 4
*ELEMENT, TYPE=CPE4, ELSET=UPPER
2, 11, 12, 13, 14
*NSET, NSET=BASE
1, 2
*NSET, NSET=LID
13, 14
*SURFACE, NAME=MASTER
LOWER, S3
*SURFACE, NAME=SLAVE
UPPER, S1
"""
REST = """*SOLID SECTION, ELSET=LOWER, MATERIAL=STEEL
*SOLID SECTION, ELSET=UPPER, MATERIAL=STEEL
*MATERIAL, NAME=STEEL
*ELASTIC
210000., 0.3
*SURFACE INTERACTION, NAME=SOFT{pad}
*SURFACE BEHAVIOR, {behaviour}
1e5, {clearance}
*CONTACT PAIR, INTERACTION=SOFT
SLAVE, MASTER
*BOUNDARY
BASE, ENCASTRE
LID, 1, 1
*STEP
*STATIC
*BOUNDARY
LID, 2, 2, -0.01
*END STEP
"""
CASE = """case = "two-bodies"
[[bodies]]
name = "upper"
file = "deck.inp"
cells = "UPPER"
method = "vem"
[[bodies]]
name = "lower"
file = "deck.inp"
cells = "LOWER"
method = "vem"
[[supports]]
body = "upper"
edges = "LID"
[[supports]]
body = "lower"
edges = "BASE"
[[motions]]
body = "upper"
shift_mm = [0.0, -0.01]
[[contacts]]
secondary = "upper"
secondary_edges = "SLAVE"
primary = "lower"
primary_edges = "MASTER"
enforcement = "multiplier"
"""
CHANGING = {
    "pad": {"pad": ", PAD THICKNESS=0.005"},
    "user": {"behaviour": "USER"},
    "penalty": {"behaviour": "PENALTY=LINEAR"},
    "clearance": {"behaviour": "PRESSURE-OVERCLOSURE=LINEAR", "clearance": "0.004"},
}


def deck(**changes):
    return MESH + REST.format(**{"pad": "", "behaviour": "PRESSURE-OVERCLOSURE=HARD", "clearance": ""} | changes)


@pytest.mark.parametrize("change", CHANGING)
def test_no_answer_comes_from_a_deck_that_is_not_read_whole(change, call, tmp_path):
    """A deck is no case, and a case that takes its mesh names the keywords that are not read."""
    (tmp_path / "deck.inp").write_text(deck(**CHANGING[change]), encoding="utf-8")
    status, out, err = call("run", "deck.inp")
    assert (status, out) == (2, "")
    assert "deck.inp, which is a mesh or a deck, not a case" in err
    assert "flangeway init two-bodies" in err
    assert call("check", "deck.inp")[0] == call("converge", "deck.inp")[0] == 2
    (tmp_path / "case.toml").write_text(CASE, encoding="utf-8")
    (notice,) = load_case(tmp_path / "case.toml").run().summary["notices"][:1]
    for keyword in ("*MATERIAL", "*SURFACE INTERACTION", "*SURFACE BEHAVIOR", "*CONTACT PAIR", "*BOUNDARY", "*STEP"):
        assert keyword in notice


def test_both_blocks_of_one_file_are_pressed(tmp_path):
    """Blocks in touch run with the deck's sets and surfaces; without contraction p = E d / (h1 + h2), in metres too."""
    (tmp_path / "deck.inp").write_text(MESH, encoding="utf-8")
    (tmp_path / "case.toml").write_text(CASE, encoding="utf-8")
    for unit, height in (("mm", 2.0), ("m", 2000.0)):
        inputs = {
            f"bodies.{number}.{key}": value for number in (1, 2) for key, value in (("unit", unit), ("poisson", 0))
        }
        (patch,) = load_case(tmp_path / "case.toml", **inputs).run().patches
        assert patch.pressures == pytest.approx(210e3 * 0.01 / height, rel=1e-9)


@pytest.mark.parametrize(
    ("key", "value", "told"),
    [
        ("size_mm", 1.0, "size_mm of an outline"),
        ("cells", "MIDDLE", "LOWER, UPPER"),
        ("method", "fem", 'method = "vem"'),
        ("materials", {"MIDDLE": {}}, "LOWER"),
    ],
)
def test_what_a_mesh_file_does_not_take_is_told(tmp_path, key, value, told):
    """Keys that contradict a mesh file are refused with what is there."""
    (tmp_path / "deck.inp").write_text(MESH, encoding="utf-8")
    body = {"name": "a", "file": str(tmp_path / "deck.inp"), "method": "vem", "cells": "LOWER", key: value}
    with pytest.raises(InputError) as caught:
        load_case("two-bodies", bodies=[body]).check()
    assert told in str(caught.value)


@pytest.mark.parametrize(
    ("line", "told"),
    [
        ("*IMPERFECTION, FILE=modes, STEP=1", r"\*IMPERFECTION in line 1"),
        ("*PARAMETER", r"\*PARAMETER in line 1"),
        ("*NODE, INPUT=nodes.txt", r"\*NODE in line 1 with the parameter 'INPUT'"),
        ("*ELEMENT, TYPE=CPE4, OFFSET=100", r"\*ELEMENT in line 1 with the parameter 'OFFSET'"),
        ("*SURFACE, NAME=BOTH, COMBINE=UNION", r"\*SURFACE in line 1 with the parameter 'COMBINE'"),
    ],
)
def test_what_would_change_the_mesh_is_refused(line, told, tmp_path):
    """Keywords and parameters that change nodes, elements or surfaces and are not read are refused with their line."""
    (tmp_path / "deck.inp").write_text(f"{line}\n{MESH}", encoding="utf-8")
    with pytest.raises(InputError, match=told):
        read_mesh(tmp_path / "deck.inp")


def test_sets_and_surfaces_of_a_deck_are_read(tmp_path):
    """Element sets are cell sets; node sets, also those of elements, and surfaces are edge sets, in an instance too."""
    (tmp_path / "flat.inp").write_text(MESH + "*NSET, NSET=ALL_LOW, ELSET=LOWER\n", encoding="utf-8")
    mesh = read_mesh(tmp_path / "flat.inp", merge_points=False).mesh
    assert {name: cells.tolist() for name, cells in mesh.cell_sets.items()} == {"LOWER": [0], "UPPER": [1]}
    assert set(mesh.edge_sets) == {"BASE", "LID", "MASTER", "SLAVE", "ALL_LOW"}
    assert mesh.points[mesh.edge_sets["SLAVE"]].tolist() == [[[0.0, 1.0], [2.0, 1.0]]]
    assert len(mesh.edge_sets["ALL_LOW"]) == 4
    part = "*PART, NAME=BLOCK\n" + MESH.partition("*NSET")[0] + "*SURFACE, NAME=TOP\nUPPER, S3\n*END PART\n"
    instance = "*INSTANCE, NAME=B1, PART=BLOCK\n*END INSTANCE\n"
    assembly = f"*ASSEMBLY, NAME=A\n{instance}*NODE\n1, 7., 7., 0.\n*SURFACE, NAME=FOOT\nB1.LOWER, S1\n*END ASSEMBLY\n"
    (tmp_path / "parts.inp").write_text(part + assembly, encoding="utf-8")
    mesh = read_mesh(tmp_path / "parts.inp", merge_points=False).mesh
    assert (set(mesh.cell_sets), mesh.n_points) == ({"LOWER", "UPPER"}, 8)
    assert mesh.points[mesh.edge_sets["TOP"]].tolist() == [[[2.0, 2.0], [0.0, 2.0]]]
    assert mesh.points[mesh.edge_sets["FOOT"]].tolist() == [[[0.0, 0.0], [2.0, 0.0]]]
