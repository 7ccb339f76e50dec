"""Triangulation of regions and of sections of several parts with Gmsh, and the target size of triangles."""

import importlib
import math
import threading
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from contextvars import ContextVar
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from flangeway.checks import check_kind, check_positive, is_finite
from flangeway.errors import InputError, MissingLibraryError, short
from flangeway.geometry.arrays import IntArray, as_points, cross_product, extent, step_lengths
from flangeway.geometry.outline import Outline
from flangeway.geometry.placement import Placement
from flangeway.geometry.region import Region, Section
from flangeway.geometry.segments import Arc, halved
from flangeway.mesh.curved import Curves, curved, with_names
from flangeway.mesh.polymesh import PolyMesh
from flangeway.system.memory_limits import refuse_large_mesh
from flangeway.system.own_process import BYTES, in_own_process
from flangeway.types import Floats, Ints

# --- Target size of triangles: one size, and refinements along polylines; how many triangles these can make.


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

REPORT_AFTER_S = 3.0  # seconds of a triangulation without a report, and after Ctrl-C
_AN_AREA = 4.0 / math.sqrt(3.0)  # equilateral triangles of side one in an area of one

_REPORT: ContextVar[Callable[[str], None]] = ContextVar("_REPORT", default=lambda _: None)


@dataclass(frozen=True, eq=False, init=False)
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
    growth: float

    def __init__(self, points: ArrayLike, size: float, growth: float = 0.15) -> None:
        """Check the numbers and keep a read-only copy of the points."""
        polyline = as_points(points, "points of a refinement").copy()
        if not len(polyline):
            raise InputError("a refinement without points", "one point or more", "add points")
        polyline.setflags(write=False)
        for name, value in (("size", size), ("growth", growth)):
            check_positive("Refinement", name, value)
        for name, stored in (("points", polyline), ("size", size), ("growth", growth)):
            object.__setattr__(self, name, stored)

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

    - `progress`: called with a sentence before each triangulation that can take more than `REPORT_AFTER_S` seconds.
    """
    token = _REPORT.set(progress)
    try:
        yield
    finally:
        _REPORT.reset(token)


def made(bound: MeshBound, work: Callable[..., PolyMesh], *arguments: Any) -> PolyMesh:
    """Return the mesh that a function of a module makes: here if it takes little time, else in another process."""
    long = bound.seconds > REPORT_AFTER_S
    counted = f"up to about {float(f'{bound.n_triangles:.2g}'):,.0f} triangles"
    refuse_large_mesh(f"the triangulation into {counted}", bound.n_bytes + long * BYTES)
    if not long:
        return work(*arguments)
    minutes = bound.seconds / 60.0
    time = f"{minutes:.0f} minutes" if minutes > 1.5 else f"{bound.seconds:.0f} seconds"
    _REPORT.get()(f"triangulating: {counted}, which can take about {time}")
    return in_own_process(work, *arguments)


# --- Triangulation of regions and of sections of several parts with Gmsh, which is brought in only when it is needed.


OPTIONS = {
    "General.Terminal": 0,
    "General.NumThreads": 1,
    "Mesh.Algorithm": 5,  # Delaunay
    "Mesh.ElementOrder": 1,
    "Mesh.RandomSeed": 1,
    # the size comes from the background field alone
    "Mesh.MeshSizeExtendFromBoundary": 0,
    "Mesh.MeshSizeFromCurvature": 0,
    "Mesh.MeshSizeFromPoints": 0,
    "Mesh.MeshSizeFactor": 1,
    "Mesh.MeshSizeMin": 0,
    "Mesh.MeshSizeMax": 1e22,
    "Mesh.RecombineAll": 0,
    "Mesh.SubdivisionAlgorithm": 0,
}


_HULL_DISTANCE = 100.0  # of the section's size

DEBIAN_PACKAGES = (
    *("libfontconfig1", "libgl1", "libglu1-mesa", "libgomp1", "libx11-6", "libxcursor1", "libxext6"),
    *("libxfixes3", "libxft2", "libxinerama1", "libxrender1"),
)
"""Debian packages that bring the shared libraries which the Gmsh wheel expects of the system."""

_LOCK = threading.RLock()


def load_gmsh() -> Any:
    """Return the module gmsh; a `MissingLibraryError` names the packages of it or of a shared library it lacks."""
    try:
        return importlib.import_module("gmsh")
    except ImportError as reason:
        raise MissingLibraryError(
            "meshes need Gmsh's module for Python, which is not installed\n"
            "  what to do: pip install gmsh; where there is none (Linux on arm64), on Debian or Ubuntu\n"
            "    apt-get install python3-gmsh, and make the environment with: python3 -m venv --system-site-packages"
        ) from reason
    except OSError as reason:
        raise MissingLibraryError(
            f"Gmsh needs a shared library that this system lacks: {reason}\n"
            "  what to do: on Debian or Ubuntu run\n"
            f"    apt-get install {' '.join(DEBIAN_PACKAGES)}\n"
            "  elsewhere install the packages that bring the same libraries"
        ) from reason


@contextmanager
def gmsh_model(options: Mapping[str, float]) -> Iterator[Any]:
    """Give gmsh with a new, empty model that is removed at the end, and options by name for its time.

    If the caller has initialised Gmsh, the options and the current model are restored; if not, Gmsh is finalised. One
    thread at a time.
    """
    with _LOCK:
        gmsh = load_gmsh()
        owner = not gmsh.isInitialized()
        if owner:
            # no configuration files and no signal handlers: the caller's process stays his
            gmsh.initialize(readConfigFiles=False, interruptible=False)
        before = {} if owner else {option: gmsh.option.getNumber(option) for option in options}
        current = None if owner else gmsh.model.getCurrent()
        try:
            _set(gmsh, options)
            gmsh.model.add("flangeway")
            try:
                yield gmsh
            finally:
                gmsh.model.remove()
        finally:
            if owner:
                gmsh.finalize()
            else:
                _set(gmsh, before)
                gmsh.model.setCurrent(current)


def _set(gmsh: Any, options: Mapping[str, float]) -> None:
    for option, value in options.items():
        gmsh.option.setNumber(option, value)


def _generate(gmsh: Any, kernel: Any, size: float, refinements: Sequence[Refinement]) -> None:
    """Make the plane mesh of what a kernel has drawn; an `InputError` with Gmsh's reason if it fails.

    The target size is Gmsh's background field. Gmsh's own distance to a cloud of points is a search tree in compiled
    code, so that meshing never calls back into Python.
    """
    # one tree for all refinements that grow alike: the least of their distances is that to all points together
    alike: dict[tuple[float, float], list[int]] = {}
    for refinement in refinements:
        tags = [kernel.addPoint(*point, 0.0) for point in refinement.seeds().tolist()]
        if refinement.size < size:
            alike.setdefault((refinement.size, refinement.growth), []).extend(tags)
    kernel.synchronize()
    field = gmsh.model.mesh.field
    constant = field.add("MathEval")
    field.setString(constant, "F", f"{size:.17g}")
    parts = [constant]
    for (fine, growth), tags in alike.items():
        distance = field.add("Distance")
        field.setNumbers(distance, "PointsList", tags)
        near = field.add("Threshold")
        reach = (size - fine) / growth
        numbers = {"InField": distance, "SizeMin": fine, "SizeMax": size, "DistMin": 0.0, "DistMax": reach}
        for name, value in numbers.items():
            field.setNumber(near, name, value)
        parts.append(near)
    least = field.add("Min")
    field.setNumbers(least, "FieldsList", parts)
    field.setAsBackgroundMesh(least)
    try:
        gmsh.model.mesh.generate(2)
    except Exception as reason:
        raise InputError(
            f"a region that Gmsh does not mesh: {reason}",
            "outlines without slivers much smaller than the size",
            "reduce the size, or look at the outline",
        ) from reason


def triangulate(
    shape: Outline | Region,
    *,
    size: float,
    refinements: Sequence[Refinement] = (),
    holes: Sequence[Outline] = (),
    outline: Curves | None = None,
) -> PolyMesh:
    """Return a mesh of triangles of a region: inside an outline and outside of holes.

    Lines and arcs go to Gmsh as they are, so boundary points lie on them; the edges between these points are straight
    unless `outline` says on which curves they lie. The local target size is
    ``min(size, r.size + r.growth * distance)`` over the refinements; boundary edges follow it too.
    The same input gives the same mesh. What takes long runs in another process, so that Ctrl-C
    ends it at once; `long_meshes_reported` reports it.

    Parameters
    ----------
    shape
        Outer boundary, or a region with its holes, such as those of `pipe_section`.
    size
        Length of a triangle's edge away from refinements.
    refinements
        Where triangles are smaller.
    holes
        Outlines of further holes, inside `shape` and apart from each other.
    outline
        All curves of the boundary, as for `dual`: edges on its arcs and splines become curved, see
        `flangeway.mesh.curved`. It may be the shape itself, with the holes in a list, or the spline of which the
        shape is a polygon. Elements of order 2 or more take the curves; without them they have the error of chords.

    Returns
    -------
    PolyMesh
        Counter-clockwise triangles; one edge set for every name of a segment.

    Raises
    ------
    InputError
        If a size makes no mesh or far too many triangles or edges on the boundary, a hole is not
        inside, Gmsh refuses the region, or no edge lies on a curve of `outline`.
    OutOfMemoryError
        If there is no memory for so many triangles; see `flangeway.mesh.gmsh_mesher`.
    MissingLibraryError
        If Gmsh lacks a shared library of the system.
    """
    allowed, advice = "an Outline or a Region", "triangulate_section takes a Section, flangeway.geometry makes outlines"
    check_kind("triangulate", "shape", shape, Outline | Region, allowed, advice)
    outer, *inner = shape.loops if isinstance(shape, Region) else [shape]
    refuse_size(outer, size)
    region = Region(outer, (*inner, *holes))  # refuses holes that are not inside or not apart
    bound = mesh_bound([region], size, refinements)
    mesh = made(bound, _meshed, region, size, tuple(refinements))
    return mesh if outline is None else curved(mesh, outline)


def triangulate_section(
    section: Section,
    *,
    size: float,
    refinements: Sequence[Refinement] = (),
) -> PolyMesh:
    """Return a mesh of triangles of all parts, conforming where they touch; `flangeway.mesh.curved` takes the section.

    Parameters
    ----------
    section
        The parts. Edges that two parts share must be at the same place; their ends need not be.
    size
        Length of a triangle's edge away from refinements.
    refinements
        Where triangles are smaller; see `triangulate`.

    Returns
    -------
    PolyMesh
        With a cell set for every part, and an edge set for every name of a segment on the boundary.

    Raises
    ------
    InputError
        If parts overlap, or as for `triangulate`.
    OutOfMemoryError
        As for `triangulate`.
    """
    check_positive("triangulate_section", "size", size, "a positive length")
    low, high = section.bounds()
    middle = 0.5 * (low + high)
    if np.abs(middle).max() > _HULL_DISTANCE * section.size:
        # Gmsh compares points with a tolerance of their distance from the origin
        away = Placement(translation=(float(middle[0]), float(middle[1])))
        nearer = [Refinement(r.points - middle, r.size, r.growth) for r in refinements]
        mesh = triangulate_section(section.transformed(away.inverse()), size=size, refinements=nearer)
        return mesh.placed(away)
    if len(section.parts) == 1:
        ((name, region),) = section.parts.items()
        mesh = triangulate(region, size=size, refinements=refinements)
        return mesh.with_cell_set(name, np.arange(mesh.n_cells))
    bound = mesh_bound(section.regions, size, refinements)
    return made(bound, _meshed_section, dict(section.parts), size, tuple(refinements))


def _meshed(region: Region, size: float, refinements: Sequence[Refinement]) -> PolyMesh:
    with gmsh_model(OPTIONS) as gmsh:
        loops = [_add_loop(gmsh.model.geo, loop) for loop in region.loops]
        surface = gmsh.model.geo.addPlaneSurface(
            [gmsh.model.geo.addCurveLoop([curve for curve, _ in loop]) for loop in loops]
        )
        _generate(gmsh, gmsh.model.geo, size, refinements)
        return _of_region(gmsh, surface, region.loops, loops)


def _meshed_section(parts: dict[str, Region], size: float, refinements: Sequence[Refinement]) -> PolyMesh:
    section = Section(parts)
    with gmsh_model(OPTIONS) as gmsh:
        surfaces = _fragments(gmsh, section)
        _generate(gmsh, gmsh.model.occ, size, refinements)
        return _of_section(gmsh, section, surfaces)


def _fragments(gmsh: Any, section: Section) -> dict[str, list[int]]:
    """Give the parts to Gmsh, cut where they touch; return the surfaces of each."""
    occ = gmsh.model.occ
    first = []
    for region in section.regions:
        loops = [_add_loop(occ, loop, center=False) for loop in region.loops]
        first.append((2, occ.addPlaneSurface([occ.addCurveLoop([curve for curve, _ in loop]) for loop in loops])))
    _, children = occ.fragment(first[:1], first[1:])
    occ.synchronize()
    owners: dict[int, str] = {}
    surfaces: dict[str, list[int]] = {name: [] for name in section.parts}
    for name, pieces in zip(section.parts, children, strict=True):
        for dimension, tag in pieces:
            if dimension != 2:
                continue
            if tag in owners:
                x, y, _ = occ.getCenterOfMass(2, tag)
                raise InputError(
                    f"parts {owners[tag]} and {name}, which overlap about ({x:.6g}, {y:.6g})",
                    "parts that touch along edges or keep apart",
                    "move one of them, or cut a hole where the other is",
                )
            owners[tag] = name
            surfaces[name].append(tag)
    return surfaces


def _add_loop(kernel: Any, outline: Outline, **center: bool) -> list[tuple[int, int]]:
    """Add a loop's curves to a kernel of Gmsh; return (curve, number of its segment) for each.

    With ``center=False`` arcs go through their middles: no radius to disagree by rounding.
    """
    # Gmsh takes arcs below half a turn
    pieces = halved(outline.segments, 0.9 * math.pi)
    corners = [kernel.addPoint(*piece.start, 0.0) for piece, _ in pieces]
    curves = []
    for i, (piece, number) in enumerate(pieces):
        start, end = corners[i], corners[(i + 1) % len(corners)]
        if isinstance(piece, Arc):
            third = piece.point(0.5)[0].tolist() if center else piece.centre
            curve = kernel.addCircleArc(start, kernel.addPoint(*third, 0.0), end, **center)
        else:
            curve = kernel.addLine(start, end)
        curves.append((int(curve), number))
    return curves


def _triangles(gmsh: Any, surfaces: Sequence[int]) -> tuple[Ints, Floats, IntArray, list[int]]:
    """Gmsh's tags of the points that triangles use, these points, triangles, and their number on each surface."""
    mesh = gmsh.model.mesh
    tags, coordinates, _ = mesh.getNodes()
    order = np.argsort(tags)
    tags, points = tags[order], coordinates.reshape(-1, 3)[order, :2]
    corners = [mesh.getElementsByType(2, surface)[1] for surface in surfaces]
    counts = [len(points_of_surface) // 3 for points_of_surface in corners]
    used, numbers = np.unique(corners[0] if len(corners) == 1 else np.concatenate(corners), return_inverse=True)
    del corners  # large
    points, triangles = points[np.searchsorted(tags, used)], numbers.reshape(-1, 3).astype(np.int32)
    del numbers
    a, b, c = (points[triangles[:, i]] for i in range(3))
    clockwise = cross_product(b - a, c - a) < 0.0
    triangles[clockwise, 1:] = triangles[clockwise, :0:-1]
    return used, points, triangles, counts


def _of_region(
    gmsh: Any, surface: int, outlines: Sequence[Outline], loops: Sequence[Sequence[tuple[int, int]]]
) -> PolyMesh:
    """Return Gmsh's triangles with points in the order of its tags, unused ones left out."""
    used, points, triangles, _ = _triangles(gmsh, [surface])
    if not len(used):
        raise InputError("a region in which Gmsh made no triangle", "a region", "reduce the size")
    pairs: dict[str, list[IntArray]] = {}
    for k, (outline, loop) in enumerate(zip(outlines, loops, strict=True)):
        for curve, number in loop:
            nodes = gmsh.model.mesh.getElementsByType(1, curve)[1]
            edges = np.searchsorted(used, nodes).reshape(-1, 2).astype(np.int32)
            # a hole has the body on its right
            pairs.setdefault(outline.names[number], []).append(edges[::-1, ::-1] if k else edges)
    edge_sets = {name: np.vstack(parts) for name, parts in pairs.items()}
    return PolyMesh.from_cells(points, triangles, edge_sets=edge_sets)


def _of_section(gmsh: Any, section: Section, surfaces: dict[str, list[int]]) -> PolyMesh:
    """Return Gmsh's triangles, those of each part as a cell set."""
    _, points, triangles, counts = _triangles(gmsh, [tag for tags in surfaces.values() for tag in tags])
    owners = np.repeat(np.repeat(np.arange(len(surfaces)), [len(tags) for tags in surfaces.values()]), counts)
    cell_sets = {name: np.flatnonzero(owners == number).astype(np.int32) for number, name in enumerate(surfaces)}
    for name, cells in cell_sets.items():
        if not len(cells):
            raise InputError(f"part {name}, in which Gmsh made no triangle", "a part", "reduce the size")
    return with_names(PolyMesh.from_cells(points, triangles, cell_sets=cell_sets), section.loops)
