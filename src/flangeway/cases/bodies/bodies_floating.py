"""Bodies that their supports let slide, so that contact must bear their loads."""

from collections.abc import Mapping
from typing import Literal

import numpy as np
from numpy.typing import NDArray

from flangeway.errors import InputError
from flangeway.mesh import PolyMesh

Where = str | tuple[float, float]

FREE = 1e-9
"""Singular value of the supports on rigid motions, over the greatest, below which a motion is free."""


def free_axis(name: str, mesh: PolyMesh, held: Mapping[Where, str]) -> Literal["x", "y"] | None:
    """Axis along which a body can slide without strain; None where its supports hold it.

    Parameters
    ----------
    name
        Name of the body, for messages.
    mesh
        Its mesh.
    held
        Components held along edge sets and at points.

    Raises
    ------
    InputError
        If the supports let it move in another way.

    """
    centre = mesh.points.mean(axis=0)
    size = float(np.hypot(*np.ptp(mesh.points, axis=0)))
    rows = [np.zeros((3, 3))]
    for where, components in held.items():
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
    ways = "in several ways" if len(free) > 1 else "with a rotation" if abs(free[0, 2]) > FREE else "along a slope"
    raise InputError(
        f"body {name!r} in contact, which its supports let move {ways}",
        "supports that hold it, or let it slide along x or y alone, contact left out",
        "add [[supports]]; to press it by a force, hold its far side and add [[motions]] with push_N",
    )


def resting_point(name: str, mesh: PolyMesh, touching: NDArray[np.integer]) -> tuple[float, float]:
    """Point at which a sliding body is held while the balance is sought: the farthest from where it may touch.

    In balance the hold bears nothing, so its place does not matter.
    """
    others = np.setdiff1d(np.arange(mesh.n_points), touching)
    if len(others) == 0:
        raise InputError(
            f"body {name!r}, which can slide and has all points on contact surfaces",
            "a point apart from them",
            "take a finer mesh, or shorten the surfaces",
        )
    steps = mesh.points[others, None] - mesh.points[np.unique(touching)]
    apart = np.min(np.sum(steps**2, axis=-1), axis=1)
    x, y = mesh.points[others[apart.argmax()]].tolist()
    return float(x), float(y)
