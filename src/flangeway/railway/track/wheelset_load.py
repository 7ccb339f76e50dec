"""Forces on the wheelset, and where they come from."""

import math
from dataclasses import dataclass

from flangeway.checks import check_finite, check_positive, is_finite, refused
from flangeway.errors import InputError
from flangeway.units import sentence

GRAVITY_M_S2 = 9.80665  # standard acceleration of free fall
MAX_SLOPE = 0.2  # largest superelevation over its base width


@dataclass(frozen=True)
class WheelsetLoad:
    """Force at the car's centre of gravity: weight along the vertical, lateral force along the horizontal.

    Parameters
    ----------
    vertical_N
        Weight, down, > 0.
    lateral_N
        Horizontal force to the right: the centrifugal force of a curve to the left.
    tilt_rad
        Rotation of the track by its superelevation, counter-clockwise: positive lifts the right rail.
    """

    vertical_N: float  # noqa: N815 (the unit newton)
    lateral_N: float = 0.0  # noqa: N815
    tilt_rad: float = 0.0

    def __post_init__(self) -> None:
        allowed = "a positive weight: it presses the wheels on the rails"
        advice = sentence("give the load of the axle in N, 300000 for {30 t}")
        check_positive("WheelsetLoad", "vertical_N", self.vertical_N, allowed, advice)
        check_finite("WheelsetLoad", "lateral_N", self.lateral_N, "a finite force in N", "leave it out for none")
        if not (is_finite(self.tilt_rad) and abs(self.tilt_rad) < 0.25):
            allowed, advice = "an angle between -0.25 and 0.25 rad", "check the superelevation"
            raise refused("WheelsetLoad", "tilt_rad", self.tilt_rad, allowed, advice)

    @property
    def in_track(self) -> tuple[float, float]:
        """Lateral force in the track's plane, to the right, and force onto it, in N."""
        cosine, sine = math.cos(self.tilt_rad), math.sin(self.tilt_rad)
        along = self.lateral_N * cosine - self.vertical_N * sine
        onto = self.vertical_N * cosine + self.lateral_N * sine
        return along, onto


def curve_force_N(weight_N: float, speed_km_h: float, radius_m: float) -> float:  # noqa: N802
    """Centrifugal force of a weight in a curve, ``(W / g) v^2 / R``: to the right in a curve to the left, R > 0."""
    return weight_N / GRAVITY_M_S2 * (speed_km_h / 3.6) ** 2 / radius_m


def balanced_superelevation_mm(speed_km_h: float, radius_m: float, base_mm: float) -> float:
    """Superelevation at which weight and centrifugal force have no lateral part in the track's plane, signed as R."""
    return base_mm * math.sin(math.atan((speed_km_h / 3.6) ** 2 / (GRAVITY_M_S2 * radius_m)))


def superelevation_angle(superelevation_mm: float, base_mm: float) -> float:
    """Tilt in rad of a track whose right rail is higher by `superelevation_mm`, measured over a base width."""
    if not (base_mm > 0.0 and abs(superelevation_mm) <= MAX_SLOPE * base_mm):
        raise InputError(
            sentence("{superelevation_mm = :g} over a base of {:g mm}", superelevation_mm, base_mm),
            "at most a fifth of the base width",
            sentence("give both in mm; {3 cm} is 30"),
        )
    return math.asin(superelevation_mm / base_mm)
