"""Where the rails and the wheels stand (Moherdaui 2021, 7.2.1; readings in `docs/readings.md`).

Axes of the track: x across it to the right, y up from its plane, origin in the middle of the track at the top of the
rails. Without superelevation they are those of space.
Profiles are those of the right side, their track side at negative x; the left side is their mirror image.
"""

import math
from dataclasses import dataclass
from functools import lru_cache
from typing import Literal, NamedTuple, get_args

import numpy as np

from flangeway.checks import check_between, check_finite, check_positive, refused
from flangeway.errors import InputError
from flangeway.geometry import Contour, Placement
from flangeway.railway.profiles.bundled import RailProfile, WheelProfile
from flangeway.railway.profiles.orientation import GAUGE_DEPTH_MM, crossings
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
        f"gauge_mm = {gauge_mm:g} without back_to_back_mm",
        "gauge_mm and back_to_back_mm, or a gauge whose wheelsets are known, "
        + ", ".join(f"{usual.gauge_mm:g}" for usual in USUAL_GAUGES[:-1])
        + f", {USUAL_GAUGES[-1].gauge_mm:g} mm, somewhat narrowed or widened",
        "give the distance between the wheels' inner faces as back_to_back_mm",
    )


def _require_positive(owner: str, **lengths: float | None) -> None:
    for name, value in lengths.items():
        if value is not None:
            check_positive(owner, name, value, "a positive length", "give it in mm")


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


@dataclass(frozen=True)
class Track:
    """Two rails, fixed along their bases.

    Parameters
    ----------
    rail
        Profile of the right rail.
    gauge_mm
        Distance between the two rails' heads, half of it on each side of the middle.
    rail_inclination
        Inclination of the rails towards the middle, as a slope (1/40).
    left_rail
        Profile of the left rail, in the right-hand form; None: the left rail mirrors the right one.
    gauge_depth_mm
        Depth below the rails' tops down to which the gauge is measured, 14 mm by EN 13848-1, 5/8 in in North America.
    gauge_at
        Where the gauge is measured: ``"within-depth"``: where the heads are closest down to `gauge_depth_mm` below
        their tops; ``"unworn"``: there on the unworn heads, so that worn rails stand where they stood new;
        ``"narrowest"``: where the heads are closest at any depth.
    """

    rail: RailProfile
    gauge_mm: float = 1600.0
    rail_inclination: float = 1.0 / 40.0
    left_rail: RailProfile | None = None
    gauge_depth_mm: float = GAUGE_DEPTH_MM
    gauge_at: GaugeAt = "within-depth"

    def __post_init__(self) -> None:
        for name in ("gauge_mm", "gauge_depth_mm"):
            check_positive("Track", name, getattr(self, name), "a positive length", "give it in mm")
        check_between("Track", "rail_inclination", self.rail_inclination, -0.2, 0.2, advice="give 1:40 as 0.025")
        if self.gauge_at not in get_args(GaugeAt):
            allowed = f"one of {', '.join(get_args(GaugeAt))}"
            raise refused("Track", "gauge_at", self.gauge_at, allowed, "choose one of these")

    @property
    def is_symmetric(self) -> bool:
        """Whether the left rail mirrors the right one."""
        return self.left_rail is None

    def rail_of(self, side: Side) -> RailProfile:
        """Profile of the rail of a side, in the right-hand form."""
        return self.left_rail if side == "left" and self.left_rail is not None else self.rail

    @property
    def _angle(self) -> float:
        return math.atan(self.rail_inclination)

    def gauge_point(self, side: Side) -> GaugePoint:
        """Point of a rail that stands at half of the gauge from the middle of the track.

        An `InputError` if the head does not go down to `gauge_depth_mm`, or its unworn head is not known.
        """
        rail = self.rail_of(side)
        head = rail.placing_head or rail.running_surface
        if self.gauge_at == "narrowest":
            return gauge_point(head, self._angle, math.inf)
        if self.gauge_at == "unworn":
            if rail.unworn is None:
                raise InputError(
                    f"gauge_at = unworn, and the {side} rail {rail.title} without an unworn head",
                    "bundled rails, and files of heads on the body of one",
                    "name the bundled rail as rail_body, or leave gauge_at out",
                )
            head = rail.unworn
        at = gauge_point(head, self._angle, self.gauge_depth_mm)
        if at.reach_mm < self.gauge_depth_mm - _REACH_TOLERANCE_MM:
            raise InputError(
                f"gauge_depth_mm = {self.gauge_depth_mm:g}, below the head of the {side} rail",
                f"depths to {at.reach_mm:.1f} mm below the rail's top, as far as its gauge face goes down",
                "give a smaller gauge_depth_mm, gauge_at = narrowest, or a profile with its gauge face",
            )
        return at

    def placement(self, side: Side) -> Placement:
        """Where the rail of a side stands: inclined, its head at the gauge, its top at y = 0."""
        at = self.gauge_point(side)
        placement = Placement(self._angle, (self.gauge_mm / 2.0 - at.x_mm, -at.top_mm))
        return placement if side == "right" else mirrored(placement)

    @property
    def measured_gauge_mm(self) -> float | None:
        """Gauge of the heads as they are, down to `gauge_depth_mm` below their tops; None where one ends above it.

        It is `gauge_mm` where this is measured ``"within-depth"`` and no rail was placed by another head than its own.
        """
        width = self.gauge_mm
        for side in SIDES:
            at = gauge_point(self.rail_of(side).running_surface, self._angle, self.gauge_depth_mm)
            if at.reach_mm < self.gauge_depth_mm - _REACH_TOLERANCE_MM:
                return None
            width += at.x_mm - self.gauge_point(side).x_mm
        return width


@dataclass(frozen=True)
class Wheelset:
    """Two wheels on a rigid axle that carries the load.

    Parameters
    ----------
    wheel
        Profile of the right wheel.
    back_to_back_mm
        Distance between the inner faces of the wheels.
    radius_mm
        Maximum radius of the wheel, that of the tip of the flange.
    centre_of_gravity_height_mm
        Height above the axle of the point where the load acts.
    left_wheel
        Profile of the left wheel, in the right-hand form; None: the left wheel mirrors the right one.
    left_radius_mm
        As `radius_mm` for the left wheel; None: both have the same rolling radius at the tape line.
    """

    wheel: WheelProfile
    back_to_back_mm: float = 1515.0
    radius_mm: float = 500.0
    centre_of_gravity_height_mm: float = 1457.7
    left_wheel: WheelProfile | None = None
    left_radius_mm: float | None = None

    def __post_init__(self) -> None:
        for name in ("back_to_back_mm", "radius_mm"):
            check_positive("Wheelset", name, getattr(self, name), "a positive length", "give it in mm")
        _require_positive("Wheelset", left_radius_mm=self.left_radius_mm)
        advice = "give the height above the axle in mm"
        check_finite(
            "Wheelset", "centre_of_gravity_height_mm", self.centre_of_gravity_height_mm, "a finite length", advice
        )

    @property
    def is_symmetric(self) -> bool:
        """Whether the left wheel mirrors the right one."""
        return self.left_wheel is None and self.left_radius_mm is None

    @property
    def tape_radius_mm(self) -> float:
        """Rolling radius of the right wheel at the tape line."""
        return self.radius_mm - self.wheel.flange_height_mm

    def wheel_of(self, side: Side) -> WheelProfile:
        """Profile of the wheel of a side, in the right-hand form."""
        return self.left_wheel if side == "left" and self.left_wheel is not None else self.wheel

    def tape_radius_of(self, side: Side) -> float:
        """Rolling radius of the wheel of a side at the tape line, in mm."""
        if side == "right" or self.left_radius_mm is None:
            return self.tape_radius_mm
        return self.left_radius_mm - self.wheel_of("left").flange_height_mm

    def placement(self, side: Side) -> Placement:
        """Where the wheel of a side stands in the reference position: the right tape line at y = 0, the axle level."""
        lateral = self.back_to_back_mm / 2.0 + self.wheel_of(side).flange_back_mm
        placement = Placement(0.0, (lateral, self.tape_radius_mm - self.tape_radius_of(side)))
        return placement if side == "right" else mirrored(placement)


@dataclass(frozen=True)
class WheelsetPosition:
    """Position of the wheelset: its rigid displacement from the reference position, axes of the track.

    - `lateral_mm`: translation of the axle's middle in x.
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

    def axle(self, wheelset: Wheelset) -> tuple[float, float]:
        """Point in the middle of the axle."""
        return self.lateral_mm, wheelset.tape_radius_mm + self.vertical_mm

    def centre_of_gravity(self, wheelset: Wheelset) -> tuple[float, float]:
        """Point where the load acts."""
        x, y = self.axle(wheelset)
        height = wheelset.centre_of_gravity_height_mm
        return x - height * math.sin(self.roll_rad), y + height * math.cos(self.roll_rad)

    def placement(self, wheelset: Wheelset, side: Side) -> Placement:
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
def refuse_misfit(track: Track, wheelset: Wheelset) -> None:
    """Refuse wheels that stand beside their rails, and flanges that do not go between them, in the middle of the track.

    An `InputError` if gauge and distance of the wheels do not fit; the message says by how much.
    """
    given = f"gauge_mm = {track.gauge_mm:g} and back_to_back_mm = {wheelset.back_to_back_mm:g} do not fit"
    allowed, room = "wheels that stand on the heads of the rails, with their flanges between these", 0.0
    usual = [gauge for gauge in USUAL_GAUGES if gauge.includes(track.gauge_mm)]
    advice = "check gauge_mm and back_to_back_mm" + "".join(
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
