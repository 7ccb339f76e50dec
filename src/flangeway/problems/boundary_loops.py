"""The outer boundary and the holes of a mesh, found from its boundary edges."""

from dataclasses import dataclass

import numpy as np
import scipy.sparse as sp
from numpy.typing import NDArray

from flangeway.mesh import PolyMesh
from flangeway.types import Floats


@dataclass(frozen=True, eq=False)
class Boundary:
    """Directed boundary edges in connected groups; loops that touch at a point are one group.

    Edges around the parts of the section (m, 2), edges around each hole, and areas of the holes (n_holes,).
    """

    outer: NDArray[np.int32]
    holes: tuple[NDArray[np.int32], ...]
    hole_areas: Floats


def boundary_of(mesh: PolyMesh) -> Boundary:
    """Sort the boundary edges of a mesh into the outer boundary and holes, by their signed areas."""
    pairs = mesh.boundary_edges
    graph = sp.coo_array((np.ones(len(pairs)), (pairs[:, 0], pairs[:, 1])), shape=(mesh.n_points, mesh.n_points))
    labels = sp.csgraph.connected_components(graph, directed=False)[1][pairs[:, 0]]
    outer, holes, areas = [], [], []
    for label in np.unique(labels):
        group = pairs[labels == label]
        local = mesh.points - mesh.points[group[0, 0]]
        start, end = local[group[:, 0]], local[group[:, 1]]
        area = float(np.sum(start[:, 0] * end[:, 1] - start[:, 1] * end[:, 0])) / 2.0
        if area > 0.0:
            outer.append(group)
        else:
            holes.append(group)
            areas.append(-area)
    hole_areas = np.array(areas)
    hole_areas.setflags(write=False)
    return Boundary(np.concatenate(outer), tuple(holes), hole_areas)
