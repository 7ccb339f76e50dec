"""`flangeway section` and `flangeway reproduce`, as users call them."""

import json

import meshio
import numpy as np
import pytest
from matplotlib.image import imread

BOX = """
title = "Box girder"
unit = "mm"
[outer]
points = [[0, 0], [0, 60], [100, 60], [100, 0]]
[[holes]]
points = [[10, 10, 5], [90, 10, 5], [90, 50, 5], [10, 50, 5]]
"""
FILES = {
    "mesh.png", "warping.png", "prandtl.png", "shear_stress.png", "section.vtu", "report.html", "section.json",
}  # fmt: skip


def test_section_of_a_file(call, tmp_path):
    """A clockwise outline in TOML gives a notice, the constants with units, and all files, whose numbers agree."""
    (tmp_path / "box.toml").write_text(BOX)
    status, out, err = call("section", "box.toml", "--size", 4)
    assert status == 0, err
    assert "Note: outer boundary: drawn clockwise" in out
    for words in ("Box girder", "torsion constant J, mm⁴", "shear centre x, mm", "warping constant, mm⁶"):
        assert words in out
    folder = tmp_path / "out" / "section-box"
    assert {path.name for path in folder.iterdir()} == FILES
    summary = json.loads((folder / "section.json").read_text(encoding="utf-8"))
    assert summary["area_mm2"] == pytest.approx(6000.0 - 3200.0 + (4.0 - np.pi) * 25.0)
    assert summary["centroid_mm"] == pytest.approx([50.0, 30.0])
    assert summary["torsion_bounds_certain"] is True
    assert summary["torsion_constant_prandtl_mm4"] == pytest.approx(summary["torsion_constant_warping_mm4"], rel=2e-3)
    fields = meshio.read(folder / "section.vtu")
    assert {"warping_mm2", "prandtl_mm2"} <= set(fields.point_data)
    assert fields.point_data["prandtl_mm2"].min() == pytest.approx(0.0, abs=1e-6)
    for name in FILES:
        if name.endswith(".png"):
            assert min(imread(folder / name).shape[:2]) > 400
