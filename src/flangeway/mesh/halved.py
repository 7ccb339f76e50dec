"""Edges cut in two, which turns the cells beside them into polygons of one side more."""

import numpy as np

from flangeway.mesh.polymesh import PolyMesh


def edges_halved(mesh: PolyMesh, edge_set: str) -> PolyMesh:
    """Return the mesh with a point in the middle of each edge of a set, which the cell beside it gets as a corner.

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
