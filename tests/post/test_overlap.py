"""Overlaps of undeformed boundaries are found where they are, and contact is none."""

import numpy as np
import pytest

from flangeway.contact.overlap import Boundary, passes_through
from flangeway.elements import Lagrange
from flangeway.geometry import Placement, circle
from flangeway.materials import Elastic
from flangeway.mesh import rectangle_grid, triangulate
from flangeway.problems import Body, Part


def part_of(mesh):
    """A steel part of a mesh."""
    return Part("box", Body("box", mesh, Lagrange(1), Elastic(210e3, 0.3)))


def boundary(mesh, placement):
    """Boundary of a placed mesh."""
    return Boundary.of_part(part_of(mesh), placement.points(mesh.points))


def box(x, y):
    """Boundary of a square of side 1 in 4 x 4 cells, its lower left corner at x, y."""
    return boundary(rectangle_grid(1.0, 1.0, 4, 4), Placement(0.0, (x, y)))


def test_boxes_overlap_by_the_depth_of_the_deepest_corner():
    """A corner that lies 0.2 and 0.3 inside another box is 0.2 deep, seen from either box."""
    for one, other in ((box(0.0, 0.0), box(0.8, 0.7)), (box(0.8, 0.7), box(0.0, 0.0))):
        assert one.overlap(other).depth == pytest.approx(0.2)


def test_boxes_apart_do_not_overlap_and_straight_sides_allow_nothing():
    """Boxes apart have no overlap; a millionth of a side is one, and no chord of a curve explains it."""
    assert box(0.0, 0.0).overlap(box(1.5, 0.0)) is None
    found = box(0.0, 0.0).overlap(box(1.0 - 1e-6, 0.37))
    assert found.depth == pytest.approx(1e-6, rel=1e-6)
    assert found.allowed == 0.0


def test_edges_that_cross_without_a_node_inside_are_an_overlap():
    """A bar that goes through a box overlaps it by half of its width, although no node is in the other body."""
    bar = boundary(rectangle_grid(10.0, 0.1, 1, 1), Placement(0.0, (-4.5, 0.3)))
    assert box(0.0, 0.0).overlap(bar).depth == pytest.approx(0.4, rel=0.1)


def test_chords_of_two_arcs_explain_their_sagittas_alone():
    """Meshed discs that roll on each other overlap by their sagittas at most; pressed by an edge they overlap more."""
    mesh = triangulate(circle(1.0), size=0.2)
    disc = boundary(mesh, Placement())
    for angle in np.linspace(0.0, 0.6, 7):
        rolled = disc.overlap(boundary(mesh, Placement(angle, (2.0, 0.0))))
        assert rolled is None or rolled.depth <= rolled.allowed + 1e-9
        assert disc.overlap(boundary(mesh, Placement(angle, (1.8, 0.0)))).depth > 0.1


@pytest.mark.parametrize(("y", "passes"), [(0.0, True), (0.99, True), (1.01, False), (-1.01, False)])
def test_a_path_through_a_body_is_seen_however_thin_it_is(y, passes):
    """A box that moves far past a thin plate goes through it where their heights overlap."""
    moved, plate = part_of(rectangle_grid(1.0, 1.0, 1, 1)), part_of(rectangle_grid(1e-3, 1.0, 1, 1))
    path = [(Placement(0.0, (x, y)), Placement()) for x in (-100.0, 100.0)]
    assert passes_through(moved, plate, path, 1e-6) == passes
