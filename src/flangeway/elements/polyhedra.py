"""Integrals over polyhedra: from their faces, on which functions are projected by the plane virtual element."""

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from flangeway.elements import batched, monomials
from flangeway.elements.monomials import Frame
from flangeway.elements.projection import CellGeometry
from flangeway.elements.reconstruction import Reconstruction
from flangeway.elements.virtual import Virtual
from flangeway.geometry.arrays import norms, sums_at, units_of
from flangeway.mesh.connectivity import row_numbers
from flangeway.mesh.polyhedral_mesh import PolyhedralMesh
from flangeway.types import Floats, Indices, Ints

SECOND_MOMENT = 0.2
"""Mean square of a coordinate in the unit ball, which the principal frame gives every cell."""


@dataclass(frozen=True, eq=False)
class Polyhedra(CellGeometry):
    """Geometry of a batch of polyhedra with elements of order 1.

    A vertex has as normal the sum over the cell's faces of the outward normal times the integral of the vertex's
    function, as the lengths of edges have in the plane.
    """

    def boundary_values(self) -> Floats:
        """Monomials of degree 1 at the vertices, (4, n_vertices, n_cells)."""
        return monomials.evaluate(1, self.local)

    def gradient_moments(self, boundary: Floats) -> Floats:  # noqa: ARG002 (moments of constants need no monomials)
        """Integrals of the basis functions' gradients, by Green's formula, shape (1, 3, n_vertices, n_cells)."""
        return self.normals.swapaxes(0, 1)[None]

    def part(self, columns: Indices) -> "Polyhedra":
        """Some of the cells, by their places in the batch (m,)."""
        arrays = (array[..., columns] for array in (self.local, self.normals, self.moments))
        return Polyhedra(self.order, self.frame.part(columns), *arrays)

    def quadrature(self) -> tuple[Floats, Floats]:
        """Six points (6, 3, n_cells) and weights (6, n_cells) that integrate polynomials of degree 2.

        They lie on the principal axes, at the distance that gives the second moments.
        """
        along = np.sqrt(3.0 * SECOND_MOMENT) * np.concatenate((np.eye(3), -np.eye(3)))
        points = np.einsum("ije,qj->qie", self.frame.inverse, along) + self.frame.origin
        return points, np.tile(self.moments[0] / 6.0, (6, 1))


@dataclass(frozen=True, eq=False)
class FaceBatch:
    """Faces with one number of corners in their planes, and the plane virtual element on them.

    - `faces`: (n_faces,).
    - `places`: of their corners in ``mesh.face_points``, (n_faces, n_corners).
    - `normals`: (n_faces, 3).
    - `base`: the first corners, (n_faces, 3).
    - `axes`: coordinates in the plane, unit vectors (2, n_faces, 3).
    - `flat`: corners in these, counter-clockwise, (n_corners, 2, n_faces).
    - `plane`: reconstruction in these.
    """

    faces: Ints
    places: Ints
    normals: Floats
    base: Floats
    axes: Floats
    flat: Floats
    plane: Reconstruction

    def in_space(self, flat: Floats) -> Floats:
        """Points in space (n_faces, n, 3) of points in the planes (n, 2, n_faces)."""
        return self.base[:, None] + np.einsum("qae,aei->eqi", flat, self.axes)


def face_batches(mesh: PolyhedralMesh, faces: Indices) -> Iterator[FaceBatch]:
    """Faces of a mesh by their numbers of corners."""
    counts = np.diff(mesh.face_offsets)
    for n in np.unique(counts[faces]):
        chosen = np.asarray(faces)[counts[faces] == n].astype(np.int64)
        places = mesh.face_offsets[chosen].astype(np.int64)[:, None] + np.arange(n)
        corners = mesh.points[mesh.face_points[places]]
        normals = units_of(mesh.face_vectors[chosen])
        # the first axis is across the normal and the coordinate along which this has its smallest component
        first = np.cross(normals, np.eye(3)[np.abs(normals).argmin(axis=1)])
        first /= norms(first)[:, None]
        axes = np.stack((first, np.cross(normals, first)))
        flat = np.einsum("aei,evi->vae", axes, corners - corners[:, :1])
        yield FaceBatch(chosen, places, normals, corners[:, 0], axes, flat, Virtual(1).reconstruct(flat))


@dataclass(frozen=True, eq=False)
class FaceIntegrals:
    """Integrals over the faces of a mesh.

    - `areas`: (n_faces,).
    - `centroids`: (n_faces, 3).
    - `second`: integrals of products of coordinates about the centroid, (n_faces, 3, 3).
    - `weights`: integral of each corner's function over its face, ragged as ``mesh.face_points``.
    """

    areas: Floats
    centroids: Floats
    second: Floats
    weights: Floats

    @classmethod
    def of(cls, mesh: PolyhedralMesh) -> "FaceIntegrals":
        """Integrate in the planes of the faces."""
        n = mesh.n_faces
        result = cls(np.empty(n), np.empty((n, 3)), np.empty((n, 3, 3)), np.empty(len(mesh.face_points)))
        for batch in face_batches(mesh, np.arange(n)):
            faces, plane = batch.faces, batch.plane
            result.areas[faces] = plane.areas
            result.centroids[faces] = batch.in_space(plane.frame.origin[None])[:, 0]
            # about the centroid x = inverse xi, with the coordinates xi of the plane's frame
            inverse = np.einsum("aei,abe->eib", batch.axes, plane.frame.inverse)
            squares = monomials.mass(1, plane.moments)[1:, 1:]
            result.second[faces] = np.einsum("eia,abe,ejb->eij", inverse, squares, inverse)
            result.weights[batch.places] = np.einsum("ae,ave->ev", plane.moments[:3], plane.value)
        return result


@dataclass(frozen=True, eq=False)
class PolyhedralCells:
    """Integrals over all cells of a mesh of polyhedra.

    - `frame`: principal frames, in which each cell has the second moments of the unit ball.
    - `volumes`: (n_cells,).
    - `normals`: see `Polyhedra`, ragged as ``mesh.cell_points``, (m, 3).
    """

    mesh: PolyhedralMesh
    frame: Frame
    volumes: Floats
    normals: Floats

    @classmethod
    def of(cls, mesh: PolyhedralMesh) -> "PolyhedralCells":
        """Sum up the integrals over faces.

        Of a homogeneous function f of degree q about a point, ``(q + 3) int_P f = sum over faces of h int_F f`` with
        the height h of that point behind the face (Lasserre, 1998, Proc. AMS 126).
        """
        faces, of_side = FaceIntegrals.of(mesh), mesh.side_faces
        outward = mesh.face_vectors[of_side] * mesh.side_signs[:, None]
        outward /= faces.areas[of_side, None]
        cells, starts = row_numbers(mesh.side_offsets), mesh.side_offsets[:-1]
        base = mesh.points[mesh.cell_points[mesh.cell_offsets[:-1]]]
        centres, areas = faces.centroids[of_side] - base[cells], faces.areas[of_side]
        volumes = np.add.reduceat(np.einsum("si,si->s", centres, outward) * areas, starts) / 3.0
        first = np.einsum("si,si,s,sj->sj", centres, outward, areas, centres)
        middle = np.add.reduceat(first, starts) / (4.0 * volumes[:, None])
        arms = centres - middle[cells]
        heights = np.einsum("si,si->s", arms, outward)
        squares = faces.second[of_side] + areas[:, None, None] * arms[:, :, None] * arms[:, None]
        second = np.add.reduceat(heights[:, None, None] * squares, starts) / 5.0
        factor = batched.cholesky(np.moveaxis(second, 0, -1) / (SECOND_MOMENT * volumes))
        unit = np.broadcast_to(np.eye(3)[:, :, None], factor.shape)
        frame = Frame((base + middle).T, batched.solve_lower(factor, unit))
        sides, corners = mesh.side_corners
        on_corners = outward[sides] * faces.weights[corners, None]
        normals = sums_at(mesh.cell_corners[1], on_corners, len(mesh.cell_points))
        return cls(mesh, frame, volumes, normals)

    def batch(self, cells: Indices, places: Ints, vertices: Floats) -> Polyhedra:
        """Cells with one number of vertices, (n_vertices, 3, n_cells).

        - `places`: of the vertices in ``mesh.cell_points``, (n_cells, n_vertices).
        """
        frame = self.frame.part(cells)
        squares = np.isin(np.arange(10), (4, 7, 9)) * SECOND_MOMENT  # of the coordinates, in the order of `exponents`
        squares[0] = 1.0
        moments = squares[:, None] * self.volumes[cells]
        normals = np.ascontiguousarray(np.moveaxis(self.normals[places], 0, -1))
        return Polyhedra(1, frame, frame.local(vertices), normals, moments)
