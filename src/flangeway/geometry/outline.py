"""Closed, counter-clockwise outline of a region, with exact section properties."""

from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import Self

import numpy as np
from numpy.typing import ArrayLike

from flangeway.errors import InputError
from flangeway.geometry.arrays import Point, as_points, norms
from flangeway.geometry.contour import Contour, _joined
from flangeway.geometry.placement import Placement
from flangeway.geometry.segments import Arc, Line, Segment, halved
from flangeway.types import Bools, Floats

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
        first = 0.5 * np.sum(local**2 * normals, axis=0) / self.area + self._middle
        return float(first[0]), float(first[1])

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
