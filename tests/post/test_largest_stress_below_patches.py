"""The von Mises stress of a patch was that below its centre of pressure, half of the maximum or less."""

import numpy as np
import pytest

from flangeway.cases.wheelset.spatial_wheelset_case import SpatialWheelsetCase
from flangeway.cases.wheelset.wheelset_quantities import PatchResult
from flangeway.exact.half_space_stresses import half_space_stresses
from flangeway.post.patch_stresses import stress_field


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


@pytest.mark.ci
def test_a_wheelset_prints_the_maximum_below_a_patch_with_two_peaks() -> None:
    """S1002 on 60E1, 200 kN, 2 mm aside: 353 MPa below the centre on the right, 634 MPa beside it."""
    case = SpatialWheelsetCase.from_values(
        {"lateral_mm": 2.0, "size_scale": 6.0, "order": 1, "rail_support": "continuous"}
    )
    run = case.run()
    numbers = next(each for each in run.patches if each.patch.side == "right")
    patch = next(each for each in run.result.patches if each.side == "right")
    grid, found = patch.state.grid.grid, patch.field("rail").max_von_mises
    s, depth, along = found.position
    near = [(s + 0.1 * i, along) for i in range(-2, 3)]
    values = by_cells(grid.cells, grid.z, patch.state.cells.pressures, near, depth + 0.1 * np.arange(-2, 3), 0.3)[0]
    assert found.value == pytest.approx(values.max(), rel=0.01)
    assert isinstance(numbers, PatchResult)
    highest, _, rail = numbers.maximum("rail", "max_von_mises")
    assert highest == pytest.approx(634.0, rel=0.05)
    assert numbers.below_centre("rail")[0] < 0.65 * highest
    # the point lies below the rail's surface, on its normal, and the wheel's as far above
    wheel = numbers.maximum("wheel", "max_von_mises")[2]
    assert np.linalg.norm(rail - wheel) == pytest.approx(2.0 * depth, rel=1e-6)
    assert rail[1] < patch.centre_mm[1] < wheel[1]
