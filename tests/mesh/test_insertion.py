"""Nodes inserted into the boundaries of meshes, so that those of two bodies match; meshes of sections."""

import numpy as np
import pytest

from flangeway.elements import Lagrange, Virtual
from flangeway.errors import InputError
from flangeway.geometry import Arc, Line, Outline, Placement, Region, Section, circle, rectangle, square
from flangeway.materials import Elastic
from flangeway.mesh import (
    Refinement,
    check,
    curved,
    dual,
    dual_section,
    insert_nodes,
    match_boundaries,
    rectangle_grid,
    triangulate,
    triangulate_section,
)
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


def test_one_part_with_holes_has_its_cell_set_and_names():
    """A square with a square hole: the mesh has the region's area, one cell set, and the loops' edge sets."""
    section = Section({"box": Region(square(4.0), (square(2.0),))})
    mesh = triangulate_section(section, size=0.5)
    check(mesh)
    assert mesh.cell_areas.sum() == pytest.approx(12.0, rel=1e-12)
    np.testing.assert_array_equal(mesh.cell_set("box"), np.arange(mesh.n_cells))
    assert set(mesh.edge_sets) == {"bottom", "right", "top", "left"}


def test_parts_that_touch_share_their_points():
    """A flange on a wider web, joined along a part of a side, is one connected mesh with both parts' areas."""
    web = Region(rectangle(2.0, 6.0, (0.0, -3.0)))
    flange = Region(rectangle(6.0, 1.0, (0.0, 0.5)))
    mesh = triangulate_section(Section({"web": web, "flange": flange}), size=0.5)
    check(mesh)
    areas = [mesh.cell_areas[mesh.cell_set(name)].sum() for name in ("web", "flange")]
    np.testing.assert_allclose(areas, (12.0, 6.0), rtol=1e-12)
    lengths = np.hypot(*np.diff(mesh.points[mesh.boundary_edges], axis=1)[:, 0].T)
    assert lengths.sum() == pytest.approx(2.0 + 2 * 6.0 + 4.0 + 6.0 + 2 * 1.0, rel=1e-9)


def test_an_inclusion_fills_a_hole():
    """A disc in a hole of the same arcs, refined about a point: no boundary is left between them."""
    core = Region(circle(1.0))
    shell = Region(square(4.0), (circle(1.0),))
    near = Refinement(np.array([[1.0, 0.0]]), 0.05, 0.3)
    mesh = triangulate_section(Section({"shell": shell, "core": core}), size=0.4, refinements=[near])
    check(mesh)
    assert mesh.cell_areas.sum() == pytest.approx(16.0, rel=1e-12)
    assert np.abs(mesh.points[mesh.boundary_edges]).max(axis=2) == pytest.approx(2.0)
    assert np.hypot(*np.diff(mesh.points[mesh.edges], axis=1)[:, 0].T).min() < 0.06


def test_overlapping_parts_are_refused_with_the_place():
    """Two squares that overlap in one of side 1 about (1.5, 1.5) are refused by name and place."""
    parts = {"a": Region(square(2.0, (1.0, 1.0))), "b": Region(square(2.0, (2.0, 2.0)))}
    with pytest.raises(InputError, match=r"parts a and b, which overlap about \(1.5, 1.5\)"):
        triangulate_section(Section(parts), size=0.5)


def test_duals_of_parts_are_glued_where_they_touch():
    """Polygons of three parts, two of which meet at a point of the third, keep areas, sets and boundary length."""
    section = Section(
        {
            "base": Region(rectangle(4.0, 1.0, (0.0, -0.5))),
            "left": Region(rectangle(2.0, 1.0, (-1.0, 0.5))),
            "right": Region(rectangle(2.0, 1.0, (1.0, 0.5))),
        }
    )
    triangles = triangulate_section(section, size=0.3)
    polygons = dual_section(triangles)
    check(polygons)
    for name, area in (("base", 4.0), ("left", 2.0), ("right", 2.0)):
        assert polygons.cell_areas[polygons.cell_set(name)].sum() == pytest.approx(area, rel=1e-12)
    lengths = np.hypot(*np.diff(polygons.points[polygons.boundary_edges], axis=1)[:, 0].T)
    assert lengths.sum() == pytest.approx(12.0, rel=1e-12)
    assert {name: len(pairs) for name, pairs in polygons.edge_sets.items()} == {
        name: 2 * len(pairs) for name, pairs in triangles.edge_sets.items()
    }
