"""Small structured meshes of a rectangle, for tests and examples."""

from typing import Literal

import numpy as np

from flangeway.checks import check_integer, check_positive
from flangeway.errors import InputError, short
from flangeway.geometry.arrays import Point, as_point
from flangeway.mesh.polymesh import PolyMesh
from flangeway.system.memory_limits import refuse_large_mesh

BYTES_A_SQUARE = 140  # of triangles, the larger; measured


def checked_rectangle(owner: str, sides: tuple[float, float], counts: tuple[int, int], origin: Point) -> Point:
    """Check the sides and the numbers of cells of a rectangle, and return its lower-left corner."""
    for name, value in zip(("width", "height"), sides, strict=True):
        check_positive(owner, name, value, "a positive length")
    for name, number in zip(("nx", "ny"), counts, strict=True):
        check_integer(owner, name, number, 1)
    return as_point(origin, "origin")


def rectangle_grid(
    width: float,
    height: float,
    nx: int,
    ny: int,
    *,
    cells: Literal["triangles", "quadrilaterals"] = "triangles",
    origin: Point = (0.0, 0.0),
) -> PolyMesh:
    """Return a rectangle of ``nx`` by ``ny`` squares, each cut by its rising diagonal if asked.

    Parameters
    ----------
    width, height
        Sides, positive.
    nx, ny
        Numbers of squares along the width and the height, one or more.
    cells
        ``"triangles"`` or ``"quadrilaterals"``.
    origin
        Lower-left corner.

    Returns
    -------
    PolyMesh
        With edge sets ``bottom``, ``right``, ``top``, ``left``.

    Raises
    ------
    InputError
        If a length or number is not positive, or the kind of cell is unknown.
    OutOfMemoryError
        If there is no memory for it.
    """
    x0, y0 = checked_rectangle("rectangle_grid", (width, height), (nx, ny), origin)
    refuse_large_mesh(f"a grid of {nx:,} by {ny:,} squares", BYTES_A_SQUARE * nx * ny)
    x, y = np.meshgrid(np.linspace(x0, x0 + width, nx + 1), np.linspace(y0, y0 + height, ny + 1))
    grid = np.arange((nx + 1) * (ny + 1), dtype=np.int32).reshape(ny + 1, nx + 1)
    corners = (grid[:-1, :-1], grid[:-1, 1:], grid[1:, 1:], grid[1:, :-1])
    a, b, c, d = (corner.ravel() for corner in corners)
    if cells == "triangles":
        rows = np.column_stack([a, b, c, a, c, d]).reshape(-1, 3)
    elif cells == "quadrilaterals":
        rows = np.column_stack([a, b, c, d])
    else:
        raise InputError(f"cells = {short(cells)}", "'triangles' or 'quadrilaterals'", "choose one")
    sides = {"bottom": grid[0], "right": grid[:, -1], "top": grid[-1, ::-1], "left": grid[::-1, 0]}
    edge_sets = {name: np.column_stack([p[:-1], p[1:]]) for name, p in sides.items()}
    return PolyMesh.from_cells(np.column_stack([x.ravel(), y.ravel()]), rows, edge_sets=edge_sets)
