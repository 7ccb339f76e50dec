"""Faces of two meshes in one plane cut into common polygons, and meshes joined at common faces."""

from collections.abc import Mapping

import numpy as np
import shapely
from scipy.spatial import cKDTree

from flangeway.errors import InputError
from flangeway.geometry.arrays import diagonal, sides_of
from flangeway.mesh.connectivity import first_connected
from flangeway.mesh.polyhedral_mesh import PolyhedralMesh
from flangeway.types import Floats, Indices, Ints

GRID, CLOSE = 1e-12, 1e-9
"""Grid of the common polygons' corners, and distance within which they lie on points and edges, relative to the size of
the interface."""
MERGED = 1e-7
"""Distance relative to the size of the meshes within which their points are one."""


def matched(
    first: PolyhedralMesh, first_faces: str, second: PolyhedralMesh, second_faces: str
) -> tuple[PolyhedralMesh, PolyhedralMesh]:
    """Return both meshes with faces in a common plane cut into the polygons that they have in common.

    Cells stay whole: they get faces and hanging nodes, which virtual elements take. What faces do not have in common
    stays their own.

    Parameters
    ----------
    first, second
        The meshes.
    first_faces, second_faces
        Their face sets on the interface.

    Raises
    ------
    InputError
        If the faces are not in one plane, or a face has a whole one of the other mesh inside.
    """
    sides = (first, first.face_set(first_faces)), (second, second.face_set(second_faces))
    nodes = [np.unique(np.concatenate([mesh.loop(face) for face in faces])) for mesh, faces in sides]
    points = np.concatenate([mesh.points[rows] for (mesh, _), rows in zip(sides, nodes, strict=True)])
    size, base = diagonal(points), points.mean(axis=0)
    *axes, normal = np.linalg.svd(points - base, full_matrices=False)[2]
    off = np.abs((points - base) @ normal).max()
    if off > MERGED * size:
        raise InputError(
            f"faces '{first_faces}' and '{second_faces}', with points {off:.2g} off their plane",
            "faces of both meshes in one plane",
            "match one plane after the other",
        )
    to_plane, reach = np.array(axes).T, CLOSE * size
    flat = [(mesh.points - base) @ to_plane for mesh, _ in sides]
    shapes = [
        np.array([shapely.Polygon(places[mesh.loop(face)]) for face in faces])
        for places, (mesh, faces) in zip(flat, sides, strict=True)
    ]
    lines = shapely.union_all(shapely.boundary(np.concatenate(shapes)), grid_size=GRID * size)
    pieces = np.array(list(shapely.polygonize([lines]).geoms))
    if shapely.get_num_interior_rings(pieces).any():
        raise InputError(
            "a face with a whole one of the other mesh inside", "faces that cross", "refine the larger one"
        )
    inner = shapely.point_on_surface(pieces)
    one, other = (
        _cut(
            mesh,
            faces,
            places,
            pieces,
            shapely.STRtree(inner).query(polygons, predicate="contains"),
            base,
            to_plane,
            reach,
        )
        for (mesh, faces), places, polygons in zip(sides, flat, shapes, strict=True)
    )
    return one, other


def _cut(
    mesh: PolyhedralMesh,
    faces: Indices,
    places: Floats,
    pieces: Floats,
    owners: Ints,
    base: Floats,
    to_plane: Floats,
    reach: float,
) -> PolyhedralMesh:
    """Mesh with faces replaced by the pieces inside of them, ``owners`` (2, n): rows of faces and of pieces.

    Corners on edges become points of all faces with these edges.
    """
    corners = np.unique(shapely.get_coordinates(pieces[owners[1]]), axis=0)
    nodes = np.unique(np.concatenate([mesh.loop(face) for face in faces]))
    distances, nearest = cKDTree(places[nodes]).query(corners)
    new = distances > reach
    number = np.where(new, mesh.n_points + np.cumsum(new) - 1, nodes[nearest])
    tree, flat = cKDTree(corners), np.concatenate((places, corners[new]))
    parts = [[mesh.loop(face).tolist()] for face in range(mesh.n_faces)]
    on_edges: dict[tuple[int, int], list[int]] = {}
    for row, face in enumerate(faces.tolist()):
        rings = [shapely.get_coordinates(piece)[:-1] for piece in pieces[owners[1, owners[0] == row]]]
        (ring,), parts[face] = parts[face], [number[tree.query(ends)[1]].tolist() for ends in rings]
        own = np.unique(np.concatenate(parts[face]))
        for start, end in sides_of(ring):
            chord, arms = flat[end] - flat[start], flat[own] - flat[start]
            length = np.hypot(*chord)
            along, heights = arms @ chord / length, arms @ (-chord[1], chord[0]) / length
            on = np.flatnonzero((np.abs(heights) <= reach) & (along > reach) & (along < length - reach))
            on = on[np.argsort(along[on])]
            flat[own[on]] = flat[start] + along[on, None] / length * chord
            on_edges |= {(start, end): own[on].tolist(), (end, start): own[on[::-1]].tolist()}
    for face in np.setdiff1d(np.arange(mesh.n_faces), faces).tolist():
        pairs = sides_of(parts[face][0])
        parts[face] = [[point for pair in pairs for point in (pair[0], *on_edges.get(pair, ()))]]
    return mesh.with_parts(np.concatenate((mesh.points, base + flat[mesh.n_points :] @ to_plane.T)), parts)


def joined(meshes: Mapping[str, PolyhedralMesh]) -> PolyhedralMesh:
    """Return meshes as one, whose equal points and faces are one: bodies that are bonded there.

    The cells of each mesh are a cell set of its name; sets of faces on the boundary and of cells have that name and
    their own with a blank between. Faces that do not match stay two faces of the boundary: see `matched`.
    """
    points, starts = np.concatenate([mesh.points for mesh in meshes.values()]), 0
    pairs = cKDTree(points).query_pairs(MERGED * diagonal(points), output_type="ndarray")
    kept, number = np.unique(first_connected(pairs, len(points)), return_inverse=True)
    cells: list[list[list[int]]] = []
    cell_sets: dict[str, Ints] = {}
    rings: dict[str, list[list[int]]] = {}
    for name, mesh in meshes.items():
        loops = [number[starts + mesh.loop(face)].tolist() for face in range(mesh.n_faces)]
        every = np.arange(len(cells), len(cells) + mesh.n_cells)
        cell_sets |= {name: every, **{f"{name} {key}": every[rows] for key, rows in mesh.cell_sets.items()}}
        rings |= {f"{name} {key}": [loops[face] for face in faces] for key, faces in mesh.face_sets.items()}
        cells += [[loops[face] for face in row] for row in np.split(mesh.side_faces, mesh.side_offsets[1:-1])]
        starts += mesh.n_points
    return PolyhedralMesh.from_cells(points[kept], cells, cell_sets=cell_sets).with_rings(rings)
