"""Uniform refinement of triangles."""

import numpy as np

from flangeway.errors import InputError
from flangeway.geometry.arrays import IntArray
from flangeway.mesh.polymesh import PolyMesh


def refined(mesh: PolyMesh) -> PolyMesh:
    """Return the mesh with every triangle cut into four at the middles of its edges.

    Points keep their numbers, the middles follow in the order of `mesh.edges`; triangle i becomes
    the triangles 4 i to 4 i + 3. Names are carried along. New points lie on the straight edges,
    also where the outline is an arc.

    Raises
    ------
    InputError
        If a cell is not a triangle.

    """
    if np.any(mesh.cell_sizes != 3):
        cell = int(np.argmax(mesh.cell_sizes != 3))
        raise InputError(
            f"cell {cell} with {mesh.cell_sizes[cell]} points at {mesh.cell_centroids[cell]}",
            "triangles only",
            "refine the triangulation and take its dual",
        )
    corners = mesh.cell_points.reshape(-1, 3)
    middles = mesh.n_points + mesh.cell_edges.reshape(-1, 3)
    (a, b, c), (ab, bc, ca) = corners.T, middles.T
    triangles = np.column_stack([a, ab, ca, ab, b, bc, ca, bc, c, ab, bc, ca]).reshape(-1, 3)
    edge_sets = {}
    for name, pairs in mesh.edge_sets.items():
        middle = mesh.n_points + mesh.edge_numbers(pairs)
        halves = np.column_stack([pairs[:, 0], middle, middle, pairs[:, 1]])
        edge_sets[name] = halves.reshape(-1, 2).astype(np.int32)
    return PolyMesh(
        np.vstack([mesh.points, mesh.points[mesh.edges].mean(axis=1)]),
        np.arange(len(triangles) + 1, dtype=np.int32) * 3,
        triangles.astype(np.int32).ravel(),
        {name: _children(cells) for name, cells in mesh.cell_sets.items()},
        edge_sets,
    )


def _children(cells: IntArray) -> IntArray:
    return np.add.outer(4 * cells, np.arange(4)).ravel().astype(np.int32)
