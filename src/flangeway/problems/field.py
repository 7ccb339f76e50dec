"""Displacements of an elastic body, however they were found."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from flangeway.problems.elasticity import Elasticity

Floats = NDArray[np.float64]


@dataclass(frozen=True, eq=False)
class ElasticField:
    """Displacements of an elastic body: what stresses and pictures need.

    Parameters
    ----------
    problem
        The elastic problem.
    displacements
        All unknowns, shape (n_dofs, 2); the first ``space.n_nodes`` are those at ``space.nodes``.

    """

    problem: Elasticity
    displacements: Floats
