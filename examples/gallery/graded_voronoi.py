"""Voronoi cells in an outline with a reentrant corner, graded by a function (PolyMesher, mVEM)."""

import numpy as np
from gallery_drawing import draw
from matplotlib.figure import Figure

from flangeway.geometry import polygon
from flangeway.mesh import check, voronoi


def main() -> Figure:
    """Cells near the corner are about a fifth as large as those far away."""
    outline = polygon([(-1, -1), (0, -1), (0, 0), (1, 0), (1, 1), (-1, 1)])
    mesh = voronoi(outline, 300, iterations=30, size=lambda p: 0.2 + np.hypot(*p.T))
    check(mesh, region_area=outline.area)
    near, far = (np.sqrt(mesh.cell_areas[mask].mean()) for mask in
                 (np.hypot(*mesh.cell_centroids.T) < 0.1, np.hypot(*mesh.cell_centroids.T) > 0.9))  # fmt: skip
    print(f"cells near the corner {near:.3f}, far away {far:.3f}")
    assert near < 0.35 * far
    return draw(mesh)
