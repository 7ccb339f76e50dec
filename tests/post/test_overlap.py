"""Overlaps of bodies are found where they are, and contact is none."""

from dataclasses import replace

import numpy as np
import pytest

from flangeway.cases import CASES
from flangeway.geometry import Placement, circle
from flangeway.mesh import rectangle_grid, triangulate
from flangeway.post import deepest_overlap


def box(x, y):
    """A square of side 1 in 4 x 4 cells, its lower left corner at x, y."""
    return rectangle_grid(1.0, 1.0, 4, 4).placed(Placement(0.0, (x, y)))


def test_boxes_overlap_by_the_depth_of_the_deepest_corner():
    """A corner that lies 0.2 and 0.3 inside another box is 0.2 deep, seen from either box."""
    for pair in ((box(0.0, 0.0), box(0.8, 0.7)), (box(0.8, 0.7), box(0.0, 0.0))):
        found = deepest_overlap(*pair)
        assert found.depth == pytest.approx(0.2)


@pytest.mark.parametrize("x", [1.0, 1.5])
def test_what_touches_is_no_overlap(x):
    """Boxes side by side or apart do not overlap."""
    assert deepest_overlap(box(0.0, 0.0), box(x, 0.0)) is None


def test_straight_sides_may_not_overlap_at_all():
    """A millionth of a side is an overlap where sides are straight, wherever the nodes are."""
    found = deepest_overlap(box(0.0, 0.0), box(1.0 - 1e-6, 0.37))
    assert found.depth == pytest.approx(1e-6, rel=1e-6)


def test_edges_that_cross_without_a_node_inside_are_an_overlap():
    """A bar that goes through a box overlaps it by half of its width, although no node is in the other body."""
    bar = rectangle_grid(10.0, 0.1, 1, 1).placed(Placement(0.0, (-4.5, 0.3)))
    assert deepest_overlap(box(0.0, 0.0), bar).depth == pytest.approx(0.4, rel=0.1)


def test_chords_of_two_arcs_are_no_overlap():
    """Meshed discs that touch or roll on each other overlap by their chords at most; pressed by an edge they do."""
    mesh = triangulate(circle(1.0), size=0.2)
    for angle in np.linspace(0.0, 0.6, 7):
        turned = mesh.placed(Placement(angle, (2.0, 0.0)))
        assert deepest_overlap(mesh, turned) is None
        assert deepest_overlap(mesh, turned.placed(Placement(0.0, (-0.2, 0.0)))).depth > 0.1


def test_displacements_and_the_placement_move_the_mesh():
    """A box drawn out by its displacements reaches into the one beside it."""
    mesh = box(0.0, 0.0)
    drawn = replace(mesh, points=mesh.points * [1.5, 1.0]).placed(Placement(0.0, (0.1, 0.0)))
    assert drawn.points[:, 0].max() == pytest.approx(1.6)
    assert deepest_overlap(drawn, box(1.2, 0.0)).depth == pytest.approx(0.4)


@pytest.mark.parametrize(
    ("shift", "words"),
    [(-300.0, "moved through"), (-30.0, None), (10.0, "nothing touches")],
)
def test_a_case_whose_bodies_pass_through_each_other_has_not_converged(shift, words):
    """A disc moved far through a block, or deep into it in one step, is no answer; one that is lifted is one."""
    case = CASES["two-bodies"]
    values = {**case.example, "motions": [{"body": "cylinder", "shift_mm": [0.0, shift]}]}
    run = case.from_values(values).run()
    assert run.status.converged == (shift > 0.0)
    if words:
        assert words in run.status.message
