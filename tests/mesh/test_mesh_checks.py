"""Every fault that `check` looks for, made on purpose in a sound mesh."""

import numpy as np
import pytest

from flangeway.errors import InputError
from flangeway.mesh import PolyMesh, check, rectangle_grid

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
