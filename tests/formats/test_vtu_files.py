"""VTU files, read back."""

import meshio
import numpy as np
import pytest

from flangeway.errors import InputError
from flangeway.formats import write_vtu, write_vtu_lines
from flangeway.mesh import dual, rectangle_grid


def test_polygons_and_values_come_back(tmp_path):
    """Cells, their numbers, and values of a mesh of 4-, 5- and 6-gons are read back as written."""
    mesh = dual(rectangle_grid(2.0, 1.0, 5, 4))
    file = tmp_path / "cells.vtu"
    write_vtu(file, mesh, {"motion": 2.0 * mesh.points}, {"area": mesh.cell_areas})
    read = meshio.read(file)
    assert {(b.type, b.data.shape[1]) for b in read.cells} == {
        ("polygon", 4),
        ("polygon", 5),
        ("polygon", 6),
    }
    assert np.array_equal(read.points[:, :2], mesh.points)
    assert np.array_equal(read.point_data["motion"][:, :2], 2.0 * mesh.points)
    assert not read.point_data["motion"][:, 2].any()
    numbers = np.concatenate(read.cell_data["cell_number"])
    assert sorted(numbers) == list(range(mesh.n_cells))
    assert np.array_equal(np.concatenate(read.cell_data["area"]), mesh.cell_areas[numbers])
    for block, rows in zip(read.cells, read.cell_data["cell_number"], strict=True):
        expected = mesh.batch_points(block.data.shape[1], rows)
        assert np.array_equal(block.data, expected)


def test_triangles_are_triangles_in_a_small_file(tmp_path):
    """Triangles are written as VTK triangles, and binary: less than 30 bytes a triangle."""
    mesh = rectangle_grid(2.0, 1.0, 60, 60)
    file = tmp_path / "triangles.vtu"
    write_vtu(str(file), mesh)
    assert [b.type for b in meshio.read(file).cells] == ["triangle"]
    assert file.stat().st_size < 30 * mesh.n_cells


def test_lines_come_back(tmp_path):
    """Lines have their points in space, values at both ends, numbers and bodies; none of them is a file too."""
    points, lines = np.array([[0.0, 0.0], [1.0, 2.0], [3.0, 2.0]]), np.array([[0, 1], [1, 2]])
    write_vtu_lines(tmp_path / "a.vtu", points, lines, {"gap": [1.0, np.nan, 3.0]}, body_id=[4, 5])
    read = meshio.read(tmp_path / "a.vtu")
    assert np.array_equal(read.points, np.column_stack([points, np.zeros(3)]))
    assert np.array_equal(read.cells_dict["line"], lines)
    np.testing.assert_array_equal(read.point_data["gap"], [1.0, np.nan, 3.0])
    assert {name: values[0].tolist() for name, values in read.cell_data.items()} == {
        "cell_number": [0, 1],
        "body_id": [4, 5],
    }
    with pytest.raises(InputError, match="one row for each of the points"):
        write_vtu_lines(tmp_path / "a.vtu", points, lines, {"gap": np.zeros(2)})
