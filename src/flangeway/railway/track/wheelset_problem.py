"""What a wheelset computation is about: bodies, loads and what is prescribed."""

import math
from dataclasses import dataclass, field, fields

from flangeway.checks import check_finite, check_positive
from flangeway.materials import Elastic
from flangeway.railway.track.discretisation import Discretisation, Role
from flangeway.railway.track.placements import Track, Wheelset, refuse_misfit
from flangeway.railway.track.wheelset_load import WheelsetLoad


@dataclass(frozen=True)
class Prescribed:
    """Components of the wheelset's motion that are given, axes of the track; None: found by balance.

    What holds them acts at the middle of the axle.

    - `lateral_mm`, `vertical_mm`, `roll_rad`: as in `WheelsetPosition`.
    """

    lateral_mm: float | None = None
    vertical_mm: float | None = None
    roll_rad: float | None = None

    def __post_init__(self) -> None:
        for each in fields(self):
            value = getattr(self, each.name)
            if value is not None:
                check_finite("Prescribed", each.name, value, advice="leave it out to find it")

    @property
    def components(self) -> tuple[float | None, float | None, float | None]:
        """Lateral and vertical motion and roll."""
        return self.lateral_mm, self.vertical_mm, self.roll_rad


@dataclass(frozen=True)
class WheelsetProblem:
    """A wheelset on a track under a load.

    - `thickness_mm`: length of the bodies along the track.
    - `discretisation`: how the bodies are meshed and joined.
    - `wheel_material`, `rail_material`: where it differs from `material`.
    - `prescribed`: components of the motion that are given instead of found.
    - `yield_MPa`: yield strength above which a warning says that the bodies would yield; None: that of rail steel, for
      steel.
    """

    track: Track
    wheelset: Wheelset
    load: WheelsetLoad
    material: Elastic
    thickness_mm: float = 10.0
    discretisation: Discretisation = field(default_factory=Discretisation)
    wheel_material: Elastic | None = None
    rail_material: Elastic | None = None
    prescribed: Prescribed = field(default_factory=Prescribed)
    yield_MPa: float | None = None  # noqa: N815 (the unit megapascal)

    def __post_init__(self) -> None:
        """Refuse wrong numbers, and a wheelset that does not fit its track."""
        check_positive("WheelsetProblem", "thickness_mm", self.thickness_mm, "a positive length", "give it in mm")
        if self.yield_MPa is not None:
            check_positive("WheelsetProblem", "yield_MPa", self.yield_MPa, advice="leave it out")
        refuse_misfit(self.track, self.wheelset)

    def material_of(self, body: Role) -> Elastic:
        """Material of a kind of body."""
        return (self.wheel_material if body == "wheel" else self.rail_material) or self.material

    @property
    def primary(self) -> tuple[Role, str]:
        """Which bodies give the segments of contact, and why."""
        settings = self.discretisation
        if settings.primary != "auto":
            return settings.primary, "chosen by the user"
        spacing = {body: settings.size_of(body) / settings.order_of(body) for body in ("wheel", "rail")}
        stiffness = {body: self.material_of(body).plane_modulus for body in ("wheel", "rail")}
        for values, why in (
            (spacing, "its nodes are farther apart: the finer surface gives the nodes"),
            (stiffness, "it is the stiffer body"),
        ):
            if not math.isclose(values["wheel"], values["rail"], rel_tol=0.05):
                return "wheel" if values["wheel"] > values["rail"] else "rail", why
        return "rail", "meshes and materials are alike, and the rail is the body that is held"
