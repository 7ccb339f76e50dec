"""The case of a wheelset that stands on straight, level track."""

from typing import ClassVar

from pydantic import Field

from flangeway.materials import Elastic
from flangeway.railway.model import Discretisation, Load, Method, Role, WheelsetProblem
from flangeway.railway.profiles import rail, wheel
from flangeway.railway.track import Track, Wheelset
from flangeway.study.case import Case


class WheelsetTangentCase(Case):
    """A wheelset on two rails under the weight of the car (seed 7.2.1, Figure 90a)."""

    name: ClassVar[str] = "wheelset-tangent"
    title: ClassVar[str] = "A wheelset stands on two rails of straight, level track"

    rail: str = Field("136RE", description="rail section: 136RE")
    crown_radius_in: float | None = Field(
        None, gt=0.0, description="radius of the crown of a 136RE: 8, 10 or 14 in; 10 if left out"
    )
    wheel: str = Field("AAR-1B", description="wheel profile: AAR-1B, an approximation of the standard's")
    gauge_mm: float = Field(Track.gauge_mm, gt=0.0, description="distance between the rails' heads")
    cant: float = Field(Track.cant, ge=-0.2, le=0.2, description="inclination of the rails as a slope; 1:40 is 0.025")
    back_to_back_mm: float = Field(
        Wheelset.back_to_back_mm, gt=0.0, description="distance between the wheels' inner faces"
    )
    wheel_radius_mm: float = Field(
        Wheelset.radius_mm, ge=150.0, description="distance from the axle to the flange's tip"
    )
    barycentre_height_mm: float = Field(
        Wheelset.barycentre_height_mm, description="height of the car's barycentre above the axle"
    )
    axle_load_kN: float = Field(  # noqa: N815 (the unit kilonewton)
        300.0, gt=0.0, description="weight that the wheelset bears; it presses on the rails"
    )
    thickness_mm: float = Field(
        WheelsetProblem.thickness_mm, gt=0.0, description="length of the bodies along the track"
    )
    young_MPa: float = Field(  # noqa: N815 (the unit megapascal)
        210e3, gt=0.0, description="Young's modulus of wheels and rails"
    )
    poisson: float = Field(0.3, gt=-1.0, lt=0.5, description="Poisson's ratio of wheels and rails")
    method: Method = Field(Discretisation.method, description="fem is triangles, vem is polygons with virtual elements")
    size_scale: float = Field(Discretisation.size_scale, ge=0.05, le=20.0, description="factor on both element sizes")
    contact_size_mm: float = Field(
        Discretisation.contact_size_mm, gt=0.0, description="element size where wheel and rail meet"
    )
    body_size_mm: float = Field(Discretisation.body_size_mm, gt=0.0, description="element size elsewhere")
    penalty_factor: float = Field(
        Discretisation.penalty_factor,
        gt=0.0,
        description="penalty as pressure per penetration, over the contact modulus per mm",
    )
    primary: Role = Field(Discretisation.primary, description="body that gives the segments of contact")

    def problem(self) -> WheelsetProblem:
        """Return the problem to solve.

        Raises
        ------
        InputError
            If a profile is unknown or a number is not allowed.

        """
        return WheelsetProblem(
            Track(rail(self.rail, crown_radius_in=self.crown_radius_in), self.gauge_mm, self.cant),
            Wheelset(
                wheel(self.wheel),
                self.back_to_back_mm,
                self.wheel_radius_mm,
                self.barycentre_height_mm,
            ),
            Load(1e3 * self.axle_load_kN),
            Elastic(self.young_MPa, self.poisson),
            self.thickness_mm,
            Discretisation(
                method=self.method,
                contact_size_mm=self.contact_size_mm,
                body_size_mm=self.body_size_mm,
                size_scale=self.size_scale,
                penalty_factor=self.penalty_factor,
                primary=self.primary,
            ),
        )
