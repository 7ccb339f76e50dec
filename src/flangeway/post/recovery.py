"""Superconvergent patch recovery of stresses, and the error that it estimates."""

from collections.abc import Callable
from dataclasses import dataclass
from functools import cached_property

import numpy as np
import scipy.sparse as sp

from flangeway.elements import batched, monomials, polygon_quadrature
from flangeway.elements.monomials import n_monomials
from flangeway.errors import InputError
from flangeway.post.lines import OUTSIDE, locate
from flangeway.post.stress import Stresses, at_mesh_points
from flangeway.problems import ElasticField, Elasticity
from flangeway.results import Result, ResultTable
from flangeway.solve import ElasticitySolution
from flangeway.space import CellBatch
from flangeway.types import Floats, Ints

SMALLEST_SINGULAR = 1e-11
"""Eigenvalue of a patch's normal equations, over the maximum, below which a polynomial is not seen by its cells."""


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
        errors.setflags(write=False)
        return errors

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
            places = mesh.batch_places(len(batch.vertices), batch.cells)
            components[places] = self._at(batch.cells, batch.vertices).transpose(2, 1, 0)
        return Stresses(components)

    def at(self, points: Floats) -> Stresses:
        """Recovered stresses at points (n, 2), each of the cell that it lies in; not-a-number outside of the body."""
        mesh = self.solution.space.mesh
        cells = locate(mesh, points)
        found = np.full((len(points), 4), np.nan)
        inside = cells != OUTSIDE
        polynomials = self._at(cells[inside], points[inside].T[None])
        found[inside] = polynomials[:, 0].T
        return Stresses(found)

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
        points, weights = polygon_quadrature(batch.outline, degree)
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
        points, weights = polygon_quadrature(batch.outline, 2 * order)
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
    coefficients = _solved(normal, rhs).swapaxes(1, 2)
    coefficients.setflags(write=False)
    return RecoveredStresses(solution, coefficients, scales)


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
    seen = values > SMALLEST_SINGULAR * values[:, -1:]
    inverse = np.where(seen, 1.0 / np.where(seen, values, 1.0), 0.0)
    return (vectors * inverse[:, None]) @ (vectors.swapaxes(1, 2) @ rhs)
