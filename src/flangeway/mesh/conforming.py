"""Points that hang on cells made points of these cells."""

import numpy as np

from flangeway.mesh.mesh_checks import hanging_points
from flangeway.mesh.polymesh import PolyMesh
from flangeway.mesh.ragged import offsets_of, row_numbers


def conforming(mesh: PolyMesh) -> PolyMesh:
    """Return the mesh with every point that hangs on an edge of a cell added to that cell.

    So meshes of other programs with hanging nodes become polygons that fit together: a square with a hanging point is a
    pentagon. Points and cells keep their numbers. Edge sets keep the edges that are at the boundary still.
    """
    edges, points = hanging_points(mesh)
    if not len(points):
        return mesh
    pairs = mesh.boundary_edges
    counts = np.bincount(mesh.cell_edges, minlength=mesh.n_edges)
    entries = np.flatnonzero(counts[mesh.cell_edges] == 1)  # in the order of boundary_edges
    along = np.hypot(*(mesh.points[points] - mesh.points[pairs[edges, 0]]).T)
    order = np.lexsort((along, edges))
    edges, points = edges[order], points[order]
    cell_points = np.insert(mesh.cell_points, entries[edges] + 1, points)
    more = np.bincount(row_numbers(mesh.cell_offsets)[entries[edges]], minlength=mesh.n_cells)
    offsets = offsets_of(mesh.cell_sizes + more)
    whole = PolyMesh(mesh.points, offsets, cell_points, mesh.cell_sets)
    outer = set(map(tuple, whole.boundary_edges.tolist()))
    for name, given in mesh.edge_sets.items():
        kept = [pair for pair in given.tolist() if tuple(pair) in outer]
        whole = whole.with_edge_set(name, np.array(kept)) if kept else whole
    return whole
