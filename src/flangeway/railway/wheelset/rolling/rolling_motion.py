"""How a wheelset rolls: speed, curve, yaw, torque and friction."""

from dataclasses import dataclass, replace

import numpy as np

from flangeway.checks import check_finite, check_positive
from flangeway.contact.rolling.friction import Friction
from flangeway.contact.rolling.theories import Theory
from flangeway.errors import InputError
from flangeway.types import Floats

GAUGE_FACE_RAD = np.deg2rad(45.0)
"""Slope of the rail's surface from which it is the gauge face."""


@dataclass(frozen=True, eq=False)
class RollingMotion:
    """Motion of a wheelset that rolls ahead along the track, and friction.

    Parameters
    ----------
    speed_m_s
        Speed V of the axle's middle along the track, > 0. All creepages are slip over it.
    friction
        Coefficients of friction; `Friction.decay` in m/s.
    flange_friction
        Static coefficient on the gauge face, where the rail is steeper than 45 degrees; the kinetic one is less by the
        same factor. None: that of `friction`.
    curve_radius_m
        Radius of the curve, positive to the left; None: straight track.
    yaw_rate_rad_s
        Yaw rate relative to the track, counter-clockwise from above. The curve adds V / R.
    lateral_velocity_m_s
        Velocity of the axle's middle across the track, to the right.
    torque_Nm
        Torque on the wheelset about its axle: > 0 drives it ahead, < 0 brakes it, 0: it rolls freely.
    yaw_stiffness_Nm_per_rad
        Stiffness against yaw by which the yaw is found. The wheelset is guided to the yaw that is given otherwise, that
        of the axle in the bogie, relative to the radial direction of the track. 0: no guidance. None: the yaw is
        prescribed.
    theory
        Creep forces by the exact theory, FASTSIM, FaStrip, Polach's formula or linear theory.

    Raises
    ------
    InputError
        If a number is not finite, the speed not positive, or the radius 0.

    """

    speed_m_s: float
    friction: Friction
    flange_friction: float | None = None
    curve_radius_m: float | None = None
    yaw_rate_rad_s: float = 0.0
    lateral_velocity_m_s: float = 0.0
    torque_Nm: float = 0.0  # noqa: N815 (units in names)
    yaw_stiffness_Nm_per_rad: float | None = None  # noqa: N815
    theory: Theory = "exact"

    def __post_init__(self) -> None:
        check_positive(
            "RollingMotion", "speed_m_s", self.speed_m_s, "a speed > 0", "leave rolling out for a wheelset that stands"
        )
        for name in ("yaw_rate_rad_s", "lateral_velocity_m_s", "torque_Nm"):
            check_finite("RollingMotion", name, getattr(self, name))
        if self.curve_radius_m is not None and not (np.isfinite(self.curve_radius_m) and self.curve_radius_m != 0.0):
            raise InputError(
                f"RollingMotion(curve_radius_m={self.curve_radius_m})",
                "a radius above 0 to the left or below 0 to the right",
                "leave it out on straight track",
            )
        stiffness = self.yaw_stiffness_Nm_per_rad
        if stiffness is not None and not (np.isfinite(stiffness) and stiffness >= 0.0):
            raise InputError(
                f"RollingMotion(yaw_stiffness_Nm_per_rad={stiffness})",
                "a stiffness >= 0",
                "leave it out to hold the yaw",
            )
        _ = self.friction_on(np.array([[0.0, 1.0]]))

    @property
    def turning_rad_s(self) -> float:
        """Yaw rate in space, counter-clockwise from above."""
        return self.yaw_rate_rad_s + (0.0 if self.curve_radius_m is None else self.speed_m_s / self.curve_radius_m)

    @property
    def yaw_is_free(self) -> bool:
        """Whether the yaw is found."""
        return self.yaw_stiffness_Nm_per_rad is not None

    def friction_on(self, normals: Floats) -> Friction:
        """Friction of rows of cells with outward normals of the rail, (n, 2)."""
        if self.flange_friction is None:
            return self.friction
        own = Friction(self.flange_friction)
        static, kinetic = (each[0] for each in self.friction.limits)
        steep = np.abs(normals[:, 0]) > np.sin(GAUGE_FACE_RAD)
        share = kinetic / static if static > 0.0 else 1.0
        on_face = float(own.limits[0][0])
        return replace(
            self.friction, static=np.where(steep, on_face, static), kinetic=np.where(steep, share * on_face, kinetic)
        )
