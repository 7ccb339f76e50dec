"""Files of other programs: outlines (DXF, CSV, TOML), meshes (Gmsh, Abaqus, VTU), stiffness matrices (CalculiX)."""

from flangeway.formats.abaqus_files import CalculixMatrix, read_calculix_matrix
from flangeway.formats.drawn_section import UNITS, DrawnSection, PartMaterial
from flangeway.formats.mesh_files import (
    read_mesh,
    read_polyhedra,
    write_vtu,
    write_vtu_grids,
    write_vtu_lines,
    write_vtu_polyhedra,
)
from flangeway.formats.mesh_repair import MeshFile
from flangeway.formats.outline_files import (
    ArcAbout,
    ArcThrough,
    CircleTable,
    LineStep,
    LoopTable,
    OutlineTable,
    PathStart,
    read_section,
)

__all__ = [
    "UNITS",
    "ArcAbout",
    "ArcThrough",
    "CalculixMatrix",
    "CircleTable",
    "DrawnSection",
    "LineStep",
    "LoopTable",
    "MeshFile",
    "OutlineTable",
    "PartMaterial",
    "PathStart",
    "read_calculix_matrix",
    "read_mesh",
    "read_polyhedra",
    "read_section",
    "write_vtu",
    "write_vtu_grids",
    "write_vtu_lines",
    "write_vtu_polyhedra",
]
