"""Structured grids against counting."""

import numpy as np
import pytest

from flangeway.mesh import check, rectangle_grid, refined


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
