"""Placements against the group of rigid motions and reflections."""

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from flangeway.geometry import Placement

NUMBERS = st.floats(-100.0, 100.0)
PLACEMENTS = st.builds(Placement, st.floats(-7.0, 7.0), st.tuples(NUMBERS, NUMBERS), st.booleans())
POINTS = np.array([[0.0, 0.0], [1.0, 0.0], [3.0, -2.0]])


def test_mirror_acts_before_rotation():
    """A mirrored quarter turn brings (1, 0) over (-1, 0) to (0, -1)."""
    placement = Placement(math.pi / 2, (10.0, 0.0), mirrored=True)
    np.testing.assert_allclose(placement.points([(1.0, 0.0)]), [(10.0, -1.0)], atol=1e-15)
    np.testing.assert_allclose(placement.vectors([(1.0, 0.0)]), [(0.0, -1.0)], atol=1e-15)


@given(PLACEMENTS)
def test_inverse_undoes(placement):
    """A placement followed by its inverse leaves points where they were."""
    back = placement.inverse().points(placement.points(POINTS))
    np.testing.assert_allclose(back, POINTS, atol=1e-12)


@given(PLACEMENTS, PLACEMENTS)
def test_composition_is_one_after_the_other(first, second):
    """The composition of two placements acts like both in turn."""
    both = second.after(first)
    np.testing.assert_allclose(both.points(POINTS), second.points(first.points(POINTS)), atol=1e-11)


@given(PLACEMENTS)
def test_matrix_is_orthogonal_with_the_sign_of_the_mirror(placement):
    """The linear part keeps lengths; it turns the orientation if and only if mirrored."""
    np.testing.assert_allclose(placement.matrix @ placement.matrix.T, np.eye(2), atol=1e-15)
    assert np.linalg.det(placement.matrix) == pytest.approx(-1.0 if placement.mirrored else 1.0)


def test_rotation_about_a_point_keeps_it():
    """A rotation about a point moves others and not that one."""
    turn = Placement.about((3.0, 4.0), 1.2)
    np.testing.assert_allclose(turn.points([(3.0, 4.0)]), [(3.0, 4.0)], atol=1e-14)
    assert turn.rotation_rad == 1.2
