"""Corners pressed into flat faces without friction: statics gives the direction of the force."""

import numpy as np
import pytest

from benchmarks.pushed import Case


@pytest.mark.parametrize("number", [45, 254, 267])
def test_a_corner_presses_on_a_flat_face_along_its_normal(number: int) -> None:
    """A node of the face beside the corner is not pressed by the corner's other side, in 1 step as in 5.

    Without friction the angle between the force and the undeformed normal is the rotation of the face, below 0.02 rad.
    """
    case = Case.of(number)
    assert case.friction == 0.0
    forces = []
    for steps in (1, 5):
        solution = case.solve(steps)
        assert solution.status.converged, solution.status.message
        part = solution.system.contacts[0].secondary.part
        ((along, normal),) = part.placement.inverse().vectors(solution.forces)
        assert abs(along) <= 0.02 * normal
        forces.append(np.array([along, normal]))
    assert np.abs(forces[0] - forces[1]).max() <= 2e-3 * normal
