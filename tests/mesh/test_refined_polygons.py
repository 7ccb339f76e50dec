"""Refinement of polygons with hanging points."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from flangeway.errors import InputError
from flangeway.geometry import circle, polygon, square
from flangeway.mesh import (
    PolyMesh,
    agglomerated,
    check,
    doerfler_marking,
    dual,
    rectangle_grid,
    refined,
    triangulate,
    voronoi,
)
from flangeway.mesh.cutting import kernel_centre
from flangeway.mesh.refine import cell_sides

TRIANGLES = triangulate(square(1.0), size=0.4)
BASES = {
    "triangles": TRIANGLES,
    "polygons": dual(TRIANGLES),
    "quadrilaterals": rectangle_grid(1.0, 1.0, 3, 2, cells="quadrilaterals"),
}
AGGLOMERATES = {"agglomerates": agglomerated(triangulate(square(1.0), size=0.15), 12)}
# no point of it sees the whole of this U
U_SHAPE = PolyMesh(
    [[0, 0], [4, 0], [4, 3], [3, 3], [3, 1], [1, 1], [1, 3], [0, 3]],
    [0, 8],
    range(8),
    {"all": [0]},
    {"bottom": [[0, 1]]},
)


def named(mesh: PolyMesh) -> PolyMesh:
    """The mesh with two cell sets, and an edge set of its whole boundary."""
    left = mesh.cell_centroids[:, 0] < mesh.cell_centroids[:, 0].mean()
    whole = mesh.with_edge_set("rim", mesh.boundary_edges)
    return whole.with_cell_set("left", left).with_cell_set("right", ~left)


def chunkiness(mesh: PolyMesh) -> float:
    """Least radius of a cell's kernel over its diameter."""
    rows = np.split(mesh.points[mesh.cell_points], mesh.cell_offsets[1:-1])
    radii = np.array([kernel_centre(row)[1] for row in rows])
    return float((radii / mesh.cell_diameters).min())


def hanging(mesh: PolyMesh) -> int:
    """Most points that hang on a side of a cell inside the body."""
    sides = cell_sides(mesh)
    return int(np.bincount(sides.side, sides.hanging).max())


def rim_length(mesh: PolyMesh) -> float:
    ends = mesh.points[mesh.edge_set("rim")]
    return float(np.hypot(*(ends[:, 1] - ends[:, 0]).T).sum())


@settings.get_profile("costly")
@given(
    kind=st.sampled_from(sorted(BASES | AGGLOMERATES)),
    seed=st.integers(0, 2**31),
    share=st.floats(0.0, 1.0),
    most_hanging=st.sampled_from([None, 1, 2]),
)
def test_random_refinements_keep_area_orientation_and_sets(kind, seed, share, most_hanging):
    """After three random refinements cells are sound and fit together without a point unknown to a neighbour."""
    random = np.random.default_rng(seed)
    base = named((BASES | AGGLOMERATES)[kind])
    mesh = base
    for _ in range(3):
        mesh = refined(mesh, random.random(mesh.n_cells) < share, most_hanging=most_hanging)
    check(mesh, region_area=1.0, area_tolerance=1e-12, allow_hanging=False)
    assert mesh.n_points - mesh.n_edges + mesh.n_cells == 1
    for name in ("left", "right"):
        area, before = mesh.cell_areas[mesh.cell_set(name)].sum(), base.cell_areas[base.cell_set(name)].sum()
        assert area == pytest.approx(before, rel=1e-12)
    assert len(mesh.cell_set("left")) + len(mesh.cell_set("right")) == mesh.n_cells
    assert rim_length(mesh) == pytest.approx(4.0, rel=1e-12)
    assert len(mesh.edge_set("rim")) == len(mesh.boundary_edges)
    if most_hanging is not None:
        assert hanging(mesh) <= most_hanging


def test_a_cell_beside_a_refined_one_gets_a_point_and_no_more():
    """Of two squares one is refined: four squares, and a pentagon of the same area with its other points."""
    mesh = rectangle_grid(2.0, 1.0, 2, 1, cells="quadrilaterals")
    fine = refined(mesh, [0])
    assert sorted(fine.cell_sizes.tolist()) == [4, 4, 4, 4, 5]
    assert fine.cell_areas.tolist() == [0.25, 0.25, 0.25, 0.25, 1.0]
    assert fine.n_points == mesh.n_points + 5
    check(fine, region_area=2.0)


def test_a_hanging_point_divides_the_side_it_hangs_on():
    """Refined one after the other, two squares make the mesh that they make together."""
    mesh = rectangle_grid(2.0, 1.0, 2, 1, cells="quadrilaterals")
    fine = refined(refined(mesh, [0]), [4])
    assert fine.cell_sizes.tolist() == [4] * 8
    both = refined(mesh)
    assert sorted(map(tuple, fine.points.tolist())) == sorted(map(tuple, both.points.tolist()))


@pytest.mark.parametrize("kind", sorted(BASES))
def test_cells_stay_well_shaped_towards_a_corner(kind):
    """Ten refinements towards a corner: the worst cell is at most half as good as after one, and sides stay few."""
    mesh = BASES[kind]
    first = chunkiness(refined(mesh))
    for _ in range(10):
        near = np.hypot(*(mesh.cell_centroids - mesh.points.min(axis=0)).T) < 1.5 * mesh.cell_diameters
        mesh = refined(mesh, near, most_hanging=1)
    assert chunkiness(mesh) > 0.5 * first
    assert mesh.cell_sizes.max() <= 12
    assert mesh.cell_diameters.min() < 1e-3


def test_the_limit_bounds_hanging_points_and_its_absence_does_not():
    """A square beside one that is refined five times towards it gets 31 points, or is refined itself."""
    free = limited = rectangle_grid(2.0, 1.0, 2, 1, cells="quadrilaterals")
    for _ in range(5):
        free = refined(free, free.cell_centroids[:, 0] < 1.0)
        limited = refined(limited, limited.cell_centroids[:, 0] < 1.0, most_hanging=1)
    assert hanging(free) == 31
    assert hanging(limited) == 1
    assert limited.n_cells > free.n_cells


def test_a_cell_that_no_point_sees_whole_is_cut_into_round_parts():
    """A U becomes parts of about half its diameter, without notches; its names stay."""
    once = refined(U_SHAPE)
    assert once.cell_diameters.max() <= 0.55 * U_SHAPE.cell_diameters[0]
    assert chunkiness(once) > 0.1
    twice = refined(once)
    check(twice, region_area=8.0)
    assert chunkiness(twice) > 0.1
    assert len(twice.cell_set("all")) == twice.n_cells
    assert len(twice.edge_set("bottom")) == 4


L_SHAPE = polygon([(-1, -1), (0, -1), (0, 0), (1, 0), (1, 1), (-1, 1)])
ANY_POLYGONS = {
    "agglomerates in an L": (lambda: agglomerated(triangulate(L_SHAPE, size=0.2), 15), 0.08),
    "duals in an L": (lambda: dual(triangulate(L_SHAPE, size=0.5)), 0.08),
    "voronoi": (lambda: voronoi(square(1.0), 30, iterations=0), 0.02),
}


@pytest.mark.parametrize("kind", sorted(ANY_POLYGONS))
def test_diameters_of_any_polygons_halve_and_roundness_stays(kind):
    """Each refinement takes the maximum diameter to 0.55; kernels keep 0.08 of diameters (with short edges 0.02)."""
    make, floor = ANY_POLYGONS[kind]
    mesh = make()
    area = mesh.cell_areas.sum()
    for _ in range(3):
        fine = refined(mesh)
        assert fine.cell_diameters.max() <= 0.55 * mesh.cell_diameters.max()
        check(fine, region_area=area, area_tolerance=1e-10)
        mesh = fine
        if mesh.n_cells < 400:
            assert chunkiness(mesh) > floor
    # area over squared diameter of a square is a half
    assert (mesh.cell_areas / mesh.cell_diameters**2).min() > floor


@pytest.mark.parametrize("kind", ["triangles", "polygons"])
def test_points_on_arcs_make_the_area_converge(kind):
    """With the outline of a disc every refinement leaves a quarter of the missing area, without it all of it.

    The first is left out: it divides the sides of dual polygons at the points that they have.
    """
    outline = circle(1.0)
    mesh = triangulate(outline, size=1.5)
    mesh = mesh if kind == "triangles" else dual(mesh)
    straight, missing = mesh, []
    for _ in range(4):
        mesh, straight = refined(mesh, outline=outline), refined(straight)
        missing.append(np.pi - mesh.cell_areas.sum())
    check(mesh)
    np.testing.assert_allclose(np.hypot(*mesh.points[np.unique(mesh.boundary_edges)].T), 1.0, rtol=1e-12)
    assert np.all(np.array(missing[1:-1]) / missing[2:] > 3.5)
    assert np.pi - straight.cell_areas.sum() > 100 * missing[-1]


SQUARES = rectangle_grid(1.0, 1.0, 2, 2, cells="quadrilaterals")


@pytest.mark.parametrize(
    ("make", "word"),
    [
        (lambda: refined(SQUARES, [9]), "cell numbers from 0"),
        (lambda: refined(SQUARES, [-1]), "cell numbers from 0"),
        (lambda: refined(SQUARES, [0.5]), "float64"),
        (lambda: refined(SQUARES, [True]), "bool"),
        (lambda: refined(SQUARES, [0], most_hanging=0), "1 or more"),
        (lambda: doerfler_marking([-1.0], 0.5), "zero or more"),
        (lambda: doerfler_marking([np.nan], 0.5), "finite"),
        (lambda: doerfler_marking([], 0.5), "one number"),
        (lambda: doerfler_marking([1.0], 0.0), "above 0"),
    ],
)
def test_wrong_cells_limits_errors_and_shares_are_refused(make, word):
    """Numbers out of range or that are none, masks of another length, a limit of zero, negative and missing errors."""
    with pytest.raises(InputError, match=word):
        make()


@given(
    errors=st.lists(st.floats(0.0, 1e3), min_size=1, max_size=30),
    share=st.floats(0.01, 1.0),
)
def test_marking_takes_the_fewest_cells_that_hold_the_share(errors, share):
    """The marked squares reach the share of the sum, and without the smallest of them they do not."""
    squares = np.array(errors) ** 2
    marked = doerfler_marking(errors, share)
    if squares.sum() == 0.0:
        assert not len(marked)
        return
    assert squares[marked].sum() >= share * squares.sum() * (1.0 - 1e-9)
    assert squares[marked].sum() - squares[marked].min() < share * squares.sum()
