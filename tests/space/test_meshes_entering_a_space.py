"""A mesh is checked where it enters a `Space`, and an edge set knows the side of its body."""

from contextlib import suppress

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.spatial import Delaunay

from flangeway.elements import Lagrange, Virtual
from flangeway.errors import InputError
from flangeway.geometry import Placement
from flangeway.materials import Elastic
from flangeway.mesh import PolyMesh, dual, edges_halved, rectangle_grid, refined
from flangeway.problems import Elasticity, Pressure, fixed
from flangeway.solve import solve_elasticity
from flangeway.space import Space

GRID = rectangle_grid(4.0, 2.0, 4, 2)


def mesh_of(points, cells, **sets):
    offsets = np.cumsum([0, *map(len, cells)])
    return PolyMesh(np.array(points, dtype=float), offsets, np.concatenate(cells), **sets)


def cells_of(mesh):
    return [mesh.cell_points[a:b].tolist() for a, b in zip(mesh.cell_offsets[:-1], mesh.cell_offsets[1:], strict=True)]


def pressed(mesh, loaded="top"):
    problem = Elasticity(
        Space(mesh, Lagrange(1)), Elastic(210e3, 0.3), loads=[Pressure(loaded, 5.0)], supports=[fixed("bottom")]
    )
    return solve_elasticity(problem).displacements


def refused(mesh, words):
    with pytest.raises(InputError, match=words):
        Space(mesh, Virtual(1))


def test_an_edge_set_in_any_order_knows_its_body():
    """Pressure pushes into the body whichever way the edges of its set are given, each of them."""
    right = pressed(GRID)
    top = GRID.edge_sets["top"]
    assert right[top[:, 0], 1].max() < 0.0
    sets = dict(GRID.edge_sets)
    for given_as in (top[:, ::-1], np.vstack([top[::2, ::-1], top[1::2]])):
        turned = mesh_of(GRID.points, cells_of(GRID), edge_sets={**sets, "top": given_as})
        assert np.array_equal(turned.edge_sets["top"], top)
        assert np.array_equal(pressed(turned), right)


BLOCK = np.array([(0.0, 0.0), (1.0, 0.0), (1.0, 1.0), (0.0, 1.0)])


def test_cells_that_overlap_around_common_points_are_refused():
    """A cell given twice, a fan around its point twice, and a cell inside one that it touches, are refused."""
    refused(mesh_of(BLOCK, [[0, 1, 2, 3], [0, 1, 2, 3]]), "same side")
    angles = np.arange(10) * 0.4 * np.pi
    fan = np.vstack([[(0.0, 0.0)], np.column_stack([np.cos(angles), np.sin(angles)])])
    fan[6:] *= 1.5
    refused(mesh_of(fan, [[0, i, i % 10 + 1] for i in range(1, 11)]), "cross|same place|inside another")
    inner = np.vstack([BLOCK, [(0.6, 0.3), (0.3, 0.6)]])
    refused(mesh_of(inner, [[0, 1, 2, 3], [0, 4, 5]]), "inside another")
    frame = np.vstack([3.0 * BLOCK, BLOCK + 1.0, 0.5 * BLOCK + 1.25, 0.5 * BLOCK + 0.25])
    ring = [[0, 1, 5, 4], [1, 2, 6, 5], [2, 3, 7, 6], [3, 0, 4, 7]]
    Space(mesh_of(frame[:12], [*ring, [8, 9, 10, 11]]), Virtual(1))  # in the hole
    refused(mesh_of(frame[[*range(8), *range(12, 16)]], [*ring, [8, 9, 10, 11]]), "cross|inside another")  # in the ring


@pytest.mark.parametrize(
    "corners",
    [
        [(0, 0), (4, 0), (4, 4), (-0.5, 3), (0.5, 3.5)],
        [(np.cos(0.8 * np.pi * k), np.sin(0.8 * np.pi * k)) for k in range(5)],
        [(0, 0), (3, 0), (3, 3), (1, 1), (2, 1), (0, 3)],
        [(0, 0), (4, 0), (4, 4), (2, 4), (2, 0), (1.9, 4), (0, 4)],
        [(0, 0), (2, 0), (1, 0), (1, 2)],
    ],
    ids=["knot", "pentagram", "loop", "touching", "fold"],
)
def test_polygons_that_meet_themselves_are_refused(corners):
    """A cell that crosses, overlaps or touches itself is refused though its area is positive."""
    mesh = mesh_of(corners, [range(len(corners))])
    assert mesh.cell_areas[0] > 0.0
    refused(mesh, "cross|same place")


@pytest.mark.parametrize("off", [0.0, 1e-9, -1e-9])
def test_t_junctions_are_told_from_hanging_points_of_polygons(off):
    """A point inside a neighbour's edge is refused; as a point of that neighbour it is accepted."""
    points = [(0, 0), (2, 0), (2, 1), (0, 1), (2, 2), (0, 2), (1, 1 + off)]
    halves = [[3, 6, 4, 5], [6, 2, 4]]
    refused(mesh_of(points, [[0, 1, 2, 3], *halves]), r"point 6 at \(1, 1(\.000000001)?\) hangs on|cross|hangs")
    Space(mesh_of(points, [[0, 1, 2, 6, 3], *halves]), Virtual(1))


def apart(off=0.0):
    """Two columns of squares whose points at the common side are there twice."""
    left, right = (rectangle_grid(2.0, 2.0, 2, 2, cells="quadrilaterals", origin=(x, 0.0)) for x in (0.0, 2.0 + off))
    bare = [mesh_of(mesh.points, cells_of(mesh)) for mesh in (left, right)]
    return bare[0].merged(bare[1]), left.edge_sets["right"], right.edge_sets["left"] + left.n_points


@pytest.mark.parametrize("off", [0.0, 1e-12, 1e-8])
def test_points_that_were_not_merged_are_refused(off):
    """Points that are there twice are refused, to rounding, also where a set holds the whole boundary."""
    mesh, _, _ = apart(off)
    refused(mesh, "at the same place")
    refused(mesh.with_edge_set("outline", mesh.boundary_edges), "at the same place")
    split = cells_of(GRID)
    last = next(i for i, cell in enumerate(split) if 6 in cell)
    split[last] = [GRID.n_points if p == 6 else p for p in split[last]]
    refused(mesh_of([*GRID.points, GRID.points[6]], split), "at the same place")


def test_a_crack_with_named_faces_and_bodies_that_share_a_point_are_meant():
    """Two faces at one place are a crack where both are named so; what touches in a common point is a hinge."""
    mesh, one, other = apart()
    mesh = mesh.with_edge_set("one", one).with_edge_set("other", other)
    refused(mesh, "at the same place")
    with pytest.raises(InputError, match="at the same place"):
        Space(mesh, Virtual(1), cracks=["one"])
    assert Space(mesh, Virtual(1), cracks=["one", "other"]).n_dofs == 18
    points = [[0, 0], [1, 0], [1, 1], [0, 1], [2, 1], [2, 2], [1, 2]]
    Space(mesh_of(points, [[0, 1, 2, 3], [2, 4, 5, 6]]), Virtual(1))


def random_mesh(seed):
    """Triangles in a random outline with holes, maybe their dual or refined in places, maybe mirrored and far away."""
    rng = np.random.default_rng(seed)
    cloud = np.vstack([rng.random((30, 2)), rng.random((3, 2)) * [1.0, 1e-2]])
    triangles = Delaunay(cloud).simplices
    a, b, c = np.moveaxis(cloud[triangles], 1, 0)
    area = (b - a)[:, 0] * (c - a)[:, 1] - (b - a)[:, 1] * (c - a)[:, 0]
    triangles = np.where((area < 0.0)[:, None], triangles[:, ::-1], triangles)
    triangles = triangles[(np.abs(area) > 1e-5) & (rng.random(len(area)) > 0.1)]
    kept, numbers = np.unique(triangles, return_inverse=True)
    mesh = mesh_of(cloud[kept], numbers.reshape(-1, 3))
    mesh = mesh.with_edge_set("rim", mesh.boundary_edges[:1])
    kind = rng.integers(4)
    if kind == 1:
        with suppress(InputError):  # the boundary touches itself at a point, or triangles are too flat
            mesh = dual(mesh)
    elif kind == 2:
        mesh = refined(mesh, np.flatnonzero(rng.random(mesh.n_cells) < 0.3))
    elif kind == 3:
        mesh = edges_halved(mesh, "rim")
    return mesh.placed(Placement(rng.uniform(0.0, 6.0), tuple(rng.uniform(-1e3, 1e3, 2)), bool(rng.integers(2))))


@settings.get_profile("costly")
@given(st.integers(0, 2**32 - 1))
def test_random_meshes_are_accepted_and_their_corruptions_refused(seed):
    """Random sound meshes enter a space; with a cell reversed, doubled or cut off or a point moved, they do not."""
    mesh = random_mesh(seed)
    Space(mesh, Virtual(1))
    rng = np.random.default_rng(seed)
    cells = cells_of(mesh)
    cell, other = rng.integers(mesh.n_cells, size=2)
    reversed_one = [row[::-1] if i == cell else row for i, row in enumerate(cells)]
    refused(mesh_of(mesh.points, reversed_one), "with area -")
    refused(mesh_of(mesh.points, [*cells, cells[cell]]), "same side")
    here = mesh.points[cells[cell]]
    apart = mesh_of([*mesh.points, *here], [*cells, range(mesh.n_points, mesh.n_points + len(here))])
    refused(apart, "same place|inside another")
    moved = here + mesh.points[cells[other]].mean(axis=0) - here.mean(axis=0) + 1e-3 * rng.random(2)
    laid = mesh_of([*mesh.points, *moved], [*cells, range(mesh.n_points, mesh.n_points + len(here))])
    refused(laid, "cross|inside another|same place|hangs")
    uses = np.bincount(mesh.cell_points)
    point = int(rng.choice(np.flatnonzero(uses > 1)))
    mine = next(i for i, row in enumerate(cells) if point in row)
    split = [[mesh.n_points if p == point else p for p in row] if i == mine else row for i, row in enumerate(cells)]
    refused(mesh_of([*mesh.points, mesh.points[point]], split), "same place")
    far = mesh.points.copy()
    inner = uses.copy()
    inner[mesh.boundary_edges] = 0  # a point of the boundary may be drawn out without harm
    far[np.argmax(inner)] += 5.0 * (mesh.points.mean(axis=0) - mesh.points[np.argmax(inner)] + 1.0)
    if inner.max() > 2:
        refused(mesh_of(far, cells), "with area|cross|inside another|hangs|same place")
    shared = [i for i, row in enumerate(cells) if len(row) > 3]
    for i in shared[:1]:
        corners = mesh.points[cells[i]]
        before, after = corners - np.roll(corners, 1, axis=0), np.roll(corners, -1, axis=0) - corners
        turn = np.abs(before[:, 0] * after[:, 1] - before[:, 1] * after[:, 0])
        straight = np.flatnonzero(turn <= 1e-9 * np.hypot(*before.T) * np.hypot(*after.T))
        straight = [k for k in straight if uses[cells[i][k]] > 1]
        if straight:
            dropped = [p for k, p in enumerate(cells[i]) if k != straight[0]]
            refused(mesh_of(mesh.points, [dropped if j == i else row for j, row in enumerate(cells)]), "hangs")
