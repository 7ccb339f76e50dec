"""Reactions of the supports of an elastic body, and residuals of its nodes."""

from dataclasses import dataclass
from typing import Any

import numpy as np

from flangeway.geometry.arrays import cross_product, frozen, max_magnitude
from flangeway.problems import ElasticField, Spring, Support
from flangeway.solve import ElasticitySolution
from flangeway.solve.constraints import RANK
from flangeway.types import Bools, Floats


@dataclass(frozen=True, eq=False)
class Reaction:
    """What one support does to the body.

    - `force`: components, shape (d,); in a body of revolution, summed around the axis.
    - `moment`: moment about the origin, counter-clockwise; in space its components, shape (3,).
    """

    support: Support
    force: Floats
    moment: Any


def reactions(solution: ElasticitySolution[Any]) -> tuple[Reaction, ...]:
    """Reaction of each support, in the problem's order.

    Where two supports hold a node, each carries the force along the direction that it holds; if both hold the same
    direction, they share it equally. Together with the loads (applied forces of handles included) the reactions are in
    equilibrium.
    """
    problem = solution.problem
    n_supports, d = len(problem.supports), problem.dimension
    forces, moments = np.zeros((n_supports, d)), np.zeros((n_supports, 3)[: d - 1])
    _add_rows(solution, forces, moments)
    springs = iter(solution.spring_forces)
    for number, support in enumerate(problem.supports):
        if isinstance(support, Spring):
            at_nodes = next(springs)
            forces[number] = at_nodes.sum(axis=0)
            moments[number] = _moments(problem.space.nodes, at_nodes).sum(axis=0)
    return tuple(map(Reaction, problem.supports, frozen(forces), moments))


def _moments(points: Floats, forces: Floats) -> Floats:
    """Moments of forces at points about the origin, both (n, d): (n,), in space (n, 3)."""
    return cross_product(points, forces) if points.shape[1] == 2 else np.cross(points, forces)


def _add_rows(solution: ElasticitySolution[Any], forces: Floats, moments: Floats) -> None:
    """Share the reaction of each held node, and that of the nodes of each handle, among the rows that hold them."""
    problem, rows, handles = solution.problem, solution.constraints.rows, solution.constraints.handles
    n_nodes, d, scale = problem.space.n_nodes, problem.dimension, problem.motion_scale
    on_groups, points = np.zeros((n_nodes + len(handles), 3)), problem.space.nodes[rows.nodes]
    on_groups[:n_nodes, :d] = solution.nodal_reactions
    for number, handle in enumerate(handles, n_nodes):
        resultant = np.einsum("nij,ni->j", handle.arms, solution.nodal_reactions[handle.nodes])
        on_groups[number] = resultant - np.array([*handle.support.force, handle.support.moment])
        points[(rows.nodes < 0) & (rows.groups == number)] = handle.pivot
    groups, group_rows, scaled, products = rows.products(scale)
    inverse = np.linalg.pinv(products, rcond=RANK, hermitian=True)
    strain = np.einsum("gij,gj->gi", inverse, on_groups[groups] / scale)
    parts = np.einsum("ni,ni->n", scaled, strain[group_rows])[:, None] * rows.directions
    turning = _moments(points, parts[:, :d])
    if d == 2:  # of a node its arm from the pivot is not a support's own
        turning += np.where(rows.nodes < 0, parts[:, 2], 0.0)
    supported = rows.supports >= 0  # the axis of revolution carries its own
    np.add.at(forces, rows.supports[supported], parts[supported, :d])
    np.add.at(moments, rows.supports[supported], turning[supported])


def nodal_residual(field: ElasticField[Any], forces: Floats) -> Floats:
    """Forces that hold the unknowns against the loads and further forces: those of supports, shape (n_dofs, d).

    The stiffness is assembled anew on all unknowns and multiplied with the displacements.

    - `field`: displacements and the problem with its loads.
    - `forces`: further forces on the nodes in the body's frame, those of contact, shape (n_nodes, d).
    """
    return _internal_and_left(field, forces)[1]


def relative_nodal_residual(field: ElasticField[Any], forces: Floats, held: Bools) -> float:
    """Maximum residual force at a node, over the maximum force there; zero without any force.

    It is that of `nodal_residual`, so it does not depend on the factor, the condensation and the contact iteration that
    found the displacements.

    - `field`: displacements and the problem with its loads.
    - `forces`: further forces on the nodes in the body's frame, those of contact, shape (n_nodes, d).
    - `held`: which components of which nodes a support holds, shape (n_nodes, d).
    """
    internal, left = _internal_and_left(field, forces)
    reference = max(max_magnitude(array) for array in (left, forces, internal))
    for spring in field.problem.springs:
        at_nodes = field.displacements[: len(forces)].ravel()
        left[: len(forces)] += (field.problem.spring_stiffness(spring) @ at_nodes).reshape(forces.shape)
    left[: len(forces)][held] = 0.0
    return max_magnitude(left) / reference if reference > 0.0 else 0.0


def _internal_and_left(field: ElasticField[Any], forces: Floats) -> tuple[Floats, Floats]:
    """Forces of the stiffness on the unknowns, and their residual against all others, each (n_dofs, d)."""
    problem = field.problem
    internal: Floats = (problem.stiffness().full() @ field.displacements.ravel()).reshape(-1, problem.dimension)
    left = internal - (problem.load_vector() + problem.thermal_load_vector())
    left[: len(forces)] -= forces
    return internal, left
