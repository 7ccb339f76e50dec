"""A spline is closed if its ends agree up to round-off."""

import numpy as np
import pytest

from flangeway import triangulate
from flangeway.geometry import Outline, Placement, Spline, polygon, square
from flangeway.mesh import PolyMesh


def hole(n: int, closing: float) -> tuple[Outline, Spline]:
    """A polygon on the unit circle, and the spline through its corners with a gap at its end."""
    angle = np.linspace(0.0, 2.0 * np.pi, n + 1)
    points = np.column_stack((np.cos(angle), np.sin(angle)))
    points[-1] = points[0] + (0.0, closing)
    return polygon(points[:-1]), Spline(points)


@pytest.mark.parametrize("gap", [0.0, 1.1e-16, -2.4e-16, 1e-13])
def test_ends_that_differ_by_round_off(gap: float) -> None:
    """No edge of the mesh leaves the circle by more than the spline does, where one ran through the hole."""
    corners, spline = hole(24, gap)
    assert spline.closed
    mesh: PolyMesh = triangulate(square(6.0), size=0.8, holes=[corners], outline=[square(6.0), spline])
    assert mesh.curves is not None
    assert np.linalg.norm(mesh.curves.points([0.25, 0.5, 0.75]), axis=2) == pytest.approx(1.0, abs=2e-5)


def test_a_moved_spline_stays_closed() -> None:
    """Far from the origin, where placed ends may differ in their last digits, it is closed too."""
    _, spline = hole(9, 0.0)
    for angle in np.linspace(0.1, 6.0, 7):
        assert spline.transformed(Placement(float(angle), (1e3, -3e3))).closed


def test_a_true_gap_is_open() -> None:
    """A gap above round-off is a gap."""
    assert not hole(9, 1e-9)[1].closed
