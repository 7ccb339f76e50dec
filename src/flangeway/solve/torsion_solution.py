"""Solution of St. Venant's torsion by one sparse Cholesky factor."""

from dataclasses import dataclass

import numpy as np
import scipy.sparse as sp
from numpy.typing import NDArray

from flangeway._core import NotPositiveDefiniteError
from flangeway.errors import InputError
from flangeway.problems import Torsion
from flangeway.results import Result, ResultTable
from flangeway.solve.linear import solve_linear
from flangeway.solve.status import Status
from flangeway.space import SymmetricMatrix
from flangeway.types import Floats


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
    function.setflags(write=False)
    hole_values.setflags(write=False)
    return TorsionSolution(problem, status, function, problem.torsional_rigidity(function), hole_values)


def _solved(matrix: SymmetricMatrix, rhs: Floats) -> tuple[Floats, Status]:
    return solve_linear(matrix, np.arange(matrix.n, dtype=np.int32), rhs)


def _warping(problem: Torsion) -> tuple[Floats, Floats, Status]:
    """Hold one unknown of each connected part at zero, then shift each part to a zero mean."""
    stiffness, load, mesh = problem.stiffness(), problem.load_vector(), problem.space.mesh
    edges = sp.coo_array(
        (np.ones(mesh.n_edges), (mesh.edges[:, 0], mesh.edges[:, 1])), shape=(mesh.n_points, mesh.n_points)
    )
    labels = sp.csgraph.connected_components(edges, directed=False)[1]
    cell_parts = labels[mesh.cell_points[mesh.cell_offsets[:-1]]]
    used = np.unique(cell_parts)
    held = np.array([np.flatnonzero(labels == part)[0] for part in used])
    free = np.zeros(problem.space.n_dofs, dtype=np.bool_)
    for batch in problem.space.batches():
        free[batch.dofs] = True
    free[held] = False
    function = np.zeros(problem.space.n_dofs)
    function[free], status = _solved(stiffness.restricted(free), load[free])
    _remove_means(problem, function, cell_parts)
    return function, np.empty(0), status


def _remove_means(problem: Torsion, function: Floats, cell_parts: NDArray[np.integer]) -> None:
    """Subtract from the function its mean on each connected part, weighted by the shear modulus."""
    space = problem.space
    weights = problem.cell_moduli * space.element_mesh.cell_areas
    integrals = np.empty(space.mesh.n_cells)
    batches = list(space.batches())
    for batch in batches:
        reconstruction = batch.element.reconstruct(batch.outline)
        value = np.einsum("ame,me->ae", reconstruction.projected_value, function[batch.dofs])
        integrals[batch.cells] = np.einsum("ae,ae->e", reconstruction.moments[: len(value)], value)
    integrals *= problem.cell_moduli
    means = np.bincount(cell_parts, integrals) / np.maximum(np.bincount(cell_parts, weights), np.finfo(float).tiny)
    shift = np.zeros(space.n_dofs)
    for batch in batches:
        reconstruction = batch.element.reconstruct(batch.outline)
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
        reduced = SymmetricMatrix.from_full(tie.T @ stiffness.full() @ tie)
        rhs = tie.T @ load
        rhs[n_free:] += 2.0 * boundary.hole_areas
    else:
        reduced, rhs = stiffness.restricted(free), load[free]
    values, status = _solved(reduced, rhs)
    return np.append(values, 0.0)[number], values[n_free:], status
