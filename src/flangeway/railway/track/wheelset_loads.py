"""Loads of a wheelset: weight, lateral force or curve, superelevation, and the position in which it is held."""

# ruff: noqa: N815 (units in names)
import math
from dataclasses import dataclass
from typing import Annotated, Literal

import annotated_types as at
from pydantic import AfterValidator, WithJsonSchema

from flangeway.records import NotNegative, Positive, Record, refused_by_check

GRAVITY_M_S2 = 9.80665  # standard acceleration of free fall
MAX_SLOPE = 0.2  # largest superelevation relative to its base width
N_AXLES = 4  # wheelsets of a usual wagon
CENTRE_OF_GRAVITY_MM = 1457.7  # height above the axle of the source's car (Moherdaui 2021, 7.2.1)


def _is_not_zero(radius_m: float) -> float:
    if radius_m == 0.0:
        raise refused_by_check(
            "a radius of 0",
            "a radius above 0 for a curve to the left, below 0 for one to the right",
            "give a radius, or leave the curve out on straight track",
        )
    return radius_m


Radius = Annotated[float, AfterValidator(_is_not_zero), WithJsonSchema({"type": "number", "not": {"const": 0}})]


class Car(Record):
    """A car whose mass its wheelsets share."""

    mass_t: Positive
    """mass of the car"""
    n_axles: Annotated[int, at.Ge(1)] = N_AXLES
    """wheelsets that share it"""


class FromSpeed(Record):
    """Superelevation at which weight and centrifugal force have no lateral part in the track's plane, less a part."""

    kind: Literal["from-speed"] = "from-speed"
    """equilibrium superelevation of speed and radius"""
    cant_deficiency_mm: NotNegative = 0.0
    """equilibrium superelevation less the one that there is"""


class Curve(Record):
    """A curve in which the wheelset rolls."""

    radius_m: Radius
    """radius of the curve, positive to the left, negative to the right"""
    speed_km_h: NotNegative
    """speed, for the centrifugal force and rolling"""
    superelevation_mm: float | FromSpeed = 0.0
    """superelevation, outer rail of the curve over the inner one, negative: adverse cant; from-speed: equilibrium
    superelevation of speed and radius"""

    def height_mm(self, base_mm: float) -> float:
        """Height of the right rail over the left one, measured over a base width."""
        if not isinstance(self.superelevation_mm, FromSpeed):
            return math.copysign(1.0, self.radius_m) * self.superelevation_mm + 0.0
        balanced = balanced_superelevation_mm(self.speed_km_h, self.radius_m, base_mm)
        deficiency = self.superelevation_mm.cant_deficiency_mm
        what = f"{abs(balanced):.4g} mm of equilibrium superelevation at {self.speed_km_h:g} km/h and "
        what += f"{abs(self.radius_m):g} m"
        if deficiency > abs(balanced):
            given = f"load.curve.superelevation_mm.cant_deficiency_mm = {deficiency:g}"
            raise refused_by_check(given, f"at most the {what}", "lower it, or raise the speed")
        if abs(balanced) - deficiency > MAX_SLOPE * base_mm:
            raise refused_by_check(
                f"load.curve.superelevation_mm = from-speed: the {what}",
                f"at most {MAX_SLOPE * base_mm:g} mm, a fifth of track.superelevation_base_mm",
                "give the actual superelevation, or a cant_deficiency_mm",
            )
        return math.copysign(abs(balanced) - deficiency, balanced)


class Load(Record):
    """Weight on the wheelset, and the forces of a curve."""

    exclusive = (
        ("axle_load_kN", "car"), ("lateral_force_kN", "curve"), ("superelevation_mm", "curve"),
    )  # fmt: skip

    axle_load_kN: Annotated[float, at.Gt(0.0), at.Le(1e5)] = 200.0
    """axle load, weight on both rails"""
    car: Car | None = None
    """car whose mass its wheelsets share, instead of axle_load_kN"""
    centre_of_gravity_height_mm: float = CENTRE_OF_GRAVITY_MM
    """height of the car's centre of gravity above the axle"""
    offset_mm: float = 0.0
    """lateral distance of the car's centre of gravity from the axle's middle, to the right"""
    lateral_force_kN: float = 0.0
    """horizontal force at the centre of gravity, to the right: centrifugal force of a curve to the left"""
    superelevation_mm: float = 0.0
    """height of the right rail over the left one, without a curve"""
    curve: Curve | None = None
    """curve whose centrifugal force and superelevation act, instead of lateral_force_kN and superelevation_mm"""

    @property
    def weight_N(self) -> float:  # noqa: N802
        """Weight on the wheelset in N."""
        if self.car is not None:
            return 1e3 * self.car.mass_t / self.car.n_axles * GRAVITY_M_S2
        return 1e3 * self.axle_load_kN

    def forces(self, base_mm: float) -> "WheelsetLoad":
        """Weight, lateral force and tilt of the track, its superelevation measured over a base width."""
        weight, lateral, height = self.weight_N, 1e3 * self.lateral_force_kN, self.superelevation_mm
        if self.curve is not None:
            lateral = curve_force_N(weight, self.curve.speed_km_h, self.curve.radius_m)
            height = self.curve.height_mm(base_mm)
        tilt = superelevation_angle(height, base_mm)
        return WheelsetLoad(weight, lateral, tilt, self.centre_of_gravity_height_mm, self.offset_mm)


@dataclass(frozen=True)
class WheelsetLoad:
    """Force at the car's centre of gravity: weight along the vertical, lateral force along the horizontal.

    - `vertical_N`: weight, down, > 0.
    - `lateral_N`: horizontal force to the right: the centrifugal force of a curve to the left.
    - `tilt_rad`: rotation of the track by its superelevation, counter-clockwise: positive lifts the right rail.
    - `height_mm`, `offset_mm`: height of the centre of gravity above the axle's middle, and distance to its right, in
      the axes of the axle.
    """

    vertical_N: float
    lateral_N: float = 0.0
    tilt_rad: float = 0.0
    height_mm: float = CENTRE_OF_GRAVITY_MM
    offset_mm: float = 0.0

    @property
    def in_track(self) -> tuple[float, float]:
        """Lateral force in the track's plane, to the right, and force onto it, in N."""
        cosine, sine = math.cos(self.tilt_rad), math.sin(self.tilt_rad)
        along = self.lateral_N * cosine - self.vertical_N * sine
        onto = self.vertical_N * cosine + self.lateral_N * sine
        return along, onto

    @property
    def is_symmetric(self) -> bool:
        """Whether it acts in the middle, onto the track."""
        return not (self.in_track[0] or self.offset_mm)

    def centre_of_gravity(self, roll_rad: float) -> tuple[float, float]:
        """Point where it acts, to the right of the axle's middle and above it, at a roll."""
        cosine, sine = math.cos(roll_rad), math.sin(roll_rad)
        return self.offset_mm * cosine - self.height_mm * sine, self.offset_mm * sine + self.height_mm * cosine


def curve_force_N(weight_N: float, speed_km_h: float, radius_m: float) -> float:  # noqa: N802
    """Centrifugal force of a weight in a curve, ``(W / g) v^2 / R``: to the right in a curve to the left, R > 0."""
    return weight_N / GRAVITY_M_S2 * (speed_km_h / 3.6) ** 2 / radius_m


def balanced_superelevation_mm(speed_km_h: float, radius_m: float, base_mm: float) -> float:
    """Superelevation at which weight and centrifugal force have no lateral part in the track's plane, signed as R."""
    return base_mm * math.sin(math.atan((speed_km_h / 3.6) ** 2 / (GRAVITY_M_S2 * radius_m)))


def superelevation_angle(superelevation_mm: float, base_mm: float) -> float:
    """Tilt in rad of a track whose right rail is higher by `superelevation_mm`, measured over a base width."""
    if abs(superelevation_mm) > MAX_SLOPE * base_mm:
        raise refused_by_check(
            f"superelevation_mm = {superelevation_mm:g} over a base of {base_mm:g} mm",
            "at most a fifth of the base width",
            "give both in mm; 3 cm is 30",
        )
    return math.asin(superelevation_mm / base_mm)


class Position(Record):
    """Components of the wheelset's position that are prescribed, in the axes of the track; the others are computed.

    What holds them acts at the middle of the axle.
    """

    lateral_mm: float | None = None
    """lateral position of the axle's middle (default: computed)"""
    vertical_mm: float | None = None
    """vertical position (default: computed); the force follows from it"""
    roll_rad: float | None = None
    """roll, counter-clockwise (default: computed)"""
    yaw_mrad: Annotated[float, at.Ge(-200.0), at.Le(200.0)] = 0.0
    """yaw of the axle, positive where the right wheel is ahead"""

    @property
    def components(self) -> tuple[float | None, float | None, float | None]:
        """Lateral and vertical position and roll, as far as they are prescribed."""
        return self.lateral_mm, self.vertical_mm, self.roll_rad

    @property
    def yaw_rad(self) -> float:
        """Yaw in rad."""
        return 1e-3 * self.yaw_mrad
