"""Solution of linear elasticity by one sparse Cholesky factor."""

from dataclasses import dataclass

import numpy as np
import scipy.sparse as sp

from flangeway._core import NotPositiveDefiniteError
from flangeway.errors import InputError
from flangeway.problems import ElasticField, Elasticity
from flangeway.solve.constraints import SupportConstraints, find_constraints
from flangeway.solve.free_motions import refuse_free_motions
from flangeway.solve.linear import solve_linear
from flangeway.solve.status import Status
from flangeway.space import DifferenceProduct, SymmetricMatrix
from flangeway.types import Floats


@dataclass(frozen=True, eq=False)
class ElasticitySolution(ElasticField):
    """Displacements of an elastic body in equilibrium.

    Parameters
    ----------
    problem, displacements
        See `flangeway.problems.ElasticField`.
    status
        How the computation ended.
    nodal_reactions
        Forces of supports without springs on the nodes, shape (n_nodes, 2).
    spring_forces
        Forces of each of ``problem.springs`` on the nodes, shape (n_springs, n_nodes, 2).
    handle_motions
        Translations x, y of the pivot and rotation of each of ``problem.handles``, shape (n_handles, 3).
    energy
        Strain energy, half the integral of stress times elastic strain, with the stabilisation's part.
    spring_energy
        Energy in the springs.
    load_work
        Work of the loads along the displacements, ``f . u``, thermal loads not counted. Without thermal loads, springs
        and prescribed motions it is twice the strain energy.
    constraints
        The supports as constraints.

    """

    status: Status
    nodal_reactions: Floats
    spring_forces: Floats
    handle_motions: Floats
    energy: float
    spring_energy: float
    load_work: float
    constraints: SupportConstraints

    def displacement_at_node(self, point: tuple[float, float]) -> Floats:
        """Displacement (2,) of the node at a given place; an InputError where there is none."""
        return self.displacements[self.problem.node_at(point)]


def solve_elasticity(problem: Elasticity) -> ElasticitySolution:
    """Solve for the displacements under all loads.

    Internal unknowns of cells are condensed before assembly and recovered afterwards.

    Raises
    ------
    InputError
        If supports contradict each other, the body can move as a whole, or its stiffness is singular otherwise.

    """
    constraints = find_constraints(problem)
    refuse_free_motions(problem, constraints)
    condensed = problem.condensed_stiffness()
    springs = [problem.spring_stiffness(spring) for spring in problem.springs]
    added = sum(springs, sp.csc_array((condensed.matrix.n, condensed.matrix.n)))
    matrix = condensed.matrix.plus(added) if springs else condensed.matrix
    product = DifferenceProduct(
        condensed.matrix,
        constraints.transform,
        axisymmetric=problem.axisymmetric,
        springs=added,
    )
    mechanical = problem.load_vector()
    thermal = problem.thermal_load_vector()
    load = condensed.condense(mechanical + thermal).ravel()
    applied, handle_forces = forces_on_handles(problem, constraints)
    reduced = _reduced(matrix, constraints)
    rhs = constraints.transform.T @ (load - product.at_nodes(constraints.shift)) + applied
    free_values, status = _solved(problem, reduced, constraints, rhs, product)
    nodal = constraints.transform @ free_values + constraints.shift
    displacements = condensed.recover(nodal, mechanical + thermal)
    spring_forces = np.array([-(spring @ nodal) for spring in springs]).reshape(-1, len(nodal) // 2, 2)
    # f - K_bi K_ii^-1 f_i is the condensed load
    reactions = (product.at_nodes(nodal) - load).reshape(-1, 2)
    internal = (reactions + spring_forces.sum(axis=0)).ravel()
    internal_work = float(np.sum(displacements * (mechanical + thermal))) + float(internal @ nodal)
    spring_energy = -0.5 * float(np.sum(spring_forces * nodal.reshape(1, -1, 2)))
    motions = _handle_motions(constraints, nodal)
    work = float(np.sum(displacements * mechanical)) + float(np.sum(handle_forces * motions))
    energy = 0.5 * internal_work - float(np.sum(displacements * thermal)) + problem.thermal_energy()
    for array in (displacements, reactions, spring_forces, motions):
        array.setflags(write=False)
    return ElasticitySolution(
        problem, displacements, status, reactions, spring_forces, motions, energy, spring_energy, work, constraints
    )


def _reduced(matrix: SymmetricMatrix, constraints: SupportConstraints) -> SymmetricMatrix:
    """Stiffness of the free unknowns."""
    if constraints.kept is not None:
        return matrix.restricted(constraints.kept)
    transform = constraints.transform
    return SymmetricMatrix.from_full(sp.csr_array(transform.T @ matrix.full() @ transform))


def forces_on_handles(problem: Elasticity, constraints: SupportConstraints) -> tuple[Floats, Floats]:
    """Forces applied to handles, on the free unknowns and as x, y and moment of each handle (n_handles, 3)."""
    applied = np.zeros(constraints.transform.shape[1])
    forces = np.zeros((len(constraints.handles), 3))
    for number, (handle, basis) in enumerate(zip(constraints.handles, constraints.bases, strict=True)):
        forces[number] = (*handle.support.force, handle.support.moment)
        applied[constraints.groups == problem.space.n_nodes + number] = basis.T @ forces[number]
    return applied, forces


def _handle_motions(constraints: SupportConstraints, nodal: Floats) -> Floats:
    """Motions of the handles by their nodes' displacements."""
    motions = np.empty((len(constraints.handles), 3))
    for number, handle in enumerate(constraints.handles):
        moved = nodal.reshape(-1, 2)[handle.nodes]
        motions[number] = np.linalg.lstsq(handle.arms.reshape(-1, 3), moved.ravel(), rcond=None)[0]
    return motions


def _solved(
    problem: Elasticity,
    matrix: SymmetricMatrix,
    constraints: SupportConstraints,
    rhs: Floats,
    product: DifferenceProduct,
) -> tuple[Floats, Status]:
    """Free unknowns, and their status."""
    try:
        return solve_linear(matrix, constraints.groups, rhs, product)
    except NotPositiveDefiniteError as error:
        group = int(constraints.groups[int(error.args[1])])
        place = f"its handle {group - problem.space.n_nodes}"
        if group < problem.space.n_nodes:
            x, y = problem.space.nodes[group]
            place = f"its node at ({x:g}, {y:g})"
        raise InputError(
            f"body `{problem.name}`, whose stiffness is singular: {place} can move without force",
            "elements with a stabilisation, on a mesh without empty cells or cells joined at one point only",
            "check the mesh with flangeway.mesh.check, and leave the element's stabilisation as published",
        ) from error
