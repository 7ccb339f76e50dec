"""Surfaces in space, rigid ones and faces of bodies, and the constraints between two of them."""

from abc import ABC, abstractmethod
from collections.abc import Mapping
from dataclasses import dataclass, field
from functools import cached_property

import numpy as np
import scipy.sparse as sp
import shapely
from scipy.spatial import cKDTree

from flangeway.checks import check_kind, check_positive
from flangeway.contact.pairs import Enforcement, Multiplier
from flangeway.elements.monomials import evaluate
from flangeway.elements.polyhedra import FaceIntegrals, face_batches
from flangeway.errors import InputError
from flangeway.geometry.arrays import norms, sums_at, units_of
from flangeway.mesh import PolyhedralMesh
from flangeway.mesh.connectivity import entries_of, row_numbers
from flangeway.problems import Elasticity
from flangeway.types import Floats, Ints

Vector = tuple[float, float, float]
Solid = Elasticity[PolyhedralMesh]

SAME_POINT = 1e-7
"""Distance of two nodes relative to the size of a body, along its surface, within which they are a pair."""

# --- What bodies are pressed on.


@dataclass(frozen=True)
class RigidSurface(ABC):
    """A surface that does not deform; a new one is a subclass.

    Parameters
    ----------
    at
        A point of it: its centre, or a point of the plane or of the axis.

    """

    at: Vector

    @abstractmethod
    def distances(self, points: Floats) -> tuple[Floats, Floats]:
        """Distances (n,) of points (n, 3) from the surface, negative inside, and its outward unit normals (n, 3)."""


@dataclass(frozen=True)
class RigidPlane(RigidSurface):
    """A plane; `normal` points out of the rigid body, towards the other one, of any length."""

    normal: Vector

    def distances(self, points: Floats) -> tuple[Floats, Floats]:
        """See `RigidSurface.distances`."""
        unit = np.array(self.normal) / np.linalg.norm(self.normal)
        return (points - self.at) @ unit, np.tile(unit, (len(points), 1))


@dataclass(frozen=True)
class RigidSphere(RigidSurface):
    """A ball about the point `at`, of a radius > 0."""

    radius: float

    def __post_init__(self) -> None:
        check_positive(type(self).__name__, "radius", self.radius, "a positive length")

    def distances(self, points: Floats) -> tuple[Floats, Floats]:
        """See `RigidSurface.distances`."""
        arms = self._arms(points)
        return norms(arms) - self.radius, units_of(arms)

    def _arms(self, points: Floats) -> Floats:
        return points - self.at


@dataclass(frozen=True)
class RigidCylinder(RigidSphere):
    """A cylinder of any length; `axis` is its direction, of any length."""

    axis: Vector

    def _arms(self, points: Floats) -> Floats:
        unit, arms = np.array(self.axis) / np.linalg.norm(self.axis), points - self.at
        return arms - (arms @ unit)[:, None] * unit


@dataclass(frozen=True, eq=False)
class FaceSurface:
    """Faces of a body in space, with its loads and supports, where contact can happen.

    Parameters
    ----------
    body
        The body. Contact may be what holds it.
    faces
        Name of a face set.

    """

    body: Solid
    faces: str

    def __post_init__(self) -> None:
        check_kind("FaceSurface", "body", self.body, Elasticity, "an Elasticity on polyhedra", "make one")
        if self.body.dimension != 3:
            raise InputError(f"FaceSurface of {self.body.name}, a plane body", "a body in space", "take Surface")
        _ = self.numbers

    @cached_property
    def numbers(self) -> Ints:
        """Numbers of the faces."""
        return self.body.space.mesh.face_set(self.faces).astype(np.int64)

    @cached_property
    def nodes(self) -> Ints:
        """Nodes of the faces, rising."""
        return self.body.space.nodes_along(self.faces)

    @cached_property
    def areas(self) -> Floats:
        """Integrals of the nodes' functions over the faces, shape (n,)."""
        mesh = self.body.space.mesh
        at = entries_of(mesh.face_offsets, self.numbers)[0]
        weights = FaceIntegrals.of(mesh).weights[at]
        return sums_at(np.searchsorted(self.nodes, mesh.face_points[at]), weights, len(self.nodes))

    @cached_property
    def node_normals(self) -> Floats:
        """Outward normals, means over the faces about the nodes by their areas, as unit vectors (n, 3)."""
        mesh = self.body.space.mesh
        at, offsets = entries_of(mesh.face_offsets, self.numbers)
        faces, nodes = self.numbers[row_numbers(offsets)], np.searchsorted(self.nodes, mesh.face_points[at])
        return units_of(sums_at(nodes, mesh.face_vectors[faces] * mesh.face_sides[faces, None], len(self.nodes)))


@dataclass(frozen=True, eq=False)
class SpatialContact:
    """Contact without friction in space.

    A node of the secondary that lies on a node of the primary is paired with it; another one with the primary's face
    behind or in front of it, whose functions are projected onto linear ones. Cut faces of both sides into common ones
    (`flangeway.mesh.matched`), so that all are pairs of nodes: a uniform pressure is then exact.

    Parameters
    ----------
    secondary
        Surface whose nodes must not enter the other one.
    primary
        A rigid surface, or the faces of another body.
    enforcement
        Law of contact: `Multiplier`, `Penalty` or `Barrier`.

    """

    secondary: FaceSurface
    primary: RigidSurface | FaceSurface
    enforcement: Enforcement = field(default_factory=Multiplier)

    def __post_init__(self) -> None:
        check_kind("SpatialContact", "secondary", self.secondary, FaceSurface, "a FaceSurface", "make one of a body")
        kinds = RigidSurface | FaceSurface
        check_kind("SpatialContact", "primary", self.primary, kinds, "a RigidSurface or FaceSurface", "make one")
        if np.isfinite(self.enforcement.tolerance()):
            raise InputError("SpatialContact(enforcement=AugmentedLagrange(...))", "another law", "take Multiplier()")

    @property
    def mover(self) -> Solid | RigidSurface:
        """The primary's body, or the rigid surface itself."""
        return self.primary if isinstance(self.primary, RigidSurface) else self.primary.body

    @cached_property
    def pairs(self) -> "SpatialPairs":
        """The constraints."""
        side, primary = self.secondary, self.primary
        if isinstance(primary, FaceSurface):
            return _on_faces(side, primary)
        gaps, normals = primary.distances(side.body.space.nodes[side.nodes])
        return SpatialPairs(side.nodes, gaps, normals, side.areas, sp.csr_array(np.ones((len(gaps), 1))))

    def gradients(self, mover: Solid | RigidSurface) -> sp.csr_array:
        """Derivatives of the gaps by the displacements of a body's nodes, (m, 3 n_nodes), or of a rigid surface."""
        n = 1 if isinstance(mover, RigidSurface) else mover.space.n_nodes
        result = sp.csr_array((len(self.pairs.keys), n))
        if mover == self.secondary.body:
            result += sp.eye_array(n, format="csr")[self.pairs.keys]
        if mover == self.mover:
            result -= self.pairs.weights
        along = zip(self.pairs.normals.T, np.eye(3), strict=True)
        return sp.csr_array(sum(sp.diags_array(normals) @ sp.kron(result, unit[None]) for normals, unit in along))

    def measured(self, fields: Mapping[Solid | RigidSurface, Floats]) -> tuple[Floats, float]:
        """Displaced nodes less the points of the primary that they are paired with, (m, 3), and the deepest overlap.

        The overlap is that of all nodes of the secondary's body with a rigid surface, or of the pairs.

        - `fields`: displacements of the nodes of bodies (n_nodes, 3), and of rigid surfaces (1, 3).
        """
        body, pairs = self.secondary.body, self.pairs
        after = body.space.nodes + fields[body]
        if isinstance(self.primary, RigidSurface):
            distances, normals = self.primary.distances(after - fields.get(self.primary, 0.0))
            return (distances[:, None] * normals)[pairs.keys], -float(distances.min())
        arms = after[pairs.keys] - pairs.weights @ (self.primary.body.space.nodes + fields[self.primary.body])
        return arms, -float(np.einsum("mi,mi->m", arms, pairs.normals).min(initial=0.0))


@dataclass(frozen=True, eq=False)
class SpatialPairs:
    """m constraints, each of one node of the secondary.

    - `keys`: the nodes, numbers of the secondary's body, (m,).
    - `gaps`: of the undeformed bodies, (m,).
    - `normals`: of the primary, towards the secondary, (m, 3).
    - `areas`: that belong to the nodes, (m,).
    - `weights`: of the primary's nodes at the constraints' points, (m, n_nodes); ones, (m, 1), where it is rigid.
    """

    keys: Ints
    gaps: Floats
    normals: Floats
    areas: Floats
    weights: sp.csr_array

    @property
    def whole_areas(self) -> Floats:
        """The areas."""
        return self.areas


def _on_faces(secondary: FaceSurface, primary: FaceSurface) -> SpatialPairs:
    """Pairs of nodes, and of nodes with the faces onto which they are projected along the faces' normals."""
    points, others = secondary.body.space.nodes[secondary.nodes], primary.body.space.nodes
    reach, n = SAME_POINT * primary.body.size, len(points)
    nearest = cKDTree(others[primary.nodes]).query(points)[1]
    arms, normals = points - others[primary.nodes[nearest]], primary.node_normals[nearest]
    gaps = np.einsum("ni,ni->n", arms, normals)
    paired = norms(arms - gaps[:, None] * normals) <= reach
    heights = np.where(paired, 0.0, np.inf)
    partners = [(primary.nodes[nearest[i : i + 1]], np.ones(1)) for i in range(n)]
    mesh = primary.body.space.mesh
    for batch in face_batches(mesh, primary.numbers):
        outward = batch.normals * mesh.face_sides[batch.faces, None]
        shapes = shapely.polygons(np.moveaxis(batch.flat, -1, 0))
        corners = mesh.face_points[batch.places].astype(np.int64)
        for face, shape in enumerate(shapes):
            offsets = points - batch.base[face]
            height, flat = offsets @ outward[face], offsets @ batch.axes[:, face].T
            inside = (np.abs(height) < heights) & (secondary.node_normals @ outward[face] < 0.0)
            inside &= shapely.distance(shape, shapely.points(flat)) <= reach
            heights[inside], gaps[inside], normals[inside] = np.abs(height[inside]), height[inside], outward[face]
            values = evaluate(1, batch.plane.frame.part(np.array([face])).local(flat[inside, :, None]))
            for place, shares in zip(
                np.flatnonzero(inside),
                np.einsum("aq,av->qv", values[..., 0], batch.plane.value[..., face]),
                strict=True,
            ):
                partners[place] = corners[face], shares
    kept = np.flatnonzero(np.isfinite(heights))
    weights = sp.lil_array((len(kept), len(others)))
    for row, (columns, values) in enumerate(partners[i] for i in kept):
        weights[row, columns] = values
    return SpatialPairs(secondary.nodes[kept], gaps[kept], normals[kept], secondary.areas[kept], sp.csr_array(weights))
