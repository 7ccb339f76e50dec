"""Structured meshes of a rectangle, and squares divided into four where a function says."""

from collections.abc import Callable, Sequence
from typing import Literal

import numpy as np

from flangeway.checks import check_integer, check_positive
from flangeway.errors import InputError, short
from flangeway.geometry.arrays import Point, as_point, sides_of
from flangeway.mesh.mesh_checks import conforming
from flangeway.mesh.polyhedral_mesh import PolyhedralMesh
from flangeway.mesh.polymesh import PolyMesh
from flangeway.system.memory_limits import refuse_large_mesh
from flangeway.types import Bools, Floats, Ints

# --- Small structured meshes of a rectangle, for tests and examples.


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


# --- Squares divided into four where a function says, with hanging nodes as points of polygons.


BYTES_A_LEAF = 1000
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
    done, size = _divided("quadtree", base, np.array([width, height]), (nx, ny), CORNERS, finer, levels)
    corners = np.concatenate([rows[:, None] + side * CORNERS for rows, side in done])
    points, cells = np.unique(corners.reshape(-1, 2), axis=0, return_inverse=True)
    mesh = conforming(PolyMesh.from_cells(base + points * size, cells.reshape(-1, 4)))
    last = np.array([nx, ny]) * 2**levels
    for name, axis, value in (("bottom", 1, 0), ("right", 0, last[0]), ("top", 1, last[1]), ("left", 0, 0)):
        ends = points[mesh.boundary_edges][..., axis]
        mesh = mesh.with_edge_set(name, mesh.boundary_edges[(ends == value).all(axis=1)])
    return mesh


def _divided(
    owner: str,
    base: Floats,
    lengths: Floats,
    counts: tuple[int, ...],
    corners: Ints,
    finer: Callable[[Floats, Floats], Bools],
    levels: int,
) -> tuple[list[tuple[Ints, int]], Floats]:
    """Cells of a box that is divided again and again: their first corners (n, d) and sides, and the unit of both."""
    check_integer(owner, "levels", levels, 0, MAX_LEVELS)
    size = lengths / counts / 2**levels  # of the smallest cells, in which places are counted
    origins = 2**levels * np.indices(counts[::-1]).reshape(len(counts), -1)[::-1].T
    done: list[tuple[Ints, int]] = []
    for level in range(levels, -1, -1):
        side = 2**level
        cut = np.zeros(len(origins), dtype=bool)
        if level:
            centres = base + (origins + side / 2.0) * size
            cut = np.asarray(finer(centres, np.full(len(origins), side * size.max())))
            if cut.shape != (len(origins),) or cut.dtype != bool:
                raise InputError(
                    f"{owner}(finer=...) with values of shape {cut.shape} and type {cut.dtype}",
                    f"a truth value for each of {len(origins)} cells",
                    f"write it for centres (n, {len(counts)}) and sides (n,)",
                )
        done.append((origins[~cut], side))
        origins = (origins[cut][:, None] + side // 2 * corners).reshape(-1, len(counts))
        refuse_large_mesh(f"the cells of the {owner}", BYTES_A_LEAF * len(origins))
    return done, size


# --- Boxes divided into eight, with hanging nodes as points of polyhedra.


def octree(
    lengths: Sequence[float],
    counts: Sequence[int],
    *,
    finer: Callable[[Floats, Floats], Bools],
    levels: int = 3,
    origin: Sequence[float] = (0.0, 0.0, 0.0),
) -> PolyhedralMesh:
    """Return a box of boxes, each cut into eight again and again where a function says.

    A face of a larger neighbour is divided like those of the smaller ones, and corners on its edges become points of
    it: cells are polyhedra with hanging nodes. Neighbours may differ by any number of levels.

    Parameters
    ----------
    lengths
        Sides along x, y and z, positive.
    counts
        Numbers of cells along them before any is cut.
    finer
        Takes the centres (n, 3) of cells and their longest sides (n,), gives which are cut, (n,).
    levels
        How often a cell can be cut, 0 to 20.
    origin
        Corner with the smallest coordinates.

    Returns
    -------
    PolyhedralMesh
        With face sets ``x-``, ``x+``, ``y-``, ``y+``, ``z-``, ``z+``.

    Raises
    ------
    InputError
        If a length or number is not positive, or the function gives something else than truth values.
    """
    for axis, length, count in zip("xyz", lengths, counts, strict=True):
        check_positive("octree", f"length along {axis}", length, "a positive length")
        check_integer("octree", f"count along {axis}", count, 1)
    base, numbers = np.array(origin, dtype=np.float64), (counts[0], counts[1], counts[2])
    unit = np.indices((2, 2, 2)).reshape(3, -1).T
    done, size = _divided("octree", base, np.array(lengths, dtype=np.float64), numbers, unit, finer, levels)
    # corners are numbered by their places in the grid of the smallest cells
    step = np.cumprod([1, *(np.array(counts[:0:-1]) * 2**levels + 1)])[::-1].tolist()
    corners = np.unique(np.concatenate([rows[:, None] + side * unit for rows, side in done]).reshape(-1, 3), axis=0)
    number = {key: i for i, key in enumerate((corners @ step).tolist())}

    def loops(first: int, one: int, other: int, side: int) -> list[list[int]]:
        """Faces that make up the square at a corner, with steps along its sides: four where its centre is a corner."""
        half = side // 2
        if side > 1 and first + half * (one + other) in number:
            places = [first + a * one + b * other for a in (0, half) for b in (0, half)]
            return [loop for place in places for loop in loops(place, one, other, half)]
        ring = (first, first + side * one, first + side * (one + other), first + side * other)
        return [[point for start, end in sides_of(ring) for point in on_edge(start, end, side)]]

    def on_edge(start: int, end: int, side: int) -> list[int]:
        """Points along an edge without its end."""
        middle = (start + end) // 2
        if side == 1 or middle not in number:
            return [number[start]]
        return on_edge(start, middle, side // 2) + on_edge(middle, end, side // 2)

    cells = (
        [
            loop
            for axis in range(3)
            for far in (0, side)
            for loop in loops(first + far * step[axis], step[axis - 2], step[axis - 1], side)
        ]
        for rows, side in done
        for first in (rows @ step).tolist()
    )
    mesh = PolyhedralMesh.from_cells(base + corners * size, cells)
    return mesh.with_box_sides(np.stack((base, base + lengths)))
