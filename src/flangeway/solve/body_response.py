"""How a set of placed linear bodies answers to forces on its surface nodes, and to loads of the bodies."""

from abc import ABC, abstractmethod
from collections.abc import Callable, Sequence
from copy import copy
from dataclasses import dataclass, replace
from typing import Literal, Self

import numpy as np
import scipy.sparse as sp
from numpy.typing import NDArray

from flangeway.errors import InputError, short
from flangeway.geometry import Placement
from flangeway.geometry.arrays import cross_product, starts_of
from flangeway.problems import Body, Elasticity, LinearBody, PrescribedDisplacement
from flangeway.problems.loads import AppliedLoad, GivenForces, Pressure, TemperatureChange
from flangeway.problems.nonlinear_body import LinearisedBody
from flangeway.solve.linear import NO_UNKNOWNS, factorise, ldlt
from flangeway.types import Bools, Floats, Ints

# --- Loads on bodies in contact: what they displace without contact, and their resultants.


Kind = Literal["turning", "space", "edges"]
"""How a term of the loads turns with the body, see `BodyLoads`."""

KINDS_OF_FORCES: tuple[Kind, ...] = ("space", "edges")

BodyLoad = AppliedLoad | PrescribedDisplacement
"""A load, or a displacement of what is held relative to the frame."""


@dataclass(frozen=True, eq=False)
class BodyLoads:
    """Displacements of a body under loads, without contact and in its own frame, and the resultants of the loads.

    Forces keep their direction in space while a handle turns the body: with the matrix R of its placement a force F of
    space acts along the body's axis b with ``sum_a R_ab F_a``. Pressures have the direction of their edges where
    motions placed the body, by the matrix P: their force f in its axes acts with ``sum_a (P^T R)_ab f_a``.
    Displacements by changes of temperature and of supports turn with the body. All are ``sum_i c_i u_i`` of terms i,
    and so are forces.

    Parameters
    ----------
    body
        The body.
    warm
        Changes of temperature.
    kinds
        Of each term: ``"turning"`` with the body, ``"space"`` for forces of space, ``"edges"`` for pressures.
    axes
        Axes a and b of each term, (n, 2).
    forces
        Forces of each term on all unknowns, shape (n, n_dofs, 2).
    fields
        Displacements by each term, shape (n, n_dofs, 2).
    sums
        Force x, y, moment about the frame's origin, and virial (sum of points times forces) of each term, shape (n, 4).
    moments
        Moments of the forces of term i at arms that are the displacements by term j, shape (n, n).

    """

    body: Body
    warm: tuple[TemperatureChange, ...]
    kinds: tuple[Kind, ...]
    axes: tuple[tuple[int, int], ...]
    forces: Floats
    fields: Floats
    sums: Floats
    moments: Floats

    def weights(self, rotation: Floats, given: Floats, constant: float = 1.0) -> Floats:
        """Factors c of the terms, shape (n,).

        By the matrices (2, 2) of the placement and of the one given before a handle turned it. With the derivative of
        the first one, and the constant 0, it is the derivative.
        """
        matrices = {"space": rotation, "edges": given.T @ rotation}
        return np.array(
            [
                constant if kind == "turning" else matrices[kind][a, b]
                for kind, (a, b) in zip(self.kinds, self.axes, strict=True)
            ]
        )

    def field(self, weights: Floats) -> Floats:
        """Displacements of all unknowns in the body's frame, shape (n_dofs, 2)."""
        return np.tensordot(weights, self.fields, 1)

    def resultant(self, weights: Floats, share: float, placement: Placement, pivot: Floats) -> Floats:
        """Of a share of the loads: force x and y in space, moment about a point of space, its derivative by the angle.

        Arms of the moment lead to where the loads displace their points; contact forces displace them too, see
        `BodyResponse.turning`.
        """
        x, y, moment, virial = share * (weights @ self.sums)
        moment += share**2 * (weights @ self.moments @ weights)
        (arm,) = placement.points(np.zeros((1, 2))) - pivot
        (force,) = placement.vectors(np.array([[x, y]]))
        moment = moment * np.linalg.det(placement.matrix) + arm[0] * force[1] - arm[1] * force[0]
        return np.array([*force, moment, -virial - arm @ force])

    def problem(self, weights: Floats, share: float) -> Elasticity:
        """The body's problem with a share of the loads as they act in its frame."""
        forces = share * np.tensordot(weights, self.forces, 1)
        warm = [_scaled(load, share) for load in self.warm]
        thermal = replace(self.body.elasticity, loads=warm).thermal_load_vector()
        return replace(self.body.elasticity, loads=[GivenForces(forces - thermal), *warm])


def _scaled(load: TemperatureChange, share: float) -> TemperatureChange:
    """A share of a change of temperature."""
    change = load.change
    return replace(load, change=(lambda points: share * change(points)) if callable(change) else share * change)


def loads_on(body: LinearBody, items: Sequence[BodyLoad]) -> BodyLoads:
    """Solve for the displacements of a body under loads, with what is held, pinned and on springs.

    Raises
    ------
    InputError
        If an item is none of `BodyLoad`, does not fit the body, or displaces what is not held.

    """
    if not isinstance(body, Body):
        raise InputError(
            f"loads on body {body.name!r}, which was given by its stiffness matrix",
            "forces and moments on its handle",
            "press(loads={part: (x, y, moment)}), or add the free displacements to its coordinates",
        )
    unknown = [item for item in items if not isinstance(item, BodyLoad)]
    if unknown:
        raise InputError(
            f"the load {short(unknown[0])} on body {body.name!r}",
            "Traction, Pressure, PointForce, BodyForce, Gravity, TemperatureChange or PrescribedDisplacement",
            "supports are Body(held=...) and Body(springs=...)",
        )
    loads = [item for item in items if isinstance(item, AppliedLoad)]
    problem = replace(body.elasticity, loads=loads)
    warm = problem.thermal_loads
    n, held = problem.space.n_dofs, _shifts(body, [item for item in items if isinstance(item, PrescribedDisplacement)])
    by_kind = {"turning": problem.thermal_load_vector(), "space": np.zeros((n, 2)), "edges": np.zeros((n, 2))}
    for load in loads:
        if not isinstance(load, TemperatureChange):
            by_kind["edges" if isinstance(load, Pressure) else "space"] += load.forces(problem)
    terms: list[tuple[Kind, tuple[int, int], Floats]] = []
    if by_kind["turning"].any() or held.any():
        terms.append(("turning", (0, 0), by_kind["turning"]))
    for kind in KINDS_OF_FORCES:
        for a, b in np.ndindex(2, 2):
            if by_kind[kind][:, a].any() and not (body.axisymmetric and a != b):
                term = np.zeros((n, 2))
                term[:, b] = by_kind[kind][:, a]
                terms.append((kind, (a, b), term))
    kinds, axes, values = zip(*terms, strict=True) if terms else ((), (), ())
    forces = np.array(values).reshape(-1, n, 2)
    fields, sums = _solved(body, forces, [held if kind == "turning" else None for kind in kinds])
    # changes of temperature are no loads that turn the body, nor do their forces keep their direction
    turning = [kind == "turning" for kind in kinds]
    sums[turning] = 0.0
    # arms u_j times forces f_i
    moments = np.einsum("jn,in->ij", fields[..., 0], forces[..., 1]) - np.einsum(
        "jn,in->ij", fields[..., 1], forces[..., 0]
    )
    moments[turning] = 0.0
    return BodyLoads(body, warm, kinds, axes, forces, fields, sums, moments)


def _shifts(body: Body, displacements: Sequence[PrescribedDisplacement]) -> Floats:
    """Displacements of what is held, zero elsewhere, shape (n_nodes, 2)."""
    shifts, problem = np.zeros((body.space.n_nodes, 2)), body.elasticity
    for item in displacements:
        nodes = problem.support_nodes(item)
        points = body.nodes[nodes]
        for component, value in enumerate((item.x, item.y)):
            if value is None:
                continue
            if item.angle != 0.0 or not body.supported[nodes, component].all():
                raise InputError(
                    f"a displacement of {short(item.where)} of body {body.name!r} in {'xy'[component]}",
                    f"components that are held, along the axes of the body; held is {body.held_by}",
                    "name it in Body(held=...) with this component too",
                )
            shifts[nodes, component] = value(points) if callable(value) else value
    return shifts


def _solved(body: Body, terms: Floats, shifts: Sequence[Floats | None]) -> tuple[Floats, Floats]:
    """Displacements (n, n_dofs, 2) and sums (n, 4) of terms of forces, with displacements of what is held."""
    free: Bools = body.free
    # whether the tangent of a nonlinear body is definite is decided with its contact
    tangent = isinstance(body, LinearisedBody)
    factor = ldlt(body.stiffness, body.free_nodes) if tangent else factorise(body, NO_UNKNOWNS)
    product, condensed = body.product, body.condensed
    fields, sums = np.zeros_like(terms), np.zeros((len(terms), 4))
    for number, (forces, shift) in enumerate(zip(terms, shifts, strict=True)):
        load = condensed.condense(forces)
        sums[number] = *load.sum(axis=0), cross_product(body.nodes, load).sum(), np.sum(body.nodes * load)
        nodal = np.zeros(2 * len(body.nodes)) if shift is None else shift.ravel().copy()
        right = (load.ravel() - (product.at_nodes(nodal) if nodal.any() else 0.0))[free]
        values = factor.solve(right)
        values += factor.solve(right - product.times(values))  # slender bodies lose digits in the factor
        nodal[free] += values
        fields[number] = condensed.recover(nodal, forces)
    return fields, sums


# --- How a set of placed linear bodies answers to forces on its surface nodes.
#
# Two ways give the same answers: `CondensedBodies` works on the surfaces alone, `SparseBodies` on all unknowns. The
# iteration for contact uses only `BodyResponse`.
#
# The surface nodes of all bodies are numbered one after the other; vectors on them have shape (n_nodes, 2) and the
# axes of space.


@dataclass(frozen=True, eq=False)
class SurfaceNodes:
    """The nodes of one body where contact can happen.

    Parameters
    ----------
    body
        The body.
    nodes
        Its nodes, shape (n,), without repetition.
    shifts
        What leads from the nodes to the surface that they represent, in the body's frame, shape (n, 2); left out: the
        nodes are on it.

    """

    body: LinearBody
    nodes: NDArray[np.int32]
    shifts: Floats | None = None

    @property
    def points(self) -> Floats:
        """Points of the surface in the body's frame, shape (n, 2)."""
        points: Floats = self.body.nodes[self.nodes]
        return points if self.shifts is None else points + self.shifts


@dataclass(frozen=True, eq=False)
class Constrained:
    """Constraints of an iteration about displacements of the touched nodes, shape (2 n_touched,).

    Their gaps and slips (k,) are ``violations + jacobian (u - displacements) + compliances * forces``, and forces (k,)
    act along the ``directions``, both (k, 2 n_touched).
    """

    displacements: Floats
    jacobian: sp.csr_array
    directions: sp.csr_array
    compliances: Floats
    violations: Floats

    def of(self, rows: Ints) -> "Constrained":
        """Some of the constraints."""
        return Constrained(
            self.displacements,
            sp.csr_array(self.jacobian[rows]),
            sp.csr_array(self.directions[rows]),
            self.compliances[rows],
            self.violations[rows],
        )


class BodyResponse(ABC):
    """Answers of placed bodies to forces on their surface nodes; subclasses are final."""

    digits: float | None = None
    """Decimal digits that round-off leaves of displacements; None where they are not estimated."""

    def __init__(self, surfaces: Sequence[SurfaceNodes]) -> None:
        self.surfaces = tuple(surfaces)
        counts = [len(surface.nodes) for surface in self.surfaces]
        self.offsets: Ints = starts_of(counts)
        self.body_of_node: Ints = np.repeat(np.arange(len(counts)), counts)
        self.n_nodes = int(self.offsets[-1])
        self._loads: dict[int, tuple[BodyLoads, Floats, float]] = {}

    def rotations(self, placements: Sequence[Placement]) -> Floats:
        """Matrix of each surface node's body, shape (n_nodes, 2, 2)."""
        matrices = np.stack([placement.matrix for placement in placements])
        return matrices[self.body_of_node]

    def loaded(self, loads: Sequence[BodyLoads | None], placements: Sequence[Placement], share: float) -> Self:
        """The same bodies with a share of loads, which displace them before any contact force acts.

        The bodies are linear, so displacements by loads and by contact forces add: the contact meets surfaces that the
        loads have moved. ``loads`` are those of each body, None for none, at ``placements`` before handles moved it.
        """
        result = copy(self)
        result._loads = {
            number: (load, placement.matrix, share)
            for number, (load, placement) in enumerate(zip(loads, placements, strict=True))
            if load is not None
        }
        return result

    def _by_loads(self, number: int, matrix: Floats, constant: float = 1.0) -> Floats:
        """Displacements (n_dofs, 2) of a body by its loads, in its frame; arguments as of `BodyLoads.weights`."""
        load, given, share = self._loads[number]
        return share * load.field(load.weights(matrix, given, constant))

    def reference(self, placements: Sequence[Placement]) -> Floats:
        """Positions of the surface nodes before contact deforms the bodies, shape (n_nodes, 2)."""
        parts = []
        for number, (surface, placement) in enumerate(zip(self.surfaces, placements, strict=True)):
            parts.append(placement.points(surface.points))
            if number in self._loads:
                moved = self._by_loads(number, placement.matrix)[surface.nodes]
                parts[-1] = parts[-1] + placement.vectors(moved)
        return np.concatenate(parts)

    def undeformed(self, placements: Sequence[Placement]) -> Floats:
        """Positions of the surface nodes without any load, shape (n_nodes, 2)."""
        pairs = zip(self.surfaces, placements, strict=True)
        return np.concatenate([placement.points(surface.points) for surface, placement in pairs])

    def resultant(self, number: int, placement: Placement, pivot: Floats) -> Floats:
        """Force x, y and moment about a point of space of a placed body's loads, and its derivative by the angle."""
        if number not in self._loads:
            return np.zeros(4)
        load, given, share = self._loads[number]
        return load.resultant(load.weights(placement.matrix, given), share, placement, pivot)

    def problem(self, number: int, placement: Placement) -> Elasticity:
        """Elastic problem behind a body, with its loads as they act in its frame."""
        if number not in self._loads:
            return self.surfaces[number].body.elasticity
        load, given, share = self._loads[number]
        return load.problem(load.weights(placement.matrix, given), share)

    def turning(self, number: int, placement: Placement) -> Floats | None:
        """What a turn by 1 rad adds to the displacements by loads of a body's surface nodes, in space; None: nothing.

        Shape (n, 2). Times contact forces it is the moment of the loads at arms that are the displacements by these
        forces (Maxwell's and Betti's theorem).
        """
        if number not in self._loads:
            return None
        field = self._by_loads(number, np.array([[0.0, -1.0], [1.0, 0.0]]) @ placement.matrix, 0.0)
        return placement.vectors(field[self.surfaces[number].nodes])

    @abstractmethod
    def displacements(self, rotations: Floats, touched: Ints, forces: Floats) -> Floats:
        """Displacements of all surface nodes under forces on some.

        Parameters
        ----------
        rotations
            From `rotations`.
        touched
            Surface nodes with the forces, rising, shape (n_touched,).
        forces
            Shape (n_touched, 2).

        Returns
        -------
        Floats
            Shape (n_nodes, 2).

        """

    @abstractmethod
    def tangent(
        self, rotations: Floats, touched: Ints, geometric: sp.csr_array, *, symmetric: bool = True
    ) -> Callable[[sp.csr_array], Floats]:
        """Solve ``(K + G) u = loads`` with both sides on the touched nodes.

        Parameters
        ----------
        rotations, touched
            As in `displacements`.
        geometric
            Stiffness G to be added on the touched nodes, shape (2 n_touched, 2 n_touched).
        symmetric
            Whether G is symmetric; with friction it is not.

        Returns
        -------
        Callable
            Called with loads, right-hand sides of shape (2 n_touched, m): displacements of the touched nodes, shape
            (2 n_touched, m).

        """

    def constrained(  # noqa: B027 (optional)
        self, rotations: Floats, touched: Ints, geometric: sp.csr_array, laws: Constrained
    ) -> tuple[Callable[[Ints, sp.csr_array], tuple[Floats, Floats]], Floats] | None:
        """Solve with constraints without a matrix of them all; None where that is not known.

        Parameters
        ----------
        rotations, touched, geometric
            As in `respond`.
        laws
            The constraints.

        Returns
        -------
        tuple or None
            A function of the rows (r,) of gaps and slips that vanish, and of what makes all forces of as many unknown
            ones, (k, r): all forces (k,), and all gaps and slips (k,). And an estimate of the displacement by a unit of
            each force, > 0, shape (k,).

        """

    def fields(self, rotations: Floats, forces: Floats) -> list[Floats]:
        """Displacements of all nodes of each body in its own frame, by forces and loads, each (n_dofs, 2).

        Parameters
        ----------
        rotations
            From `rotations`.
        forces
            Forces on all surface nodes, shape (n_nodes, 2).

        """
        result = self._fields_by_forces(rotations, forces)
        for number in self._loads:
            result[number] = result[number] + self._by_loads(number, rotations[self.offsets[number]])
        return result

    @abstractmethod
    def _fields_by_forces(self, rotations: Floats, forces: Floats) -> list[Floats]:
        """Those of `fields` by the forces alone."""

    @property
    @abstractmethod
    def n_unknowns(self) -> int:
        """Number of unknowns that an iteration works on."""


def turning(rotations: Floats) -> sp.csr_array:
    """Block-diagonal matrix that turns vectors on nodes from their bodies' axes into those of space.

    Parameters
    ----------
    rotations
        Matrix of each node's body, shape (n, 2, 2).

    """
    n = len(rotations)
    columns = np.repeat(np.arange(2 * n).reshape(n, 1, 2), 2, axis=1)
    starts = np.arange(0, 4 * n + 1, 2)
    return sp.csr_array((rotations.ravel(), columns.ravel(), starts), shape=(2 * n, 2 * n))
