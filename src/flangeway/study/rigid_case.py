"""Inputs of ``flangeway geometry``: a rigid wheelset on two rigid rails, its profiles, measures and load."""

import math
from dataclasses import replace
from pathlib import Path
from typing import Any, ClassVar, Literal

import numpy as np
from pydantic import Field

from flangeway.errors import InputError
from flangeway.geometry import Arc, Line, Outline, Segment
from flangeway.geometry.arrays import as_point
from flangeway.railway.joining import joined
from flangeway.railway.profile_file import FORMATS, read_profile
from flangeway.railway.profiles import RailProfile, WheelProfile, rail, wheel
from flangeway.railway.rigid_contact import RigidWheelset
from flangeway.railway.rigid_equilibrium import RigidLoad, superelevation_tilt
from flangeway.railway.rigid_side import RigidSide
from flangeway.railway.track import Side, Track, Wheelset
from flangeway.study.case import Case, closest


class GeometryCase(Case):
    """A rigid wheelset on two rigid rails."""

    name: ClassVar[str] = "geometry"
    title: ClassVar[str] = "Contact geometry of a rigid wheelset on rigid rails"

    rail: str = Field("136RE", description="rail: 136RE, 60E1, or a file that `flangeway profile` reads")
    crown_radius_in: float | None = Field(
        None, gt=0.0, description="radius of the crown of a 136RE: 8, 10 or 14 in; 10 if left out"
    )
    wheel: str = Field("AAR-1B", description="wheel: AAR-1B (an approximation), S1002, heavy-haul, or a file")
    left_rail: str | None = Field(None, description="rail of the left side, likewise; that of the right if left out")
    left_wheel: str | None = Field(None, description="wheel of the left side, likewise")
    rail_body: str = Field("136RE", description="bundled rail that gives the body of a file's head")
    wheel_body: str = Field("AAR-1B", description="bundled wheel that gives the body of a file's running surface")
    throat_radius_mm: float | None = Field(
        None, gt=0.0, description="radius of the narrow arc of the AAR-1B's throat; 14.29 if left out"
    )
    wide_throat_radius_mm: float | None = Field(
        None, gt=0.0, description="radius of the wide arc of the AAR-1B's throat; 38.1 if left out"
    )
    gauge_mm: float = Field(1600.0, gt=0.0, description="distance between the rails' heads")
    gauge_depth_mm: float | None = Field(
        None,
        gt=0.0,
        description="depth below the rail's top where the gauge is measured; the closest points if left out",
    )
    cant: float = Field(0.025, ge=-0.2, le=0.2, description="inclination of the rails as a slope; 1:40 is 0.025")
    back_to_back_mm: float = Field(1515.0, gt=0.0, description="distance between the wheels' inner faces")
    wheel_radius_mm: float = Field(500.0, ge=150.0, description="distance from the axle to the flange's tip")
    tape_radius_mm: float | None = Field(
        None, ge=150.0, description="rolling radius at the tape line, instead of wheel_radius_mm"
    )
    left_tape_radius_mm: float | None = Field(
        None, ge=150.0, description="rolling radius of the left wheel; that of the right if left out"
    )
    barycentre_height_mm: float = Field(1457.7, description="height of the car's barycentre above the axle")
    axle_load_kN: float = Field(300.0, gt=0.0, description="weight that the wheelset bears")  # noqa: N815
    lateral_force_kN: float = Field(  # noqa: N815
        0.0, description="horizontal force at the barycentre, to the right: centrifugal force of a curve to the left"
    )
    superelevation_mm: float = Field(0.0, description="height of the right rail over the left one")
    superelevation_base_mm: float | None = Field(
        None, gt=0.0, description="width over which it is measured; the gauge if left out"
    )
    thickness_mm: float = Field(10.0, gt=0.0, description="length of the bodies along the track, for Hertz's estimate")
    young_MPa: float = Field(210e3, gt=0.0, description="Young's modulus, for Hertz's estimate")  # noqa: N815
    poisson: float = Field(0.3, gt=-1.0, lt=0.5, description="Poisson's ratio, for Hertz's estimate")
    largest_lateral_mm: float = Field(8.0, gt=0.0, le=60.0, description="largest lateral motion that is shown")
    step_mm: float = Field(0.02, ge=1e-3, le=1.0, description="distance of the positions")
    largest_amplitude_mm: float = Field(6.0, gt=0.0, le=30.0, description="largest amplitude of the conicity")
    roll: Literal["free", "none"] = Field(
        "free", description="free: both wheels touch; none: no roll, as in the reference results of EN 15302"
    )

    def wheelset(self) -> RigidWheelset:
        """Return the rigid curves.

        Raises
        ------
        InputError
            If a profile is unknown or a length is not allowed.

        """
        throats = (self.throat_radius_mm, self.wide_throat_radius_mm)
        if throats != (None, None) and "AAR-1B" not in (self.wheel, self.left_wheel):
            raise InputError(f"throat radii for the wheel {self.wheel}", "AAR-1B", "leave them out")
        right = self._side("right", self.rail, self.wheel, self.tape_radius_mm)
        left = self._side(
            "left",
            self.rail if self.left_rail is None else self.left_rail,
            self.wheel if self.left_wheel is None else self.left_wheel,
            self.tape_radius_mm if self.left_tape_radius_mm is None else self.left_tape_radius_mm,
        )
        height = -float(right.wheel_frame.translation[1])
        found = RigidWheelset(left, right, height)
        return found if self.gauge_depth_mm is None else found.with_gauge(self.gauge_mm, self.gauge_depth_mm)

    def _side(self, side: Side, rail_name: str, wheel_name: str, tape_radius_mm: float | None) -> RigidSide:
        profile = self._wheel(wheel_name)
        radius = self.wheel_radius_mm if tape_radius_mm is None else tape_radius_mm + profile.flange_height_mm
        track = Track(self._rail(rail_name), self.gauge_mm, self.cant)
        return RigidSide.of(track, Wheelset(profile, self.back_to_back_mm, radius, self.barycentre_height_mm), side)

    def _rail(self, name: str) -> RailProfile:
        found: RailProfile | WheelProfile
        if _is_file(name):
            found = joined(read_profile(name), self.rail_body).profile
        else:
            found = rail(name, crown_radius_in=self.crown_radius_in)
        if not isinstance(found, RailProfile):
            raise InputError(f"rail = {name}, a wheel", "a rail", "exchange the keys rail and wheel")
        return found

    def _wheel(self, name: str) -> WheelProfile:
        found: RailProfile | WheelProfile
        if _is_file(name):
            found = joined(read_profile(name), self.wheel_body).profile
        else:
            found = wheel(name, throat_radius_mm=self.throat_radius_mm if name == "AAR-1B" else None)
            if self.wide_throat_radius_mm is not None and name == "AAR-1B":
                found = with_wide_throat(found, self.wide_throat_radius_mm)
        if not isinstance(found, WheelProfile):
            raise InputError(f"wheel = {name}, a rail", "a wheel", "exchange the keys rail and wheel")
        return found

    def load(self) -> RigidLoad:
        """Return the load."""
        base = self.gauge_mm if self.superelevation_base_mm is None else self.superelevation_base_mm
        return RigidLoad(
            1e3 * self.axle_load_kN,
            1e3 * self.lateral_force_kN,
            superelevation_tilt(self.superelevation_mm, base),
            self.barycentre_height_mm,
        )


def _is_file(name: str) -> bool:
    path = Path(name)
    return path.suffix.lower() in FORMATS or path.exists()


GEOMETRY_CASES: dict[str, tuple[str, dict[str, Any]]] = {
    "wheelset-tangent": ("136RE and AAR-1B on straight, level track", {}),
    "wheelset-curve": (
        "136RE and AAR-1B in a curve of 400 m at 70 km/h, superelevation 3 cm",
        {"lateral_force_kN": 28.4, "superelevation_mm": 30.0, "largest_lateral_mm": 9.9},
    ),
    "s1002-60e1": (
        "S1002 on 60E1 at 1:40, gauge 1435 mm, back-to-back 1360 mm, rolling radius 460 mm",
        {
            "rail": "60E1",
            "wheel": "S1002",
            "gauge_mm": 1435.0,
            "gauge_depth_mm": 14.0,
            "back_to_back_mm": 1360.0,
            "tape_radius_mm": 460.0,
            "barycentre_height_mm": 1000.0,
            "axle_load_kN": 225.0,
            "largest_lateral_mm": 7.0,
        },
    ),
}
"""Title and what differs from the defaults, by name."""


def find_geometry_case(name: str, values: dict[str, Any]) -> GeometryCase:
    """Return a case by its name with some inputs changed.

    Raises
    ------
    InputError
        If there is none of that name, or an input is wrong.

    """
    if name not in GEOMETRY_CASES:
        raise InputError(
            f"a geometry case called {name!r}",
            f"one of: {', '.join(GEOMETRY_CASES)}",
            closest(name, list(GEOMETRY_CASES)),
        )
    return GeometryCase.from_values({**GEOMETRY_CASES[name][1], **values})


def with_wide_throat(profile: WheelProfile, radius_mm: float) -> WheelProfile:
    """Return an AAR-1B with another radius of the wide arc between tread and narrow arc, tangent to both.

    Parameters
    ----------
    profile
        Wheel with segments ``throat_R1``, ``throat_R2`` and ``tread_1:20``.
    radius_mm
        Radius, larger than that of the narrow arc.

    Raises
    ------
    InputError
        If the wheel has no such arcs, or no arc of the radius is tangent to both neighbours.

    """
    parts: dict[str, Segment] = dict(zip(profile.outline.names, profile.outline.segments, strict=True))
    narrow, wide, tread = (parts.get(part) for part in ("throat_R1", "throat_R2", "tread_1:20"))
    if not (isinstance(narrow, Arc) and isinstance(wide, Arc) and isinstance(tread, Line)):
        raise InputError(f"wide_throat_radius_mm for {profile.title}", "AAR-1B", "leave it out")
    along, off = tread.tangent(0.0)[0], tread.normal(0.0)[0]
    # the outline has the wheel on its left: the throat's hollow arcs have their centres on its right
    arm = np.array(narrow.centre) - np.array(tread.start)
    depth, place = float(arm @ off), float(arm @ along)
    square = (radius_mm - narrow.radius) ** 2 - (radius_mm - depth) ** 2
    if radius_mm <= narrow.radius or square <= 0.0:
        raise InputError(
            f"wide_throat_radius_mm = {radius_mm:g}",
            f"more than {0.5 * (narrow.radius + depth):.1f} mm",
            "leave it out for 38.1 mm",
        )
    foot = np.array(tread.start) + (place + math.sqrt(square)) * along
    centre = foot + radius_mm * off
    ray = np.array(narrow.centre) - centre
    joint = as_point(centre + radius_mm * ray / np.hypot(*ray))
    parts["throat_R1"] = Arc(narrow.start, joint, narrow.centre, narrow.counter_clockwise)
    parts["throat_R2"] = Arc(joint, as_point(foot), as_point(centre), wide.counter_clockwise)
    parts["tread_1:20"] = Line(as_point(foot), tread.end)
    return replace(profile, outline=Outline.from_segments(parts.values(), parts.keys()))
