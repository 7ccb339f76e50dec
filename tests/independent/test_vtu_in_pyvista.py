"""The files of all kinds of cases, read by VTK's own reader with pyvista.

pyvista is large, 0.6 GB with VTK: these tests are skipped where it is not installed.
"""

from functools import cache
from xml.etree import ElementTree

import numpy as np
import pytest

from flangeway.cases import load_case
from flangeway.report.case_outputs import write_case

pyvista = pytest.importorskip("pyvista", reason="pyvista is not installed")

FIELDS = {"displacement_mm", "stress_MPa", "von_mises_MPa"}
CONTACT = {"pressure_MPa", "gap_mm"}
CASES = {
    "hertz": ({"order": 2, "size_mm": 1.0, "lower_size_mm": 1.5}, "bodies.pvd"),
    "wheelset-tangent": ({"size_scale": 4.0, "method": "vem"}, "wheelset.pvd"),
    "wheelset": ({"size_scale": 3.0}, "wheelset.pvd"),
    "crossed-cylinders": ({"order": 1, "upper_radius_mm": 30.0}, "bodies.pvd"),
    "torsion": ({"size": 12.0}, None),
}


@pytest.fixture(scope="module")
def folders(tmp_path_factory):
    """Files of a case and its run by the name of the case."""

    @cache
    def folder(name):
        run = load_case(name, **CASES[name][0]).run()
        out = tmp_path_factory.mktemp(name)
        write_case(run, out)
        return out, run

    return folder


@pytest.mark.parametrize(
    "name", [pytest.param(each, marks=[pytest.mark.ci] * each.startswith(("wheelset", "crossed"))) for each in CASES]
)
def test_all_files_have_one_convention(folders, name):
    """What is measured is at points, one array each; cells have numbers; the collection's parts are the bodies."""
    folder, _ = folders(name)
    files = sorted(folder.rglob("*.vtu"))
    assert files
    for file in files:
        grid = pyvista.read(file)
        cells, points = {key for key in grid.cell_data if "_set:" not in key}, set(grid.point_data.keys())
        assert cells == {"cell_number", "body_id"} | ({"part"} if name == "torsion" else set())
        if "displacement_mm" in points and "gap_mm" not in points:
            assert points == FIELDS
        elif name != "torsion":
            assert points - {"displacement_mm"} == CONTACT or points == FIELDS - {"displacement_mm"}
        assert grid.n_cells
        if "stress_MPa" in points:
            xx, yy, zz, xy, yz, xz = np.asarray(grid["stress_MPa"]).T
            von_mises = ((xx - yy) ** 2 + (yy - zz) ** 2 + (zz - xx) ** 2) / 2.0 + 3.0 * (xy**2 + yz**2 + xz**2)
            np.testing.assert_allclose(grid["von_mises_MPa"], np.sqrt(von_mises), rtol=1e-6, atol=1e-6)
    if CASES[name][1] is not None:
        rows = ElementTree.parse(folder / CASES[name][1]).getroot().findall("Collection/DataSet")
        assert {row.get("file") for row in rows} == {file.relative_to(folder).as_posix() for file in files}
        for row in rows if name != "wheelset" else ():
            if "contact" not in row.get("name") and "surface" not in row.get("name"):
                ids = np.unique(pyvista.read(folder / row.get("file")).cell_data["body_id"])
                assert ids.tolist() == [int(row.get("part"))]
