"""Meshes of polygons: triangulation, dual polygons, refinement, checks and files."""

from flangeway.mesh.conforming import conforming
from flangeway.mesh.dual import dual
from flangeway.mesh.gmsh_mesher import triangulate
from flangeway.mesh.halved import edges_halved
from flangeway.mesh.long_meshes import long_meshes_reported
from flangeway.mesh.marking import doerfler_marking
from flangeway.mesh.mesh_checks import check
from flangeway.mesh.polymesh import PolyMesh
from flangeway.mesh.refine import refined
from flangeway.mesh.section_mesher import dual_section, triangulate_section
from flangeway.mesh.sizing import Refinement
from flangeway.mesh.structured import rectangle_grid

__all__ = [
    "PolyMesh",
    "Refinement",
    "check",
    "conforming",
    "doerfler_marking",
    "dual",
    "dual_section",
    "edges_halved",
    "long_meshes_reported",
    "rectangle_grid",
    "refined",
    "triangulate",
    "triangulate_section",
]
