"""VTU files, read back."""

import meshio
import numpy as np
import pytest

from flangeway.errors import InputError
from flangeway.formats import write_vtu
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


@pytest.mark.parametrize(
    ("name", "points", "cells", "word"),
    [
        ("a.vtk", {}, {}, ".vtu"),
        ("a.vtu", {"u": np.zeros((2, 9))}, {}, r"shape \(2, 9\)"),
        ("a.vtu", {}, {"area": np.zeros(9)}, "cells"),
        ("a.vtu", {}, {"cell_number": np.zeros(8)}, "rename"),
    ],
)
def test_wrong_data_are_refused(tmp_path, name, points, cells, word):
    """Another ending, arrays of another length and a reserved name are refused."""
    with pytest.raises(InputError, match=word):
        write_vtu(tmp_path / name, rectangle_grid(1.0, 1.0, 2, 2), points, cells)
