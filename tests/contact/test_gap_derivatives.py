"""Gap kinematics against finite differences and simple geometry."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from flangeway.contact.kinematics import closest_parameters, node_edge_gaps, shape_functions
from flangeway.elements.quadrature import gauss_lobatto

STEP = 1e-5


def edge(order: int) -> np.ndarray:
    """A bent edge of some order about (0, 0) to (3, 0.2), its body above."""
    position = gauss_lobatto(order + 1)[0]
    return np.stack((3.0 * position, 0.2 * position - 0.3 * position * (1.0 - position)), axis=1)


def stacked(configuration: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    points = configuration.reshape(-1, 2)
    return points[:1], points[None, 1:]


@pytest.mark.parametrize("height", [-0.4, -0.01, 0.3])
@pytest.mark.parametrize("order", [1, 2, 3])
def test_first_and_second_derivatives_of_the_gap(order: int, height: float) -> None:
    """Gradient and Hessian of the gap agree with central differences to 1e-7, for any order of the edge."""
    configuration = np.concatenate(([[1.3, height]], edge(order))).ravel()
    exact = node_edge_gaps(*stacked(configuration))
    gradient, hessian = [], []
    for direction in np.eye(len(configuration)):
        ahead = node_edge_gaps(*stacked(configuration + STEP * direction))
        behind = node_edge_gaps(*stacked(configuration - STEP * direction))
        gradient.append((ahead.gaps[0] - behind.gaps[0]) / (2.0 * STEP))
        hessian.append((ahead.gradients - behind.gradients).ravel() / (2.0 * STEP))
    assert np.abs(gradient - exact.gradients.ravel()).max() < 1e-7
    assert np.abs(hessian - exact.hessians[0]).max() < 1e-7


def test_the_sign_of_the_gap() -> None:
    """A node below an edge whose body lies above is outside of it: gap positive, normal down."""
    edges = np.array([[[0.0, 0.0], [1.0, 0.0]]])
    gaps = node_edge_gaps(np.array([[0.4, -0.25]]), edges)
    assert gaps.gaps[0] == pytest.approx(0.25)
    assert gaps.normals[0] == pytest.approx([0.0, -1.0])
    assert node_edge_gaps(np.array([[0.4, 0.25]]), edges).gaps[0] == pytest.approx(-0.25)


@given(
    order=st.integers(1, 3),
    along=st.floats(0.05, 0.95),
    distance=st.floats(-0.3, 0.3),
)
def test_a_point_on_a_normal_projects_back(order: int, along: float, distance: float) -> None:
    """The closest point of a point on the normal of an edge is the foot of that normal."""
    nodes = edge(order)
    value, slope, _ = shape_functions(order, np.array([along]))
    tangent = slope[0] @ nodes
    normal = np.array([tangent[1], -tangent[0]]) / np.linalg.norm(tangent)
    point = value[0] @ nodes + distance * normal
    assert closest_parameters(point[None], nodes[None])[0] == pytest.approx(along, abs=1e-9)
    assert node_edge_gaps(point[None], nodes[None]).gaps[0] == pytest.approx(distance, abs=1e-9)
