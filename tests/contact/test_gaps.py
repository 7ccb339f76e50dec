"""Gaps of nodes and averaged gaps of segments: sign, projections, and exact derivatives."""

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from flangeway.contact.edge_pieces import PieceIntegrals, find_pieces
from flangeway.contact.kinematics import closest_parameters, node_edge_gaps, shape_functions
from flangeway.contact.search import candidate_pairs
from flangeway.elements.quadrature import gauss_lobatto


def chain(n_edges: int, order: int, length: float, height: float, bend: float, *, backwards: bool) -> np.ndarray:
    """Edges along x whose nodes lie on a parabola, shape (n_edges, order + 1, 2)."""
    ends = np.linspace(-length / 2, length / 2, n_edges + 1)
    parameters = gauss_lobatto(order + 1)[0]
    x = ends[:-1, None] + np.diff(ends)[:, None] * parameters
    points = np.stack((x, height + bend * x**2), axis=-1)
    return points[::-1, ::-1] if backwards else points


def pieces_between(secondary: np.ndarray, primary: np.ndarray):
    """Pieces of two chains, and the nodes' positions of each piece."""
    pieces = find_pieces(secondary, primary, candidate_pairs(secondary, primary, 1.0), 1.0, 1.0)
    return pieces, secondary[pieces.edges], primary[pieces.partners]


@pytest.mark.parametrize("revolved", [False, True], ids=["plane", "revolved"])
@pytest.mark.parametrize("orders", [(1, 1), (1, 2), (2, 1), (2, 2), (3, 2)])
def test_the_derivatives_of_integrated_gaps_are_exact(orders: tuple[int, int], revolved: bool) -> None:
    """First and second derivatives agree with central differences to 1e-7, moving ends of the pieces included.

    Those of bodies of revolution are weighted with a radius that varies along the edges.
    """
    secondary = chain(3, orders[0], 2.0, 0.05, 0.10, backwards=False)
    primary = chain(4, orders[1], 2.3, 0.0, -0.07, backwards=True)
    pieces, own, other = pieces_between(secondary, primary)
    assert (pieces.starts > 0.0).any()
    assert (pieces.ends < 1.0).any()
    lengths = np.full(len(pieces), 0.7)
    radii = np.tile((0.4, 1.9), (len(pieces), 1)) if revolved else None
    both = np.concatenate((own, other), axis=1)
    width = own.shape[1]

    def evaluate(positions: np.ndarray):
        # the ends of pieces move with the nodes
        a, b = positions[:, :width], positions[:, width:]
        starts = np.where(pieces.starts > 0.0, closest_parameters(b[:, -1], a), pieces.starts)
        ends = np.where(pieces.ends < 1.0, closest_parameters(b[:, 0], a), pieces.ends)
        return PieceIntegrals(replace(pieces, starts=starts, ends=ends), a, b, lengths, radii)

    exact = evaluate(both)
    hessians = [exact.hessians(np.broadcast_to(factors, (len(pieces), 2))) for factors in np.eye(2)]
    step = 1e-5
    for variable in range(both[0].size):
        moved = []
        for sign in (1.0, -1.0):
            positions = both.copy()
            positions.reshape(len(both), -1)[:, variable] += sign * step
            moved.append(evaluate(positions))
        for hat in range(2):
            slope = (moved[0].gaps[0] - moved[1].gaps[0])[:, hat] / (2 * step)
            bend = (moved[0].gaps[1] - moved[1].gaps[1])[:, hat] / (2 * step)
            np.testing.assert_allclose(exact.gaps[1][:, hat, variable], slope, atol=1e-8)
            np.testing.assert_allclose(hessians[hat][:, variable], bend, atol=1e-7)


def edge(order: int) -> np.ndarray:
    """A bent edge of some order about (0, 0) to (3, 0.2), its body above."""
    position = gauss_lobatto(order + 1)[0]
    return np.stack((3.0 * position, 0.2 * position - 0.3 * position * (1.0 - position)), axis=1)


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
