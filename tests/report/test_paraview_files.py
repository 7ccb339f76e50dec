"""Displacements and stresses in the axes of space, files for ParaView and series in time, read back."""

import xml.etree.ElementTree as ET

import meshio
import numpy as np
import pytest
from scipy.spatial import KDTree

from flangeway.cases import load_case
from flangeway.elements import Virtual
from flangeway.geometry import Placement
from flangeway.materials import Elastic
from flangeway.mesh import dual, rectangle_grid
from flangeway.post import Stresses, corner_stresses, stresses_at
from flangeway.problems import Elasticity, Traction, fixed
from flangeway.railway.track.placements import SIDES
from flangeway.report import part_fields
from flangeway.report.figures.display import (
    SeriesFrame,
    placed_stresses,
    solution_frame,
    write_contacts,
    write_frame,
    write_series,
)
from flangeway.report.scenes import write_part
from flangeway.report.viewer.scene_model import DISPLACEMENT
from flangeway.solve import ElasticitySolution, solve_elasticity
from flangeway.space import Space


def test_cells_and_values_come_back(runs, tmp_path):
    """Each file has the part's cells as polygons, with motion and stresses at their corners."""
    result = runs["vem"].result
    for number, part in enumerate(part_fields(result)):
        path = tmp_path / f"{part.name}.vtu"
        write_part(path, result, part.name)
        read = meshio.read(path)
        assert set(read.point_data) == {"displacement_mm", "stress_MPa", "von_mises_MPa"}
        assert set(read.cell_data) == {"cell_number", "body_id"}
        assert np.unique(np.concatenate(read.cell_data["body_id"])).tolist() == [number]
        mesh = part.mesh
        numbers = np.concatenate(
            [
                np.repeat(row, block.data.shape[1])
                for block, row in zip(read.cells, read.cell_data["cell_number"], strict=True)
            ]
        ).astype(int)
        corners = np.concatenate([block.data.ravel() for block in read.cells])
        assert sorted(numbers) == sorted(np.repeat(np.arange(mesh.n_cells), mesh.cell_sizes))
        points = KDTree(mesh.points).query(read.points[corners, :2])[1]
        assert np.allclose(read.points[corners, :2], mesh.points[points])
        assert np.allclose(read.point_data["displacement_mm"][corners, :2], part.point_arrays[DISPLACEMENT][points])
        stresses = Stresses(part.cell_arrays["stresses"][numbers])
        assert np.allclose(read.point_data["stress_MPa"][corners], stresses.tensors, atol=1e-9)
        assert np.allclose(read.point_data["von_mises_MPa"][corners], stresses.von_mises)


def test_pressures_along_the_surface_carry_the_load(tmp_path):
    """Integrated along the lines, pressures are the contact forces; gaps close there; the surface lies on its body."""
    run = load_case("wheelset-tangent", size_scale=3.0, primary="wheel").run()
    result = run.result
    write_contacts(tmp_path / "a.vtu", result.model.system, result.equilibrium.state, result.placements)
    read = meshio.read(tmp_path / "a.vtu")
    lines, bodies = read.cells_dict["line"], read.cell_data["body_id"][0]
    pressures, gaps = (read.point_data[name] for name in ("pressure_MPa", "gap_mm"))
    lengths = np.linalg.norm(np.diff(read.points[lines], axis=1)[:, 0], axis=1)
    for side in SIDES:
        name = f"rail-{side}"
        mine = bodies == list(result.placements).index(name)
        force = (pressures[lines[mine]].mean(axis=1) * lengths[mine]).sum() * result.model.problem.plane.thickness_mm
        assert force == pytest.approx(np.linalg.norm(result.force_on_wheel_N(side)), rel=0.02)
        mesh = result.model.parts[name].body.mesh.placed(result.placements[name])
        apart = np.linalg.norm(mesh.points[:, None] - read.points[lines[mine][:, 0], :2], axis=2).min(axis=0)
        assert apart.max() < 1e-9
    assert np.abs(gaps[pressures > 0.0]).max() < 1e-3
    assert (gaps[pressures == 0.0] > -1e-3).sum() > 20
    assert np.isnan(gaps).any() or (gaps[pressures == 0.0] > 0.05).any()


ROWS = np.array([[120.0, -40.0, 25.0, 24.0], [0.0, 0.0, -70.0, 0.0]])


def plane(row):
    return np.array([[row[0], row[2]], [row[2], row[1]]])


@pytest.mark.parametrize("mirrored", [False, True])
def test_tractions_turn_with_the_body(mirrored):
    """A placed stress gives on a placed normal the placed traction, also under a mirror; invariants stay."""
    placement = Placement(0.3, (5.0, -2.0), mirrored)
    moved = placed_stresses(Stresses(ROWS), placement)
    normal = np.array([0.6, 0.8])
    for before, after in zip(ROWS, moved.components, strict=True):
        expected = placement.vectors([plane(before) @ normal])[0]
        assert np.allclose(plane(after) @ placement.vectors([normal])[0], expected, atol=1e-12)
    assert np.allclose(moved.principal, Stresses(ROWS).principal, atol=1e-12)
    assert np.allclose(moved.von_mises, Stresses(ROWS).von_mises, atol=1e-12)


def test_left_parts_mirror_the_right_ones(runs):
    """The left part's points, displacements and stresses are the right one's, reflected about the track's middle."""
    parts = {part.name: part for part in part_fields(runs["vem"].result)}
    assert list(parts) == ["wheel-left", "rail-left", "wheel-right", "rail-right"]
    for body in ("wheel", "rail"):
        left, right = parts[f"{body}-left"], parts[f"{body}-right"]
        assert left.mesh.points[:, 0].max() < 0.0 < right.mesh.points[:, 0].min()
        assert np.allclose(left.mesh.points * (-1, 1), right.mesh.points, atol=1e-8)
        assert np.allclose(left.point_arrays[DISPLACEMENT] * (-1, 1), right.point_arrays[DISPLACEMENT], atol=1e-8)
        signs = (1, 1, -1, 1)
        of_left, of_right = (part.cell_arrays["stresses"] for part in (left, right))
        assert np.allclose(of_left * signs, of_right, atol=1e-6 * np.abs(of_right).max())
        assert (left.mesh.cell_areas > 0.0).all()


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
