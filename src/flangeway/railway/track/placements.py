"""Where the rails and the wheels stand (Moherdaui 2021, 7.2.1; readings in `docs/readings.md`).

Axes of the track: x across it to the right, y up from its plane, origin in the middle of the track at the top of the
rails. Without superelevation they are those of space.
Profiles are those of the right side, their track side at negative x; the left side is their mirror image.
"""

import math
from collections.abc import Mapping
from dataclasses import dataclass
from functools import cached_property, lru_cache
from typing import Annotated, Any, Literal, NamedTuple, Self

import annotated_types as at
import numpy as np

from flangeway.checks import check_finite
from flangeway.contact.rolling.friction import FrictionCoefficient
from flangeway.errors import InputError
from flangeway.geometry import Contour, Placement
from flangeway.railway.profiles.bundled import RailProfile, WheelProfile
from flangeway.railway.profiles.formats.two_column import Kind
from flangeway.railway.profiles.named import RailInput, WheelInput, profile_of
from flangeway.railway.profiles.orientation import GAUGE_DEPTH_MM, crossings
from flangeway.railway.track.supports import Axle, ElasticAxle, RimSection, Sleepers, Support, WheelSection
from flangeway.records import Positive, Record
from flangeway.types import Floats

Side = Literal["left", "right"]
SIDES: tuple[Side, Side] = ("left", "right")
SIDE_SIGN: dict[Side, float] = {"left": -1.0, "right": 1.0}
"""Sign of x from the right-hand form of a side to the track's axes."""


def lateral_over_vertical(force_N: Floats, side: Side) -> float:
    """Ratio L/V of the force (2,) on a wheel, positive where the wheel pushes the rail outwards; nan without contact.

    The force has the axes of the track.
    """
    lateral, vertical = force_N
    return float(lateral / vertical) * -SIDE_SIGN[side] if vertical > 0.0 else math.nan


RUNNING_CIRCLES_MM = 65.0
"""Distance of the running circles relative to the gauge: 1500 mm on standard gauge (EN 13803: base of the
superelevation)."""


@dataclass(frozen=True)
class UsualGauge:
    """A gauge, and the distance of the wheels' inner faces that goes with it.

    - `back_to_back_mm`: distance of the wheels' inner faces.
    - `source`: where this is from.
    - `widest_mm`: widest track that is this one: widened in a curve or by wear, but narrower than the next gauge whose
      wheelsets differ, such as 1524 mm after 1520 mm, and 1676 mm after 1668 mm.
    """

    gauge_mm: float
    back_to_back_mm: float
    source: str
    widest_mm: float

    def includes(self, gauge_mm: float) -> bool:
        """Whether a track of a gauge is this one, narrowed or widened."""
        return self.gauge_mm - NARROWING_MM <= gauge_mm <= self.widest_mm


NARROWING_MM = 10.0  # of a track that keeps its wheelsets
_OF_THE_EU = "middle of the range for wheels above 840 mm in Regulation (EU) 1302/2014, 4.2.3.5.2.1"
USUAL_GAUGES = (
    UsualGauge(1435.0, 1360.0, _OF_THE_EU, 1470.0),
    UsualGauge(1520.0, 1440.0, _OF_THE_EU, 1523.5),
    UsualGauge(1600.0, 1515.0, "Moherdaui (2021), 7.2.1", 1635.0),
    UsualGauge(1668.0, 1593.0, _OF_THE_EU, 1671.5),
)
"""Gauges whose wheelsets are known from a source, with the distance of the wheels' inner faces."""


def usual_gauge(gauge_mm: float) -> UsualGauge:
    """Return the usual gauge that a track is built to.

    An `InputError` if there is none with a source for its wheelsets: the distance of the wheels is needed then.
    """
    for usual in USUAL_GAUGES:
        if usual.includes(gauge_mm):
            return usual
    raise InputError(
        f"track.gauge_mm = {gauge_mm:g} without wheelset.back_to_back_mm",
        "both, or a gauge whose wheelsets are known, "
        + ", ".join(f"{usual.gauge_mm:g}" for usual in USUAL_GAUGES[:-1])
        + f", {USUAL_GAUGES[-1].gauge_mm:g} mm, somewhat narrowed or widened",
        "give the distance between the wheels' inner faces as wheelset.back_to_back_mm",
    )


GaugeAt = Literal["within-depth", "unworn", "narrowest"]
_DEVIATION_MM = 1e-6  # of the chords by which a head is measured from its arcs
_REACH_TOLERANCE_MM = 1e-3  # by which a gauge face may end above the depth of the gauge


class GaugePoint(NamedTuple):
    """Point of an inclined head to which the gauge is measured, in the frame of the profile after its inclination.

    - `x_mm`: its lateral position.
    - `depth_mm`: its depth below the top.
    - `top_mm`: height of the top.
    - `reach_mm`: depth to which the head goes down at its gauge side.
    """

    x_mm: float
    depth_mm: float
    top_mm: float
    reach_mm: float


@lru_cache(maxsize=32)
def gauge_point(head: Contour, inclination_rad: float, depth_mm: float) -> GaugePoint:
    """Innermost point of a head from its top down to a depth (EN 13848-1), as a gauge rod in the track plane finds it.

    - `head`: in the frame of its profile, the gauge side at negative x.
    - `inclination_rad`: rotation towards the middle of the track.
    - `depth_mm`: below the top of the inclined head; inf: the whole head.
    """
    inclined = head.transformed(Placement(inclination_rad))
    (inner, _), (_, top) = inclined.bounds()
    points = inclined.sampled(max_deviation=_DEVIATION_MM)
    gauge_side = points[points[:, 0] <= points[np.argmax(points[:, 1]), 0]]
    reach = float(top - gauge_side[:, 1].min())
    if math.isinf(depth_mm):
        return GaugePoint(float(inner), float(top - points[np.argmin(points[:, 0]), 1]), float(top), reach)
    level = top - depth_mm
    at_level = crossings(points, level)
    within = np.vstack((points[points[:, 1] >= level], np.column_stack((at_level, np.full(len(at_level), level)))))
    x, y = within[np.argmin(within[:, 0])]
    return GaugePoint(float(x), float(top - y), float(top), reach)


def _profiles_of(kind: Kind, table: str, common: Any, own: Mapping[Side, Any]) -> dict[Side, Any]:
    """Rails or wheels by side, one object where the sides name the same.

    - `table`: where their inputs are, for messages.
    - `common`: what both sides have.
    - `own`: what each side has in its place; None: nothing.
    """
    inputs = {side: common if value is None else value for side, value in own.items()}
    paths = {side: f"{table}.{kind}" if value is None else f"{table}.{side}.{kind}" for side, value in own.items()}
    right = profile_of(inputs["right"], kind, paths["right"], inputs["left"])
    if inputs["left"] == inputs["right"]:
        return {"left": right, "right": right}
    return {"left": profile_of(inputs["left"], kind, paths["left"], inputs["right"]), "right": right}


class RigidRailSide(Record):
    """What a rigid rail of one side has of its own."""

    rail: RailInput | None = None
    """rail (default: that of the track)"""
    inclination: Annotated[float, at.Ge(-0.2), at.Le(0.2)] | None = None
    """inclination (default: that of the track)"""


class RailSide(RigidRailSide):
    """What the rail of one side has of its own."""

    support: Support | None = None
    """what it stands on (default: that of the track)"""
    friction: FrictionCoefficient | None = None
    """coefficient of friction, with rolling.friction a number (default: that)"""


class RigidTrack(Record):
    """Two rigid rails."""

    rail: RailInput = "60E1"
    """rail: 60E1, 60E2, 54E1, 49E1, 136RE (other crowns: 136RE-8, 136RE-14), S-519-A, or a file"""
    left: RigidRailSide = RigidRailSide()
    """what the left side has of its own"""
    right: RigidRailSide = RigidRailSide()
    """what the right side has of its own"""
    gauge_mm: Positive = 1435.0
    """track gauge, between the rails' heads"""
    gauge_depth_mm: Positive = GAUGE_DEPTH_MM
    """depth below the tops down to which the gauge is measured: 14 mm by EN 13848-1; North America has 15.875 mm"""
    gauge_at: GaugeAt = "within-depth"
    """within-depth: closest points of the heads down to gauge_depth_mm; unworn: those of the unworn heads, so that worn
    rails stand where they stood new; narrowest: closest points at any depth"""
    inclination: Annotated[float, at.Ge(-0.2), at.Le(0.2)] = 1.0 / 40.0
    """rail inclination, a slope; 1:40 is 0.025"""
    superelevation_base_mm: Positive | None = None
    """width over which superelevation is measured (default: the gauge and 65 mm, the running circles)"""

    @property
    def base_mm(self) -> float:
        """Width over which superelevation is measured."""
        base = self.superelevation_base_mm
        return self.gauge_mm + RUNNING_CIRCLES_MM if base is None else base

    @cached_property
    def rails(self) -> dict[Side, RailProfile]:
        """Rails by side, one object where the sides name the same."""
        own = {side: self.side(side).rail for side in SIDES}
        return _profiles_of("rail", "track", self.rail, own)

    def side(self, side: Side) -> RigidRailSide:
        """What a side has of its own."""
        return self.left if side == "left" else self.right

    @property
    def is_symmetric(self) -> bool:
        """Whether the left rail mirrors the right one."""
        return self.rail_of("left") is self.rail_of("right") and self.has_one_inclination

    @property
    def has_one_inclination(self) -> bool:
        """Whether both rails are inclined alike."""
        return self.inclination_of("left") == self.inclination_of("right")

    def rail_of(self, side: Side) -> RailProfile:
        """Profile of the rail of a side, in the right-hand form; an `InputError` if its file cannot be read."""
        return self.rails[side]

    def inclination_of(self, side: Side) -> float:
        """Inclination of the rail of a side towards the middle, a slope."""
        own = self.side(side).inclination
        return self.inclination if own is None else own

    def _angle(self, side: Side) -> float:
        return math.atan(self.inclination_of(side))

    def gauge_point(self, side: Side) -> GaugePoint:
        """Point of a rail that stands at half of the gauge from the middle of the track.

        An `InputError` if the head does not go down to `gauge_depth_mm`, or its unworn head is not known.
        """
        rail = self.rail_of(side)
        head = rail.placing_head or rail.running_surface
        if self.gauge_at == "narrowest":
            return gauge_point(head, self._angle(side), math.inf)
        if self.gauge_at == "unworn":
            if rail.unworn is None:
                raise InputError(
                    f"track.gauge_at = unworn, and the {side} rail {rail.title} without an unworn head",
                    "bundled rails, and files of heads on the body of one",
                    "name the bundled rail as body of the file, or leave gauge_at out",
                )
            head = rail.unworn
        at = gauge_point(head, self._angle(side), self.gauge_depth_mm)
        if at.reach_mm < self.gauge_depth_mm - _REACH_TOLERANCE_MM:
            raise InputError(
                f"track.gauge_depth_mm = {self.gauge_depth_mm:g}, below the head of the {side} rail",
                f"depths to {at.reach_mm:.1f} mm below the rail's top, as far as its gauge face goes down",
                "give a smaller gauge_depth_mm, gauge_at = narrowest, or a profile with its gauge face",
            )
        return at

    def placement(self, side: Side) -> Placement:
        """Where the rail of a side stands: inclined, its head at the gauge, its top at y = 0."""
        at = self.gauge_point(side)
        placement = Placement(self._angle(side), (self.gauge_mm / 2.0 - at.x_mm, -at.top_mm))
        return placement if side == "right" else mirrored(placement)

    @property
    def measured_gauge_mm(self) -> float | None:
        """Gauge of the heads as they are, down to `gauge_depth_mm` below their tops; None where one ends above it.

        It is `gauge_mm` where this is measured ``"within-depth"`` and no rail was placed by another head than its own.
        """
        width = self.gauge_mm
        for side in SIDES:
            at = gauge_point(self.rail_of(side).running_surface, self._angle(side), self.gauge_depth_mm)
            if at.reach_mm < self.gauge_depth_mm - _REACH_TOLERANCE_MM:
                return None
            width += at.x_mm - self.gauge_point(side).x_mm
        return width


class Track(RigidTrack):
    """Two rails on their supports."""

    left: RailSide = RailSide()
    """what the left side has of its own"""
    right: RailSide = RailSide()
    """what the right side has of its own"""
    support: Support = Sleepers()
    """what the rails stand on"""

    def side(self, side: Side) -> RailSide:
        """What a side has of its own."""
        return self.left if side == "left" else self.right

    @property
    def is_symmetric(self) -> bool:
        """Whether the left rail, with its support and friction, mirrors the right one."""
        alike = super().is_symmetric and self.support_of("left") == self.support_of("right")
        return alike and self.left.friction == self.right.friction

    def support_of(self, side: Side) -> Support:
        """What the rail of a side stands on."""
        return self.side(side).support or self.support


class WheelSide(Record):
    """What the wheel of one side has of its own."""

    wheel: WheelInput | None = None
    """wheel (default: that of the wheelset)"""
    radius_mm: Annotated[float, at.Ge(150.0)] | None = None
    """radius (default: radius_mm of the wheelset, at a flange's tip that of the right wheel)"""


class RigidWheelPair(Record):
    """Two rigid wheels on a rigid axle."""

    wheel: WheelInput = "S1002"
    """wheel: S1002, AAR-1B (an approximation), heavy-haul, R-519-A, -B, -C, -H, -I, or a file"""
    left: WheelSide = WheelSide()
    """what the left side has of its own"""
    right: WheelSide = WheelSide()
    """what the right side has of its own"""
    back_to_back_mm: Positive | None = None
    """distance between the wheels' inner faces (default: by the gauge, 1360 for 1435, 1440 for 1520, 1515 for 1600,
    1593 for 1668)"""
    radius_mm: Annotated[float, at.Ge(150.0)] = 460.0
    """rolling radius, at the position radius_at"""
    radius_at: Literal["flange-tip", "tape-line"] = "tape-line"
    """where radii are measured"""

    @cached_property
    def profiles(self) -> dict[Side, WheelProfile]:
        """Wheels by side, one object where the sides name the same."""
        own = {side: self.side(side).wheel for side in SIDES}
        return _profiles_of("wheel", "wheelset", self.wheel, own)

    def side(self, side: Side) -> WheelSide:
        """What a side has of its own."""
        return self.left if side == "left" else self.right

    @property
    def is_symmetric(self) -> bool:
        """Whether the left wheel mirrors the right one."""
        alike = self.wheel_of("left") is self.wheel_of("right")
        return alike and self.tape_radius_of("left") == self.tape_radius_of("right")

    @property
    def tape_radius_mm(self) -> float:
        """Rolling radius of the right wheel at the tape line."""
        return self.tape_radius_of("right")

    @property
    def tip_radius_mm(self) -> float:
        """Radius of the right wheel at the tip of its flange."""
        return self.tape_radius_mm + self.wheel_of("right").flange_height_mm

    def wheel_of(self, side: Side) -> WheelProfile:
        """Profile of the wheel of a side, in the right-hand form; an `InputError` if its file cannot be read."""
        return self.profiles[side]

    def tape_radius_of(self, side: Side) -> float:
        """Rolling radius of the wheel of a side at the tape line, in mm."""
        own = self.side(side).radius_mm
        radius, measured = (self.radius_mm, self.wheel_of("right")) if own is None else (own, self.wheel_of(side))
        return radius if self.radius_at == "tape-line" else radius - measured.flange_height_mm

    @property
    def distance_mm(self) -> float:
        """Distance of the wheels' inner faces of a wheelset that has one; see `RigidWheelPair.on`."""
        if self.back_to_back_mm is None:
            raise InputError("wheels without back_to_back_mm", "their distance", "give it, or take those of a wheelset")
        return self.back_to_back_mm

    def on(self, track: RigidTrack) -> Self:
        """Return the wheels with their distance, by the gauge of their track if none is given."""
        if self.back_to_back_mm is not None:
            return self
        _ = self.profiles  # read once for both
        return self.model_copy(update={"back_to_back_mm": usual_gauge(track.gauge_mm).back_to_back_mm})

    def placement(self, side: Side) -> Placement:
        """Where the wheel of a side stands in the reference position: the right tape line at y = 0, the axle level."""
        lateral = self.distance_mm / 2.0 + self.wheel_of(side).flange_back_mm
        placement = Placement(0.0, (lateral, self.tape_radius_mm - self.tape_radius_of(side)))
        return placement if side == "right" else mirrored(placement)


class WheelPair(RigidWheelPair):
    """Two wheels on an axle."""

    section: WheelSection = RimSection()
    """what of the wheels is elastic"""
    axle: Axle = ElasticAxle()
    """how the axle bends"""
    wheels: Literal["joined", "independent"] = "joined"
    """joined: both wheels roll at one rate of rotation; independent: each at its own, with half of the torque"""


@dataclass(frozen=True)
class WheelsetPosition:
    """Position of the wheelset: its rigid displacement from the reference position, axes of the track.

    - `lateral_mm`: translation of the axle's middle in x; on the line through the journals if the axle bends.
    - `vertical_mm`: translation of the axle's middle in y, up.
    - `roll_rad`: counter-clockwise rotation about the axle's middle.
    """

    lateral_mm: float = 0.0
    vertical_mm: float = 0.0
    roll_rad: float = 0.0

    def __post_init__(self) -> None:
        for name, value in zip(("lateral_mm", "vertical_mm", "roll_rad"), self.components, strict=True):
            check_finite("WheelsetPosition", name, value)
            object.__setattr__(self, name, float(value))  # searches give NumPy's numbers

    @property
    def components(self) -> tuple[float, float, float]:
        """Lateral and vertical displacement and roll."""
        return self.lateral_mm, self.vertical_mm, self.roll_rad

    def moved(self, other: "WheelsetPosition", part: float = 1.0) -> "WheelsetPosition":
        """Add a part of another displacement."""
        return WheelsetPosition(
            self.lateral_mm + part * other.lateral_mm,
            self.vertical_mm + part * other.vertical_mm,
            self.roll_rad + part * other.roll_rad,
        )

    def turned(self, angle_rad: float) -> "WheelsetPosition":
        """The same with its displacement along axes that are turned clockwise: in space for the tilt of the track."""
        cosine, sine = math.cos(angle_rad), math.sin(angle_rad)
        x, y = self.lateral_mm, self.vertical_mm
        return WheelsetPosition(cosine * x - sine * y, sine * x + cosine * y, self.roll_rad)

    def axle(self, wheelset: RigidWheelPair) -> tuple[float, float]:
        """Point in the middle of the axle."""
        return self.lateral_mm, wheelset.tape_radius_mm + self.vertical_mm

    def placement(self, wheelset: RigidWheelPair, side: Side) -> Placement:
        """Placement of the wheel of a side."""
        turn = Placement.about((0.0, wheelset.tape_radius_mm), self.roll_rad)
        shift = Placement(0.0, (self.lateral_mm, self.vertical_mm))
        return shift.after(turn).after(wheelset.placement(side))


def mirrored(placement: Placement) -> Placement:
    """Mirror image of a placement about the middle of the track."""
    x, y = placement.translation
    return Placement(-placement.rotation_rad, (-x, y), not placement.mirrored)


FLANGE_MM = 10.0
"""Depth below tread and rail's top at which flange and gauge face are compared (EN 15313 measures flanges there)."""


@lru_cache(maxsize=16)
def refuse_misfit(track: RigidTrack, wheelset: RigidWheelPair) -> None:
    """Refuse wheels that stand beside their rails, and flanges that do not go between them, in the middle of the track.

    An `InputError` if gauge and distance of the wheels do not fit; the message says by how much.
    """
    given = f"track.gauge_mm = {track.gauge_mm:g} and wheelset.back_to_back_mm = {wheelset.distance_mm:g} do not fit"
    allowed, room = "wheels that stand on the heads of the rails, with their flanges between these", 0.0
    usual = [gauge for gauge in USUAL_GAUGES if gauge.includes(track.gauge_mm)]
    advice = "check both" + "".join(
        f": {gauge.back_to_back_mm:g} goes with {gauge.gauge_mm:g}, and is taken where back_to_back_mm is left out"
        for gauge in usual
    )
    for side in SIDES:
        outward = SIDE_SIGN[side]
        wheel, rail = wheelset.wheel_of(side), track.rail_of(side)
        on_wheel = wheelset.placement(side).points(wheel.running_surface.sampled(spacing=0.5)) * [outward, 1.0]
        on_rail = track.placement(side).points(rail.running_surface.sampled(spacing=0.5)) * [outward, 1.0]
        (near, far), (inner, outer) = (
            (float(points[:, 0].min()), float(points[:, 0].max())) for points in (on_wheel, on_rail)
        )
        missed = max(inner - far, near - outer)
        if missed > 0.0:
            raise InputError(f"{given}: the {side} wheel misses its rail by {missed:.1f} mm", allowed, advice)
        flange, head = on_wheel[on_wheel[:, 1] <= -FLANGE_MM, 0], on_rail[on_rail[:, 1] >= -FLANGE_MM, 0]
        room += float(head.min() - flange.max()) if len(flange) else math.inf
    if room < 0.0:
        raise InputError(f"{given}: the flanges are {-room:.1f} mm too far apart for the rails", allowed, advice)
