"""Places on the boundaries of bodies, as tables of a case file name them."""

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from flangeway.cases.bodies.bodies_tables import PlaceTable
from flangeway.cases.case import Box, closest
from flangeway.errors import InputError
from flangeway.mesh import PolyMesh
from flangeway.problems import Body
from flangeway.types import Floats

Ints = NDArray[np.int32]

ON_LINE = 1e-6
"""Distance over the size of the mesh up to which a point lies on a line or in a box."""


def keys_of_place(table: PlaceTable) -> list[str]:
    """Keys of a table that say where, but for a point."""
    return [name for name in ("edges", "at_x_mm", "at_y_mm", "box_mm") if getattr(table, name) is not None]


def edge_middles(points: Floats, pairs: Ints) -> Floats:
    """Middles of edges, pairs of points: nodes of elements of order 2; shape (n, 2)."""
    return 0.5 * (points[pairs[:, 0]] + points[pairs[:, 1]])


def point_at(mesh: PolyMesh, order: int, body: str, point: tuple[float, float], key: str) -> tuple[float, float]:
    """Exact place of a point of a mesh, of order 2 also of the middle of an edge; an InputError names the nearest."""
    spots = mesh.points if order == 1 else np.vstack((mesh.points, edge_middles(mesh.points, mesh.edges)))
    apart = np.hypot(*(spots - point).T)
    nearest = spots[apart.argmin()]
    if apart.min() > ON_LINE * float(np.hypot(*np.ptp(mesh.points, axis=0))):
        raise InputError(
            f"{key}.point_mm = [{point[0]:g}, {point[1]:g}]",
            f"a point of the mesh of {body!r}; the nearest is [{nearest[0]:.9g}, {nearest[1]:.9g}]",
            "give the place of a corner of the outline or of a point of the mesh",
        )
    return float(nearest[0]), float(nearest[1])


def edges_at(
    mesh: PolyMesh,
    body: str,
    names: str | Sequence[str] | None,
    box: Box | None,
    lines: tuple[float | None, float | None],
    key: str,
    which: str,
) -> Ints:
    """Boundary edges that a place allows, pairs of points (n, 2).

    Parameters
    ----------
    mesh
        Mesh of the body.
    body
        Its name, for messages.
    names
        Edge sets, or None for the whole boundary.
    box
        Corners x_min, y_min, x_max, y_max of a box that holds them.
    lines
        The x and the y of lines that they are on.
    key, which
        Table and key, for messages.

    """
    pairs = mesh.boundary_edges
    if names is not None:
        chosen = [names] if isinstance(names, str) else list(names)
        known = sorted(name for name in mesh.edge_sets if "[" not in name)
        if not chosen:
            raise InputError(
                f"{key}.{which} = []", f"edge sets of {body!r}: {', '.join(known) or 'none'}", f"leave {which} out"
            )
        for name in chosen:
            if name not in known:
                raise InputError(
                    f"{key}.{which} = {name!r}",
                    f"edge sets of {body!r}: {', '.join(known) or 'none'}",
                    closest(name, known) if known else "take at_x_mm, at_y_mm or box_mm instead",
                )
        pairs = np.vstack([mesh.edge_sets[name] for name in chosen])
    slack = ON_LINE * float(np.hypot(*np.ptp(mesh.points, axis=0)))
    ends = mesh.points[pairs]
    inside = np.ones(len(pairs), dtype=np.bool_)
    for axis, value in enumerate(lines):
        if value is not None:
            inside &= (np.abs(ends[:, :, axis] - value) <= slack).all(axis=1)
    if box is not None:
        low, high = np.array(box[:2]) - slack, np.array(box[2:]) + slack
        inside &= ((ends >= low) & (ends <= high)).all(axis=(1, 2))
    if not inside.any():
        (x0, y0), (x1, y1) = mesh.points.min(axis=0), mesh.points.max(axis=0)
        raise InputError(
            f"{key}: no boundary edge of {body!r} is at this place",
            f"places on its boundary; it reaches from ({x0:g}, {y0:g}) to ({x1:g}, {y1:g})",
            "correct the numbers; a box must hold whole edges",
        )
    return pairs[inside]


def free_edges(body: Body, pairs: Ints) -> Ints:
    """Edges without a point that is held in both components, where no contact force could act."""
    nodes = body.space.edge_nodes(pairs)
    loose: NDArray[np.bool_] = np.asarray(body.free.reshape(-1, 2).any(axis=1))
    return pairs[loose[nodes].all(axis=1)]
