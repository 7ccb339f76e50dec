"""Files of other programs: outlines in DXF, CSV and TOML, meshes of Gmsh, Abaqus and VTU, and their repair."""

from flangeway.formats.drawn_section import UNITS, DrawnSection, PartMaterial
from flangeway.formats.mesh_files import read_mesh
from flangeway.formats.mesh_repair import MeshFile
from flangeway.formats.outline_files import read_section
from flangeway.formats.vtu import write_vtu

__all__ = ["UNITS", "DrawnSection", "MeshFile", "PartMaterial", "read_mesh", "read_section", "write_vtu"]
