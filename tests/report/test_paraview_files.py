"""Files for ParaView, read back."""

import meshio
import numpy as np
import pytest
from scipy.spatial import KDTree

from flangeway.cases import WheelsetTangentCase
from flangeway.post import Stresses
from flangeway.railway.track.placements import SIDES
from flangeway.report import part_fields
from flangeway.report.figures.fields import write_part
from flangeway.report.figures.series import write_contacts
from flangeway.report.viewer.scene_model import DISPLACEMENT


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
    run = WheelsetTangentCase.from_values({"size_scale": 3.0, "primary": "wheel"}).run()
    result = run.result
    write_contacts(tmp_path / "a.vtu", result.model.system, result.equilibrium.state, result.placements)
    read = meshio.read(tmp_path / "a.vtu")
    lines, bodies = read.cells_dict["line"], read.cell_data["body_id"][0]
    pressures, gaps = (read.point_data[name] for name in ("pressure_MPa", "gap_mm"))
    lengths = np.linalg.norm(np.diff(read.points[lines], axis=1)[:, 0], axis=1)
    for side in SIDES:
        name = f"rail-{side}"
        mine = bodies == list(result.placements).index(name)
        force = (pressures[lines[mine]].mean(axis=1) * lengths[mine]).sum() * result.model.problem.thickness_mm
        assert force == pytest.approx(np.linalg.norm(result.force_on_wheel_N(side)), rel=0.02)
        mesh = result.model.parts[name].body.mesh.placed(result.placements[name])
        apart = np.linalg.norm(mesh.points[:, None] - read.points[lines[mine][:, 0], :2], axis=2).min(axis=0)
        assert apart.max() < 1e-9
    assert np.abs(gaps[pressures > 0.0]).max() < 1e-3
    assert (gaps[pressures == 0.0] > -1e-3).sum() > 20
    assert np.isnan(gaps).any() or (gaps[pressures == 0.0] > 0.05).any()
