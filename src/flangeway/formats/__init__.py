"""Files of other programs: outlines in DXF, CSV and TOML, meshes of Gmsh, Abaqus and VTU, and their repair."""

from flangeway.formats.drawn_section import UNITS, DrawnSection, PartMaterial
from flangeway.formats.mesh_files import read_mesh, write_vtu, write_vtu_lines
from flangeway.formats.mesh_repair import MeshFile
from flangeway.formats.outline_files import read_section

__all__ = [
    "UNITS",
    "DrawnSection",
    "MeshFile",
    "PartMaterial",
    "read_mesh",
    "read_section",
    "write_vtu",
    "write_vtu_lines",
]
