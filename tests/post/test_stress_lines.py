"""Stresses and displacements at points, along lines and through cuts, and what is derived from stresses."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from flangeway import quantities
from flangeway.cases.case_file import load_case
from flangeway.cases.wheelset.wheelset_quantities import PATCH
from flangeway.elements import Lagrange, Virtual
from flangeway.exact.half_space import half_space_stresses
from flangeway.geometry import square
from flangeway.materials import Elastic
from flangeway.mesh import PolyMesh, dual, rectangle_grid, triangulate
from flangeway.post import (
    Stresses,
    cell_stresses,
    displacements_at,
    force_through_cut,
    locate,
    nodal_stresses,
    stresses_along,
    stresses_at,
)
from flangeway.post.patch_stresses import stress_field
from flangeway.problems import Elasticity, PrescribedDisplacement, Pressure
from flangeway.solve import solve_elasticity
from flangeway.space import Space
from tests.given_displacement import solved

MATERIAL = Elastic(100.0, 0.3)
POLYGONS = dual(triangulate(square(1.0), size=0.15))


def quadratic(points: np.ndarray) -> np.ndarray:
    """A displacement whose stress is in equilibrium without a body force."""
    x, y = points.T
    return 1e-2 * np.stack((x * y, -0.5 * x**2 - 0.5 * y**2 * 0.3 / 0.7), axis=1)


def bending_stress(points: np.ndarray) -> np.ndarray:
    """Pure bending: xx is linear in y, yy and xy are none."""
    y = points[:, 1]
    xx = 100.0 / (1.0 - 0.09) * 1e-2 * y
    return np.stack((xx, 0.0 * y, 0.0 * y, 0.3 * xx), axis=1)


@given(st.lists(st.tuples(st.floats(-0.7, 0.7), st.floats(-0.7, 0.7)), min_size=1, max_size=20))
def test_points_are_found_in_their_cells(points: list) -> None:
    """A located cell holds its point on the left of all its edges, and exactly the points outside have none."""
    given_points = np.array(points)
    cells = locate(POLYGONS, given_points)
    outside = (np.abs(given_points) > 0.5).any(axis=1)
    assert np.array_equal(cells < 0, outside)
    for point, cell in zip(given_points[~outside], cells[~outside], strict=True):
        corners = POLYGONS.points[POLYGONS.cell_points[POLYGONS.cell_offsets[cell] : POLYGONS.cell_offsets[cell + 1]]]
        a, b = corners - point, np.roll(corners, -1, axis=0) - point
        areas = a[:, 0] * b[:, 1] - a[:, 1] * b[:, 0]
        assert areas.min() > -1e-9


def test_cells_that_are_not_convex_are_told_apart() -> None:
    """A point in the notch of an L belongs to the square that fills it."""
    points = np.array([[0, 0], [2, 0], [2, 1], [1, 1], [1, 2], [0, 2], [2, 2]], dtype=np.float64)
    mesh = PolyMesh(points, np.array([0, 6, 10]), np.array([0, 1, 2, 3, 4, 5, 3, 2, 6, 4]))
    assert locate(mesh, [[1.5, 1.5], [0.5, 1.5], [1.5, 0.5], [2.5, 0.5]]).tolist() == [1, 0, 0, -1]


@pytest.mark.parametrize(
    ("mesh", "element"), [(triangulate(square(1.0), size=0.3), Lagrange(2)), (POLYGONS, Virtual(2))]
)
def test_pure_bending_everywhere(mesh: PolyMesh, element) -> None:
    """Order 2 has the stresses and displacements of pure bending at points, on a line, at nodes, and cells' means."""
    solution = solved(Space(mesh, element), MATERIAL, quadratic)
    points = np.random.default_rng(2).uniform(-0.5, 0.5, (50, 2))
    assert stresses_at(solution, points).components == pytest.approx(bending_stress(points), abs=1e-9)
    assert displacements_at(solution, points) == pytest.approx(quadratic(points), abs=1e-12)
    means = cell_stresses(solution.problem, solution.displacements).components
    assert means == pytest.approx(bending_stress(mesh.cell_centroids), abs=1e-9)
    line = stresses_along(solution, (0.1, -0.5), (0.1, 0.7), 13)
    inside = line.points[:, 1] < 0.5 + 1e-12
    assert line.distances == pytest.approx(np.linspace(0.0, 1.2, 13))
    assert line.stresses.components[inside] == pytest.approx(bending_stress(line.points[inside]), abs=1e-9)
    assert np.isnan(line.stresses.components[~inside]).all()
    assert inside.sum() == 11
    used = np.unique(mesh.cell_points)
    assert nodal_stresses(solution).components[used] == pytest.approx(bending_stress(mesh.points[used]), abs=1e-9)


def test_a_cut_carries_the_bending_moment() -> None:
    """The force through any straight cut of pure bending has the moment of the linear stress, oblique or not."""
    solution = solved(Space(POLYGONS, Virtual(2)), MATERIAL, quadratic)
    moment = -100.0 / 0.91 * 1e-2 / 12.0
    for top in (0.1, 0.35):
        cut = force_through_cut(solution, (0.1, -0.6), (top, 0.6))
        assert cut.force == pytest.approx([0.0, 0.0], abs=1e-9)
        assert cut.moment == pytest.approx(moment)
    straight, back = (
        force_through_cut(solution, *ends) for ends in (((0.1, 0.0), (0.1, 0.6)), ((0.1, 0.6), (0.1, 0.0)))
    )
    assert straight.length == pytest.approx(0.5)
    assert straight.force[0] == pytest.approx(100.0 / 0.91 * 1e-2 * 0.125)
    assert back.force == pytest.approx(-straight.force)


def test_a_cut_of_a_ring_counts_the_circumference() -> None:
    """A horizontal cut of a pressed tube carries the pressure times its area, seen from below."""
    problem = Elasticity(
        Space(dual(rectangle_grid(1.0, 1.0, 6, 6, origin=(1.0, 0.0))), Virtual(2)),
        Elastic(100.0, 0.3, "axisymmetric"),
        loads=[Pressure("top", 2.0)],
        supports=[PrescribedDisplacement("bottom", y=0.0)],
    )
    cut = force_through_cut(solve_elasticity(problem), (3.0, 0.4), (0.0, 0.4))
    assert cut.force[1] == pytest.approx(-2.0 * np.pi * 3.0)


def test_invariants_of_known_states() -> None:
    """Uniaxial tension, pure shear and hydrostatic pressure have the textbook's invariants."""
    states = Stresses(np.array([[100.0, 0.0, 0.0, 0.0], [0.0, 0.0, 40.0, 0.0], [-7.0, -7.0, 0.0, -7.0]]))
    assert states.von_mises == pytest.approx([100.0, 40.0 * np.sqrt(3.0), 0.0])
    assert states.in_plane_shear == pytest.approx([50.0, 40.0, 0.0])
    assert states.principal == pytest.approx(np.array([[100.0, 0.0, 0.0], [40.0, 0.0, -40.0], [-7.0, -7.0, -7.0]]))


def test_principal_stresses_are_eigenvalues() -> None:
    """For random states the principal stresses are the eigenvalues of the tensor, zz included."""
    components = np.random.default_rng(0).normal(size=(50, 4))
    for row, principal in zip(components, Stresses(components).principal, strict=True):
        tensor = np.array([[row[0], row[2], 0.0], [row[2], row[1], 0.0], [0.0, 0.0, row[3]]])
        assert np.linalg.eigvalsh(tensor)[::-1] == pytest.approx(principal)


def by_cells(ends, z, pressures, columns, depths, poisson):
    """Von Mises and Tresca stress at columns (k, 2) and depths, by the sum over all cells."""
    strips = np.stack((z, z), axis=1) + (z[1] - z[0]) * np.array([-0.5, 0.5])
    points = np.array([(x, depth, y) for x, y in columns for depth in depths])
    found = half_space_stresses(ends, strips, pressures, points, poisson)
    low, middle, high = np.linalg.eigvalsh(found[:, [[0, 3, 5], [3, 1, 4], [5, 4, 2]]]).T
    mises = np.sqrt(((low - middle) ** 2 + (middle - high) ** 2 + (high - low) ** 2) / 2.0)
    return mises, high - low


def two_peaks():
    """Pressures of an uneven patch: a broad low peak and a narrow high one beside it."""
    ends = np.linspace(-8.0, 8.0, 41)
    ends, z = np.stack((ends[:-1], ends[1:]), axis=1), np.linspace(-6.0, 6.0, 21)
    x, y = np.meshgrid(ends.mean(axis=1), z, indexing="ij")
    broad = 500.0 * np.sqrt(np.maximum(1.0 - ((x + 2.0) / 5.5) ** 2 - (y / 5.0) ** 2, 0.0))
    narrow = 1100.0 * np.sqrt(np.maximum(1.0 - ((x - 4.5) / 1.6) ** 2 - (y / 5.0) ** 2, 0.0))
    return ends, z, broad + narrow


def test_the_maximum_below_a_patch_with_two_peaks_is_that_of_the_sum_over_its_cells() -> None:
    """Von Mises and Tresca maxima are within 1 % of sums on 0.1 mm, far above those below the centre."""
    ends, z, pressures = two_peaks()
    depths = np.append(0.0, np.geomspace(0.2, 10.0, 40))
    field = stress_field(ends, z, pressures[..., None], pressures > 0.0, depths, 0.3)
    for found, number in ((field.max_von_mises, 0), (field.max_tresca, 1)):
        s, depth, along = found.position
        near = [(s + 0.1 * i, along) for i in range(-4, 5)]
        values = by_cells(ends, z, pressures, near, depth + 0.1 * np.arange(-3, 4), 0.3)
        assert found.value == pytest.approx(values[number].max(), rel=0.01)
    centre = float(pressures.sum(axis=1) @ ends.mean(axis=1) / pressures.sum())
    below = by_cells(ends, z, pressures, [(centre, 0.0)], depths[5:], 0.3)[0].max()
    assert field.max_von_mises.value > 1.3 * below
    # nowhere else is there more: columns of 1 mm over the whole patch
    columns = [(x, y) for x in np.arange(-7.5, 8.0) for y in (0.0, 2.0, 4.0)]
    mises, _ = by_cells(ends, z, pressures, columns, (0.5, 1.0, 2.0, 4.0), 0.3)
    assert mises.max() < 1.01 * field.max_von_mises.value


def test_tension_is_greatest_at_the_edge_of_a_circular_patch() -> None:
    """At the edge of a Hertzian circle the radial tension at the surface is (1 - 2 nu) p0 / 3, within a cell."""
    ends = np.linspace(-1.5, 1.5, 61)
    ends, z = np.stack((ends[:-1], ends[1:]), axis=1), np.linspace(-1.475, 1.475, 60)
    x, y = np.meshgrid(ends.mean(axis=1), z, indexing="ij")
    pressures = np.sqrt(np.maximum(1.0 - x**2 - y**2, 0.0))
    field = stress_field(ends, z, pressures[..., None], pressures > 0.0, np.linspace(0.0, 2.0, 81), 0.3)
    tension = field.max_tension
    assert tension.value == pytest.approx(0.4 / 3.0, rel=0.06)
    assert np.hypot(tension.position[0], tension.position[2]) == pytest.approx(1.0, abs=0.06)
    assert tension.position[1] == 0.0
    # Johnson (1985, 3.4): the maximum shear stress 0.31 p0 and von Mises stress 0.62 p0 at a depth of 0.48 a
    assert field.max_tresca.value == pytest.approx(0.62, rel=0.005)
    assert field.max_von_mises.value == pytest.approx(0.62, rel=0.005)
    assert field.max_tresca.position[1] == pytest.approx(0.48, abs=0.03)


def test_uneven_cells_of_two_patches_carry_their_whole_load() -> None:
    """Far below, two patches with cells of different widths act as their resultants."""
    left, right = np.linspace(0.0, 2.0, 11), np.linspace(2.5, 4.0, 21)
    ends = np.concatenate([np.stack((each[:-1], each[1:]), axis=1) for each in (left, right)])
    z, pressures = np.linspace(-1.0, 1.0, 11), np.zeros((30, 11))
    pressures[2:9, 3:8], pressures[14:27, 3:8] = 300.0, 700.0
    inside = np.zeros_like(pressures, dtype=bool)
    inside[2:9, 3:8] = True
    depth = np.array([0.0, 5.0, 20.0])
    field = stress_field(ends, z, pressures[..., None], inside, depth, 0.3)
    columns = np.stack(np.meshgrid(field.along, field.z, indexing="ij"), axis=-1).reshape(-1, 2)
    mises = by_cells(ends, z, pressures, columns[::7], depth[1:], 0.3)[0].reshape(-1, 2)
    assert field.von_mises[1:].reshape(2, -1).T[::7] == pytest.approx(mises, rel=2e-3)


@pytest.mark.parametrize("force_of_other", [1.0, 1e3])
def test_a_narrow_patch_far_from_another_one_has_the_stresses_of_both(force_of_other) -> None:
    """To 0.1 % of its maximum pressure, under a light patch and under a heavy one 60 mm away."""
    narrow, wide = np.linspace(0.0, 0.4, 9), np.linspace(60.0, 64.0, 9)
    ends = np.concatenate([np.stack((each[:-1], each[1:]), axis=1) for each in (narrow, wide)])
    z, pressures = 0.5 * np.arange(120.0), np.zeros((16, 120))
    pressures[:8, 2:8], pressures[8:, 90:100] = 1000.0, 5.0 * force_of_other
    inside = np.zeros_like(pressures, dtype=bool)
    inside[:8, 2:8] = True
    depths = np.array([0.1, 0.4, 2.0])
    field = stress_field(ends, z, pressures[..., None], inside, depths, 0.3)
    columns = np.stack(np.meshgrid(field.along, field.z, indexing="ij"), axis=-1).reshape(-1, 2)[::5]
    mises = by_cells(ends, z, pressures, columns, depths, 0.3)[0].reshape(-1, 3)
    assert field.von_mises.reshape(3, -1).T[::5] == pytest.approx(mises, abs=1.0)
    assert len(field.z) == 6 + 2 * 3


@pytest.mark.ci
def test_a_wheelset_prints_the_maximum_below_a_patch_with_two_peaks() -> None:
    """S1002 on 60E1, 200 kN, 2 mm aside: 353 MPa below the centre on the right, 634 MPa beside it."""
    mesh = {"size_scale": 6.0, "order": 1}
    case = load_case("wheelset", lateral_mm=2.0, mesh=mesh, support="continuous", gauge_at="narrowest")
    run = case.run()
    patch = next(each for each in run.result.patches if each.side == "right")
    grid, found = patch.state.grid.grid, patch.stress_fields["rail"].max_von_mises
    s, depth, along = found.position
    near = [(s + 0.1 * i, along) for i in range(-2, 3)]
    values = by_cells(grid.cells, grid.along, patch.cells.pressures, near, depth + 0.1 * np.arange(-2, 3), 0.3)[0]
    assert found.value == pytest.approx(values.max(), rel=0.01)
    numbers = quantities.values(PATCH, patch)
    highest, rail = numbers["in_rail_max_von_mises_MPa"], np.array(numbers["in_rail_max_von_mises_position_mm"])
    assert highest == pytest.approx(634.0, rel=0.05)
    assert numbers["von_mises_below_centre_MPa"] < 0.65 * highest
    # the point lies below the rail's surface, on its normal, and the wheel's as far above
    wheel = np.array(numbers["in_wheel_max_von_mises_position_mm"])
    assert np.linalg.norm(rail - wheel) == pytest.approx(2.0 * depth, rel=1e-6)
    assert rail[1] < patch.centre_mm[1] < wheel[1]
