"""Gaps of nodes and averaged gaps of segments: search, sign, projections, and exact derivatives."""

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from flangeway.contact.kinematics import closest_parameters, node_edge_gaps, shape_functions
from flangeway.contact.search import candidate_pairs, nearest_edges
from flangeway.contact.segment_to_segment import PieceIntegrals, find_pieces
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


NUMBERS = st.integers(0, 2**32 - 1)


def random_edges(rng: np.random.Generator, count: int, width: int) -> np.ndarray:
    """Edges of very unequal sizes, some of them on a grid so that distances are equal."""
    starts = rng.uniform(-1.0, 1.0, (count, 1, 2))
    sizes = 10.0 ** rng.uniform(-4.0, 0.5, (count, 1, 1))
    steps = rng.uniform(-1.0, 1.0, (count, width - 1, 2)) * sizes
    edges = np.concatenate((starts, starts + np.cumsum(steps, axis=1)), axis=1)
    on_grid = rng.random(count) < 0.3
    grid = np.round(edges[on_grid] * 4.0) / 4.0
    grid[(grid[:, 0] == grid[:, -1]).all(axis=1), -1] += 0.25
    edges[on_grid] = grid
    return edges


def all_pairs(secondary: np.ndarray, primary: np.ndarray, reach: float) -> list[tuple[int, int]]:
    """Overlapping boxes one by one."""
    found = []
    for i, mine in enumerate(secondary):
        for j, other in enumerate(primary):
            low, high = mine.min(axis=0) - reach, mine.max(axis=0) + reach
            if (other.min(axis=0) <= high).all() and (other.max(axis=0) >= low).all():
                found.append((i, j))
    return found


def nearest_of_all(points: np.ndarray, directions: np.ndarray, edges: np.ndarray) -> np.ndarray:
    """Every edge measured for every point."""
    found = []
    for point, direction in zip(points, directions, strict=True):
        best, number = np.inf, -1
        for j, edge in enumerate(edges):
            chord = edge[-1] - edge[0]
            if direction[0] * chord[1] + direction[1] * -chord[0] >= 0.0:
                continue
            apart = point - edge[0]
            along = (apart[0] * chord[0] + apart[1] * chord[1]) / (chord[0] ** 2 + chord[1] ** 2)
            rest = apart - min(max(along, 0.0), 1.0) * chord
            distance = rest[0] ** 2 + rest[1] ** 2
            if distance < best:
                best, number = distance, j
        found.append(number)
    return np.array(found)


@given(
    seed=NUMBERS,
    n=st.integers(1, 40),
    m=st.integers(1, 40),
    reach=st.sampled_from([0.0, 0.01, 0.3]),
    width=st.integers(2, 3),
)
def test_candidates_are_all_overlapping_boxes(seed: int, n: int, m: int, reach: float, width: int) -> None:
    """The pairs of edges are those whose enlarged boxes overlap, none more and none less, in order."""
    rng = np.random.default_rng(seed)
    secondary, primary = random_edges(rng, n, width), random_edges(rng, m, 2)
    i, j = candidate_pairs(secondary, primary, reach)
    tight = set(all_pairs(secondary, primary, reach - 1e-12))
    loose = set(all_pairs(secondary, primary, reach + 1e-12))
    found = list(zip(i.tolist(), j.tolist(), strict=True))
    assert found == sorted(set(found))
    assert tight <= set(found) <= loose


@given(NUMBERS, st.integers(1, 30), st.integers(1, 120))
def test_nearest_edge_is_the_nearest_of_all(seed: int, n: int, m: int) -> None:
    """Every point gets the edge that measuring all edges gives, the first of equally near ones, or none."""
    rng = np.random.default_rng(seed)
    edges = random_edges(rng, m, int(rng.integers(2, 4)))
    points = rng.uniform(-2.0, 2.0, (n, 2))
    points[::3] = np.round(points[::3] * 4.0) / 4.0
    directions = rng.normal(size=(n, 2))
    directions[::4] = np.round(directions[::4])
    if seed % 3 == 0:  # edges that face nearly one way, so that many points are faced by none
        turned = edges[:, -1, 0] < edges[:, 0, 0]
        edges[turned] = edges[turned, ::-1]
    assert nearest_edges(points, directions, edges).tolist() == nearest_of_all(points, directions, edges).tolist()
