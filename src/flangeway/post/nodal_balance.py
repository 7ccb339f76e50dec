"""Balance of the nodes of a body, from its displacements alone."""

import numpy as np
from numpy.typing import NDArray

from flangeway.problems import ElasticField

Floats = NDArray[np.float64]
Bools = NDArray[np.bool_]


def nodal_imbalance(field: ElasticField, forces: Floats, held: Bools) -> float:
    """Largest force that is left at a node, over the largest one there; zero without any force.

    The stiffness is assembled anew on all unknowns and multiplied with the displacements. So neither the factor, nor
    condensation, nor the contact iteration is trusted that found them.

    Parameters
    ----------
    field
        Displacements and the problem with its loads.
    forces
        Further forces on the nodes in the body's frame, those of contact, shape (n_nodes, 2).
    held
        Which components of which nodes a support bears, shape (n_nodes, 2).

    """
    problem = field.problem
    n_nodes = problem.space.n_nodes
    internal = (problem.stiffness().full() @ field.displacements.ravel()).reshape(-1, 2)
    left = internal - problem.load_vector() - problem.thermal_load_vector()
    left[:n_nodes] -= forces
    reference = max(float(np.abs(each).max(initial=0.0)) for each in (left, forces, internal))
    left[:n_nodes][held] = 0.0
    return float(np.abs(left).max()) / reference if reference > 0.0 else 0.0
