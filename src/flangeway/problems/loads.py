"""Loads and supports of an elastic body: items of an `Elasticity` problem."""

from abc import ABC, abstractmethod
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from typing import Any, Protocol

import numpy as np

from flangeway.checks import are_finite, check_angle, is_finite
from flangeway.elements import Reconstruction, polygon_quadrature
from flangeway.elements.polyhedra import face_batches
from flangeway.elements.quadrature import edge_rule
from flangeway.errors import InputError, located, short
from flangeway.geometry.arrays import IntArray, Place, Point, norms, turned_right
from flangeway.materials import Material
from flangeway.mesh import PolyhedralMesh
from flangeway.space import CellBatch, Mesh, Space
from flangeway.space.functions import at_points
from flangeway.types import Bools, Floats, Indices, Ints, floats

# --- Numbers and functions of the points that a user gives: loads, displacements, temperatures.


NO_FORCE = 1e-12
"""Force on what can move relative to the maximum force of a load that is round-off."""

Scalar = float | Callable[[Floats], Floats]
"""A number, or a function of points (n, d) with values (n,)."""
Vector = Sequence[float] | Floats | Callable[[Floats], Floats]
"""A number for each of d coordinates, or a function of points (n, d) with values (n, d); d is 2, in space 3."""


def check_scalar(owner: str, value: Scalar) -> None:
    """Refuse what is neither a finite number nor a function."""
    if callable(value):
        return
    if not is_finite(value):
        allowed = "a finite number, or a function of points"
        raise InputError(f"{owner} = {short(value)}", allowed, "correct the value")


def check_vector(owner: str, value: Vector) -> None:
    """Refuse what is neither two or three finite numbers nor a function."""
    if not callable(value) and not are_finite(value, 2) and not are_finite(value, 3):
        raise _wrong_vector(owner, value, "two finite numbers, for x and y, in space three")


def _wrong_vector(owner: str, value: object, allowed: str) -> InputError:
    return InputError(
        f"{owner} = {short(value)}", f"{allowed}, or a function of points", "give all components, 0 for none"
    )


def scalar_at(owner: str, value: Scalar, points: Floats) -> Floats:
    """Values (n,) at points (n, d); an InputError if a function fails to give finite numbers."""
    return _at(owner, value, points, (len(points),))


def vector_at(owner: str, value: Vector, points: Floats) -> Floats:
    """Values (n, d) at points (n, d); an InputError if there are too few, or a function fails to give finite ones."""
    if not callable(value) and len(value) != points.shape[1]:
        raise _wrong_vector(owner, value, f"{points.shape[1]} numbers")
    return _at(owner, value, points, points.shape)


def _at(owner: str, value: Scalar | Vector, points: Floats, shape: tuple[int, ...]) -> Floats:
    if not callable(value):
        return np.broadcast_to(floats(value), shape)
    with located(f"{owner}: "):
        values = at_points(value, points.T).T
        if values.shape != shape:
            raise InputError(
                f"a function that gives shape {values.shape} for {len(points)} points",
                f"shape {shape}",
                f"write it for points of shape {points.shape}",
            )
    return values


# --- Integrals along edges of a space: what tractions and springs on named edges need.


def entries_between(unknowns: Indices, matrices: Floats) -> tuple[Ints, Ints, Floats]:
    """Rows, columns and entries, each (m,), of symmetric matrices (..., n, n) between unknowns (..., n)."""
    rows, columns, entries = np.broadcast_arrays(unknowns[..., None], unknowns[..., None, :], matrices)
    return rows.ravel().astype(np.int64), columns.ravel().astype(np.int64), entries.ravel()


@dataclass(frozen=True, eq=False)
class EdgeQuadrature:
    """Points of quadrature on edges, or on faces with one number of corners, with the traces of the nodes."""

    nodes: IntArray  # nodes of each edge in its direction, (n_edges, order + 1), or of each face, (n_faces, n)
    points: Floats  # (n_edges, n_points, d)
    weights: Floats  # lengths or areas that belong to the points, (n_edges, n_points)
    shapes: Floats  # values of the nodes' functions at the points, the same on every edge, (n_points, order + 1);
    # of faces (n_faces, n_points, n)
    normals: Floats  # outward unit normals, (n_edges, n_points, d)

    def products(self, depth: Floats | float) -> Floats:
        """Integrals of products of the nodes' functions times a depth (n_edges, n_points), (n_edges, n, n)."""
        axes_of_shapes = "eqm,eqn" if self.shapes.ndim == 3 else "qm,qn"
        return np.einsum(f"eq,{axes_of_shapes}->emn", self.weights * depth, self.shapes, self.shapes)

    def integrals(self, values: Floats) -> Floats:
        """Integrals of the nodes' functions times values (n_edges, n_points, d), (n_edges, n, d)."""
        axes_of_shapes = "eqm" if self.shapes.ndim == 3 else "qm"
        return np.einsum(f"eq,eqi,{axes_of_shapes}->emi", self.weights, values, self.shapes)


def boundary_quadrature(space: Space[Mesh], name: str) -> list[EdgeQuadrature]:
    """Quadrature on a named set of edges, or in space of faces, those with each number of corners by themselves.

    On faces functions are those of the plane virtual element; integrands of degree 2 beside them are exact.
    """
    mesh = space.mesh
    if not isinstance(mesh, PolyhedralMesh):
        return [edge_quadrature(space, space.plane_mesh.edge_set(name))]
    rules = []
    for batch in face_batches(mesh, mesh.face_set(name)):
        flat, weights = polygon_quadrature(batch.flat, 3)
        normals = batch.normals * mesh.face_sides[batch.faces, None]
        points = batch.in_space(flat)
        shapes = np.einsum("aqe,ame->eqm", batch.plane.at(flat), batch.plane.value)
        nodes = mesh.face_points[batch.places]
        rules.append(EdgeQuadrature(nodes, points, weights.T, shapes, np.broadcast_to(normals[:, None], points.shape)))
    return rules


def edge_quadrature(space: Space[Any], pairs: Indices, n_points: int | None = None) -> EdgeQuadrature:
    """Quadrature on edges given as pairs of points (n, 2), body on the left.

    Exact to degree ``2 n_points - 1``, by default ``2 order + 3``.

    On curved edges that is the degree along the edge of the integrand times its length or normal.
    """
    weights, shapes, slopes = edge_rule(space.order, space.order + 2 if n_points is None else n_points)
    nodes = space.edge_nodes(pairs)
    start = space.nodes[nodes[:, :1]]
    local = space.nodes[nodes] - start  # no digits are lost far from the origin
    along = slopes @ local
    lengths = norms(along)
    normals = turned_right(along) / lengths[..., None]
    return EdgeQuadrature(nodes, start + shapes @ local, lengths * weights, shapes, normals)


# --- Supports of an elastic body: items of an `Elasticity` problem.


def _check_place(owner: str, where: str | Place) -> None:
    if not isinstance(where, str) and not are_finite(where, 2) and not are_finite(where, 3):
        raise InputError(f"{owner} at {short(where)}", "the name of an edge set, or a point (x, y)", "correct it")


def axes(angle: float, dimension: int = 2) -> Floats:
    """Directions of the axes of a frame turned counter-clockwise, the rows of (2, 2); in space (3, 3), not turned."""
    if dimension == 3:
        return np.eye(3)
    turn = angle / (np.pi / 2.0)
    if turn == round(turn):  # quarter turns without round-off, so that unknowns stay apart
        angle_cos, angle_sin = ((1.0, 0.0), (0.0, 1.0), (-1.0, 0.0), (0.0, -1.0))[round(turn) % 4]
    else:
        angle_cos, angle_sin = np.cos(angle), np.sin(angle)
    return np.array([[angle_cos, angle_sin], [-angle_sin, angle_cos]])


@dataclass(frozen=True)
class PrescribedDisplacement:
    """Displacements given on named edges or faces or at a point, each component on its own.

    Parameters
    ----------
    where
        Name of an edge set, in space of a face set, or a point of the mesh.
    x, y, z
        Displacement along each axis: a number, a function of points (n, d) with values (n,), or None for free.
    angle
        Angle in radians from the x axis of space to the x axis of this support, counter-clockwise; in the plane.

    """

    where: str | Place
    x: Scalar | None = None
    y: Scalar | None = None
    angle: float = 0.0
    z: Scalar | None = None

    def __post_init__(self) -> None:
        owner = f"PrescribedDisplacement({short(self.where)})"
        _check_place(owner, self.where)
        check_angle(owner, "angle", self.angle)
        for name, value in zip("xyz", self.components, strict=True):
            if value is not None:
                check_scalar(f"{owner}: {name}", value)
        if self.components == (None, None, None):
            raise InputError(
                f"{owner} without x, y and z", "at least one of them", "give x=0.0 or y=0.0, or leave it out"
            )

    @property
    def components(self) -> tuple[Scalar | None, ...]:
        """Displacements along x, y, z."""
        return self.x, self.y, self.z


def fixed(where: str | Place, dimension: int = 2) -> PrescribedDisplacement:
    """Support that holds all components of named edges or faces, or of a point, at zero."""
    return PrescribedDisplacement(where, x=0.0, y=0.0, z=0.0 if dimension == 3 else None)


@dataclass(frozen=True)
class Spring:
    """Elastic support on named edges or at a point, fixed at its other end.

    Parameters
    ----------
    where
        Name of an edge set, in space of a face set, or a point of the mesh.
    x, y, z
        Stiffness along each axis, 0 for none: pressure per displacement on edges and faces, force per displacement at a
        point (in a body of revolution, of the whole circle).
    angle
        Angle in radians from the x axis of space to the x axis of this support, counter-clockwise.

    """

    where: str | Place
    x: float = 0.0
    y: float = 0.0
    angle: float = 0.0
    z: float = 0.0

    def __post_init__(self) -> None:
        owner = f"Spring({short(self.where)})"
        _check_place(owner, self.where)
        check_angle(owner, "angle", self.angle)
        if not all(is_finite(k) and k >= 0.0 for k in (self.x, self.y, self.z)) or self.x == self.y == self.z == 0.0:
            raise InputError(
                f"{owner}: stiffnesses x={self.x}, y={self.y}, z={self.z}",
                "numbers >= 0, and one of them positive",
                "give the stiffness along each axis; to hold a component take PrescribedDisplacement",
            )


@dataclass(frozen=True)
class RigidHandle:
    """Named edges that move as a rigid line: each of three motions is prescribed, or free under a force.

    Parameters
    ----------
    edges
        Name of an edge set.
    x, y
        Translation of the pivot, or None for free.
    rotation
        Rotation in radians, counter-clockwise and small, or None for free.
    force
        Applied force x, y; only along free translations.
    moment
        Applied moment about the pivot, counter-clockwise; only on a free rotation.
    pivot
        Point that the motion and the moment refer to; None is the middle of the edges' bounding box.

    """

    edges: str
    x: float | None = None
    y: float | None = None
    rotation: float | None = None
    force: Point = (0.0, 0.0)
    moment: float = 0.0
    pivot: Point | None = None

    def __post_init__(self) -> None:
        owner = f"RigidHandle({short(self.edges)})"
        for name, value in (("x", self.x), ("y", self.y), ("rotation", self.rotation), ("moment", self.moment)):
            if value is not None:
                check_scalar(f"{owner}: {name}", value)
        if self.rotation is not None:
            check_angle(owner, "rotation", self.rotation)
        check_vector(f"{owner}: force", self.force)
        if self.pivot is not None:
            check_vector(f"{owner}: pivot", self.pivot)
        actions = zip(("force x", "force y", "moment"), (*self.force, self.moment), strict=True)
        for name, motion, (action, load) in zip(("x", "y", "rotation"), self.prescribed, actions, strict=True):
            if motion is not None and load != 0.0:
                raise InputError(
                    f"{owner}: {name}={motion} and {action} = {load}",
                    "a motion, or a force on a free motion",
                    f"leave {name}=None to apply the {action}",
                )

    @property
    def prescribed(self) -> tuple[float | None, float | None, float | None]:
        """Translations x, y and rotation, None where free."""
        return self.x, self.y, self.rotation


Support = PrescribedDisplacement | Spring | RigidHandle


# --- Loads of an elastic body: items of an `Elasticity` problem.
#
# Every load gives the forces on all unknowns that do its work. Tractions are forces per area, that is per length of
# edge and per thickness; in a body of revolution they act all around the axis.


class LoadedProblem(Protocol):
    """What loads ask of the problem that they act on: see the same names of `flangeway.problems.Elasticity`."""

    @property
    def name(self) -> str: ...  # noqa: D102
    @property
    def space(self) -> Space[Any]: ...  # noqa: D102
    @property
    def materials(self) -> tuple[Material, ...]: ...  # noqa: D102
    @property
    def cell_material(self) -> Ints: ...  # noqa: D102
    def depth(self, points: Floats) -> Floats | float: ...  # noqa: D102
    def node_at(self, point: Sequence[float]) -> int: ...  # noqa: D102
    def cells_in(self, name: str | None) -> Bools: ...  # noqa: D102
    def thermal_forces(  # noqa: D102
        self, batch: CellBatch, reconstruction: Reconstruction, loads: "Sequence[TemperatureChange]"
    ) -> Floats: ...


class AppliedLoad(ABC):
    """A load; its subclasses are final."""

    @abstractmethod
    def check(self, problem: LoadedProblem) -> None:
        """Raise `InputError` where the load does not fit the problem."""

    @abstractmethod
    def forces(self, problem: LoadedProblem) -> Floats:
        """Forces on all unknowns, shape (n_dofs, d)."""


def refuse_held(load: AppliedLoad, problem: LoadedProblem, held: Bools) -> None:
    """Raise `InputError` for a load that acts on held displacements (n_nodes, d) alone, where it does nothing."""
    forces = np.abs(load.forces(problem))
    maximum = float(forces.max(initial=0.0))
    forces[: len(held)][held] = 0.0
    if maximum > 0.0 and forces.max() <= NO_FORCE * maximum:
        where = getattr(load, "edges", getattr(load, "at", None))
        raise InputError(
            f"{type(load).__name__}{'' if where is None else f' on {short(where)}'} of body {problem.name!r}: all that "
            "it acts on is held",
            "a load on what can move",
            "load other edges, hold fewer components, or leave the load out: it only changes the reaction",
        )


@dataclass(frozen=True)
class _EdgeLoad(AppliedLoad):
    """Force per area on named edges, in space on named faces."""

    edges: str

    @property
    def _name(self) -> str:
        return f"{type(self).__name__} on {short(self.edges)}"

    def check(self, problem: LoadedProblem) -> None:
        """See `AppliedLoad.check`."""
        problem.space.nodes_along(self.edges)

    def forces(self, problem: LoadedProblem) -> Floats:
        """See `AppliedLoad.forces`."""
        forces = np.zeros((problem.space.n_dofs, problem.space.dimension))
        for rule in boundary_quadrature(problem.space, self.edges):
            rows = (array.reshape(-1, forces.shape[1]) for array in (rule.points, rule.normals))
            values = self._tractions(*rows).reshape(rule.points.shape)
            weighted = replace(rule, weights=rule.weights * problem.depth(rule.points))
            np.add.at(forces, rule.nodes, weighted.integrals(values))
        return forces

    @abstractmethod
    def _tractions(self, points: Floats, normals: Floats) -> Floats:
        """Force per area at points with outward normals, each (n, d)."""


@dataclass(frozen=True)
class Traction(_EdgeLoad):
    """Force per area on named edges, in a direction that does not follow them.

    Parameters
    ----------
    edges
        Name of an edge set, in space of a face set.
    value
        Components x and y, in space z, or a function of points (n, d) with values (n, d).

    """

    value: Vector

    def __post_init__(self) -> None:
        check_vector(self._name, self.value)

    def _tractions(self, points: Floats, normals: Floats) -> Floats:  # noqa: ARG002 (it does not follow the edges)
        return vector_at(self._name, self.value, points)


@dataclass(frozen=True)
class Pressure(_EdgeLoad):
    """Pressure on named edges, positive into the body; it keeps the direction of the undeformed edges.

    Parameters
    ----------
    edges
        Name of an edge set, in space of a face set.
    value
        A number, or a function of points (n, d) with values (n,).

    """

    value: Scalar

    def __post_init__(self) -> None:
        check_scalar(self._name, self.value)

    def _tractions(self, points: Floats, normals: Floats) -> Floats:
        return -scalar_at(self._name, self.value, points)[:, None] * normals


@dataclass(frozen=True, eq=False)
class GivenForces(AppliedLoad):
    """Forces on all unknowns, shape (n_dofs, d)."""

    values: Floats

    def check(self, problem: LoadedProblem) -> None:
        """See `AppliedLoad.check`."""
        shape = (problem.space.n_dofs, problem.space.dimension)
        if self.values.shape != shape:
            raise InputError(f"forces of shape {self.values.shape}", f"{shape}", "give a force for each unknown")

    def forces(self, problem: LoadedProblem) -> Floats:  # noqa: ARG002 (they are given)
        """See `AppliedLoad.forces`."""
        return self.values


@dataclass(frozen=True)
class PointForce(AppliedLoad):
    """Force at a point of the mesh; in a body of revolution, the sum around the axis.

    The displacement below it grows without limit as the mesh is refined.

    Parameters
    ----------
    at
        Place of a node.
    force
        Components x and y, in space z.

    """

    at: Place
    force: Place

    def __post_init__(self) -> None:
        check_vector("PointForce(at)", self.at)
        check_vector(f"PointForce at {self.at}", self.force)
        if callable(self.at) or callable(self.force):
            raise InputError("PointForce with a function", "two numbers", "take Traction for distributed forces")

    def check(self, problem: LoadedProblem) -> None:
        """See `AppliedLoad.check`."""
        problem.node_at(self.at)

    def forces(self, problem: LoadedProblem) -> Floats:
        """See `AppliedLoad.forces`."""
        forces = np.zeros((problem.space.n_dofs, problem.space.dimension))
        forces[problem.node_at(self.at)] = vector_at(f"PointForce at {self.at}", self.force, forces[:1])[0]
        return forces


@dataclass(frozen=True)
class BodyForce(AppliedLoad):
    """Force per volume.

    Parameters
    ----------
    value
        Components x and y, in space z, or a function of points (n, d) with values (n, d).
    cells
        Name of the cell set that it acts on; None is the whole body.

    """

    value: Vector
    cells: str | None = None

    def __post_init__(self) -> None:
        check_vector("BodyForce", self.value)

    def check(self, problem: LoadedProblem) -> None:
        """See `AppliedLoad.check`."""
        if self.cells is not None:
            problem.space.mesh.cell_set(self.cells)

    def forces(self, problem: LoadedProblem) -> Floats:
        """See `AppliedLoad.forces`."""
        factors = problem.cells_in(self.cells).astype(np.float64)
        return _volume_forces(problem, self.value, factors)


@dataclass(frozen=True)
class Gravity(AppliedLoad):
    """Weight: density times an acceleration; every material needs its density.

    Parameters
    ----------
    acceleration
        Components x and y, in space z, in the units of the model: (0, -9810) in mm, s and t.

    """

    acceleration: Place

    def __post_init__(self) -> None:
        check_vector("Gravity", self.acceleration)
        if callable(self.acceleration):
            raise InputError("Gravity with a function", "two numbers", "take BodyForce")

    def check(self, problem: LoadedProblem) -> None:
        """See `AppliedLoad.check`."""
        _ = self._densities(problem)

    def forces(self, problem: LoadedProblem) -> Floats:
        """See `AppliedLoad.forces`."""
        return _volume_forces(problem, self.acceleration, self._densities(problem))

    def _densities(self, problem: LoadedProblem) -> Floats:
        densities = []
        for material in problem.materials:
            if material.density is None:
                raise InputError(f"Gravity on {material} without a density", "a material with one", "give density")
            densities.append(material.density)
        return np.array(densities)[problem.cell_material]


def _volume_forces(problem: LoadedProblem, value: Vector, factors: Floats) -> Floats:
    """Forces of a force per volume times a factor of each cell (n_cells,), on projections (Moherdaui 2021, 3.81)."""
    space = problem.space
    # a constant is of degree 0, times the radius of degree 1
    degree = 2 * space.order + 2 if callable(value) else space.order + 1
    forces = np.zeros((space.n_dofs, space.dimension))
    for batch in space.batches():
        here = factors[batch.cells]
        if not here.any():
            continue
        reconstruction = batch.reconstruction
        points, weights = batch.quadrature(degree)
        rows = points.swapaxes(1, 2)
        values = vector_at("a force per volume", value, rows.reshape(-1, space.dimension)).reshape(rows.shape)
        weights = weights * problem.depth(rows) * here
        products = np.einsum("aqe,qe,qei->iae", reconstruction.at(points), weights, values)
        np.add.at(forces, batch.dofs, np.einsum("iae,ame->mei", products, reconstruction.projected_value))
    return forces


@dataclass(frozen=True)
class TemperatureChange(AppliedLoad):
    """Thermal strain: a rise of temperature times the materials' coefficients of expansion.

    Parameters
    ----------
    change
        A number, or a function of points (n, d) with values (n,).
    cells
        Name of the cell set that it acts on; None is the whole body.

    """

    change: Scalar
    cells: str | None = None

    def __post_init__(self) -> None:
        check_scalar("TemperatureChange", self.change)

    def check(self, problem: LoadedProblem) -> None:
        """See `AppliedLoad.check`."""
        cells = problem.cells_in(self.cells)
        for number in np.unique(problem.cell_material[cells]):
            _ = problem.materials[number].thermal_strain

    def at(self, points: Floats) -> Floats:
        """Rise of temperature at points (n, d), shape (n,)."""
        return scalar_at("TemperatureChange", self.change, points)

    def forces(self, problem: LoadedProblem) -> Floats:
        """See `AppliedLoad.forces`."""
        forces = np.zeros((problem.space.n_dofs, problem.space.dimension))
        for batch in problem.space.batches():
            reconstruction = batch.reconstruction
            local = problem.thermal_forces(batch, reconstruction, [self])
            np.add.at(forces, batch.dofs, np.moveaxis(local, 0, -1))
        return forces
