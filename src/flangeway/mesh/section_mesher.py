"""Triangulation of a section: one region with holes, or several that share edges."""

import functools
import math
from collections.abc import Sequence
from typing import Any, Literal

import numpy as np
from numpy.typing import NDArray
from scipy.spatial import cKDTree

from flangeway.checks import check_positive
from flangeway.errors import InputError
from flangeway.geometry import Arc, IntArray, Outline, Placement, Region, Section
from flangeway.geometry.segments import halved
from flangeway.mesh.dual import dual
from flangeway.mesh.gmsh_mesher import (
    ALGORITHMS,
    OPTIONS,
    counter_clockwise,
    refuse_algorithm,
    set_size_field,
    triangulate,
)
from flangeway.mesh.gmsh_session import generate, gmsh_model
from flangeway.mesh.polymesh import PolyMesh
from flangeway.mesh.sizing import Refinement, made, mesh_bound

_FAR = 100.0  # of the section's size


def triangulate_section(
    section: Section,
    *,
    size: float,
    refinements: Sequence[Refinement] = (),
    algorithm: Literal["delaunay", "frontal-delaunay"] = "delaunay",
) -> PolyMesh:
    """Return a mesh of triangles of all parts, conforming where they touch.

    Parameters
    ----------
    section
        The parts. Edges that two parts share must be at the same place; their ends need not be.
    size
        Length of a triangle's edge away from refinements.
    refinements
        Where triangles are smaller; see `triangulate`.
    algorithm
        As for `triangulate`.

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
    if np.abs(middle).max() > _FAR * section.size:
        # Gmsh compares points with a tolerance of their distance from the origin
        away = Placement(translation=(float(middle[0]), float(middle[1])))
        nearer = [Refinement(r.points - middle, r.size, r.growth) for r in refinements]
        mesh = triangulate_section(
            section.transformed(away.inverse()), size=size, refinements=nearer, algorithm=algorithm
        )
        return mesh.placed(away)
    if len(section.parts) == 1:
        ((name, region),) = section.parts.items()
        mesh = triangulate(region.outer, size=size, refinements=refinements, holes=region.holes, algorithm=algorithm)
        return mesh.with_cell_set(name, np.arange(mesh.n_cells))
    refuse_algorithm(algorithm)
    bound = mesh_bound(section.regions, size, refinements, algorithm)
    return made(bound, _meshed, dict(section.parts), size, tuple(refinements), algorithm)


def _meshed(parts: dict[str, Region], size: float, refinements: Sequence[Refinement], algorithm: str) -> PolyMesh:
    section = Section(parts)
    with gmsh_model("flangeway", OPTIONS | {"Mesh.Algorithm": ALGORITHMS[algorithm]}) as gmsh:
        surfaces = _fragments(gmsh, section)
        seeds = [[gmsh.model.occ.addPoint(*p, 0.0) for p in r.seeds().tolist()] for r in refinements]
        gmsh.model.occ.synchronize()
        set_size_field(gmsh, size, refinements, seeds)
        generate(gmsh)
        return _collected(gmsh, section, surfaces)


def _fragments(gmsh: Any, section: Section) -> dict[str, list[int]]:
    """Give the parts to Gmsh, cut where they touch; return the surfaces of each."""
    occ = gmsh.model.occ
    first = [(2, occ.addPlaneSurface([_add_loop(occ, loop) for loop in region.loops])) for region in section.regions]
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


def _add_loop(occ: Any, outline: Outline) -> int:
    pieces = [piece for piece, _ in halved(outline.segments, 0.9 * math.pi)]
    corners = [occ.addPoint(*piece.start, 0.0) for piece in pieces]
    curves = []
    for i, piece in enumerate(pieces):
        ends = corners[i], corners[(i + 1) % len(corners)]
        if isinstance(piece, Arc):
            # through its middle: no radius to disagree by rounding
            middle = occ.addPoint(*piece.point(0.5)[0].tolist(), 0.0)
            curves.append(occ.addCircleArc(ends[0], middle, ends[1], center=False))
        else:
            curves.append(occ.addLine(*ends))
    return int(occ.addCurveLoop(curves))


def _collected(gmsh: Any, section: Section, surfaces: dict[str, list[int]]) -> PolyMesh:
    """Return Gmsh's triangles, those of each part as a cell set."""
    mesh = gmsh.model.mesh
    tags, coordinates, _ = mesh.getNodes()
    order = np.argsort(tags)
    tags, points = tags[order], coordinates.reshape(-1, 3)[order, :2]
    corners: list[NDArray[Any]] = []
    cell_sets: dict[str, NDArray[Any]] = {}
    n_cells = 0
    for name, mine in surfaces.items():
        parts = [mesh.getElementsByType(2, tag)[1].reshape(-1, 3) for tag in mine]
        if not sum(len(part) for part in parts):
            raise InputError(f"part {name}, in which Gmsh made no triangle", "a part", "reduce the size")
        corners += parts
        found = sum(len(part) for part in parts)
        cell_sets[name] = np.arange(n_cells, n_cells + found)
        n_cells += found
    used, numbers = np.unique(np.vstack(corners), return_inverse=True)
    points = points[np.searchsorted(tags, used)]
    triangles = counter_clockwise(points, numbers.reshape(-1, 3))
    plain = PolyMesh(points, np.arange(n_cells + 1, dtype=np.int32) * 3, triangles.astype(np.int32).ravel(), cell_sets)
    return _with_names(plain, section)


def _with_names(mesh: PolyMesh, section: Section) -> PolyMesh:
    """Name each boundary edge after the segment that it is closest to."""
    pairs: IntArray = mesh.boundary_edges
    middles = mesh.points[pairs].mean(axis=1)
    names = np.full(len(pairs), "", dtype=object)
    best = np.full(len(pairs), np.inf)
    for region in section.regions:
        for loop in region.loops:
            number, _, distance = loop.closest(middles)
            nearer = distance < best
            best[nearer] = distance[nearer]
            names[nearer] = np.array(loop.names, dtype=object)[number[nearer]]
    for name in sorted(set(names.tolist())):
        mesh = mesh.with_edge_set(name, pairs[names == name])
    return mesh


def dual_section(mesh: PolyMesh) -> PolyMesh:
    """Return the dual polygons of every cell set apart, glued where the sets touch.

    So that each polygon lies in one part; see `dual`. The cell sets must cover the mesh once. Returned: with the same
    cell sets and edge sets.

    - `mesh`: triangles, as from `triangulate_section`.
    """
    if len(mesh.cell_sets) == 1:
        return dual(mesh)
    parts = [dual(_extracted(mesh, name, cells)) for name, cells in mesh.cell_sets.items()]
    glued = _glued(functools.reduce(PolyMesh.merged, parts), 1e-9 * float(np.ptp(mesh.points, axis=0).max()))
    middles = glued.points[glued.boundary_edges].mean(axis=1)
    for name, pairs in mesh.edge_sets.items():
        start, end = mesh.points[pairs].swapaxes(0, 1)
        halves = np.vstack([0.75 * start + 0.25 * end, 0.25 * start + 0.75 * end])
        glued = glued.with_edge_set(name, glued.boundary_edges[cKDTree(middles).query(halves)[1]])
    return glued


def _extracted(mesh: PolyMesh, name: str, cells: IntArray) -> PolyMesh:
    """Return the triangles of one cell set as a separate mesh."""
    used, corners = np.unique(mesh.cell_points.reshape(-1, 3)[cells], return_inverse=True)
    offsets = np.arange(len(cells) + 1, dtype=np.int32) * 3
    return PolyMesh(
        mesh.points[used], offsets, corners.astype(np.int32).ravel(), {name: np.arange(len(cells), dtype=np.int32)}
    )


def _glued(mesh: PolyMesh, tolerance: float) -> PolyMesh:
    """Return the mesh with points nearer than a tolerance made one."""
    pairs = cKDTree(mesh.points).query_pairs(tolerance, output_type="ndarray")
    first = np.arange(mesh.n_points)
    # each group of coinciding points has one of every part, so that its lowest is paired with all others
    for low, high in sorted(pairs.tolist(), reverse=True):
        first[high] = low
    kept, numbers = np.unique(first, return_inverse=True)
    return PolyMesh(mesh.points[kept], mesh.cell_offsets, numbers[mesh.cell_points].astype(np.int32), mesh.cell_sets)
