"""Uniform refinement and refinement where the error is, side by side."""

from collections.abc import Callable
from dataclasses import dataclass
from typing import Literal

import numpy as np

from flangeway.elements import polygon_quadrature
from flangeway.mesh import PolyMesh, refined
from flangeway.post.adaptive import adapt
from flangeway.post.recovery import recovered_stresses
from flangeway.solve import ElasticitySolution
from flangeway.types import Floats

Solve = Callable[[PolyMesh], ElasticitySolution]
Measure = Callable[[ElasticitySolution], tuple[float, float]]
"""Gives the true error of a solution and the size of the exact one, both in the energy norm."""


@dataclass(frozen=True, eq=False)
class RefinementRow:
    """Errors of one solution.

    - `refinement`: ``"uniform"`` or ``"adaptive"``.
    - `n_unknowns`: components of displacement at nodes, prescribed ones too; those inside cells are condensed.
    - `error`, `estimated_error`: error of the stresses in the energy norm over the exact norm: true, and estimated by
      recovery.
    """

    refinement: Literal["uniform", "adaptive"]
    mesh: PolyMesh
    n_unknowns: int
    error: float
    estimated_error: float
    solution: ElasticitySolution


def stress_errors(
    solution: ElasticitySolution, exact: Callable[[Floats], Floats], *, degree: int
) -> tuple[float, float]:
    """Energy norms, roots of the integrals of stress times strain, of a solution's error and of the exact stresses.

    - `solution`: plane strain or stress, one material.
    - `exact`: gives stresses xx, yy, xy (n, 3) at points (n, 2).
    - `degree`: degree of the polynomials that are integrated exactly.
    """
    problem = solution.problem
    compliance = np.linalg.inv(problem.materials[0].matrix[:3, :3])
    squares = np.zeros(2)
    for batch in problem.space.batches():
        reconstruction, stress = problem.cell_stresses(batch, solution.displacements)
        points, weights = polygon_quadrature(batch.vertices, degree)
        values = np.einsum("sae,aqe->sqe", stress[:3], reconstruction.at(points)[: stress.shape[1]])
        wanted = exact(np.moveaxis(points, 1, -1).reshape(-1, 2)).T.reshape(3, *weights.shape)
        for i, field in enumerate((wanted - values, wanted)):
            squares[i] += problem.thickness * float(np.einsum("sqe,st,tqe,qe->", field, compliance, field, weights))
    error, size = np.sqrt(squares).tolist()
    return error, size


def refine_uniformly(solve: Solve, mesh: PolyMesh, measure: Measure, n_levels: int) -> list[RefinementRow]:
    """Solve on a mesh and on its uniform refinements."""
    rows = []
    for level in range(n_levels):
        mesh = refined(mesh) if level else mesh
        solution = solve(mesh)
        rows.append(_row("uniform", solution, recovered_stresses(solution).error, measure))
    return rows


def refine_adaptively(
    solve: Solve,
    mesh: PolyMesh,
    measure: Measure,
    *,
    tolerance: float,
    most_steps: int = 50,
) -> list[RefinementRow]:
    """Refine a mesh by the recovered stresses' error estimate, see `adapt`, down to a tolerance in the energy norm."""
    run = adapt(
        solve,
        mesh,
        lambda solution: recovered_stresses(solution).cell_errors,
        tolerance=tolerance,
        most_steps=most_steps,
    )
    return [_row("adaptive", step.solution, step.error, measure) for step in run.steps]


def _row(
    refinement: Literal["uniform", "adaptive"], solution: ElasticitySolution, estimate: float, measure: Measure
) -> RefinementRow:
    space = solution.problem.space
    error, size = measure(solution)
    return RefinementRow(refinement, space.mesh, 2 * space.n_nodes, error / size, estimate / size, solution)
