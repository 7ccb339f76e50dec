"""Compliance of a surface as that of a half-space and a smooth remainder."""

import numpy as np
import pytest

from flangeway.contact.patch.elastic_surface import elastic_surface
from flangeway.elements import Lagrange
from flangeway.exact import half_space_influence
from flangeway.geometry import circle
from flangeway.materials import Elastic
from flangeway.mesh import triangulate
from flangeway.problems import Elasticity, Harmonic
from flangeway.solve import SurfaceCells, compliance_table
from flangeway.solve.half_spaces import half_spaces_on
from flangeway.space import Space

STEEL = Elastic(210e3, 0.3)


@pytest.fixture(scope="module")
def bar():
    """A steel bar of the radius 20 mm, held at its lower half; and the edges of its upper half."""
    mesh = triangulate(circle(20.0), size=1.5)
    chain = mesh.chain(*sorted(mesh.edge_sets))[:-1]
    points = mesh.points[chain]
    start = int(np.flatnonzero((points[:, 1] > 0.0) & (np.roll(points[:, 1], 1) <= 0.0))[0])
    chain = np.roll(chain, -start).astype(np.int64)
    count = int((mesh.points[chain][:, 1] > 0.0).sum())
    edges = np.stack((chain[:-1], chain[1:]), axis=1)
    mesh = mesh.with_edge_set("below", edges[count + 2 :])
    return Harmonic(Elasticity(Space(mesh, Lagrange(2)), STEEL), held={"below": "xyz"}), edges[: count - 1]


def cells_of(bar, count):
    problem, edges = bar
    points = problem.elasticity.space.mesh.points
    length = float(np.linalg.norm(points[edges[:, 1]] - points[edges[:, 0]], axis=1).sum())
    return SurfaceCells(problem, edges, np.linspace(0.0, length, count + 1))


def test_cells_of_a_plane_have_the_coefficients_of_a_half_space() -> None:
    """On a flat surface cells have the half-space's coefficients to round-off, with frames and without."""
    limits = np.array([0.0, 0.4, 0.8, 2.0, 2.3])
    expected = half_space_influence(210e3, 0.3, limits, 0.5, 4).reshape(4, 4, 3, 4, 3)
    for frames in (np.tile(np.diag([1.0, -1.0, 1.0]), (4, 1, 1)), None):
        assert half_spaces_on((STEEL,), limits, frames, 0.5, 4) == pytest.approx(expected, rel=1e-12)


@pytest.mark.ci
def test_half_space_and_remainder_give_the_compliance_on_other_cells(bar) -> None:
    """Interpolated to cells of half the width, they agree with the compliance of these cells to 2 % of the largest."""
    surface = elastic_surface(cells_of(bar, 20))
    fine = cells_of(bar, 40)
    strip, n_strips = 1.5, 10
    direct = compliance_table(fine, 2e-5, 2.0 * np.pi / strip).influence(strip, n_strips)
    direct = direct.reshape(n_strips, 40, 3, 40, 3)
    stations = (fine.limits[1:] + fine.limits[:-1]) / 2.0
    across, along = surface.interpolation(stations), surface.along(strip * np.arange(n_strips))
    remainder = np.einsum("zk,ia,xykab,jb->zixjy", along, across, surface.by_axes, across, optimize=True)
    remainder = np.einsum("iax,zixjy,jby->ziajb", fine.frames, remainder, fine.frames, optimize=True)
    total = half_spaces_on((STEEL,), fine.limits, fine.frames, strip, n_strips) + remainder
    middle = slice(6, 34)
    for axis in (0, 1):
        expected = direct[:, middle, axis, middle, axis]
        assert total[:, middle, axis, middle, axis] == pytest.approx(expected, abs=0.02 * expected.max())
