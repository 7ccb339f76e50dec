"""Quadrature on simple polygons, convex or not, with all points inside and all weights positive."""

import numpy as np

from flangeway.elements.quadrature import triangle
from flangeway.types import Floats


def polygon_quadrature(vertices: Floats, degree: int) -> tuple[Floats, Floats]:
    """Points and weights on polygons with the same number of vertices.

    A polygon that sees all of its boundary from the mean of its vertices is divided into triangles about
    that point, any other one by cutting off ears (Meisters, 1975, "Polygons have ears").

    Parameters
    ----------
    vertices
        Counter-clockwise vertices, shape (n_vertices, 2, n_cells).
    degree
        Polynomials of this degree are integrated exactly.

    Returns
    -------
    tuple of Floats
        Points (n_points, 2, n_cells) and weights (n_points, n_cells).

    """
    if len(vertices) == 3:
        corners = vertices[None]
    else:
        middle = vertices.mean(axis=0)
        following = np.roll(vertices, -1, axis=0)
        corners = np.stack((np.broadcast_to(middle, vertices.shape), vertices, following), axis=1)
        for cell in np.flatnonzero((_doubled_areas(corners) <= 0.0).any(axis=0)):
            corners[:, :, :, cell] = _ears(vertices[:, :, cell])
    points, weights = triangle(degree)
    barycentric = np.column_stack((1.0 - points.sum(axis=1), points))
    at = np.einsum("qc,tcie->tqie", barycentric, corners)
    weighted = weights[:, None] * _doubled_areas(corners)[:, None]
    n_cells = vertices.shape[-1]
    return at.reshape(-1, 2, n_cells), weighted.reshape(-1, n_cells)


def _doubled_areas(corners: Floats) -> Floats:
    """Twice the signed areas of triangles (..., 3, 2, n_cells), shape (..., n_cells)."""
    first = corners[..., 1, :, :] - corners[..., 0, :, :]
    second = corners[..., 2, :, :] - corners[..., 0, :, :]
    return first[..., 0, :] * second[..., 1, :] - first[..., 1, :] * second[..., 0, :]


def _turn(a: Floats, b: Floats, c: Floats) -> Floats:
    """Twice the signed area of triangles; c may have many rows."""
    area: Floats = (b[0] - a[0]) * (c[..., 1] - a[1]) - (b[1] - a[1]) * (c[..., 0] - a[0])
    return area


def _ears(polygon: Floats) -> Floats:
    """Cut a simple polygon (n, 2) into triangles; two without area fill up to n: (n, 3, 2)."""
    left = list(range(len(polygon)))
    triangles = []
    while len(left) > 3:
        place = _best_ear(polygon, left)
        triangles.append([left[place - 1], left[place], left[(place + 1) % len(left)]])
        del left[place]
    triangles.append(left)
    empty = [[0, 0, 0]] * (len(polygon) - len(triangles))
    return polygon[np.array(triangles + empty)]


def _best_ear(polygon: Floats, left: list[int]) -> int:
    """Place of the vertex whose triangle holds no other vertex; a straight one is taken at once."""
    rest = polygon[left]
    size = float(np.ptp(rest, axis=0).max()) ** 2
    best, best_area = 0, -np.inf
    for place in range(len(left)):
        a, b, c = rest[place - 1], rest[place], rest[(place + 1) % len(left)]
        area = float(_turn(a, b, c))
        if abs(area) <= 1e-15 * size and (a - b) @ (c - b) < 0.0:
            return place
        others = np.delete(rest, [(place - 1) % len(left), place, (place + 1) % len(left)], axis=0)
        inside = (_turn(a, b, others) >= 0) & (_turn(b, c, others) >= 0) & (_turn(c, a, others) >= 0)
        if area > best_area and not inside.any():
            best, best_area = place, area
    return best
