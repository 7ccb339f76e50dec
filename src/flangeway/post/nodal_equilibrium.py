"""RelativeResiduals of the nodes of a body, from its displacements alone."""

import numpy as np

from flangeway.problems import ElasticField
from flangeway.types import Bools, Floats


def nodal_residual(field: ElasticField, forces: Floats) -> Floats:
    """Forces that hold the unknowns beside the loads and further ones: what supports bear, shape (n_dofs, 2).

    The stiffness is assembled anew on all unknowns and multiplied with the displacements.

    Parameters
    ----------
    field
        Displacements and the problem with its loads.
    forces
        Further forces on the nodes in the body's frame, those of contact, shape (n_nodes, 2).

    """
    return _internal_and_left(field, forces)[1]


def nodal_imbalance(field: ElasticField, forces: Floats, held: Bools) -> float:
    """Maximum force that is left at a node, over the largest one there; zero without any force.

    It is that of `nodal_residual`, so neither the factor, nor condensation, nor the contact iteration is trusted that
    found the displacements.

    Parameters
    ----------
    field
        Displacements and the problem with its loads.
    forces
        Further forces on the nodes in the body's frame, those of contact, shape (n_nodes, 2).
    held
        Which components of which nodes a support bears, shape (n_nodes, 2).

    """
    internal, left = _internal_and_left(field, forces)
    reference = max(float(np.abs(each).max(initial=0.0)) for each in (left, forces, internal))
    left[: len(forces)][held] = 0.0
    return float(np.abs(left).max()) / reference if reference > 0.0 else 0.0


def _internal_and_left(field: ElasticField, forces: Floats) -> tuple[Floats, Floats]:
    """Forces of the stiffness on the unknowns, and what is left of them beside all others, each (n_dofs, 2)."""
    problem = field.problem
    internal: Floats = (problem.stiffness().full() @ field.displacements.ravel()).reshape(-1, 2)
    left = internal - (problem.load_vector() + problem.thermal_load_vector())
    left[: len(forces)] -= forces
    return internal, left
