"""The spatial index gives exactly what comparing everything with everything gives."""

import numpy as np
from hypothesis import given
from hypothesis import strategies as st

from flangeway.contact.search import candidate_pairs, nearest_edges

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
