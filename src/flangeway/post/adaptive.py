"""Refinement driven by an error estimate: solve, estimate, mark, refine, again."""

from collections.abc import Callable
from dataclasses import dataclass
from typing import Generic, TypeVar

import numpy as np

from flangeway.errors import InputError
from flangeway.mesh import PolyMesh, doerfler_marking, refined
from flangeway.mesh.curved import Curves
from flangeway.post.recovery import energy_norms
from flangeway.results import Result, ResultTable
from flangeway.solve import ElasticitySolution, Status
from flangeway.space import CellBatch
from flangeway.types import Floats

Solution = TypeVar("Solution")


@dataclass(frozen=True, eq=False)
class AdaptiveStep(Generic[Solution]):
    """One solution of an adaptive run.

    - `solution`: what `solve` gave.
    - `cell_errors`: estimated error of each cell, shape (n_cells,).
    """

    mesh: PolyMesh
    solution: Solution
    cell_errors: Floats

    @property
    def error(self) -> float:
        """Estimated error of the whole, the root of the sum of the squares."""
        return float(np.linalg.norm(self.cell_errors))


@dataclass(frozen=True, eq=False)
class AdaptiveRun(Result, Generic[Solution]):
    """Solutions on meshes of which each is refined where the error of the one before was maximum.

    - `steps`: first mesh first; at least one.
    - `status`: whether the tolerance was reached, in a sentence.
    """

    steps: tuple[AdaptiveStep[Solution], ...]
    status: Status

    @property
    def table(self) -> ResultTable:
        """Cells and estimated errors of its meshes."""
        cells, errors = [each.mesh.n_cells for each in self.steps], [each.error for each in self.steps]
        return ResultTable({"cells": cells, "estimated_error": errors})

    @property
    def last(self) -> AdaptiveStep[Solution]:
        """The finest."""
        return self.steps[-1]


def adapt(
    solve: Callable[[PolyMesh], Solution],
    mesh: PolyMesh,
    cell_errors: Callable[[Solution], Floats],
    *,
    tolerance: float,
    most_cells: int = 100_000,
    most_steps: int = 50,
    share: float = 0.5,
    most_hanging: int | None = 1,
    outline: Curves | None = None,
) -> AdaptiveRun[Solution]:
    """Refine a mesh until the estimated error is small enough.

    For example ``adapt(solve, mesh, lambda solution: recovered_stresses(solution).cell_errors, tolerance=0.1)`` with a
    function ``solve(mesh)`` that makes a space and a problem and solves it. The meshes get cells with hanging points,
    so elements must take polygons.

    Parameters
    ----------
    solve
        Gives a solution on a mesh.
    mesh
        First mesh.
    cell_errors
        Gives the estimated error of each cell, (n_cells,), such that their squares add up.
    tolerance
        Estimated error of the whole at which to end, in the units of `cell_errors`.
    most_cells
        No mesh is solved on that has more cells, except the first.
    most_steps
        Number of solutions at which to end.
    share
        Share of the squared error that the cells to refine hold, see `doerfler_marking`.
    most_hanging
        Most points that may hang on a side, see `refined`. On the L-shaped body one at most needs about a quarter fewer
        unknowns than no limit with order 2 from polygons, whose cells then get 12 points rather than 26, and about as
        many with quadrilaterals and other orders.
    outline
        Curves of the boundary, see `refined`.

    Returns
    -------
    AdaptiveRun
        Not reaching the tolerance is a result, reported by its status.

    Raises
    ------
    InputError
        If a number is out of its range, or the estimate is not one number for each cell.
    """
    if not (tolerance > 0.0 and most_steps >= 1):
        raise InputError(
            f"adapt(tolerance={tolerance}, most_steps={most_steps})",
            "a positive tolerance, and one step or more",
            "give the estimated error at which to end",
        )
    steps: list[AdaptiveStep[Solution]] = []
    while True:
        solution = solve(mesh)
        errors = np.array(cell_errors(solution), dtype=np.float64)
        if errors.shape != (mesh.n_cells,):
            raise InputError(
                f"cell errors of shape {errors.shape}", f"({mesh.n_cells},), one for each cell", "correct the estimate"
            )
        errors.setflags(write=False)
        steps.append(AdaptiveStep(mesh, solution, errors))
        if steps[-1].error <= tolerance:
            return _ended(steps, tolerance, "")
        if len(steps) == most_steps:
            return _ended(steps, tolerance, f"{most_steps} solutions; allow more steps")
        mesh = refined(mesh, doerfler_marking(errors, share), most_hanging=most_hanging, outline=outline)
        if mesh.n_cells > most_cells:
            return _ended(steps, tolerance, f"the next mesh has {mesh.n_cells} cells; allow more")


def _ended(steps: list[AdaptiveStep[Solution]], tolerance: float, reason: str) -> AdaptiveRun[Solution]:
    cells, error = steps[-1].mesh.n_cells, steps[-1].error
    if reason:
        message = f"The estimated error {error:.3g} on {cells} cells is above the tolerance {tolerance:.3g}: {reason}."
    else:
        message = f"The estimated error {error:.3g} on {cells} cells is within the tolerance {tolerance:.3g}."
    return AdaptiveRun(tuple(steps), Status(not reason, message, len(steps)))


def stress_errors(
    solution: ElasticitySolution, exact: Callable[[Floats], Floats], *, degree: int
) -> tuple[float, float]:
    """Energy norms, roots of the integrals of stress times strain, of a solution's error and of the exact stresses.

    - `solution`: plane strain or stress.
    - `exact`: gives stresses xx, yy, xy (n, 3) at points (n, 2).
    - `degree`: degree of the polynomials that are integrated exactly.
    """

    def given(_: CellBatch, points: Floats) -> Floats:
        in_plane = exact(np.moveaxis(points, 1, -1).reshape(-1, 2)).T.reshape(3, len(points), -1)
        return np.concatenate((in_plane, np.zeros_like(in_plane[:1])))

    error, size = np.linalg.norm(energy_norms(solution, given, degree), axis=1).tolist()
    return error, size
