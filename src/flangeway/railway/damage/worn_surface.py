"""A running surface that wears, and the measures and limits of worn profiles."""

from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from functools import cached_property
from typing import NamedTuple

import numpy as np
from scipy.interpolate import CubicSpline
from scipy.ndimage import gaussian_filter1d

from flangeway.checks import as_numbers, check_between, check_kind
from flangeway.errors import InputError
from flangeway.geometry import Contour, Outline, Placement, Segment
from flangeway.geometry.biarcs import biarcs
from flangeway.railway.profiles.bundled import RailProfile, WheelProfile
from flangeway.railway.profiles.formats.instrument_files import write_segment_csv
from flangeway.railway.profiles.orientation import GAUGE_DEPTH_MM, crossings, measures
from flangeway.railway.track.wheelset_problem import Role
from flangeway.records import Positive, Record
from flangeway.types import Floats

# --- A running surface that wears: depth over its arc length, from cells of patches, and the worn profile.
#
# The depth is measured along the normals of the new surface into the steel, on even pieces of the new surface's arc
# length. Contact is on the worn surface: what cells wear off lies between points of it, and is added to the pieces as
# an area over their worn lengths, so that the areas of pieces and cells have one sum. Between the middles of the pieces
# the depth is a cubic spline; the area between new and worn surface then differs from the sum by second powers of depth
# times curvature and by the interpolation (below 1 % up to 0.5 mm on treads).


SPACING_MM = 0.25
"""Length of the pieces: contact cells are 0.2 to 0.6 mm wide."""
SPACINGS_MM = (0.01, 5.0)
"""Lengths of the pieces that are allowed."""
FILTER_MM = 2.0
"""Standard deviation of the Gaussian by which increments of the depth are filtered.

Raw increments grow ridges, since a wheel that has worn a groove runs beside it in the next step; a line has more states
than a collective. Filtering the profile instead does not stop ridges."""
ARCS_TOLERANCE_MM = 2e-6
"""Maximum distance of the arcs of contact from the worn curve."""
BODY_TOLERANCE_MM = 2e-3
"""The same of the body's outline, whose arcs the mesh must resolve."""
MIN_STRETCH = 0.2
"""Least worn length over new length of a piece; below it the worn surface folds."""

DEPTH_SEEN_MM = 1e-3
"""Depth beyond which a worn point must lie inside the new body."""

Profile = WheelProfile | RailProfile


@dataclass(frozen=True, eq=False)
class WornSurface:
    """A wheel or rail and how deep it is worn.

    Parameters
    ----------
    new
        The profile without wear.
    depth
        Depth of the pieces in mm, >= 0, shape (n,); empty: no wear.
    spacing_mm
        Length of the pieces; the last one may be shorter.

    Raises
    ------
    InputError
        If a depth is negative or not finite, their number is not that of the pieces, or the spacing is not allowed.

    """

    new: Profile
    depth: Floats = field(default_factory=lambda: np.zeros(0))
    spacing_mm: float = SPACING_MM

    def __post_init__(self) -> None:
        advice = "give what rail(...) or wheel(...) returns"
        check_kind("WornSurface", "new", self.new, Profile, "the profile of a wheel or a rail", advice)
        check_between("WornSurface", "spacing_mm", self.spacing_mm, *SPACINGS_MM, advice="leave it out")
        depth = as_numbers("WornSurface(depth)", self.depth).copy()
        if not depth.size:
            depth = np.zeros(len(self.bounds) - 1)
        if depth.shape != (len(self.bounds) - 1,) or not (np.isfinite(depth) & (depth >= 0.0)).all():
            raise InputError(
                f"{depth.size} depths of {self.new.title}, or some not >= 0",
                f"{len(self.bounds) - 1} finite depths >= 0 in mm, one for each {self.spacing_mm:g} mm of the surface",
                "give the depth on all pieces",
            )
        depth.setflags(write=False)
        object.__setattr__(self, "depth", depth)

    @cached_property
    def surface(self) -> Contour:
        """The new running surface."""
        return self.new.running_surface

    @cached_property
    def bounds(self) -> Floats:
        """Arc lengths of the ends of the pieces on the new surface, shape (n + 1,)."""
        length = self.surface.length
        return np.append(np.arange(0.0, length - 0.5 * self.spacing_mm, self.spacing_mm), length)

    @property
    def middles(self) -> Floats:
        """Arc lengths of the middles of the pieces, shape (n,)."""
        return np.asarray((self.bounds[1:] + self.bounds[:-1]) / 2.0)

    @cached_property
    def _depth_at(self) -> CubicSpline:
        # a second derivative without jumps: contact feels curvatures of 1e-3 per mm
        s = np.concatenate((self.bounds[:1], self.middles, self.bounds[-1:]))
        return CubicSpline(s, np.concatenate(([0.0], self.depth, [0.0])), bc_type="clamped")

    @cached_property
    def worn_points(self) -> Floats:
        """Points of the worn surface at the ends of the pieces, shape (n + 1, 2)."""
        return self._at(self.bounds)

    @cached_property
    def worn_lengths(self) -> Floats:
        """Lengths of the pieces along the worn surface, shape (n,)."""
        return np.linalg.norm(np.diff(self.worn_points, axis=0), axis=1)

    def _at(self, lengths: Floats) -> Floats:
        """Worn points at arc lengths (n,) of the new surface, shape (n, 2)."""
        points, normals = self._new_at(lengths)
        return np.asarray(points - self._depth_at(lengths)[:, None] * normals)

    def _new_at(self, lengths: Floats) -> tuple[Floats, Floats]:
        """Points and normals of the new surface at arc lengths (n,), shape (n, 2)."""
        piece = self.surface.numbers_at(lengths)
        points, normals = np.empty((2, len(lengths), 2))
        for number in np.unique(piece):
            rows, segment = piece == number, self.surface.segments[number]
            s = (lengths[rows] - self.surface.offsets[number]) / segment.length
            points[rows], normals[rows] = segment.point(s), segment.normal(s)
        return points, normals

    @property
    def slope_cosines(self) -> Floats:
        """Cosines of the slopes of the new surface at the middles of the pieces, shape (n,)."""
        return np.abs(self._new_at(self.middles)[1][:, 1])

    def deposited(self, ends: Floats, areas: Floats) -> Floats:
        """Mean depths of the pieces (n,) by areas (m,) in mm2 spread between points of the worn surface (m, 2, 2).

        ``(depths * worn_lengths).sum() == areas.sum()`` to round-off. An `InputError` where points reach the end of the
        surface.
        """
        worn = np.append(0.0, np.cumsum(self.worn_lengths))
        at = np.sort(self.surface.lengths_at(ends.reshape(-1, 2)).reshape(-1, 2), axis=1)
        first, last = np.interp(at, self.bounds, worn).T
        width = np.maximum(last - first, np.finfo(float).tiny)
        if (last - first < 1e-9).any() or first.min(initial=1.0) <= 0.0 or last.max(initial=0.0) >= worn[-1]:
            raise InputError(
                f"wear at the end of the running surface of {self.new.title}",
                "contact inside of the running surface",
                "give a profile that reaches farther",
            )
        # fraction of each area before each bound, exact for uniform depths between the ends; then on each piece
        before = np.clip((worn[None] - first[:, None]) / width[:, None], 0.0, 1.0)
        return np.asarray(areas @ np.diff(before, axis=1) / self.worn_lengths)

    def filtered(self, increment: Floats, filter_mm: float = FILTER_MM) -> Floats:
        """Increment of the depth (n,) without short waves, of the same area.

        - `filter_mm`: standard deviation of a Gaussian; 0: as it is.
        """
        if not filter_mm:
            return increment
        areas = increment * self.worn_lengths
        return np.asarray(gaussian_filter1d(areas, filter_mm / self.spacing_mm, mode="reflect") / self.worn_lengths)

    def worn_by(self, increment: Floats) -> "WornSurface":
        """Return the surface with a further depth (n,) along the normals of the worn surface."""
        return replace(self, depth=self.depth + increment * self._inclination)

    @cached_property
    def _inclination(self) -> Floats:
        """Depth along the new normal over that along the worn one, shape (n,)."""
        stretch = np.diff(self.bounds) * (1.0 - self.surface.curvatures_at(self.middles) * self.depth)
        return np.asarray(np.sqrt(1.0 + (np.diff(self._depth_at(self.bounds)) / stretch) ** 2))

    @property
    def worn_area_mm2(self) -> float:
        """Area between the new and the worn surface, ``integral of h - curvature h^2 / 2`` over the arc length."""
        s = np.linspace(0.0, self.surface.length, 20 * len(self.depth))
        h = self._depth_at(s)
        return float(np.trapezoid(h - 0.5 * self.surface.curvatures_at(s) * h**2, s))

    @cached_property
    def worn(self) -> Profile:
        """The profile with the worn surface for contact, and the body of the new one.

        An `InputError` if the wear folds the surface, reaches its ends or leaves the body.
        """
        if not self.depth.any():
            return self.new
        contour = self._worn_contour(self.surface, self.surface.offsets)
        if isinstance(self.new, RailProfile):  # the gauge is that of the new head
            head = self.new.placing_head or self.surface
            return replace(self.new, fine=contour, placing_head=head)
        return replace(self.new, fine=contour)

    @cached_property
    def worn_body(self) -> Profile:
        """The profile with the worn surface for contact and in its body: its compliance is made anew."""
        if not self.depth.any():
            return self.new
        drawn = self.new.outline.part(self.new.running_names)
        # the drawn surface and the one of contact have lengths that differ by round-off and tolerances of drawing
        scale = self.surface.length / drawn.offsets[-1]
        part = self._worn_contour(drawn, drawn.offsets * scale, BODY_TOLERANCE_MM)
        rest = self.new.outline.part(dict.fromkeys(name for name in self.new.outline.names if name not in drawn.names))
        outline = Outline.from_segments([*part.segments, *rest.segments], [*part.names, *rest.names])
        return replace(self.worn, outline=outline)

    def _worn_contour(self, surface: Contour, starts: Floats, tolerance: float = ARCS_TOLERANCE_MM) -> Contour:
        """Worn surface as lines and arcs; segments without wear stay."""
        self._refuse_too_deep()
        limits = np.flatnonzero(self.depth)[[0, -1]] + np.array([0, 1])
        first, last = self.bounds[np.clip(limits + np.array([-1, 1]), 0, len(self.bounds) - 1)]
        depth, slope = self._depth_at, self._depth_at.derivative()
        touched = (starts[1:] > first) & (starts[:-1] < last)
        ends = np.array([[segment.point([0.0, 1.0]), segment.normal([0.0, 1.0])] for segment in surface.segments])
        depths = np.stack((depth(starts[:-1]), depth(starts[1:])), axis=1) * touched[:, None]
        points = ends[:, 0] - depths[..., None] * ends[:, 1]
        # neighbours meet at the mean of their worn ends, which are apart at corners, or at the end that stays
        both = (touched[1:] & touched[:-1])[:, None]
        joints = np.where(both, 0.5 * (points[:-1, 1] + points[1:, 0]), ends[:-1, 0, 1])
        joints = np.concatenate((points[:1, 0], joints, points[-1:, 1]))
        moves = np.stack((joints[:-1], joints[1:]), axis=1) - points

        def worn(number: int) -> list[Segment]:
            """Arcs in the place of a segment."""
            segment, (first_move, last_move) = surface.segments[number], moves[number]
            low, length = float(starts[number]), float(starts[number + 1] - starts[number])

            def curve(t: Floats) -> tuple[Floats, Floats]:
                at, tangents, normals = low + t * length, segment.tangent(t), segment.normal(t)
                h = depth(at)[:, None]
                points = segment.point(t) - h * normals + (1.0 - t)[:, None] * first_move + t[:, None] * last_move
                along = tangents * (1.0 - segment.curvature * h) - slope(at)[:, None] * normals
                return points, segment.length * along + (last_move - first_move)

            # joints every 4 mm, none close to the ends: arcs must not be tiny
            inside = self.bounds[:: max(int(4.0 / self.spacing_mm), 1)]
            inside = inside[(inside > low + self.spacing_mm) & (inside < low + length - self.spacing_mm)]
            return biarcs(curve, np.concatenate(([0.0], (inside - low) / length, [1.0])), tolerance)

        chain = [
            (name, piece)
            for number, (name, segment) in enumerate(zip(surface.names, surface.segments, strict=True))
            for piece in (worn(number) if touched[number] else [segment])
        ]
        try:
            return Contour.named(chain)
        except InputError as reason:
            raise self._too_deep("its surface then meets itself: " + reason.given) from reason

    def _refuse_too_deep(self) -> None:
        if self.depth[[0, -1]].any():
            raise self._too_deep("it reaches the end of the running surface")
        if (1.0 - self.surface.curvatures_at(self.middles) * self.depth < MIN_STRETCH).any():
            raise self._too_deep("its surface folds where it is curved more")
        deep = self._at(self.middles)[self.depth > DEPTH_SEEN_MM]
        if len(deep) and not self.new.outline.contains(deep).all():
            raise self._too_deep("it is deeper than the body")

    def _too_deep(self, why: str) -> InputError:
        return InputError(
            f"wear of {self.depth.max():.3g} mm on {self.new.title}: {why}",
            "wear inside of the profile and its body",
            "give a profile whose measured surface reaches farther, or end at a smaller depth",
        )

    @property
    def radius_loss_mm(self) -> float:
        """How much lower the worn tread of a wheel is at the tape line: what its radius there has lost; 0 on rails."""
        if isinstance(self.new, RailProfile):
            return 0.0
        # the tread follows the flange
        worn, new = (crossings(points, 0.0, axis=0)[-1] for points in (self.worn_points, self._new_at(self.bounds)[0]))
        return float(worn - new)

    def csv(self) -> str:
        """The worn surface as lines and arcs, without rounding, as ``flangeway profile`` reads it.

        A wheel's file has its origin on the worn tread at the tape line, where `radius_loss_mm` is off its radius.
        """
        profile = self.worn
        if isinstance(profile, WheelProfile):
            return write_segment_csv(self.from_tread, "wheel", profile.title, "tape", profile.flange_back_mm)
        return write_segment_csv(profile.running_surface, "rail", profile.title, "base")

    @property
    def from_tread(self) -> Contour:
        """The worn surface with the origin of wheels on the worn tread at the tape line."""
        return self.worn.running_surface.transformed(Placement(0.0, (0.0, -self.radius_loss_mm)))


# --- Measures of worn profiles and the limits at which they are done.


class LimitKind(NamedTuple):
    """Whose measure a limit is of, and whether it is reached above it (1) or below it (-1)."""

    role: Role
    measure: str
    sense: int = 1


class Limits(Record):
    """Measures of the profiles at which an evolution ends; flange thickness, height and slope qR as in EN 15313."""

    min_flange_thickness_mm: Positive | None = None
    """minimum flange thickness"""
    max_flange_height_mm: Positive | None = None
    """maximum flange height"""
    min_flange_slope_mm: Positive | None = None
    """minimum flange slope qR"""
    max_hollow_mm: Positive | None = None
    """maximum height of the tread over its field side"""
    max_tread_wear_mm: Positive | None = None
    """maximum loss of the radius at the tape line"""
    max_top_wear_mm: Positive | None = None
    """maximum wear of the rail's top"""
    max_side_wear_mm: Positive | None = None
    """maximum wear of the rail's gauge face"""


LIMITS: dict[str, LimitKind] = {
    "min_flange_thickness_mm": LimitKind("wheel", "flange_thickness_mm", -1),
    "max_flange_height_mm": LimitKind("wheel", "flange_height_mm"),
    "min_flange_slope_mm": LimitKind("wheel", "flange_slope_mm", -1),
    "max_hollow_mm": LimitKind("wheel", "hollow_mm"),
    "max_tread_wear_mm": LimitKind("wheel", "tread_wear_mm"),
    "max_top_wear_mm": LimitKind("rail", "top_wear_mm"),
    "max_side_wear_mm": LimitKind("rail", "side_wear_mm"),
}
"""Measures of `Limits`."""
MAX_CUT_DEG = 75.0
"""Steepest slope of a running surface that a cut restores: flanges have 70 degrees, faces of rails stay as they are."""
HOLLOW_FROM_MM = -20.0
"""Position across the tread from which hollow wear is measured: beyond the flange root."""


def worn_measures(surface: WornSurface) -> dict[str, float]:
    """Measures of a worn profile in mm.

    Wheels: those of `flangeway.railway.profiles.orientation.measures`; ``tread_wear_mm``, the loss of the radius at the
    tape line; ``hollow_mm``, how far the tread lies above its field side, towards the axle. Rails: ``top_wear_mm`` in
    the middle of the head and ``side_wear_mm`` of the gauge face at 14 mm below the new top. Both:
    ``restoring_cut_mm``, what turning takes off the radius, or grinding off the height, until the new shape is there
    again: the new surface moved down by it lies nowhere above the worn one, ``max(depth / cos(slope))``.
    """
    worn = surface.worn.running_surface.sampled(spacing=0.1, max_deviation=1e-4)
    if isinstance(surface.new, WheelProfile):
        measured = measures(surface.from_tread, "wheel")
        tread = worn[worn[:, 0] > HOLLOW_FROM_MM]
        rim = np.minimum.accumulate(tread[::-1, 1])[::-1]
        hollow = float((tread[:, 1] - rim).max())
        return measured | {"tread_wear_mm": surface.radius_loss_mm, "hollow_mm": hollow} | _cut(surface)
    new = surface.surface.sampled(spacing=0.1, max_deviation=1e-4)
    level = float(new[:, 1].max()) - GAUGE_DEPTH_MM
    heights, faces = ([_at(profile, axis, at) for profile in (new, worn)] for axis, at in ((0, 0.0), (1, level)))
    return {"top_wear_mm": heights[0] - heights[1], "side_wear_mm": faces[1] - faces[0]} | _cut(surface)


def _cut(surface: WornSurface) -> dict[str, float]:
    cosines = surface.slope_cosines
    restored = cosines >= np.cos(np.radians(MAX_CUT_DEG))
    return {"restoring_cut_mm": float((surface.depth[restored] / cosines[restored]).max())}


def _at(points: Floats, axis: int, value: float) -> float:
    """Height in the middle of a head (axis 0), or x of its gauge face at a height (axis 1)."""
    if axis == 1:
        points = points[points[:, 0] < 0.0]
    order = np.argsort(points[:, axis])
    return float(np.interp(value, points[order, axis], points[order, 1 - axis]))


def reached(surface: WornSurface, limits: Mapping[str, float]) -> tuple[str, ...]:
    """Names of the limits that a profile has reached; those of the other kind of profile do not count."""
    measured = worn_measures(surface) if limits else {}
    kinds = [(name, LIMITS[name], limit) for name, limit in limits.items()]
    return tuple(
        name
        for name, kind, limit in kinds
        if kind.measure in measured and (measured[kind.measure] - limit) * kind.sense >= 0.0
    )
