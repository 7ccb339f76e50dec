"""Error norms, stresses by recovery, the error that they estimate, and refinement driven by it."""

from collections.abc import Callable
from dataclasses import dataclass
from functools import cached_property
from typing import Generic, TypeVar

import numpy as np
import scipy.sparse as sp

from flangeway.elements import Function, batched, monomials
from flangeway.elements.monomials import n_monomials
from flangeway.errors import InputError
from flangeway.geometry.arrays import frozen
from flangeway.mesh import PolyMesh, doerfler_marking, refined
from flangeway.mesh.curved import Curves
from flangeway.post.stress import OUTSIDE, Stresses, at_mesh_points, locate
from flangeway.problems import ElasticField, Elasticity
from flangeway.results import Result, ResultTable
from flangeway.solve import ElasticitySolution, Status
from flangeway.space import CellBatch, CellCoefficient, Coefficient, Space
from flangeway.space.functions import at_points, quadrature_degree
from flangeway.types import Floats, Ints

# --- Superconvergent patch recovery of stresses, and the error that it estimates.


MIN_SINGULAR_VALUE = 1e-11
"""Eigenvalue of a patch's normal equations, relative to the maximum, below which a polynomial is not seen by its
cells."""


@dataclass(frozen=True, eq=False)
class RecoveredStresses(Result):
    """Stresses of one order more than the reconstruction's, and the difference between both.

    - `coefficients`: polynomials of degree k of each cell in its patch's coordinates, shape (n_cells, 4,
      n_monomials(k)).
    - `scales`: lengths by which the patches' coordinates about the cells' centroids are divided, shape (n_cells,).
    """

    solution: ElasticField
    coefficients: Floats
    scales: Floats

    @cached_property
    def cell_errors(self) -> Floats:
        """Estimated error of the stresses in each cell in the energy norm, shape (n_cells,).

        It is the root of the integral of the differences' stress times strain. The energy of a virtual element's
        stabilisation is no part of it.
        """
        order = self.solution.space.order
        errors = energy_norms(self.solution, lambda batch, points: self._at(batch.cells, points), 2 * order)[0]
        return frozen(errors)

    @property
    def table(self) -> ResultTable:
        """Places of the mesh's points and the recovered stresses there."""
        x, y = self.solution.space.mesh.points.T
        return ResultTable(
            {"x": x, "y": y, **dict(zip(("xx", "yy", "xy", "zz"), self.nodal.components.T, strict=True))}
        )

    @property
    def error(self) -> float:
        """Estimated error of the stresses in the energy norm, the root of twice an energy."""
        return float(np.linalg.norm(self.cell_errors))

    @property
    def relative_error(self) -> float:
        """Estimated error over the energy norm of the solution (Zienkiewicz and Zhu, 1987); it needs a solution."""
        assert isinstance(self.solution, ElasticitySolution)
        size = np.sqrt(2.0 * max(self.solution.energy, 0.0) + self.error**2)
        return self.error / float(size) if size > 0.0 else 0.0

    @cached_property
    def corners(self) -> Stresses:
        """Recovered stresses at the cells' corners, in the order of ``mesh.cell_points``."""
        mesh = self.solution.space.mesh
        components = np.empty((len(mesh.cell_points), 4))
        for batch in self.solution.space.batches():
            entries = mesh.batch_places(len(batch.vertices), batch.cells)
            components[entries] = self._at(batch.cells, batch.vertices).transpose(2, 1, 0)
        return Stresses(components)

    def at(self, points: Floats) -> Stresses:
        """Recovered stresses at points (n, 2), each of the cell that it lies in; not-a-number outside of the body."""
        mesh = self.solution.space.mesh
        cells = locate(mesh, points)
        stresses = np.full((len(points), 4), np.nan)
        inside = cells != OUTSIDE
        polynomials = self._at(cells[inside], points[inside].T[None])
        stresses[inside] = polynomials[:, 0].T
        return Stresses(stresses)

    @property
    def nodal(self) -> Stresses:
        """Means of the recovered stresses at the mesh's points; of all cells there, whatever their material."""
        return at_mesh_points(self.solution.space.mesh, self.corners)

    def _at(self, cells: Ints, points: Floats) -> Floats:
        """Values (4, n_points, n_cells) at points (n_points, 2, n_cells) of cells."""
        centres = self.solution.space.mesh.cell_centroids[cells].T
        values = monomials.evaluate(self.solution.space.order, (points - centres) / self.scales[cells])
        return np.einsum("esb,bqe->sqe", self.coefficients[cells], values)


def energy_norms(solution: ElasticField, given: Callable[[CellBatch, Floats], Floats], degree: int) -> Floats:
    """Energy norms of given stresses less those of a solution, and of the given ones, in each cell, (2, n_cells).

    They are the roots of the integrals of stress times strain.

    - `given`: gives stresses xx, yy, xy, zz (4, n_points, n_cells) at points (n_points, 2, n_cells) of a batch.
    - `degree`: degree of the polynomials that are integrated exactly.
    """
    problem = solution.problem
    squares = np.empty((2, problem.space.mesh.n_cells))
    for batch in problem.space.batches():
        reconstruction, stress = problem.cell_stresses(batch, solution.displacements)
        points, weights = batch.quadrature(degree)
        wanted = given(batch, points)
        values = np.einsum("sae,aqe->sqe", stress, reconstruction.at(points)[: stress.shape[1]])
        weights = weights * problem.depth(points.swapaxes(1, 2))
        compliance = _compliances(problem)[:, :, problem.cell_material[batch.cells]]
        for number, field in enumerate((wanted - values, wanted)):
            strain = np.einsum("ste,tqe->sqe", compliance, field)
            squares[number, batch.cells] = np.einsum("sqe,sqe,qe->e", strain, field, weights)
    return np.sqrt(squares)


def _compliances(problem: Elasticity) -> Floats:
    """Strains per stress of the materials, in the plane without zz, shape (4, 4, n_materials)."""
    result = np.zeros((4, 4, len(problem.materials)))
    n = 4 if problem.axisymmetric else 3
    for number, material in enumerate(problem.materials):
        result[:n, :n, number] = np.linalg.inv(material.matrix[:n, :n])
    return result


def recovered_stresses(solution: ElasticField) -> RecoveredStresses:
    """Fit to each cell and its neighbours one polynomial of degree k whose projections are nearest to their stresses.

    The projection of a cell's stress onto polynomials of degree k - 1 converges faster than the stress itself, as at
    the superconvergent points of triangles and quadrilaterals (Zienkiewicz and Zhu, 1992, Int. J. Numer. Methods Eng.
    33), and exists on every polygon. A patch holds the cells of one material around a cell, with further ones where
    they are too few.

    Raises
    ------
    InputError
        If the body has fewer cells of a material than a polynomial needs.
    """
    problem = solution.problem
    mesh, order = problem.space.mesh, problem.space.order
    patches = _patches(problem, n_monomials(order), n_monomials(order - 1))
    scales = 2.0 * mesh.cell_diameters
    normal = np.zeros((mesh.n_cells, n_monomials(order), n_monomials(order)))
    rhs = np.zeros((mesh.n_cells, n_monomials(order), 4))
    for batch in problem.space.batches():
        reconstruction, stress = problem.cell_stresses(batch, solution.displacements)
        mass = problem.strains(batch, reconstruction).mass
        points, weights = batch.quadrature(2 * order)
        if problem.axisymmetric:
            weights = weights * points[:, 0]
        weighted = reconstruction.at(points)[: len(mass)] * weights
        # one pair for each patch, named by its middle cell, that a cell of the batch belongs to
        columns, middles = patches[batch.cells].tocoo().coords
        local = (points[:, :, columns] - mesh.cell_centroids[middles].T) / scales[middles]
        products = np.einsum("aqp,bqp->abp", weighted[:, :, columns], monomials.evaluate(order, local))
        projected = batched.solve(mass[:, :, columns], products)
        np.add.at(normal, middles, np.einsum("abp,acp->pbc", products, projected))
        np.add.at(rhs, middles, np.einsum("abp,sap->pbs", products, stress[:, :, columns]))
    return RecoveredStresses(solution, frozen(_solved(normal, rhs).swapaxes(1, 2)), scales)


def _patches(problem: Elasticity, n_wanted: int, n_each: int) -> sp.csr_array:
    """Which cells belong to which patch, symmetric, (n_cells, n_cells): those that share a point and the material."""
    mesh = problem.space.mesh
    cells = np.repeat(np.arange(mesh.n_cells), mesh.cell_sizes)
    shape = (mesh.n_cells, mesh.n_points)
    at_points = sp.csr_array((np.ones(len(cells)), (cells, mesh.cell_points)), shape=shape)
    neighbours = sp.coo_array(at_points @ at_points.T)
    first, second = neighbours.coords
    alike = problem.cell_material[first] == problem.cell_material[second]
    ring = sp.csr_array((np.ones(alike.sum()), (first[alike], second[alike])), shape=neighbours.shape)
    patches = ring
    while True:
        few = np.diff(patches.indptr) * n_each < n_wanted + 2
        if not few.any():
            return sp.csr_array(patches.T)
        grown = sp.csr_array(sp.diags_array(few.astype(np.float64)) @ patches @ ring)
        wider = sp.csr_array(patches + grown)
        if wider.nnz == patches.nnz:
            cell = int(few.argmax())
            raise InputError(
                f"stresses recovered in cell {cell}, which has too few cells of its material around it",
                f"{-(-(n_wanted + 2) // n_each)} joined cells of each material, or more",
                "refine the mesh",
            )
        patches = wider


def _solved(normal: Floats, rhs: Floats) -> Floats:
    """Least-squares solutions (n_cells, n, 4); what a patch does not see is left zero."""
    values, vectors = np.linalg.eigh(normal)
    seen = values > MIN_SINGULAR_VALUE * values[:, -1:]
    inverse = np.where(seen, 1.0 / np.where(seen, values, 1.0), 0.0)
    return (vectors * inverse[:, None]) @ (vectors.swapaxes(1, 2) @ rhs)


# --- Refinement driven by an error estimate: solve, estimate, mark, refine, again.


Solution = TypeVar("Solution")


@dataclass(frozen=True, eq=False)
class AdaptiveStep(Generic[Solution]):
    """One solution of an adaptive run.

    - `solution`: what `solve` gave.
    - `cell_errors`: estimated error of each cell, shape (n_cells,).
    """

    mesh: PolyMesh
    solution: Solution
    cell_errors: Floats

    @property
    def error(self) -> float:
        """Estimated error of the whole, the root of the sum of the squares."""
        return float(np.linalg.norm(self.cell_errors))


@dataclass(frozen=True, eq=False)
class AdaptiveRun(Result, Generic[Solution]):
    """Solutions on meshes of which each is refined where the error of the one before was maximum.

    - `steps`: first mesh first; at least one.
    - `status`: whether the tolerance was reached, in a sentence.
    """

    steps: tuple[AdaptiveStep[Solution], ...]
    status: Status

    @property
    def table(self) -> ResultTable:
        """Cells and estimated errors of its meshes."""
        cells, errors = [step.mesh.n_cells for step in self.steps], [step.error for step in self.steps]
        return ResultTable({"cells": cells, "estimated_error": errors})

    @property
    def last(self) -> AdaptiveStep[Solution]:
        """The finest."""
        return self.steps[-1]


def adapt(
    solve: Callable[[PolyMesh], Solution],
    mesh: PolyMesh,
    cell_errors: Callable[[Solution], Floats],
    *,
    tolerance: float,
    most_cells: int = 100_000,
    most_steps: int = 50,
    share: float = 0.5,
    most_hanging: int | None = 1,
    outline: Curves | None = None,
) -> AdaptiveRun[Solution]:
    """Refine a mesh until the estimated error is small enough.

    For example ``adapt(solve, mesh, lambda solution: recovered_stresses(solution).cell_errors, tolerance=0.1)`` with a
    function ``solve(mesh)`` that makes a space and a problem and solves it. The meshes get cells with hanging points,
    so elements must take polygons.

    Parameters
    ----------
    solve
        Gives a solution on a mesh.
    mesh
        First mesh.
    cell_errors
        Gives the estimated error of each cell, (n_cells,), such that their squares add up.
    tolerance
        Estimated error of the whole at which to end, in the units of `cell_errors`.
    most_cells
        No mesh is solved on that has more cells, except the first.
    most_steps
        Number of solutions at which to end.
    share
        Share of the squared error that the cells to refine hold, see `doerfler_marking`.
    most_hanging
        Most points that may hang on a side, see `refined`. On the L-shaped body one at most needs about a quarter fewer
        unknowns than no limit with order 2 from polygons, whose cells then get 12 points rather than 26, and about as
        many with quadrilaterals and other orders.
    outline
        Curves of the boundary, see `refined`.

    Returns
    -------
    AdaptiveRun
        Not reaching the tolerance is a result, reported by its status.

    Raises
    ------
    InputError
        If a number is out of its range, or the estimate is not one number for each cell.
    """
    if not (tolerance > 0.0 and most_steps >= 1):
        raise InputError(
            f"adapt(tolerance={tolerance}, most_steps={most_steps})",
            "a positive tolerance, and one step or more",
            "give the estimated error at which to end",
        )
    steps: list[AdaptiveStep[Solution]] = []
    while True:
        solution = solve(mesh)
        errors = np.array(cell_errors(solution), dtype=np.float64)
        if errors.shape != (mesh.n_cells,):
            raise InputError(
                f"cell errors of shape {errors.shape}", f"({mesh.n_cells},), one for each cell", "correct the estimate"
            )
        steps.append(AdaptiveStep(mesh, solution, frozen(errors)))
        if steps[-1].error <= tolerance:
            return _ended(steps, tolerance, "")
        if len(steps) == most_steps:
            return _ended(steps, tolerance, f"{most_steps} solutions; allow more steps")
        mesh = refined(mesh, doerfler_marking(errors, share), most_hanging=most_hanging, outline=outline)
        if mesh.n_cells > most_cells:
            return _ended(steps, tolerance, f"the next mesh has {mesh.n_cells} cells; allow more")


def _ended(steps: list[AdaptiveStep[Solution]], tolerance: float, reason: str) -> AdaptiveRun[Solution]:
    cells, error = steps[-1].mesh.n_cells, steps[-1].error
    if reason:
        message = f"The estimated error {error:.3g} on {cells} cells is above the tolerance {tolerance:.3g}: {reason}."
    else:
        message = f"The estimated error {error:.3g} on {cells} cells is within the tolerance {tolerance:.3g}."
    return AdaptiveRun(tuple(steps), Status(not reason, message, len(steps)))


def stress_errors(
    solution: ElasticitySolution, exact: Callable[[Floats], Floats], *, degree: int
) -> tuple[float, float]:
    """Energy norms, roots of the integrals of stress times strain, of a solution's error and of the exact stresses.

    - `solution`: plane strain or stress.
    - `exact`: gives stresses xx, yy, xy (n, 3) at points (n, 2).
    - `degree`: degree of the polynomials that are integrated exactly.
    """

    def given(_: CellBatch, points: Floats) -> Floats:
        in_plane = exact(np.moveaxis(points, 1, -1).reshape(-1, 2)).T.reshape(3, len(points), -1)
        return np.concatenate((in_plane, np.zeros_like(in_plane[:1])))

    error, size = np.linalg.norm(energy_norms(solution, given, degree), axis=1).tolist()
    return error, size


# --- Errors of a discrete function against an exact one, through the elements' reconstruction.


@dataclass(frozen=True)
class ErrorNorms:
    """Norms of an error and of the exact function over the mesh.

    - `l2`, `h1`: L2 norm of the error, and of the gradient's error (a seminorm), over all components.
    - `exact_l2`, `exact_h1`: the same of the exact function.
    - `energy`, `exact_energy`: roots of ``int grad e : C : grad e`` with the coefficient given, zero without.
    """

    l2: float
    h1: float
    exact_l2: float
    exact_h1: float
    energy: float = 0.0
    exact_energy: float = 0.0

    @property
    def relative_l2(self) -> float:
        """Error over the exact function, in L2."""
        return self.l2 / self.exact_l2

    @property
    def relative_h1(self) -> float:
        """Error over the exact function, in the H1 seminorm."""
        return self.h1 / self.exact_h1

    @property
    def relative_energy(self) -> float:
        """Error over the exact function, in energy."""
        return self.energy / self.exact_energy

    @property
    def errors(self) -> dict[str, float]:
        """The errors by their names; energy where a coefficient was given."""
        return {"l2": self.l2, "h1": self.h1} | ({"energy": self.energy} if self.exact_energy else {})


def error_norms(
    space: Space,
    dofs: Floats,
    exact: Function,
    exact_gradient: Function,
    *,
    coefficient: Coefficient | None = None,
    degree: int | None = None,
) -> ErrorNorms:
    """Compare the L2 projections of a discrete function and of its gradient with an exact function.

    - `dofs`: unknowns, shape (n_dofs,), or (n_dofs, m) for m components.
    - `exact`: takes points (n, 2), gives values (n,) or (n, m).
    - `exact_gradient`: takes points (n, 2), gives gradients (n, 2) or (n, m, 2), derivatives last.
    - `coefficient`: for the energy, as of `flangeway.forms.stiffness`.
    - `degree`: degree of the quadrature, ``2 k + 2`` by default.
    """
    degree = quadrature_degree(space) if degree is None else degree
    given = None if coefficient is None else CellCoefficient.on(space, coefficient, "gradients")
    fields = dofs.reshape(space.n_dofs, -1)
    totals = np.zeros(6)
    for batch in space.batches():
        reconstruction = batch.reconstruct()
        points, weights = batch.quadrature(degree)
        monomials = reconstruction.at(points)
        local = fields[batch.dofs]
        value = np.einsum("ame,mec->cae", reconstruction.projected_value, local)
        gradient = np.einsum("aime,mec->ciae", reconstruction.gradient, local)
        wanted = at_points(exact, points).reshape(-1, *weights.shape)
        wanted_gradient = at_points(exact_gradient, points).reshape(-1, 2, *weights.shape)
        error = wanted - np.einsum("cae,aqe->cqe", value, monomials)
        gradient_error = wanted_gradient - np.einsum("ciae,aqe->ciqe", gradient, monomials[: gradient.shape[2]])
        densities = [(field**2).sum(axis=axes) for field, axes in
                     ((error, 0), (gradient_error, (0, 1)), (wanted, 0), (wanted_gradient, (0, 1)))]  # fmt: skip
        if given is not None:
            tensor = np.broadcast_to(given.at(batch, points), (*gradient.shape[:2] * 2, *weights.shape))
            densities += [np.einsum("iaqe,iajbqe,jbqe->qe", g, tensor, g) for g in (gradient_error, wanted_gradient)]
        totals[: len(densities)] += [float(np.sum(weights * density)) for density in densities]
    return ErrorNorms(*np.sqrt(totals).tolist())
