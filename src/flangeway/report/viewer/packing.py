"""Arrays of parts as text for a page: 32 bits a number, bytes of equal weight together, deflated, base64."""

import base64
import json
import zlib
from collections.abc import Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from flangeway.report.fields import PartFields

Floats = NDArray[np.float64]

LEVEL = 9


def packed_parts(parts: Sequence[PartFields]) -> tuple[dict[str, Any], str]:
    """Pack the parts.

    The arrays of all parts stand one after the other. Each is little-endian with 4 bytes a number, stored with all
    first bytes first, then all second ones and so on, which deflates better. All is deflated (zlib) and then base64.

    Parameters
    ----------
    parts
        The parts.

    Returns
    -------
    header
        What JSON can hold: for each part ``name``, ``side``, ``origin`` (mm, subtracted from the points), ``rigid``
        (3, 2): the rows that give a point's rigid motion since first touch as x, y (from the origin) and 1 times them;
        and ``arrays``: name, type (``f4`` or ``u4``) and count of each array, in the order of the bytes.
    text
        The base64 text. Arrays of a part: ``points`` (n_points, 2) and ``displacement`` (n_points, 2) in mm; ``sizes``
        of the cells; ``corners``: the point numbers of the cells as differences from the number before; ``stresses``
        (4, n_cells): xx, yy, xy, zz in MPa.

    """
    headers, chunks = [], []
    for part in parts:
        mesh = part.mesh
        origin: Floats = np.mean(mesh.points, axis=0)
        local: Floats = mesh.points - origin
        arrays: dict[str, NDArray[Any]] = {
            "points": local.astype("<f4"),
            "displacement": part.displacement.astype("<f4"),
            "sizes": mesh.cell_sizes.astype("<u4"),
            "corners": np.diff(mesh.cell_points.astype(np.int64), prepend=0).astype("<i4").view("<u4"),
            "stresses": part.stresses.components.T.astype("<f4"),
        }
        headers.append(
            {
                "name": part.name,
                "side": part.side,
                "origin": origin.tolist(),
                "rigid": rigid_motion(local, mesh.points - part.touch_points).tolist(),
                "arrays": [[name, array.dtype.str[1:], array.size] for name, array in arrays.items()],
            }
        )
        chunks += [_byte_planes(array) for array in arrays.values()]
    deflated = zlib.compress(b"".join(chunks), LEVEL)
    return {"parts": headers}, base64.b64encode(deflated).decode("ascii")


def rigid_motion(points: Floats, motion: Floats) -> Floats:
    """Rows (3, 2) that times x, y and 1 give the motion (n_points, 2) of points (n_points, 2) of a rigid body."""
    columns = np.column_stack([points, np.ones(len(points))])
    return np.asarray(np.linalg.lstsq(columns, motion, rcond=None)[0], dtype=np.float64)


def json_in_script(value: object) -> str:
    """JSON that may stand inside a script element: no character in it ends the element."""
    return json.dumps(value, separators=(",", ":"), allow_nan=False).replace("<", "\\u003c")


def _byte_planes(array: NDArray[Any]) -> bytes:
    return np.ascontiguousarray(array).view(np.uint8).reshape(-1, 4).T.tobytes()
