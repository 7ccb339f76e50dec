"""Inputs of a wheelset on two rails: what every situation shares."""

from typing import TYPE_CHECKING, ClassVar, Literal

from pydantic import Field

from flangeway.cases.case import Progress, RunnableCase
from flangeway.cases.wheelset.wheelset_inputs import WheelsetInputs
from flangeway.materials import Elastic
from flangeway.railway.track.discretisation import Choice, Discretisation, EnforcementName, Method, PairingName
from flangeway.railway.track.wheelset_problem import Prescribed, WheelsetProblem

if TYPE_CHECKING:
    from flangeway.cases.wheelset.runner import CaseRun


class WheelsetCase(WheelsetInputs, RunnableCase):
    """A wheelset on two rails (Moherdaui 2021, 7.2.1); subclasses are situations with defaults of their own."""

    essential: ClassVar[tuple[str, ...]] = (
        *("rail", "wheel", "gauge_mm", "wheel_radius_mm", "axle_load_kN"),
        *("method", "order", "size_scale"),
    )

    lateral_mm: float | None = Field(
        None, description="prescribed lateral motion of the axle's middle in the track's axes; found if left out"
    )
    vertical_mm: float | None = Field(None, description="prescribed vertical motion; found if left out")
    roll_rad: float | None = Field(None, description="prescribed roll, counter-clockwise; found if left out")
    wheel_young_MPa: float | None = Field(None, gt=0.0, description="young_MPa of the wheels, if unlike")  # noqa: N815
    wheel_poisson: float | None = Field(None, gt=-1.0, lt=0.5, description="poisson of the wheels, if unlike")
    rail_young_MPa: float | None = Field(None, gt=0.0, description="young_MPa of the rails, if unlike")  # noqa: N815
    rail_poisson: float | None = Field(None, gt=-1.0, lt=0.5, description="poisson of the rails, if unlike")
    yield_MPa: float | None = Field(  # noqa: N815
        None, gt=0.0, description="yield strength, for a warning; 510 MPa, that of rail steel, if left out"
    )
    method: Method = Field(Discretisation.method, description="fem is triangles, vem is polygons with virtual elements")
    order: int = Field(Discretisation.order, ge=1, le=2, description="order of the elements: FO2 is fem of order 2")
    wheel_method: Method | None = Field(None, description="method of the wheels, if unlike")
    rail_method: Method | None = Field(None, description="method of the rails, if unlike")
    wheel_order: int | None = Field(None, ge=1, le=2, description="order in the wheels, if unlike")
    rail_order: int | None = Field(None, ge=1, le=2, description="order in the rails, if unlike")
    size_scale: float = Field(Discretisation.size_scale, ge=0.05, le=20.0, description="factor on all element sizes")
    contact_size_mm: float = Field(
        Discretisation.contact_size_mm,
        gt=0.0,
        description="element size in contact, doubled for order 2",
    )
    wheel_contact_size_mm: float | None = Field(None, gt=0.0, description="contact_size_mm of the wheels, if unlike")
    rail_contact_size_mm: float | None = Field(None, gt=0.0, description="contact_size_mm of the rails, if unlike")
    body_size_mm: float = Field(Discretisation.body_size_mm, gt=0.0, description="element size elsewhere, likewise")
    growth: float = Field(Discretisation.growth, gt=0.0, le=1.0, description="growth of the size per distance")
    pairing: PairingName = Field(Discretisation.pairing, description="how the surfaces are compared")
    enforcement: EnforcementName = Field(Discretisation.enforcement, description="how penetration is kept off")
    penalty_factor: float = Field(
        Discretisation.penalty_factor,
        gt=0.0,
        description="penalty as pressure per penetration, over the contact modulus per mm",
    )
    nodal_penalty_N_per_mm: float | None = Field(  # noqa: N815
        None,
        gt=0.0,
        description="penalty of node-to-segment as force per penetration at a node; penalty_factor counts if left out",
    )
    penetration_mm: float = Field(
        Discretisation.penetration_mm, gt=0.0, description="penetration that augmented-lagrange tolerates"
    )
    primary: Choice = Field(
        Discretisation.primary, description="body that gives the segments of contact; auto: chosen with a reason"
    )

    equilibria: Literal["reached", "all"] = Field(
        "reached", description="balances that are looked for: the one reached from the middle, or all"
    )

    def check(self) -> None:
        """See `RunnableCase.check`."""
        self.problem()

    def run(self, progress: Progress = lambda _: None) -> "CaseRun":
        """See `RunnableCase.run`."""
        from flangeway.cases.wheelset.runner import run_case  # noqa: PLC0415 (it imports this module)

        return run_case(self, progress)

    def problem(self) -> WheelsetProblem:
        """Return the problem to solve.

        Raises
        ------
        InputError
            If a profile is unknown, a number is not allowed, or inputs contradict each other.

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
            self.equilibria == "all",
            self.yield_MPa,
        )

    def _material(self, young: float | None, poisson: float | None) -> Elastic | None:
        if young is None and poisson is None:
            return None
        return Elastic(self.young_MPa if young is None else young, self.poisson if poisson is None else poisson)

    def _discretisation(self) -> Discretisation:
        shared = Discretisation.__dataclass_fields__.keys() & type(self).model_fields.keys()
        return Discretisation(**{name: getattr(self, name) for name in shared})
