"""PolyMesh and structured grids on meshes small enough to count by hand, and every fault that `check` looks for."""

import math
import re

import numpy as np
import pytest

from flangeway.errors import InputError
from flangeway.geometry import Placement
from flangeway.mesh import PolyMesh, check, rectangle_grid, refined

# a unit square cut into a triangle and a quadrilateral, with a fifth point on its right side
POINTS = np.array([[0.0, 0.0], [1.0, 0.0], [1.0, 0.5], [1.0, 1.0], [0.0, 1.0]])
MIXED = PolyMesh(
    POINTS,
    [0, 3, 7],
    [0, 1, 2, 0, 2, 3, 4],
    cell_sets={"low": [0]},
    edge_sets={"right": [[2, 3], [1, 2]], "left": [[4, 0]]},
)
PENTAGON = PolyMesh(POINTS, [0, 5], [0, 1, 2, 3, 4])


def test_counts_and_connections_by_hand():
    """A triangle beside a quadrilateral: six edges, one of them with both cells."""
    assert (MIXED.n_points, MIXED.n_cells, MIXED.n_edges) == (5, 2, 6)
    assert MIXED.edges.tolist() == [[0, 1], [0, 2], [0, 4], [1, 2], [2, 3], [3, 4]]
    assert MIXED.cell_edges.tolist() == [0, 3, 1, 1, 4, 5, 2]
    assert MIXED.edge_cells.tolist() == [[0, -1], [0, 1], [1, -1], [0, -1], [1, -1], [1, -1]]
    assert sorted(map(tuple, MIXED.boundary_edges)) == [(0, 1), (1, 2), (2, 3), (3, 4), (4, 0)]


def test_areas_centroids_and_diameters_by_hand():
    """Areas 1/4 and 3/4, centroids of triangle and trapezium, and the longest diagonals."""
    np.testing.assert_allclose(MIXED.cell_areas, [0.25, 0.75], rtol=1e-15)
    np.testing.assert_allclose(MIXED.cell_centroids, [[2 / 3, 1 / 6], [4 / 9, 11 / 18]], rtol=1e-14)
    np.testing.assert_allclose(MIXED.cell_diameters, [math.sqrt(1.25), math.sqrt(2)], rtol=1e-15)
    np.testing.assert_allclose(PENTAGON.cell_diameters, [math.sqrt(2)], rtol=1e-15)


def test_areas_keep_their_digits_far_from_the_origin():
    """A cell of size one at a distance of 1e6 has its area to ten digits."""
    far = MIXED.placed(Placement(0.0, (1e6, 1e6)))
    np.testing.assert_allclose(far.cell_areas, [0.25, 0.75], rtol=1e-10)
    np.testing.assert_allclose(far.cell_centroids - 1e6, MIXED.cell_centroids, atol=1e-9)


def test_batches_group_cells_by_their_number_of_points():
    """Every cell is in the batch of its number of points, and their points are its own."""
    mesh = MIXED.merged(PENTAGON).merged(MIXED)
    batches = {n: cells.tolist() for n, cells in mesh.batches()}
    assert batches == {3: [0, 3], 4: [1, 4], 5: [2]}
    assert mesh.batch_points(3, mesh.batches()[0][1]).tolist() == [[0, 1, 2], [10, 11, 12]]


def test_edges_are_chosen_by_name_box_and_line():
    """Edges are those of the names, with both ends in the box and on the lines; open sides of a box are infinite."""
    everything, right = MIXED.boundary_edges.tolist(), [[1, 2], [2, 3]]
    assert MIXED.edge_set().tolist() == everything
    assert MIXED.edge_set("right").tolist() == MIXED.edge_set(at_x=1.0).tolist() == right
    assert MIXED.edge_set(["left", "right"]).tolist() == [[4, 0], *right]
    assert MIXED.edge_set("right", within=(0.0, 0.0, 2.0, 0.5)).tolist() == right[:1]
    assert MIXED.edge_set(within=(-np.inf, 0.5, np.inf, np.inf)).tolist() == [[2, 3], [3, 4]]
    assert MIXED.edge_set(within=(0.0, 0.0, 0.5, 1.0), at_x=0.0).tolist() == [[4, 0]]
    top = MIXED.with_edge_set("top", MIXED.edge_set(at_y=1.0))
    assert top.edge_set("top").tolist() == [[3, 4]]


@pytest.mark.parametrize(
    ("names", "position", "message"),
    [
        ("rigt", {}, "edge set 'rigt'.*mean right"),
        ([], {}, "no edge set"),
        ("left", {"at_x": 1.0}, r"no edge of the boundary is there.*\(0, 0\) to \(1, 1\)"),
        (None, {"within": (0.0, 0.0, 1.0)}, "within"),
        (None, {"within": "rim"}, "within"),
    ],
)
def test_edges_that_are_not_there_are_refused(names, position, message):
    """An unknown name is answered by the nearest one, a position off the boundary by the reach of the boundary."""
    with pytest.raises(InputError) as refused:
        MIXED.edge_set(names, **position)
    assert re.search(message, str(refused.value), re.DOTALL)


def test_edge_sets_are_ordered_and_make_chains():
    """Edges given out of order come back in order along the boundary, as do several sets."""
    assert MIXED.chain("right").tolist() == [1, 2, 3]
    mesh = MIXED.with_edge_set("top", [[4, 3]])
    assert mesh.chain("left", "right", "top").tolist() == [1, 2, 3, 4, 0]


def test_closed_chain_repeats_its_first_point():
    """A chain once round the body ends where it starts."""
    ring = MIXED.with_edge_set("ring", MIXED.boundary_edges[::-1])
    points = ring.chain("ring")
    assert len(points) == 6
    assert points[0] == points[-1]
    assert sorted(points[1:]) == [0, 1, 2, 3, 4]


def test_with_edge_set_turns_edges_and_refuses_inner_ones():
    """A boundary edge given backwards is turned; an inner edge or no edge is refused."""
    mesh = MIXED.with_edge_set("bottom", [[1, 0]])
    assert mesh.edge_set("bottom").tolist() == [[0, 1]]
    assert "bottom" not in MIXED.edge_sets
    with pytest.raises(InputError, match="inside the body"):
        MIXED.with_edge_set("cut", [[0, 2]])
    with pytest.raises(InputError, match="ends of an edge"):
        MIXED.with_edge_set("cut", [[1, 3]])


def test_cell_sets_take_masks_and_numbers():
    """A mask and the numbers it is used for make the same set."""
    mask = MIXED.with_cell_set("high", MIXED.cell_centroids[:, 1] > 0.5)
    assert mask.cell_set("high").tolist() == [1]
    assert MIXED.with_cell_set("high", [1, 1]).cell_set("high").tolist() == [1]


@pytest.mark.parametrize("mirrored", [False, True])
def test_placed_mesh_stays_valid(mirrored):
    """A placed mesh keeps areas and names, also mirrored, with the body left of its edge sets."""
    placed = MIXED.placed(Placement(1.1, (5.0, -2.0), mirrored))
    check(placed, region_area=1.0, allow_hanging=False)
    np.testing.assert_allclose(placed.cell_areas, MIXED.cell_areas, rtol=1e-13)
    assert set(placed.chain("right")) == {1, 2, 3}
    back = placed.placed(Placement(1.1, (5.0, -2.0), mirrored).inverse())
    np.testing.assert_allclose(back.points, MIXED.points, atol=1e-14)
    assert back.chain("right").tolist() == MIXED.chain("right").tolist()


def test_merged_keeps_both_and_unites_names():
    """Of two meshes side by side, cells, areas and sets with one name are all there."""
    other = MIXED.placed(Placement(0.0, (3.0, 0.0))).with_cell_set("new", [0])
    both = MIXED.merged(other)
    assert (both.n_points, both.n_cells) == (10, 4)
    assert both.cell_sets["low"].tolist() == [0, 2]
    assert both.cell_sets["new"].tolist() == [2]
    assert both.edge_sets["left"].tolist() == [[4, 0], [9, 5]]
    check(both, region_area=2.0)


def test_arrays_are_read_only_copies():
    """Neither the mesh's arrays nor those it was made of can change it."""
    points = POINTS.copy()
    mesh = PolyMesh(points, [0, 5], [0, 1, 2, 3, 4], edge_sets={"left": [[4, 0]]})
    points[0] = 99.0
    assert mesh.points[0, 0] == 0.0
    for array in (mesh.points, mesh.cell_points, mesh.edges, mesh.edge_sets["left"]):
        with pytest.raises(ValueError, match="read-only"):
            array[0] = 1
    with pytest.raises(TypeError):
        mesh.edge_sets["more"] = mesh.edges
    assert mesh.cell_points.dtype == mesh.cell_offsets.dtype == mesh.edges.dtype == np.int32


def mesh_with(**changes):
    return PolyMesh(**({"points": POINTS, "cell_offsets": [0, 5], "cell_points": [0, 1, 2, 3, 4]} | changes))


@pytest.mark.parametrize(
    ("make", "word"),
    [
        (lambda: mesh_with(points=POINTS.T), r"\(2, 5\)"),
        (lambda: mesh_with(points=[[np.nan, 0.0]] * 5), "row 0"),
        (lambda: mesh_with(cell_points=[0, 1, 2, 3, 5]), "from 0 to 5"),
        (lambda: mesh_with(cell_points=[0.0, 1.0, 2.0, 3.0, 4.0]), "float64"),
        (lambda: mesh_with(cell_offsets=[0, 2, 5]), "row 0 with 2 entries"),
        (lambda: mesh_with(cell_offsets=[0, 4]), "cell_offsets"),
        (lambda: mesh_with(cell_offsets=[0]), "cell_offsets"),
        (lambda: mesh_with(cell_sets={"a": [1]}), "cell set 'a'"),
        (lambda: mesh_with(edge_sets={"a": [0, 1]}), "edge set 'a'"),
        (lambda: mesh_with(edge_sets={"a": [[0, 2], [0, 3]]}), "2 edges leave point 0"),
        (lambda: mesh_with(edge_sets={"a": [[0, 2], [1, 2]]}), "2 edges reach point 2"),
        (lambda: PolyMesh(POINTS, [0, 3, 6, 9], [0, 1, 2, 0, 1, 3, 0, 1, 4]).edge_cells, "3 cells"),
        (lambda: MIXED.chain("left", "right"), "2 chains"),
        (lambda: MIXED.edge_set("top"), "left, right"),
        (lambda: MIXED.cell_set("high"), "low"),
    ],
)
def test_wrong_arrays_chains_and_names_are_refused(make, word):
    """Wrong shapes, types, index ranges, branching or interrupted edge sets, three cells at an edge, unknown names."""
    with pytest.raises(InputError, match=word):
        make()


@pytest.mark.parametrize(("cells", "n_cells"), [("triangles", 12), ("quadrilaterals", 6)])
def test_grid_fills_the_rectangle(cells, n_cells):
    """A grid of 3 by 2 has 12 points, all cells of one area, and passes all checks."""
    mesh = rectangle_grid(6.0, 1.0, 3, 2, cells=cells, origin=(-1.0, 5.0))
    check(mesh, region_area=6.0)
    assert (mesh.n_points, mesh.n_cells) == (12, n_cells)
    np.testing.assert_allclose(mesh.cell_areas, 6.0 / n_cells, rtol=1e-14)
    assert mesh.points.min(axis=0).tolist() == [-1.0, 5.0]


def test_sides_run_counter_clockwise():
    """The four sides make one closed chain with the body on the left, each on its own line."""
    mesh = rectangle_grid(6.0, 1.0, 3, 2)
    assert len(mesh.chain("bottom", "right", "top", "left")) == 11
    assert mesh.points[mesh.chain("right")].tolist() == [[6.0, 0.0], [6.0, 0.5], [6.0, 1.0]]
    assert mesh.points[mesh.chain("top")][:, 0].tolist() == [6.0, 4.0, 2.0, 0.0]


def test_refined_cuts_every_triangle_into_four_equal_ones():
    """Refined triangles have a quarter of the area, sets keep their area and sides their length."""
    mesh = rectangle_grid(6.0, 1.0, 3, 2).with_cell_set("part", [1, 4])
    fine = refined(mesh)
    check(fine, region_area=6.0)
    np.testing.assert_allclose(fine.cell_areas, np.repeat(mesh.cell_areas / 4, 4), rtol=1e-14)
    assert fine.cell_sets["part"].tolist() == [4, 5, 6, 7, 16, 17, 18, 19]
    middles = fine.points[fine.chain("top")][1::2, 0]
    assert middles.tolist() == [5.0, 3.0, 1.0]


SOUND = rectangle_grid(2.0, 2.0, 2, 2, cells="quadrilaterals", origin=(10.0, 0.0))


def changed(**changes):
    fields = ("points", "cell_offsets", "cell_points", "cell_sets", "edge_sets")
    return PolyMesh(**{f: changes.get(f, getattr(SOUND, f)) for f in fields})


def cell_points(cell, points):
    given = SOUND.cell_points.copy()
    given[4 * cell : 4 * cell + 4] = points
    return given


def moved(point, x, y):
    points = SOUND.points.copy()
    points[point] = (x, y)
    return points


def test_a_sound_mesh_passes():
    """The mesh in which the faults are made has none."""
    check(SOUND, region_area=4.0)


@pytest.mark.parametrize(
    ("mesh", "message"),
    [
        (changed(points=np.vstack([SOUND.points, [(0.0, 7.0)]])), r"point 9 at \(0, 7\) of no"),
        (changed(points=moved(5, 11.0, 1.0)), r"same place \(11, 1\)"),
        (changed(cell_points=cell_points(0, [0, 3, 4, 1])), r"cell 0 near \(10.5, 0.5\) with area"),
        (changed(points=moved(4, 13.0, 1.2)), r"cell \d near .* (with area|cross)"),
        (changed(cell_points=cell_points(3, [4, 5, 8, 5])), "cell 3 near .* passes point 5 twice"),
        (changed(cell_points=cell_points(1, [0, 1, 2, 4])), r"cells \[0, 1\] on the same side"),
        (changed(edge_sets={"in": [[1, 4]]}), r"edge set 'in': \(1, 4\) near \(11, 0\)"),
    ],
    ids=["unused", "duplicate", "clockwise", "folded", "twice", "overlap", "inner"],
)
def test_faults_are_named_with_their_place(mesh, message):
    """Each fault is refused, and the message names the cell or point and where it is."""
    with pytest.raises(InputError, match=message):
        check(mesh)


def test_a_missing_cell_shows_in_the_area():
    """A mesh with a hole is sound in itself, and refused against the region's area."""
    grid = rectangle_grid(3.0, 3.0, 3, 3, cells="quadrilaterals")
    rows = np.delete(grid.cell_points.reshape(-1, 4), 4, axis=0)
    mesh = PolyMesh(grid.points, 4 * np.arange(9), rows.ravel())
    check(mesh)
    with pytest.raises(InputError, match="8 of area in a region of 9"):
        check(mesh, region_area=9.0)
    check(mesh, region_area=8.05, area_tolerance=0.01)
