"""The pentagon of Beirao da Veiga et al. (2014), "The Hitchhiker's guide to the virtual element method"."""

from fractions import Fraction as Q
from math import comb

import numpy as np
import pytest

from flangeway.elements import cell_matrices

PENTAGON = [(Q(0), Q(0)), (Q(3), Q(0)), (Q(3), Q(2)), (Q(3, 2), Q(4)), (Q(0), Q(4))]
DIAMETER = Q(5)
POWERS = [(0, 0), (1, 0), (0, 1), (2, 0), (1, 1), (0, 2)]


def integral(corners, a, b):
    """Integral of x^a y^b over triangles with the origin, by the formula for powers of barycentric coordinates."""
    total = Q(0)
    for (x0, y0), (x1, y1) in zip(corners, corners[1:] + corners[:1], strict=True):
        cross = x0 * y1 - x1 * y0
        for i in range(a + 1):
            for j in range(b + 1):
                p, q = i + j, a + b - i - j
                beta = Q(1, (p + q + 2) * (p + q + 1) * comb(p + q, p))
                total += cross * comb(a, i) * comb(b, j) * x0**i * x1 ** (a - i) * y0**j * y1 ** (b - j) * beta
    return total


def solved(matrix, rhs):
    """Gauss-Jordan elimination in fractions."""
    rows = [list(a) + list(b) for a, b in zip(matrix, rhs, strict=True)]
    n = len(rows)
    for i in range(n):
        pivot = next(r for r in range(i, n) if rows[r][i])
        rows[i], rows[pivot] = rows[pivot], rows[i]
        rows[i] = [v / rows[i][i] for v in rows[i]]
        for r in range(n):
            if r != i:
                rows[r] = [v - rows[r][i] * w for v, w in zip(rows[r], rows[i], strict=True)]
    return [row[n:] for row in rows]


def times(a, b):
    return [
        [sum((x * y for x, y in zip(row, column, strict=True)), Q(0)) for column in zip(*b, strict=True)] for row in a
    ]


class Exact:
    """All matrices of the pentagon for order 1 or 2, whose Gauss-Lobatto points are rational."""

    def __init__(self, order):
        self.order = order
        self.n_monomials = (order + 1) * (order + 2) // 2
        area = integral(PENTAGON, 0, 0)
        xc, yc = integral(PENTAGON, 1, 0) / area, integral(PENTAGON, 0, 1) / area
        self.area, self.centroid = area, (xc, yc)
        scaled = [((x - xc) / DIAMETER, (y - yc) / DIAMETER) for x, y in PENTAGON]
        after = scaled[1:] + scaled[:1]
        powers = POWERS[: self.n_monomials]
        moment = {(a, b): DIAMETER**2 * integral(scaled, a, b) for a in range(5) for b in range(5 - a)}
        middles = [((p[0] + q[0]) / 2, (p[1] + q[1]) / 2) for p, q in zip(scaled, after, strict=True)]
        nodes = scaled + (middles if order == 2 else [])
        self.D = [[x**a * y**b for a, b in powers] for x, y in nodes]
        if order == 2:
            self.D.append([moment[p] / area for p in powers])
        # edge weights times normals, in units of the diameter
        normals = [(q[1] - p[1], p[0] - q[0]) for p, q in zip(scaled, after, strict=True)]
        at_vertex = Q(1, 2) if order == 1 else Q(1, 6)
        weighted = [tuple(at_vertex * (normals[i][j] + normals[i - 1][j]) for j in range(2)) for i in range(5)]
        if order == 2:
            weighted += [tuple(Q(2, 3) * c for c in normal) for normal in normals]
        n = len(self.D)
        self.B = [[Q(1, 5)] * 5 if order == 1 else [Q(0)] * (n - 1) + [Q(1)]]
        for a, b in powers[1:]:
            row = []
            for (x, y), (nx, ny) in zip(nodes, weighted, strict=True):
                dx = a * x ** (a - 1) * y**b if a else Q(0)
                dy = b * x**a * y ** (b - 1) if b else Q(0)
                row.append(dx * nx + dy * ny)
            if order == 2:
                laplacian = Q(2) if (a, b) in ((2, 0), (0, 2)) else Q(0)
                row.append(-laplacian * area / DIAMETER**2)
            self.B.append(row)
        self.G = times(self.B, self.D)
        self.pi_nabla_star = solved(self.G, self.B)
        self.pi_nabla = times(self.D, self.pi_nabla_star)
        self.H = [[moment[a + c, b + d] for c, d in powers] for a, b in powers]
        self.C = times(self.H, self.pi_nabla_star)
        self.pi_zero = times(self.D, solved(self.H, self.C))


@pytest.mark.parametrize("order", [1, 2])
@pytest.mark.parametrize("name", ["D", "B", "G", "H", "C", "pi_nabla_star", "pi_nabla", "pi_zero"])
def test_matrices_of_the_pentagon_are_the_exact_fractions(order, name):
    """Every matrix of the pentagon equals its exact fractions to rounding, for orders 1 and 2."""
    exact = np.array([[float(v) for v in row] for row in getattr(Exact(order), name)])
    computed = getattr(cell_matrices(np.array(PENTAGON, dtype=float), order), name)
    assert computed == pytest.approx(exact, abs=2e-14)


def test_gram_matrix_of_order_1_is_the_published_one():
    """G of order 1 is 1/1050 [[1050, 30, 40], [0, 441, 0], [0, 0, 441]]."""
    published = np.array([[1050, 30, 40], [0, 441, 0], [0, 0, 441]]) / 1050
    assert pytest.approx(published, abs=1e-15) == cell_matrices(np.array(PENTAGON, dtype=float), 1).G


def test_geometry_of_the_pentagon_is_exact():
    """Area 21/2, centroid (19/14, 38/21), diameter 5."""
    cell = cell_matrices(np.array(PENTAGON, dtype=float), 1)
    assert (cell.area, cell.diameter) == pytest.approx((10.5, 5.0), abs=1e-14)
    assert cell.centroid == pytest.approx([19 / 14, 38 / 21], abs=1e-14)


@pytest.mark.parametrize("order", [1, 2, 3, 4])
def test_gram_matrix_is_the_product_and_projectors_are_idempotent(order):
    """G = B D, and both projectors leave their own images alone."""
    cell = cell_matrices(np.array(PENTAGON, dtype=float), order)
    assert pytest.approx(cell.B @ cell.D, abs=1e-13) == cell.G
    for projector in (cell.pi_nabla, cell.pi_zero):
        assert projector @ projector == pytest.approx(projector, abs=1e-9)
