"""The cases of an elastic wheelset on two rails: standing on tangent track, and in a curve."""

import time
from dataclasses import dataclass
from typing import Any, ClassVar, Literal

from pydantic import Field

from flangeway.cases.case import Progress, RunnableCase
from flangeway.cases.summary import RunResult
from flangeway.cases.wheelset.summarise import summarise
from flangeway.cases.wheelset.wheelset_inputs import WheelsetInputs
from flangeway.cases.wheelset.wheelset_summary import ContactSummary, PublishedPosition, WheelsetSummary
from flangeway.materials import Elastic
from flangeway.railway.track.discretisation import Choice, Discretisation, EnforcementName, Method, PairingName
from flangeway.railway.track.placements import SIDES
from flangeway.railway.track.wheelset_problem import Prescribed, WheelsetProblem
from flangeway.railway.wheelset.wheelset_result import WheelsetResult, solve_wheelset
from flangeway.solve import Status

# ruff: noqa: N815 (units in names)

PUBLISHED_CM = {
    ("fem", 1): (-3.122e-1, 7.025e-1, 3.273e-4),
    ("fem", 2): (-3.126e-1, 7.330e-1, 3.404e-4),
    ("vem", 1): (-3.122e-1, 7.073e-1, 3.291e-4),
    ("vem", 2): (-3.125e-1, 7.309e-1, 3.395e-4),
}
"""Vertical and horizontal translation in cm and rotation in rad by method and order (Moherdaui 2021, Table 16)."""
PUBLISHED_REASON = (
    "Published position of the curve (Moherdaui 2021, Table 16, along horizontal and vertical): its vertical "
    "displacement is relative to an unknown reference, with a gap of about 2.6 mm; its lateral displacement is "
    "decided by where the wheel's flange root meets the rail. The root of the AAR-1B is assumed here, which makes the "
    "lateral displacement 1 to 3 mm larger. `flangeway reproduce wheel-rail` compares with a root that one of the "
    "published numbers identifies."
)


@dataclass(frozen=True, eq=False)
class CaseRun(RunResult):
    """A case of a wheelset and what came out of it.

    Parameters
    ----------
    case
        The inputs.
    result
        The solution.
    summary
        What ``summary.json`` holds.

    """

    main_table: ClassVar[str] = "contacts"

    case: "WheelsetCase"
    result: WheelsetResult
    summary: WheelsetSummary

    @property
    def status(self) -> Status:
        """How it ended."""
        return self.result.status


class WheelsetCase(WheelsetInputs, RunnableCase):
    """A wheelset on two rails (Moherdaui 2021, 7.2.1); subclasses are situations with defaults of their own."""

    essential: ClassVar[tuple[str, ...]] = (
        *("rail", "wheel", "gauge_mm", "wheel_radius_mm", "axle_load_kN"),
        *("method", "order", "size_scale"),
    )

    lateral_mm: float | None = Field(
        None, description="prescribed lateral position of the axle's middle in the track's axes (default: computed)"
    )
    vertical_mm: float | None = Field(None, description="prescribed vertical position (default: computed)")
    roll_rad: float | None = Field(None, description="prescribed roll, counter-clockwise (default: computed)")
    wheel_young_MPa: float | None = Field(
        None, gt=0.0, description="Young's modulus of the wheels (default: young_MPa)"
    )
    wheel_poisson: float | None = Field(
        None, gt=-1.0, lt=0.5, description="Poisson's ratio of the wheels (default: poisson)"
    )
    rail_young_MPa: float | None = Field(None, gt=0.0, description="Young's modulus of the rails (default: young_MPa)")
    rail_poisson: float | None = Field(
        None, gt=-1.0, lt=0.5, description="Poisson's ratio of the rails (default: poisson)"
    )
    yield_MPa: float | None = Field(
        None, gt=0.0, description="yield strength, for a warning (default: 510 MPa, rail steel)"
    )
    method: Method = Field(Discretisation.method, description="fem is triangles, vem is polygons with virtual elements")
    order: int = Field(Discretisation.order, ge=1, le=2, description="order of the elements: FO2 is fem of order 2")
    wheel_method: Method | None = Field(None, description="method of the wheels (default: method)")
    rail_method: Method | None = Field(None, description="method of the rails (default: method)")
    wheel_order: int | None = Field(
        None, ge=1, le=2, description="order of the elements of the wheels (default: order)"
    )
    rail_order: int | None = Field(None, ge=1, le=2, description="order of the elements of the rails (default: order)")
    size_scale: float = Field(Discretisation.size_scale, ge=0.05, le=20.0, description="factor on all element sizes")
    contact_size_mm: float = Field(
        Discretisation.contact_size_mm, gt=0.0, description="element size in contact, doubled for order 2"
    )
    wheel_contact_size_mm: float | None = Field(
        None, gt=0.0, description="element size of the wheels in contact (default: contact_size_mm)"
    )
    rail_contact_size_mm: float | None = Field(
        None, gt=0.0, description="element size of the rails in contact (default: contact_size_mm)"
    )
    body_size_mm: float = Field(
        Discretisation.body_size_mm, gt=0.0, description="element size elsewhere, doubled for order 2"
    )
    growth: float = Field(Discretisation.growth, gt=0.0, le=1.0, description="growth of the element size per distance")
    pairing: PairingName = Field(Discretisation.pairing, description="contact discretisation")
    enforcement: EnforcementName = Field(Discretisation.enforcement, description="constraint enforcement")
    penalty_factor: float = Field(
        Discretisation.penalty_factor,
        gt=0.0,
        description="penalty (pressure per penetration) over the contact modulus per mm",
    )
    nodal_penalty_N_per_mm: float | None = Field(
        None,
        gt=0.0,
        description="penalty of node-to-segment as force per penetration at a node (default: from penalty_factor)",
    )
    penetration_mm: float = Field(
        Discretisation.penetration_mm, gt=0.0, description="tolerated penetration of augmented-lagrange"
    )
    primary: Choice = Field(
        Discretisation.primary, description="primary surface; auto: chosen, and the reason is reported"
    )

    def check(self) -> None:
        """See `RunnableCase.check`."""
        self.problem()

    def run(self, progress: Progress = lambda _: None, *, cold: bool = False) -> CaseRun:
        """See `RunnableCase.run`; `cold` computes everything without the user's cache."""
        start = time.perf_counter()
        result = solve_wheelset(self.problem(), progress, cold=cold)
        return CaseRun(self, result, summarise(self, result, time.perf_counter() - start))

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

    name: ClassVar[str] = "wheelset-tangent"
    title: ClassVar[str] = "A wheelset on two rails of straight, level track"


class WheelsetCurveCase(WheelsetCase):
    """A wheelset in a curve to the left, radius 400 m at 70 km/h, superelevation 3 cm (Moherdaui 2021, Figure 90b)."""

    name: ClassVar[str] = "wheelset-curve"
    title: ClassVar[str] = "A wheelset in a curve, pressed against the outer rail"

    lateral_force_kN: float = Field(
        28.4,
        description="horizontal force at the centre of gravity, to the right: centrifugal force of 400 m at 70 km/h",
    )
    superelevation_mm: float | Literal["from-speed"] = Field(
        30.0,
        description="height of the right rail over the left one (default: that of the outer rail); "
        "from-speed: equilibrium superelevation of speed and radius",
    )

    def published_position(self) -> PublishedPosition | None:
        """Return the published position if all inputs but method and order are those of Moherdaui (2021)."""
        for key, field in type(self).model_fields.items():
            default = field.get_default(call_default_factory=True)
            if key not in ("method", "order") and getattr(self, key) != default:
                return None
        vertical, horizontal, roll = PUBLISHED_CM[self.method, self.order]
        return PublishedPosition(10.0 * vertical, 10.0 * horizontal, roll, PUBLISHED_REASON)


MAX_APPROACH_CHANGE = 0.02
MAX_POSITION_CHANGE_MM = 0.2


@dataclass(frozen=True)
class Convergence:
    """Results on a mesh and on one with half of its sizes.

    Parameters
    ----------
    summaries
        Summary of each run, coarse mesh first.

    """

    summaries: tuple[WheelsetSummary, WheelsetSummary]

    @property
    def converged(self) -> bool:
        """Whether both runs converged to contact on both sides."""
        return all(each.status.converged and len(each.contacts) > 0 for each in self.summaries)

    @property
    def within(self) -> bool:
        """Whether both runs converged, and approach and positions changed less than the limits."""
        if not self.converged:
            return False
        changes = self.changes()
        return (
            abs(changes["approach_change"]) < MAX_APPROACH_CHANGE
            and changes["position_change_mm"] < MAX_POSITION_CHANGE_MM
        )

    def pairs(self) -> list[tuple[ContactSummary, ContactSummary]]:
        """Contacts of both runs, side by side: that with the maximum force of each side."""
        found = []
        for side in SIDES:
            one, other = ([c for c in each.contacts if c.side == side] for each in self.summaries)
            if one and other:
                found.append((max(one, key=lambda c: c.force_kN), max(other, key=lambda c: c.force_kN)))
        return found

    def changes(self) -> dict[str, float]:
        """Relative changes of approach, pressure and half width; the maximum change of a position in mm."""
        coarse, fine = self.summaries
        pairs = self.pairs()

        def relative(key: str) -> float:
            return max((abs(getattr(b, key) / getattr(a, key) - 1.0) for a, b in pairs), default=float("nan"))

        shifts = [
            abs(getattr(a, key)[axis] - getattr(b, key)[axis])
            for a, b in pairs
            for key in ("rail_position_mm", "wheel_position_mm")
            for axis in (0, 1)
        ]
        before, after = coarse.position.approach_mm, fine.position.approach_mm
        return {
            "approach_change": abs(after / before - 1.0),
            "position_change_mm": max(shifts, default=float("nan")),
            "max_pressure_change": relative("max_pressure_MPa"),
            "half_width_change": relative("half_width_mm"),
        }

    def to_json(self) -> dict[str, Any]:
        """What ``converge.json`` holds."""
        keys = ("status", "position", "residual", "contacts", "bodies", "timings_s")
        summaries = [each.to_dict() for each in self.summaries]
        runs = [{"size_scale": s["case"]["size_scale"]} | {key: s[key] for key in keys} for s in summaries]
        return {
            "within": self.within,
            "changes": self.changes() if self.converged else None,
            "limits": {"approach_change": MAX_APPROACH_CHANGE, "position_change_mm": MAX_POSITION_CHANGE_MM},
            "runs": runs,
            "case": summaries[0]["case"],
            "versions": summaries[0]["versions"],
        }


def run_halved(case: WheelsetCase, progress: Progress = lambda _: None) -> Convergence:
    """Run a case with its own sizes and with half of them.

    It is an `InputError` if the inputs make no problem that can be solved, or half of `size_scale` is not allowed.
    """
    halved = case.from_values({**case.model_dump(), "size_scale": case.size_scale / 2.0})
    case.problem()
    summaries = []
    for run in (case, halved):

        def labelled(sentence: str, scale: float = run.size_scale) -> None:
            progress(f"size scale {scale:g}: {sentence}")

        summaries.append(run.run(labelled).summary)
    return Convergence((summaries[0], summaries[1]))
