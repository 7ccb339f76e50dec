"""Meshes of polyhedra for tests."""

from dataclasses import replace

import numpy as np
from scipy.spatial import Delaunay

from flangeway.mesh import PolyhedralMesh, octree, quadtree, rectangle_grid
from flangeway.types import Floats

BOX = (0.0, 0.0, 0.0, 1.0, 2.0, 1.5)


def voronoi_box(n: int = 60, seed: int = 1) -> PolyhedralMesh:
    """Voronoi cells of random seeds."""
    seeds = np.random.default_rng(seed).uniform(0.0, 1.0, (n, 3)) * BOX[3:]
    return PolyhedralMesh.voronoi(seeds, BOX)


def tetrahedra(n: int = 3) -> tuple[Floats, Floats]:
    """Points and tetrahedra of a box whose inner points are moved at random."""
    points = np.stack(np.meshgrid(*[np.linspace(0.0, 1.0, n + 1)] * 3, indexing="ij"), axis=-1).reshape(-1, 3)
    inside = ((points > 0.0) & (points < 1.0)).all(axis=1)
    points[inside] += np.random.default_rng(2).uniform(-0.2, 0.2, (int(inside.sum()), 3)) / n
    points *= BOX[3:]
    cells = Delaunay(points).simplices
    edges = points[cells[:, 1:]] - points[cells[:, :1]]
    volumes = np.linalg.det(edges)
    cells = cells[np.abs(volumes) > 1e-9]
    turned = volumes[np.abs(volumes) > 1e-9] < 0.0
    cells[turned] = cells[turned][:, [0, 2, 1, 3]]
    return points, cells


def with_sides(mesh: PolyhedralMesh) -> PolyhedralMesh:
    """The mesh of the box with its sides as face sets."""
    for axis, name in enumerate("xyz"):
        for sign, side in (("-", BOX[axis]), ("+", BOX[axis + 3])):
            mesh = mesh.with_face_set(name + sign, lambda p, axis=axis, side=side: np.abs(p[:, axis] - side) < 1e-9)
    return mesh


def boxes() -> dict[str, PolyhedralMesh]:
    """The box in hexahedra, prisms, tetrahedra, Voronoi cells, graded prisms and cubes with hanging nodes."""
    heights = [0.0, 0.3, 0.8, 1.5]
    graded = quadtree(1.0, 2.0, 2, 3, finer=lambda centres, sides: np.hypot(*centres.T) < 0.8, levels=2)
    return {
        name: with_sides(mesh)
        for name, mesh in {
            "hexahedra": PolyhedralMesh.extruded(rectangle_grid(1.0, 2.0, 2, 3, cells="quadrilaterals"), heights),
            "prisms": PolyhedralMesh.extruded(rectangle_grid(1.0, 2.0, 2, 3), heights),
            "tetrahedra": PolyhedralMesh.from_elements(*tetrahedra()),
            "voronoi": voronoi_box(),
            "hanging": PolyhedralMesh.extruded(graded, heights),
            "octree": octree(BOX[3:], (1, 2, 1), finer=lambda p, s: np.linalg.norm(p - 0.1, axis=1) < s, levels=3),
        }.items()
    }


def tilted_blocks() -> tuple[PolyhedralMesh, PolyhedralMesh]:
    """The case `contact_patch_tilted` of three_dimensions.json: two blocks whose meshes do not match.

    Together 20 x 20 x 40, split by the plane through (10, 10, 20) that is tilted by 20 degrees about y: hexahedra with
    5 x 5, and prisms over 7 x 7 squares. The interface is ``z+`` of the first and ``z-`` of the second.
    """
    slope = np.tan(np.deg2rad(20.0))
    meshes = []
    for n, cells, upper in ((5, "quadrilaterals", False), (7, "triangles", True)):
        mesh = PolyhedralMesh.extruded(rectangle_grid(20.0, 20.0, n, n, cells=cells), np.linspace(0.0, 1.0, n - 1))
        x, y, t = mesh.points.T
        middle = 20.0 + slope * (x - 10.0)
        z = middle + t * (40.0 - middle) if upper else t * middle
        meshes.append(replace(mesh, points=np.column_stack((x, y, z))))
    return meshes[0], meshes[1]
