"""Stresses inside cells, from the elements' reconstruction, and what is derived from them."""

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from flangeway.elements import Reconstruction, monomials
from flangeway.mesh import PolyMesh
from flangeway.problems import ElasticField, Elasticity
from flangeway.solve import TorsionSolution
from flangeway.space import CellBatch, Space
from flangeway.types import Floats

Polynomials = Callable[[CellBatch], tuple[Reconstruction, Floats]]
"""Reconstruction of a batch, and coefficients of the field's components, shape (n_components, n, n_cells)."""


@dataclass(frozen=True, eq=False)
class Stresses:
    """Stress components at some places and the invariants that engineers ask for.

    Parameters
    ----------
    components
        Normal stresses xx, yy, the shear xy, and the normal stress zz out of the plane, shape (n, 4), tension positive.
    """

    components: Floats

    @property
    def tensors(self) -> Floats:
        """Stresses xx, yy, zz, xy, yz, xz, the last two zero, shape (n, 6)."""
        xx, yy, xy, zz = self.components.T
        return np.stack((xx, yy, zz, xy, np.zeros_like(xx), np.zeros_like(xx)), axis=1)

    @property
    def principal(self) -> Floats:
        """Principal stresses in three dimensions, zz included, descending, shape (n, 3)."""
        xx, yy, xy, zz = self.components.T
        middle, radius = (xx + yy) / 2.0, np.hypot((xx - yy) / 2.0, xy)
        return np.sort(np.stack((middle + radius, middle - radius, zz), axis=1), axis=1)[:, ::-1]

    @property
    def in_plane_shear(self) -> Floats:
        """Maximum shear stress in the plane, shape (n,)."""
        xx, yy, xy, _ = self.components.T
        return np.hypot((xx - yy) / 2.0, xy)

    @property
    def von_mises(self) -> Floats:
        """Von Mises stress, the root of three times the second invariant of the deviator, shape (n,)."""
        return von_mises(self.tensors)


def von_mises(tensors: Floats) -> Floats:
    """Von Mises stress (n,) of stresses xx, yy, zz, xy, yz, xz, shape (n, 6)."""
    xx, yy, zz, *shears = tensors.T
    normal = (xx - yy) ** 2 + (yy - zz) ** 2 + (zz - xx) ** 2
    return np.sqrt(normal / 2.0 + 3.0 * np.sum(np.square(shears), axis=0))


def cell_stresses(elasticity: Elasticity, displacement: Floats) -> Stresses:
    """Mean stresses of the cells.

    - `displacement`: all unknowns, shape (n_dofs, 2).
    """
    return Stresses(_cell_means(elasticity.space, lambda batch: elasticity.cell_stresses(batch, displacement), 4))


def corner_stresses(elasticity: Elasticity, displacement: Floats) -> Stresses:
    """Stresses at the cells' corners, each from its own cell, in the order of ``mesh.cell_points``.

    - `displacement`: all unknowns, shape (n_dofs, 2).
    """
    return Stresses(corner_values(elasticity.space, lambda batch: elasticity.cell_stresses(batch, displacement), 4))


def corner_values(space: Space, polynomials: Polynomials, n_components: int) -> Floats:
    """Values (n_corners, n_components) of the cells' polynomials at their corners, ordered as `mesh.cell_points`."""
    values = np.empty((len(space.mesh.cell_points), n_components))
    for batch in space.batches():
        reconstruction, coefficients = polynomials(batch)
        basis = monomials.evaluate(reconstruction.order, reconstruction.frame.local(batch.vertices))
        places = space.mesh.batch_places(len(batch.vertices), batch.cells)
        # v_evs = sum over monomials a of c_sae m_ave at the vertices v of the cells e
        values[places] = np.einsum("sae,ave->evs", coefficients, basis[: coefficients.shape[1]])
    return values


def nodal_stresses(solution: ElasticField) -> Stresses:
    """Stresses at the mesh's points, averaged over the cells there with their areas as weights.

    Averages hide jumps between cells, which show how good a mesh is, and between materials, which are real; prefer
    `corner_stresses`, or `recovered_stresses`, which are more accurate.
    """
    return at_mesh_points(solution.space.mesh, corner_stresses(solution.problem, solution.displacements))


def at_mesh_points(mesh: PolyMesh, corners: Stresses) -> Stresses:
    """Means of values at the cells' corners over each point, weighted by the cells' areas; zero at unused points."""
    weights = np.repeat(mesh.cell_areas, mesh.cell_sizes)
    total = np.bincount(mesh.cell_points, weights, minlength=mesh.n_points)
    sums = [
        np.bincount(mesh.cell_points, weights * component, minlength=mesh.n_points)
        for component in corners.components.T
    ]
    return Stresses(np.stack(sums, axis=1) / np.maximum(total, np.finfo(np.float64).tiny)[:, None])


def shear_stresses(solution: TorsionSolution) -> Floats:
    """Mean shear stresses ``tau_zx, tau_zy`` of the cells for a rate of twist of one, shape (n_cells, 2).

    With a shear modulus of one they are stresses per ``G theta'``.
    """
    return _cell_means(solution.problem.space, _shear_polynomials(solution), 2)


def corner_shear_stresses(solution: TorsionSolution) -> Floats:
    """Shear stresses at the cells' corners, each from its own cell, shape (len(cell_points), 2).

    In the order of ``mesh.cell_points``, for a rate of twist of one.
    """
    return corner_values(solution.problem.space, _shear_polynomials(solution), 2)


def _shear_polynomials(solution: TorsionSolution) -> Polynomials:
    return lambda batch: solution.problem.cell_shear_stresses(batch, solution.function)


def _cell_means(space: Space, polynomials: Polynomials, n_components: int) -> Floats:
    """Means (n_cells, n_components) of the cells' polynomials."""
    means = np.empty((space.mesh.n_cells, n_components))
    for batch in space.batches():
        reconstruction, coefficients = polynomials(batch)
        weights = reconstruction.moments[: coefficients.shape[1]] / reconstruction.areas
        means[batch.cells] = np.einsum("sae,ae->es", coefficients, weights)
    return means
