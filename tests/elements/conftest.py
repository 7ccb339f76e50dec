"""Polygons that are hard on a virtual element."""

import numpy as np
import pytest


def ring(n, inner=1.0):
    angles = 2.0 * np.pi * np.arange(n) / n
    radii = np.where(np.arange(n) % 2, inner, 1.0)
    return radii[:, None] * np.column_stack((np.cos(angles), np.sin(angles)))


UGLY = {
    "triangle": [(0, 0), (1, 0), (0.3, 0.8)],
    "pentagon": [(0, 0), (3, 0), (3, 2), (1.5, 4), (0, 4)],
    "thirty": ring(30),
    "star": ring(30, inner=0.4),
    "angle": [(0, 0), (2, 0), (2, 1), (1, 1), (1, 2), (0, 2)],
    "hanging": [(0, 0), (0.5, 0), (1, 0), (1, 0.3), (1, 1), (0.7, 1), (0.2, 1), (0, 1)],
    "tiny edge": [(0, 0), (1, 0), (1, 1), (0.5, 1), (0.5 - 1.4e-6, 1), (0, 1)],
    "cut corner": [(0, 0), (1, 0), (1, 1), (1e-6, 1), (0, 1 - 1e-6)],
    "comb": [(0, 0), (5, 0), (5, 1), (4, 1), (4, 0.2), (3, 0.2), (3, 1), (2, 1), (2, 0.2), (1, 0.2), (1, 1), (0, 1)],
}


@pytest.fixture(params=sorted(UGLY))
def ugly(request):
    """One polygon as (n_vertices, 2)."""
    return np.array(UGLY[request.param], dtype=np.float64)
