"""The cases of an elastic wheelset on two rails in the plane, and what a run of any wheelset found."""

# ruff: noqa: N815 (units in names)
import time
from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from typing import Any, Literal

from pydantic import Field

from flangeway.cases.case import RunnableCase
from flangeway.cases.summary import RunResult
from flangeway.cases.wheelset.wheelset_inputs import WheelsetInputs, profile_notes, side_warnings
from flangeway.cases.wheelset.wheelset_quantities import (
    HEAD,
    LOAD,
    MESH,
    NADAL,
    PATCH,
    PLANE_PATCH,
    POSITION,
    RESIDUAL,
    ROLLING,
    TRACK,
    WHEEL,
    AnyPatch,
    AnyResult,
    WheelResult,
    patch_name,
)
from flangeway.materials import Elastic
from flangeway.quantities import Quantity, values
from flangeway.railway.track.placements import SIDES, GaugeAt
from flangeway.railway.track.wheelset_problem import (
    Choice,
    Discretisation,
    EnforcementName,
    Method,
    PairingName,
    Prescribed,
    WheelsetLoad,
    WheelsetProblem,
)
from flangeway.railway.wheelset.plane_wheelset import PlaneWheelset, WheelsetResult, solve_condensed, solve_wheelset
from flangeway.railway.wheelset.spatial_result import SpatialResult
from flangeway.railway.wheelset.wheelset_model import build_model
from flangeway.records import ElementOrder, Fraction, PoissonRatio, Positive, SolidModulus
from flangeway.solve import Status
from flangeway.system.disk_cache import Cache
from flangeway.types import Progress

# --- What a run of a wheelset found, in three dimensions or in the plane: results, ``summary.json``, rows of campaigns.


@dataclass(frozen=True, eq=False)
class WheelsetRun(RunResult):
    """A case of a wheelset and what came out of it.

    Parameters
    ----------
    case
        The inputs.
    result
        The solution.
    total_s
        Wall-clock time of the computation in seconds.

    """

    main_table = "patches"

    case: "WheelsetInputs"
    result: AnyResult
    total_s: float

    @property
    def status(self) -> Status:
        """How it ended."""
        return self.result.status

    @property
    def timings_s(self) -> dict[str, float]:
        """Seconds by stage."""
        return {name.replace("-", "_"): s for name, s in self.result.timings_s.items()} | {"total": self.total_s}

    @property
    def problem(self) -> WheelsetProblem:
        """Wheelset, track and load."""
        return self.result.problem

    @property
    def in_space(self) -> SpatialResult | None:
        """The solution in three dimensions; None of a plane wheelset."""
        return self.result if isinstance(self.result, SpatialResult) else None

    @property
    def space(self) -> SpatialResult:
        """The solution of a wheelset in three dimensions."""
        assert isinstance(self.result, SpatialResult)
        return self.result

    @property
    def plane(self) -> WheelsetResult:
        """The solution of a plane wheelset."""
        assert isinstance(self.result, WheelsetResult)
        return self.result

    @property
    def patches(self) -> Sequence[AnyPatch]:
        """The contact patches, left side first."""
        return self.result.patches

    @cached_property
    def wheels(self) -> list[WheelResult]:
        """The left and the right wheel."""
        return [
            WheelResult(self.result, side, [patch for patch in self.patches if patch.side == side]) for side in SIDES
        ]

    @property
    def patch_names(self) -> list[str]:
        """Names of the patches."""
        return [patch_name(patch) for patch in self.result.patches]

    @property
    def patch_quantities(self) -> Sequence[Quantity[Any]]:
        """Numbers of its patches."""
        return PLANE_PATCH if self.in_space is None else PATCH

    @property
    def wheel_quantities(self) -> Sequence[Quantity[WheelResult]]:
        """Numbers of its wheels."""
        space = self.in_space
        return WHEEL if space is None else (*WHEEL, *HEAD, *(NADAL if space.rolling else ()))

    @property
    def warnings(self) -> list[str]:
        """What limits the results."""
        return [*self.case.warnings(), *self.result.warnings, *side_warnings(self.problem.track)]

    def parts(self) -> dict[str, Any]:
        """See `RunResult.parts`."""
        result, space = self.result, self.in_space
        content: dict[str, Any] = {
            "position": values(POSITION, result),
            "track": values(TRACK, self.problem.track),
            "load": values(LOAD, self.problem.load),
            "residual": values(RESIDUAL, result.equilibrium.residuals),
            "sides": [{"side": wheel.side, **values(self.wheel_quantities, wheel)} for wheel in self.wheels],
            "patches": [values(self.patch_quantities, patch) for patch in self.patches],
        }
        if space is not None:
            content["rolling"] = values(ROLLING, space) if space.rolling else None
        elif isinstance(result, WheelsetResult):
            content["bodies"] = [values(MESH, body) for body in result.model.bodies]
        return content | {"assumptions": self.case.assumptions(result), "warnings": self.warnings}


# --- The cases of an elastic wheelset on two rails: standing on tangent track, and in a curve.


CONFORMING = (
    "Hertz's theory is left out where wheel and rail conform: where its half width is above half of a radius of either "
    "profile, or the gap of the profiles at an end of it is 1.5 times that of constant curvature, or less than 1 / 1.5."
)


MIN_TOGETHER = 12
"""Positions of the same plane bodies from which on these are prepared for many positions."""


class WheelsetCase(WheelsetInputs, RunnableCase):
    """A wheelset on two rails (Moherdaui 2021, 7.2.1); subclasses are situations with defaults of their own."""

    essential = (
        *("rail", "wheel", "gauge_mm", "wheel_radius_mm", "axle_load_kN"),
        *("method", "order", "size_scale"),
    )

    gauge_at: GaugeAt = "narrowest"
    """within-depth: closest points of the heads down to gauge_depth_mm; unworn: those of the unworn heads; narrowest:
    closest points at any depth, as in Moherdaui (2021)"""
    lateral_mm: float | None = None
    """prescribed lateral position of the axle's middle in the track's axes (default: computed)"""
    vertical_mm: float | None = None
    """prescribed vertical position (default: computed)"""
    roll_rad: float | None = None
    """prescribed roll, counter-clockwise (default: computed)"""
    wheel_young_MPa: SolidModulus | None = None
    """Young's modulus of the wheels (default: young_MPa)"""
    wheel_poisson: PoissonRatio | None = None
    """Poisson's ratio of the wheels (default: poisson)"""
    rail_young_MPa: SolidModulus | None = None
    """Young's modulus of the rails (default: young_MPa)"""
    rail_poisson: PoissonRatio | None = None
    """Poisson's ratio of the rails (default: poisson)"""
    yield_MPa: Positive | None = None
    """yield strength, for a warning (default: 510 MPa, rail steel)"""
    method: Method = Discretisation.method
    """fem is triangles, vem is polygons with virtual elements"""
    order: ElementOrder = Discretisation.order
    """order of the elements: FO2 is fem of order 2"""
    wheel_method: Method | None = None
    """method of the wheels (default: method)"""
    rail_method: Method | None = None
    """method of the rails (default: method)"""
    wheel_order: ElementOrder | None = None
    """order of the elements of the wheels (default: order)"""
    rail_order: ElementOrder | None = None
    """order of the elements of the rails (default: order)"""
    size_scale: float = Field(Discretisation.size_scale, ge=0.05, le=20.0)
    """factor on all element sizes"""
    contact_size_mm: Positive = Discretisation.contact_size_mm
    """element size in contact, doubled for order 2"""
    wheel_contact_size_mm: Positive | None = None
    """element size of the wheels in contact (default: contact_size_mm)"""
    rail_contact_size_mm: Positive | None = None
    """element size of the rails in contact (default: contact_size_mm)"""
    body_size_mm: Positive = Discretisation.body_size_mm
    """element size elsewhere, doubled for order 2"""
    growth: Fraction = Discretisation.growth
    """growth of the element size per distance"""
    pairing: PairingName = Discretisation.pairing
    """contact discretisation"""
    enforcement: EnforcementName = Discretisation.enforcement
    """constraint enforcement"""
    penalty_factor: Positive = Discretisation.penalty_factor
    """penalty (pressure per penetration) relative to the contact modulus per mm"""
    nodal_penalty_N_per_mm: Positive | None = None
    """penalty of node-to-segment as force per penetration at a node (default: from penalty_factor)"""
    penetration_mm: Positive = Discretisation.penetration_mm
    """tolerated penetration of augmented-lagrange"""
    primary: Choice = Discretisation.primary
    """primary surface; auto: chosen, and the reason is reported"""

    def check(self) -> None:
        """See `RunnableCase.check`."""
        self.problem()

    def run(self, progress: Progress = lambda _: None, *, cold: bool = False) -> WheelsetRun:
        """See `RunnableCase.run`; `cold` computes everything without the user's cache."""
        start = time.perf_counter()
        result = solve_wheelset(self.problem(), progress, cold=cold)
        return WheelsetRun(self, result, time.perf_counter() - start)

    @property
    def min_together(self) -> int:
        """See `RunnableCase.min_together`: bodies for many positions are finer, and condensed whole."""
        return MIN_TOGETHER

    def prepared(self, progress: Progress = lambda _: None) -> PlaneWheelset:  # noqa: ARG002 (short)
        """See `RunnableCase.prepared`."""
        problem, cache = self.problem(), Cache.of_user()
        # in the middle of level track, which rigid wheels can always reach
        middle = replace(problem, load=WheelsetLoad(problem.load.vertical_N), prescribed=Prescribed())
        return PlaneWheelset.of(build_model(middle, whole=True, cache=cache), cache=cache)

    def run_on(self, bodies: PlaneWheelset, progress: Progress = lambda _: None) -> WheelsetRun:
        """See `RunnableCase.run_on`."""
        start = time.perf_counter()
        result = solve_condensed(bodies.at(self.problem()), progress)
        return WheelsetRun(self, result, time.perf_counter() - start)

    def assumptions(self, result: WheelsetResult) -> list[str]:
        """See `WheelsetInputs.assumptions`."""
        problem = result.model.problem
        wheelset, track = problem.wheelset, problem.track
        role, reason = problem.primary
        materials = {"wheels": problem.material_of("wheel"), "rails": problem.material_of("rail")}
        if materials["wheels"] == materials["rails"]:
            materials = {"steel": problem.material}
        return [
            "Plane strain: the bodies do not stretch in the direction of the track.",
            "Stresses in web, fillets and foot, the displacement of the rail's head and the approach are those of a "
            f"prism of {self.thickness_mm:g} mm that carries the whole load alone: compare them between runs, not with "
            "a rail in track.",
            f"Thickness {self.thickness_mm:g} mm: this length of wheel and rail carries the whole load.",
            *self.derived(),
            *profile_notes(track, wheelset),
            *(
                (
                    f"Linear elastic, isotropic {name}: Young's modulus {material.young:g} MPa, Poisson's ratio "
                    f"{material.poisson:g}; plasticity is not modelled."
                )
                for name, material in materials.items()
            ),
            "Contact without friction.",
            *([CONFORMING] if any(patch.hertz is None for patch in result.patches) else []),
            f"The {role}s are the primary surface: {reason}.",
            "The rails are fixed along their whole base.",
            "The wheels' cuts and the axle are rigid; the load acts at the car's centre of gravity and stays vertical"
            + (", its lateral force horizontal." if problem.load.lateral_N else "."),
            *(
                ["The left side is the mirror image of the right side, mesh included."]
                if wheelset.is_symmetric and track.is_symmetric
                else []
            ),
        ]

    def problem(self) -> WheelsetProblem:
        """Return the problem to solve.

        It is an `InputError` if a profile is unknown, a number is not allowed, or inputs contradict each other.
        """
        return WheelsetProblem(
            self.track(),
            self.wheelset(),
            self.load(),
            Elastic(self.young_MPa, self.poisson),
            self.thickness_mm,
            self._discretisation(),
            self._material(self.wheel_young_MPa, self.wheel_poisson),
            self._material(self.rail_young_MPa, self.rail_poisson),
            Prescribed(self.lateral_mm, self.vertical_mm, self.roll_rad),
            yield_MPa=self.yield_MPa,
        )

    def _material(self, young: float | None, poisson: float | None) -> Elastic | None:
        if young is None and poisson is None:
            return None
        return Elastic(self.young_MPa if young is None else young, self.poisson if poisson is None else poisson)

    def _discretisation(self) -> Discretisation:
        shared = Discretisation.__dataclass_fields__.keys() & type(self).model_fields.keys()
        return Discretisation(**{name: getattr(self, name) for name in shared})


class WheelsetTangentCase(WheelsetCase):
    """A wheelset on two rails under the weight of the car (Moherdaui 2021, 7.2.1, Figure 90a)."""

    name = "wheelset-tangent"
    title = "A wheelset on two rails of straight, level track"


class WheelsetCurveCase(WheelsetCase):
    """A wheelset in a curve to the left, radius 400 m at 70 km/h, superelevation 3 cm (Moherdaui 2021, Figure 90b)."""

    name = "wheelset-curve"
    title = "A wheelset in a curve, pressed against the outer rail"

    lateral_force_kN: float = 28.4
    """horizontal force at the centre of gravity, to the right: centrifugal force of 400 m at 70 km/h"""
    superelevation_mm: float | Literal["from-speed"] = 30.0
    """height of the right rail over the left one (default: that of the outer rail); from-speed: equilibrium
    superelevation of speed and radius"""
