"""Stresses inside cells, from the elements' reconstruction, and what is derived from them."""

from dataclasses import dataclass

import numpy as np

from flangeway.elements import monomials
from flangeway.mesh import PolyMesh
from flangeway.problems import ElasticField, Elasticity
from flangeway.solve import TorsionSolution
from flangeway.types import Floats


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
        xx, yy, xy, zz = self.components.T
        squares = (xx - yy) ** 2 + (yy - zz) ** 2 + (zz - xx) ** 2
        return np.sqrt(squares / 2.0 + 3.0 * xy**2)


def cell_stresses(elasticity: Elasticity, displacement: Floats) -> Stresses:
    """Mean stresses of the cells.

    - `displacement`: all unknowns, shape (n_dofs, 2).
    """
    components = np.empty((elasticity.space.mesh.n_cells, 4))
    for batch in elasticity.space.batches():
        reconstruction, stress = elasticity.cell_stresses(batch, displacement)
        means = reconstruction.moments[: stress.shape[1]] / reconstruction.areas
        components[batch.cells] = np.einsum("sae,ae->es", stress, means)
    return Stresses(components)


def corner_stresses(elasticity: Elasticity, displacement: Floats) -> Stresses:
    """Stresses at the cells' corners, each from its own cell, in the order of ``mesh.cell_points``.

    - `displacement`: all unknowns, shape (n_dofs, 2).
    """
    mesh = elasticity.space.mesh
    components = np.empty((len(mesh.cell_points), 4))
    for batch in elasticity.space.batches():
        reconstruction, stress = elasticity.cell_stresses(batch, displacement)
        local = reconstruction.frame.local(batch.vertices)
        values = monomials.evaluate(reconstruction.order - 1, local)
        places = mesh.cell_offsets[batch.cells][:, None] + np.arange(len(batch.vertices))
        components[places] = np.einsum("sae,ave->evs", stress, values)
    return Stresses(components)


def nodal_stresses(solution: ElasticField) -> Stresses:
    """Stresses at the mesh's points, averaged over the cells there with their areas as weights.

    Averages hide jumps between cells, which show how good a mesh is, and between materials, which are real; prefer
    `corner_stresses`, or `recovered_stresses`, which are more accurate.
    """
    return at_mesh_points(solution.problem.space.mesh, corner_stresses(solution.problem, solution.displacements))


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
    space = solution.problem.space
    means = np.empty((space.mesh.n_cells, 2))
    for batch in space.batches():
        reconstruction, stress = solution.problem.cell_shear_stresses(batch, solution.function)
        weights = reconstruction.moments[: stress.shape[1]] / reconstruction.areas
        means[batch.cells] = np.einsum("iae,ae->ei", stress, weights)
    return means


def corner_shear_stresses(solution: TorsionSolution) -> Floats:
    """Shear stresses at the cells' corners, each from its own cell, shape (len(cell_points), 2).

    In the order of ``mesh.cell_points``, for a rate of twist of one.
    """
    space = solution.problem.space
    mesh = space.mesh
    stresses = np.empty((len(mesh.cell_points), 2))
    degree = max(space.order - 1, 1)
    for batch in space.batches():
        reconstruction, stress = solution.problem.cell_shear_stresses(batch, solution.function)
        values = monomials.evaluate(degree, reconstruction.frame.local(batch.vertices))
        places = mesh.cell_offsets[batch.cells][:, None] + np.arange(len(batch.vertices))
        stresses[places] = np.einsum("iae,ave->evi", stress, values[: stress.shape[1]])
    return stresses
