"""Meshes of polygons: triangulation, dual polygons, refinement, checks and files."""

from flangeway.mesh.agglomeration import agglomerated
from flangeway.mesh.curved import curved
from flangeway.mesh.dual import dual, dual_section
from flangeway.mesh.gmsh_mesher import triangulate, triangulate_section
from flangeway.mesh.insertion import edges_halved, insert_nodes, match_boundaries
from flangeway.mesh.mesh_checks import check, conforming
from flangeway.mesh.polymesh import PolyMesh
from flangeway.mesh.quadtree import quadtree
from flangeway.mesh.refine import doerfler_marking, refined
from flangeway.mesh.sizing import Refinement, long_meshes_reported
from flangeway.mesh.structured import rectangle_grid
from flangeway.mesh.voronoi import voronoi

__all__ = [
    "PolyMesh",
    "Refinement",
    "agglomerated",
    "check",
    "conforming",
    "curved",
    "doerfler_marking",
    "dual",
    "dual_section",
    "edges_halved",
    "insert_nodes",
    "long_meshes_reported",
    "match_boundaries",
    "quadtree",
    "rectangle_grid",
    "refined",
    "triangulate",
    "triangulate_section",
    "voronoi",
]
