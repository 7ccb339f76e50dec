"""Target size of triangles: one size, and refinements along polylines; how many triangles these can make."""

import math
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from contextvars import ContextVar
from dataclasses import dataclass
from typing import Any

import numpy as np

from flangeway.checks import check_positive, is_finite
from flangeway.errors import InputError, short
from flangeway.geometry.arrays import as_points, extent, step_lengths
from flangeway.geometry.outline import Outline
from flangeway.geometry.region import Region
from flangeway.mesh.polymesh import PolyMesh
from flangeway.system.memory_limits import refuse_large_mesh
from flangeway.system.own_process import BYTES, in_own_process
from flangeway.types import Floats

MAX_TRIANGLES = 5_000_000
MAX_EDGES = 100_000
"""Along one side: Gmsh's time grows with the square where points lie on a line along an axis, to half an hour here."""
MAX_SEEDS = 5_000_000

TRIANGLES_AN_AREA = 1.14
"""Triangles over what the target size alone would make, measured."""
BYTES_A_TRIANGLE = 460
"""Of Gmsh and of the mesh taken from it; measured 440 to 480."""
BYTES_A_BOUNDARY_EDGE = 1200
BYTES_A_SEED = 10_000
"""Up to this much, mostly while Gmsh integrates the size along a curve beside them; measured 2,300 to 10,500."""

LONG = 3.0  # seconds of a triangulation without a report, and after Ctrl-C
_AN_AREA = 4.0 / math.sqrt(3.0)  # equilateral triangles of side one in an area of one

_REPORT: ContextVar[Callable[[str], None]] = ContextVar("_REPORT", default=lambda _: None)


@dataclass(frozen=True, eq=False)
class Refinement:
    """Finer triangles about a polyline: ``size + growth * distance to the polyline``.

    Parameters
    ----------
    points
        Polyline (n, 2); one point refines about that point.
    size
        Length of edges on the polyline.
    growth
        Growth of the edges per distance, positive; about 0.1 to 0.3.

    Raises
    ------
    InputError
        If a number is not positive or a point is not finite.
    """

    points: Floats
    size: float
    growth: float = 0.15

    def __post_init__(self) -> None:
        """Check the numbers and keep a read-only copy of the points."""
        points = as_points(self.points, "points of a refinement").copy()
        if not len(points):
            raise InputError("a refinement without points", "one point or more", "add points")
        points.setflags(write=False)
        object.__setattr__(self, "points", points)
        for name, value in (("size", self.size), ("growth", self.growth)):
            check_positive("Refinement", name, value)

    @property
    def _pieces(self) -> Floats:
        """Number of seeds on each segment: between neighbours the distance to the nearest errs below 2 % of size."""
        lengths = step_lengths(self.points)
        return np.maximum(np.ceil(lengths / (self.size * min(1.0, 0.04 / self.growth))), 1.0)

    @property
    def n_seeds(self) -> int:
        """Number of `seeds`, counted without making them."""
        return int(self._pieces.sum()) + 1

    def seeds(self) -> Floats:
        """Return points (n_seeds, 2) of the polyline, whose distance field is used for that of the polyline."""
        rows = [
            start + (end - start) * (np.arange(n) / n)[:, None]
            for start, end, n in zip(self.points[:-1], self.points[1:], self._pieces, strict=True)
        ]
        return np.vstack([*rows, self.points[-1:]])


@dataclass(frozen=True)
class MeshBound:
    """Maximum number of triangles, bytes at the peak, and seconds on one core of 2020, to a factor of two."""

    n_triangles: int
    n_bytes: int
    seconds: float


def mesh_bound(regions: Sequence[Region], size: float, refinements: Sequence[Refinement] = ()) -> MeshBound:
    """Return what the triangulation of regions that make one section needs at most.

    A triangle of the edge length h covers ``sqrt(3) h^2 / 4``. A refinement adds the integral of ``1 / h^2`` over the
    strip on both sides of its polyline in which h is below `size`, so up to twice what it makes along a boundary. An
    `InputError` if there can be far too many triangles, edges along a side, or points of refinements.
    """
    fine = [refinement for refinement in refinements if refinement.size < size]
    n_seeds = sum(refinement.n_seeds for refinement in refinements)
    # a part that is smaller than the size is meshed with its extent
    parts = [(region, min(size, extent(region.bounds()))) for region in regions]
    area = sum(region.area / local**2 for region, local in parts)
    sides = np.array([side.length / h for part, h in parts for loop in part.loops for side in loop.segments])
    whole, added = sum(region.area for region in regions), 0.0
    for r in fine:
        length, ratio = float(step_lengths(r.points).sum()), size / r.size
        strip = 2.0 * length * (1.0 / r.size - 1.0 / size) / r.growth
        ends = 2.0 * math.pi * (math.log(ratio) - 1.0 + 1.0 / ratio) / r.growth**2
        area += min(strip + ends, whole / r.size**2)
        added += min(length / r.size + 2.0 * math.log(ratio) / r.growth, size * sides.sum() / r.size)
    smallest = min([size, *(refinement.size for refinement in fine)])
    given = f"size = {size}" if smallest == size else f"size = {size} with the smallest local size {smallest}"
    for number, most, kind, what in (
        (n_seeds, MAX_SEEDS, "points along refinements", "enlarge their size, shorten them or let them grow slower"),
        (_AN_AREA * area, MAX_TRIANGLES, "triangles", "enlarge the size, shorten the refinement or let it grow faster"),
        (sides.max() + added, MAX_EDGES, "edges along one side", "enlarge the size or shorten the refinement"),
    ):
        if number > most:
            raise InputError(f"{given}: about {number:.2g} {kind}", f"sizes that make up to {most} {kind}", what)
    n_edges = np.maximum(sides, 1.0).sum() + added
    n_triangles = math.ceil(max(TRIANGLES_AN_AREA * _AN_AREA * area, n_edges))
    return MeshBound(
        n_triangles,
        math.ceil(BYTES_A_TRIANGLE * n_triangles + BYTES_A_BOUNDARY_EDGE * n_edges + BYTES_A_SEED * n_seeds),
        2.5e-5 * n_triangles * (1e-5 * n_triangles) ** 0.3 + 1e-7 * float(np.sum(sides**2) + added**2) + 1e-4 * n_seeds,
    )


def refuse_size(outline: Outline, size: float) -> None:
    """Refuse a size that is not positive, or larger than the region inside an outline."""
    extent = float(np.max(outline.bounds()[1] - outline.bounds()[0]))
    if not (is_finite(size) and 0.0 < size <= extent):
        raise InputError(
            f"size = {short(size)}",
            f"a positive length up to the extent {extent:.6g} of the region",
            "give the length of a triangle's edge",
        )


@contextmanager
def long_meshes_reported(progress: Callable[[str], None]) -> Iterator[None]:
    """Report triangulations that take long, wherever they are begun inside this context.

    - `progress`: called with a sentence before each triangulation that can take more than `LONG` seconds.
    """
    token = _REPORT.set(progress)
    try:
        yield
    finally:
        _REPORT.reset(token)


def made(bound: MeshBound, work: Callable[..., PolyMesh], *arguments: Any) -> PolyMesh:
    """Return the mesh that a function of a module makes: here if it takes little time, else in another process."""
    long = bound.seconds > LONG
    counted = f"up to about {float(f'{bound.n_triangles:.2g}'):,.0f} triangles"
    refuse_large_mesh(f"the triangulation into {counted}", bound.n_bytes + long * BYTES)
    if not long:
        return work(*arguments)
    minutes = bound.seconds / 60.0
    time = f"{minutes:.0f} minutes" if minutes > 1.5 else f"{bound.seconds:.0f} seconds"
    _REPORT.get()(f"triangulating: {counted}, which can take about {time}")
    return in_own_process(work, *arguments)
