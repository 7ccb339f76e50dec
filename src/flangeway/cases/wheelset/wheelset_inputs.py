"""Inputs of a wheelset on two rails that the rigid and the elastic computation share, with profiles by name or file."""

# ruff: noqa: N815 (units in names)
import math
import re
from collections.abc import Sequence
from dataclasses import replace
from functools import lru_cache
from pathlib import Path
from typing import Any, ClassVar, Literal

from pydantic import Field

from flangeway.cases.case import Case
from flangeway.cases.patch_quantities import FRICTION_KEYS
from flangeway.cases.wheelset.wheelset_quantities import MOTION, PLANE_PATCH_ROW, PLANE_ROW, WheelResult, row_columns
from flangeway.errors import InputError
from flangeway.geometry import Outline
from flangeway.quantities import Quantity, column_names, numbers
from flangeway.railway.profiles.bundled import (
    RAILS,
    REFERENCE_RAIL,
    REFERENCE_WHEELS,
    WHEELS,
    RailProfile,
    WheelProfile,
    bundled_name,
    rail,
    wheel,
)
from flangeway.railway.profiles.flange_root import IDENTIFIED, identified_wheel
from flangeway.railway.profiles.formats.two_column import Kind
from flangeway.railway.profiles.joining import body_distance_mm, joined, nominal_profile, on_plain_body, whole_profile
from flangeway.railway.profiles.orientation import GAUGE_DEPTH_MM, ReadOptions
from flangeway.railway.profiles.profile_file import (
    FIELD_WORN,
    MIRRORED,
    READABLE,
    MeasuredProfile,
    read_profile,
    side_notices,
)
from flangeway.railway.track.placements import SIDES, USUAL_GAUGES, GaugeAt, Track, Wheelset, usual_gauge
from flangeway.railway.track.wheelset_problem import (
    GRAVITY_M_S2,
    MAX_SLOPE,
    WheelsetLoad,
    WheelsetProblem,
    balanced_superelevation_mm,
    curve_force_N,
    superelevation_angle,
)
from flangeway.records import LengthUnit, NotNegative, PoissonRatio, Positive, SolidModulus
from flangeway.system.file_content import is_file
from flangeway.units import Units

# --- Rails and wheels of cases by the names that users give: bundled ones, or files of profiles.


READ_AS_IT_IS = ReadOptions()
USUAL_BODIES: dict[Kind, tuple[str, ...]] = {"rail": ("136RE", "60E1"), "wheel": WHEELS}
"""Bodies that a file gets by itself; others, whose heads are much alike, are taken where they are named."""
PLAIN = "plain"  # body of a rail or wheel that fits no bundled one: a block beside its running surface


def profile_named(
    name: str,
    kind: Kind,
    options: ReadOptions = READ_AS_IT_IS,
    key: str = "",
    *,
    body: str | None = None,
    other: str | None = None,
    crown_radius_in: float | None = None,
) -> Any:
    """Return a bundled rail or wheel, a file's running surface on the body of a bundled one, or a file's whole outline.

    It is an `InputError` if there is none of that name, or the file is that of the other kind, cannot be read or does
    not fit the body.
    - `name`: of a bundled profile, or of a file.
    - `options`: what the file does not contain: unit, mirror, distance of the tape line.
    - `key`: name of the input, for messages: the options are called after it, such as ``rail_unit``; the kind if empty.
    - `body`: the bundled profile for a file's running surface; None: the other side's if it fits, else that of
      `USUAL_BODIES` nearest to most of the surface.
    - `other`: the profile of the other side.
    - `crown_radius_in`: radius of a 136RE's crown; None: the usual one.
    """
    key = key or kind
    if not _means_file(name):
        _refuse_other_kind(name, kind)
        _refuse_options(name, options, key)
        if kind == "rail":
            return rail(name, crown_radius_in=crown_radius_in)
        return identified_wheel() if name == IDENTIFIED else wheel(name)
    measured = _read(name, kind, options, key)
    if measured.kind != kind:
        raise InputError(
            f"{key} = {name}, which is the profile of a {measured.kind}",
            f"a {kind}",
            "exchange the keys rail and wheel",
        )
    return with_body(measured, name, key, body, other)


def _refuse_options(name: str, options: ReadOptions, key: str) -> None:
    for option, wrong in option_keys(key).items():
        if getattr(options, option) not in (None, False):
            raise InputError(f"{wrong} of the bundled {name}", "a file", f"leave {wrong} out")


def option_keys(key: str) -> dict[str, str]:
    """Names of the inputs with options for the file of a profile, by the fields of `ReadOptions`."""
    return {option: f"{key}_{option}" for option in ("unit", "mirror", "tape_mm")} | {"position": position_key(key)}


def position_key(key: str) -> str:
    """Name of the input with the position of a section in a file of slices, of one of the inputs with a profile."""
    return f"{key}_position_mm" if key.endswith("rail") else f"{key}_angle_deg"


_joined = lru_cache(maxsize=8)(joined)  # the nearest body is joined to see whether it fits, so it is joined already


def with_body(
    measured: MeasuredProfile, name: str, key: str, body: str | None = None, other: str | None = None
) -> RailProfile | WheelProfile:
    """Return a rail or wheel from what was read of a file, with its own body or that of a bundled one.

    Parameters and errors as of `profile_named`.
    """
    kind = measured.kind
    if isinstance(measured.surface, Outline):
        if body is not None and other in (None, name):
            raise InputError(
                f"{kind}_body = {body} for {name}, which is the whole outline",
                "a running surface",
                f"leave {kind}_body out",
            )
        return whole_profile(measured)
    bodies = (*(RAILS if kind == "rail" else WHEELS), PLAIN)
    body = body or _nearest_body(measured, other)
    if body != PLAIN:
        try:
            wanted = nominal_profile(body)
        except InputError as reason:
            raise InputError(
                f"{kind}_body = {body}", ", ".join(bodies), "choose the one nearest to the measured profile"
            ) from reason
        if isinstance(wanted, RailProfile) != (kind == "rail"):
            raise InputError(f"{kind}_body = {body}", ", ".join(bodies), f"a {kind} needs the body of a {kind}")
    try:
        return _on_body(measured, body)
    except InputError as reason:
        others = [other_body for other_body in bodies if other_body != body and _fits(measured, other_body)]
        advice = (
            f"flangeway profile {name} --join {body} shows how it is read; options give what the file does not contain"
        )
        if others:
            advice = f"is it the profile of another {kind}? Give {kind}_body = {' or '.join(others)}"
        given, allowed = (_as_keys(text, key) for text in (reason.given, reason.allowed))
        raise InputError(f"{key} = {name}: " + given, allowed, advice) from reason


def _as_keys(text: str, key: str) -> str:
    """Return a text that names options of ``flangeway profile`` with the keys that do the same in a case."""
    text = re.sub(r"--unit (mm|cm|m|in|ft)\b", rf"{key}_unit = \1", text)
    text = text.replace("--no-mirror", f"{key}_mirror = false")
    for option, name in (("unit", "unit"), ("mirror", "mirror"), ("tape", "tape_mm")):
        text = re.sub(rf"--{option}\b", f"{key}_{name}", text)
    return re.sub(r"--position( in \w+)?", position_key(key), text)


def _read(name: str, kind: Kind, options: ReadOptions, key: str) -> MeasuredProfile:
    """Read a file; where neither file nor shape shows whether it is a rail or a wheel, the key decides."""
    try:
        try:
            measured = read_profile(name, options)
        except InputError as reason:
            if "--kind" not in reason.allowed:
                raise
            measured = read_profile(name, replace(options, kind=kind))
    except InputError as reason:
        given, allowed, advice = (_as_keys(text, key) for text in (reason.given, reason.allowed, reason.advice))
        if "--" in f"{allowed} {advice}":
            advice += f": options of `flangeway profile {name}`, whose --to writes a file for {kind}"
        raise InputError(f"{key} = " + given, allowed, advice) from reason
    return replace(measured, notices=tuple(_as_keys(notice, key) for notice in measured.notices))


def _on_body(measured: MeasuredProfile, body: str) -> RailProfile | WheelProfile:
    return on_plain_body(measured) if body == PLAIN else _joined(measured, body).profile


def _fits(measured: MeasuredProfile, body: str) -> bool:
    try:
        _on_body(measured, body)
    except InputError:
        return False
    return True


def _nearest_body(measured: MeasuredProfile, other: str | None) -> str:
    """Return the other side's body if it fits, else the usual one nearest to most of the surface; see `PLAIN`."""
    names = USUAL_BODIES[measured.kind]
    known = RAILS if measured.kind == "rail" else WHEELS
    tried = dict.fromkeys((other, *names)) if other in known else names
    gaps = {name: gap for name in tried if name and (gap := body_distance_mm(measured, name)) is not None}
    nearest = sorted(gaps, key=lambda name: (name != other, gaps[name]))
    # sections of a crossing fit no rail
    last = PLAIN if measured.first_slice is not None else other if other in known else names[0]
    return next((name for name in nearest if _fits(measured, name)), last)


def _refuse_other_kind(name: str, kind: Kind) -> None:
    names = {"rail": (*RAILS, REFERENCE_RAIL), "wheel": (*WHEELS, *REFERENCE_WHEELS)}
    other: Kind = "wheel" if kind == "rail" else "rail"
    if bundled_name(name) in names[other]:
        raise InputError(
            f"{kind} = {name}, which is a {other}",
            ", ".join(names[kind]),
            "exchange the keys rail and wheel",
        )


def _means_file(name: str) -> bool:
    path = Path(name)
    return path.suffix.lower() in READABLE or is_file(path)


def gauge_note(track: Track) -> str:
    """Return where the gauge is measured, in a sentence."""
    heads = "unworn rails" if track.gauge_at == "unworn" else "rails"
    left, right = (track.gauge_point(side).depth_mm for side in SIDES)
    width, between = track.measured_gauge_mm, ""
    if width is not None and track.gauge_at != "within-depth":
        between = f"; down to {track.gauge_depth_mm:g} mm below the tops the heads are {width:.2f} mm apart"
    return (
        f"The gauge of {track.gauge_mm:g} mm is measured {left:.2f} (left) and {right:.2f} mm (right) below the tops "
        f"of the {heads}{between}."
    )


def profile_notes(track: Track, wheelset: Wheelset) -> list[str]:
    """Return where the gauge is measured, how far the profiles can be trusted, and what was assumed of their files."""
    wheels = [wheelset.wheel_of(side) for side in SIDES[::-1]]
    rails = [track.rail_of(side) for side in SIDES[::-1]]
    profiles: dict[RailProfile | WheelProfile, None] = dict.fromkeys([*wheels, *rails])
    return [
        gauge_note(track),
        *(f"{'Wheel' if profile in wheels else 'Rail'} {profile.title}. {profile.certainty}" for profile in profiles),
        *(
            notice + f" ({profile.title})"
            for profile in profiles
            for notice in profile.notices
            if not notice.startswith((MIRRORED, FIELD_WORN))
        ),
    ]


def side_warnings(track: Track) -> list[str]:
    """Return a warning for each rail that was mirrored, or is worn more at the side that no flange reaches."""
    rails = {"rail": track.rail_of("right"), "left_rail": None if track.is_symmetric else track.rail_of("left")}
    warnings = []
    for key, one in rails.items():
        if one is not None:
            mirrored = [notice for notice in one.notices if notice.startswith(MIRRORED)]
            warnings += [_as_keys(notice, key) for notice in mirrored or side_notices(one.running_surface)]
    return warnings


# --- Inputs of a wheelset on two rails that the rigid and the elastic computation share.


N_AXLES = 4  # wheelsets of a usual wagon
GAUGE_DEPTHS_MM: dict[Units, float] = {"metric": GAUGE_DEPTH_MM, "us": 0.625 * 25.4}
"""Depth below the rails' tops down to which the gauge is measured: EN 13848-1, and 5/8 in in North America."""

POSITION_KEYS = ("lateral_mm", "vertical_mm", "roll_rad", "axle_load_kN", "car_mass_t", "n_axles")
CURVE_KEYS = (
    *("lateral_force_kN", "speed_km_h", "curve_radius_m", "superelevation_mm", "cant_deficiency_mm"),
    "superelevation_base_mm",
)
ROLLING_KEYS = (
    *(*FRICTION_KEYS, "flange_friction", "rolling_theory", "torque_kNm"),
    *("yaw_stiffness_kNm_per_mrad", "yaw_rate_mrad_per_s", "lateral_velocity_mm_per_s"),
)
PLACE_KEYS = ("friction", "friction_file", "distance_m")
"""Inputs that leave the bodies as they are: of the position and its load, of the forces of a curve, those that have an
effect with friction only, and friction at a place along the track."""


class WheelsetInputs(Case):
    """Profiles, measures, load and material of a wheelset on two rails."""

    rail: str = "136RE"
    """rail: 136RE, 60E1, 60E2, 54E1, 49E1, S-519-A, or a file that `flangeway profile` reads"""
    crown_radius_in: Positive | None = None
    """radius of the crown of a 136RE: 8, 10 or 14 in (default: 10)"""
    wheel: str = "AAR-1B"
    """wheel: AAR-1B (an approximation), S1002, heavy-haul, R-519-A, -B, -C, -H, -I, or a file"""
    left_rail: str | None = None
    """rail of the left side, a name or a file (default: rail)"""
    left_wheel: str | None = None
    """wheel of the left side, a name or a file (default: wheel)"""
    rail_unit: LengthUnit | None = None
    """unit of the rail's file, if the file does not name one (default: mm)"""
    rail_mirror: bool | None = None
    """whether the rail's file contains a left-hand rail, to be mirrored (default: by its worn side)"""
    wheel_unit: LengthUnit | None = None
    """unit of the wheel's file, if the file does not name one (default: mm)"""
    wheel_mirror: bool = False
    """whether the wheel's file contains a left-hand wheel, to be mirrored"""
    wheel_tape_mm: float | None = Field(None, ge=40.0, le=110.0)
    """tape line from the flange's back (default: from the file, else measured, else 70)"""
    left_rail_unit: LengthUnit | None = None
    """rail_unit of left_rail"""
    left_rail_mirror: bool | None = None
    """rail_mirror of left_rail"""
    left_wheel_unit: LengthUnit | None = None
    """wheel_unit of left_wheel"""
    left_wheel_mirror: bool = False
    """wheel_mirror of left_wheel"""
    left_wheel_tape_mm: float | None = Field(None, ge=40.0, le=110.0)
    """wheel_tape_mm of left_wheel"""
    rail_position_mm: float | None = None
    """section of a rail in a .slcs file, along the track"""
    wheel_angle_deg: float | None = None
    """section of a wheel in a .slcw file, around the axle"""
    left_rail_position_mm: float | None = None
    """rail_position_mm of left_rail"""
    left_wheel_angle_deg: float | None = None
    """wheel_angle_deg of left_wheel"""
    rail_body: str | None = None
    """bundled rail with web and foot for a file's head, or plain (default: that of the other side, else the
    nearest)"""
    wheel_body: str | None = None
    """bundled wheel with the rim for a file's running surface, or plain (default: as for rail_body)"""
    gauge_mm: Positive = Track.gauge_mm
    """track gauge, between the rails' heads"""
    gauge_depth_mm: Positive | None = None
    """depth below the tops down to which the gauge is measured (default: 14 mm by EN 13848-1; with units = us 5/8
    in)"""
    gauge_at: GaugeAt = "within-depth"
    """within-depth: closest points of the heads down to gauge_depth_mm; unworn: those of the unworn heads, so that worn
    rails stand where they stood new; narrowest: closest points at any depth"""
    rail_inclination: float = Field(Track.rail_inclination, ge=-0.2, le=0.2)
    """rail inclination, a slope; 1:40 is 0.025"""
    back_to_back_mm: float | None = Field(
        None,
        gt=0.0,
        description="distance between the wheels' inner faces (default by gauge): "
        + ", ".join(f"{gauge.back_to_back_mm:g} for {gauge.gauge_mm:g}" for gauge in USUAL_GAUGES),
    )
    wheel_radius_mm: float = Field(Wheelset.radius_mm, ge=150.0)
    """rolling radius, at the position wheel_radius_at"""
    wheel_radius_at: Literal["flange-tip", "tape-line"] = "flange-tip"
    """where wheel_radius_mm is measured"""
    left_wheel_radius_mm: float | None = Field(None, ge=150.0)
    """radius of the left wheel at wheel_radius_at (default: the same radius at the tape line)"""
    centre_of_gravity_height_mm: float = Wheelset.centre_of_gravity_height_mm
    """height of the car's centre of gravity above the axle"""
    axle_load_kN: float = Field(300.0, gt=0.0, le=1e5)
    """axle load, weight on both rails"""
    car_mass_t: Positive | None = None
    """mass of the car, shared by n_axles, instead of axle_load_kN"""
    n_axles: int = Field(N_AXLES, ge=1)
    """wheelsets that share car_mass_t"""
    lateral_force_kN: float = 0.0
    """horizontal force at the centre of gravity, to the right: centrifugal force of a curve to the left"""
    speed_km_h: NotNegative | None = None
    """speed; with curve_radius_m it gives the centrifugal force for lateral_force_kN"""
    curve_radius_m: float | None = None
    """radius of the curve, positive to the left, negative to the right; needs speed_km_h"""
    superelevation_mm: float | Literal["from-speed"] = 0.0
    """superelevation, outer rail of the curve over the inner one, negative: adverse cant; without curve_radius_m of
    the right rail over the left one; from-speed: equilibrium superelevation of speed and radius"""
    cant_deficiency_mm: NotNegative = 0.0
    """equilibrium superelevation less the superelevation from-speed"""
    superelevation_base_mm: Positive | None = None
    """width over which superelevation is measured, 1500 mm between the running circles on standard gauge (default:
    the gauge)"""
    thickness_mm: Positive = WheelsetProblem.thickness_mm
    """length of the bodies along the track"""
    young_MPa: SolidModulus = 210e3
    """Young's modulus of wheels and rails"""
    poisson: PoissonRatio = 0.3
    """Poisson's ratio of wheels and rails"""

    position_keys: ClassVar[tuple[str, ...]] = (*POSITION_KEYS, *CURVE_KEYS, "yaw_mrad", *PLACE_KEYS, *ROLLING_KEYS)

    @property
    def row_quantities(self) -> Sequence[Quantity[WheelResult]]:
        """Numbers of a wheel in a row of a campaign."""
        return PLANE_ROW

    @property
    def patch_row_quantities(self) -> Sequence[Quantity[Any]]:
        """Numbers of a patch in the table of patches of a campaign."""
        return PLANE_PATCH_ROW

    def columns(self) -> tuple[str, ...]:
        """See `RunnableCase.columns`."""
        return row_columns(self.row_quantities)

    def patch_columns(self) -> tuple[str, ...]:
        """See `RunnableCase.patch_columns`."""
        return tuple(column_names(self.patch_row_quantities))

    def row(self, run: Any) -> dict[str, Any]:
        """See `RunnableCase.row`: position, and of each side the sums over its patches, and the most loaded one."""
        wheels = [number for result in run.wheels for number in numbers(self.row_quantities, result)]
        return dict(zip(self.columns(), [*numbers(MOTION, run.result), *wheels], strict=True))

    def patch_rows(self, run: Any) -> list[dict[str, Any]]:
        """See `RunnableCase.patch_rows`: on each side from the field to the gauge."""
        rows = []
        for result in run.wheels:
            ordered = sorted(result.patches, key=lambda patch: -float(patch.rail_point_mm[0]))
            for number, patch in enumerate(ordered, 1):
                row = dict(zip(self.patch_columns(), numbers(self.patch_row_quantities, patch), strict=True))
                rows.append({"side": result.side, "number": number} | row)
        return rows

    def warnings_of(self, run: Any) -> list[str]:
        """See `RunnableCase.warnings_of`."""
        return list(run.warnings)

    def assumptions(self, result: Any) -> list[str]:
        """Return in sentences what a solution rests on."""
        raise NotImplementedError

    def check_position(self) -> None:
        """See `RunnableCase.check_position`."""
        self.load()

    def load(self) -> WheelsetLoad:
        """Return weight, lateral force and tilt of the track.

        It is an `InputError` if only one of speed and radius is given, or a force besides both.
        """
        weight = 1e3 * self.axle_load_kN
        if self.car_mass_t is not None:
            if "axle_load_kN" in self.model_fields_set:
                raise InputError("axle_load_kN and car_mass_t", "one of both", "leave one out")
            weight = 1e3 * self.car_mass_t / self.n_axles * GRAVITY_M_S2
        elif self.n_axles != N_AXLES:
            raise InputError("n_axles without car_mass_t", "both", "give car_mass_t, or axle_load_kN alone")
        lateral = 1e3 * self.lateral_force_kN
        base = self._superelevation_base
        alone = self.speed_km_h is not None and self.curve_radius_m is None and self._rolls
        if (self.speed_km_h is None) != (self.curve_radius_m is None) and not alone:
            raise InputError("one of speed_km_h and curve_radius_m", "both or neither", "give the other one as well")
        if self.speed_km_h is not None and self.curve_radius_m is not None:
            if "lateral_force_kN" in self.model_fields_set:
                raise InputError(
                    "lateral_force_kN with speed_km_h and curve_radius_m", "the force or both of these", "leave it out"
                )
            if self.curve_radius_m == 0.0:
                raise InputError(
                    "curve_radius_m = 0",
                    "a radius above 0 for a curve to the left, below 0 for one to the right",
                    "give a radius, or leave curve_radius_m and speed_km_h out on straight track",
                )
            lateral = curve_force_N(weight, self.speed_km_h, self.curve_radius_m)
        return WheelsetLoad(weight, lateral, superelevation_angle(self._superelevation(base), base))

    def derived(self) -> list[str]:
        """Return in sentences what follows from other inputs: distance of the wheels and base of the superelevation."""
        sentences = []
        if self.back_to_back_mm is None:
            usual = usual_gauge(self.gauge_mm)
            sentences.append(
                f"Back to back {usual.back_to_back_mm:g} mm, from the gauge of {self.gauge_mm:g} mm: {usual.source}."
            )
        base = self._superelevation_base
        height = self._superelevation(base)
        if height:
            which = self._base_words if self.superelevation_base_mm is None else "superelevation_base_mm"
            sentences.append(
                f"Superelevation {height:.4g} mm over a base of {base:g} mm: {which}, tilt of the track "
                f"{superelevation_angle(height, base):.5f} rad."
            )
        return sentences

    def warnings(self) -> list[str]:
        """Return what is unusual about the inputs, in sentences."""
        given = self.superelevation_mm
        if self.curve_radius_m is None or given == "from-speed" or given >= 0.0:
            return []
        return [f"superelevation_mm = {given:g}: adverse cant, the inner rail of the curve is {-given:g} mm higher"]

    @property
    def _rolls(self) -> bool:
        """Whether there may be a speed on straight track."""
        return False

    @property
    def _base_words(self) -> str:
        return "the gauge"

    @property
    def _superelevation_base(self) -> float:
        return self.gauge_mm if self.superelevation_base_mm is None else self.superelevation_base_mm

    def _superelevation(self, base: float) -> float:
        """Height of the right rail over the left one in mm."""
        if self.superelevation_mm != "from-speed":
            if self.cant_deficiency_mm:
                raise InputError(
                    f"cant_deficiency_mm with superelevation_mm = {float(self.superelevation_mm):g}",
                    "superelevation_mm = from-speed, from which it is taken off",
                    "give from-speed, or leave cant_deficiency_mm out: the given one includes it",
                )
            height = float(self.superelevation_mm)
            return -height if (self.curve_radius_m or 0.0) < 0.0 else height
        if self.speed_km_h is None or self.curve_radius_m is None:
            raise InputError(
                "superelevation_mm = from-speed without speed_km_h and curve_radius_m", "both", "give them or a height"
            )
        at_equilibrium = balanced_superelevation_mm(self.speed_km_h, self.curve_radius_m, base)
        where = f"{self.speed_km_h:g} km/h and {abs(self.curve_radius_m):g} m"
        what = f"{abs(at_equilibrium):.4g} mm of equilibrium superelevation at {where}"
        height = abs(at_equilibrium) - self.cant_deficiency_mm
        if height < 0.0:
            raise InputError(
                f"cant_deficiency_mm = {self.cant_deficiency_mm:g}",
                "at most the " + what,
                "lower it, or raise the speed",
            )
        if height > MAX_SLOPE * base:
            raise InputError(
                "superelevation_mm = from-speed: the " + what,
                f"at most {MAX_SLOPE * base:g} mm, a fifth of superelevation_base_mm",
                "give the actual superelevation, or cant_deficiency_mm",
            )
        return math.copysign(height, at_equilibrium)

    def track(self) -> Track:
        """Return the rails in their positions."""
        right, left = self._profiles("rail")
        depth = GAUGE_DEPTHS_MM[self.units] if self.gauge_depth_mm is None else self.gauge_depth_mm
        return Track(right, self.gauge_mm, self.rail_inclination, left, depth, self.gauge_at)

    def _profiles(self, kind: Kind) -> tuple[Any, Any]:
        """Rails or wheels of the right and the left side, None for a left one that is the same."""
        names = {key: getattr(self, key) for key in (kind, f"left_{kind}")}
        read = {key: self._reading(key) for key in names}
        if not any(name is not None and _means_file(name) for name in names.values()):
            self.refuse_without_effect([f"{kind}_body"], kind, "a file")
        profiles: list[Any] = []
        for key, other in zip(names, reversed(names.values()), strict=True):
            name = names[key]
            if name is None or (profiles and (name, read[key]) == (names[kind], read[kind])):
                profiles.append(None)
                continue
            # of two rails a radius of the crown is that of the one that takes it
            crown = None if name != "136RE" and other == "136RE" else self.crown_radius_in
            body = getattr(self, f"{kind}_body")
            profiles.append(profile_named(name, kind, read[key], key, body=body, other=other, crown_radius_in=crown))
        return profiles[0], profiles[1]

    def _reading(self, key: str) -> ReadOptions:
        """Return the options for the file of a profile.

        It is an `InputError` if there are options for a left profile without the profile.
        """
        name, right = getattr(self, key), key.removeprefix("left_")
        keys = option_keys(key)
        options: dict[str, Any] = {option: getattr(self, name, None) for option, name in keys.items()}
        options_given = [keys[option] for option, value in options.items() if value not in (None, False)]
        if name is None and options_given:
            raise InputError(
                f"{' and '.join(options_given)} without {key}", f"{key} with a file", f"give {key}, or leave it out"
            )
        if name == getattr(self, right):  # the same file has the same unit
            for option, of_right in option_keys(right).items():
                if options[option] is None:
                    options[option] = getattr(self, of_right, None)
        return ReadOptions(**options)

    def wheelset(self) -> Wheelset:
        """Return the wheels on their axle."""
        right, left = self._profiles("wheel")
        radius, left_radius = self.wheel_radius_mm, self.left_wheel_radius_mm
        if self.wheel_radius_at == "tape-line":
            radius += right.flange_height_mm
            left_radius = None if left_radius is None else left_radius + (left or right).flange_height_mm
        distance = self.back_to_back_mm
        if distance is None:
            distance = usual_gauge(self.gauge_mm).back_to_back_mm
        return Wheelset(right, distance, radius, self.centre_of_gravity_height_mm, left, left_radius)
