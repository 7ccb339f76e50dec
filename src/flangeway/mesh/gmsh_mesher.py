"""Triangulation of a region with Gmsh."""

import math
from collections.abc import Sequence
from typing import Any, Literal

import numpy as np

from flangeway.errors import InputError, short
from flangeway.geometry.arrays import IntArray
from flangeway.geometry.outline import Outline
from flangeway.geometry.region import Region
from flangeway.geometry.segments import Arc, halved
from flangeway.mesh.gmsh_session import generate, gmsh_model
from flangeway.mesh.polymesh import PolyMesh
from flangeway.mesh.sizing import Refinement, made, mesh_bound, refuse_size
from flangeway.types import Floats, Ints

ALGORITHMS = {"delaunay": 5, "frontal-delaunay": 6}
"""Gmsh's numbers of the algorithms."""

OPTIONS = {
    "General.Terminal": 0,
    "General.NumThreads": 1,
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


def triangulate(
    outline: Outline,
    *,
    size: float,
    refinements: Sequence[Refinement] = (),
    holes: Sequence[Outline] = (),
    algorithm: Literal["delaunay", "frontal-delaunay"] = "delaunay",
) -> PolyMesh:
    """Return a mesh of triangles of the region inside an outline and outside of its holes.

    Lines and arcs go to Gmsh as they are, so boundary points lie on them. The local target size is
    ``min(size, r.size + r.growth * distance)`` over the refinements; boundary edges follow it too.
    The same input gives the same mesh. What takes long runs in another process, so that Ctrl-C
    ends it at once; `long_meshes_reported` reports it.

    Parameters
    ----------
    outline
        Outer boundary.
    size
        Length of a triangle's edge away from refinements.
    refinements
        Where triangles are smaller.
    holes
        Outlines of holes, inside `outline` and apart from each other.
    algorithm
        ``"delaunay"`` or ``"frontal-delaunay"`` (more regular, a little slower).

    Returns
    -------
    PolyMesh
        Counter-clockwise triangles; one edge set for every name of a segment.

    Raises
    ------
    InputError
        If a size makes no mesh or far too many triangles or edges on the boundary, a hole is not
        inside, the algorithm is unknown, or Gmsh refuses the region.
    OutOfMemoryError
        If there is no memory for so many triangles; see `flangeway.mesh.sizing`.
    MissingLibraryError
        If Gmsh lacks a shared library of the system.

    """
    refuse_algorithm(algorithm)
    refuse_size(outline, size)
    region = Region(outline, tuple(holes))  # refuses holes that are not inside or not apart
    bound = mesh_bound([region], size, refinements, algorithm)
    return made(bound, _meshed, region, size, tuple(refinements), algorithm)


def refuse_algorithm(algorithm: str) -> None:
    """Refuse the name of an algorithm that is not known."""
    if algorithm not in ALGORITHMS:
        raise InputError(f"algorithm = {short(algorithm)}", f"one of {sorted(ALGORITHMS)}", "choose one of them")


def _meshed(region: Region, size: float, refinements: Sequence[Refinement], algorithm: str) -> PolyMesh:
    with gmsh_model("flangeway", OPTIONS | {"Mesh.Algorithm": ALGORITHMS[algorithm]}) as gmsh:
        loops = [_add_loop(gmsh, loop) for loop in region.loops]
        surface = gmsh.model.geo.addPlaneSurface(
            [gmsh.model.geo.addCurveLoop([curve for curve, _ in loop]) for loop in loops]
        )
        seeds = [[_add_point(gmsh, p) for p in r.seeds()] for r in refinements]
        gmsh.model.geo.synchronize()
        set_size_field(gmsh, size, refinements, seeds)
        generate(gmsh)
        return _collected(gmsh, surface, region.loops, loops)


def _add_point(gmsh: Any, point: Sequence[float] | Floats) -> int:
    return int(gmsh.model.geo.addPoint(float(point[0]), float(point[1]), 0.0))


def _add_loop(gmsh: Any, outline: Outline) -> list[tuple[int, int]]:
    """Add a loop's curves; return (curve, number of its segment) for each."""
    # Gmsh takes arcs below half a turn
    pieces = halved(outline.segments, 0.9 * math.pi)
    corners = [_add_point(gmsh, piece.start) for piece, _ in pieces]
    curves = []
    for i, (piece, number) in enumerate(pieces):
        start, end = corners[i], corners[(i + 1) % len(corners)]
        if isinstance(piece, Arc):
            centre = _add_point(gmsh, piece.centre)
            curve = gmsh.model.geo.addCircleArc(start, centre, end)
        else:
            curve = gmsh.model.geo.addLine(start, end)
        curves.append((int(curve), number))
    return curves


def set_size_field(gmsh: Any, size: float, refinements: Sequence[Refinement], seeds: Sequence[Sequence[int]]) -> None:
    """Make the target size Gmsh's background field.

    Gmsh's own distance to a cloud of points is a search tree in compiled code, so that meshing
    never calls back into Python.
    """
    field = gmsh.model.mesh.field
    constant = field.add("MathEval")
    field.setString(constant, "F", f"{size:.17g}")
    parts = [constant]
    for refinement, tags in zip(refinements, seeds, strict=True):
        if refinement.size >= size:
            continue
        distance = field.add("Distance")
        field.setNumbers(distance, "PointsList", tags)
        near = field.add("Threshold")
        field.setNumber(near, "InField", distance)
        field.setNumber(near, "SizeMin", refinement.size)
        field.setNumber(near, "SizeMax", size)
        field.setNumber(near, "DistMin", 0.0)
        field.setNumber(near, "DistMax", (size - refinement.size) / refinement.growth)
        parts.append(near)
    least = field.add("Min")
    field.setNumbers(least, "FieldsList", parts)
    field.setAsBackgroundMesh(least)


def _collected(
    gmsh: Any,
    surface: int,
    outlines: Sequence[Outline],
    loops: Sequence[Sequence[tuple[int, int]]],
) -> PolyMesh:
    """Return Gmsh's triangles with points in the order of its tags, unused ones left out."""
    mesh = gmsh.model.mesh
    tags, coordinates, _ = mesh.getNodes()
    order = np.argsort(tags)
    tags, points = tags[order], coordinates.reshape(-1, 3)[order, :2]
    used, corners = np.unique(mesh.getElementsByType(2, surface)[1], return_inverse=True)
    if not len(used):
        raise InputError("a region in which Gmsh made no triangle", "a region", "reduce the size")
    points = points[np.searchsorted(tags, used)]
    pairs: dict[str, list[IntArray]] = {}
    for k, (outline, loop) in enumerate(zip(outlines, loops, strict=True)):
        for curve, number in loop:
            nodes = mesh.getElementsByType(1, curve)[1]
            edges = np.searchsorted(used, nodes).reshape(-1, 2).astype(np.int32)
            # a hole has the body on its right
            pairs.setdefault(outline.names[number], []).append(edges[::-1, ::-1] if k else edges)
    triangles = corners.reshape(-1, 3)
    return PolyMesh(
        points,
        np.arange(len(triangles) + 1, dtype=np.int32) * 3,
        counter_clockwise(points, triangles).astype(np.int32).ravel(),
        edge_sets={name: np.vstack(parts) for name, parts in pairs.items()},
    )


def counter_clockwise(points: Floats, triangles: Ints) -> Ints:
    """Return triangles (n, 3) that all turn counter-clockwise."""
    a, b, c = (points[triangles[:, i]] for i in range(3))
    clockwise = (b - a)[:, 0] * (c - a)[:, 1] < (b - a)[:, 1] * (c - a)[:, 0]
    turned = triangles.copy()
    turned[clockwise, 1:] = triangles[clockwise, :0:-1]
    return turned
