"""Virtual elements on random simple polygons: projections, stiffness, patch test."""

import numpy as np
from hypothesis import assume, given
from hypothesis import strategies as st

from flangeway.elements import Virtual
from flangeway.errors import InputError
from flangeway.materials import Elastic
from flangeway.mesh import PolyMesh, check, dual
from flangeway.space import Space
from tests.given_displacement import solved

STEEL = Elastic(210e3, 0.3)
ORDERS = st.sampled_from([1, 2])
GRADIENT = np.array([[1.2e-3, -0.7e-3], [2.1e-3, 0.4e-3]])


@st.composite
def polygons(draw):
    """Polygon (n, 2) about the origin, from which all of it is seen: convex or not, of any direction and place."""
    n = draw(st.integers(3, 14))
    steps = np.array(draw(st.lists(st.floats(0.2, 1.0), min_size=n, max_size=n)))
    radii = np.array(draw(st.lists(st.floats(0.1, 1.0), min_size=n, max_size=n)))
    steps *= 2.0 * np.pi / steps.sum()
    if steps.max() > 3.0:  # the centre must stay inside
        steps = np.full(n, 2.0 * np.pi / n)
    angles = draw(st.floats(0.0, 6.0)) + np.cumsum(steps)
    return radii[:, None] * np.column_stack((np.cos(angles), np.sin(angles)))


def one_cell(points):
    return PolyMesh(points, [0, len(points)], np.arange(len(points)))


def fan(points):
    """Triangles from the origin to the polygon's edges."""
    n = len(points)
    triangles = [(n, i, (i + 1) % n) for i in range(n)]
    return PolyMesh(np.vstack((points, [[0.0, 0.0]])), 3 * np.arange(n + 1), np.ravel(triangles))


def dual_or_none(mesh):
    """Dual polygons, or None where the origin is not inside of the triangles' centroids, which is refused."""
    try:
        return dual(mesh)
    except InputError as error:
        return None if "so flat" in error.given else dual(mesh)


@given(points=polygons(), order=ORDERS, cells=st.sampled_from(["fan", "dual"]))
def test_the_patch_test_holds(points, order, cells):
    """On the fan of a polygon and on its dual, a linear displacement of the boundary is linear inside, to 1e-8."""
    mesh = fan(points)
    if cells == "dual":
        mesh = dual_or_none(mesh)
        assume(mesh is not None)
        check(mesh, region_area=one_cell(points).cell_areas.sum())
    space = Space(mesh, Virtual(order))
    solution = solved(space, STEEL, lambda p: p @ GRADIENT.T + [1e-3, -2e-3])
    exact = space.nodes @ GRADIENT.T + [1e-3, -2e-3]
    assert np.abs(solution.displacements[: space.n_nodes] - exact).max() < 1e-8 * np.abs(exact).max()
