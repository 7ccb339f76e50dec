"""Which cell of a mesh a point lies in."""

import numpy as np
from numpy.typing import ArrayLike, NDArray

from flangeway.checks import as_numbers
from flangeway.errors import InputError
from flangeway.geometry.arrays import cross_product
from flangeway.mesh import PolyMesh
from flangeway.types import Floats, Ints

NEAR = 1e-9
"""Distance from the boundary, over the size of the mesh, within which a point still belongs to the mesh."""
OUTSIDE = -1


def locate(mesh: PolyMesh, points: ArrayLike) -> Ints:
    """Cell of each point (n, 2), shape (n,); -1 outside of the mesh.

    A point on a common edge belongs to one of its cells. An `InputError` if the points have another shape or are not
    finite.
    """
    given = as_numbers("points", points)
    if given.ndim != 2 or given.shape[1:] != (2,) or not np.isfinite(given).all():
        raise InputError(f"points of shape {given.shape}", "finite numbers, shape (n, 2)", "give rows of x and y")
    cells = np.full(len(given), OUTSIDE, dtype=np.int64)
    near = NEAR * float(np.linalg.norm(np.ptp(mesh.points, axis=0)))
    which, candidates = _candidates(mesh, given, near)
    if len(which) == 0:
        return cells
    inside, distances = _tested(mesh, given[which], candidates)
    # the nearest of the cells that are near comes first and is overwritten by one that contains the point
    touching = np.flatnonzero(distances <= near)
    touching = touching[np.argsort(-distances[touching], kind="stable")]
    cells[which[touching]] = candidates[touching]
    cells[which[inside]] = candidates[inside]
    return cells


def _candidates(mesh: PolyMesh, points: Floats, near: float) -> tuple[Ints, Ints]:
    """Pairs of a point and a cell whose bounding box holds it, found through a grid of about as many bins as cells."""
    corners = mesh.points[mesh.cell_points]
    low = np.minimum.reduceat(corners, mesh.cell_offsets[:-1]) - near
    high = np.maximum.reduceat(corners, mesh.cell_offsets[:-1]) + near
    start, end = low.min(axis=0), high.max(axis=0)
    n_bins = np.maximum(np.ceil((end - start) / np.median(high - low, axis=0)), 1.0)
    n_bins = np.minimum(n_bins, 4.0 * np.sqrt(mesh.n_cells) + 1.0).astype(np.int64)
    width = (end - start) / n_bins

    def bin_of(places: Floats) -> Ints:
        return np.clip(((places - start) / width).astype(np.int64), 0, n_bins - 1)

    first, last = bin_of(low), bin_of(high)
    spans = last - first + 1
    counts = spans.prod(axis=1)
    cell = np.repeat(np.arange(mesh.n_cells), counts)
    within = np.arange(len(cell)) - np.repeat(np.cumsum(counts) - counts, counts)
    bins = (first[cell, 0] + within % spans[cell, 0]) * n_bins[1] + first[cell, 1] + within // spans[cell, 0]
    order = np.argsort(bins, kind="stable")
    sorted_bins, sorted_cells = bins[order], cell[order]
    here = ((points >= start) & (points <= end)).all(axis=1)
    number = np.flatnonzero(here)
    wanted = bin_of(points[here])
    key = wanted[:, 0] * n_bins[1] + wanted[:, 1]
    begin, stop = np.searchsorted(sorted_bins, key, "left"), np.searchsorted(sorted_bins, key, "right")
    which = np.repeat(number, stop - begin)
    place = np.arange(len(which)) + np.repeat(begin - (np.cumsum(stop - begin) - (stop - begin)), stop - begin)
    candidates = sorted_cells[place]
    boxed = ((points[which] >= low[candidates]) & (points[which] <= high[candidates])).all(axis=1)
    return which[boxed], candidates[boxed]


def _tested(mesh: PolyMesh, points: Floats, cells: Ints) -> tuple[NDArray[np.bool_], Floats]:
    """For pairs of a point and a cell: whether it is inside (crossing number), and its distance from the boundary."""
    sizes = mesh.cell_sizes[cells].astype(np.int64)
    pair = np.repeat(np.arange(len(cells)), sizes)
    starts = np.cumsum(sizes) - sizes
    place = np.arange(len(pair)) - starts[pair]
    offset = mesh.cell_offsets[cells][pair]
    a = mesh.points[mesh.cell_points[offset + place]] - points[pair]
    b = mesh.points[mesh.cell_points[offset + (place + 1) % sizes[pair]]] - points[pair]
    straddles = (a[:, 1] > 0.0) != (b[:, 1] > 0.0)
    along = b - a
    cross = cross_product(a, along)
    to_the_right = straddles & ((cross > 0.0) == (along[:, 1] > 0.0))
    crossings = np.add.reduceat(to_the_right, starts, dtype=np.int64)
    squared = np.maximum(np.einsum("ni,ni->n", along, along), np.finfo(np.float64).tiny)
    nearest = np.clip(-np.einsum("ni,ni->n", a, along) / squared, 0.0, 1.0)
    distance = np.linalg.norm(a + nearest[:, None] * along, axis=1)
    return crossings % 2 == 1, np.minimum.reduceat(distance, starts)
