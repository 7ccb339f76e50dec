"""Inputs of a wheelset on two rails: what every situation shares."""

from typing import Literal

from pydantic import Field

from flangeway.errors import InputError
from flangeway.materials import Elastic
from flangeway.railway.discretisation import Choice, Discretisation, EnforcementName, Method, PairingName
from flangeway.railway.load import (
    GRAVITY_M_S2,
    Load,
    balanced_superelevation_mm,
    curve_force_N,
    superelevation_angle,
)
from flangeway.railway.problem import Prescribed, WheelsetProblem
from flangeway.railway.track import Track, Wheelset
from flangeway.study.case import Case
from flangeway.study.wheelset_profiles import rail_named, wheel_named


class WheelsetCase(Case):
    """A wheelset on two rails (seed 7.2.1); subclasses are situations with defaults of their own."""

    rail: str = Field("136RE", description="rail: 136RE, 60E1, or a file that `flangeway profile` reads")
    crown_radius_in: float | None = Field(
        None, gt=0.0, description="radius of the crown of a 136RE: 8, 10 or 14 in; 10 if left out"
    )
    wheel: str = Field("AAR-1B", description="wheel: AAR-1B (an approximation), S1002, heavy-haul, or a file")
    throat_radius_mm: float | None = Field(
        None, gt=0.0, description="radius of the AAR-1B's throat beside the flange; the file's if left out"
    )
    left_rail: str | None = Field(None, description="rail of the left side, likewise; as on the right if left out")
    left_wheel: str | None = Field(None, description="wheel of the left side, likewise; as on the right if left out")
    rail_body: str = Field("136RE", description="bundled rail that gives web and foot to a file's head")
    wheel_body: str = Field("AAR-1B", description="bundled wheel that gives the rim to a file's running surface")
    gauge_mm: float = Field(Track.gauge_mm, gt=0.0, description="distance between the rails' heads")
    gauge_depth_mm: float | None = Field(
        None, gt=0.0, description="depth below the tops above which the gauge is measured; closest points if left out"
    )
    cant: float = Field(Track.cant, ge=-0.2, le=0.2, description="inclination of the rails as a slope; 1:40 is 0.025")
    back_to_back_mm: float = Field(
        Wheelset.back_to_back_mm, gt=0.0, description="distance between the wheels' inner faces"
    )
    wheel_radius_mm: float = Field(
        Wheelset.radius_mm, ge=150.0, description="distance from the axle to the place wheel_radius_at"
    )
    wheel_radius_at: Literal["flange-tip", "tape-line"] = Field(
        "flange-tip", description="where wheel_radius_mm is measured"
    )
    left_wheel_radius_mm: float | None = Field(
        None, ge=150.0, description="radius of the left wheel, likewise; same at the tape line if left out"
    )
    barycentre_height_mm: float = Field(
        Wheelset.barycentre_height_mm, description="height of the car's barycentre above the axle"
    )
    axle_load_kN: float = Field(  # noqa: N815 (the unit kilonewton)
        300.0, gt=0.0, description="weight that the wheelset bears; it presses on the rails"
    )
    car_mass_t: float | None = Field(
        None, gt=0.0, description="mass of the car, shared by n_axles, instead of axle_load_kN"
    )
    n_axles: int = Field(4, ge=1, description="wheelsets that share car_mass_t")
    lateral_force_kN: float = Field(  # noqa: N815
        0.0, description="horizontal force at the barycentre, to the right: centrifugal force of a curve to the left"
    )
    speed_km_h: float | None = Field(
        None, ge=0.0, description="speed; with curve_radius_m it gives the centrifugal force for lateral_force_kN"
    )
    curve_radius_m: float | None = Field(None, gt=0.0, description="radius of the curve; needs speed_km_h")
    superelevation_mm: float | Literal["from-speed"] = Field(
        0.0, description="height of the right rail over the left one; from-speed: what balances speed and radius"
    )
    cant_deficiency_mm: float = Field(
        0.0, ge=0.0, description="what a superelevation from-speed lacks of the balanced one"
    )
    superelevation_base_mm: float | None = Field(
        None, gt=0.0, description="width over which superelevation is measured; the gauge if left out"
    )
    lateral_mm: float | None = Field(
        None, description="prescribed lateral motion of the axle's middle in the track's axes; found if left out"
    )
    vertical_mm: float | None = Field(None, description="prescribed vertical motion; found if left out")
    roll_rad: float | None = Field(None, description="prescribed roll, counter-clockwise; found if left out")
    thickness_mm: float = Field(
        WheelsetProblem.thickness_mm, gt=0.0, description="length of the bodies along the track"
    )
    young_MPa: float = Field(  # noqa: N815 (the unit megapascal)
        210e3, gt=0.0, description="Young's modulus of wheels and rails"
    )
    poisson: float = Field(0.3, gt=-1.0, lt=0.5, description="Poisson's ratio of wheels and rails")
    wheel_young_MPa: float | None = Field(None, gt=0.0, description="young_MPa of the wheels, if unlike")  # noqa: N815
    wheel_poisson: float | None = Field(None, gt=-1.0, lt=0.5, description="poisson of the wheels, if unlike")
    rail_young_MPa: float | None = Field(None, gt=0.0, description="young_MPa of the rails, if unlike")  # noqa: N815
    rail_poisson: float | None = Field(None, gt=-1.0, lt=0.5, description="poisson of the rails, if unlike")
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
    penetration_mm: float = Field(
        Discretisation.penetration_mm, gt=0.0, description="penetration that augmented-lagrange tolerates"
    )
    primary: Choice = Field(
        Discretisation.primary, description="body that gives the segments of contact; auto: chosen with a reason"
    )

    def problem(self) -> WheelsetProblem:
        """Return the problem to solve.

        Raises
        ------
        InputError
            If a profile is unknown, a number is not allowed, or inputs contradict each other.

        """
        return WheelsetProblem(
            self._track(),
            self._wheelset(),
            self.load(),
            Elastic(self.young_MPa, self.poisson),
            self.thickness_mm,
            self._discretisation(),
            self._material(self.wheel_young_MPa, self.wheel_poisson),
            self._material(self.rail_young_MPa, self.rail_poisson),
            Prescribed(self.lateral_mm, self.vertical_mm, self.roll_rad),
        )

    def load(self) -> Load:
        """Return weight, lateral force and tilt of the track.

        Raises
        ------
        InputError
            If speed or radius stands alone, or a force is given besides both.

        """
        weight = 1e3 * self.axle_load_kN
        if self.car_mass_t is not None:
            if "axle_load_kN" in self.model_fields_set:
                raise InputError("axle_load_kN and car_mass_t", "one of both", "leave one out")
            weight = 1e3 * self.car_mass_t / self.n_axles * GRAVITY_M_S2
        lateral = 1e3 * self.lateral_force_kN
        base = self.gauge_mm if self.superelevation_base_mm is None else self.superelevation_base_mm
        balanced = None
        if (self.speed_km_h is None) != (self.curve_radius_m is None):
            raise InputError("one of speed_km_h and curve_radius_m", "both or neither", "give the other one as well")
        if self.speed_km_h is not None and self.curve_radius_m is not None:
            if "lateral_force_kN" in self.model_fields_set:
                raise InputError(
                    "lateral_force_kN with speed_km_h and curve_radius_m", "the force or both of these", "leave it out"
                )
            lateral = curve_force_N(weight, self.speed_km_h, self.curve_radius_m)
            balanced = balanced_superelevation_mm(self.speed_km_h, self.curve_radius_m, base)
        if self.superelevation_mm != "from-speed":
            return Load(weight, lateral, superelevation_angle(float(self.superelevation_mm), base))
        if balanced is None:
            raise InputError(
                "superelevation_mm = from-speed without speed_km_h and curve_radius_m", "both", "give them or a height"
            )
        height = max(balanced - self.cant_deficiency_mm, 0.0)
        return Load(weight, lateral, superelevation_angle(height, base))

    def _track(self) -> Track:
        left = None
        if self.left_rail not in (None, self.rail):
            left = rail_named(str(self.left_rail), self._crown(str(self.left_rail)), self.rail_body)
        right = rail_named(self.rail, self._crown(self.rail), self.rail_body)
        return Track(right, self.gauge_mm, self.cant, left, self.gauge_depth_mm)

    def _crown(self, name: str) -> float | None:
        """Radius of the crown for a rail, left out only where the other side's rail is the one that takes it."""
        other = {self.rail, self.left_rail or self.rail} - {name}
        return None if name != "136RE" and "136RE" in other else self.crown_radius_in

    def _throat(self, name: str) -> float | None:
        other = {self.wheel, self.left_wheel or self.wheel} - {name}
        return None if name != "AAR-1B" and "AAR-1B" in other else self.throat_radius_mm

    def _wheelset(self) -> Wheelset:
        right = wheel_named(self.wheel, self._throat(self.wheel), self.wheel_body)
        left = None
        if self.left_wheel not in (None, self.wheel):
            left = wheel_named(str(self.left_wheel), self._throat(str(self.left_wheel)), self.wheel_body)
        radius, left_radius = self.wheel_radius_mm, self.left_wheel_radius_mm
        if self.wheel_radius_at == "tape-line":
            radius += right.flange_height_mm
            left_radius = None if left_radius is None else left_radius + (left or right).flange_height_mm
        return Wheelset(right, self.back_to_back_mm, radius, self.barycentre_height_mm, left, left_radius)

    def _material(self, young: float | None, poisson: float | None) -> Elastic | None:
        if young is None and poisson is None:
            return None
        return Elastic(self.young_MPa if young is None else young, self.poisson if poisson is None else poisson)

    def _discretisation(self) -> Discretisation:
        shared = Discretisation.__dataclass_fields__
        return Discretisation(**{name: getattr(self, name) for name in shared})
