"""Dual polygons against their definition (seed, section 3.3.6)."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.spatial import Delaunay

from flangeway.errors import InputError
from flangeway.mesh import PolyMesh, check, dual, rectangle_grid


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


@st.composite
def triangulations(draw):
    rng = np.random.default_rng(draw(st.integers(0, 10**6)))
    n = draw(st.integers(3, 12))
    grid = rectangle_grid(1.0, 1.0, n, n)
    inner = np.all((grid.points > 0.0) & (grid.points < 1.0), axis=1)
    shift = rng.uniform(-0.28, 0.28, grid.points.shape) / n
    points = grid.points + inner[:, None] * shift
    triangles = Delaunay(points).simplices
    a, b, c = (points[triangles[:, i]] for i in range(3))
    twice = (b - a)[:, 0] * (c - a)[:, 1] - (b - a)[:, 1] * (c - a)[:, 0]
    triangles = triangles[np.abs(twice) > 1e-12]
    twice = twice[np.abs(twice) > 1e-12]
    triangles[twice < 0] = triangles[twice < 0][:, ::-1]
    edge_sets = {name: grid.edge_sets[name] for name in ("bottom", "left")}
    offsets = np.arange(len(triangles) + 1) * 3
    return PolyMesh(points, offsets, triangles.ravel(), edge_sets=edge_sets)


@given(triangulations())
def test_dual_of_any_triangulation_fills_the_body(mesh):
    """Cells are simple, positive and fill the body; each holds its own point and centroids."""
    cells = dual(mesh)
    check(cells, region_area=1.0)
    assert cells.n_cells == mesh.n_points
    rim = np.zeros(mesh.n_points, dtype=bool)
    rim[mesh.boundary_edges.ravel()] = True
    about = np.bincount(mesh.cell_points, minlength=mesh.n_points)
    assert np.array_equal(cells.cell_sizes, about + 3 * rim)
    for cell in np.flatnonzero(rim).tolist():
        assert np.array_equal(corners(cells, cell)[0], mesh.points[cell])


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
