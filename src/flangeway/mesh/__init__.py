"""Meshes of polygons: triangulation, dual polygons, refinement, checks and files."""

from flangeway.mesh.curved import curved
from flangeway.mesh.gmsh_mesher import Refinement, long_meshes_reported, triangulate, triangulate_section
from flangeway.mesh.insertion import edges_halved, insert_nodes, match_boundaries
from flangeway.mesh.interfaces import joined, matched
from flangeway.mesh.mesh_checks import check, conforming
from flangeway.mesh.polygons import agglomerated, dual, dual_section, voronoi
from flangeway.mesh.polyhedral_mesh import PolyhedralMesh, check_polyhedra
from flangeway.mesh.polymesh import PolyMesh
from flangeway.mesh.refine import doerfler_marking, refined
from flangeway.mesh.structured import octree, quadtree, rectangle_grid

__all__ = [
    "PolyMesh",
    "PolyhedralMesh",
    "Refinement",
    "agglomerated",
    "check",
    "check_polyhedra",
    "conforming",
    "curved",
    "doerfler_marking",
    "dual",
    "dual_section",
    "edges_halved",
    "insert_nodes",
    "joined",
    "long_meshes_reported",
    "match_boundaries",
    "matched",
    "octree",
    "quadtree",
    "rectangle_grid",
    "refined",
    "triangulate",
    "triangulate_section",
    "voronoi",
]
