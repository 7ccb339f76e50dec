"""Boundary points moved onto the arcs of an outline."""

from collections.abc import Iterable
from typing import TypeAlias

import numpy as np

from flangeway.geometry.arrays import FloatArray
from flangeway.geometry.contour import Contour
from flangeway.geometry.region import Region, Section
from flangeway.geometry.segments import Arc
from flangeway.mesh.polymesh import PolyMesh

Curves: TypeAlias = Contour | Region | Section | Iterable[Contour]
"""What has arcs: an outline or open chain, a region, a section, or several outlines."""

NEAR = 1.0
"""Distance from an arc, over the shorter boundary edge at the point, up to which the point belongs on it.

As large as that, since the middle of a coarse chord is far from its arc; the nearest curve decides.
"""


def _loops(curves: Curves) -> list[Contour]:
    if isinstance(curves, Contour):
        return [curves]
    if isinstance(curves, Region):
        return list(curves.loops)
    if isinstance(curves, Section):
        return [loop for region in curves.regions for loop in region.loops]
    return list(curves)


def snapped_points(mesh: PolyMesh, curves: Curves) -> FloatArray:
    """Return the mesh's points (n_points, 2) with those of the boundary that are near an arc moved onto it.

    Points at the ends of arcs, and those nearer to a line, stay; so all curves of the boundary must be given. Near
    means within the length of the boundary edges there.
    """
    pairs = mesh.boundary_edges
    lengths = np.hypot(*(mesh.points[pairs[:, 1]] - mesh.points[pairs[:, 0]]).T)
    shortest = np.full(mesh.n_points, np.inf)
    for column in (0, 1):
        np.minimum.at(shortest, pairs[:, column], lengths)
    rim = np.unique(pairs)
    points = mesh.points.copy()
    nearest = NEAR * shortest[rim]
    for loop in _loops(curves):
        number, place, distance = loop.closest(mesh.points[rim])
        nearer = distance < nearest
        nearest[nearer] = distance[nearer]
        points[rim[nearer]] = mesh.points[rim[nearer]]
        for which in np.unique(number[nearer]).tolist():
            segment = loop.segments[which]
            inside = nearer & (number == which) & (place > 1e-9) & (place < 1.0 - 1e-9)
            if isinstance(segment, Arc) and inside.any():
                points[rim[inside]] = segment.point(place[inside])
    return points
