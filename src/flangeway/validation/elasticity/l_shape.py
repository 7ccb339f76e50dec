"""An L-shaped body with a singular corner: uniform and adaptive refinement against the exact solution."""

import numpy as np

from flangeway.elements import Element
from flangeway.exact.notch import Notch
from flangeway.materials import Elastic
from flangeway.mesh import PolyMesh, dual, rectangle_grid
from flangeway.post.adaptive import RefinementRow, refine_adaptively, refine_uniformly, stress_errors
from flangeway.problems import Elasticity, PrescribedDisplacement
from flangeway.solve import ElasticitySolution, solve_elasticity
from flangeway.space import Space

MATERIAL = Elastic(1.0, 0.3)
EXACT = Notch(shear_modulus=1.0 / 2.6, kolosov=3.0 - 4.0 * 0.3)
QUADRATURE_DEGREE = 12  # the exact stresses are no polynomials


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


def uniform_rows(element: Element, mesh: PolyMesh, n_levels: int) -> list[RefinementRow]:
    """Solve on a mesh and on its uniform refinements."""
    return refine_uniformly(lambda mesh: solve_l_shape(mesh, element), mesh, _measure, n_levels)


def adaptive_rows(
    element: Element,
    mesh: PolyMesh,
    *,
    tolerance: float,
    most_steps: int = 50,
) -> list[RefinementRow]:
    """Refine a mesh by the recovered stresses' error estimate down to a tolerance in the energy norm."""
    return refine_adaptively(
        lambda mesh: solve_l_shape(mesh, element),
        mesh,
        _measure,
        tolerance=tolerance,
        most_steps=most_steps,
    )


def _measure(solution: ElasticitySolution) -> tuple[float, float]:
    return stress_errors(solution, EXACT.stresses, degree=QUADRATURE_DEGREE)
