"""Arrays of parts as text for a page: 32 bits a number, bytes of equal weight together, deflated, base64."""

import base64
import json
import zlib
from collections.abc import Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from flangeway.report.viewer.scene_model import ShownPart
from flangeway.types import Floats, floats

LEVEL = 6
"""Of compression; 9 takes five times as long for a page that is two thousandths smaller."""

VALUE_TOLERANCE = 1e-9
"""Difference relative to the largest value of an array below which values count as the same."""


def packed_parts(parts: Sequence[ShownPart]) -> tuple[list[dict[str, Any]], str]:
    """Pack the parts.

    The arrays of all parts stand one after the other. Each is little-endian with 4 bytes a number, stored with all
    first bytes first, then all second ones and so on, which deflates better. All is deflated (zlib) and then base64.

    Parameters
    ----------
    parts
        The parts.

    Returns
    -------
    headers
        What JSON can hold, for each part: ``name``, ``side``, ``origin`` (subtracted from the points), ``rigid``
        (3, 2): the rows that give a point's approach as x, y (from the origin) and 1 times them; ``rim``, the number of
        places on rims of cells, if there are others; and ``arrays``: name, type (``f4`` or ``u4``) and count of each
        array in the order of the bytes, and of those with values where they are (``points``, ``places`` or ``cells``)
        and the numbers of their components, which follow each other, and of their steps, which do so too.
    text
        The base64 text. Other arrays of a part: ``points`` (n, 2) of the points, or of their places, and their
        ``heights``; ``sizes`` of the cells; and as differences from the number before, ``corners``: the points of the
        cells, ``places`` of the points, and ``cells``: the cell that each drawn cell is a piece of.

    """
    headers, chunks = [], []
    for part in parts:
        header, arrays = _packed(part)
        headers.append(header)
        chunks += [_byte_planes(array) for array in arrays]
    deflated = zlib.compress(b"".join(chunks), LEVEL)
    return headers, base64.b64encode(deflated).decode("ascii")


def _packed(part: ShownPart) -> tuple[dict[str, Any], list[NDArray[Any]]]:
    """Header and arrays of a part."""
    mesh, first = part.mesh, _first_at_places(part)
    origin: Floats = np.mean(mesh.points, axis=0)
    local: Floats = mesh.points - origin
    arrays: list[tuple[list[Any], NDArray[Any]]] = [
        (["points"], (local if first is None else local[first]).astype("<f4")),
        (["sizes"], mesh.cell_sizes.astype("<u4")),
        (["corners"], _differences(mesh.cell_points)),
    ]
    if part.heights is not None:
        arrays.append((["heights"], (part.heights if first is None else part.heights[first]).astype("<f4")))
    for name, numbers in (("places", part.places), ("cells", part.cells)):
        if numbers is not None:
            arrays.append(([name], _differences(numbers)))
    for name, values in part.point_arrays.items():
        where, fewer = _without_copies(part, _by_step(values), first)
        arrays.append(_steps_array(name, where, fewer))
    arrays += [_steps_array(name, "cells", _by_step(values)) for name, values in part.cell_arrays.items()]
    rigid = np.zeros((3, 2)) if part.approach is None else rigid_motion(local, part.approach)
    header: dict[str, Any] = {
        "name": part.name,
        "side": part.side,
        "origin": origin.tolist(),
        "rigid": rigid.tolist(),
        "arrays": [[name, array.dtype.str[1:], array.size, *more] for (name, *more), array in arrays],
    }
    if part.n_rim_places is not None:
        header["rim"] = part.n_rim_places
    return header, [array for _, array in arrays]


def _by_step(values: Floats) -> Floats:
    """Values (n_steps, n, n_components) of one step or more."""
    return values if values.ndim == 3 else values[None]


def _steps_array(name: str, where: str, values: Floats) -> tuple[list[Any], NDArray[Any]]:
    """Header's words and numbers of values (n_steps, n, n_components): component after component, step after step."""
    return [name, where, values.shape[2], len(values)], values.transpose(0, 2, 1).astype("<f4")


def _first_at_places(part: ShownPart) -> NDArray[np.intp] | None:
    """A point of each place, None where each point is a place of its own."""
    return None if part.places is None else np.unique(part.places, return_index=True)[1]


def _without_copies(part: ShownPart, values: Floats, first: NDArray[np.intp] | None) -> tuple[str, Floats]:
    """Where values (n_steps, n_points, n_components) are kept, and those: once a place or a cell if the same there."""
    if part.places is None or first is None:
        return "points", values
    starts = part.mesh.cell_points[part.mesh.cell_offsets[:-1]]
    cells = np.repeat(starts, part.mesh.cell_sizes)
    at_places, at_cells = True, True
    for step in values:
        tolerance = VALUE_TOLERANCE * float(np.abs(step).max(initial=0.0))
        at_places = at_places and np.abs(step - step[first][part.places]).max(initial=0.0) <= tolerance
        at_cells = at_cells and np.abs(step[part.mesh.cell_points] - step[cells]).max(initial=0.0) <= tolerance
    if at_places:
        return "places", values[:, first]
    return ("cells", values[:, starts]) if at_cells else ("points", values)


def rigid_motion(points: Floats, motion: Floats) -> Floats:
    """Rows (3, 2) that times x, y and 1 give the motion (n_points, 2) of points (n_points, 2) of a rigid body."""
    columns = np.column_stack([points, np.ones(len(points))])
    return floats(np.linalg.lstsq(columns, motion, rcond=None)[0])


def json_in_script(value: object) -> str:
    """JSON that may stand inside a script element: no character in it ends the element."""
    return json.dumps(value, separators=(",", ":"), allow_nan=False).replace("<", "\\u003c")


def _differences(numbers: NDArray[Any]) -> NDArray[Any]:
    return np.diff(numbers.astype(np.int64), prepend=0).astype("<i4").view("<u4")


def _byte_planes(array: NDArray[Any]) -> bytes:
    return np.ascontiguousarray(array).view(np.uint8).reshape(-1, 4).T.tobytes()
