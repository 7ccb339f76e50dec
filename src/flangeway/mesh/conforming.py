"""Points added to the sides of cells, which become polygons of more sides."""

import numpy as np

from flangeway.mesh.connectivity import offsets_of, row_numbers
from flangeway.mesh.mesh_checks import hanging_points
from flangeway.mesh.polymesh import PolyMesh


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


def edges_halved(mesh: PolyMesh, edge_set: str) -> PolyMesh:
    """Return the mesh with a point in the middle of each edge of a set, which becomes a corner of the cell there.

    Cell sets ``"quadrilaterals"`` and ``"triangles"`` name the cells that have got one and the others.
    """
    pairs = mesh.edge_sets[edge_set].astype(np.int64)
    middles = mesh.n_points + np.arange(len(pairs))
    starts = mesh.cell_points.astype(np.int64)
    last = mesh.cell_offsets[1:] - 1
    following = np.roll(starts, -1)
    following[last] = starts[mesh.cell_offsets[:-1]]
    keys, wanted = starts * mesh.n_points + following, pairs[:, 0] * mesh.n_points + pairs[:, 1]
    order = np.argsort(keys)
    places = order[np.searchsorted(keys, wanted, sorter=order)]
    owners = np.searchsorted(mesh.cell_offsets, places, side="right") - 1
    sizes = mesh.cell_sizes + np.bincount(owners, minlength=mesh.n_cells)
    edge_sets = dict(mesh.edge_sets)
    edge_sets[edge_set] = np.column_stack((pairs[:, 0], middles, middles, pairs[:, 1])).reshape(-1, 2).astype(np.int32)
    return PolyMesh(
        np.vstack((mesh.points, mesh.points[pairs].mean(axis=1))),
        np.concatenate(([0], np.cumsum(sizes))).astype(np.int32),
        np.insert(starts, places + 1, middles).astype(np.int32),
        {
            **mesh.cell_sets,
            "quadrilaterals": np.unique(owners).astype(np.int32),
            "triangles": np.setdiff1d(np.arange(mesh.n_cells), owners).astype(np.int32),
        },
        edge_sets,
    )
