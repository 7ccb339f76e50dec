"""Squares divided into four where a function says, with hanging nodes as points of polygons."""

from collections.abc import Callable

import numpy as np

from flangeway.checks import check_integer
from flangeway.errors import InputError
from flangeway.geometry.arrays import Point
from flangeway.mesh.mesh_checks import conforming
from flangeway.mesh.polymesh import PolyMesh
from flangeway.mesh.structured import checked_rectangle
from flangeway.system.memory_limits import refuse_large_mesh
from flangeway.types import Bools, Floats, Ints

BYTES_A_SQUARE = 1000
CORNERS = np.array([[0, 0], [1, 0], [1, 1], [0, 1]])
MAX_LEVELS = 20  # 2^20 of the smallest sides on the largest


def quadtree(
    width: float,
    height: float,
    nx: int,
    ny: int,
    *,
    finer: Callable[[Floats, Floats], Bools],
    levels: int = 3,
    origin: Point = (0.0, 0.0),
) -> PolyMesh:
    """Return a rectangle of rectangles, each cut into four again and again where a function says.

    A corner on a side of a larger neighbour becomes a point of that cell too, which is a polygon with straight angles.
    Neighbours may differ by any number of levels.

    Parameters
    ----------
    width, height
        Sides, positive.
    nx, ny
        Numbers of cells along the width and the height before any is cut.
    finer
        Takes the centres (n, 2) of cells and their longer sides (n,), gives which are cut, (n,).
    levels
        How often a cell can be cut, 0 to 20.
    origin
        Lower-left corner.

    Returns
    -------
    PolyMesh
        With edge sets ``bottom``, ``right``, ``top``, ``left``.

    Raises
    ------
    InputError
        If a length or number is not positive, or the function gives something else than truth values.
    """
    base = np.array(checked_rectangle("quadtree", (width, height), (nx, ny), origin))
    check_integer("quadtree", "levels", levels, 0, MAX_LEVELS)
    size = np.array([width / nx, height / ny]) / 2**levels  # of the smallest cells, in which places are counted
    place = 2**levels * np.stack(np.meshgrid(np.arange(nx), np.arange(ny)), axis=-1).reshape(-1, 2)
    done: list[tuple[Ints, int]] = []
    for level in range(levels, -1, -1):
        side = 2**level
        cut = np.zeros(len(place), dtype=bool)
        if level:
            centres = base + (place + side / 2.0) * size
            cut = np.asarray(finer(centres, np.full(len(place), side * size.max())))
            if cut.shape != (len(place),) or cut.dtype != bool:
                raise InputError(
                    f"quadtree(finer=...) with values of shape {cut.shape} and type {cut.dtype}",
                    f"a truth value for each of {len(place)} cells",
                    "write it for centres (n, 2) and sides (n,)",
                )
        done.append((place[~cut], side))
        place = (place[cut][:, None] + side // 2 * CORNERS).reshape(-1, 2)
        refuse_large_mesh("the cells of a quadtree", BYTES_A_SQUARE * len(place))
    corners = np.concatenate([rows[:, None] + side * CORNERS for rows, side in done])
    points, cells = np.unique(corners.reshape(-1, 2), axis=0, return_inverse=True)
    mesh = conforming(PolyMesh.from_cells(base + points * size, cells.reshape(-1, 4)))
    last = np.array([nx, ny]) * 2**levels
    for name, axis, value in (("bottom", 1, 0), ("right", 0, last[0]), ("top", 1, last[1]), ("left", 0, 0)):
        ends = points[mesh.boundary_edges][..., axis]
        mesh = mesh.with_edge_set(name, mesh.boundary_edges[(ends == value).all(axis=1)])
    return mesh
