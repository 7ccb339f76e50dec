"""Mesh of polyhedra: points, plane faces as loops of points, and cells as numbers of faces."""

from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property
from itertools import pairwise
from types import MappingProxyType
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray
from scipy.spatial import Voronoi, cKDTree

from flangeway.checks import as_numbers, values_at
from flangeway.errors import InputError, short
from flangeway.geometry.arrays import IntArray, frozen, norms, point_text, sums_at
from flangeway.mesh.cell_mesh import CellMesh, index_array, known, row_starts
from flangeway.mesh.connectivity import entries_of, first_connected, next_in_row, offsets_of, row_numbers
from flangeway.mesh.polymesh import PolyMesh
from flangeway.types import Bools, Floats, Ints

FLATNESS = 1e-9
"""Distance of a face's points from its plane, relative to the face's size, up to which the face counts as plane."""

MERGED = 1e-9
"""Distance of two corners of Voronoi cells, relative to the size of the box, up to which they are one."""

ELEMENT_FACES = {
    4: ((0, 2, 1), (0, 1, 3), (1, 2, 3), (2, 0, 3)),
    5: ((0, 3, 2, 1), (0, 1, 4), (1, 2, 4), (2, 3, 4), (3, 0, 4)),
    6: ((0, 2, 1), (3, 4, 5), (0, 1, 4, 3), (1, 2, 5, 4), (2, 0, 3, 5)),
    8: ((0, 3, 2, 1), (4, 5, 6, 7), (0, 1, 5, 4), (1, 2, 6, 5), (2, 3, 7, 6), (3, 0, 4, 7)),
}
"""Faces of tetrahedra, pyramids, prisms and hexahedra in the usual order of nodes (VTK, Abaqus, Gmsh)."""


@dataclass(frozen=True, eq=False)
class PolyhedralMesh(CellMesh):
    """Polyhedra with any number of plane faces, which may have hanging nodes.

    The mean of a cell's points must lie behind all of its faces, which defines their outside.

    All arrays are copied and read-only; a change returns a new mesh. The constructor checks shapes and index ranges
    only; a `Space` checks the geometry, as `check_polyhedra` does.

    Parameters
    ----------
    points
        Coordinates (n_points, 3).
    face_offsets, face_points
        Start of every face in `face_points` (n_faces + 1,), from 0, and the faces' points around them.
    side_offsets, side_faces
        Start of every cell in `side_faces` (n_cells + 1,), from 0, and the numbers of the cells' faces.
    cell_sets, face_sets
        Numbers of cells and of faces by name.

    Raises
    ------
    InputError
        If a shape or an index is wrong.

    """

    points: Floats
    face_offsets: IntArray
    face_points: IntArray
    side_offsets: IntArray
    side_faces: IntArray
    cell_sets: Mapping[str, IntArray] = field(default_factory=dict)
    face_sets: Mapping[str, IntArray] = field(default_factory=dict)

    def __post_init__(self) -> None:
        """Check shapes and ranges; store read-only copies."""
        allowed = "finite coordinates of shape (n, 3)"
        points = as_numbers("points", self.points, allowed, "give one row (x, y, z) a point").copy()
        if points.ndim != 2 or points.shape[1] != 3 or not np.isfinite(points).all():
            raise InputError(f"points of shape {points.shape}", allowed, "give one row (x, y, z) a point")
        face_points = index_array(self.face_points, "face_points", len(points)).ravel()
        face_offsets = row_starts(self.face_offsets, "face_offsets", len(face_points), 3)
        n_faces = len(face_offsets) - 1
        side_faces = index_array(self.side_faces, "side_faces", n_faces).ravel()
        side_offsets = row_starts(self.side_offsets, "side_offsets", len(side_faces), 4)
        numbers = {"cell": len(side_offsets) - 1, "face": n_faces}
        named = {
            f"{what}_sets": MappingProxyType(
                {
                    name: frozen(np.unique(index_array(values, f"{what} set '{name}'", numbers[what])))
                    for name, values in getattr(self, f"{what}_sets").items()
                }
            )
            for what in numbers
        }
        arrays = {"points": frozen(points), "face_points": face_points, "side_faces": side_faces}
        for name, value in {**arrays, "face_offsets": face_offsets, "side_offsets": side_offsets, **named}.items():
            object.__setattr__(self, name, value)

    @classmethod
    def from_cells(cls, points: ArrayLike, cells: Iterable[Iterable[Any]], **named: Any) -> "PolyhedralMesh":
        """Return the mesh of points (n_points, 3) and of cells, each the loops of its faces.

        Loops are numbers of points around a face, in either direction; a face between two cells is in both.

        - `named`: sets of cells, as of the class.
        """
        loops: dict[frozenset[int], list[int]] = {}
        keys: list[list[frozenset[int]]] = []
        for cell in cells:
            rings = [[int(point) for point in loop] for loop in cell]
            keys.append([frozenset(ring) for ring in rings])
            loops |= {key: loops.get(key, ring) for key, ring in zip(keys[-1], rings, strict=True)}
        number = {key: face for face, key in enumerate(loops)}
        rows = [[number[key] for key in row] for row in keys]
        face_offsets, side_offsets = (offsets_of(np.array([*map(len, ragged)])) for ragged in (loops.values(), rows))
        flat, sides = np.concatenate([*loops.values()]), np.concatenate(rows)
        return cls(np.asarray(points), face_offsets, flat, side_offsets, sides, **named)

    @classmethod
    def from_elements(cls, points: ArrayLike, *elements: ArrayLike, **named: Any) -> "PolyhedralMesh":
        """Return the mesh of points (n_points, 3) and of tetrahedra, pyramids, prisms or hexahedra.

        - `elements`: numbers of points (n, 4), (n, 5), (n, 6) or (n, 8), in the order of VTK, Abaqus and Gmsh.
        - `named`: sets of cells, as of the class.
        """
        tables = [np.asarray(table) for table in elements]
        for table in tables:
            if table.ndim != 2 or table.shape[1] not in ELEMENT_FACES:
                allowed = "shape (n, 4), (n, 5), (n, 6) or (n, 8)"
                raise InputError(f"elements of shape {table.shape}", allowed, "give one row of points an element")
        rows = (row for table in tables for row in table)
        return cls.from_cells(points, ([row[list(face)] for face in ELEMENT_FACES[len(row)]] for row in rows), **named)

    @classmethod
    def extruded(cls, mesh: PolyMesh, heights: ArrayLike) -> "PolyhedralMesh":
        """Return the prisms over the cells of a plane mesh between heights z, rising (n,).

        Cell sets keep their names, edge sets become face sets, and ``z-`` and ``z+`` are the ends.
        """
        z = np.asarray(heights, dtype=np.float64).ravel()
        if len(z) < 2 or not (np.diff(z) > 0.0).all():
            raise InputError(f"heights {short(heights)}", "two or more numbers that rise", "sort them")
        n, layers = mesh.n_points, np.arange(len(z) - 1)
        points = np.column_stack((np.tile(mesh.points, (len(z), 1)), np.repeat(z, n)))
        cells = (
            [ring, ring + n, *([a, b, b + n, a + n] for a, b in zip(ring, np.roll(ring, -1), strict=True))]
            for layer in layers
            for ring in (mesh.corners(cell) + n * layer for cell in range(mesh.n_cells))
        )
        sets: dict[str, Any] = {
            name: (mesh.n_cells * layers[:, None] + cells).ravel() for name, cells in mesh.cell_sets.items()
        }
        solid = cls.from_cells(points, cells, cell_sets=sets)
        rings: dict[str, list[Any]] = {
            name: [[a + at, b + at, b + at + n, a + at + n] for a, b in pairs for at in n * layers]
            for name, pairs in mesh.edge_sets.items()
        }
        bottom = [mesh.corners(cell) for cell in range(mesh.n_cells)]
        return solid.with_rings(rings | {"z-": bottom, "z+": [ring + n * len(layers) for ring in bottom]})

    @classmethod
    def voronoi(cls, seeds: ArrayLike, box: Sequence[float]) -> "PolyhedralMesh":
        """Return the Voronoi cells of seeds in a box, with the box's sides as face sets.

        - `seeds`: points (n, 3) inside the box.
        - `box`: x_min, y_min, z_min, x_max, y_max, z_max. Face sets: ``x-``, ``x+``, ``y-``, ``y+``, ``z-``, ``z+``.
        """
        points, sides = np.asarray(seeds, dtype=np.float64), np.asarray(box, dtype=np.float64).reshape(2, 3)
        if points.ndim != 2 or points.shape[1:] != (3,) or not ((points > sides[0]) & (points < sides[1])).all():
            raise InputError(f"seeds of shape {points.shape}", f"points (n, 3) inside {short(box)}", "correct them")
        # cells of seeds and of their mirror images meet in the sides of the box
        across = [np.where(np.arange(3) == axis, 2.0 * side - points, points) for side in sides for axis in range(3)]
        diagram, reach = Voronoi(np.concatenate((points, *across))), MERGED * float(norms(sides[1] - sides[0]))
        pairs, rings = diagram.ridge_points, diagram.ridge_vertices
        inner = np.flatnonzero(pairs.min(axis=1) < len(points)).tolist()
        used = np.unique(np.concatenate([rings[row] for row in inner]))
        corners = np.clip(diagram.vertices[used], *sides)
        first = first_connected(cKDTree(corners).query_pairs(reach, output_type="ndarray"), len(used))
        kept, merged = np.unique(first, return_inverse=True)
        corners, number = corners[kept], dict(zip(used.tolist(), merged.tolist(), strict=True))
        cells: list[list[list[int]]] = [[] for _ in points]
        for row in inner:
            ring = list(dict.fromkeys(number[vertex] for vertex in rings[row]))
            for cell in pairs[row].tolist():
                if len(ring) > 2 and cell < len(points):
                    cells[cell].append(ring)
        return cls.from_cells(corners, cells).with_box_sides(sides)

    def __repr__(self) -> str:
        sets = f"cell_sets={sorted(self.cell_sets)}, face_sets={sorted(self.face_sets)}"
        return f"PolyhedralMesh(n_points={self.n_points}, n_faces={self.n_faces}, n_cells={self.n_cells}, {sets})"

    # connections

    @property
    def n_faces(self) -> int:
        """Number of faces."""
        return len(self.face_offsets) - 1

    def loop(self, face: int) -> IntArray:
        """Return the numbers of the points around a face."""
        return self.face_points[self.face_offsets[face] : self.face_offsets[face + 1]]

    @cached_property
    def side_signs(self) -> Floats:
        """1 where a side's cell is behind the face's normal, -1 where it is in front of it, (n_sides,)."""
        return np.sign(self._heights)

    @cached_property
    def side_corners(self) -> tuple[Ints, Ints]:
        """Each corner of each side of each cell, (m,): the side, and the place in `face_points`."""
        places, offsets = entries_of(self.face_offsets, self.side_faces)
        return row_numbers(offsets), places

    @cached_property
    def cell_corners(self) -> tuple[Ints, Ints]:
        """Numbers ``cell * n_points + point`` of the points of cells, rising, and the place there of `side_corners`."""
        sides, corners = self.side_corners
        keys = row_numbers(self.side_offsets)[sides] * self.n_points + self.face_points[corners]
        return np.unique(keys, return_inverse=True)

    @cached_property
    def cell_points(self) -> IntArray:  # type: ignore[override]
        """Points of the cells one after the other, rising in each cell."""
        return frozen((self.cell_corners[0] % self.n_points).astype(np.int32))

    @cached_property
    def cell_offsets(self) -> IntArray:  # type: ignore[override]
        """Start of every cell in `cell_points` (n_cells + 1,)."""
        return frozen(offsets_of(np.bincount(self.cell_corners[0] // self.n_points)))

    def with_plane_faces(self) -> "PolyhedralMesh":
        """Return the mesh with faces that are not plane divided into triangles about their lowest point number.

        Cells stay whole. Hexahedra whose points lie on curved surfaces become polyhedra with triangles.
        """
        bent = bent_faces(self)[0]
        if not bent.any():
            return self
        rings = [self.loop(face).tolist() for face in range(self.n_faces)]
        rings = [ring[(at := ring.index(min(ring))) :] + ring[:at] for ring in rings]
        parts = [
            [[ring[0], *pair] for pair in pairwise(ring[1:])] if divide else [ring]
            for ring, divide in zip(rings, bent, strict=True)
        ]
        return self.with_parts(self.points, parts)

    def with_parts(self, points: ArrayLike, parts: Sequence[Sequence[Sequence[int]]]) -> "PolyhedralMesh":
        """Return the mesh with each face replaced by one or more loops of points (n_points, 3); sets keep their names.

        - `parts`: loops of each face, (n_faces,).
        """
        sides = [parts[face] for face in self.side_faces.tolist()]
        cells = [[ring for side in sides[start:end] for ring in side] for start, end in pairwise(self.side_offsets)]
        mesh = PolyhedralMesh.from_cells(points, cells, cell_sets=self.cell_sets)
        return mesh.with_rings(
            {name: [ring for face in faces.tolist() for ring in parts[face]] for name, faces in self.face_sets.items()}
        )

    def with_rings(self, rings: Mapping[str, Iterable[Iterable[int]]]) -> "PolyhedralMesh":
        """Return the mesh with face sets, each the loops of its faces; those inside the body are left out."""
        numbers = {frozenset(self.loop(face).tolist()): face for face in self.boundary_faces.tolist()}
        sets = {
            name: [numbers[key] for ring in loops if (key := frozenset(ring)) in numbers]
            for name, loops in rings.items()
        }
        return replace(self, face_sets={name: np.array(faces) for name, faces in sets.items() if faces})

    def with_box_sides(self, sides: Floats) -> "PolyhedralMesh":
        """Return the mesh with the sides of its box as face sets, ``x-`` to ``z+``; the least and greatest x, y, z."""
        centres, reach = self.face_centres[self.boundary_faces], MERGED * float(norms(sides[1] - sides[0]))
        at = {
            f"{'xyz'[axis]}{sign}": np.abs(centres[:, axis] - side[axis]) <= reach
            for side, sign in zip(sides, "-+", strict=True)
            for axis in range(3)
        }
        return replace(self, face_sets={name: self.boundary_faces[rows] for name, rows in at.items()})

    @cached_property
    def boundary_faces(self) -> Ints:
        """Faces with one cell, rising."""
        return np.flatnonzero(np.bincount(self.side_faces, minlength=self.n_faces) == 1)

    @cached_property
    def face_sides(self) -> Floats:
        """1 where the points of a boundary face are counter-clockwise from outside, else -1, (n_faces,)."""
        signs = np.ones(self.n_faces)
        signs[self.side_faces] = self.side_signs
        return signs

    @cached_property
    def cell_neighbours(self) -> Ints:
        """Pairs of cells (m, 2) with a common face."""
        order = np.argsort(self.side_faces, kind="stable")
        faces, cells = self.side_faces[order], row_numbers(self.side_offsets)[order]
        double = np.flatnonzero(faces[1:] == faces[:-1])
        return np.column_stack((cells[double], cells[double + 1]))

    # geometry

    @cached_property
    def face_vectors(self) -> Floats:
        """Normals of the faces times their areas, shape (n_faces, 3)."""
        first = self.points[self.face_points[self.face_offsets[:-1]]]
        arms = self.points[self.face_points] - np.repeat(first, np.diff(self.face_offsets), axis=0)
        halves = np.cross(arms, arms[next_in_row(self.face_offsets)]) / 2.0
        return frozen(np.add.reduceat(halves, self.face_offsets[:-1], axis=0))

    @cached_property
    def face_centres(self) -> Floats:
        """Means of the faces' points, shape (n_faces, 3)."""
        sums = np.add.reduceat(self.points[self.face_points], self.face_offsets[:-1], axis=0)
        return frozen(sums / np.diff(self.face_offsets)[:, None])

    @cached_property
    def _heights(self) -> Floats:
        """Heights of the faces over the means of their cells' points along their `face_vectors`, (n_sides,)."""
        sums = np.add.reduceat(self.points[self.cell_points], self.cell_offsets[:-1], axis=0)
        middles = np.repeat(sums / self.cell_sizes[:, None], np.diff(self.side_offsets), axis=0)
        arms = self.face_centres[self.side_faces] - middles
        return frozen(np.einsum("si,si->s", arms, self.face_vectors[self.side_faces]))

    @cached_property
    def cell_volumes(self) -> Floats:
        """Volumes (n_cells,)."""
        return frozen(np.add.reduceat(np.abs(self._heights), self.side_offsets[:-1]) / 3.0)

    # named sets

    def face_set(self, name: str) -> IntArray:
        """Return the numbers of the faces of a face set; an unknown name is an InputError."""
        return known(self.face_sets, name, "face")

    def with_face_set(self, name: str, where: ArrayLike | Callable[[Floats], Bools]) -> "PolyhedralMesh":
        """Return the mesh with a further (or replaced) face set.

        - `where`: numbers of boundary faces, or a function that says of points (n, 3) which it takes, (n,): the set
          then has the boundary faces all of whose points it takes, such as ``lambda p: p[:, 2] < 1e-9``.

        Raises
        ------
        InputError
            If a face is inside the body, or a function takes none.
        """
        boundary: NDArray[Any] = self.boundary_faces
        chosen = np.asarray(where)
        if callable(where):
            taken = values_at(where, self.points)
            whole = np.logical_and.reduceat(taken[self.face_points], self.face_offsets[:-1])
            chosen = boundary[whole[boundary]]
        inside = np.setdiff1d(chosen, boundary)
        if len(chosen) == 0 or len(inside):
            given = f"face {inside[0]}, which is inside" if len(inside) else "no face"
            raise InputError(f"face set '{name}' with {given}", "faces of the boundary, one or more", "correct it")
        return replace(self, face_sets={**self.face_sets, name: chosen})


def bent_faces(mesh: PolyhedralMesh) -> tuple[Bools, Floats]:
    """Which faces are not plane or have no area, and the largest distance of their points from their planes."""
    counts, areas = np.diff(mesh.face_offsets), norms(mesh.face_vectors)
    arms = mesh.points[mesh.face_points] - np.repeat(mesh.face_centres, counts, axis=0)
    volumes = np.abs(np.einsum("ci,ci->c", arms, np.repeat(mesh.face_vectors, counts, axis=0)))
    sizes, highest = (np.maximum.reduceat(values, mesh.face_offsets[:-1]) for values in (norms(arms), volumes))
    distances = highest / np.maximum(areas, np.finfo(np.float64).tiny)
    return ~((highest <= FLATNESS * sizes * areas) & (areas > 0.0)), distances


def check_polyhedra(mesh: PolyhedralMesh) -> None:
    """Refuse faces that are not plane, and cells that are not closed or not seen whole from the mean of their points.

    Raises
    ------
    InputError
        With the number of the face or cell and its place.
    """
    bent, distances = bent_faces(mesh)
    if bent.any():
        face = int(bent.argmax())
        place = point_text(mesh.face_centres[face])
        raise InputError(
            f"face {face} at {place}, of which points are {distances[face]:.2g} off its plane",
            f"faces with an area that are plane to {FLATNESS:g} of their size",
            "divide such faces into triangles: mesh.with_plane_faces()",
        )
    times = np.bincount(mesh.side_faces, minlength=mesh.n_faces)
    both = sums_at(mesh.side_faces, mesh.side_signs, mesh.n_faces)
    wrong = (times > 2) | ((times == 2) & (both != 0.0)) | (times == 0)
    if wrong.any():
        face = int(wrong.argmax())
        raise InputError(
            f"face {face} at {point_text(mesh.face_centres[face])} with {times[face]} cells on its sides",
            "faces with one cell, or with one on each side",
            "look for cells that overlap, and for faces whose points run the wrong way round",
        )
    _check_closed(mesh)


def _check_closed(mesh: PolyhedralMesh) -> None:
    """Refuse cells of whose faces, seen from outside, an edge is not travelled once in each direction."""
    sides, corners = mesh.side_corners
    following, n = next_in_row(mesh.face_offsets)[corners], mesh.n_points
    start, end = mesh.face_points[corners].astype(np.int64), mesh.face_points[following].astype(np.int64)
    cells, signs = row_numbers(mesh.side_offsets)[sides], mesh.side_signs[sides]
    keys = (cells * n + np.minimum(start, end)) * n + np.maximum(start, end)
    edges, places = np.unique(keys, return_inverse=True)
    # of a face in the plane of the mean the sign is 0
    open_ = np.bincount(places, np.where(start < end, signs, -signs) + 0.5 * (signs == 0.0)) != 0.0
    if open_.any():
        rest, b = divmod(int(edges[open_.argmax()]), n)
        cell, a = divmod(rest, n)
        raise InputError(
            f"cell {cell}, which is open or flat at the edge from {point_text(mesh.points[a])} to "
            f"{point_text(mesh.points[b])}",
            "closed cells: each edge belongs to two of their faces, and the mean of their points is behind all faces",
            "add the missing face, or divide the cell; a hanging node is a point of all faces on whose edges it lies",
        )
