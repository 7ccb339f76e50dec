"""Chains of named segments: an open contour, and the closed outline of a region."""

import itertools
from collections.abc import Iterable, Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from typing import Self

import numpy as np
from numpy.typing import ArrayLike

from flangeway.checks import check_positive
from flangeway.errors import InputError
from flangeway.geometry.arrays import IntArray, Point, as_point, as_points, box_about, norms, point_text
from flangeway.geometry.placement import Placement
from flangeway.geometry.segments import Arc, Line, Segment, first_crossing, halved
from flangeway.types import Bools, Floats

# --- Open chain of named segments: a measured surface, or a part of an outline.


JOINT_TOLERANCE = 1e-6  # maximum gap between neighbours that `from_segments` closes, relative to the size of the whole
CROSSING_TOLERANCE = 1e-9  # distance at which segments touch, relative to the size of the whole
BLOCK = 1_000_000  # distances of points from segments that are held at a time: 8 MB


def _joined(segments: Sequence[Segment], *, closed: bool) -> tuple[Segment, ...]:
    """Return the segments with every start moved onto the end before it."""
    if not segments:
        raise InputError("no segment", "one segment or more", "give the contour's segments")
    joined: list[Segment] = []
    for number, segment in enumerate(segments):
        before = segments[number - 1].end if number or closed else segment.start
        gap = float(np.hypot(segment.start[0] - before[0], segment.start[1] - before[1]))
        if gap > 0.0 and gap > JOINT_TOLERANCE * (size := _size(segments)):
            raise InputError(
                f"segment {number} starts at {segment.start}, {gap:.6g} from the end {before} "
                f"of segment {(number - 1) % len(segments)}",
                f"a {'closed outline' if closed else 'chain'} with gaps below {JOINT_TOLERANCE * size:.3g}",
                "close the gap or reorder the segments",
            )
        joined.append(segment if gap == 0.0 else replace(segment, start=before))
    return tuple(joined)


def _size(segments: Sequence[Segment]) -> float:
    """Return the diagonal of the box about the segments."""
    boxes = np.array([segment.bounds for segment in segments])
    return float(norms(boxes[:, 1].max(axis=0) - boxes[:, 0].min(axis=0)))


@dataclass(frozen=True)
class Contour:
    """Open chain of lines and arcs, each with a name that several may share.

    `Contour.from_segments` closes the small gaps of files; the constructor wants exact joints. An `InputError` if there
    is no segment, a joint is open, the chain meets itself, or names are missing; the message names the place.

    - `segments`: each starts where the one before ends.
    - `names`: one name a segment.
    """

    segments: tuple[Segment, ...]
    names: tuple[str, ...]

    _closed = False

    def __post_init__(self) -> None:
        """Check names, joints and crossings."""
        object.__setattr__(self, "segments", tuple(self.segments))
        object.__setattr__(self, "names", tuple(self.names))
        if len(self.names) != len(self.segments):
            raise InputError(
                f"{len(self.names)} names for {len(self.segments)} segments",
                "one name a segment",
                "repeat a name where several segments share it",
            )
        if _joined(self.segments, closed=self._closed) != self.segments:
            raise InputError(
                "segments whose ends differ by rounding",
                "ends that are equal",
                f"use {type(self).__name__}.from_segments, which closes such gaps",
            )
        self._refuse_crossing()

    @classmethod
    def from_segments(cls, segments: Iterable[Segment], names: Iterable[str]) -> Self:
        """Return the chain with gaps below `JOINT_TOLERANCE` of its size closed."""
        return cls(_joined(tuple(segments), closed=cls._closed), tuple(names))

    @classmethod
    def named(cls, rows: Iterable[tuple[str, Segment]]) -> Self:
        """Return the chain of segments behind their names."""
        names, segments = zip(*rows, strict=True)
        return cls.from_segments(segments, names)

    @classmethod
    def _trusted(cls, segments: tuple[Segment, ...], names: tuple[str, ...]) -> Self:
        """Return a chain without checks, for changes that keep it valid."""
        chain = object.__new__(cls)
        object.__setattr__(chain, "segments", segments)
        object.__setattr__(chain, "names", names)
        return chain

    def _refuse_crossing(self) -> None:
        crossing = first_crossing(self.segments, closed=self._closed, tolerance=CROSSING_TOLERANCE * self.size)
        if crossing is not None:
            i, j, crossing_point = crossing
            raise InputError(
                f"segments {i} ({self.names[i]}) and {j} ({self.names[j]}) meet at {point_text(crossing_point)}",
                "a chain that does not cross or touch itself",
                "repair these two segments, or remove a point that is given twice",
            )

    @property
    def n_segments(self) -> int:
        """Number of segments."""
        return len(self.segments)

    @property
    def by_name(self) -> dict[str, Segment]:
        """Segments by their names; of several of one name the last."""
        return dict(zip(self.names, self.segments, strict=True))

    @cached_property
    def size(self) -> float:
        """Diagonal of the bounding box."""
        return _size(self.segments)

    @cached_property
    def length(self) -> float:
        """Length along the chain."""
        return sum(segment.length for segment in self.segments)

    @cached_property
    def offsets(self) -> Floats:
        """Lengths along the chain at the starts of the segments and at the end, (n_segments + 1,)."""
        return np.append(0.0, np.cumsum([segment.length for segment in self.segments]))

    def _named(self, names: Iterable[str] | None) -> list[int]:
        """Return the numbers of the segments with one of the names, all for None."""
        if names is None:
            return list(range(self.n_segments))
        wanted = {names} if isinstance(names, str) else set(names)
        unknown = sorted(wanted - set(self.names))
        if unknown or not wanted:
            raise InputError(
                f"segment names {unknown}", f"one or more of {sorted(set(self.names))}", "correct the names"
            )
        return [i for i, name in enumerate(self.names) if name in wanted]

    def bounds(self, names: Iterable[str] | None = None) -> Floats:
        """Return the lower-left and upper-right corner (2, 2) of all or of the named segments."""
        return box_about(self.segments[i].bounds for i in self._named(names))

    @property
    def top(self) -> float:
        """Largest y of all segments."""
        return float(self.bounds()[1, 1])

    @property
    def bottom(self) -> float:
        """Least y of all segments."""
        return float(self.bounds()[0, 1])

    @property
    def ends(self) -> tuple[Point, Point]:
        """Start of the first segment, and end of the last one."""
        return self.segments[0].start, self.segments[-1].end

    def part(self, names: Iterable[str]) -> "Contour":
        """Return the named segments as an open chain, in the direction of this one.

        An `InputError` if a name is unknown or the segments are not one open chain.
        """
        picked = self._named(names)
        if self._closed and 0 < len(picked) < self.n_segments:
            # start behind a segment that is left out, so that a chain may pass the closing joint
            missing = next(i for i in range(self.n_segments) if i not in picked)
            picked.sort(key=lambda i: (i - missing) % self.n_segments)
        segments = [self.segments[i] for i in picked]
        whole = self._closed and len(picked) == self.n_segments
        if whole or any(a.end != b.start for a, b in itertools.pairwise(segments)):
            raise InputError(
                f"segments {[self.names[i] for i in picked]} are not one open chain",
                "names of neighbouring segments, not of a whole outline",
                "name a part without gaps",
            )
        return Contour._trusted(tuple(segments), tuple(self.names[i] for i in picked))

    def reversed(self) -> "Contour":
        """Return the same points travelled backwards (an open chain, also of an outline)."""
        return Contour._trusted(tuple(segment.reversed() for segment in self.segments[::-1]), self.names[::-1])

    def transformed(self, placement: Placement) -> Self:
        """Return the chain in the placed frame, with the same names."""
        moved = tuple(segment.transformed(placement) for segment in self.segments)
        return self._trusted(_joined(moved, closed=self._closed), self.names)

    def sampled(self, *, spacing: float | None = None, max_deviation: float | None = None) -> Floats:
        """Return points (n, 2) along the chain; all joints are among them.

        An `InputError` if neither is given or one is not positive.

        - `spacing`: maximum distance of neighbours along the chain.
        - `max_deviation`: maximum distance between chords and arcs. At least one of both is needed.
        """
        for name, value in (("spacing", spacing), ("max_deviation", max_deviation)):
            if value is not None:
                check_positive("sampled", name, value, "a positive length")
        if spacing is None and max_deviation is None:
            raise InputError("neither spacing nor max_deviation", "one of both or both", "give a length")
        rows = []
        for segment in self.segments:
            count = 1.0 if spacing is None else segment.length / spacing
            if max_deviation is not None and isinstance(segment, Arc):
                ratio = max(1.0 - max_deviation / segment.radius, 0.0)
                count = max(count, abs(segment.sweep) / (2.0 * np.arccos(ratio)))
            n_pieces = max(int(np.ceil(count - 1e-9)), 1)
            rows.append(segment.point(np.arange(n_pieces) / n_pieces))
        if not self._closed:
            rows.append(np.array([self.ends[1]]))
        return np.vstack(rows)

    def closest(self, points: ArrayLike) -> tuple[IntArray, Floats, Floats]:
        """Return segment numbers (n,), parameters (n,) and distances (n,) of the closest points."""
        given = as_points(points)
        best = np.zeros(len(given), dtype=np.int32)
        parameters = np.zeros(len(given))
        distances = np.full(len(given), np.inf)
        starts, lengths = self._reach
        block = max(BLOCK // len(starts), 1)
        for first in range(0, len(given), block):
            # a segment is within its length of its start: few of many can be the closest
            to_starts = norms(given[first : first + block, None] - starts)
            near = to_starts - lengths <= (1.0 + JOINT_TOLERANCE) * to_starts.min(axis=1, keepdims=True)
            for number in np.flatnonzero(near.any(axis=0)):
                rows = first + np.flatnonzero(near[:, number])
                s, distance = self.segments[number].closest(given[rows])
                nearer = distance < distances[rows]
                rows = rows[nearer]
                best[rows], parameters[rows], distances[rows] = number, s[nearer], distance[nearer]
        return best, parameters, distances

    def numbers_at(self, lengths: Floats) -> IntArray:
        """Return the numbers of the segments at lengths along the chain, those at its ends beyond them."""
        return np.clip(np.searchsorted(self.offsets, lengths, side="right") - 1, 0, self.n_segments - 1)

    def curvatures_at(self, lengths: Floats) -> Floats:
        """Return the curvatures of the segments at lengths along the chain, positive counter-clockwise."""
        return np.array([segment.curvature for segment in self.segments])[self.numbers_at(lengths)]

    def lengths_at(self, points: ArrayLike) -> Floats:
        """Return the lengths along the chain (n,) of its points closest to points (n, 2)."""
        numbers, parameters, _ = self.closest(points)
        return self.offsets[numbers] + parameters * np.diff(self.offsets)[numbers]

    @cached_property
    def _reach(self) -> tuple[Floats, Floats]:
        """Starts (n, 2) and lengths (n,) of the segments."""
        return np.array([segment.start for segment in self.segments]), np.array(
            [segment.length for segment in self.segments]
        )


# --- Closed, counter-clockwise outline of a region, with exact section properties.


# x, y and their products along half a turn are trigonometric polynomials of degree 4 at most:
# 20 Gauss points integrate them to rounding, and lines exactly
_GAUSS_POINTS, _GAUSS_WEIGHTS = np.polynomial.legendre.leggauss(20)


@dataclass(frozen=True)
class Outline(Contour):
    """Simple closed loop of lines and arcs, travelled with the region on the left.

    `Outline.from_segments` closes small gaps and reverses a clockwise loop; the constructor wants
    exact joints and a counter-clockwise loop.

    Parameters
    ----------
    segments
        Each starts where the one before ends, the first where the last ends.
    names
        One name a segment; several may share one.

    Raises
    ------
    InputError
        If the loop is open, meets itself, has no area, or is clockwise; the message names the
        place.
    """

    _closed = True

    def __post_init__(self) -> None:
        """Check the loop, then its direction."""
        super().__post_init__()
        if abs(self._signed_area) <= 1e-12 * self.size**2:
            raise InputError(
                f"an outline with area {self._signed_area:.3g} and size {self.size:.3g}",
                "a loop that encloses an area",
                "check the order of the segments",
            )
        if self._signed_area < 0.0:
            raise InputError(
                "a clockwise outline", "counter-clockwise segments", "use Outline.from_segments, which reverses them"
            )

    @classmethod
    def from_segments(cls, segments: Iterable[Segment], names: Iterable[str]) -> Self:
        """Return the outline with small gaps closed, reversed if the segments run clockwise."""
        joined = _joined(tuple(segments), closed=True)
        labels = tuple(names)
        if cls._trusted(joined, labels)._signed_area < 0.0:
            joined = tuple(segment.reversed() for segment in joined[::-1])
            labels = labels[::-1]
        return cls(joined, labels)

    @classmethod
    def closed(cls, segments: Sequence[Segment], others: Sequence[Point], names: Iterable[str]) -> Self:
        """Return the outline of segments, and of lines from their end through other points to their start."""
        corners = [segments[-1].end, *others, segments[0].start]
        return cls.from_segments([*segments, *map(Line, corners, corners[1:])], names)

    @cached_property
    def _gauss(self) -> tuple[Floats, Floats]:
        """Points (n, 2) and weighted outward normals (n, 2) for integrals along the loop."""
        s = 0.5 * (_GAUSS_POINTS + 1.0)
        points, normals = [], []
        for piece, _ in halved(self.segments, np.pi):
            points.append(piece.point(s))
            normals.append(piece.normal(s) * (0.5 * piece.length * _GAUSS_WEIGHTS)[:, None])
        return np.vstack(points), np.vstack(normals)

    @cached_property
    def _signed_area(self) -> float:
        points, normals = self._gauss
        return 0.5 * float(np.sum((points - self._middle) * normals))

    @property
    def _middle(self) -> Floats:
        # far from the origin, moments about it would lose digits
        return self.bounds().mean(axis=0)

    @property
    def area(self) -> float:
        """Area of the region, exact for lines and arcs."""
        return self._signed_area

    @cached_property
    def centroid(self) -> Point:
        """Centroid of the region, exact for lines and arcs."""
        points, normals = self._gauss
        local = points - self._middle
        return as_point(0.5 * np.sum(local**2 * normals, axis=0) / self.area + self._middle)

    @cached_property
    def second_moments(self) -> tuple[float, float, float]:
        """``Ixx = int y^2``, ``Iyy = int x^2``, ``Ixy = int x y`` about the centroid, exact."""
        points, normals = self._gauss
        x, y = (points - np.array(self.centroid)).T
        ixx = float(np.sum(y**3 * normals[:, 1])) / 3.0
        iyy = float(np.sum(x**3 * normals[:, 0])) / 3.0
        return ixx, iyy, 0.5 * float(np.sum(x**2 * y * normals[:, 0]))

    def contains(self, points: ArrayLike) -> Bools:
        """Return for points (n, 2) whether they lie inside (n,); undecided on the outline."""
        given = as_points(points)
        winding = np.zeros(len(given), dtype=np.int64)
        for piece, _ in halved(self.segments, np.pi):
            a, b = np.array(piece.start), np.array(piece.end)
            left = (b[0] - a[0]) * (given[:, 1] - a[1]) - (b[1] - a[1]) * (given[:, 0] - a[0])
            winding += (a[1] <= given[:, 1]) & (b[1] > given[:, 1]) & (left > 0.0)
            winding -= (a[1] > given[:, 1]) & (b[1] <= given[:, 1]) & (left < 0.0)
            if isinstance(piece, Arc):
                # between chord and arc the loop winds once more than the chords do; a point on the
                # chord is where the rule above sees it: beside and above
                disc = norms(given - np.array(piece.centre)) < piece.radius
                on_right = b[1] > a[1] or (b[1] == a[1] and b[0] < a[0])
                right = (left < 0.0) | ((left == 0.0) & on_right)
                winding += disc & right if piece.counter_clockwise else -1 * (disc & ~right)
        return winding > 0

    def transformed(self, placement: Placement) -> Self:
        """Return the outline in the placed frame, counter-clockwise also if mirrored."""
        moved = super().transformed(placement)
        if not placement.mirrored:
            return moved
        back = moved.reversed()
        return self._trusted(back.segments, back.names)

    def mirrored(self) -> Self:
        """Return the mirror image about x = 0, counter-clockwise, with the same names."""
        return self.transformed(Placement(mirrored=True))
