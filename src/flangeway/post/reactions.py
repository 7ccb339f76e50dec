"""Reactions of the supports of an elastic body, and residuals of its nodes."""

from dataclasses import dataclass

import numpy as np

from flangeway.geometry.arrays import cross_product
from flangeway.problems import ElasticField, RigidHandle, Spring, Support
from flangeway.solve import ElasticitySolution
from flangeway.solve.constraints import RANK, HandleNodes, Rows
from flangeway.types import Bools, Floats


@dataclass(frozen=True, eq=False)
class Reaction:
    """What one support does to the body.

    - `force`: components x and y, shape (2,); in a body of revolution, summed around the axis.
    - `moment`: moment about the origin, counter-clockwise.
    """

    support: Support
    force: Floats
    moment: float


def reactions(solution: ElasticitySolution) -> tuple[Reaction, ...]:
    """Reaction of each support, in the problem's order.

    Where two supports hold a node, each carries the force along the direction that it holds; if both hold the same
    direction, they share it equally. Together with the loads (applied forces of handles included) the reactions are in
    equilibrium.
    """
    problem, constraints = solution.problem, solution.constraints
    n_supports = len(problem.supports)
    forces, moments = np.zeros((n_supports, 2)), np.zeros(n_supports)
    _add_nodes(solution, constraints.node_rows, forces, moments)
    for handle in constraints.handles:
        _add_handle(solution, handle, forces, moments)
    springs = iter(solution.spring_forces)
    for number, support in enumerate(problem.supports):
        if isinstance(support, Spring):
            at_nodes = next(springs)
            forces[number] = at_nodes.sum(axis=0)
            moments[number] = cross_product(problem.space.nodes, at_nodes).sum()
    forces.setflags(write=False)
    return tuple(
        Reaction(support, force, float(moment))
        for support, force, moment in zip(problem.supports, forces, moments, strict=True)
    )


def _add_nodes(solution: ElasticitySolution, rows: Rows, forces: Floats, moments: Floats) -> None:
    """Share the reaction of each held node among the rows that hold it."""
    nodes, place = np.unique(rows.nodes, return_inverse=True)
    gram = np.zeros((len(nodes), 2, 2))
    np.add.at(gram, place, rows.directions[:, :, None] * rows.directions[:, None])
    values, vectors = np.linalg.eigh(gram)
    inverse = np.where(values > RANK, 1.0 / np.where(values > RANK, values, 1.0), 0.0)
    strain = np.einsum("nij,nj,nkj,nk->ni", vectors, inverse, vectors, solution.nodal_reactions[nodes])
    share = np.einsum("ni,ni->n", rows.directions, strain[place])
    _add(solution, rows, share[:, None] * rows.directions, forces, moments)


def _add(solution: ElasticitySolution, rows: Rows, at_nodes: Floats, forces: Floats, moments: Floats) -> None:
    """Add forces (n, 2) of rows with a node to those of their supports; the axis of revolution carries its own."""
    own = rows.supports >= 0
    supports = rows.supports[own]
    np.add.at(forces, supports, at_nodes[own])
    np.add.at(moments, supports, cross_product(solution.problem.space.nodes[rows.nodes[own]], at_nodes[own]))


def _add_handle(solution: ElasticitySolution, handle: HandleNodes, forces: Floats, moments: Floats) -> None:
    """Share the resultant on a handle among its prescribed motions and the supports on its nodes."""
    support = solution.problem.supports[handle.support]
    if not isinstance(support, RigidHandle):
        return
    resultant = np.einsum("nij,ni->j", handle.arms, solution.nodal_reactions[handle.nodes])
    resultant -= np.array([*support.force, support.moment])
    scale = np.array([1.0, 1.0, solution.problem.size])
    scaled = handle.rows.directions / scale
    share = scaled @ (np.linalg.pinv(scaled.T @ scaled, rcond=RANK, hermitian=True) @ (resultant / scale))
    own = handle.rows.nodes < 0
    mine = own & (handle.rows.supports == handle.support)
    x, y, turn = share[mine] @ handle.rows.directions[mine]
    forces[handle.support] += (x, y)
    moments[handle.support] += turn + float(cross_product(handle.pivot, np.array([x, y])))
    others = handle.rows.where(~own)
    _add(solution, others, share[~own, None] * others.directions[:, :2], forces, moments)


def nodal_residual(field: ElasticField, forces: Floats) -> Floats:
    """Forces that hold the unknowns against the loads and further forces: those of supports, shape (n_dofs, 2).

    The stiffness is assembled anew on all unknowns and multiplied with the displacements.

    - `field`: displacements and the problem with its loads.
    - `forces`: further forces on the nodes in the body's frame, those of contact, shape (n_nodes, 2).
    """
    return _internal_and_left(field, forces)[1]


def relative_nodal_residual(field: ElasticField, forces: Floats, held: Bools) -> float:
    """Maximum residual force at a node, over the maximum force there; zero without any force.

    It is that of `nodal_residual`, so it does not depend on the factor, the condensation and the contact iteration that
    found the displacements.

    - `field`: displacements and the problem with its loads.
    - `forces`: further forces on the nodes in the body's frame, those of contact, shape (n_nodes, 2).
    - `held`: which components of which nodes a support holds, shape (n_nodes, 2).
    """
    internal, left = _internal_and_left(field, forces)
    reference = max(float(np.abs(each).max(initial=0.0)) for each in (left, forces, internal))
    for spring in field.problem.springs:
        at_nodes = field.displacements[: len(forces)].ravel()
        left[: len(forces)] += (field.problem.spring_stiffness(spring) @ at_nodes).reshape(-1, 2)
    left[: len(forces)][held] = 0.0
    return float(np.abs(left).max()) / reference if reference > 0.0 else 0.0


def _internal_and_left(field: ElasticField, forces: Floats) -> tuple[Floats, Floats]:
    """Forces of the stiffness on the unknowns, and their residual against all others, each (n_dofs, 2)."""
    problem = field.problem
    internal: Floats = (problem.stiffness().full() @ field.displacements.ravel()).reshape(-1, 2)
    left = internal - (problem.load_vector() + problem.thermal_load_vector())
    left[: len(forces)] -= forces
    return internal, left
