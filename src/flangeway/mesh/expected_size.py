"""How large a triangulation will be: counted before Gmsh is called, and refused where it is too large.

A triangle of the edge length h covers ``sqrt(3) h^2 / 4``, an edge of the boundary h: the counts are integrals of the
target size over the region and along its boundary, on boxes and pieces so small that the size hardly changes in them.
"""

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np
from scipy.spatial import cKDTree

from flangeway.errors import InputError
from flangeway.geometry.arrays import BoolArray, FloatArray, IntArray
from flangeway.geometry.region import Region
from flangeway.geometry.segments import Arc, Segment
from flangeway.mesh.sizing import Refinement

MOST_TRIANGLES = 5_000_000
MOST_EDGES = 100_000
"""Along one side: Gmsh's time grows with the square where points lie on a line along an axis, to half an hour here."""
MOST_SEEDS = 5_000_000

TRIANGLES_AN_AREA = {"delaunay": 1.14, "frontal-delaunay": 1.0}
"""Triangles over what the target size alone would make, measured."""
BYTES_A_TRIANGLE = {"delaunay": 460, "frontal-delaunay": 950}
"""Of Gmsh and of the mesh taken from it; measured 440 to 480 and 900 to 980."""
BYTES_A_BOUNDARY_EDGE = 1200
BYTES_A_SEED = 10_000
"""Up to this much, mostly while Gmsh integrates the size along a curve beside them; measured 2,300 to 10,500."""

_AN_AREA = 4.0 / math.sqrt(3.0)
"""Equilateral triangles of side one in an area of one."""
_CHANGE = 0.5
"""Of the target size within a box or piece on which it is taken as constant."""

Sizes = Callable[[FloatArray, FloatArray], tuple[FloatArray, FloatArray, BoolArray]]


@dataclass(frozen=True)
class ExpectedMesh:
    """What a triangulation will need.

    Parameters
    ----------
    n_triangles
        Number of triangles.
    n_boundary_edges
        Number of edges on the boundary.
    squared_edges
        Sum over the sides of the square of their number of edges.
    n_seeds
        Number of points about which refinements are.
    bytes_a_triangle
        Memory for each triangle.

    """

    n_triangles: int
    n_boundary_edges: int
    squared_edges: float
    n_seeds: int
    bytes_a_triangle: int

    @property
    def n_bytes(self) -> int:
        """Memory at its peak."""
        return (
            self.bytes_a_triangle * self.n_triangles
            + BYTES_A_BOUNDARY_EDGE * self.n_boundary_edges
            + BYTES_A_SEED * self.n_seeds
        )

    @property
    def seconds(self) -> float:
        """Time on one core of about 2020, to a factor of two; less where long sides are not along an axis."""
        triangles = 2.5e-5 * self.n_triangles * (1e-5 * self.n_triangles) ** 0.3
        return triangles + 1e-7 * self.squared_edges + 1e-4 * self.n_seeds


def expected_mesh(
    region: Region, size: float, refinements: Sequence[Refinement], algorithm: str = "delaunay"
) -> ExpectedMesh:
    """Return what the triangulation of a region will need.

    Parameters
    ----------
    region
        The region.
    size, refinements, algorithm
        As for `flangeway.mesh.triangulate`.

    Raises
    ------
    InputError
        If it would have far too many triangles, edges along a side, or points of refinements.

    """
    fine = [refinement for refinement in refinements if refinement.size < size]
    n_seeds = sum(refinement.n_seeds for refinement in refinements)
    smallest = min([size, *(refinement.size for refinement in fine)])
    given = f"size = {size}" if smallest == size else f"size = {size} with the smallest local size {smallest}"
    area = region.area / size**2
    sides = [segment for loop in region.loops for segment in loop.segments]
    edges = np.array([segment.length for segment in sides]) / size
    if n_seeds > MOST_SEEDS:  # refused, so a rough count will do: as if they were sides of the region
        area += sum(r.length * (1.0 / r.size - 1.0 / size) / r.growth for r in fine)
    _refuse(given, area, edges, n_seeds)
    if fine:
        sizes = _sizes(fine, size)
        low, high = region.bounds()
        box = np.diag(0.5 * (high - low))
        first = np.zeros(1, dtype=np.int32)
        most = 2.0 * MOST_TRIANGLES / _AN_AREA
        area += _excess(0.5 * (low + high)[None], box[None], size, sizes, first, inside=region.contains, most=most)[0]
        _refuse(given, area, edges, n_seeds)
        starts, ends, numbers = _chords(sides, max(min(0.1 * r.size / r.growth for r in fine), 1e-6 * region.size))
        middles, halves = 0.5 * (starts + ends), 0.5 * (ends - starts)[:, None]
        edges += _excess(middles, halves, size, sizes, numbers, most=float(MOST_EDGES * len(sides)))
    _refuse(given, area, edges, n_seeds)
    n_edges = float(np.maximum(edges, 1.0).sum())
    n_triangles = max(TRIANGLES_AN_AREA[algorithm] * _AN_AREA * area, n_edges)
    return ExpectedMesh(
        math.ceil(n_triangles), math.ceil(n_edges), float(np.sum(edges**2)), n_seeds, BYTES_A_TRIANGLE[algorithm]
    )


def _refuse(given: str, area: float, edges: FloatArray, n_seeds: int) -> None:
    """Refuse numbers that are far too large; `area` in squares of the local size, `edges` on each side."""
    advice = "enlarge the size, shorten the refinement or let it grow faster"
    kinds = (
        (_AN_AREA * area, MOST_TRIANGLES, "triangles", advice),
        (float(edges.max()), MOST_EDGES, "edges along one side", advice),
        (n_seeds, MOST_SEEDS, "points along refinements", "enlarge their size, shorten them or let them grow slower"),
    )
    for found, most, kind, what in kinds:
        if found > most:
            raise InputError(f"{given}: about {found:.2g} {kind}", f"sizes that make up to {most} {kind}", what)


def _sizes(fine: Sequence[Refinement], size: float) -> Sizes:
    """Return a function of centres (n, 2) and radii (n,) about them.

    It gives the target sizes (n,) at the centres, how fast these grow (n,), and whether any is below `size` (n,). The
    lines of refinements are points to it, the coarser the larger the radii.
    """
    alike: dict[tuple[float, float], list[Refinement]] = {}
    for refinement in fine:
        alike.setdefault((refinement.size, refinement.growth), []).append(refinement)
    trees: dict[tuple[float, float, int], cKDTree] = {}

    def tree(smallest: float, growth: float, radius: float) -> cKDTree:
        finest = 0.25 * smallest / growth
        level = max(0, math.floor(math.log2(0.1 * radius / finest)))
        key = (smallest, growth, level)
        if key not in trees:
            points = [each.sampled(finest * 2.0**level) for each in alike[smallest, growth]]
            trees[key] = cKDTree(np.vstack(points))
        return trees[key]

    def sizes(centres: FloatArray, radii: FloatArray) -> tuple[FloatArray, FloatArray, BoolArray]:
        local = np.full(len(centres), size)
        growths = np.ones(len(centres))
        reached = np.zeros(len(centres), dtype=bool)
        for smallest, growth in alike:
            there = smallest + growth * tree(smallest, growth, float(radii.min())).query(centres)[0]
            reached |= there - growth * radii < size
            less = there < local
            local[less], growths[less] = there[less], growth
        return local, growths, reached

    return sizes


def _excess(
    centres: FloatArray,
    halves: FloatArray,
    size: float,
    sizes: Sizes,
    numbers: IntArray,
    *,
    inside: Callable[[FloatArray], BoolArray] = lambda points: np.ones(len(points), dtype=bool),
    most: float = math.inf,
) -> FloatArray:
    """Return integrals of ``1 / h^k - 1 / size^k`` over boxes (k = 2) or straight pieces (k = 1).

    Parameters
    ----------
    centres, halves
        Middles (n, 2), and half of each side as a vector (n, k, 2).
    size, sizes
        Size away from refinements, and those near them.
    numbers
        Which integral each belongs to (n,).
    inside
        Whether points count.
    most
        Sum of the integrals beyond which their exact values are not wanted.

    """
    n_sides = halves.shape[1]
    total = np.zeros(numbers.max() + 1)
    while len(centres):
        lengths = np.hypot(halves[..., 0], halves[..., 1])
        radii = np.sqrt(np.sum(lengths**2, axis=1))
        local, growths, reached = sizes(centres, radii)
        centres, halves, lengths, numbers = centres[reached], halves[reached], lengths[reached], numbers[reached]
        local, growths, radii = local[reached], growths[reached], radii[reached]
        areas = inside(centres) * np.prod(2.0 * lengths, axis=1)
        parts = areas * (local**-n_sides - size**-n_sides)
        least = areas * (np.minimum(local + growths * radii, size) ** -n_sides - size**-n_sides)
        done = 2.0 * lengths.max(axis=1, initial=0.0) * growths <= _CHANGE * local
        if float(total.sum() + least.sum()) > most:
            parts, done[:] = least, True
        np.add.at(total, numbers[done], parts[done])
        rest = np.flatnonzero(~done)
        halves, longest = halves[rest], lengths[rest].argmax(axis=1)
        rows = np.arange(len(rest))
        step = 0.5 * halves[rows, longest]
        halves[rows, longest] = step
        centres = np.vstack([centres[rest] - step, centres[rest] + step])
        halves, numbers = np.concatenate([halves, halves]), np.tile(numbers[rest], 2)
    return total


def _chords(sides: Sequence[Segment], deviation: float) -> tuple[FloatArray, FloatArray, IntArray]:
    """Return starts (n, 2) and ends (n, 2) of chords that close to the sides, and the side of each (n,)."""
    starts, ends, numbers = [], [], []
    for number, side in enumerate(sides):
        n_chords = 1
        if isinstance(side, Arc):
            n_chords = math.ceil(0.5 * abs(side.sweep) / math.acos(max(1.0 - deviation / side.radius, 0.0)))
        points = side.point(np.linspace(0.0, 1.0, n_chords + 1))
        starts.append(points[:-1])
        ends.append(points[1:])
        numbers.append(np.full(n_chords, number, dtype=np.int32))
    return np.vstack(starts), np.vstack(ends), np.concatenate(numbers)
