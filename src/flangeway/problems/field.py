"""Displacements of an elastic body, however they were found."""

from dataclasses import dataclass

from flangeway.problems.elasticity_problem import Elasticity
from flangeway.results import Result, ResultTable
from flangeway.space import Space
from flangeway.types import Floats


@dataclass(frozen=True, eq=False)
class ElasticField(Result):
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

    @property
    def space(self) -> Space:
        """Space of the displacements."""
        return self.problem.space

    @property
    def table(self) -> ResultTable:
        """Places and displacements of the nodes."""
        nodes = self.space.nodes
        (x, y), (u, v) = nodes.T, self.displacements[: len(nodes)].T
        return ResultTable({"x": x, "y": y, "displacement_x": u, "displacement_y": v})
