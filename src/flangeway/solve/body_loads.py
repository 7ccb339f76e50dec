"""Loads on bodies in contact: what they displace without contact, and their resultants."""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Literal

import numpy as np

from flangeway.errors import InputError, short
from flangeway.geometry import Placement
from flangeway.geometry.arrays import cross_product
from flangeway.problems import Body, Elasticity, LinearBody, PrescribedDisplacement
from flangeway.problems.loads import GivenForces, Load, Pressure, TemperatureChange
from flangeway.solve.linear import NO_UNKNOWNS, factorise
from flangeway.types import Bools, Floats

Kind = Literal["turning", "space", "edges"]
"""How a term of the loads turns with the body, see `BodyLoads`."""

KINDS_OF_FORCES: tuple[Kind, ...] = ("space", "edges")

BodyLoad = Load | PrescribedDisplacement
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
        warm = [_scaled(each, share) for each in self.warm]
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
    unknown = [each for each in items if not isinstance(each, BodyLoad)]
    if unknown:
        raise InputError(
            f"the load {short(unknown[0])} on body {body.name!r}",
            "Traction, Pressure, PointForce, BodyForce, Gravity, TemperatureChange or PrescribedDisplacement",
            "supports are Body(held=...) and Body(springs=...)",
        )
    loads = [each for each in items if isinstance(each, Load)]
    problem = replace(body.elasticity, loads=loads)
    warm = problem.thermal_loads
    n, held = problem.space.n_dofs, _shifts(body, [each for each in items if isinstance(each, PrescribedDisplacement)])
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
    # arms u_j times forces f_i: those of changes of temperature are no loads that turn the body
    acting = np.array([kind != "turning" for kind in kinds])[:, None, None] * forces
    moments = np.einsum("jn,in->ij", fields[..., 0], acting[..., 1]) - np.einsum(
        "jn,in->ij", fields[..., 1], acting[..., 0]
    )
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
    factor, product, condensed = factorise(body, NO_UNKNOWNS), body.product, body.condensed
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
