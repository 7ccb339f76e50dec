"""Shear stresses of torsion inside cells and at their corners."""

import numpy as np

from flangeway.elements import monomials
from flangeway.solve import TorsionSolution
from flangeway.types import Floats


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
