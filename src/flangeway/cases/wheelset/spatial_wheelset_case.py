"""The case of a wheelset on two rails in three dimensions."""

import time
from collections.abc import Sequence
from functools import cached_property
from pathlib import Path
from typing import Any, Literal

import numpy as np
from pydantic import Field

from flangeway.cases.case import RunnableCase
from flangeway.cases.patch_quantities import MAX_FRICTION, FrictionCoefficient, FrictionInputs
from flangeway.cases.wheelset.wheelset_case import WheelsetRun, WheelsetTangentCase
from flangeway.cases.wheelset.wheelset_inputs import ROLLING_KEYS, WheelsetInputs, profile_notes
from flangeway.cases.wheelset.wheelset_quantities import (
    ROLLING_PATCH_ROW,
    ROLLING_ROW,
    SPATIAL_PATCH_ROW,
    SPATIAL_ROW,
    WheelResult,
)
from flangeway.contact.patch.patch_contact import MAX_PARABOLOID_DISTANCE
from flangeway.contact.rolling.fast_theories import Theory
from flangeway.errors import InputError
from flangeway.materials import Elastic
from flangeway.quantities import Quantity
from flangeway.railway.track.placements import RUNNING_CIRCLES_MM
from flangeway.railway.track.wheelset_problem import Discretisation, Method, Prescribed, WheelsetProblem
from flangeway.railway.wheelset.rolling.patch_rolling import RollingMotion
from flangeway.railway.wheelset.running_surfaces import PATCH_CELLS, SpatialModel, running_surfaces
from flangeway.railway.wheelset.spatial_result import SpatialResult, solve_position, solve_spatial
from flangeway.railway.wheelset.spatial_wheelset import SpatialWheelset
from flangeway.railway.wheelset.supported_rail import RailSupport
from flangeway.railway.wheelset.whole_wheel import Axle, WheelDisc
from flangeway.records import ElementOrder, NotNegative, Positive
from flangeway.system.disk_cache import Cache
from flangeway.system.file_content import number_table
from flangeway.types import Progress

# ruff: noqa: N815 (units in names)

ALONG_TRACK = ("distance_m", "friction")
HERTZ = (
    "Hertz's theory is left out where the curvatures vary within a patch: where the gap deviates from a paraboloid by "
    f"more than {100.0 * MAX_PARABOLOID_DISTANCE:g} % of its height."
)
THEORIES: dict[Theory, str] = {
    "exact": "the exact theory on the bodies",
    "fastsim": "FASTSIM",
    "fastrip": "FaStrip",
    "polach": "Polach's formula",
    "linear": "linear theory",
}


class SpatialWheelsetCase(FrictionInputs, WheelsetInputs, RunnableCase):
    """A wheelset on two rails, by default in three dimensions on standard gauge."""

    name = "wheelset"
    title = "A wheelset on two rails in three dimensions"
    essential = (
        *("rail", "wheel", "gauge_mm", "rail_inclination", "wheel_radius_mm", "axle_load_kN"),
        *("superelevation_mm", "yaw_mrad"),
    )

    model: Literal["spatial", "plane"] = "spatial"
    """spatial: three dimensions; plane: a slice of thickness_mm in plane strain"""
    rail: str = "60E1"
    """rail: 60E1, 60E2, 54E1, 49E1, 136RE, or a file that `flangeway profile` reads"""
    wheel: str = "S1002"
    """wheel: AAR-1B (an approximation), S1002, heavy-haul, R-519-A, -B, -C, -H, -I, or a file"""
    gauge_mm: Positive = 1435.0
    """track gauge, between the rails' heads"""
    wheel_radius_mm: float = Field(460.0, ge=150.0)
    """rolling radius, at the position wheel_radius_at"""
    wheel_radius_at: Literal["flange-tip", "tape-line"] = "tape-line"
    """where wheel_radius_mm is measured"""
    axle_load_kN: float = Field(200.0, gt=0.0, le=1e5)
    """axle load, weight on both rails"""
    superelevation_base_mm: Positive | None = None
    """width over which superelevation is measured (default: the gauge and 65 mm)"""
    yaw_mrad: float = Field(0.0, ge=-200.0, le=200.0)
    """yaw of the axle, positive where the right wheel is ahead"""
    lateral_mm: float | None = None
    """prescribed lateral position of the axle's middle in the track's axes (default: computed)"""
    vertical_mm: float | None = None
    """prescribed vertical position (default: computed)"""
    roll_rad: float | None = None
    """prescribed roll, counter-clockwise (default: computed)"""
    friction: FrictionCoefficient | None = None
    """coefficient of friction: the wheelset rolls at speed_km_h with creep forces (default, and 0: without
    friction)"""
    friction_file: str | None = None
    """CSV file of the coefficient along the track, instead of friction: distance_m, friction, linear in between"""
    distance_m: float = 0.0
    """distance of the wheelset along the track, at which friction_file is read"""
    flange_friction: FrictionCoefficient | None = None
    """coefficient on the gauge face, steeper than 45 degrees (default: friction)"""
    rolling_theory: Theory = "exact"
    """creep forces: exact theory, fastsim, fastrip, polach or linear theory"""
    torque_kNm: float = 0.0
    """torque on the axle: positive drives, negative brakes, 0 rolls freely"""
    yaw_stiffness_kNm_per_mrad: NotNegative | None = None
    """stiffness that guides the axle to yaw_mrad, 0: none; the yaw is then found (default: yaw_mrad is prescribed)"""
    yaw_rate_mrad_per_s: float = 0.0
    """yaw rate relative to the track, counter-clockwise from above; the curve adds its own"""
    lateral_velocity_mm_per_s: float = 0.0
    """velocity of the axle across the track, to the right"""
    rail_support: Literal["sleepers", "continuous", "fixed"] = "sleepers"
    """what the rails stand on: sleepers, a continuous foundation, or fixed bases"""
    sleeper_spacing_mm: float = Field(RailSupport.spacing_mm, ge=RailSupport.pad_length_mm)
    """distance of the sleepers"""
    sleeper_position: float = Field(RailSupport.position, ge=0.0, lt=1.0)
    """distance of the wheelset from the last sleeper relative to the spacing: 0 over it, 0.5 between two"""
    seat_vertical_kN_per_mm: Positive = RailSupport.vertical_kN_per_mm
    """vertical stiffness of rail seat, sleeper and ballast"""
    seat_lateral_kN_per_mm: Positive = RailSupport.lateral_kN_per_mm
    """their lateral stiffness"""
    seat_longitudinal_kN_per_mm: Positive = RailSupport.longitudinal_kN_per_mm
    """their longitudinal stiffness"""
    seat_roll_kNm_per_rad: Positive = RailSupport.roll_kNm_per_rad
    """their stiffness against roll of the rail"""
    wheel_section: Literal["rim", "whole"] = "rim"
    """rim held at its cut, or whole wheel with an assumed web and hub, held at the bore"""
    axle: Literal["elastic", "rigid"] = "elastic"
    """elastic: an AAR class F axle that bends between its journals"""
    yield_MPa: Positive | None = None
    """yield strength, for the shakedown position of patches (default: 510 MPa, rail steel)"""
    method: Method = "fem"
    """fem is triangles, vem is polygons with virtual elements"""
    order: ElementOrder = 2
    """order of the elements"""
    size_scale: float = Field(1.0, ge=0.05, le=10.0)
    """factor on all element sizes"""
    patch_cells: int = Field(PATCH_CELLS, ge=10, le=60)
    """cells across each contact patch, and along it"""

    def check(self) -> None:
        """See `RunnableCase.check`."""
        if self.model == "plane":
            self.plane().check()
        else:
            self.problem()
            self.spatial_model()

    def run(self, progress: Progress = lambda _: None, *, cold: bool = False) -> WheelsetRun:
        """See `RunnableCase.run`; `cold` computes everything without the user's cache."""
        if self.model == "plane":
            return self.plane().run(progress, cold=cold)
        start = time.perf_counter()
        return WheelsetRun(
            self,
            solve_spatial(self.problem(), self.spatial_model(), cold=cold, progress=progress),
            time.perf_counter() - start,
        )

    @property
    def min_together(self) -> int:
        """See `RunnableCase.min_together`: in three dimensions the bodies are most of the work of one position too."""
        return self.plane().min_together if self.model == "plane" else 1

    def check_position(self) -> None:
        """See `RunnableCase.check_position`."""
        if self.model == "plane":
            self.plane().check_position()
        else:
            self.load()
            self._rolling()

    def prepared(self, progress: Progress = lambda _: None) -> Any:
        """See `RunnableCase.prepared`; in three dimensions a `SpatialWheelset`."""
        if self.model == "plane":
            return self.plane().prepared(progress)
        problem, model = self.problem(), self.spatial_model()
        return SpatialWheelset(
            problem, running_surfaces(problem, model, cache=Cache.of_user(), progress=progress), model
        )

    def run_on(self, bodies: Any, progress: Progress = lambda _: None) -> WheelsetRun:
        """See `RunnableCase.run_on`."""
        if self.model == "plane":
            return self.plane().run_on(bodies, progress)
        start, model = time.perf_counter(), self.spatial_model()
        prescribed = Prescribed(self.lateral_mm, self.vertical_mm, self.roll_rad)
        placed = bodies.at(self.load(), prescribed, model.yaw_rad, model.rolling)
        return WheelsetRun(self, solve_position(placed, {}, progress), time.perf_counter() - start)

    @property
    def row_quantities(self) -> Sequence[Quantity[WheelResult]]:
        """See `WheelsetInputs.row_quantities`."""
        return super().row_quantities if self.model == "plane" else ROLLING_ROW if self.coefficient else SPATIAL_ROW

    @property
    def patch_row_quantities(self) -> Sequence[Quantity[Any]]:
        """See `WheelsetInputs.patch_row_quantities`."""
        if self.model == "plane":
            return super().patch_row_quantities
        return ROLLING_PATCH_ROW if self.coefficient else SPATIAL_PATCH_ROW

    def plane(self) -> WheelsetTangentCase:
        """Return the plane wheelset of the same inputs; an `InputError` if it does not have one that was given."""
        plane = WheelsetTangentCase.model_fields
        self.refuse_without_effect(
            (key for key in type(self).model_fields if key not in plane and key != "model"), "model", "spatial"
        )
        shared = WheelsetTangentCase.model_fields.keys() & self.model_fields_set
        keys = {"rail", "wheel", "gauge_mm", "gauge_at", "wheel_radius_mm", "wheel_radius_at", "axle_load_kN", "order"}
        if self.car_mass_t is not None:
            keys -= {"axle_load_kN"}
        values = {key: getattr(self, key) for key in shared | keys}
        return WheelsetTangentCase.from_values(values | {"superelevation_base_mm": self._superelevation_base})

    def problem(self) -> WheelsetProblem:
        """Return the problem to solve.

        It is an `InputError` if a profile is unknown, a number is not allowed, or inputs contradict each other.
        """
        self.refuse_without_effect(["thickness_mm"], "model", "plane")
        load = self.model_fields_set & {"axle_load_kN", "car_mass_t"}
        if self.vertical_mm is not None and load:
            raise InputError(
                f"vertical_mm with {' and '.join(load)}",
                "the load, or the vertical position, from which the force follows",
                "leave one of them out",
            )
        return WheelsetProblem(
            self.track(),
            self.wheelset(),
            self.load(),
            Elastic(self.young_MPa, self.poisson),
            self.thickness_mm,
            Discretisation(method=self.method, order=self.order, size_scale=self.size_scale),
            prescribed=Prescribed(self.lateral_mm, self.vertical_mm, self.roll_rad),
            yield_MPa=self.yield_MPa,
        )

    def spatial_model(self) -> SpatialModel:
        """Return supports, wheels, axle and yaw; an `InputError` if what was given does not belong together."""
        support = None
        if self.rail_support != "sleepers":
            self.refuse_without_effect(["sleeper_position"], "rail_support", "sleepers")
        if self.rail_support == "fixed":
            seats = (key for key in type(self).model_fields if key.startswith(("seat_", "sleeper_")))
            self.refuse_without_effect(seats, "rail_support", "sleepers or continuous")
        else:
            support = RailSupport(
                self.rail_support,
                self.sleeper_spacing_mm,
                self.seat_vertical_kN_per_mm,
                self.seat_lateral_kN_per_mm,
                self.seat_longitudinal_kN_per_mm,
                self.seat_roll_kNm_per_rad,
                self.sleeper_position if self.rail_support == "sleepers" else 0.0,
            )
        disc = WheelDisc() if self.wheel_section == "whole" else None
        axle = Axle(young=self.young_MPa) if self.axle == "elastic" else None
        return SpatialModel(support, disc, axle, 1e-3 * self.yaw_mrad, self._rolling(), self.patch_cells)

    @property
    def _rolls(self) -> bool:
        return self.coefficient is not None

    @cached_property
    def coefficient(self) -> float | None:
        """Coefficient of friction where the wheelset is; beyond the ends of the file that of its end."""
        if self.friction_file is None:
            self.refuse_without_effect(["distance_m"], "friction_file", "a file of the coefficient along the track")
            return self.friction
        self.refuse_without_effect(["friction"], "friction_file", "none")
        wanted = f"a CSV file with the columns {', '.join(ALONG_TRACK)}: rising distances, coefficients up to 1"
        distances, coefficients = number_table(Path(self.friction_file), ALONG_TRACK, wanted).T
        if (np.diff(distances) <= 0.0).any() or coefficients.min() < 0.0 or coefficients.max() > MAX_FRICTION:
            raise InputError(
                f"{self.friction_file}: distances that do not rise, or coefficients out of range",
                wanted,
                "sort the lines, and correct the coefficients",
            )
        return float(np.interp(self.distance_m, distances, coefficients))

    def _rolling(self) -> RollingMotion | None:
        """How the wheelset rolls, None without friction."""
        if not self.coefficient:
            self.refuse_without_effect(ROLLING_KEYS, "friction", "a coefficient above 0")
            return None
        if not self.speed_km_h:
            raise InputError(
                f"friction = {self.coefficient:g} with speed_km_h = {self.speed_km_h}",
                "a speed above 0: creep forces are those of rolling",
                "give speed_km_h, or leave friction out",
            )
        stiffness = self.yaw_stiffness_kNm_per_mrad
        return RollingMotion(
            self.speed_km_h / 3.6,
            self.friction_law(self.coefficient, self.rolling_theory),
            self.flange_friction,
            self.curve_radius_m,
            1e-3 * self.yaw_rate_mrad_per_s,
            1e-3 * self.lateral_velocity_mm_per_s,
            1e3 * self.torque_kNm,
            None if stiffness is None else 1e6 * stiffness,
            self.rolling_theory,
        )

    @property
    def _base_words(self) -> str:
        return f"the gauge and {RUNNING_CIRCLES_MM:g} mm, the distance of the running circles"

    @property
    def _superelevation_base(self) -> float:
        return (
            self.gauge_mm + RUNNING_CIRCLES_MM if self.superelevation_base_mm is None else self.superelevation_base_mm
        )

    def _supports(self) -> list[str]:
        """Sentences on track, wheels and axle."""
        seat = (
            f"{self.seat_vertical_kN_per_mm:g} kN/mm vertical, {self.seat_lateral_kN_per_mm:g} kN/mm lateral and "
            f"{self.seat_roll_kNm_per_rad:g} kN m/rad in roll every {self.sleeper_spacing_mm:g} mm"
        )
        seats = f"{self.sleeper_position:g} of the spacing from" if self.sleeper_position else "over"
        where = f"the wheelset is {seats} a sleeper"
        track = {
            "sleepers": f"Each rail on sleepers, {seat}; {where}.",
            "continuous": f"Each rail on a continuous foundation, {seat}.",
            "fixed": "The rails are fixed along their whole base.",
        }[self.rail_support]
        wheel = {
            "rim": "Only the rims of the wheels are modelled, clamped at their inner faces.",
            "whole": "The wheels have an assumed web and hub, and are held at the bore; sections drawn and saved "
            "are of the rims alone, clamped at their inner faces: web and hub count in the compliance only.",
        }[self.wheel_section]
        axle = {
            "elastic": "Axle bending: AAR class F axle, loaded at its journals.",
            "rigid": "The axle is rigid.",
        }[self.axle]
        return [track, wheel, axle]

    def _friction_words(self) -> str:
        if not self.coefficient:
            return "Contact without friction: L/V leaves out creep forces."
        theory = THEORIES[self.rolling_theory]
        where = f"{self.speed_km_h:g} km/h" + (f", {self.curve_radius_m:g} m" if self.curve_radius_m else "")
        friction = f"a coefficient of friction of {self.coefficient:g}"
        return f"Steady rolling at {where} with {friction}; creep forces by {theory}."

    def assumptions(self, result: SpatialResult) -> list[str]:
        """See `WheelsetInputs.assumptions`."""
        problem = result.problem
        return [
            "Three dimensions: each rail is a prism; gaps are computed for true bodies of revolution.",
            *self.derived(),
            *profile_notes(problem.track, problem.wheelset),
            (
                f"Linear elastic, isotropic steel: Young's modulus {self.young_MPa:g} MPa, Poisson's ratio "
                f"{self.poisson:g}; plasticity is not modelled."
            ),
            self._friction_words(),
            "Stresses below the patches are those of a half-space under the tractions of all cells.",
            *([HERTZ] if any(patch.hertz is None for patch in result.patches) else []),
            *self._supports(),
            "The load acts at the car's centre of gravity and stays vertical.",
        ]


def wheelset(**inputs: Any) -> WheelsetRun:
    """Run a wheelset on two rails with some inputs, such as ``wheelset(wheel="S1002", rail="60E1", lateral_mm=2.0)``.

    Parameters
    ----------
    inputs
        Those of the case ``wheelset``, which `flangeway cases wheelset` lists.

    Returns
    -------
    WheelsetRun
        The result, which shows itself in a notebook.

    Raises
    ------
    InputError
        If an input is unknown or not allowed.

    """
    return SpatialWheelsetCase.from_values(inputs).run()
