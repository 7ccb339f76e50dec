"""Pictures of meshes and fields: what is drawn is what the elements say."""

import numpy as np
import pytest
from matplotlib.collections import TriMesh
from matplotlib.figure import Figure

from flangeway.elements import Virtual
from flangeway.geometry import circle, rectangle
from flangeway.materials import Elastic
from flangeway.mesh import PolyMesh, dual, refined, triangulate
from flangeway.post import corner_stresses, displacements_at, stresses_at
from flangeway.problems import Elasticity, Traction, fixed
from flangeway.report.figures.display import NO_EDGE, display, displayed_stresses
from flangeway.report.figures.plots import (
    plot_deformed,
    plot_displacement,
    plot_function,
    plot_mesh,
    plot_stress,
    stress_quantity,
)
from flangeway.solve import ElasticitySolution, solve_elasticity
from flangeway.space import Space, interpolate

TRIANGLES = triangulate(rectangle(4.0, 2.0), size=0.8, holes=[circle(0.5)])
U_SHAPE = PolyMesh([[0, 0], [4, 0], [4, 3], [3, 3], [3, 1], [1, 1], [1, 3], [0, 3]], [0, 8], range(8))
MESHES = {
    "triangles": TRIANGLES,
    "polygons": dual(TRIANGLES),
    "hanging": refined(TRIANGLES, np.arange(5)),
    "u": U_SHAPE,
}


def pulled(mesh: PolyMesh, order: int) -> ElasticitySolution:
    """The plate with a hole, held at the left and pulled to the right."""
    problem = Elasticity(
        Space(mesh, Virtual(order)), Elastic(70.0, 0.3), loads=[Traction("right", (1.0, 0.2))], supports=[fixed("left")]
    )
    return solve_elasticity(problem)


@pytest.mark.parametrize("kind", sorted(MESHES))
def test_triangles_fill_the_cells(kind):
    """The small triangles are counter-clockwise, have the area of their cells, and share places across edges."""
    mesh, pieces = MESHES[kind], 3
    shown = display(Space(mesh, Virtual(2)), pieces)
    corners = shown.points[shown.triangles]
    first, second = corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]
    areas = 0.5 * (first[:, 0] * second[:, 1] - first[:, 1] * second[:, 0])
    assert areas.min() > 0.0
    sums = np.bincount(shown.cells[shown.triangles[:, 0]], areas, minlength=mesh.n_cells)
    np.testing.assert_allclose(sums, mesh.cell_areas, rtol=1e-12)
    place_points = np.zeros((shown.places.max() + 1, 2))
    place_points[shown.places] = shown.points
    np.testing.assert_allclose(place_points[shown.places], shown.points, atol=1e-14)
    on_edges = np.unique(shown.places[shown.edge != NO_EDGE])
    assert len(on_edges) == mesh.n_points + mesh.n_edges * (pieces - 1)


@pytest.mark.parametrize("order", [1, 2, 3])
@pytest.mark.parametrize("kind", sorted(MESHES))
def test_a_polynomial_is_drawn_exactly(kind, order):
    """A polynomial of degree k of a space of order k has its values at all small triangles' points."""
    space = Space(MESHES[kind], Virtual(order))
    shown = display(space, 4)

    def exact(points):
        return (0.3 + points @ [0.7, -0.4]) ** order

    values = shown.function(interpolate(space, exact)[:, None])[:, 0]
    np.testing.assert_allclose(values, exact(shown.points), atol=1e-10)


@pytest.mark.parametrize("kind", ["triangles", "polygons", "hanging"])
def test_displacements_are_continuous_and_stresses_those_of_the_cells(kind):
    """Displacements agree across edges; inside, both agree with post's values at the same points."""
    solution = pulled(MESHES[kind], 2)
    shown = display(solution.problem.space, 3)
    moved = shown.function(solution.displacements)
    order = np.argsort(shown.places, kind="stable")
    same = np.flatnonzero(np.diff(shown.places[order]) == 0)
    np.testing.assert_allclose(moved[order[same]], moved[order[same + 1]], atol=1e-13)
    inside = shown.edge == NO_EDGE
    np.testing.assert_allclose(moved[inside], displacements_at(solution, shown.points[inside]), atol=1e-12)
    stresses = displayed_stresses(solution, shown).components
    np.testing.assert_allclose(stresses[inside], stresses_at(solution, shown.points[inside]).components, atol=1e-10)
    own = corner_stresses(solution.problem, solution.displacements).components
    corners = np.flatnonzero(shown.places < shown.mesh.n_points)
    assert len(corners) == len(own)
    assert np.sort(stresses[corners], axis=0) == pytest.approx(np.sort(own, axis=0), abs=1e-10)


def test_pictures_show_the_values_and_say_the_units():
    """The drawn values are the quantity's, the bar names it with its unit, limits are kept, and no state is left."""
    import matplotlib.pyplot as plt  # noqa: PLC0415

    solution = pulled(TRIANGLES, 2)
    for quantity in ("von_mises", "xx", "zz", "in_plane_shear", "principal_1", "principal_3"):
        axes = plot_stress(solution, quantity, unit="MPa", length_unit="mm", limits=(0.0, 2.0), factor="auto")
        (drawn,) = [c for c in axes.collections if isinstance(c, TriMesh)]
        assert drawn.get_clim() == (0.0, 2.0)
        bar = axes.figure.axes[1]
        assert bar.get_ylabel().endswith(", MPa")
        assert axes.get_xlabel() == "x, mm"
        assert "deformation x" in axes.get_title()
    shown = display(solution.problem.space, 6)
    wanted = stress_quantity(displayed_stresses(solution, shown), "principal_3")
    assert drawn.get_array().max() == pytest.approx(wanted.max())
    assert not plt.get_fignums()


def test_named_edges_are_in_the_legend():
    """Every edge set is drawn with as many lines as it has edges, and named."""
    mesh = MESHES["polygons"]
    axes = plot_mesh(mesh)
    assert [text.get_text() for text in axes.get_legend().get_texts()] == [*mesh.edge_sets]
    lines = {c.get_label(): len(c.get_paths()) for c in axes.collections}
    assert all(lines[name] == len(pairs) for name, pairs in mesh.edge_sets.items())


def test_deformed_edges_of_order_2_are_curved():
    """Deformed edges have inner points off their chords for order 2, none for order 1, and end at moved points."""
    for order, curved in ((1, False), (2, True)):
        solution = pulled(MESHES["polygons"], order)
        axes = plot_deformed(solution, factor=3.0)
        n_edges = solution.problem.space.mesh.n_edges
        (edges,) = [c for c in axes.collections if len(c.get_paths()) == n_edges]
        lines = np.array([path.vertices for path in edges.get_paths()])
        mesh = solution.problem.space.mesh
        moved = mesh.points + 3.0 * solution.displacements[: mesh.n_points]
        np.testing.assert_allclose(lines[:, 0], moved[mesh.edges[:, 0]], atol=1e-12)
        chords = lines[:, :1] + np.linspace(0.0, 1.0, lines.shape[1])[:, None] * (lines[:, -1:] - lines[:, :1])
        assert (np.abs(lines - chords).max() > 1e-3) == curved


def test_pictures_of_functions_and_displacements():
    """A function of a space and displacement components are drawn into given axes with their range of values."""
    solution = pulled(MESHES["polygons"], 1)
    axes = plot_displacement(solution, "x", unit="mm")
    (drawn,) = [c for c in axes.collections if isinstance(c, TriMesh)]
    n_points = solution.problem.space.mesh.n_points
    assert drawn.get_clim()[1] == pytest.approx(solution.displacements[:n_points, 0].max())
    space = Space(MESHES["u"], Virtual(2))
    given = Figure().subplots()
    assert plot_function(space, np.full(space.n_dofs, 2.0), given, label="level") is given
    (drawn,) = [c for c in given.collections if isinstance(c, TriMesh)]
    assert drawn.get_clim() == pytest.approx((1.0, 3.0))
