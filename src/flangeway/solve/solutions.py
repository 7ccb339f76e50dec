"""Solutions by one sparse Cholesky factor: plane elasticity, bodies at one wavenumber, torsion."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
import scipy.sparse as sp
from numpy.typing import NDArray

from flangeway._core import NotPositiveDefiniteError
from flangeway.errors import InputError
from flangeway.geometry.arrays import frozen, point_text
from flangeway.mesh.connectivity import connected
from flangeway.problems import ElasticField, Elasticity, PointForce, Pressure, Torsion, Traction
from flangeway.problems.harmonic import Harmonic
from flangeway.problems.loads import refuse_held
from flangeway.results import Result, ResultTable
from flangeway.solve.constraints import SupportConstraints, find_constraints, refuse_free_motions
from flangeway.solve.linear import solve_linear
from flangeway.solve.status import Status
from flangeway.space import DifferenceProduct, Mesh, SymmetricMatrix
from flangeway.types import Bools, Floats

# --- Solution of linear elasticity by one sparse Cholesky factor.


@dataclass(frozen=True, eq=False)
class ElasticitySolution(ElasticField[Mesh]):
    """Displacements of an elastic body in equilibrium.

    Parameters
    ----------
    problem, displacements
        See `flangeway.problems.ElasticField`.
    status
        How the computation ended.
    nodal_reactions
        Forces of supports without springs on the nodes, shape (n_nodes, d).
    spring_forces
        Forces of each of ``problem.springs`` on the nodes, shape (n_springs, n_nodes, d).
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

    def displacement_at_node(self, point: Sequence[float]) -> Floats:
        """Displacement (d,) of the node at a given place; an InputError where there is none."""
        return self.displacements[self.problem.node_at(point)]


def solve_elasticity(problem: Elasticity[Mesh]) -> ElasticitySolution[Mesh]:
    """Solve for the displacements under all loads.

    Internal unknowns of cells are condensed before assembly and recovered afterwards.

    Raises
    ------
    InputError
        If supports contradict each other, the body can move as a whole, or its stiffness is singular otherwise.

    """
    constraints = find_constraints(problem)
    refuse_free_motions(problem, constraints)
    d = problem.dimension
    held = (np.diff(constraints.transform.indptr) == 0).reshape(-1, d)
    for item in problem.loads:
        if isinstance(item, Traction | Pressure | PointForce):
            refuse_held(item, problem, held)
    condensed = problem.condensed_stiffness()
    springs = [problem.spring_stiffness(spring) for spring in problem.springs]
    added = sum(springs, sp.csc_array((condensed.matrix.n, condensed.matrix.n)))
    matrix = condensed.matrix.plus(added) if springs else condensed.matrix
    product = DifferenceProduct(
        condensed.matrix,
        constraints.transform,
        axisymmetric=problem.axisymmetric,
        springs=added,
        dimension=d,
    )
    mechanical = problem.load_vector()
    thermal = problem.thermal_load_vector()
    load = condensed.condense(mechanical + thermal).ravel()
    applied, handle_forces = forces_on_handles(problem, constraints)
    reduced = _reduced(matrix, constraints)
    rhs = constraints.transform.T @ (load - product.at_nodes(constraints.shift)) + applied
    free_values, status = _solved(problem, reduced, constraints, rhs, product)
    status = status.with_notices(problem.locking)
    nodal = constraints.transform @ free_values + constraints.shift
    displacements = condensed.recover(nodal, mechanical + thermal)
    spring_forces = np.array([-(spring @ nodal) for spring in springs]).reshape(-1, len(nodal) // d, d)
    # f - K_bi K_ii^-1 f_i is the condensed load
    reactions = (product.at_nodes(nodal) - load).reshape(-1, d)
    internal = (reactions + spring_forces.sum(axis=0)).ravel()
    internal_work = float(np.sum(displacements * (mechanical + thermal))) + float(internal @ nodal)
    spring_energy = -0.5 * float(np.sum(spring_forces * nodal.reshape(1, -1, d)))
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
    return matrix.transformed(constraints.transform)


def forces_on_handles(problem: Elasticity[Any], constraints: SupportConstraints) -> tuple[Floats, Floats]:
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
    problem: Elasticity[Any],
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
        location = f"its handle {group - problem.space.n_nodes}"
        if group < problem.space.n_nodes:
            location = f"its node at {point_text(problem.space.nodes[group])}"
        raise InputError(
            f"body `{problem.name}`, whose stiffness is singular: {location} can move without force",
            "elements with a stabilisation, on a mesh without empty cells or cells joined at one point only",
            "check the mesh with flangeway.mesh.check, and leave the element's stabilisation as published",
        ) from error


# --- Solution of prisms and bodies of revolution at one wavenumber.


@dataclass(frozen=True, eq=False)
class HarmonicSolution:
    """Amplitudes of the displacements at one wavenumber.

    Parameters
    ----------
    problem
        What was solved.
    wavenumber
        Wavenumber k of a prism, or harmonic n of a body of revolution.
    amplitudes
        U, V, W of all unknowns, shape (n_dofs, 3); see `flangeway.problems.harmonic`.
    energy
        Strain energy over a quarter wave's mean of ``cos^2`` (1 / 2): ``f . u / 2`` of the amplitudes, with the
        foundations'.
    status
        How the computation ended.

    """

    problem: Harmonic
    wavenumber: float
    amplitudes: Floats
    energy: float
    status: Status

    def displacements(self, along: float) -> Floats:
        """Displacements of all nodes at a place z (or angle t), shape (n_nodes, 3)."""
        return self.amplitudes[: self.problem.elasticity.space.n_nodes] * self._phases(along, 2, 1)

    def stresses(self, along: float) -> Floats:
        """Stresses at all cells' centres of gravity at a place z (or angle t), shape (n_cells, 6), see `NAMES`."""
        space = self.problem.elasticity.space
        result = np.empty((space.mesh.n_cells, 6))
        for batch in space.batches():
            polynomials = self.problem.cell_stresses(batch, self.amplitudes, self.wavenumber)[1]
            result[batch.cells] = polynomials[:, 0].T  # their frames have their origins there
        return result * self._phases(along, 4, 2)

    def _phases(self, along: float, n_even: int, n_odd: int) -> Floats:
        """Cosine for the even components, sine for the others that follow."""
        phase = self.wavenumber * along
        return np.repeat([np.cos(phase), np.sin(phase)], [n_even, n_odd])


def solve_harmonic(problem: Harmonic, wavenumber: float) -> HarmonicSolution:
    """Solve for the amplitudes at one wavenumber.

    At wavenumber 0 the displacements in the plane and those along z do not act on each other. What is not loaded then
    stays at rest, so that it needs no support.

    Parameters
    ----------
    problem
        Body, loads and supports.
    wavenumber
        Wavenumber k >= 0 of a prism, per length; whole number n >= 0 for a body of revolution.

    Raises
    ------
    InputError
        If the wavenumber is wrong, or the body can move without strain.

    """
    if not (np.isfinite(wavenumber) and wavenumber >= 0.0) or (problem.revolution and wavenumber != round(wavenumber)):
        raise InputError(
            f"the wavenumber {wavenumber}",
            "a whole number >= 0 of waves around the axis" if problem.revolution else "a finite number >= 0",
            "sum the solutions of several",
        )
    load = problem.load_vector()
    free = problem.free(wavenumber)
    if wavenumber == 0.0:
        free[:, :2] &= bool(load[:, :2].any())
        free[:, 2] &= bool(load[:, 2].any())
    matrix = problem.stiffness(wavenumber)
    transform = _transform(problem, free, wavenumber)
    if transform is None:
        reduced, rhs = matrix.restricted(free.ravel()), load[free]
    else:
        reduced = matrix.transformed(transform)
        rhs = transform.T @ load.ravel()
    try:
        values, status = solve_linear(reduced, (np.flatnonzero(free) // 3).astype(np.int32), rhs)
    except NotPositiveDefiniteError as error:
        unknown = int(np.flatnonzero(free)[int(error.args[1])])
        raise InputError(
            f"body `{problem.elasticity.name}` at wavenumber {wavenumber:g}: it can move along "
            f"{'xyz'[unknown % 3]} without force",
            "a body that is held, or on a foundation, in every direction in which it is loaded",
            "give held=... or foundations=...",
        ) from error
    status = status.with_notices(problem.elasticity.locking, problem.elasticity.facets)
    amplitudes = np.zeros(load.shape)
    if transform is None:
        amplitudes[free] = values
    else:
        amplitudes[:] = (transform @ values).reshape(-1, 3)
    return HarmonicSolution(problem, wavenumber, amplitudes, 0.5 * float(np.sum(load * amplitudes)), status)


def _transform(problem: Harmonic, free: Bools, wavenumber: float) -> sp.csr_array | None:
    """All amplitudes by the free ones, where a motion of the axis couples two of them (n = 1); else None."""
    if not problem.revolution or wavenumber != 1 or len(problem.axis_nodes) == 0:
        return None
    numbers = np.cumsum(free.ravel()) - 1
    at = np.flatnonzero(free)
    moved = problem.axis_nodes[free[problem.axis_nodes, 0]]
    rows = np.concatenate((at, 3 * moved + 2))
    columns = np.concatenate((numbers[at], numbers[3 * moved]))
    values = np.concatenate((np.ones(len(at)), -np.ones(len(moved))))
    return sp.csr_array((values, (rows, columns)), shape=(free.size, len(at)))


# --- Solution of St. Venant's torsion by one sparse Cholesky factor.


@dataclass(frozen=True, eq=False)
class TorsionSolution(Result):
    """Warping or Prandtl's function of a cross-section for a rate of twist of one.

    Parameters
    ----------
    problem
        The problem.
    status
        How the computation ended.
    function
        Unknowns of the warping function (mean zero, weighted by the shear modulus, over each connected part) or
        of Prandtl's function, shape (n_dofs,).
    torsional_rigidity
        Torque per rate of twist, ``G J``.
    hole_values
        Prandtl's function on each hole's boundary, shape (n_holes,); empty for the warping function.

    """

    problem: Torsion
    status: Status
    function: Floats
    torsional_rigidity: float
    hole_values: Floats

    @property
    def table(self) -> ResultTable:
        """Places of the nodes and the function there."""
        x, y = self.problem.space.nodes.T
        return ResultTable({"x": x, "y": y, "function": self.function[: len(x)]})

    @property
    def torsion_constant(self) -> float:
        """Torsional rigidity over the mean shear modulus, ``J``."""
        return self.torsional_rigidity / self.problem.mean_modulus


def solve_torsion(problem: Torsion) -> TorsionSolution:
    """Solve for the warping function or for Prandtl's function.

    With Lagrange elements the torsion constant of the warping function is an upper bound and that of Prandtl's function
    a lower bound of the meshed polygon's (both are minima of energies over fewer functions; Trefftz, 1935). Virtual
    elements of order 1 on triangles are Lagrange elements. On other cells no bound is certain, because a stabilisation
    may be softer than the energy that it replaces: with the published one both constants come out above the exact one
    on dual polygons of order 2 and 3, while `TraceStabilisation`, which is stiffer, enclosed it in most cases measured.

    Raises
    ------
    InputError
        If the stiffness is singular: a stabilisation is missing or the mesh is broken.

    """
    solve = _warping if problem.formulation == "warping" else _prandtl
    try:
        function, hole_values, status = solve(problem)
    except NotPositiveDefiniteError as error:
        raise InputError(
            "a torsion problem whose stiffness is singular",
            "elements with a stabilisation on a mesh without clockwise or empty cells",
            "check the mesh with flangeway.mesh.check, and leave the element's stabilisation as published",
        ) from error
    rigidity = problem.torsional_rigidity(function)
    return TorsionSolution(problem, status, frozen(function), rigidity, frozen(hole_values))


def _torsion_solved(matrix: SymmetricMatrix, rhs: Floats) -> tuple[Floats, Status]:
    return solve_linear(matrix, np.arange(matrix.n, dtype=np.int32), rhs)


def _warping(problem: Torsion) -> tuple[Floats, Floats, Status]:
    """Hold one unknown of each connected part at zero, then shift each part to a zero mean."""
    stiffness, load, mesh = problem.stiffness(), problem.load_vector(), problem.space.mesh
    labels = connected(mesh.edges, mesh.n_points)
    cell_parts = labels[mesh.cell_points[mesh.cell_offsets[:-1]]]
    used = np.unique(cell_parts)
    held = np.array([np.flatnonzero(labels == part)[0] for part in used])
    free = np.zeros(problem.space.n_dofs, dtype=np.bool_)
    for batch in problem.space.batches():
        free[batch.dofs] = True
    free[held] = False
    function = np.zeros(problem.space.n_dofs)
    function[free], status = _torsion_solved(stiffness.restricted(free), load[free])
    _remove_means(problem, function, cell_parts)
    return function, np.empty(0), status


def _remove_means(problem: Torsion, function: Floats, cell_parts: NDArray[np.integer]) -> None:
    """Subtract from the function its mean on each connected part, weighted by the shear modulus."""
    space = problem.space
    weights = problem.cell_moduli * space.element_mesh.cell_areas
    integrals = np.empty(space.mesh.n_cells)
    batches = list(space.batches())
    for batch in batches:
        reconstruction = batch.reconstruct()
        value = np.einsum("ame,me->ae", reconstruction.projected_value, function[batch.dofs])
        integrals[batch.cells] = np.einsum("ae,ae->e", reconstruction.moments[: len(value)], value)
    integrals *= problem.cell_moduli
    means = np.bincount(cell_parts, integrals) / np.maximum(np.bincount(cell_parts, weights), np.finfo(float).tiny)
    shift = np.zeros(space.n_dofs)
    for batch in batches:
        reconstruction = batch.reconstruct()
        shift[batch.dofs] = reconstruction.monomial_dofs[:, 0] * means[cell_parts[batch.cells]]
    function -= shift


def _prandtl(problem: Torsion) -> tuple[Floats, Floats, Status]:
    """Solve with zero on the outer boundary and one unknown for each hole's boundary.

    The condition of each hole, circulation of the shear strain equal to ``2 theta'`` times its area, is the natural one
    of the tied unknown.
    """
    space, boundary = problem.space, problem.boundary
    stiffness, load = problem.stiffness(), problem.load_vector()
    number = np.full(space.n_dofs, -1, dtype=np.int64)
    for batch in space.batches():
        number[batch.dofs] = 0
    number[space.edge_nodes(boundary.outer)] = -1
    for pairs in boundary.holes:
        number[space.edge_nodes(pairs)] = -1
    free = number == 0
    n_free, n_holes = int(free.sum()), len(boundary.holes)
    number[free] = np.arange(n_free)
    for hole, pairs in enumerate(boundary.holes):
        number[space.edge_nodes(pairs)] = n_free + hole
    if n_holes:
        kept = np.flatnonzero(number >= 0)
        tie = sp.csr_array((np.ones(len(kept)), (kept, number[kept])), shape=(space.n_dofs, n_free + n_holes))
        reduced = stiffness.transformed(tie)
        rhs = tie.T @ load
        rhs[n_free:] += 2.0 * boundary.hole_areas
    else:
        reduced, rhs = stiffness.restricted(free), load[free]
    values, status = _torsion_solved(reduced, rhs)
    return np.append(values, 0.0)[number], values[n_free:], status
