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


def test_a_cell_that_crosses_itself_is_found_though_its_area_is_positive():
    """A pentagon with a small knot has positive area and is refused for the sides that cross."""
    knot = [(0, 0), (4, 0), (4, 4), (-0.5, 3), (0.5, 3.5)]
    mesh = PolyMesh(np.array(knot, dtype=float), [0, 5], [0, 1, 2, 3, 4])
    assert mesh.cell_areas[0] > 0
    with pytest.raises(InputError, match="sides 2 and 4 cross"):
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


def test_a_hanging_point_is_found_unless_allowed_or_made_a_corner():
    """A point inside a neighbour's edge hangs; as a corner of that neighbour it does not."""
    points = np.array([(0, 0), (2, 0), (2, 1), (0, 1), (2, 2), (0, 2), (1, 1)], dtype=float)
    hanging = PolyMesh(points, [0, 4, 8, 11], [0, 1, 2, 3, 3, 6, 4, 5, 6, 2, 4])
    check(hanging, region_area=4.0, allow_hanging=True)
    with pytest.raises(InputError, match=r"point 6 at \(1, 1\) hangs on the edge \(2, 3\)"):
        check(hanging)
    corner = PolyMesh(points, [0, 5, 9, 12], [0, 1, 2, 6, 3, 3, 6, 4, 5, 6, 2, 4])
    check(corner, region_area=4.0)
