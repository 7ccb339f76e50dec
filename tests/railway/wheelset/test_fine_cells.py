"""Fine cells of a side: what they cover, and that none is empty."""

from dataclasses import replace
from types import SimpleNamespace

import numpy as np

from flangeway.railway.wheelset.fine_cells import divided, finer
from flangeway.railway.wheelset.side_contact import GriddedSide, SideGrid, SideState, WheelPose
from flangeway.solve import Status


def state_of(cells, loaded, gaps=1.0):
    """Contact on cells (n, 2) of a flat surface, nine strips of 1 mm: even forces on loaded rows and inner strips."""
    forces = np.zeros((len(cells), 9))
    forces[np.ix_(loaded, range(1, 8))] = np.diff(cells, axis=1)[loaded]
    points, normals = np.column_stack((cells.mean(axis=1), np.zeros(len(cells)))), np.tile((0.0, 1.0), (len(cells), 1))
    surfaces = SimpleNamespace(rail_stations=np.array([[-50.0, -50.0], [50.0, 50.0]]), modulus=1e5)
    pose = WheelPose(0.0, 460.0, 0.0)
    grid = GriddedSide(surfaces, SideGrid(cells, 1.0, np.arange(-4, 5)), pose)
    gaps = np.where(forces > 0.0, 0.0, gaps)
    return SideState(grid, pose, Status(True, "", 0), forces, points, normals, None, gaps, np.zeros((3, 4)))


def covered(cells, low, high):
    """Length of an interval that cells cover."""
    return np.maximum(np.minimum(cells[:, 1], high) - np.maximum(cells[:, 0], low), 0.0).sum()


def test_a_narrow_patch_that_lies_in_the_cells_of_another_one_has_none_of_its_own():
    """A patch of 0.1 mm, 1.2 mm beside one of 8 mm whose cells are 1 mm wide: both covered, no cell empty or twice."""
    wide = np.stack((np.arange(10.0), np.arange(1.0, 11.0)), axis=1)
    cells = np.vstack((wide, [[10.1, 10.2], [10.2, 10.3], [10.3, 10.4]]))
    found = finer(state_of(cells, [*range(1, 9), 11]), 8).grid.cells
    assert (np.diff(found, axis=1) > 0.0).all()
    assert (np.diff(found.ravel()) > -1e-12).all()
    for low, high in ((1.0, 9.0), (10.2, 10.3)):
        assert np.isclose(covered(found, low, high), high - low)


def test_a_gap_within_reach_has_cells_before_it_closes():
    """What is 0.2 mm apart on coarse cells has cells where 0.3 mm is asked for, and none without."""
    cells = np.stack((np.arange(-20.0, 20.0), np.arange(-19.0, 21.0)), axis=1)
    gaps = np.full((40, 1), 1.0)
    gaps[34:37] = 0.2
    state = state_of(cells, range(5, 15), gaps)
    near, far = (finer(state, 26, None, state, within).grid.cells for within in (0.3, 0.1))
    assert np.isclose(covered(near, 14.0, 17.0), 3.0)
    assert covered(far, 14.0, 17.0) == 0.0


def test_cells_at_a_narrow_peak_are_divided_once():
    """Pressure of a patch of 30 mm with a parabola of 4 mm on it: cells of 1.25 mm are divided by four there, once."""
    ends = np.linspace(-20.0, 20.0, 33)
    even = np.stack((ends[:-1], ends[1:]), axis=1)

    def pressed(cells, peak):
        state = state_of(cells, np.flatnonzero(np.abs(cells.mean(axis=1)) < 15.0))
        s = state.grid.grid.stations
        pressure = 1.0 - (s / 16.0) ** 2 + peak * np.maximum(1.0 - (s / 2.0) ** 2, 0.0)
        return replace(state, forces=state.forces * pressure[:, None])

    smooth, first = pressed(even, 0.0), pressed(even, 4.0)
    assert divided(smooth, 20) is smooth.grid
    found = divided(first, 20).grid
    near = np.abs(found.stations) < 1.2
    assert np.allclose(found.widths[near], 1.25 / 4.0)
    assert np.allclose(found.widths[np.abs(found.stations) > 4.0], 1.25)
    again = pressed(found.cells, 4.0)
    assert divided(again, 20) is again.grid
