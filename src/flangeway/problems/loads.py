"""Loads of an elastic body: items of an `Elasticity` problem.

Every load gives the forces on all unknowns that do its work. Tractions are forces per area, that is per length of edge
and per thickness; in a body of revolution they act all around the axis.
"""

from abc import ABC, abstractmethod
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Protocol

import numpy as np

from flangeway.elements import Reconstruction, polygon_quadrature
from flangeway.errors import InputError, short
from flangeway.geometry.arrays import Point
from flangeway.materials import Material
from flangeway.problems.edges import edge_quadrature
from flangeway.problems.prescribed import Scalar, Vector, check_scalar, check_vector, scalar_at, vector_at
from flangeway.space import CellBatch, Space
from flangeway.types import Bools, Floats, Ints


class LoadedProblem(Protocol):
    """What loads ask of the problem that they act on: see the same names of `flangeway.problems.Elasticity`."""

    @property
    def space(self) -> Space: ...  # noqa: D102
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


class Load(ABC):
    """A load; its subclasses are final."""

    @abstractmethod
    def check(self, problem: LoadedProblem) -> None:
        """Raise `InputError` where the load does not fit the problem."""

    @abstractmethod
    def forces(self, problem: LoadedProblem) -> Floats:
        """Forces on all unknowns, shape (n_dofs, 2)."""


@dataclass(frozen=True)
class _EdgeLoad(Load):
    """Force per area on named edges."""

    edges: str

    @property
    def _name(self) -> str:
        return f"{type(self).__name__} on {short(self.edges)}"

    def check(self, problem: LoadedProblem) -> None:
        """See `Load.check`."""
        problem.space.mesh.edge_set(self.edges)

    def forces(self, problem: LoadedProblem) -> Floats:
        """See `Load.forces`."""
        rule = edge_quadrature(problem.space, problem.space.mesh.edge_set(self.edges))
        values = self._tractions(rule.points.reshape(-1, 2), rule.normals.reshape(-1, 2)).reshape(rule.points.shape)
        weights = rule.weights * problem.depth(rule.points)
        at_nodes = np.einsum("eq,eqi,qm->emi", weights, values, rule.shapes)
        forces = np.zeros((problem.space.n_dofs, 2))
        np.add.at(forces, rule.nodes, at_nodes)
        return forces

    @abstractmethod
    def _tractions(self, points: Floats, normals: Floats) -> Floats:
        """Force per area at points with outward normals, each (n, 2)."""


@dataclass(frozen=True)
class Traction(_EdgeLoad):
    """Force per area on named edges, in a direction that does not follow them.

    Parameters
    ----------
    edges
        Name of an edge set.
    value
        Components x and y, or a function of points (n, 2) with values (n, 2).

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
        Name of an edge set.
    value
        A number, or a function of points (n, 2) with values (n,).

    """

    value: Scalar

    def __post_init__(self) -> None:
        check_scalar(self._name, self.value)

    def _tractions(self, points: Floats, normals: Floats) -> Floats:
        return -scalar_at(self._name, self.value, points)[:, None] * normals


@dataclass(frozen=True, eq=False)
class GivenForces(Load):
    """Forces on all unknowns, shape (n_dofs, 2)."""

    values: Floats

    def check(self, problem: LoadedProblem) -> None:
        """See `Load.check`."""
        if self.values.shape != (problem.space.n_dofs, 2):
            raise InputError(
                f"forces of shape {self.values.shape}", f"({problem.space.n_dofs}, 2)", "give a force for each unknown"
            )

    def forces(self, problem: LoadedProblem) -> Floats:  # noqa: ARG002 (they are given)
        """See `Load.forces`."""
        return self.values


@dataclass(frozen=True)
class PointForce(Load):
    """Force at a point of the mesh; in a body of revolution, the sum around the axis.

    The displacement below it grows without limit as the mesh is refined.

    Parameters
    ----------
    at
        Place of a node.
    force
        Components x and y.

    """

    at: Point
    force: Point

    def __post_init__(self) -> None:
        check_vector("PointForce(at)", self.at)
        check_vector(f"PointForce at {self.at}", self.force)
        if callable(self.at) or callable(self.force):
            raise InputError("PointForce with a function", "two numbers", "take Traction for distributed forces")

    def check(self, problem: LoadedProblem) -> None:
        """See `Load.check`."""
        problem.node_at(self.at)

    def forces(self, problem: LoadedProblem) -> Floats:
        """See `Load.forces`."""
        forces = np.zeros((problem.space.n_dofs, 2))
        forces[problem.node_at(self.at)] = self.force
        return forces


@dataclass(frozen=True)
class BodyForce(Load):
    """Force per volume.

    Parameters
    ----------
    value
        Components x and y, or a function of points (n, 2) with values (n, 2).
    cells
        Name of the cell set that it acts on; None is the whole body.

    """

    value: Vector
    cells: str | None = None

    def __post_init__(self) -> None:
        check_vector("BodyForce", self.value)

    def check(self, problem: LoadedProblem) -> None:
        """See `Load.check`."""
        if self.cells is not None:
            problem.space.mesh.cell_set(self.cells)

    def forces(self, problem: LoadedProblem) -> Floats:
        """See `Load.forces`."""
        factors = problem.cells_in(self.cells).astype(np.float64)
        return _volume_forces(problem, self.value, factors)


@dataclass(frozen=True)
class Gravity(Load):
    """Weight: density times an acceleration; every material needs its density.

    Parameters
    ----------
    acceleration
        Components x and y, in the units of the model: (0, -9810) in mm, s and t.

    """

    acceleration: Point

    def __post_init__(self) -> None:
        check_vector("Gravity", self.acceleration)
        if callable(self.acceleration):
            raise InputError("Gravity with a function", "two numbers", "take BodyForce")

    def check(self, problem: LoadedProblem) -> None:
        """See `Load.check`."""
        _ = self._densities(problem)

    def forces(self, problem: LoadedProblem) -> Floats:
        """See `Load.forces`."""
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
    forces = np.zeros((space.n_dofs, 2))
    for batch in space.batches():
        here = factors[batch.cells]
        if not here.any():
            continue
        reconstruction = batch.reconstruction
        points, weights = polygon_quadrature(batch.outline, degree)
        rows = points.swapaxes(1, 2)
        values = vector_at("a force per volume", value, rows.reshape(-1, 2)).reshape(rows.shape)
        weights = weights * problem.depth(rows) * here
        products = np.einsum("aqe,qe,qei->iae", reconstruction.at(points), weights, values)
        np.add.at(forces, batch.dofs, np.einsum("iae,ame->mei", products, reconstruction.projected_value))
    return forces


@dataclass(frozen=True)
class TemperatureChange(Load):
    """Thermal strain: a rise of temperature times the materials' coefficients of expansion.

    Parameters
    ----------
    change
        A number, or a function of points (n, 2) with values (n,).
    cells
        Name of the cell set that it acts on; None is the whole body.

    """

    change: Scalar
    cells: str | None = None

    def __post_init__(self) -> None:
        check_scalar("TemperatureChange", self.change)

    def check(self, problem: LoadedProblem) -> None:
        """See `Load.check`."""
        cells = problem.cells_in(self.cells)
        for number in np.unique(problem.cell_material[cells]):
            _ = problem.materials[number].thermal_strain

    def at(self, points: Floats) -> Floats:
        """Rise of temperature at points (n, 2), shape (n,)."""
        return scalar_at("TemperatureChange", self.change, points)

    def forces(self, problem: LoadedProblem) -> Floats:
        """See `Load.forces`."""
        forces = np.zeros((problem.space.n_dofs, 2))
        for batch in problem.space.batches():
            reconstruction = batch.reconstruction
            local = problem.thermal_forces(batch, reconstruction, [self])
            np.add.at(forces, batch.dofs, np.moveaxis(local, 0, -1))
        return forces
