"""Voronoi polygons, quadtrees, agglomerated and dual polygons: sound, by definition, with the patch test passed."""

import numpy as np
import pytest
from hypothesis import assume, given, settings
from hypothesis import strategies as st

from flangeway.elements import Virtual
from flangeway.errors import InputError
from flangeway.forms import interpolate, load, mass, solve, stiffness
from flangeway.geometry import Arc, Line, Outline, circle, polygon, square
from flangeway.mesh import PolyMesh, agglomerated, check, curved, dual, quadtree, rectangle_grid, triangulate, voronoi
from flangeway.space import Space

PENTAGON = polygon([(0.0, 0.0), (2.0, 0.0), (4.0, 0.0), (5.0, 2.0), (2.0, 4.0)], ["a", "b", "c", "d", "e"])


def near_corner(centres, sides):
    return np.hypot(*centres.T) < 1.5 * sides


MESHES = {
    "voronoi": lambda: voronoi(square(1.0, (0.5, 0.5)), 30, iterations=2),
    "voronoi of random points": lambda: voronoi(square(1.0, (0.5, 0.5)), 30, iterations=0),
    "voronoi in a pentagon": lambda: voronoi(PENTAGON, 25),
    "quadtree": lambda: quadtree(1.0, 1.0, 2, 2, finer=near_corner, levels=4),
    "agglomerated triangles": lambda: agglomerated(triangulate(square(1.0), size=0.12), 20),
    "agglomerated squares": lambda: agglomerated(rectangle_grid(1.0, 1.0, 8, 8, cells="quadrilaterals"), 12),
}
AREAS = dict.fromkeys(MESHES, 1.0) | {"voronoi in a pentagon": PENTAGON.area}


@pytest.mark.parametrize("name", MESHES)
def test_the_mesh_is_sound_and_the_patch_test_is_passed(name):
    """Cells are simple and fill the area; polynomials of degree k are found to round-off, k = 1 to 3."""
    mesh = MESHES[name]()
    check(mesh, region_area=AREAS[name])
    for order in (1, 2, 3):

        def exact(p, order=order):
            return (0.3 * p[:, 0] + 0.5 * p[:, 1]) ** order + p[:, 0]

        def source(p, order=order):
            return (
                -0.34 * order * (order - 1) * (0.3 * p[:, 0] + 0.5 * p[:, 1]) ** (order - 2)
                if order > 1
                else 0 * p.T[0]
            )

        space = Space(mesh, Virtual(order))
        wanted = interpolate(space, exact)
        found = solve(stiffness(space), load(space, source), space.boundary_dofs(), wanted)
        np.testing.assert_allclose(found, wanted, atol=1e-10 * np.abs(wanted).max())


def test_voronoi_cells_are_nearest_to_their_points():
    """Every vertex of a cell is as near to the cell's point as to the nearest one; sides have the outline's names."""
    points = np.random.default_rng(3).random((20, 2))
    mesh = voronoi(square(1.0, (0.5, 0.5)), points, iterations=0)
    apart = np.linalg.norm(mesh.points[:, None] - points, axis=2)
    for cell in range(20):
        own = mesh.cell_points[mesh.cell_offsets[cell] : mesh.cell_offsets[cell + 1]]
        np.testing.assert_allclose(apart[own, cell], apart[own].min(axis=1), atol=1e-12)
    assert sorted(voronoi(PENTAGON, 9).edge_sets) == ["a", "b", "c", "d", "e"]
    assert np.linalg.norm(voronoi(PENTAGON, 9).points - [2.0, 0.0], axis=1).min() == 0.0


SLOTTED = polygon([(0, 0), (3, 0), (3, 4), (2, 4), (2, 1), (1, 1), (1, 4), (0, 4)])


@pytest.mark.parametrize("iterations", [0, 8])
def test_voronoi_cells_fill_an_outline_with_reentrant_corners(iterations):
    """The area is the outline's, sides have its names, and the mesh is of one piece without holes."""
    mesh = voronoi(SLOTTED, 40, iterations=iterations)
    check(mesh, region_area=SLOTTED.area, area_tolerance=1e-12)
    assert len(mesh.edge_sets) == 8
    assert mesh.n_points - mesh.n_edges + mesh.n_cells == 1


def test_a_piece_of_a_cell_behind_a_slot_gets_a_cell_of_its_own():
    """Points in one arm of a U: what is nearest to the upper one in the other arm is no part of its cell."""
    points = np.array([[0.5, 3.5], [0.5, 0.5]])
    mesh = voronoi(SLOTTED, points, iterations=0)
    assert mesh.n_cells == 3
    check(mesh, region_area=SLOTTED.area, area_tolerance=1e-12)
    assert mesh.cell_centroids[2, 0] > 2.0
    assert (mesh.cell_centroids[:2, 0] < 2.0).all()


def test_voronoi_cells_in_a_circle_have_their_vertices_on_it():
    """The boundary is made of chords; with curved edges the area is the circle's to the order of the edges."""
    outline = circle(1.0)
    mesh = voronoi(outline, 60)
    rim = mesh.points[np.unique(mesh.boundary_edges)]
    np.testing.assert_allclose(np.hypot(*rim.T), 1.0, rtol=1e-12)
    assert len(mesh.edge_set("circle")) == len(mesh.boundary_edges) < 60
    bent = curved(mesh, outline)
    space = Space(bent, Virtual(4))
    ones = interpolate(space, lambda p: np.ones(len(p)))
    assert ones @ (mass(space) @ ones) == pytest.approx(np.pi, rel=1e-5)


def test_cells_are_graded_like_a_size_field():
    """The root of the area over the size is the same everywhere within 30 %, where sizes differ 20 times."""

    def size(p):
        return 0.02 + 0.3 * np.hypot(*p.T)

    mesh = voronoi(polygon([(0, 0), (1, 0), (1, 1), (0, 1)]), 400, size=size, iterations=30)
    ratio = np.sqrt(mesh.cell_areas) / size(mesh.cell_centroids)
    assert np.percentile(ratio, 95) < 1.3 * np.percentile(ratio, 5)
    assert ratio.max() < 1.6 * ratio.min()


def test_a_quadtree_is_fine_where_the_function_says():
    """Sides halve from level to level towards the corner; cells beside finer ones have more than four points."""
    mesh = MESHES["quadtree"]()
    assert mesh.cell_areas.min() == pytest.approx(0.25 * 4.0**-4)
    assert mesh.n_cells == 4 + 3 * 4
    assert sorted(np.unique(mesh.cell_sizes)) == [4, 5]
    steep = quadtree(1.0, 1.0, 2, 1, finer=lambda c, _: c[:, 0] < 0.5, levels=3)
    assert steep.cell_sizes.max() == 4 + 7
    counts = {name: len(pairs) for name, pairs in steep.edge_sets.items()}
    assert counts == {
        "bottom": 9,
        "right": 1,
        "top": 9,
        "left": 8,
    }


def test_agglomerated_polygons_keep_area_sets_and_the_boundary():
    """Of 100 triangles ten polygons are left or some more; a cell set keeps its area, an edge set its edges."""
    mesh = triangulate(circle(1.0), size=0.2)
    mesh = mesh.with_cell_set("left", mesh.cell_centroids[:, 0] < 0.0)
    joined = agglomerated(mesh, 10)
    check(joined, region_area=mesh.cell_areas.sum())
    assert joined.n_cells == 10
    for part in (joined, mesh):
        assert part.cell_areas[part.cell_set("left")].sum() == pytest.approx(
            mesh.cell_areas[mesh.cell_set("left")].sum()
        )
    assert len(joined.edge_set("circle")) == len(mesh.edge_set("circle"))
    assert agglomerated(mesh, 1).n_cells == 2
    ring = agglomerated(rectangle_grid(3.0, 3.0, 3, 3).with_cell_set("hole", [8, 9]), 1)
    check(ring, region_area=9.0)
    assert ring.n_cells > 2  # a ring would have a hole


WRONG = {
    "sizes of shape": lambda: voronoi(square(1.0), 5, size=lambda p: 1.0),
    "not positive": lambda: voronoi(square(1.0), 5, size=lambda p: -(p[:, 0] ** 2)),
    "inside the outline": lambda: voronoi(square(1.0), [(5.0, 0.0), (0.1, 0.1)]),
    "at one place": lambda: voronoi(square(1.0), [(0.1, 0.1), (0.1, 0.1)]),
    "number of cells": lambda: voronoi(square(1.0), 0),
    "iterations": lambda: voronoi(square(1.0), 4, iterations=-1),
    "truth value": lambda: quadtree(1.0, 1.0, 2, 2, finer=lambda c, _: c),
    "levels": lambda: quadtree(1.0, 1.0, 2, 2, finer=near_corner, levels=99),
    "width": lambda: quadtree(0.0, 1.0, 2, 2, finer=near_corner),
    "cells": lambda: agglomerated(rectangle_grid(1.0, 1.0, 2, 2), 9),
}


@pytest.mark.parametrize("words", WRONG)
def test_wrong_input_is_named(words):
    """Each error says what was wrong."""
    with pytest.raises(InputError, match=words):
        WRONG[words]()


def corners(mesh, cell):
    row = slice(mesh.cell_offsets[cell], mesh.cell_offsets[cell + 1])
    return mesh.points[mesh.cell_points[row]]


def test_dual_of_one_triangle_by_hand():
    """A triangle gives three quadrilaterals: corner, middle, centre of gravity, middle."""
    mesh = PolyMesh([[0.0, 0.0], [6.0, 0.0], [0.0, 6.0]], [0, 3], [0, 1, 2])
    cells = dual(mesh)
    assert corners(cells, 0).tolist() == [[0, 0], [3, 0], [2, 2], [0, 3]]
    assert corners(cells, 1).tolist() == [[6, 0], [3, 3], [2, 2], [3, 0]]
    np.testing.assert_allclose(cells.cell_areas, 6.0)


def test_outline_and_edge_sets_survive():
    """Boundary points are kept, every boundary edge is halved, and sets keep order and length."""
    mesh = rectangle_grid(4.0, 2.0, 4, 3)
    cells = dual(mesh)
    assert len(cells.boundary_edges) == 2 * len(mesh.boundary_edges)
    for name in mesh.edge_sets:
        coarse, fine = mesh.points[mesh.chain(name)], cells.points[cells.chain(name)]
        assert np.array_equal(fine[::2], coarse)
        np.testing.assert_allclose(fine[1::2], 0.5 * (coarse[1:] + coarse[:-1]))
    middles = np.array([cells.edge_cells[e] for e in cells.edge_numbers(cells.edge_set("top"))])
    assert middles[:, 0].tolist() == [19, 18, 18, 17, 17, 16, 16, 15]


FLAT = PolyMesh([[0.0, 0.0], [10.0, -7.0], [0.0, 0.5], [-10.0, -7.0]], [0, 3, 6], [0, 1, 2, 0, 2, 3])


@pytest.mark.parametrize(
    ("mesh", "word"),
    [
        (FLAT, r"point 0 at .*flat"),
        (rectangle_grid(1.0, 1.0, 2, 2, cells="quadrilaterals"), "4 points"),
        (PolyMesh([[0, 0], [0, 1], [1, 0]], [0, 3], [0, 1, 2]), "area -"),
        (
            PolyMesh([[0, 0], [1, 0], [0, 1], [-1, 0], [0, -1]], [0, 3, 6], [0, 1, 2, 0, 3, 4]),
            r"point 0 at .*touches itself",
        ),
    ],
)
def test_triangles_without_a_dual_are_refused_with_their_place(mesh, word):
    """Very flat ones at a reentrant corner, quadrilaterals, clockwise ones, and two that share one point only."""
    check(FLAT)
    with pytest.raises(InputError, match=word):
        dual(mesh)


def test_cell_sets_are_carried_only_where_they_are_clear():
    """A set of all cells of one body of two is carried; one that divides a point is refused."""
    left, right = rectangle_grid(1.0, 1.0, 2, 2), rectangle_grid(1.0, 1.0, 3, 3, origin=(5.0, 0.0))
    both = left.merged(right).with_cell_set("left", np.arange(left.n_cells))
    cells = dual(both)
    assert cells.cell_sets["left"].tolist() == list(range(9))
    with pytest.raises(InputError, match=r"cell set 'low' with .* triangles of point"):
        dual(left.with_cell_set("low", [0, 1]))


@st.composite
def outlines(draw):
    """Star of 3 to 9 sides about a point, some of them arcs of up to half of their chord in height."""
    n = draw(st.integers(3, 9))
    radii = np.array(draw(st.lists(st.floats(0.3, 1.0), min_size=n, max_size=n)))
    bulges = draw(st.lists(st.sampled_from([0.0, 0.0, 0.02, -0.02, 0.15, -0.15, 0.4]), min_size=n, max_size=n))
    size = draw(st.sampled_from([1e-2, 1.0, 1e3]))
    angles = draw(st.floats(0.0, 6.0)) + 2.0 * np.pi * np.arange(n) / n
    corners = size * radii[:, None] * np.column_stack((np.cos(angles), np.sin(angles)))
    corners += size * np.array(draw(st.tuples(st.floats(-20.0, 20.0), st.floats(-20.0, 20.0))))
    ends = np.roll(corners, -1, axis=0)
    return [side(*each) for each in zip(corners, ends, bulges, strict=True)]


def side(start, end, bulge):
    """Line, or the arc whose height over its chord is `bulge` chords, outwards if positive."""
    if bulge == 0.0:
        return Line(tuple(start), tuple(end))
    chord = end - start
    outwards = np.array([chord[1], -chord[0]])
    height = abs(bulge)
    to_centre = (0.25 / height - height) / 2.0
    centre = (start + end) / 2.0 - np.sign(bulge) * to_centre * outwards
    return Arc(tuple(start), tuple(end), tuple(centre), counter_clockwise=bulge > 0.0)


def drawn(segments):
    """Outline, or None where the arcs of a star meet each other, which must be reported in three parts."""
    refused = None
    try:
        return Outline.from_segments(segments, [f"side {i}" for i in range(len(segments))])
    except InputError as error:
        refused = error
    assert refused.given
    assert refused.allowed
    assert refused.advice
    return None


@settings.get_profile("costly")
@given(segments=outlines(), fineness=st.sampled_from([2.0, 5.0, 12.0]))
def test_meshes_of_random_outlines_keep_the_area(segments, fineness):
    """Triangles and their dual fill the polygon of the boundary points; these are on the outline, names and all.

    The area is the outline's up to what chords cut off its arcs. A dual cell at the boundary begins with its own point,
    and has a centroid of each triangle about it.
    """
    outline = drawn(segments)
    assume(outline is not None)  # too many refusals fail Hypothesis' health check
    size = outline.size / fineness
    mesh = triangulate(outline, size=size)
    assert (mesh.cell_areas > 0.0).all()
    assert set(mesh.edge_sets) == set(outline.names)
    rim = mesh.points[mesh.boundary_edges]
    rim = rim - mesh.points[0]  # the area keeps its digits
    within = float(np.sum(rim[:, 0, 0] * rim[:, 1, 1] - rim[:, 1, 0] * rim[:, 0, 1])) / 2.0
    polygons = dual(mesh)
    check(mesh, region_area=within)
    check(polygons, region_area=within)
    assert polygons.cell_areas.sum() == pytest.approx(mesh.cell_areas.sum(), rel=1e-10)
    assert polygons.n_cells == mesh.n_points
    ends = np.isin(np.arange(mesh.n_points), mesh.boundary_edges)
    assert np.array_equal(polygons.cell_sizes, np.bincount(mesh.cell_points, minlength=mesh.n_points) + 3 * ends)
    for cell in np.flatnonzero(ends).tolist():
        assert np.array_equal(corners(polygons, cell)[0], mesh.points[cell])
    _, _, distances = outline.closest(mesh.points[mesh.boundary_edges[:, 0]])
    assert np.abs(distances).max() < 1e-9 * outline.size
    sides = zip(outline.segments, outline.names, strict=True)
    cut_off = sum(maximum_cut(segment, mesh, name) for segment, name in sides)
    assert abs(within - outline.area) <= cut_off + 1e-9 * outline.area


def maximum_cut(segment, mesh, name):
    """Area between an arc and the chords of its edges, (r^2 / 2) (t - sin t) of each."""
    if isinstance(segment, Line):
        return 0.0
    edges = mesh.points[mesh.edge_sets[name]]
    radius = np.hypot(*np.subtract(segment.start, segment.centre))
    lengths = np.hypot(*(edges[:, 1] - edges[:, 0]).T)
    turns = 2.0 * np.arcsin(np.minimum(lengths / (2.0 * radius), 1.0))
    return float(np.sum(radius**2 / 2.0 * (turns - np.sin(turns))) * (1.0 + 1e-6))
