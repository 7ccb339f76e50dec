"""Array types, the one check that all points given by a user pass, and how messages write a point."""

import math
from collections.abc import Callable, Iterable, Iterator, Sequence
from typing import Any, TypeAlias, TypeVar

import numpy as np
from numpy.typing import ArrayLike, NDArray

from flangeway.checks import as_numbers
from flangeway.errors import InputError
from flangeway.types import Floats, Ints

FloatArray: TypeAlias = Floats
IntArray: TypeAlias = NDArray[np.int32]
Point: TypeAlias = tuple[float, float]
Place: TypeAlias = Point | tuple[float, float, float]
Item = TypeVar("Item")

MAX_NEWTON_STEPS = 20
"""Steps of Newton's method for parameters; a few are enough where it converges."""


def as_points(values: ArrayLike, name: str = "points") -> Floats:
    """Return `values` as an array of finite points.

    Returned: points (n, 2), float64. An `InputError` if the shape is another one or a coordinate is not finite.

    - `values`: one point (2,) or points (n, 2).
    - `name`: what the message calls them.
    """
    points = np.atleast_2d(as_numbers(name, values, "an array of shape (n, 2)", "give one row (x, y) a point"))
    if points.ndim != 2 or points.shape[1] != 2:
        raise InputError(
            f"{name} with shape {np.shape(values)}",
            "an array of shape (n, 2)",
            "give one row (x, y) a point, never transposed",
        )
    finite = np.isfinite(points).all(axis=1)
    if not finite.all():
        row = int(np.argmin(finite))
        raise InputError(
            f"{name}: row {row} is ({points[row, 0]}, {points[row, 1]})",
            "finite coordinates",
            "remove or repair this point",
        )
    return points


def as_point(value: ArrayLike, name: str = "point") -> Point:
    """Return one finite point as a pair of floats; see `as_points` for what is refused."""
    if isinstance(value, tuple) and len(value) == 2:  # quickly, for profiles of hundreds of arcs at every motion
        x, y = value
        if type(x) is float and type(y) is float and math.isfinite(x) and math.isfinite(y):
            return x, y
    points = as_points(value, name)
    if len(points) != 1:
        raise InputError(f"{name}: {len(points)} points", "one point (x, y)", "give a single point")
    return float(points[0, 0]), float(points[0, 1])


def frozen(values: NDArray[Any]) -> NDArray[Any]:
    """Return an array after it was made read-only."""
    values.setflags(write=False)
    return values


def sides_of(ring: Sequence[Item]) -> Iterator[tuple[Item, Item]]:
    """Each item of a closed ring and the one after it, the last and the first at the end."""
    return zip(ring, [*ring[1:], *ring[:1]], strict=True)


def point_text(point: Point | Floats) -> str:
    """Write a point (d,) for a message, with nine digits."""
    return f"({', '.join(f'{coordinate:.9g}' for coordinate in point)})"


def box_about(boxes: Iterable[Floats]) -> Floats:
    """Return the lower-left and upper-right corner (2, 2) of boxes given by theirs."""
    corners = np.array(list(boxes))
    return np.array([corners[:, 0].min(axis=0), corners[:, 1].max(axis=0)])


def norms(vectors: Floats) -> Floats:
    """Return the lengths of vectors (..., d)."""
    lengths = np.hypot(vectors[..., 0], vectors[..., 1])
    return np.asarray(np.hypot(lengths, vectors[..., 2]) if vectors.shape[-1] == 3 else lengths)


def extent(points: Floats) -> float:
    """Return the longer side of the box about points (n, 2)."""
    return float(np.ptp(points, axis=0).max())


def diagonal(points: Floats) -> float:
    """Return the diagonal of the box about points (..., d)."""
    return float(norms(np.ptp(points.reshape(-1, points.shape[-1]), axis=0)))


def box_middle(points: Floats) -> Floats:
    """Return the middle (2,) of the box about points (n, 2)."""
    return (points.min(axis=0) + points.max(axis=0)) / 2.0


def box(points: Sequence[Floats], margin: float) -> Floats:
    """Return the corners (2, 2) of the box about all points, widened."""
    every = np.vstack(points)
    return np.array([every.min(axis=0) - margin, every.max(axis=0) + margin])


def framed(points: Floats, share: float) -> Floats:
    """Return the box about points (n, 2), widened by a share of its longer side."""
    return box([points], share * extent(points))


def steps_around(vertices: Floats) -> Floats:
    """Return the steps from each vertex of polygons (n_vertices, ...) to the next one, of the same shape."""
    return np.roll(vertices, -1, axis=0) - vertices


def angles_of(vectors: Floats) -> Floats:
    """Return the angles of vectors (..., 2) from x, counter-clockwise, in (-pi, pi]."""
    return np.asarray(np.arctan2(vectors[..., 1], vectors[..., 0]))


def step_lengths(points: Floats) -> Floats:
    """Return the distances (n - 1,) from each of points (n, 2) to the next one."""
    return np.asarray(norms(np.diff(points, axis=0)))


def middles_of(ends: Floats) -> Floats:
    """Return the middles (n - 1, ...) of neighbours among values (n, ...)."""
    return (ends[1:] + ends[:-1]) / 2.0


def chords_of(edges: Floats) -> Floats:
    """Return the vectors (n, d) from the first to the last of the points of edges (n, k, d)."""
    return edges[:, -1] - edges[:, 0]


def units_of(vectors: Floats) -> Floats:
    """Return vectors (n, d) divided by their lengths."""
    return vectors / norms(vectors)[:, None]


def max_magnitude(values: NDArray[Any]) -> float:
    """Return the largest magnitude of numbers, 0 of none."""
    return float(np.abs(values).max(initial=0.0))


def sums_at(places: NDArray[np.integer], values: Floats, n: int) -> Floats:
    """Return the sums (n, ...) of values (*k, ...) that belong to places (*k,) from 0 to n - 1."""
    sums = np.zeros((n, *values.shape[places.ndim :]))
    np.add.at(sums, places, values)
    return sums


def starts_of(counts: Sequence[int] | Ints) -> Ints:
    """Return where rows with counts of entries (n,) start among all entries, and the number of these, (n + 1,)."""
    return np.concatenate(([0], np.cumsum(counts))).astype(np.int64)


def components_of(nodes: Ints, dimension: int = 2) -> Ints:
    """Return the numbers (..., d) of the components of nodes (...), d of each node after the other."""
    return dimension * nodes[..., None] + np.arange(dimension)


def vectors_at(at: Floats | float, stations: Floats, vectors: Floats) -> Floats:
    """Return vectors (..., d) at places (...), linear between those (n, d) at stations (n,), rising."""
    return np.stack([np.interp(at, stations, component) for component in vectors.T], axis=-1)


def chain_points(edges: NDArray[Any]) -> NDArray[Any]:
    """Return the points along edges (n, k) that follow each other."""
    return np.append(edges[:, :-1], edges[-1, -1])


def longest_step(stations: Floats, low: float, high: float) -> float:
    """Return the longest of the steps between stations (n,), rising, that are in part between two of their numbers."""
    return float(np.diff(stations)[(stations[1:] > low) & (stations[:-1] < high)].max())


def run_of(used: ArrayLike) -> slice:
    """Return the run from the first to the last of those used, (n,)."""
    at = np.flatnonzero(used)
    return slice(int(at[0]), int(at[-1]) + 1)


def quotients(numerators: Floats | float, denominators: Floats) -> Floats:
    """Return numerators over denominators (...), 0 where the latter are not positive."""
    zeros = np.zeros(np.broadcast_shapes(np.shape(numerators), denominators.shape))
    return np.divide(numerators, denominators, out=zeros, where=denominators > 0.0)


def joined_columns(rows: Iterable[Sequence[NDArray[Any]]]) -> tuple[NDArray[Any], ...]:
    """Return the arrays of a table, those of each column one after the other along their first axis."""
    return tuple(np.concatenate(column) for column in zip(*rows, strict=True))


def cross_product(a: Floats, b: Floats) -> Floats:
    """Return the component out of the plane of the cross products of vectors (..., 2), positive if b is left of a."""
    return a[..., 0] * b[..., 1] - a[..., 1] * b[..., 0]


def turned_right(vectors: Floats) -> Floats:
    """Vectors (..., 2) turned clockwise by a right angle: outwards, of edges with their body on the left."""
    return np.stack((vectors[..., 1], -vectors[..., 0]), axis=-1)


def circle_centres(middles: Floats, ends: Floats) -> Floats:
    """Centres (..., 2) of circles through the origin and two further points (..., 2) that are on no line with it.

    Of a and b the centre is ``(|a|^2 b' - |b|^2 a') / (2 a x b)``, the prime for a quarter of a turn to the right.
    """
    squares = [(points**2).sum(axis=-1, keepdims=True) for points in (middles, ends)]
    rays = squares[0] * turned_right(ends) - squares[1] * turned_right(middles)
    return rays / (2.0 * cross_product(middles, ends)[..., None])


def chain_lengths(points: Floats) -> Floats:
    """Lengths along a chain of points (n, 2) at each of them, from 0, shape (n,)."""
    return np.append(0.0, np.cumsum(step_lengths(points)))


def nearest_on_segments(points: Floats, starts: Floats, ends: Floats) -> tuple[Ints, Floats, Floats]:
    """Nearest segment of each point, the share of the segment up to the closest point, and the distance, each (n,).

    - `points`: shape (n, 2).
    - `starts`, `ends`: of the segments, shape (m, 2) each.
    """
    apart, chords = points[:, None] - starts, ends - starts
    shares = np.clip((apart * chords).sum(axis=-1) / (chords**2).sum(axis=-1), 0.0, 1.0)
    distances = norms(apart - shares[..., None] * chords)
    nearest, rows = distances.argmin(axis=1), np.arange(len(points))
    return nearest, shares[rows, nearest], distances[rows, nearest]


# --- Straight edges that stand for a smooth curve.


COLLINEAR = 1e-6
"""Turn between edges, in rad, below which they are one line."""

ROUGH_ANGLE = np.deg2rad(30.0)
"""Turn between edges from which a surface is not smooth in the mean: the pressure may jump there, so that both sides
have a constraint each. Edges that turn by less are taken for a coarse curve in the warning of straight edges."""

CHORD_RATIO = 1.5
"""Length of an edge that is a chord of a curve relative to that of the longer neighbour."""


def chord_depths(lengths: Floats, before: Floats, after: Floats, limit: float) -> Floats:
    """Distance ``h^2 / 8 R`` of chords from the smooth curve that they belong to, shape (n,).

    Two chords of a circle meet at the angle ``h / R``. The turns at both ends of a chord show a curve if they are to
    the same side and below a limit; the smaller one gives its radius. Otherwise the distance is 0.
    """
    turns = np.minimum(np.abs(before), np.abs(after))
    smooth = (before * after > 0.0) & (np.maximum(np.abs(before), np.abs(after)) < limit)
    return np.where(smooth, lengths * turns / 8.0, 0.0)


def facet_depths(ends: Floats, limit: float) -> Floats:
    """Distance of edges (n, 2, 2) that follow each other from the smooth curve whose chords turn by less than a limit.

    See `chord_depths`; pieces of one straight line are one chord. Shape (n,).
    """
    depth = np.zeros(len(ends))
    start, end = (ends @ np.array([1.0, 1j])).T
    chords = end - start
    turns = np.angle(chords / np.roll(chords, 1))  # at the start of each edge
    if start[0] != end[-1]:
        turns[0] = np.nan
    starts = np.flatnonzero(~(np.abs(turns) < COLLINEAR))
    if len(starts) < 2:
        return depth
    line = (np.cumsum(~(np.abs(turns) < COLLINEAR)) - 1) % len(starts)
    lengths = np.bincount(line, np.abs(chords)).astype(np.float64)
    # a straight side is far longer than the chords of the arcs beside it
    lengths = np.minimum(lengths, CHORD_RATIO * np.maximum(np.roll(lengths, 1), np.roll(lengths, -1)))
    before, after = turns[starts], np.roll(turns[starts], -1)
    # a chain's first and last line have one turn each
    before, after = np.where(np.isnan(before), after, before), np.where(np.isnan(after), before, after)
    depth[:] = chord_depths(lengths, before, after, limit)[line]
    return depth


def root_parameters(
    change: Callable[[Floats], Floats],
    parameters: Floats,
    max_step: float,
    tolerance: float,
    within: Callable[[Floats], Floats] = np.asarray,
) -> Floats:
    """Parameters (n,) of points on curves after Newton's method from first ones, all at once.

    - `change`: what is to be taken from parameters, the quotient of an equation and its derivative.
    - `max_step`: maximum change of a parameter in a step.
    - `tolerance`: change after which the next one, of the size of its square, is round-off.
    - `within`: takes parameters to those that the curve has.
    """
    for _ in range(MAX_NEWTON_STEPS):
        previous = parameters
        parameters = within(parameters - np.clip(change(parameters), -max_step, max_step))
        if max_magnitude(parameters - previous) <= tolerance:
            break
    return parameters
