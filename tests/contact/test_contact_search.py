"""Pairing of nodes and edges: nothing missed, nothing hopping."""

import numpy as np

from flangeway.contact import NodeToSegment

CHAIN = np.array([[0, 1], [1, 2]])


def flat_edges(breaks: np.ndarray) -> np.ndarray:
    """Edges along y = 0 from right to left, so that their body is below and they face up."""
    points = np.stack((breaks[::-1], np.zeros(len(breaks))), axis=1)
    return np.stack((points[:-1], points[1:]), axis=1)


def test_a_pair_is_kept_a_little_beyond_its_edge() -> None:
    """Within the slack a node stays with its edge; beyond it takes the neighbour."""
    edges = flat_edges(np.array([0.0, 1.0, 2.0]))
    nodes = np.array([[2.5, -0.01], [0.99, -0.01], [-0.5, -0.01]])[::-1]
    pairing = NodeToSegment(slack=0.02)
    kept = np.array([-1, 0, -1])
    found, facing, _ = pairing.find(nodes, CHAIN, edges, kept)
    assert facing[found == 1] == 0
    nodes[1, 0] = 0.97
    found, facing, _ = pairing.find(nodes, CHAIN, edges, kept)
    assert facing[found == 1] == 1


def test_nodes_out_of_reach_take_no_part() -> None:
    """A gap larger than the reach, or a foot beyond the chain, makes no pair."""
    edges = flat_edges(np.array([0.0, 1.0, 2.0]))
    nodes = np.array([[0.5, 0.2], [1.5, 5.0], [2.7, 0.1]])
    found, _, _ = NodeToSegment().find(nodes, CHAIN, edges, np.full(3, -1))
    assert found.tolist() == [0]


def test_the_dead_angle_of_a_corner_is_bridged() -> None:
    """An open node below a convex corner, beyond the ends of both edges, still has a pair."""
    points = np.array([[1.0, -0.02], [0.0, 0.0], [-1.0, -0.02]])
    edges = np.stack((points[:-1], points[1:]), axis=1)
    found, _, _ = NodeToSegment().find(np.array([[1e-9, 2.0]]), np.array([[0, 0]]), edges, np.array([-1]))
    assert found.tolist() == []  # without a chain there is no direction to face
    nodes = np.array([[0.5, 2.5], [0.0, 2.0], [-0.5, 2.5]])[::-1]
    found, _, _ = NodeToSegment().find(nodes, CHAIN, edges, np.full(3, -1))
    assert 1 in found
