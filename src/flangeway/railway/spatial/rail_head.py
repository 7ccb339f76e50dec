"""A rail's section: narrowest place of the web, rigid motion of the head, top and gauge face."""

import numpy as np

from flangeway.geometry import Outline
from flangeway.mesh import PolyMesh
from flangeway.railway.profiles.bundled import RailProfile
from flangeway.types import Floats

WEB_SHARES = np.linspace(0.2, 0.75, 221)
"""Heights over that of the rail between which the web's narrowest place is sought."""

DEVIATION_MM = 0.02  # of chords from the outline, for widths and heights

GAUGE_DEPTH_MM = 14.0
"""Depth below the top of the gauge face whose displacement is reported, unless the track has its own (EN 13848-1)."""


def narrowest_web(outline: Outline) -> tuple[float, float, float]:
    """Height of a rail's narrowest place between foot and head, and x of the two faces there, in its own frame."""
    points = outline.sampled(max_deviation=DEVIATION_MM, spacing=5.0)
    (_, low), (_, high) = outline.bounds()
    heights = low + WEB_SHARES * (high - low)
    first, second = points, np.roll(points, -1, axis=0)
    rise = second[:, 1] - first[:, 1]
    crossed = (first[:, 1] <= heights[:, None]) != (second[:, 1] <= heights[:, None])
    with np.errstate(divide="ignore", invalid="ignore"):
        x = first[:, 0] + (heights[:, None] - first[:, 1]) / rise * (second[:, 0] - first[:, 0])
    left = np.where(crossed, x, np.inf).min(axis=1)
    right = np.where(crossed, x, -np.inf).max(axis=1)
    place = int(np.argmin(right - left))
    return float(heights[place]), float(left[place]), float(right[place])


def head_motion(mesh: PolyMesh, displacement: Floats, profile: RailProfile) -> tuple[Floats, Floats, float]:
    """Centre of the head, its translation and its counter-clockwise rotation, least squares by the cells' areas."""
    foot = float(profile.outline.bounds(profile.head_names)[0, 1])
    in_head = mesh.cell_centroids[:, 1] > foot
    starts = mesh.cell_offsets[:-1]
    means = np.add.reduceat(displacement[mesh.cell_points], starts, axis=0) / mesh.cell_sizes[:, None]
    points, moves, areas = mesh.cell_centroids[in_head], means[in_head], mesh.cell_areas[in_head]
    centre, shift = areas @ points / areas.sum(), areas @ moves / areas.sum()
    arms = points - centre
    turn = areas @ (arms[:, 0] * moves[:, 1] - arms[:, 1] * moves[:, 0]) / (areas @ np.sum(arms**2, axis=1))
    return centre, shift, float(turn)


def top_and_gauge(profile: RailProfile, matrix: Floats, depth_mm: float) -> tuple[Floats, Floats]:
    """Highest point of the inclined head and its gauge face at a depth below, in the frame of the profile."""
    points = profile.running_surface.sampled(max_deviation=DEVIATION_MM, spacing=1.0)
    heights = points @ matrix[1]
    top = int(np.argmax(heights))
    gauge = points[top:][np.argmin(np.abs(heights[top:] - heights[top] + depth_mm))]
    return points[top], gauge
