"""Positions on the boundaries of bodies, as tables of a case file name them, and what supports leave free."""

from collections.abc import Mapping, Sequence
from typing import Literal

import numpy as np
from numpy.typing import NDArray

from flangeway.cases.bodies.bodies_tables import PlaceTable
from flangeway.cases.case import Box, closest
from flangeway.errors import InputError
from flangeway.mesh import PolyMesh
from flangeway.problems import Body
from flangeway.types import Floats

Ints = NDArray[np.int32]

Where = str | tuple[float, float]

FREE = 1e-9
"""Singular value of the supports on rigid motions over the maximum, below which a motion is free."""
ON_LINE = 1e-6
"""Distance over the size of the mesh up to which a point lies on a line or in a box."""


def keys_of_place(table: PlaceTable) -> list[str]:
    """Keys of a table that say where, but for a point."""
    return [name for name in ("edges", "at_x_mm", "at_y_mm", "box_mm") if getattr(table, name) is not None]


def edge_middles(points: Floats, pairs: Ints) -> Floats:
    """Middles of edges, pairs of points: nodes of elements of order 2; shape (n, 2)."""
    return 0.5 * (points[pairs[:, 0]] + points[pairs[:, 1]])


def point_at(mesh: PolyMesh, order: int, body: str, point: tuple[float, float], key: str) -> tuple[float, float]:
    """Exact position of a point of a mesh, for order 2 also of the middle of an edge; an error names the nearest."""
    spots = mesh.points if order == 1 else np.vstack((mesh.points, edge_middles(mesh.points, mesh.edges)))
    apart = np.hypot(*(spots - point).T)
    nearest = spots[apart.argmin()]
    if apart.min() > ON_LINE * float(np.hypot(*np.ptp(mesh.points, axis=0))):
        raise InputError(
            f"{key}.point_mm = [{point[0]:g}, {point[1]:g}]",
            f"a point of the mesh of {body!r}; the nearest is [{nearest[0]:.9g}, {nearest[1]:.9g}]",
            "give a corner of the outline or a point of the mesh",
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
    """Boundary edges at a position, pairs of points (n, 2).

    Parameters
    ----------
    mesh
        Mesh of the body.
    body
        Its name, for messages.
    names
        Edge sets, or None for the whole boundary.
    box
        Corners x_min, y_min, x_max, y_max of a box that contains them.
    lines
        The x and the y of lines on which they lie.
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
            f"{key}: no boundary edge of {body!r} is there",
            f"positions on its boundary, which reaches from ({x0:g}, {y0:g}) to ({x1:g}, {y1:g})",
            "correct the numbers; a box must contain whole edges",
        )
    return pairs[inside]


def free_edges(body: Body, pairs: Ints) -> Ints:
    """Edges without a point that is fixed in both components, where no contact force could act."""
    nodes = body.space.edge_nodes(pairs)
    loose: NDArray[np.bool_] = np.asarray(body.free.reshape(-1, 2).any(axis=1))
    return pairs[loose[nodes].all(axis=1)]


def free_axis(name: str, mesh: PolyMesh, fixed: Mapping[Where, str]) -> Literal["x", "y"] | None:
    """Axis along which a body can slide without strain; None where its supports fix it.

    Parameters
    ----------
    name
        Name of the body, for messages.
    mesh
        Its mesh.
    fixed
        Fixed components along edge sets and at points.

    Raises
    ------
    InputError
        If the supports allow another rigid motion.

    """
    centre = mesh.points.mean(axis=0)
    size = float(np.hypot(*np.ptp(mesh.points, axis=0)))
    rows = [np.zeros((3, 3))]
    for where, components in fixed.items():
        points = mesh.points[np.unique(mesh.edge_set(where))] if isinstance(where, str) else np.array([where])
        arms = (points - centre) / size
        zeros, ones = np.zeros(len(arms)), np.ones(len(arms))
        if "x" in components:
            rows.append(np.column_stack((ones, zeros, -arms[:, 1])))
        if "y" in components:
            rows.append(np.column_stack((zeros, ones, arms[:, 0])))
    _, values, vectors = np.linalg.svd(np.vstack(rows), full_matrices=False)
    free = vectors[values <= FREE * max(float(values.max()), 1.0)]
    if len(free) == 0:
        return None
    if len(free) == 1 and abs(free[0, 2]) <= FREE:
        for axis, other in ((0, 1), (1, 0)):
            if abs(free[0, other]) <= FREE:
                return "x" if axis == 0 else "y"
    ways = "in several directions" if len(free) > 1 else "with a rotation" if abs(free[0, 2]) > FREE else "at an angle"
    raise InputError(
        f"body {name!r} in contact, whose supports allow a rigid motion {ways}",
        "without contact: supports that fix it, or leave x or y alone free",
        "add [[supports]]; to press it by a force, fix its far side and add [[motions]] with push_N",
    )


def fixed_point(name: str, mesh: PolyMesh, touching: NDArray[np.integer]) -> tuple[float, float]:
    """Point at which a sliding body is fixed during the search: at maximum distance from its contact surfaces.

    In equilibrium its reaction is zero, so the choice of the point does not matter.
    """
    others = np.setdiff1d(np.arange(mesh.n_points), touching)
    if len(others) == 0:
        raise InputError(
            f"body {name!r}, which can slide and whose points are all on contact surfaces",
            "a point apart from them",
            "take a finer mesh, or shorten the surfaces",
        )
    steps = mesh.points[others, None] - mesh.points[np.unique(touching)]
    apart = np.min(np.sum(steps**2, axis=-1), axis=1)
    x, y = mesh.points[others[apart.argmax()]].tolist()
    return float(x), float(y)
