"""Abaqus decks that run as they are: flat ones and those of parts and instances, and what is refused."""

from datetime import timedelta

import numpy as np
import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from flangeway.errors import InputError
from flangeway.mesh import read_mesh
from flangeway.study import load_case
from flangeway.study.bodies_shape import part_of_mesh
from flangeway.study.case_file import check_case
from flangeway.study.case_template import write_case_file

E_UPPER, E_LOWER, DOWN = 1000.0, 3000.0, 0.02


def grid(name, x0, width, nx, ny, height):
    """Part of nx by ny quadrilaterals with its sets and a surface, as a modeller writes it."""
    lines = [f"*Part, name={name}", "*Node"]
    lines += [
        f"{1 + i + j * (nx + 1)}, {x0 + width * i / nx}, {height * j / ny}"
        for j in range(ny + 1)
        for i in range(nx + 1)
    ]
    lines.append("*Element, type=CPE4R")
    for j in range(ny):
        for i in range(nx):
            a = 1 + i + j * (nx + 1)
            lines.append(f"{1 + i + j * nx}, {a}, {a + 1}, {a + nx + 2}, {a + nx + 1}")
    n_points, first_of_top = (nx + 1) * (ny + 1), 1 + ny * (nx + 1)
    lines += [
        "*Nset, nset=bottom, generate",
        f"1, {nx + 1}, 1",
        "*Nset, nset=top, generate",
        f"{first_of_top}, {n_points}, 1",
    ]
    lines += ["*Nset, nset=corner", f"{first_of_top if name == 'upper' else 1}"]
    lines += ["*Elset, elset=all, generate", f"1, {nx * ny}, 1"]
    lines += [
        "*Elset, elset=_skin, internal, generate",
        f"1, {nx}, 1",
        "*Surface, type=ELEMENT, name=below",
        "_skin, S1",
    ]
    lines += [f"*Solid Section, elset=all, material={name}-steel", "2.0,", "*End Part"]
    return lines


def assembled(contact="*Contact Pair, interaction=hard, type=SURFACE TO SURFACE", friction="0.", extra=()):
    """Deck of two parts: the upper one is shifted up and pushed down on the lower one."""
    lines = ["*Heading", "** made by hand", *grid("upper", 0.0, 4.0, 3, 2, 2.0), *grid("lower", 0.0, 4.0, 4, 3, 3.0)]
    lines += ["*Assembly, name=Assembly", "*Instance, name=Upper-1, part=upper", "0., 3., 0.", "*End Instance"]
    lines += ["*Instance, name=Lower-1, part=lower", "*End Instance"]
    lines += ["*Elset, elset=_face, internal, instance=Lower-1, generate", "9, 12, 1"]
    lines += ["*Surface, type=ELEMENT, name=face", "_face, S3", "*End Assembly"]
    for name, young in (("upper", E_UPPER), ("lower", E_LOWER)):
        lines += [f"*Material, name={name}-steel", "*Elastic", f"{young}, 0."]
    lines += ["*Surface Interaction, name=hard", "1.,", "*Friction", f"{friction},"]
    lines += [contact, "Upper-1.below, face"] if contact else []
    lines += ["*Boundary", "Lower-1.bottom, 2, 2", "Lower-1.corner, 1, 1", "Upper-1.corner, XSYMM", "Upper-1.top, 2, 2"]
    lines += ["*Step, name=press", "*Static", "1., 1., 1e-5, 1.", *extra]
    lines += ["*Boundary", f"Upper-1.top, 2, 2, {-DOWN}", "*Output, field", "*End Step"]
    return "\n".join(lines) + "\n"


def deck(folder, text):
    path = folder / "deck.inp"
    path.write_text(text, encoding="utf-8")
    return path


def test_a_deck_of_parts_runs_without_an_edit(tmp_path):
    """Two columns pressed by a displaced set bear p = d / (h1 / E1 + h2 / E2), as the deck says, with no case file."""
    path = deck(tmp_path, assembled())
    case = load_case(path)
    check_case(case, path)
    assert [body.name for body in case.bodies] == ["Upper-1", "Lower-1"] or {b.name for b in case.bodies} == {
        "Upper-1",
        "Lower-1",
    }
    run = case.run()
    pressures = np.concatenate([patch.pressures for patch in run.patches])
    assert pressures == pytest.approx(DOWN / (2.0 / E_UPPER + 3.0 / E_LOWER), rel=1e-9)
    assert run.contact.forces[0] == pytest.approx([0.0, 4.0 * 2.0 * pressures[0]], abs=1e-9)
    finer = load_case(path, thickness_mm=1.0).run()
    assert finer.contact.forces[0, 1] == pytest.approx(run.contact.forces[0, 1] / 2.0)


def test_a_deck_becomes_a_case_file(tmp_path):
    """The case file written from a deck, in another folder, computes the same."""
    path = deck(tmp_path, assembled(extra=["*Dload", "Upper-1.all, BY, -0.25"]))
    case = load_case(path)
    (tmp_path / "cases").mkdir()
    target = tmp_path / "cases" / "deck.toml"
    target.write_text(write_case_file(case, target.parent), encoding="utf-8")
    found = load_case(target)
    assert found.bodies[0].file == str(target.parent / ".." / "deck.inp")
    assert found.run().contact.forces == pytest.approx(case.run().contact.forces, rel=1e-12)


def test_loads_of_a_deck_are_taken(tmp_path):
    """A pressure, forces at nodes and a body force act beside the contact: the supports bear what is left."""
    extra = [
        "*Dsload",
        "Upper-1.below, P, -1.5",
        "*Dload",
        "Upper-1.all, BY, -0.25",
        "*Cload",
        "Lower-1.corner, 2, -3.",
    ]
    run = load_case(deck(tmp_path, assembled(extra=extra))).run()
    loads = {row["body"]: row["loads_N"] for row in run.summary["results"]["forces"]}
    assert loads["Upper-1"] == pytest.approx([0.0, -1.5 * 4.0 * 2.0 - 0.25 * 8.0 * 2.0])
    assert loads["Lower-1"] == pytest.approx([0.0, -3.0])


def test_a_flat_deck_with_one_body_is_plane_elasticity(tmp_path):
    """A bar of two quadrilaterals under nodal forces stretches by sigma l / E in plane stress."""
    text = """*NODE
1, 0, 0
2, 1, 0
3, 2, 0
4, 0, 1
5, 1, 1
6, 2, 1
*ELEMENT, TYPE=CPS4, ELSET=BAR
1, 1, 2, 5, 4
2, 2, 3, 6, 5
*NSET, NSET=HELD
1, 4
*NSET, NSET=PULLED
3, 6
*SOLID SECTION, ELSET=BAR, MATERIAL=SOFT
*MATERIAL, NAME=SOFT
*ELASTIC
10.0, 0.0
*BOUNDARY
HELD, ENCASTRE
*STEP
*CLOAD
PULLED, 1, 0.5
*END STEP
"""
    run = load_case(deck(tmp_path, text)).run()
    assert run.contact is None
    assert run.summary["bodies"][0]["max_displacement_mm"] == pytest.approx(1.0 / 1.0 * 2.0 / 10.0)


def test_instances_are_placed(tmp_path):
    """Two instances of one part, one turned by a right angle about a point and shifted, lie where the deck says."""
    lines = [
        *grid("lower", 0.0, 4.0, 2, 1, 1.0),
        "*Assembly, name=a",
        "*Instance, name=one, part=lower",
        "*End Instance",
    ]
    lines += ["*Instance, name=two, part=lower", "10., 0., 0.", "10., 0., 0., 10., 0., 1., 90.", "*End Instance"]
    read = read_mesh(deck(tmp_path, "\n".join([*lines, "*End Assembly"]) + "\n"), merge_points=False).mesh
    turned = part_of_mesh(read, read.cell_sets["two"]).points
    assert turned.min(axis=0) == pytest.approx([9.0, 0.0])
    assert turned.max(axis=0) == pytest.approx([10.0, 4.0])
    assert {"one", "two", "one:all", "two:all"} <= set(read.cell_sets)
    assert len(read.cell_sets["one"]) == len(read.cell_sets["two"]) == 2
    assert {"one:below", "two:below"} <= set(read.edge_sets)


WRONG = {
    "friction": (assembled(friction="0.3"), ["*FRICTION in line 108", "frictionless"]),
    "tie": (assembled(extra=["*Tie, name=t", "a, b"]), ["*TIE in line"]),
    "surface": (assembled().replace("Upper-1.below, face", "Upper-1.belov, face"), ["*CONTACT PAIR in line", "belov"]),
    "set": (assembled().replace("Lower-1.corner, 1", "Lower-1.cornr, 1"), ["*BOUNDARY in line", "cornr"]),
    "material": (assembled().replace("material=upper-steel", "material=brass"), ["*SOLID SECTION in line", "BRASS"]),
    "elastic": (assembled().replace(f"{E_UPPER}, 0.", "soft, 0."), ["*ELASTIC in line", "soft"]),
    "poisson": (assembled().replace(f"{E_UPPER}, 0.", "1000., 0.7"), ["poisson = 0.7"]),
    "load": (assembled(extra=["*Dload", "Upper-1.all, P1, 3."]), ["*DLOAD in line", "P1"]),
    "part": (assembled().replace("part=upper", "part=uper"), ["*INSTANCE in line", "uper"]),
    "tilted": (assembled().replace("0., 3., 0.", "0., 3., 0.\n0., 0., 0., 1., 0., 0., 90."), ["out of the plane"]),
    "shells": (assembled().replace("*Solid Section", "*Shell Section"), ["*SHELL SECTION in line 36"]),
    "no section": (
        assembled().replace("*Solid Section, elset=all, material=upper-steel\n2.0,\n", ""),
        ["without *SOLID SECTION"],
    ),
    "supports": (
        assembled().replace("Upper-1.corner, XSYMM", "").replace("Upper-1.top", "Lower-1.bottom"),
        ["without supports"],
    ),
}


@pytest.mark.parametrize(("text", "told"), WRONG.values(), ids=WRONG)
def test_what_a_deck_may_not_have_is_told_with_its_line(tmp_path, text, told):
    """What changes the answer and cannot be computed is refused with the keyword and its line, never passed over."""
    path = deck(tmp_path, text)
    with pytest.raises(InputError) as caught:
        check_case(load_case(path), path)
    for words in told:
        assert words in str(caught.value)
    assert str(path) in caught.value.given


LINES = assembled(
    extra=["*Dsload", "Upper-1.below, P, -1.5", "*Dload", "Upper-1.all, BY, -1", "*Cload", "Lower-1.corner, 2, 3"]
)
WORDS = st.sampled_from(
    ["", "1", "-1", "0", "x", "99", "1e300", "nan", "inf", "1.5", "Upper-1.top", "3, 4", "*", "a=b"]
)
CHANGES = st.tuples(st.integers(0, 200), st.integers(0, 8), WORDS, st.sampled_from(["word", "drop", "double"]))


@settings(deadline=timedelta(seconds=20), suppress_health_check=[HealthCheck.function_scoped_fixture])
@given(changes=st.lists(CHANGES, min_size=1, max_size=3))
def test_a_broken_deck_gives_a_case_or_an_input_error(tmp_path, changes):
    """Lines dropped, doubled, or with other words: the deck is sound or refused by an error that names the file."""
    lines = LINES.splitlines()
    for number, place, word, kind in changes:
        row = number % len(lines)
        words = lines[row].split(",")
        words[place % len(words)] = word
        lines[row : row + 1] = {"word": [",".join(words)], "drop": [], "double": [lines[row]] * 2}[kind]
    case, refused = None, None
    path = deck(tmp_path, "\n".join(lines))
    try:
        case = load_case(path)
        check_case(case, path)
    except InputError as error:
        refused = error
    assert str(path) in refused.given if refused is not None else case.bodies
