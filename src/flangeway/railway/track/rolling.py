"""How a wheelset rolls: friction, theory of creep forces, speed, torque and guidance, as inputs."""

# ruff: noqa: N815 (units in names)
from functools import cached_property
from pathlib import Path

import numpy as np
from pydantic import model_validator

from flangeway.contact.rolling.fast_theories import WITH_TRACTIONS, Theory
from flangeway.contact.rolling.friction import MAX_FRICTION, Friction, FrictionCoefficient, FrictionInputs
from flangeway.errors import InputError
from flangeway.records import NotNegative, Positive, Record, refused_by_check
from flangeway.system.file_content import number_table
from flangeway.types import Bools, Floats

GAUGE_FACE_RAD = np.deg2rad(45.0)
"""Slope of the rail's surface from which it is the gauge face."""
ALONG_TRACK = ("distance_m", "friction")


def on_gauge_face(normals: Floats) -> Bools:
    """Whether cells with outward normals of the rail, (n, 2), are on its gauge face, (n,)."""
    return np.abs(normals[:, 0]) > np.sin(GAUGE_FACE_RAD)


class FrictionAlongTrack(Record):
    """Friction by the place along the track."""

    file: str
    """CSV file of the coefficient along the track: distance_m, friction, linear in between"""
    distance_m: float = 0.0
    """distance of the wheelset along the track"""

    @cached_property
    def coefficient(self) -> float:
        """Coefficient where the wheelset is; beyond the ends of the file that of its end."""
        allowed = f"a CSV file with the columns {', '.join(ALONG_TRACK)}: rising distances, coefficients up to 1"
        distances, coefficients = number_table(Path(self.file), ALONG_TRACK, allowed).T
        if (np.diff(distances) <= 0.0).any() or coefficients.min() < 0.0 or coefficients.max() > MAX_FRICTION:
            raise InputError(
                f"{self.file}: distances that do not rise, or coefficients out of range",
                allowed,
                "sort the lines, and correct the coefficients",
            )
        return float(np.interp(self.distance_m, distances, coefficients))


class RollingMotion(FrictionInputs):
    """Steady rolling ahead along the track, with creep forces by friction."""

    friction: FrictionCoefficient | FrictionAlongTrack = 0.3
    """coefficient of friction; 0: without friction"""
    flange_friction: FrictionCoefficient | None = None
    """coefficient on the gauge face, where the rail is steeper than 45 degrees (default: friction); the kinetic one is
    less by the same factor"""
    theory: Theory = "exact"
    """creep forces: exact theory, fastsim, fastrip, polach or linear theory"""
    speed_km_h: Positive | None = None
    """speed on straight track; in a curve that of load.curve"""
    torque_kNm: float = 0.0
    """torque on the axle: positive drives, negative brakes, 0 rolls freely"""
    yaw_stiffness_kNm_per_mrad: NotNegative | None = None
    """stiffness that guides the axle to position.yaw_mrad, 0: none; the yaw is then found (default: the yaw is
    prescribed)"""
    yaw_rate_mrad_per_s: float = 0.0
    """yaw rate relative to the track, counter-clockwise from above; the curve adds its own"""
    lateral_velocity_mm_per_s: float = 0.0
    """velocity of the axle across the track, to the right"""

    @model_validator(mode="after")
    def _falls_by_tractions(self) -> "RollingMotion":
        if self.theory not in WITH_TRACTIONS and self.falling is not None and self.falling.between_C is not None:
            given = f"falling.between_C with theory = {self.theory}, which has no temperatures"
            raise refused_by_check(given, f"theory = {', '.join(WITH_TRACTIONS)}", "leave between_C out")
        return self

    @property
    def coefficient(self) -> float:
        """Static coefficient of friction."""
        return self.friction.coefficient if isinstance(self.friction, FrictionAlongTrack) else self.friction

    @property
    def yaw_is_free(self) -> bool:
        """Whether the yaw is found."""
        return self.yaw_stiffness_kNm_per_mrad is not None

    @property
    def yaw_stiffness(self) -> float:
        """Stiffness against yaw in N mm/rad; 0 without guidance, and where the yaw is prescribed."""
        return 1e9 * (self.yaw_stiffness_kNm_per_mrad or 0.0)

    @property
    def torque(self) -> float:
        """Torque on the axle in N mm."""
        return 1e6 * self.torque_kNm

    def friction_on(self, normals: Floats, coefficient: float) -> Friction:
        """Friction of rows of cells with outward normals of the rail, (n, 2), for a static coefficient on the tread."""
        if self.flange_friction is None:
            return self.law(coefficient)
        return self.law(coefficient, np.where(on_gauge_face(normals), self.flange_friction, coefficient))
