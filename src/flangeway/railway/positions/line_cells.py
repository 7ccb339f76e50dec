"""Cells of a mesh that points of straight lines lie in, for many lines at once."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from flangeway.mesh import PolyMesh
from flangeway.post.location import NEAR, OUTSIDE
from flangeway.types import Floats, Ints


@dataclass(frozen=True, eq=False)
class _Passages:
    """Where lines are inside of cells, ordered by line and then by distance, each (k,)."""

    lines: Ints
    cells: Ints
    enters: Floats
    leaves: Floats


def cells_along(mesh: PolyMesh, starts: Floats, directions: Floats, distances: Floats) -> Ints:
    """Cells that points of lines lie in, as `flangeway.post.location.locate` finds them point by point.

    Each point of the mesh is on one of two sides of a line, so that the line crosses an even number of a cell's edges
    and is in the cell between the first and the second, and so on. An edge of two cells is crossed at one place: the
    cells cover the line without gaps, whatever is rounded.

    Parameters
    ----------
    mesh
        The mesh.
    starts, directions
        Where the lines begin and their unit vectors, each (m, 2).
    distances
        Of the points from the start, >= 0 and rising along each line, shape (m, n).

    Returns
    -------
    Ints
        Shape (m, n), -1 outside of the mesh.

    """
    near = NEAR * float(np.linalg.norm(np.ptp(mesh.points, axis=0)))
    passages = _passages(mesh, starts, directions, distances[:, -1], near)
    if len(passages.lines) == 0:
        return np.full(distances.shape, OUTSIDE)
    # one row of rising numbers for all lines: each line's are shifted behind those of the one before
    shift = 2.0 * (float(distances[:, -1].max()) + 2.0 * near)
    wanted = (distances + shift * np.arange(len(starts))[:, None]).ravel()
    enters, leaves = passages.enters + shift * passages.lines, passages.leaves + shift * passages.lines

    def apart(places: Ints) -> Floats:
        return np.maximum(wanted - leaves[places], enters[places] - wanted)

    after = np.searchsorted(enters, wanted, "right")
    before, after = np.maximum(after - 1, 0), np.minimum(after, len(enters) - 1)
    nearest = np.where(apart(before) <= apart(after), before, after)
    cells = np.where(apart(nearest) <= near, passages.cells[nearest], OUTSIDE)
    return cells.reshape(distances.shape)


def _passages(mesh: PolyMesh, starts: Floats, directions: Floats, lengths: Floats, near: float) -> _Passages:
    """Find the cells that lines of some lengths run through."""
    reached = _reached(mesh, starts, starts + lengths[:, None] * directions, near)
    edges = np.zeros(mesh.n_edges, dtype=np.bool_)
    edges[mesh.cell_edges[np.repeat(reached, mesh.cell_sizes)]] = True
    numbers = np.flatnonzero(edges)
    crossed, lines, places = _crossings(mesh, numbers, starts, directions)
    cells = mesh.edge_cells[numbers[crossed]].astype(np.int64).ravel()
    lines, places = np.repeat(lines, 2), np.repeat(places, 2)
    kept = (cells != OUTSIDE) & reached[cells]
    cells, lines, places = cells[kept], lines[kept], places[kept]
    order = np.lexsort((places, cells, lines))
    first, second = order[::2], order[1::2]
    lines, cells, enters, leaves = lines[first], cells[first], places[first], places[second]
    kept = (leaves >= -near) & (enters <= lengths[lines] + near)
    lines, cells = lines[kept], cells[kept]
    enters, leaves = np.maximum(enters[kept], -near), np.minimum(leaves[kept], lengths[lines] + near)
    order = np.lexsort((leaves, enters, lines))
    return _Passages(lines[order], cells[order], enters[order], leaves[order])


def _reached(mesh: PolyMesh, starts: Floats, ends: Floats, near: float) -> NDArray[np.bool_]:
    """Which cells the box around all lines reaches, shape (n_cells,)."""
    corners = mesh.points[mesh.cell_points]
    low = np.minimum.reduceat(corners, mesh.cell_offsets[:-1])
    high = np.maximum.reduceat(corners, mesh.cell_offsets[:-1])
    places = np.concatenate((starts, ends))
    return ((low <= places.max(axis=0) + near) & (high >= places.min(axis=0) - near)).all(axis=1)


def _crossings(mesh: PolyMesh, edges: Ints, starts: Floats, directions: Floats) -> tuple[Ints, Ints, Floats]:
    """Places among some edges, lines, and distances from the lines' starts where they cross, each (k,)."""
    points, ends = np.unique(mesh.edges[edges], return_inverse=True)
    ends = ends.reshape(-1, 2)
    normals = np.stack((directions[:, 1], -directions[:, 0]))
    beside = mesh.points[points] @ normals > np.einsum("mx,xm->m", starts, normals)
    crossed, lines = np.nonzero(beside[ends[:, 0]] != beside[ends[:, 1]])
    first, second = (mesh.points[points[ends[crossed, side]]] - starts[lines] for side in range(2))
    across = [np.einsum("kx,xk->k", each, normals[:, lines]) for each in (first, second)]
    along = [np.einsum("kx,kx->k", each, directions[lines]) for each in (first, second)]
    # an edge along the line, crossed by rounding alone, is crossed somewhere
    step = across[0] - across[1]
    share = np.clip(np.divide(across[0], step, out=np.zeros_like(step), where=step != 0.0), 0.0, 1.0)
    return crossed, lines, along[0] + share * (along[1] - along[0])
