"""Cells along straight lines, beside the search for one point after the other."""

import numpy as np
import pytest

from flangeway.geometry import Arc, Line, Outline
from flangeway.mesh import PolyMesh, dual, rectangle_grid, triangulate
from flangeway.post.lines import OUTSIDE, locate
from flangeway.railway.positions.line_stresses import cells_along

HOLLOW = Outline(
    (
        Line((-6.0, -6.0), (6.0, -6.0)),
        Line((6.0, -6.0), (6.0, 6.0)),
        Line((6.0, 6.0), (3.0, 6.0)),
        Arc((3.0, 6.0), (-3.0, 6.0), (0.0, 6.0), counter_clockwise=False),
        Line((-3.0, 6.0), (-6.0, 6.0)),
        Line((-6.0, 6.0), (-6.0, -6.0)),
    ),
    ("bottom", "right", "top right", "hollow", "top left", "left"),
)
"""A square with a half disc cut out of its top."""


@pytest.fixture(scope="module", params=["triangles", "polygons"])
def mesh(request: pytest.FixtureRequest) -> PolyMesh:
    """Cells of two kinds; those of the dual mesh need not be convex."""
    triangles = triangulate(HOLLOW, size=0.7)
    return triangles if request.param == "triangles" else dual(triangles)


def test_cells_are_those_of_each_point(mesh: PolyMesh) -> None:
    """500 lines of random places, directions and lengths, which leave the body and come back, are in the same cells."""
    rng = np.random.default_rng(3)
    starts = rng.uniform(-7.0, 7.0, (500, 2))
    angles = rng.uniform(0.0, 2.0 * np.pi, 500)
    directions = np.stack((np.cos(angles), np.sin(angles)), axis=1)
    distances = np.linspace(0.0, rng.uniform(0.5, 20.0, 500), 101, axis=1)
    found = cells_along(mesh, starts, directions, distances)
    points = starts[:, None] + distances[..., None] * directions[:, None]
    expected = locate(mesh, points.reshape(-1, 2)).reshape(found.shape)
    np.testing.assert_array_equal(found, expected)
    inside = found != OUTSIDE
    times_inside = inside[:, 0] + np.count_nonzero(inside[:, 1:] & ~inside[:, :-1], axis=1)
    assert np.count_nonzero(times_inside == 2) > 10


def test_a_line_may_begin_on_the_surface(mesh: PolyMesh) -> None:
    """From ends and inner points of boundary edges inwards, all points are in the body."""
    edges = mesh.boundary_edges
    first, second = mesh.points[edges].swapaxes(0, 1)
    along = (second - first) / np.linalg.norm(second - first, axis=1)[:, None]
    inward = np.stack((-along[:, 1], along[:, 0]), axis=1)
    before = inward[np.argsort(edges[:, 1])][np.argsort(np.argsort(edges[:, 0]))]
    between = (inward + before) / np.linalg.norm(inward + before, axis=1)[:, None]
    starts, directions = np.concatenate((0.7 * first + 0.3 * second, first)), np.concatenate((inward, between))
    distances = np.tile(np.linspace(0.0, 0.5, 6), (len(starts), 1))
    found = cells_along(mesh, starts, directions, distances)
    assert (found != OUTSIDE).all()
    # lines from ends may run along the edges between two cells; points of the others are in the cells of each alone
    n_edges = len(edges)
    points = starts[:n_edges, None] + distances[:n_edges, 1:, None] * directions[:n_edges, None]
    np.testing.assert_array_equal(found[:n_edges, 1:].ravel(), locate(mesh, points.reshape(-1, 2)))


@pytest.mark.parametrize("angle", [0.0, 0.25, 0.5, 0.75, 1.0, 1.5])
def test_lines_along_edges_and_through_corners_have_a_cell_at_each_point(angle: float) -> None:
    """Along a grid's edges and diagonals each point lies in a cell that it touches, and none is lost."""
    grid = rectangle_grid(4.0, 4.0, 4, 4)
    turn = np.array([np.cos(np.pi * angle), np.sin(np.pi * angle)])
    distances = np.linspace(0.0, 1.9, 20)[None]
    found = cells_along(grid, np.array([[2.0, 2.0]]), turn[None], distances)[0]
    centres = grid.cell_centroids[found]
    points = np.array([2.0, 2.0]) + distances[0][:, None] * turn
    assert (found != OUTSIDE).all()
    assert np.abs(points - centres).max() < 2.0 / 3.0 + 1e-9


def test_no_cell_far_from_the_mesh(mesh: PolyMesh) -> None:
    """Lines beside the mesh are in no cell."""
    distances = np.tile(np.linspace(0.0, 2.0, 5), (2, 1))
    found = cells_along(mesh, np.array([[20.0, 0.0], [0.0, 7.0]]), np.array([[1.0, 0.0], [0.0, 1.0]]), distances)
    assert (found == OUTSIDE).all()
