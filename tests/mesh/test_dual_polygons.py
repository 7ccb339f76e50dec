"""Dual polygons against their definition (seed, section 3.3.6), and of random outlines of lines and arcs."""

import numpy as np
import pytest
from hypothesis import assume, given, settings
from hypothesis import strategies as st

from flangeway.errors import InputError
from flangeway.geometry import Arc, Line, Outline
from flangeway.mesh import PolyMesh, check, dual, rectangle_grid, triangulate


def corners(mesh, cell):
    row = slice(mesh.cell_offsets[cell], mesh.cell_offsets[cell + 1])
    return mesh.points[mesh.cell_points[row]]


def test_dual_of_one_triangle_by_hand():
    """A triangle gives three quadrilaterals: corner, middle, centre of gravity, middle."""
    mesh = PolyMesh([[0.0, 0.0], [6.0, 0.0], [0.0, 6.0]], [0, 3], [0, 1, 2])
    cells = dual(mesh)
    assert corners(cells, 0).tolist() == [[0, 0], [3, 0], [2, 2], [0, 3]]
    assert corners(cells, 1).tolist() == [[6, 0], [3, 3], [2, 2], [3, 0]]
    np.testing.assert_allclose(cells.cell_areas, 6.0)


def test_outline_and_edge_sets_survive():
    """Boundary points are kept, every boundary edge is halved, and sets keep order and length."""
    mesh = rectangle_grid(4.0, 2.0, 4, 3)
    cells = dual(mesh)
    assert len(cells.boundary_edges) == 2 * len(mesh.boundary_edges)
    for name in mesh.edge_sets:
        coarse, fine = mesh.points[mesh.chain(name)], cells.points[cells.chain(name)]
        assert np.array_equal(fine[::2], coarse)
        np.testing.assert_allclose(fine[1::2], 0.5 * (coarse[1:] + coarse[:-1]))
    middles = np.array([cells.edge_cells[e] for e in cells.edge_numbers(cells.edge_set("top"))])
    assert middles[:, 0].tolist() == [19, 18, 18, 17, 17, 16, 16, 15]


FLAT = PolyMesh([[0.0, 0.0], [10.0, -7.0], [0.0, 0.5], [-10.0, -7.0]], [0, 3, 6], [0, 1, 2, 0, 2, 3])


@pytest.mark.parametrize(
    ("mesh", "word"),
    [
        (FLAT, r"point 0 at .*flat"),
        (rectangle_grid(1.0, 1.0, 2, 2, cells="quadrilaterals"), "4 points"),
        (PolyMesh([[0, 0], [0, 1], [1, 0]], [0, 3], [0, 1, 2]), "area -"),
        (
            PolyMesh([[0, 0], [1, 0], [0, 1], [-1, 0], [0, -1]], [0, 3, 6], [0, 1, 2, 0, 3, 4]),
            r"point 0 at .*touches itself",
        ),
    ],
)
def test_triangles_without_a_dual_are_refused_with_their_place(mesh, word):
    """Very flat ones at a reentrant corner, quadrilaterals, clockwise ones, and two that share one point only."""
    check(FLAT)
    with pytest.raises(InputError, match=word):
        dual(mesh)


def test_cell_sets_are_carried_only_where_they_are_clear():
    """A set of all cells of one body of two is carried; one that divides a point is refused."""
    left, right = rectangle_grid(1.0, 1.0, 2, 2), rectangle_grid(1.0, 1.0, 3, 3, origin=(5.0, 0.0))
    both = left.merged(right).with_cell_set("left", np.arange(left.n_cells))
    cells = dual(both)
    assert cells.cell_sets["left"].tolist() == list(range(9))
    with pytest.raises(InputError, match=r"cell set 'low' with .* triangles of point"):
        dual(left.with_cell_set("low", [0, 1]))


@st.composite
def outlines(draw):
    """Star of 3 to 9 sides about a point, some of them arcs of up to half of their chord in height."""
    n = draw(st.integers(3, 9))
    radii = np.array(draw(st.lists(st.floats(0.3, 1.0), min_size=n, max_size=n)))
    bulges = draw(st.lists(st.sampled_from([0.0, 0.0, 0.02, -0.02, 0.15, -0.15, 0.4]), min_size=n, max_size=n))
    size = draw(st.sampled_from([1e-2, 1.0, 1e3]))
    angles = draw(st.floats(0.0, 6.0)) + 2.0 * np.pi * np.arange(n) / n
    corners = size * radii[:, None] * np.column_stack((np.cos(angles), np.sin(angles)))
    corners += size * np.array(draw(st.tuples(st.floats(-20.0, 20.0), st.floats(-20.0, 20.0))))
    ends = np.roll(corners, -1, axis=0)
    return [side(*each) for each in zip(corners, ends, bulges, strict=True)]


def side(start, end, bulge):
    """Line, or the arc whose height over its chord is `bulge` chords, outwards if positive."""
    if bulge == 0.0:
        return Line(tuple(start), tuple(end))
    chord = end - start
    outwards = np.array([chord[1], -chord[0]])
    height = abs(bulge)
    to_centre = (0.25 / height - height) / 2.0
    centre = (start + end) / 2.0 - np.sign(bulge) * to_centre * outwards
    return Arc(tuple(start), tuple(end), tuple(centre), counter_clockwise=bulge > 0.0)


def drawn(segments):
    """Outline, or None where the arcs of a star meet each other, which must be reported in three parts."""
    refused = None
    try:
        return Outline.from_segments(segments, [f"side {i}" for i in range(len(segments))])
    except InputError as error:
        refused = error
    assert refused.given
    assert refused.allowed
    assert refused.advice
    return None


@settings.get_profile("costly")
@given(segments=outlines(), fineness=st.sampled_from([2.0, 5.0, 12.0]))
def test_meshes_of_random_outlines_keep_the_area(segments, fineness):
    """Triangles and their dual fill the polygon of the boundary points; these are on the outline, names and all.

    The area is the outline's up to what chords cut off its arcs. A dual cell at the boundary begins with its own point,
    and has a centroid of each triangle about it.
    """
    outline = drawn(segments)
    assume(outline is not None)  # too many refusals fail Hypothesis' health check
    size = outline.size / fineness
    mesh = triangulate(outline, size=size)
    assert (mesh.cell_areas > 0.0).all()
    assert set(mesh.edge_sets) == set(outline.names)
    rim = mesh.points[mesh.boundary_edges]
    rim = rim - mesh.points[0]  # the area keeps its digits
    within = float(np.sum(rim[:, 0, 0] * rim[:, 1, 1] - rim[:, 1, 0] * rim[:, 0, 1])) / 2.0
    polygons = dual(mesh)
    check(mesh, region_area=within)
    check(polygons, region_area=within)
    assert polygons.cell_areas.sum() == pytest.approx(mesh.cell_areas.sum(), rel=1e-10)
    assert polygons.n_cells == mesh.n_points
    ends = np.isin(np.arange(mesh.n_points), mesh.boundary_edges)
    assert np.array_equal(polygons.cell_sizes, np.bincount(mesh.cell_points, minlength=mesh.n_points) + 3 * ends)
    for cell in np.flatnonzero(ends).tolist():
        assert np.array_equal(corners(polygons, cell)[0], mesh.points[cell])
    _, _, distances = outline.closest(mesh.points[mesh.boundary_edges[:, 0]])
    assert np.abs(distances).max() < 1e-9 * outline.size
    sides = zip(outline.segments, outline.names, strict=True)
    cut_off = sum(maximum_cut(segment, mesh, name) for segment, name in sides)
    assert abs(within - outline.area) <= cut_off + 1e-9 * outline.area


def maximum_cut(segment, mesh, name):
    """Area between an arc and the chords of its edges, (r^2 / 2) (t - sin t) of each."""
    if isinstance(segment, Line):
        return 0.0
    edges = mesh.points[mesh.edge_sets[name]]
    radius = np.hypot(*np.subtract(segment.start, segment.centre))
    lengths = np.hypot(*(edges[:, 1] - edges[:, 0]).T)
    turns = 2.0 * np.arcsin(np.minimum(lengths / (2.0 * radius), 1.0))
    return float(np.sum(radius**2 / 2.0 * (turns - np.sin(turns))) * (1.0 + 1e-6))
