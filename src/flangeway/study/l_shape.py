"""An L-shaped body with a singular corner: uniform and adaptive refinement against the exact solution."""

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from flangeway.elements import Element, polygon_quadrature
from flangeway.exact.notch import Notch
from flangeway.materials import Elastic
from flangeway.mesh import PolyMesh, dual, rectangle_grid, refined
from flangeway.post import recovered_stresses
from flangeway.problems import Elasticity, PrescribedDisplacement
from flangeway.solve import ElasticitySolution, solve_elasticity
from flangeway.space import Space
from flangeway.study.adaptive import adapt

Floats = NDArray[np.float64]

MATERIAL = Elastic(1.0, 0.3)
EXACT = Notch(shear_modulus=1.0 / 2.6, kolosov=3.0 - 4.0 * 0.3)
QUADRATURE_DEGREE = 12  # the exact stresses are no polynomials


@dataclass(frozen=True, eq=False)
class LShapeRow:
    """Errors of one solution.

    Parameters
    ----------
    refinement
        ``"uniform"`` or ``"adaptive"``.
    mesh
        The mesh.
    n_unknowns
        Components of displacement at nodes, prescribed ones too; those inside cells are condensed.
    error, estimated_error
        Error of the stresses in the energy norm over the exact norm: true, and estimated by recovery.
    solution
        The solution.

    """

    refinement: str
    mesh: PolyMesh
    n_unknowns: int
    error: float
    estimated_error: float
    solution: ElasticitySolution


def l_shape(n: int, cells: str = "quadrilaterals") -> PolyMesh:
    """The square from (-1, -1) to (1, 1) without its lower left quarter, with the edge sets ``outer`` and ``notch``.

    Parameters
    ----------
    n
        Number of squares along a length of one.
    cells
        ``"quadrilaterals"``, ``"triangles"``, or ``"polygons"``, the dual of these.

    """
    grid = rectangle_grid(
        2.0,
        2.0,
        2 * n,
        2 * n,
        cells="quadrilaterals" if cells == "quadrilaterals" else "triangles",
        origin=(-1.0, -1.0),
    )
    kept = (grid.cell_centroids > 0.0).any(axis=1)
    size = int(grid.cell_sizes[0])
    used, corners = np.unique(grid.cell_points.reshape(-1, size)[kept], return_inverse=True)
    offsets = np.arange(kept.sum() + 1, dtype=np.int32) * size
    mesh = PolyMesh(grid.points[used], offsets, corners.astype(np.int32).ravel())
    if cells == "polygons":
        mesh = dual(mesh)
    middles = np.abs(mesh.points[mesh.boundary_edges].mean(axis=1))
    outer = (middles > 1.0 - 1e-9).any(axis=1)
    return mesh.with_edge_set("outer", mesh.boundary_edges[outer]).with_edge_set("notch", mesh.boundary_edges[~outer])


def solve_l_shape(mesh: PolyMesh, element: Element) -> ElasticitySolution:
    """Plane strain with the exact displacements along ``outer`` and a free notch."""
    held = PrescribedDisplacement(
        "outer", x=lambda p: EXACT.displacements(p)[:, 0], y=lambda p: EXACT.displacements(p)[:, 1]
    )
    return solve_elasticity(Elasticity(Space(mesh, element), MATERIAL, supports=[held]))


def stress_errors(solution: ElasticitySolution, exact: Callable[[Floats], Floats]) -> tuple[float, float]:
    """Energy norms, roots of the integrals of stress times strain, of a solution's error and of the exact stresses.

    Parameters
    ----------
    solution
        Plane strain or stress, one material.
    exact
        Gives stresses xx, yy, xy (n, 3) at points (n, 2).

    """
    problem = solution.problem
    compliance = np.linalg.inv(problem.materials[0].matrix[:3, :3])
    squares = np.zeros(2)
    for batch in problem.space.batches():
        reconstruction, stress = problem.cell_stresses(batch, solution.displacements)
        points, weights = polygon_quadrature(batch.vertices, QUADRATURE_DEGREE)
        values = np.einsum("sae,aqe->sqe", stress[:3], reconstruction.at(points)[: stress.shape[1]])
        wanted = exact(np.moveaxis(points, 1, -1).reshape(-1, 2)).T.reshape(3, *weights.shape)
        for i, field in enumerate((wanted - values, wanted)):
            squares[i] += problem.thickness * float(np.einsum("sqe,st,tqe,qe->", field, compliance, field, weights))
    error, size = np.sqrt(squares).tolist()
    return error, size


def _row(refinement: str, mesh: PolyMesh, solution: ElasticitySolution, estimate: float) -> LShapeRow:
    error, size = stress_errors(solution, EXACT.stresses)
    return LShapeRow(refinement, mesh, 2 * solution.problem.space.n_nodes, error / size, estimate / size, solution)


def uniform_rows(element: Element, mesh: PolyMesh, n_levels: int) -> list[LShapeRow]:
    """Solve on a mesh and on its uniform refinements."""
    rows = []
    for level in range(n_levels):
        mesh = refined(mesh) if level else mesh
        solution = solve_l_shape(mesh, element)
        rows.append(_row("uniform", mesh, solution, recovered_stresses(solution).error))
    return rows


def adaptive_rows(
    element: Element,
    mesh: PolyMesh,
    *,
    tolerance: float,
    share: float = 0.5,
    most_hanging: int | None = 1,
    most_steps: int = 50,
) -> list[LShapeRow]:
    """Refine a mesh by the recovered stresses' error estimate down to a tolerance in the energy norm."""
    run = adapt(
        lambda mesh: solve_l_shape(mesh, element),
        mesh,
        lambda solution: recovered_stresses(solution).cell_errors,
        tolerance=tolerance,
        share=share,
        most_hanging=most_hanging,
        most_steps=most_steps,
    )
    return [_row("adaptive", step.mesh, step.solution, step.error) for step in run.steps]
