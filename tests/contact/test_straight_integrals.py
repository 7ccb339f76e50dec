"""The closed form for straight edges beside quadrature, which serves edges of any order."""

import numpy as np
import pytest

from flangeway.contact.edge_pieces import Pieces, _distances, find_pieces, integrate


@pytest.fixture
def edges() -> tuple[np.ndarray, np.ndarray]:
    """Secondary edges, and primary ones near them that run against them, with bodies on the left."""
    rng = np.random.default_rng(3)
    start = np.array([[0.0, 0.0], [0.25, 0.0]])
    secondary = start + rng.normal(scale=0.02, size=(500, 2, 2))
    along = rng.uniform(-0.1, 0.3, size=500)
    primary = np.stack((np.stack((along + 0.1, 0.0 * along), axis=1), np.stack((along - 0.15, 0.0 * along), axis=1)), 1)
    return secondary, primary + rng.normal(scale=0.02, size=(500, 2, 2))


def found(edges: tuple[np.ndarray, np.ndarray]) -> Pieces:
    numbers = np.arange(len(edges[0]))
    return find_pieces(*edges, (numbers, numbers), 0.05, 0.03)


def test_integrals_and_derivatives_are_those_of_quadrature(edges: tuple[np.ndarray, np.ndarray]) -> None:
    """Values, first derivatives, covered lengths and primary shapes agree to 1e-14 with those of quadrature."""
    pieces = found(edges)
    assert len(pieces) > 100
    assert 0.1 < pieces.start_is_foot.mean() < 0.9
    secondary, primary = edges[0][pieces.edges], edges[1][pieces.partners]
    lengths = np.linspace(0.2, 0.3, len(pieces))
    closed = integrate(pieces, secondary, primary, lengths, second=False)
    points = integrate(pieces, secondary, primary, lengths, second=True)
    np.testing.assert_allclose(closed.gaps, points.gaps, rtol=0.0, atol=1e-15)
    np.testing.assert_allclose(closed.gradients, points.gradients, rtol=0.0, atol=1e-14)
    np.testing.assert_allclose(closed.lengths, points.lengths, rtol=0.0, atol=1e-15)
    np.testing.assert_allclose(closed.primary_shapes, points.primary_shapes, rtol=0.0, atol=1e-15)


def test_pieces_within_reach_are_found(edges: tuple[np.ndarray, np.ndarray]) -> None:
    """Pieces of straight edges are those that are within reach and depth at their middle, and no others."""
    everything = find_pieces(*edges, (np.arange(500), np.arange(500)), np.inf, np.inf)
    middle = (everything.starts + everything.ends) / 2.0
    distance = _distances(edges[0][everything.edges], edges[1][everything.partners], middle)
    near = (distance < 0.05) & (distance > -0.03)
    assert 50 < near.sum() < len(near)
    np.testing.assert_array_equal(found(edges).edges, everything.edges[near])


def test_pieces_are_those_of_curved_edges(edges: tuple[np.ndarray, np.ndarray]) -> None:
    """A middle node makes an edge of order 2 of each, whose pieces are the same to 1e-12."""
    pieces = found(edges)
    curved = [np.stack((side[:, 0], side.mean(axis=1), side[:, 1]), axis=1) for side in edges]
    same = find_pieces(*curved, (np.arange(500), np.arange(500)), 0.05, 0.03)
    np.testing.assert_array_equal(pieces.edges, same.edges)
    np.testing.assert_array_equal(pieces.start_is_foot, same.start_is_foot)
    np.testing.assert_array_equal(pieces.end_is_foot, same.end_is_foot)
    np.testing.assert_allclose(pieces.starts, same.starts, atol=1e-12)
    np.testing.assert_allclose(pieces.ends, same.ends, atol=1e-12)
