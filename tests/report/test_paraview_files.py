"""Files for ParaView, read back."""

import xml.etree.ElementTree as ET

import meshio
import numpy as np
import pytest

from flangeway.post import Stresses
from flangeway.report import part_fields
from flangeway.report.figures.fields import write_part
from flangeway.report.figures.series import write_collection

COMPONENTS = [f"stress_{name}_MPa" for name in ("xx", "yy", "xy", "zz")]


@pytest.mark.parametrize("method", ["fem", "vem"])
def test_cells_and_values_come_back(runs, method, tmp_path):
    """Each file has the part's cells, as polygons for virtual elements, and its displacements and stresses."""
    for part in part_fields(runs[method].result):
        path = tmp_path / f"{part.name}.vtu"
        write_part(path, part)
        read = meshio.read(path)
        sizes = {block.data.shape[1]: len(block.data) for block in read.cells}
        assert sizes == {n: len(cells) for n, cells in part.mesh.batches()}
        assert {block.type for block in read.cells} == ({"triangle"} if method == "fem" else {"triangle", "polygon"} & {
            "polygon" if n > 3 else "triangle" for n in sizes
        })  # fmt: skip
        assert np.array_equal(read.points[:, :2], part.mesh.points)
        assert np.array_equal(read.point_data["displacement_mm"][:, :2], part.displacement)
        order = np.argsort(np.concatenate(read.cell_data["cell_number"]))
        cells = {name: np.concatenate(values)[order] for name, values in read.cell_data.items()}
        stresses = Stresses(np.column_stack([cells[name] for name in COMPONENTS]))
        assert np.array_equal(stresses.components, part.stresses.components)
        assert np.allclose(cells["von_mises_MPa"], stresses.von_mises)
        assert np.allclose(cells["max_in_plane_shear_MPa"], stresses.in_plane_shear)
        for i in range(3):
            assert np.allclose(cells[f"principal_{i + 1}_MPa"], stresses.principal[:, i])


def test_virtual_elements_are_polygons(runs, tmp_path):
    """Most cells of the virtual elements' file have more than four corners."""
    part = next(part_fields(runs["vem"].result))
    write_part(tmp_path / "a.vtu", part)
    blocks = meshio.read(tmp_path / "a.vtu").cells
    many = sum(len(block.data) for block in blocks if block.data.shape[1] > 4)
    assert many > 0.9 * part.mesh.n_cells


def test_the_collection_names_all_parts(tmp_path):
    """The collection is XML that names one file a part, numbered from zero."""
    write_collection(tmp_path / "all.pvd", [(0.0, "a", "a.vtu"), (0.0, "b & c", "b.vtu")])
    sets = ET.parse(tmp_path / "all.pvd").getroot().findall("Collection/DataSet")
    assert [(s.get("part"), s.get("name"), s.get("file")) for s in sets] == [
        ("0", "a", "a.vtu"),
        ("1", "b & c", "b.vtu"),
    ]
