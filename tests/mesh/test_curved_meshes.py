"""Meshes whose edges lie on the curves that were drawn."""

import pickle
from dataclasses import replace
from pathlib import Path

import meshio
import numpy as np
import pytest

from flangeway.elements import Serendipity, StabilisationFree, Virtual
from flangeway.errors import InputError
from flangeway.formats import read_mesh, write_vtu
from flangeway.geometry import Arc, Line, Outline, Placement, Spline, circle, rectangle
from flangeway.mesh import PolyMesh, agglomerated, conforming, curved, dual, edges_halved, refined, triangulate
from flangeway.mesh.connectivity import EdgeCurves
from flangeway.post.stress import locate
from flangeway.report.figures.display import display
from flangeway.report.figures.plots import plot_mesh
from flangeway.space import Space

OUTER, HOLE = circle(1.0), circle(0.4)
AREA = np.pi * 0.84


def ring() -> PolyMesh:
    return triangulate(OUTER, size=0.5, holes=[HOLE])


def off_circles(mesh: PolyMesh) -> float:
    radii = np.hypot(*mesh.points[np.unique(mesh.boundary_edges)].T)
    return float(np.minimum(np.abs(radii - 1.0), np.abs(radii - 0.4)).max())


def test_duals_and_refinements_stay_on_the_curves_with_the_exact_area() -> None:
    """Areas of curved cells sum up to that of the ring, new points are on its circles, all boundary edges curved."""
    mesh = curved(ring(), [OUTER, HOLE])
    some = refined(mesh, np.arange(6))
    made = triangulate(OUTER, size=0.5, holes=[HOLE], outline=[OUTER, HOLE])
    for each in (mesh, made, dual(mesh), dual(ring(), outline=[OUTER, HOLE]), refined(mesh), refined(dual(mesh)), some):
        assert each.cell_areas.sum() == pytest.approx(AREA, rel=1e-10)
        assert off_circles(each) < 1e-12
        assert len(each.curves.pairs) == len(each.boundary_edges)
    assert abs(ring().cell_areas.sum() / AREA - 1.0) > 1e-3


def test_centroids_are_those_of_the_curved_cells() -> None:
    """The first moments of the cells sum up to that of a disc off the origin."""
    disc = circle(1.0, (3.0, -2.0))
    mesh = curved(triangulate(disc, size=0.8), disc)
    moments = mesh.cell_areas @ mesh.cell_centroids
    assert moments == pytest.approx(np.pi * np.array([3.0, -2.0]), rel=1e-9)


def test_curves_are_kept_by_placements_merging_sets_and_pickles() -> None:
    """A mirrored and turned copy beside the mesh has the same area on curves; so have copies with sets and pickles."""
    mesh = curved(ring(), [OUTER, HOLE])
    moved = mesh.placed(Placement(rotation_rad=0.3, translation=(5.0, 1.0), mirrored=True))
    both = mesh.merged(moved).with_cell_set("one", [0])
    for each, n_times in ((moved, 1), (both, 2), (pickle.loads(pickle.dumps(both)), 2)):
        assert each.cell_areas.sum() == pytest.approx(n_times * AREA, rel=1e-10)
    assert mesh.straight().curves is None


def test_a_chord_that_was_drawn_stays_straight() -> None:
    """Of half a disc the diameter is a line, though its ends lie on the arc."""
    half = Outline((Arc((1.0, 0.0), (-1.0, 0.0), (0.0, 0.0), True), Line((-1.0, 0.0), (1.0, 0.0))), ("arc", "line"))
    mesh = curved(triangulate(half, size=0.7), half)
    assert mesh.cell_areas.sum() == pytest.approx(np.pi / 2.0, rel=1e-10)
    assert len(mesh.curves.pairs) == len(mesh.edge_set("arc"))


def test_nodes_of_edges_lie_on_the_arc_and_those_of_straight_edges_where_they_were() -> None:
    """All nodes of the boundary are on the circles for every order; the others do not move."""
    mesh = curved(ring(), [OUTER, HOLE])
    for order in (2, 5):
        space, before = Space(mesh, Virtual(order)), Space(ring(), Virtual(order))
        nodes = np.unique(space.edge_nodes(mesh.boundary_edges))
        radii = np.hypot(*space.nodes[nodes].T)
        assert np.minimum(np.abs(radii - 1.0), np.abs(radii - 0.4)).max() < 1e-12
        others = np.setdiff1d(np.arange(space.n_nodes), nodes)
        assert np.abs(space.nodes[others] - before.nodes[others]).max() < 1e-9


def test_a_spline_is_smooth_and_its_closest_points_are_exact() -> None:
    """A closed spline through 12 points of a circle is the circle to 1e-3; closest points are square to the tangent."""
    angle = np.linspace(0.0, 2.0 * np.pi, 13)
    points = np.stack((np.cos(angle), np.sin(angle)), axis=1)
    points[-1] = points[0]
    spline = Spline(points)
    assert spline.closed
    given = np.random.default_rng(1).normal(size=(50, 2))
    s, distance = spline.closest(given)
    assert np.abs(distance - np.abs(np.hypot(*given.T) - 1.0)).max() < 1e-3
    along = spline.point(s + 1e-6) - spline.point(s - 1e-6)
    assert np.abs(((given - spline.point(s)) * along).sum(axis=1)).max() < 1e-10
    mesh = curved(triangulate(OUTER, size=0.5), spline)
    assert mesh.cell_areas.sum() == pytest.approx(np.pi, rel=2e-3)


def two_triangles() -> PolyMesh:
    return PolyMesh.from_cells([[0.0, 0.0], [1.0, 0.0], [0.9, 0.25], [0.1, 0.25]], [[0, 1, 2], [0, 2, 3]])


@pytest.mark.parametrize("depth", [0.3, 2.0])
def test_an_arc_that_leaves_its_cell_is_refused_with_the_place(depth: float) -> None:
    """An arc that bends through the cell's other edges, a little or far, is named with its cell."""
    radius = (0.25 + depth**2) / (2.0 * depth)
    arc = Arc((1.0, 0.0), (0.0, 0.0), (0.5, depth - radius), True)
    mesh = curved(two_triangles(), [Spline(arc.point(np.linspace(0.0, 1.0, 9))), rectangle(0.8, 1.0, (0.1, -0.75))])
    with pytest.raises(InputError, match=r"cell 0 near .* with a curved edge that leaves it"):
        Space(mesh, Virtual(2))
    assert Space(mesh, Virtual(1)).n_dofs == 4  # edges of order 1 are chords


def test_agglomerated_polygons_and_halved_edges_stay_on_the_curves() -> None:
    """Both keep every edge of the boundary curved, and the exact area; polygons inside have no curved edge left."""
    mesh = dual(curved(ring(), [OUTER, HOLE]))
    fewer, halved = agglomerated(mesh, 7), edges_halved(mesh.with_edge_set("rim", mesh.boundary_edges[::3]), "rim")
    assert fewer.n_cells == 7
    assert len(halved.curves.pairs) == len(mesh.curves.pairs) + len(mesh.boundary_edges[::3])
    for each in (fewer, halved):
        assert each.cell_areas.sum() == pytest.approx(AREA, rel=1e-10)
        assert off_circles(each) < 1e-12
        assert len(each.curves.pairs) == len(each.boundary_edges)


def test_points_on_the_chord_of_a_curved_edge_are_no_hanging_points() -> None:
    """On straight edges they are added and curves stay; on the chord of a curved edge they are refused, with why."""
    points = [[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0], [0.5, 1.0], [0.5, 1.6], [0.0, 1.6], [1.0, 1.6]]
    mesh = PolyMesh.from_cells(points, [[0, 1, 2, 3], [3, 4, 5, 6], [4, 2, 7, 5]])
    below = Spline([[0.0, 0.0], [0.3, -0.1], [0.7, -0.1], [1.0, 0.0]])
    whole = conforming(curved(mesh, below))
    assert whole.cell_sizes.tolist() == [5, 4, 4]
    assert len(whole.curves.pairs) == 1
    above = Spline([[0.0, 1.0], [0.3, 1.1], [0.7, 1.1], [1.0, 1.0]])
    bent = EdgeCurves(np.array([[3, 2]], dtype=np.int32), (above,), np.array([0]), np.array([[0.0, 1.0]]))
    with pytest.raises(InputError, match=r"point 4 at .* hangs on the chord of a curved edge"):
        conforming(replace(mesh, curves=bent))


def test_every_place_of_a_curved_mesh_is_found_in_a_cell() -> None:
    """Points beside the chords up to the circle belong to the cells there, points beyond it to none."""
    mesh = dual(curved(ring(), [OUTER, HOLE]))
    angle = np.linspace(0.0, 2.0 * np.pi, 101)
    circles = {radius: radius * np.stack((np.cos(angle), np.sin(angle)), axis=1) for radius in (0.397, 0.4, 1.0, 1.002)}
    assert (locate(mesh, circles[1.0]) >= 0).all()
    assert (locate(mesh, circles[0.4]) >= 0).all()
    assert (locate(mesh, circles[1.002]) < 0).all()
    assert (locate(mesh, circles[0.397]) < 0).all()
    assert (locate(mesh.straight(), circles[1.0]) < 0).any()
    cells = np.unique(locate(mesh, 0.9999 * circles[1.0]))
    outer = mesh.boundary_edges[np.hypot(*mesh.points[mesh.boundary_edges[:, 0]].T) > 0.7]
    assert set(cells) <= set(mesh.edge_cells[mesh.edge_numbers(outer), 0])


def test_files_and_pictures_follow_the_curves(tmp_path: Path) -> None:
    """A VTU file has the ring's area to 0.1 % and values between those of the ends; pictures end on the circles."""
    mesh = dual(curved(triangulate(OUTER, size=0.9, holes=[HOLE]), [OUTER, HOLE]))
    corners = {"at_corner": mesh.points[mesh.cell_points, 0]}
    write_vtu(tmp_path / "points.vtu", mesh, {"x": mesh.points[:, 0], "number": np.arange(mesh.n_points)})
    write_vtu(tmp_path / "corners.vtu", mesh, {}, {"area": mesh.cell_areas}, corners)
    read = meshio.read(tmp_path / "points.vtu")
    assert np.abs(read.point_data["x"] - read.points[:, 0]).max() < 0.1
    assert (read.point_data["number"][: mesh.n_points] == np.arange(mesh.n_points)).all()
    both = meshio.read(tmp_path / "corners.vtu")
    assert np.abs(both.point_data["at_corner"] - both.points[:, 0]).max() < 0.1
    for name in ("points.vtu", "corners.vtu"):
        found = read_mesh(tmp_path / name).mesh
        assert found.n_cells == mesh.n_cells
        assert found.cell_areas.sum() == pytest.approx(AREA, rel=1e-3)
        assert np.abs(found.cell_areas - mesh.cell_areas).max() < 1e-3
    shown = display(Space(mesh, Virtual(3)))
    a, b, c = np.moveaxis(shown.points[shown.triangles], 1, 0)
    areas = 0.5 * ((b - a)[:, 0] * (c - a)[:, 1] - (b - a)[:, 1] * (c - a)[:, 0])
    assert areas.min() > 0.0
    assert areas.sum() == pytest.approx(AREA, rel=3e-3)
    rim = [line for each in plot_mesh(mesh).collections for line in each.get_segments()]
    ends = np.concatenate([line for line in rim if np.hypot(*line.mean(axis=0)) > 0.99])
    assert np.abs(np.hypot(*ends.T) - 1.0).max() < 1e-9
    assert len(ends) > 8 * len(mesh.boundary_edges)


LOOP = [[1.0, 1.0], [0.2, 1.4], [0.2, 0.8], [0.8, 1.4], [0.0, 1.0]]
BULGE = Arc((-1.0, 0.0), (1.0, 0.0), (0.0, -1.0), False)


def bent_cell(points: list[list[float]], pair: tuple[int, int], curve: Spline | Arc, end: float = 1.0) -> Space:
    """One cell with one curved edge."""
    table = EdgeCurves(np.array([pair], dtype=np.int32), (curve,), np.array([0]), np.array([[0.0, end]]))
    return Space(replace(PolyMesh.from_cells(points, [range(len(points))]), curves=table), Virtual(3))


@pytest.mark.parametrize(
    ("make", "words"),
    [
        (lambda: bent_cell([[0, 0], [1, 0], [1, 1], [0, 1]], (2, 3), Spline(LOOP)), "cell 0 near .* that leaves it"),
        (lambda: bent_cell([[-1, 0], [1, 0], [1, 0.1], [-1, 0.1]], (0, 1), BULGE), "cell 0 near .* that leaves it"),
        (
            lambda: bent_cell([[-1, 0], [1, 0], [1, 1], [-1, 1]], (0, 1), BULGE, 0.9),
            r"the edge \(0, 1\) .* from its curve",
        ),
        (lambda: curved(ring(), circle(9.0)), "on which no edge of the mesh lies"),
        (lambda: Spline([[0.0, 0.0], [1.0, 0.0], [2.0, 1.0]]), "through 3 points"),
        (lambda: Spline([[0.0, 0.0], [1.0, 0.0], [1.0, 0.0], [2.0, 1.0]]), "twice in a row"),
        (lambda: triangulate(OUTER, size=0.5, outline="circle"), "'c' as a curve of the boundary"),
        (lambda: curved(ring(), 3.0), "3.0 as a curve of the boundary"),
        (lambda: curved(ring(), [[[0.0, 1.0], [1.0, 0.0]]]), "as a curve of the boundary"),
        (lambda: triangulate(rectangle(1.0, 1.0), size=0.5, outline=rectangle(1.0, 1.0)), "no edge of the mesh lies"),
        (
            lambda: Space(dual(curved(ring(), OUTER)), StabilisationFree(2)),
            "StabilisationFree on cells with curved edges",
        ),
        (lambda: Space(dual(curved(ring(), OUTER)), Serendipity(3)), "Serendipity on cells with curved edges"),
    ],
)
def test_curves_that_make_no_cells_are_refused(make, words: str) -> None:
    """A spline that crosses itself, an arc through the other side, one that ends elsewhere, and what is no curve."""
    with pytest.raises(InputError, match=words):
        make()
