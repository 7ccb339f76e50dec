"""Nodes inserted into the boundaries of meshes, so that those of two bodies match."""

import numpy as np
import pytest

from flangeway.elements import Lagrange, Virtual
from flangeway.errors import InputError
from flangeway.geometry import Arc, Line, Outline, Placement
from flangeway.materials import Elastic
from flangeway.mesh import check, curved, dual, insert_nodes, match_boundaries, rectangle_grid, triangulate
from flangeway.mesh.insertion import match_all
from flangeway.problems import Elasticity, PrescribedDisplacement, Traction
from flangeway.solve import solve_elasticity
from flangeway.space import Space


def shifted(y):
    """A shift along y."""
    return Placement(0.0, (0.0, y))


UPPER, LOWER = rectangle_grid(4.0, 2.0, 7, 2), rectangle_grid(5.0, 2.0, 5, 2, origin=(-0.3, -2.0))


def on(mesh, name):
    """Points along an edge set in the order of x."""
    points = mesh.points[np.unique(mesh.edge_sets[name])]
    return points[np.argsort(points[:, 0])]


def test_boundaries_get_the_nodes_of_each_other() -> None:
    """Where two blocks are opposite each other their nodes are, to round-off; a second time adds nothing."""
    upper, lower = match_boundaries(dual(UPPER), "bottom", dual(LOWER), "top")
    mine, theirs = on(upper, "bottom"), on(lower, "top")
    np.testing.assert_allclose(mine, theirs[(theirs[:, 0] > -1e-9) & (theirs[:, 0] < 4.0 + 1e-9)], atol=1e-14)
    for mesh, before in ((upper, dual(UPPER)), (lower, dual(LOWER))):
        check(mesh)
        np.testing.assert_allclose(mesh.cell_areas, before.cell_areas, rtol=1e-13)
        assert np.array_equal(mesh.points[: before.n_points], before.points)
    again = match_boundaries(upper, "bottom", lower, "top")
    assert [mesh.n_points for mesh in again] == [upper.n_points, lower.n_points]


def test_arcs_across_a_gap_keep_the_order_of_their_nodes() -> None:
    """Facing arcs of different meshes, with a gap as large as their radii, get as many nodes as each other."""

    def disc(radius, size, sign):
        arc = Arc((-radius * sign, 0.0), (radius * sign, 0.0), (0.0, 0.0), counter_clockwise=True)
        outline = Outline.from_segments([arc, Line((radius * sign, 0.0), (-radius * sign, 0.0))], ["rim", "cut"])
        return triangulate(outline, size=size)

    upper, lower = disc(3.0, 0.5, 1.0), disc(2.0, 0.37, -1.0)
    moved = [mesh.placed(at) for mesh, at in zip((upper, lower), (shifted(3.1), shifted(-2.0)), strict=True)]
    one, other = match_boundaries(moved[0], "rim", moved[1], "rim")
    assert one.n_points - upper.n_points > 5
    again = match_boundaries(one, "rim", other, "rim")
    assert [mesh.n_points for mesh in again] == [one.n_points, other.n_points]


def test_points_on_curved_edges_are_on_the_curve() -> None:
    """A node inserted into an arc's edge lies on the arc, and its pieces are edges on that arc."""
    arc = Arc((1.0, 0.0), (0.0, 1.0), (0.0, 0.0), counter_clockwise=True)
    outline = Outline.from_segments(
        [arc, Line((0.0, 1.0), (0.0, 0.0)), Line((0.0, 0.0), (1.0, 0.0))], ["arc", "y", "x"]
    )
    mesh = dual(curved(triangulate(outline, size=0.4), outline))
    angles = np.array([0.3, 0.31, 0.9])
    fine = insert_nodes(mesh, "arc", 1.2 * np.column_stack((np.cos(angles), np.sin(angles))))
    new = fine.points[mesh.n_points :]
    np.testing.assert_allclose(np.hypot(*new.T), 1.0, atol=1e-12)
    np.testing.assert_allclose(np.arctan2(new[:, 1], new[:, 0]), angles, atol=1e-9)
    assert len(fine.curves.pairs) == len(mesh.curves.pairs) + 3
    assert fine.cell_areas.sum() == pytest.approx(np.pi / 4.0, rel=1e-6)
    check(fine)


@pytest.mark.parametrize("order", [1, 2, 3])
def test_the_patch_test_passes_with_edges_of_a_millionth(order) -> None:
    """Nodes a millionth of an edge beside others leave constant stresses exact to 1e-8."""
    x = on(UPPER, "bottom")[1:-1, 0] + 4.0 / 7.0 * 1e-6
    mesh = insert_nodes(dual(UPPER), "bottom", np.column_stack((x, 0.0 * x)))
    assert mesh.n_points == dual(UPPER).n_points + 6
    held = [PrescribedDisplacement("bottom", y=0.0), PrescribedDisplacement("left", x=0.0)]
    problem = Elasticity(Space(mesh, Virtual(order)), Elastic(1.0, 0.3), 1.0, [Traction("top", (0.0, -1.0))], held)
    found = solve_elasticity(problem).displacements[: mesh.n_points]
    np.testing.assert_allclose(found[:, 1], -(1.0 - 0.3**2) * mesh.points[:, 1], atol=1e-8)


def test_points_at_nodes_and_points_given_twice_add_nothing() -> None:
    """A projection within 1e-7 of an edge of a node is the node; of two equal points one is inserted."""
    at = [(0.3, -1.0), (0.3, -2.0), (4.0 / 7.0 + 1e-9, 0.0), (-1.0, 0.0), (9.0, 0.0)]
    assert insert_nodes(UPPER, "bottom", at).n_points == UPPER.n_points + 1


def test_three_bodies_match_along_common_edges() -> None:
    """Nodes that one contact adds to an edge of two contacts reach the third body; refused if they never end."""
    third = rectangle_grid(3.0, 1.0, 4, 1, origin=(0.2, -2.0)).with_edge_set("roof", lambda p: p[:, 1] > -1.0 - 1e-9)
    third = third.placed(shifted(1.0))
    meshes = {"upper": dual(UPPER), "lower": dual(LOWER), "third": dual(third)}
    pairs = [("upper", "bottom", "lower", "top"), ("third", "roof", "upper", "bottom")]
    found = match_all(meshes, pairs)
    for one, edges, other, others in pairs:
        again = match_boundaries(found[one], edges, found[other], others)
        assert [mesh.n_points for mesh in again] == [found[one].n_points, found[other].n_points]


@pytest.mark.parametrize(
    ("act", "words"),
    [
        (lambda: insert_nodes(UPPER, UPPER.edges[[int(np.argmax(UPPER.edge_cells[:, 1] >= 0))]], [(1, 1)]), "inside"),
        (lambda: Space(insert_nodes(UPPER, "bottom", [(1.0, 0.0)]), Lagrange(1)), "use Virtual"),
    ],
)
def test_what_cannot_be_inserted_is_refused(act, words) -> None:
    """Edges inside, and triangles with four nodes."""
    with pytest.raises(InputError, match=words):
        act()
