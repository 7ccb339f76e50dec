"""Meshes of polyhedra for tests."""

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
