"""Whether two bodies overlap, whatever contact was looked for."""

from dataclasses import dataclass

import numpy as np

from flangeway.contact.boundary import ROUND_OFF, Boundary, deepest_intrusion
from flangeway.mesh import PolyMesh


@dataclass(frozen=True)
class Overlap:
    """Where two bodies overlap most.

    Parameters
    ----------
    depth
        Distance of a point of one body from the boundary of the other, in which it lies.
    place
        That point, x and y.

    """

    depth: float
    place: tuple[float, float]


def deepest_overlap(one: PolyMesh, other: PolyMesh) -> Overlap | None:
    """Return where the boundary of one body lies deepest in the other one; None if nowhere beyond what chords explain.

    Chords of arcs may overlap by h^2 / 8 R on either side; straight sides by round-off.
    """
    found = deepest_intrusion(*(_boundary(mesh) for mesh in (one, other)))
    size = min(float(np.ptp(mesh.points, axis=0).max()) for mesh in (one, other))
    if found is None or found.depth <= found.allowed + ROUND_OFF * size:
        return None
    return Overlap(found.depth, found.place)


def _boundary(mesh: PolyMesh) -> Boundary:
    edges = mesh.boundary_edges.astype(np.int64)
    points = mesh.points[edges]
    return Boundary.of(points, points, (edges[:, 0], edges[:, 1]))
