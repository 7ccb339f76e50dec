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
