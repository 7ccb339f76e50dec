"""What a wheelset computation is about: bodies, meshes, loads and what is prescribed."""

import math
from dataclasses import dataclass, field, fields
from typing import Literal

from flangeway.checks import check_finite, check_integer, check_positive, is_finite, refused
from flangeway.contact import AugmentedLagrange, Multiplier, NodeToSegment, Penalty, SegmentToSegment
from flangeway.elements import Element, Lagrange, Stabilisation, Virtual
from flangeway.errors import InputError, short
from flangeway.materials import Elastic
from flangeway.railway.track.placements import Track, Wheelset, refuse_misfit

# --- Forces on the wheelset, and where they come from.


GRAVITY_M_S2 = 9.80665  # standard acceleration of free fall
MAX_SLOPE = 0.2  # largest superelevation relative to its base width


@dataclass(frozen=True)
class WheelsetLoad:
    """Force at the car's centre of gravity: weight along the vertical, lateral force along the horizontal.

    Parameters
    ----------
    vertical_N
        Weight, down, > 0.
    lateral_N
        Horizontal force to the right: the centrifugal force of a curve to the left.
    tilt_rad
        Rotation of the track by its superelevation, counter-clockwise: positive lifts the right rail.
    """

    vertical_N: float  # noqa: N815 (the unit newton)
    lateral_N: float = 0.0  # noqa: N815
    tilt_rad: float = 0.0

    def __post_init__(self) -> None:
        allowed = "a positive weight: it presses the wheels on the rails"
        advice = "give the load of the axle in N, 300000 for 30 t"
        check_positive("WheelsetLoad", "vertical_N", self.vertical_N, allowed, advice)
        check_finite("WheelsetLoad", "lateral_N", self.lateral_N, "a finite force in N", "leave it out for none")
        if not (is_finite(self.tilt_rad) and abs(self.tilt_rad) < 0.25):
            allowed, advice = "an angle between -0.25 and 0.25 rad", "check the superelevation"
            raise refused("WheelsetLoad", "tilt_rad", self.tilt_rad, allowed, advice)

    @property
    def in_track(self) -> tuple[float, float]:
        """Lateral force in the track's plane, to the right, and force onto it, in N."""
        cosine, sine = math.cos(self.tilt_rad), math.sin(self.tilt_rad)
        along = self.lateral_N * cosine - self.vertical_N * sine
        onto = self.vertical_N * cosine + self.lateral_N * sine
        return along, onto


def curve_force_N(weight_N: float, speed_km_h: float, radius_m: float) -> float:  # noqa: N802
    """Centrifugal force of a weight in a curve, ``(W / g) v^2 / R``: to the right in a curve to the left, R > 0."""
    return weight_N / GRAVITY_M_S2 * (speed_km_h / 3.6) ** 2 / radius_m


def balanced_superelevation_mm(speed_km_h: float, radius_m: float, base_mm: float) -> float:
    """Superelevation at which weight and centrifugal force have no lateral part in the track's plane, signed as R."""
    return base_mm * math.sin(math.atan((speed_km_h / 3.6) ** 2 / (GRAVITY_M_S2 * radius_m)))


def superelevation_angle(superelevation_mm: float, base_mm: float) -> float:
    """Tilt in rad of a track whose right rail is higher by `superelevation_mm`, measured over a base width."""
    if not (base_mm > 0.0 and abs(superelevation_mm) <= MAX_SLOPE * base_mm):
        raise InputError(
            f"superelevation_mm = {superelevation_mm:g} over a base of {base_mm:g} mm",
            "at most a fifth of the base width",
            "give both in mm; 3 cm is 30",
        )
    return math.asin(superelevation_mm / base_mm)


# --- How wheels and rails are meshed, and how their contact is enforced.


Method = Literal["fem", "vem"]
Role = Literal["rail", "wheel"]
ROLES: tuple[Role, Role] = ("wheel", "rail")
Choice = Literal["auto", "rail", "wheel"]
PairingName = Literal["node-to-segment", "segment-to-segment"]
EnforcementName = Literal["penalty", "augmented-lagrange", "multiplier"]
DEPTH_MM = 10.0
"""Depth up to which surfaces that overlap are paired in an iteration, in mm: a wheel sinks by less than 1 mm."""

PRIMARY_SIZE_RATIO = 2.8
"""Ratio of the size on the primary side to that on the other one for node-to-segment contact of order 2 and more, if no
size is given. Edges of one length lock into each other: shifting one surface along the other by a part of an edge
changes the energy, with larger forces than those by which a rail resists the shift. There are many equilibria then, a
part of an edge from each other, and Newton's method goes from one to the next. With several nodes on each edge, and
lengths of no common multiple, these forces cancel."""

NODAL = ("node-to-segment", "penalty")  # pairing and enforcement that can have a penalty per node


@dataclass(frozen=True)
class Discretisation:
    """How the bodies are meshed and joined.

    - `method`: ``"fem"``: triangles. ``"vem"``: the polygons dual to the same triangles.
    - `contact_size_mm`: size of the triangles in the candidate contact zones, for order 1; order 2 has triangles of
      twice the size, with nodes as far apart.
    - `body_size_mm`: size of the triangles far from them, in the same way.
    - `growth`: growth of the size per distance from the zones.
    - `size_scale`: factor on both sizes.
    - `penalty_factor`: penalty as pressure per penetration, over the contact modulus per mm.
    - `nodal_penalty_N_per_mm`: penalty of node-to-segment contact as force per penetration at each secondary node, as
      in Moherdaui (2021); None: by `penalty_factor`.
    - `primary`: which bodies give the segments; the others give the nodes. ``"auto"``: see `WheelsetProblem.primary`.
    - `wheel_method`, `rail_method`, `wheel_order`, `rail_order`, `wheel_contact_size_mm`, `rail_contact_size_mm`: what
      differs for one body; None: as for both.
    - `pairing`: ``"segment-to-segment"`` or, as in Moherdaui (2021), ``"node-to-segment"``, whose nodal pressures
      oscillate. At order 2 elements of the primary side, where ``"auto"`` is the rail, are `PRIMARY_SIZE_RATIO` times
      as large as those of the other one if no size of one of them is given.
    - `enforcement`: ``"penalty"``, ``"augmented-lagrange"`` or ``"multiplier"``.
    - `penetration_mm`: maximum penetration that augmented Lagrange tolerates.
    - `stabilisation`: of polygons; None: their usual one.
    """

    method: Method = "fem"
    order: int = 1
    contact_size_mm: float = 0.25
    body_size_mm: float = 1.5
    growth: float = 0.1
    size_scale: float = 1.0
    penalty_factor: float = 20.0
    nodal_penalty_N_per_mm: float | None = None  # noqa: N815 (units)
    primary: Choice = "auto"
    wheel_method: Method | None = None
    rail_method: Method | None = None
    wheel_order: int | None = None
    rail_order: int | None = None
    wheel_contact_size_mm: float | None = None
    rail_contact_size_mm: float | None = None
    pairing: PairingName = "segment-to-segment"
    enforcement: EnforcementName = "penalty"
    penetration_mm: float = 1e-4
    stabilisation: Stabilisation | None = None

    def __post_init__(self) -> None:
        lengths = ("contact_size_mm", "body_size_mm", "wheel_contact_size_mm", "rail_contact_size_mm", "penetration_mm")
        orders = ("order", "wheel_order", "rail_order")
        for name in (*lengths, "growth", "size_scale", "penalty_factor", "nodal_penalty_N_per_mm", *orders):
            value = getattr(self, name)
            if value is None and getattr(type(self), name) is None:  # the default
                continue
            if name in orders:
                check_integer("Discretisation", name, value, 1, advice="leave it out")
            else:
                check_positive("Discretisation", name, value, advice="leave it out")
        choices: tuple[tuple[str, tuple[str | None, ...]], ...] = (
            ("method", ("fem", "vem")),
            ("wheel_method", ("fem", "vem", None)),
            ("rail_method", ("fem", "vem", None)),
            ("primary", ("auto", "rail", "wheel")),
            ("pairing", ("node-to-segment", "segment-to-segment")),
            ("enforcement", ("penalty", "augmented-lagrange", "multiplier")),
        )
        for name, allowed in choices:
            if getattr(self, name) not in allowed:
                raise InputError(
                    f"Discretisation({name}={short(getattr(self, name))})",
                    " or ".join(repr(value) for value in allowed),
                    "choose one of these",
                )
        if self.nodal_penalty_N_per_mm is not None and (self.pairing, self.enforcement) != NODAL:
            raise InputError(
                f"nodal_penalty_N_per_mm with {self.pairing} and {self.enforcement}",
                " with ".join(NODAL),
                "leave it out, or choose these for pairing and enforcement",
            )

    def method_of(self, body: Role) -> Method:
        """Method of a kind of body."""
        return (self.wheel_method if body == "wheel" else self.rail_method) or self.method

    def order_of(self, body: Role) -> int:
        """Order of the elements of a kind of body."""
        return (self.wheel_order if body == "wheel" else self.rail_order) or self.order

    def size_of(self, body: Role) -> float:
        """Size of the triangles of a kind of body where it can touch, in mm."""
        sizes, order = {"wheel": self.wheel_contact_size_mm, "rail": self.rail_contact_size_mm}, self.order_of(body)
        is_primary = (body == "wheel") == (self.primary == "wheel")
        locks = is_primary and order > 1 and self.pairing == "node-to-segment" and not any(sizes.values())
        return (sizes[body] or self.contact_size_mm * (PRIMARY_SIZE_RATIO if locks else 1.0)) * self.size_scale * order

    def element_of(self, body: Role) -> Element:
        """Element of all cells of a kind of body."""
        order = self.order_of(body)
        return Lagrange(order) if self.method_of(body) == "fem" else Virtual(order, self.stabilisation)

    def pairing_law(self) -> NodeToSegment | SegmentToSegment:
        """How the surfaces are compared."""
        return NodeToSegment() if self.pairing == "node-to-segment" else SegmentToSegment(depth=DEPTH_MM)

    def enforcement_law(self, modulus: float) -> Penalty | AugmentedLagrange | Multiplier:
        """Constraint enforcement, for a contact modulus in MPa."""
        if self.nodal_penalty_N_per_mm is not None:
            return Penalty(self.nodal_penalty_N_per_mm, per="node")
        value = self.penalty_factor * modulus
        if self.enforcement == "penalty":
            return Penalty(value, per="length")
        if self.enforcement == "augmented-lagrange":
            return AugmentedLagrange(value, per="length", penetration=self.penetration_mm)
        return Multiplier()


# --- What a wheelset computation is about: bodies, loads and what is prescribed.


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
        for component in fields(self):
            value = getattr(self, component.name)
            if value is not None:
                check_finite("Prescribed", component.name, value, advice="leave it out to find it")

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
