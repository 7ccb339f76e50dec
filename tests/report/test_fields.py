"""Displacements and stresses in the axes of space."""

import numpy as np
import pytest

from flangeway.geometry import Placement
from flangeway.post import Stresses
from flangeway.report import part_fields
from flangeway.report.figures.series import placed_stresses
from flangeway.report.viewer.scene_model import DISPLACEMENT

ROWS = np.array([[120.0, -40.0, 25.0, 24.0], [0.0, 0.0, -70.0, 0.0]])


def plane(row):
    return np.array([[row[0], row[2]], [row[2], row[1]]])


@pytest.mark.parametrize("mirrored", [False, True])
def test_tractions_turn_with_the_body(mirrored):
    """A placed stress gives on a placed normal the placed traction, also under a mirror; invariants stay."""
    placement = Placement(0.3, (5.0, -2.0), mirrored)
    moved = placed_stresses(Stresses(ROWS), placement)
    normal = np.array([0.6, 0.8])
    for before, after in zip(ROWS, moved.components, strict=True):
        expected = placement.vectors([plane(before) @ normal])[0]
        assert np.allclose(plane(after) @ placement.vectors([normal])[0], expected, atol=1e-12)
    assert np.allclose(moved.principal, Stresses(ROWS).principal, atol=1e-12)
    assert np.allclose(moved.von_mises, Stresses(ROWS).von_mises, atol=1e-12)


def test_left_parts_mirror_the_right_ones(runs):
    """The left part's points, displacements and stresses are the right one's, reflected about the track's middle."""
    parts = {part.name: part for part in part_fields(runs["vem"].result)}
    assert list(parts) == ["wheel-left", "rail-left", "wheel-right", "rail-right"]
    for body in ("wheel", "rail"):
        left, right = parts[f"{body}-left"], parts[f"{body}-right"]
        assert left.mesh.points[:, 0].max() < 0.0 < right.mesh.points[:, 0].min()
        assert np.allclose(left.mesh.points * (-1, 1), right.mesh.points, atol=1e-8)
        assert np.allclose(left.point_arrays[DISPLACEMENT] * (-1, 1), right.point_arrays[DISPLACEMENT], atol=1e-8)
        signs = (1, 1, -1, 1)
        of_left, of_right = (part.cell_arrays["stresses"] for part in (left, right))
        assert np.allclose(of_left * signs, of_right, atol=1e-6 * np.abs(of_right).max())
        assert (left.mesh.cell_areas > 0.0).all()
