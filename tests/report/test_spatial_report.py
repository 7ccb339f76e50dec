"""Files and report of two bodies in contact in three dimensions."""

import meshio
import numpy as np
import pytest

from flangeway.cases import load_case
from flangeway.report.case_outputs import write_case


@pytest.fixture(scope="module")
def run():
    """A cylinder across another one, on coarse elements."""
    return load_case("crossed-cylinders", order=1, angle_deg=60.0, upper_radius_mm=30.0).run()


def test_files_hold_the_force_and_the_stresses(run, tmp_path):
    """All files are there; pressure times area is the force, also on the surface in space; stresses are Hertz's."""
    files = write_case(run, tmp_path)
    page = (tmp_path / "report.html").read_text(encoding="utf-8")
    assert f"{run.summary['patches'][0]['max_pressure_MPa']:.1f}" in page
    assert {file.name for file in files} == {
        *("patch.png", "depth.png", "surface.vtu", "section-lower.vtu", "section-upper.vtu"),
        *("bodies.pvd", "report.html", "summary.json"),
    }
    surface = meshio.read(tmp_path / "surface.vtu")
    corners = surface.points[surface.cells[0].data]
    one, other = corners[:, 1] - corners[:, 0], corners[:, 3] - corners[:, 0]
    normals = -np.cross(one, other)
    pressures, gaps = (surface.point_data[name][surface.cells[0].data] for name in ("pressure_MPa", "gap_mm"))
    assert not np.ptp(pressures, axis=1).any()
    pressures, gaps = pressures[:, 0], gaps[:, 0]
    assert np.abs(pressures @ normals)[1] == pytest.approx(10e3, rel=2e-3)
    assert np.ptp(surface.points[:, 2]) == pytest.approx(
        run.contact.pair.grid.strip * pressures.size / len(run.contact.pair.grid.widths)
    )
    assert (gaps[pressures > 0.0] < 1e-8).all()
    for number, (name, body) in enumerate(zip(("lower", "upper"), run.bodies, strict=True)):
        section = meshio.read(tmp_path / f"section-{name}.vtu")
        assert np.unique(section.cell_data["body_id"]).tolist() == [number]
        mises = section.point_data["von_mises_MPa"]
        assert mises.max() == pytest.approx(body.von_mises[0], rel=0.1)
        assert section.point_data["stress_MPa"][:, 1].min() == pytest.approx(-pressures.max(), rel=0.1)


def test_the_patch_is_that_of_hertz(run):
    """Maximum pressure and semi-axes are within 1 %."""
    patch = run.summary["patches"][0]
    assert patch["max_pressure_MPa"] == pytest.approx(patch["hertz_pressure_MPa"], rel=1e-2)
    np.testing.assert_allclose(patch["semi_axes_mm"], patch["hertz_semi_axes_mm"], rtol=1e-2)
