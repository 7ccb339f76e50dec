"""Files for ParaView: orders shown, jumps kept, and series in time."""

import xml.etree.ElementTree as ET

import meshio
import numpy as np
import pytest

from flangeway.elements import Virtual
from flangeway.materials import Elastic
from flangeway.mesh import dual, rectangle_grid
from flangeway.post import corner_stresses, stresses_at
from flangeway.problems import Elasticity, Traction, fixed
from flangeway.report.figures.series import SeriesFrame, solution_frame, write_frame, write_series
from flangeway.solve import ElasticitySolution, solve_elasticity
from flangeway.space import Space

MESH = dual(rectangle_grid(3.0, 1.0, 6, 3))


def bent(order: int, load: float = 1.0) -> ElasticitySolution:
    """A beam held at the left with a shear load on the right."""
    return solve_elasticity(
        Elasticity(
            Space(MESH, Virtual(order)),
            Elastic(1e3, 0.3),
            loads=[Traction("right", (0.0, load))],
            supports=[fixed("left")],
        )
    )


def test_order_1_is_written_as_polygons_with_stresses_that_jump(tmp_path):
    """Each cell has points of its own, with its own stress at each and the displacement of the mesh's point."""
    solution = bent(1)
    write_frame(tmp_path / "a.vtu", solution_frame(solution))
    read = meshio.read(tmp_path / "a.vtu")
    assert {block.type for block in read.cells} == {"polygon"}
    assert len(read.points) == len(MESH.cell_points)
    own = corner_stresses(solution.problem, solution.displacements)
    np.testing.assert_array_equal(read.point_data["stress"], own.tensors)
    np.testing.assert_array_equal(read.point_data["von_mises"], own.von_mises)
    moved = solution.displacements[MESH.cell_points]
    np.testing.assert_array_equal(read.point_data["displacement"][:, :2], moved)


@pytest.mark.parametrize(("order", "pieces"), [(2, None), (3, None)])
def test_higher_orders_are_cut_into_triangles(tmp_path, order, pieces):
    """Sides are cut into as many pieces as the order; values at middles of triangles are near to post's."""
    solution = bent(order)
    frame = solution_frame(solution, pieces=pieces)
    write_frame(tmp_path / "a.vtu", frame)
    read = meshio.read(tmp_path / "a.vtu")
    (block,) = read.cells
    assert block.type == "triangle"
    assert len(block.data) == len(MESH.cell_points) * (pieces or order) ** 2
    corners = read.points[block.data][:, :, :2]
    cells = read.cell_data["cell_number"][0]
    areas = frame.mesh.cell_areas
    np.testing.assert_allclose(np.bincount(cells, areas), MESH.cell_areas, rtol=1e-12)
    middle = read.point_data["stress"][:, 0][block.data].mean(axis=1)
    wanted = stresses_at(solution, corners.mean(axis=1)).components[:, 0]
    if order <= 2:  # linear within a cell
        np.testing.assert_allclose(middle, wanted, atol=1e-9 * np.abs(wanted).max())
    else:
        assert np.abs(middle - wanted).max() < 0.05 * np.abs(wanted).max()


def test_a_series_opens_all_its_files_in_time(tmp_path):
    """The PVD names every file with its time, number and part, and is whole after each frame."""
    file = tmp_path / "load.pvd"

    def frames():
        for step in range(3):
            if step:
                assert len(ET.parse(file).getroot().findall("Collection/DataSet")) == 2 * step
            yield solution_frame(bent(1, step), step / 4, part="beam & co")
            yield SeriesFrame(step / 4, MESH, {"x": MESH.points[:, 0]}, part="copy")

    written = write_series(file, frames())
    assert [path.name for path in written] == [f"load_{i:04d}.vtu" for i in range(6)]
    rows = [row.attrib for row in ET.parse(file).getroot().findall("Collection/DataSet")]
    assert [float(row["timestep"]) for row in rows] == [0.0, 0.0, 0.25, 0.25, 0.5, 0.5]
    assert [row["part"] for row in rows] == ["0", "1"] * 3
    assert rows[0]["name"] == "beam & co"
    maximum = [np.abs(meshio.read(tmp_path / row["file"]).point_data["displacement"]).max() for row in rows[::2]]
    bodies = [
        np.unique(np.concatenate(meshio.read(tmp_path / row["file"]).cell_data["body_id"])).tolist() for row in rows
    ]
    assert bodies == [[int(row["part"])] for row in rows]
    assert maximum[0] == 0.0
    assert maximum[2] == pytest.approx(2.0 * maximum[1])
    assert sorted(path.name for path in tmp_path.iterdir()) == sorted(["load.pvd", *(p.name for p in written)])
