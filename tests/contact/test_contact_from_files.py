"""Bodies in contact from files of Abaqus and Gmsh, by the names that the files have."""

from pathlib import Path

import gmsh
import numpy as np
import pytest

from flangeway.contact import Contact, Multiplier, SegmentToSegment, Surface, press
from flangeway.elements import Virtual
from flangeway.errors import InputError
from flangeway.formats import read_mesh
from flangeway.geometry import Placement
from flangeway.materials import Elastic
from flangeway.problems import Body, Part
from tests.docs.conftest import blocks_of


def written_abaqus(folder: Path) -> Path:
    """The deck of the page on case files: two blocks of height 1 with sets and surfaces."""
    path = folder / "blocks.inp"
    path.write_text(next(each.text for each in blocks_of("how-to/write-a-case-file.md") if each.file == "blocks.inp"))
    return path


def written_gmsh(folder: Path) -> Path:
    """The same blocks by Gmsh, with physical groups of the same names."""
    path = folder / "blocks.msh"
    gmsh.initialize()
    try:
        gmsh.option.setNumber("General.Terminal", 0)
        for name, low, size, sides in (("LOWER", 0.0, 0.7, ("BASE", "MASTER")), ("UPPER", 1.0, 0.5, ("SLAVE", "LID"))):
            tag = gmsh.model.occ.addRectangle(0.0, low, 0.0, 4.0, 1.0)
            gmsh.model.occ.synchronize()
            gmsh.model.addPhysicalGroup(2, [tag], name=name)
            curves = [curve for _, curve in gmsh.model.getBoundary([(2, tag)], oriented=False)]
            for side, height in zip(sides, (low, low + 1.0), strict=True):
                mine = [c for c in curves if np.allclose(gmsh.model.getBoundingBox(1, c)[1::3], height, atol=1e-6)]
                gmsh.model.addPhysicalGroup(1, mine, name=side)
            gmsh.model.mesh.setSize(gmsh.model.getBoundary([(2, tag)], recursive=True), size)
        gmsh.model.mesh.generate(2)
        gmsh.write(str(path))
    finally:
        gmsh.finalize()
    return path


@pytest.mark.parametrize("written", [written_abaqus, written_gmsh])
def test_two_blocks_of_one_file_are_pressed(written, tmp_path: Path) -> None:
    """Without contraction two blocks are columns: the force is E d b / (h1 + h2)."""
    read = read_mesh(written(tmp_path), merge_points=False)
    steel = Elastic(210e3, 0.0)
    meshes = {name: read.part(name).mesh for name in ("UPPER", "LOWER")}
    upper, lower = (
        Part(name, Body(name, meshes[name], Virtual(1), steel, held))
        for name, held in (("UPPER", "LID"), ("LOWER", "BASE"))
    )
    surfaces = Surface(upper, meshes["UPPER"].edge_set("SLAVE")), Surface(lower, meshes["LOWER"].edge_set("MASTER"))
    contact = Contact(*surfaces, SegmentToSegment(), Multiplier())
    solution = press([contact], {upper: Placement(0.0, (0.0, -0.01))})
    assert solution.status.converged
    assert solution.forces[0] == pytest.approx([0.0, 210e3 * 0.01 * 4.0 / 2.0], rel=1e-9, abs=1e-6)


def test_an_unknown_set_of_cells_is_refused(tmp_path: Path) -> None:
    """The message has the names that there are."""
    with pytest.raises(InputError, match=r"(?s)MIDDLE.*LOWER"):
        read_mesh(written_abaqus(tmp_path), merge_points=False).part("MIDDLE")
