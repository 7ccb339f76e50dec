"""Meshes of polygons: triangulation, dual polygons, checks and files."""

from flangeway.mesh.checks import check
from flangeway.mesh.dual import dual
from flangeway.mesh.gmsh_mesher import triangulate
from flangeway.mesh.polymesh import PolyMesh
from flangeway.mesh.refine import refined
from flangeway.mesh.section_mesher import dual_section, triangulate_section
from flangeway.mesh.sizing import Refinement
from flangeway.mesh.structured import rectangle_grid
from flangeway.mesh.vtu import write_vtu

__all__ = [
    "PolyMesh",
    "Refinement",
    "check",
    "dual",
    "dual_section",
    "rectangle_grid",
    "refined",
    "triangulate",
    "triangulate_section",
    "write_vtu",
]
