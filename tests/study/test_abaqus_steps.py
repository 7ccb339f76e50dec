"""Abaqus decks written by hand: what stands after the last step, nodes by number, middle nodes, other spellings."""

import numpy as np
import pytest

from flangeway.errors import InputError
from flangeway.study import load_case

YOUNG = 1000.0
BAR = """*NODE
1, 0., 0.
2, 2., 0.
3, 2., 1.
4, 0., 1.
5, 1., 0.
6, 2., 0.5
7, 1., 1.
8, 0., 0.5
*ELEMENT, TYPE=CPS8R, ELSET=Bar
1, 1, 2, 3, 4,
5, 6, 7, 8
*NSET, NSET=Left
1, 8, 4
*SURFACE, NAME=End, TYPE=ELEMENT
Bar, S2
*SOLID SECTION, ELSET=BAR, MATERIAL=Soft
3.,
*MATERIAL, NAME=SOFT
*DENSITY
0.5,
*ELASTIC, TYPE=ISO
1000., 0.
*BOUNDARY
LEFT, 1
1, 2
"""
END_LOADS = "2, 1, {0}\n6, 1, {1}\n3, 1, {0}\n"


def step(*lines):
    """One static step."""
    return "\n".join(["*STEP", "*STATIC", *lines, "*END STEP", ""])


def stretched(folder, steps, text=BAR):
    """Stress in the bar of thickness 3 from the displacement of its end: (mean, spread)."""
    path = folder / "bar.inp"
    path.write_text(text + steps, encoding="utf-8")
    field = load_case(path).run().bodies["Bar"].field
    nodes = field.problem.space.nodes
    moves = field.displacements[: len(nodes), 0][np.abs(nodes[:, 0] - 2.0) < 1e-9]
    return YOUNG * moves.mean() / 2.0, np.ptp(moves)


def test_forces_at_middle_nodes_act(tmp_path):
    """Consistent nodal forces 1 : 4 : 1 on a side of an eight-node element stretch it as an even traction does."""
    stress, spread = stretched(tmp_path, step("*CLOAD", END_LOADS.format(1.0, 4.0)))
    assert stress == pytest.approx(6.0 / 3.0, rel=1e-9)
    assert spread < 1e-12


STEPS = {
    "a later step replaces": (step("*DSLOAD", "END, P, -1.") + step("*dsload", "end, p, -3."), 3.0),
    "a later step adds another kind": (
        step("*DSLOAD", "End, P, -1.") + step("*CLOAD", END_LOADS.format(1.0, 4.0)),
        1.0 + 2.0,
    ),
    "one step adds": (step("*DSLOAD", "End, P, -1.", "End, P, -3."), 4.0),
    "OP=NEW removes": (
        step("*CLOAD", END_LOADS.format(2.0, 8.0)) + step("*CLOAD, OP=NEW", END_LOADS.format(1.0, 4.0)),
        2.0,
    ),
    "an amplitude at the end of its step": (
        "*AMPLITUDE, NAME=Half\n0., 0., 1., 1., 3., 0.\n"
        + step("*DSLOAD, AMPLITUDE=HALF", "End, P, -8.").replace("*STATIC", "*STATIC\n0.1, 2."),
        4.0,
    ),
    "a displacement given anew": (
        step("*BOUNDARY", "2, 1, 1, 1.", "6, 1, 1, 1.", "3, 1, 1, 1.")
        + step("*BOUNDARY", "2, 1, 1, 0.004", "6, 1, 1, 0.004", "3, 1, 1, 0.004"),
        2.0,
    ),
    "supports taken away": (
        step("*BOUNDARY", "2, 1, 1, 1.", "3, 1, 1, 1.")
        + step("*BOUNDARY, OP=NEW", "Left, 1", "1, 2", "*DSLOAD", "End, P, -2."),
        2.0,
    ),
    "gravity": (step("*DLOAD", "Bar, GRAV, 6., 2., 0., 0."), 0.5 * 12.0 * 2.0 / 2.0),
}


@pytest.mark.parametrize(("steps", "expected"), STEPS.values(), ids=STEPS)
def test_what_stands_after_the_last_step_acts(tmp_path, steps, expected):
    """The bar's mean stress is that of the loads and supports of the last step's end, as Abaqus takes them over."""
    assert stretched(tmp_path, steps)[0] == pytest.approx(expected, rel=1e-9)


REFUSED = {
    "a keyword that is not known": ("*INITIAL CONDITIONS, TYPE=STRESS\nBar, 1.\n", "line 27: *INITIAL CONDITIONS"),
    "a procedure": ("*STEP\n*FREQUENCY\n5\n*END STEP\n", "line 28: *FREQUENCY"),
    "a keyword misspelt": ("*BOUNDRY\nLeft, 2\n", "line 27: *BOUNDRY"),
    "velocities": ("*BOUNDARY, TYPE=VELOCITY\nLeft, 2\n", "line 27: the parameter TYPE"),
    "loads that follow": (step("*CLOAD, FOLLOWER", "2, 1, 1."), "line 29: the parameter FOLLOWER"),
    "no separation": (
        "*SURFACE INTERACTION, NAME=I\n*SURFACE BEHAVIOR, NO SEPARATION\n",
        "line 28: the parameter NO SEPARATION",
    ),
    "rough": ("*SURFACE INTERACTION, NAME=I\n*FRICTION, ROUGH\n", "line 28: the parameter ROUGH"),
    "soft": (
        "*SURFACE INTERACTION, NAME=I\n*SURFACE BEHAVIOR, PRESSURE-OVERCLOSURE=TABULAR\n0., 0.\n1., 1.\n"
        "*CONTACT PAIR, INTERACTION=I\nEnd, End\n",
        "line 28: PRESSURE-OVERCLOSURE=TABULAR",
    ),
    "a face that plane elements do not have": ("*SURFACE, NAME=Side\nBar, P2\n", "line 27: the face P2"),
    "a surface of segments": ("*SURFACE, NAME=Side, TYPE=SEGMENTS\nSTART, 0., 0.\n", "line 27: TYPE=SEGMENTS"),
    "tied": ("*CONTACT PAIR, TIED\nEnd, End\n", "line 27: the parameter TIED"),
    "adjusted": ("*CONTACT PAIR, ADJUST=0.1\nEnd, End\n", "line 27: ADJUST=0.1"),
    "an amplitude that is missing": (step("*DSLOAD, AMPLITUDE=A", "End, P, 1."), "line 29: the amplitude A"),
    "a pressure on faces": (step("*DLOAD", "Bar, P2, 5."), "line 29: a load of the type P2"),
    "two displacements of a node": (
        step("*BOUNDARY", "4, 1, 1, 0.5"),
        "line 29: 4 with x = 0.5, where LEFT in line 24 has x = 0 at (0, 1)",
    ),
    "a node that is not there": (step("*CLOAD", "99, 1, 1."), "line 29: the node set '99'"),
    "a set written in two ways": ("*NSET, NSET=LEFT\n2\n", "the sets Left and LEFT, which are one"),
    "a set by elements": ("*NSET, NSET=Far, ELSET=Bar\n", "line 27: the parameter ELSET"),
    "a support of no element": (
        "*NODE, NSET=Far\n9, 9., 9.\n*BOUNDARY\nFar, 1\n",
        "Far, which has no node of an element",
    ),
    "a node of no element": ("*NODE, NSET=Far\n9, 9., 9.\n" + step("*CLOAD", "FAR, 1, 1."), "a node of no element"),
}


@pytest.mark.parametrize(("more", "told"), REFUSED.values(), ids=REFUSED)
def test_what_would_change_the_answer_is_refused_with_its_line(tmp_path, more, told):
    """Nothing that changes the answer is passed over: the message names the keyword and its line in the file."""
    path = tmp_path / "bar.inp"
    path.write_text(BAR + more, encoding="utf-8")
    with pytest.raises(InputError) as caught:
        load_case(path)
    assert told in caught.value.given


def test_mixed_decks_are_refused(tmp_path):
    """Plane strain and plane stress in one deck, shells, sections of unlike thickness, elements without a section."""
    two = "*NODE\n11, 5., 0.\n12, 6., 0.\n13, 5., 1.\n*ELEMENT, TYPE={}, ELSET=More\n2, 11, 12, 13\n"
    section = "*SOLID SECTION, ELSET=More, MATERIAL=Soft\n"
    for more, told in (
        (two.format("CPE3") + section + "3.,\n", "CPE and CPS in one deck"),
        (two.format("S3") + section + "3.,\n", "elements S3"),
        (two.format("CPS3") + section, "thicknesses 1, 3"),
        (two.format("CPS3"), "without *SOLID SECTION for the element at (5.33333, 0.333333)"),
        ("*SOLID SECTION, ELSET=None, MATERIAL=Soft\n", "'None', of which no element is plane"),
    ):
        path = tmp_path / "bar.inp"
        path.write_text(BAR + more, encoding="utf-8")
        with pytest.raises(InputError) as caught:
            load_case(path)
        assert told in caught.value.given


BLOCKS = """*Node
1, 0., 0.
2, 2., 0.
3, 2., 1.
4, 0., 1.
11, 0., 1.
12, 2., 1.
13, 2., 2.
14, 0., 2.
*Element, type=CPE4, elset=Lower
1, 1, 2, 3, 4
*Element, type=CPE4, elset=Upper
2, 11, 12, 13, 14
*Nset, nset=base
1, 2
*Nset, nset=lid
13, 14
*Surface, type=node, name=below
11
12
*Surface, type=element, name=face
1, S3
*Solid Section, elset=lower, material=m
*Solid Section, elset=upper, material=m
*Material, name=m
*Elastic
1000., 0.
*Surface Interaction, name=soft
*Surface Behavior, pressure-overclosure=linear
500000.,
*Contact Pair, interaction=SOFT
Below, FACE
*Boundary
BASE, encastre
LID, 1, 1
*Step
*Static
*Boundary
Lid, 2, 2, -0.01
*End Step
"""


def test_a_linear_overclosure_is_a_spring_between_the_surfaces(tmp_path):
    """Two columns in a row, and a pressure-overclosure k between them, names in any case: p = d / (2 / E + 1 / k)."""
    path = tmp_path / "blocks.inp"
    path.write_text(BLOCKS, encoding="utf-8")
    run = load_case(path).run()
    assert run.contact.forces[0, 1] == pytest.approx(2.0 * 0.01 / (2.0 / 1000.0 + 1.0 / 500000.0), rel=1e-9)


def test_each_body_has_the_order_of_its_elements(tmp_path):
    """Beside a body of eight-node elements one of four-node elements stays of first order."""
    more = "*NODE\n11, 5., 0.\n12, 6., 0.\n13, 6., 1.\n14, 5., 1.\n*ELEMENT, TYPE=CPS4, ELSET=More\n2, 11, 12, 13, 14\n"
    more += "*SOLID SECTION, ELSET=More, MATERIAL=Soft\n3.,\n*BOUNDARY\n11, 1, 2\n12, 2\n"
    path = tmp_path / "bar.inp"
    path.write_text(BAR + more + step("*CLOAD", "6, 1, 1.", "13, 2, 1."), encoding="utf-8")
    case = load_case(path)
    assert {body.name: body.order for body in case.bodies} == {"Bar": 2, "More": 1}
    assert case.run().status.converged
