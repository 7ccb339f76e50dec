"""Errors on a sequence of meshes and their rates."""

from collections.abc import Callable, Iterable, Mapping
from typing import Any

import numpy as np

from flangeway.errors import InputError
from flangeway.mesh import PolyMesh
from flangeway.post import ErrorNorms
from flangeway.results import ResultTable


def convergence(
    problem: Callable[[PolyMesh], ErrorNorms | Mapping[str, float]], meshes: Iterable[PolyMesh]
) -> ResultTable:
    """Solve a problem on meshes and measure how fast its errors fall.

    Parameters
    ----------
    problem
        Takes a mesh, gives `ErrorNorms`, or errors by names.
    meshes
        Two or more, from coarse to fine.

    Returns
    -------
    ResultTable
        A row for each mesh: number of cells, h (root of the mean area of the cells), each error, and its rate: the
        exponent p of ``error ~ h^p`` from the mesh before, none for the first.

    """
    cells, sizes, errors = [], [], []
    for mesh in meshes:
        solution = problem(mesh)
        cells.append(mesh.n_cells)
        sizes.append(float(np.sqrt(mesh.cell_areas.mean())))
        errors.append(solution.errors if isinstance(solution, ErrorNorms) else dict(solution))
    if len(cells) < 2 or (np.diff(sizes) == 0.0).any():
        raise InputError(f"meshes with cells of sizes {sizes}", "two or more of different sizes", "give finer ones")
    columns: dict[str, Any] = {"cells": cells, "h": sizes}
    for name in errors[0]:
        values = [row[name] for row in errors]
        with np.errstate(divide="ignore", invalid="ignore"):
            rates = np.diff(np.log(values)) / np.diff(np.log(sizes))
        columns[name] = values
        columns[f"{name} rate"] = [None, *np.round(rates, 2).tolist()]
    return ResultTable(columns)
