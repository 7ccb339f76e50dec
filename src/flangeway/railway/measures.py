"""Gauge measures of running surfaces, as instruments print them."""

import numpy as np

from flangeway.geometry import Contour, FloatArray
from flangeway.railway.raw_profile import Kind

FACE_MM = 10.0
"""Distance from the tread, towards the flange's tip, at which the flange is measured (EN 15313)."""

TIP_MM = 2.0
"""Distance below the flange's tip of the upper point of the measure qR (EN 15313)."""

HEAD_MM = 14.0
"""Depth below the top at which a head's width is measured."""

_SPACING_MM = 0.02


def measures(surface: Contour, kind: Kind) -> dict[str, float]:
    """Return those measures of a running surface in mm that it reaches far enough for.

    Wheels: ``flange_height_mm`` (Sh), ``flange_thickness_mm`` (Sd) and ``flange_slope_mm`` (qR), from the tread at the
    tape line. Rails: ``head_width_mm`` at `HEAD_MM` below the highest place.

    Parameters
    ----------
    surface
        In this package's frame of a wheel or a rail.
    kind
        What it is.

    """
    points = surface.sampled(spacing=_SPACING_MM, max_deviation=1e-4)
    return _wheel(points) if kind == "wheel" else _rail(points)


def _wheel(points: FloatArray) -> dict[str, float]:
    tip = int(np.argmin(points[:, 1]))
    lowest = float(points[tip, 1])
    if tip in (0, len(points) - 1) or lowest > -FACE_MM - TIP_MM or points[:, 0].max() < 0.0:
        return {}
    found = {"flange_height_mm": -lowest}
    front = points[tip:] if points[-1, 0] > points[tip, 0] else points[tip::-1]
    back = points[: tip + 1] if points[-1, 0] > points[tip, 0] else points[tip:]
    face, top = _first_x(front, -FACE_MM), _first_x(front, lowest + TIP_MM)
    if face is not None and top is not None:
        found["flange_slope_mm"] = face - top
    # the back has to be seen, not the tip's rounding alone
    if face is not None and back[:, 1].max() > lowest + FACE_MM:
        found["flange_thickness_mm"] = face - float(back[:, 0].min())
    return found


def _rail(points: FloatArray) -> dict[str, float]:
    top = int(np.argmax(points[:, 1]))
    level = float(points[top, 1]) - HEAD_MM
    first, second = _first_x(points[top::-1], level), _first_x(points[top:], level)
    return {} if first is None or second is None else {"head_width_mm": abs(second - first)}


def _first_x(points: FloatArray, level: float) -> float | None:
    """Return x where points (n, 2) first pass a height, None if they do not."""
    above = points[:, 1] > level
    passed = np.flatnonzero(above[1:] != above[:-1])
    if not len(passed):
        return None
    (x0, y0), (x1, y1) = points[passed[0]], points[passed[0] + 1]
    return float(x0 + (level - y0) / (y1 - y0) * (x1 - x0))
