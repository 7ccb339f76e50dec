"""Regions with holes, and sections made of one region or of several that touch."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from types import MappingProxyType

import numpy as np
from numpy.typing import ArrayLike

from flangeway.errors import InputError
from flangeway.geometry.arrays import Point, as_points, box_about, cross_product, norms, point_text
from flangeway.geometry.outline import CROSSING_TOLERANCE, Outline
from flangeway.geometry.placement import Placement
from flangeway.geometry.segments import chains_meet
from flangeway.types import Bools, Floats


@dataclass(frozen=True)
class Region:
    """Plane region inside an outline and outside of its holes.

    Parameters
    ----------
    outer
        Outer boundary.
    holes
        Outlines of the holes, counter-clockwise like every `Outline`.

    Raises
    ------
    InputError
        If a hole is outside, touches or crosses the outer boundary or another hole, or lies in another hole; the
        message names the place.
    """

    outer: Outline
    holes: tuple[Outline, ...] = ()

    def __post_init__(self) -> None:
        """Check where the holes are."""
        object.__setattr__(self, "holes", tuple(self.holes))
        for number, hole in enumerate(self.holes):
            name = f"hole {number + 1} of {len(self.holes)}"
            _refuse_meeting(name, hole, "the outer boundary", self.outer)
            if not self.outer.contains([hole.ends[0]])[0]:
                raise InputError(
                    f"{name} at {_place(hole)} is outside of the outer boundary",
                    "holes inside the outer boundary",
                    "move this hole, or make it a separate part",
                )
            for other_number, other in enumerate(self.holes[:number]):
                other_name = f"hole {other_number + 1}"
                _refuse_meeting(name, hole, other_name, other)
                if other.contains([hole.ends[0]])[0] or hole.contains([other.ends[0]])[0]:
                    raise InputError(
                        f"{name} at {_place(hole)} and {other_name} at {_place(other)}, one inside the other",
                        "holes apart from each other",
                        "remove one, or make the inner one a separate part",
                    )

    @property
    def loops(self) -> tuple[Outline, ...]:
        """Outer boundary, then the holes."""
        return (self.outer, *self.holes)

    @property
    def signed_loops(self) -> list[tuple[float, Outline]]:
        """Outer boundary with 1, then the holes with -1."""
        return [(1.0, self.outer), *((-1.0, hole) for hole in self.holes)]

    @property
    def size(self) -> float:
        """Diagonal of the bounding box."""
        return self.outer.size

    def bounds(self) -> Floats:
        """Lower-left and upper-right corner (2, 2)."""
        return self.outer.bounds()

    @property
    def boundary_length(self) -> float:
        """Length of the outer boundary and of all holes'."""
        return sum(loop.length for loop in self.loops)

    @property
    def area(self) -> float:
        """Area, exact for lines and arcs."""
        return self.outer.area - sum(hole.area for hole in self.holes)

    @cached_property
    def centroid(self) -> Point:
        """Centroid, exact for lines and arcs."""
        return _centroid(self.signed_loops)

    @cached_property
    def second_moments(self) -> tuple[float, float, float]:
        """``Ixx = int y^2``, ``Iyy = int x^2``, ``Ixy = int x y`` about the centroid, exact."""
        return _second_moments(self.signed_loops, self.centroid)

    def reentrant_corners(self, angle_rad: float = 0.02) -> Floats:
        """Return the corners (n, 2) where the material fills more than half a turn, by more than an angle."""
        corners = []
        for sign, loop in self.signed_loops:
            for before, after in zip((loop.segments[-1], *loop.segments), loop.segments, strict=False):
                if -sign * cross_product(before.tangent(1.0)[0], after.tangent(0.0)[0]) > np.sin(angle_rad):
                    corners.append(after.start)
        return np.array(corners).reshape(-1, 2)

    def transformed(self, placement: Placement) -> "Region":
        """Return the region in the placed frame."""
        return Region(self.outer.transformed(placement), tuple(hole.transformed(placement) for hole in self.holes))

    def contains(self, points: ArrayLike) -> Bools:
        """Return for points (n, 2) whether they lie inside (n,); undecided on the boundary."""
        given = as_points(points)
        inside = self.outer.contains(given)
        for hole in self.holes:
            inside &= ~hole.contains(given)
        return inside


@dataclass(frozen=True)
class Section:
    """Cross-section of one named part, or of several that may touch along edges but not overlap.

    Overlaps are found, and refused, when the section is meshed.

    Parameters
    ----------
    parts
        Regions by name; the mesh has a cell set of each name.

    Raises
    ------
    InputError
        If there is no part.
    """

    parts: Mapping[str, Region]

    def __post_init__(self) -> None:
        """Keep a copy that cannot be changed."""
        if not self.parts:
            raise InputError("a section without parts", "one part or more", "give an outer boundary")
        object.__setattr__(self, "parts", MappingProxyType(dict(self.parts)))

    @property
    def regions(self) -> tuple[Region, ...]:
        """The parts' regions."""
        return tuple(self.parts.values())

    @property
    def loops(self) -> tuple[Outline, ...]:
        """Outer boundaries and holes of all parts."""
        return tuple(loop for region in self.regions for loop in region.loops)

    def bounds(self) -> Floats:
        """Lower-left and upper-right corner (2, 2)."""
        return box_about(region.bounds() for region in self.regions)

    @property
    def size(self) -> float:
        """Diagonal of the bounding box."""
        low, high = self.bounds()
        return float(norms(high - low))

    def transformed(self, placement: Placement) -> "Section":
        """Return the section in the placed frame."""
        return Section({name: region.transformed(placement) for name, region in self.parts.items()})

    @property
    def area(self) -> float:
        """Area of all parts, exact."""
        return sum(region.area for region in self.regions)

    @property
    def mean_thickness(self) -> float:
        """``2 area / boundary length``: the wall's thickness if it is thin, the radius of a circle."""
        return 2.0 * self.area / sum(region.boundary_length for region in self.regions)

    def centroid(self, weights: Mapping[str, float] | None = None) -> Point:
        """Centroid, exact; `weights` by part, such as moduli, are one by default."""
        return _centroid(self._weighted(weights))

    def second_moments(self, weights: Mapping[str, float] | None = None) -> tuple[float, float, float]:
        """``Ixx = int y^2``, ``Iyy = int x^2``, ``Ixy = int x y`` about `centroid`, with the same weights, exact."""
        return _second_moments(self._weighted(weights), self.centroid(weights))

    def _weighted(self, weights: Mapping[str, float] | None) -> list[tuple[float, Outline]]:
        return [
            (sign * (1.0 if weights is None else weights[name]), loop)
            for name, region in self.parts.items()
            for sign, loop in region.signed_loops
        ]


def nested_regions(loops: Sequence[Outline]) -> tuple[Region, ...]:
    """Sort loops into regions by what lies in what: every second one inwards is a hole.

    Returned: largest first. An `InputError` if two loops cross or lie on each other, or a hole touches; the message
    names the place.

    - `loops`: outlines that do not cross.
    """
    order = sorted(loops, key=lambda loop: -loop.area)
    owners = [[j for j in range(i) if _lies_in(order[i], order[j])] for i in range(len(order))]
    regions = []
    for i, loop in enumerate(order):
        if len(owners[i]) % 2 == 0:
            inner = [j for j, above in enumerate(owners) if i in above and len(above) == len(owners[i]) + 1]
            regions.append(Region(loop, tuple(order[j] for j in inner)))
    return tuple(regions)


def _lies_in(inner: Outline, outer: Outline) -> bool:
    points = inner.sampled(spacing=inner.length / 16.0)
    apart = outer.closest(points)[2] > CROSSING_TOLERANCE * outer.size
    if not apart.any():
        raise InputError(
            f"two loops that lie on each other at {_place(inner)}", "loops that differ", "remove one of them"
        )
    inside = outer.contains(points[apart])
    if inside.any() and not inside.all():
        meeting_point = chains_meet(inner.segments, outer.segments, CROSSING_TOLERANCE * outer.size)
        where = _place(inner) if meeting_point is None else point_text(meeting_point)
        raise InputError(f"two loops that cross at {where}", "loops that do not cross", "repair one of them")
    return bool(inside.all())


def _refuse_meeting(name: str, hole: Outline, other_name: str, other: Outline) -> None:
    meeting_point = chains_meet(hole.segments, other.segments, CROSSING_TOLERANCE * max(other.size, hole.size))
    if meeting_point is not None:
        raise InputError(
            f"{name} meets {other_name} at {point_text(meeting_point)}",
            "holes that keep apart from the outer boundary and from each other",
            "move or shrink this hole, or draw the notch as part of the outer boundary",
        )


def _place(loop: Outline) -> str:
    return point_text(loop.ends[0])


def _centroid(loops: Sequence[tuple[float, Outline]]) -> Point:
    """Centroid of weighted loops, about the first one's to keep digits far from the origin."""
    base = np.array(loops[0][1].centroid)
    total = sum(weight * loop.area for weight, loop in loops)
    first = sum(weight * loop.area * (np.array(loop.centroid) - base) for weight, loop in loops)
    x, y = base + first / total
    return float(x), float(y)


def _second_moments(loops: Sequence[tuple[float, Outline]], about: Point) -> tuple[float, float, float]:
    """Second moments of weighted loops about a point, by the parallel axis theorem."""
    sums = np.zeros(3)
    for weight, loop in loops:
        x, y = np.array(loop.centroid) - np.array(about)
        sums += weight * (np.array(loop.second_moments) + loop.area * np.array([y * y, x * x, x * y]))
    ixx, iyy, ixy = sums.tolist()
    return ixx, iyy, ixy
