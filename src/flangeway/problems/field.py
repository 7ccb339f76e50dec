"""Displacements of an elastic body, however they were found."""

from dataclasses import dataclass

from flangeway.problems.elasticity_problem import Elasticity
from flangeway.types import Floats


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
