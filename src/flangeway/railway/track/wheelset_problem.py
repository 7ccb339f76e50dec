"""A wheelset computation as one tree of records: track, wheels, load, position, rolling, contact, mesh."""

# ruff: noqa: N815 (units in names)
import math
from collections.abc import Iterable
from functools import cached_property
from typing import Annotated, Any, Literal, TypeAlias

import annotated_types as at
from pydantic import Field, model_validator

from flangeway.contact import AugmentedLagrange, Multiplier, NodeToSegment, Penalty, SegmentToSegment
from flangeway.elements import Element, Lagrange, TraceStabilisation, Virtual
from flangeway.materials import Elastic
from flangeway.railway.track.placements import (
    SIDES,
    RigidTrack,
    RigidWheelPair,
    Side,
    Track,
    WheelPair,
    refuse_misfit,
)
from flangeway.railway.track.rolling import RollingMotion
from flangeway.railway.track.wheelset_loads import Load, Position, WheelsetLoad
from flangeway.records import ElementOrder, Fraction, PoissonRatio, Positive, Record, SolidModulus, refused_by_check

Method = Literal["fem", "vem"]
Role = Literal["rail", "wheel"]
ROLES: tuple[Role, Role] = ("wheel", "rail")
DEPTH_MM = 10.0
"""Depth up to which surfaces that overlap are paired in an iteration, in mm: a wheel sinks by less than 1 mm."""

PRIMARY_SIZE_RATIO = 2.8
"""Ratio of the size on the primary side to that on the other one for node-to-segment contact of order 2 and more, if no
size is given. Edges of one length lock into each other: shifting one surface along the other by a part of an edge
changes the energy, with larger forces than those by which a rail resists the shift. There are many equilibria then, a
part of an edge from each other, and Newton's method goes from one to the next. With several nodes on each edge, and
lengths of no common multiple, these forces cancel."""

NODAL = ("node-to-segment", "penalty")  # pairing and enforcement that can have a penalty per node


class Steel(Record):
    """Linear elastic, isotropic material of wheels and rails."""

    young_MPa: SolidModulus = 210e3
    """Young's modulus"""
    poisson: PoissonRatio = 0.3
    """Poisson's ratio"""

    @property
    def elastic(self) -> Elastic:
        """The material of the elastic bodies."""
        return Elastic(self.young_MPa, self.poisson)


class YieldingSteel(Steel):
    """The same with a yield strength."""

    yield_MPa: Positive | None = None
    """yield strength, for the shakedown position of patches and warnings (default: 510 MPa, rail steel)"""


class Mesh(Record):
    """Elements of the bodies."""

    method: Method = "fem"
    """fem is triangles, vem is polygons with virtual elements"""
    order: ElementOrder = 2
    """order of the elements: FO2 is fem of order 2"""
    size_scale: Annotated[float, at.Ge(0.05), at.Le(20.0)] = 1.0
    """factor on all element sizes"""
    stabilisation: Literal["default", "trace"] = "default"
    """stabilisation of virtual elements; trace: half of the trace (Moherdaui 2021, 3.96)"""


class BodyMesh(Record):
    """What the mesh of one kind of body has of its own in the plane."""

    method: Method | None = None
    """method (default: that of the mesh)"""
    order: ElementOrder | None = None
    """order of the elements (default: that of the mesh)"""
    contact_size_mm: Positive | None = None
    """element size in contact (default: that of both)"""


PATCH_CELLS = 26


class Spatial(Record):
    """Contact in three dimensions."""

    kind: Literal["spatial"] = "spatial"
    """three dimensions"""
    patch_cells: Annotated[int, at.Ge(10), at.Le(60)] = PATCH_CELLS
    """cells across each contact patch, and along it"""


class Plane(Record):
    """Contact of a slice in plane strain without friction (Moherdaui 2021, 7.2)."""

    kind: Literal["plane"] = "plane"
    """a slice of thickness_mm in plane strain"""
    thickness_mm: Positive = 10.0
    """length of the bodies along the track"""
    contact_size_mm: Positive = 0.25
    """element size in contact, doubled for order 2"""
    body_size_mm: Positive = 1.5
    """element size elsewhere, doubled for order 2"""
    growth: Fraction = 0.1
    """growth of the element size per distance"""
    wheel_mesh: BodyMesh = BodyMesh()
    """what the mesh of the wheels has of its own"""
    rail_mesh: BodyMesh = BodyMesh()
    """what the mesh of the rails has of its own"""
    wheel_material: Steel | None = None
    """material of the wheels (default: material)"""
    rail_material: Steel | None = None
    """material of the rails (default: material)"""
    pairing: Literal["node-to-segment", "segment-to-segment"] = "segment-to-segment"
    """contact discretisation"""
    enforcement: Literal["penalty", "augmented-lagrange", "multiplier"] = "penalty"
    """constraint enforcement"""
    penalty_factor: Positive = 20.0
    """penalty (pressure per penetration) relative to the contact modulus per mm"""
    nodal_penalty_N_per_mm: Positive | None = None
    """penalty of node-to-segment as force per penetration at a node, as in Moherdaui (2021) (default: from
    penalty_factor)"""
    penetration_mm: Positive = 1e-4
    """tolerated penetration of augmented-lagrange"""
    primary: Literal["auto", "rail", "wheel"] = "auto"
    """primary surface; auto: chosen, and the reason is reported"""

    @model_validator(mode="after")
    def _has_nodes(self) -> "Plane":
        if self.nodal_penalty_N_per_mm is not None and (self.pairing, self.enforcement) != NODAL:
            raise refused_by_check(
                f"nodal_penalty_N_per_mm with {self.pairing} and {self.enforcement}",
                " with ".join(NODAL),
                "leave it out, or choose these for pairing and enforcement",
            )
        return self

    def mesh_of(self, body: Role) -> BodyMesh:
        """What the mesh of a kind of body has of its own."""
        return self.wheel_mesh if body == "wheel" else self.rail_mesh

    @property
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


WheelRailContact: TypeAlias = Annotated[Spatial | Plane, Field(discriminator="kind")]
"""How wheels and rails touch."""

OF_ROLLING = ("track.left.friction", "track.right.friction", "wheelset.wheels")
"""Inputs that have an effect where a wheelset rolls."""
NOT_IN_A_PLANE = (
    *("track.support", "track.left.support", "track.right.support", "wheelset.section", "wheelset.axle"),
    *("position.yaw_mrad", "rolling", *OF_ROLLING),
)
"""Inputs that only three dimensions have."""


class WheelsetOnTrack(Record):
    """Profiles, measures, load and material of a wheelset on two rails."""

    track: RigidTrack = RigidTrack()
    """the two rails"""
    wheelset: RigidWheelPair = RigidWheelPair()
    """the two wheels and their axle"""
    load: Load = Load()
    """weight, lateral force or curve"""
    material: Steel = Steel()
    """steel of wheels and rails"""

    @cached_property
    def forces(self) -> WheelsetLoad:
        """Weight, lateral force and tilt of the track."""
        return self.load.forces(self.track.base_mm)

    @cached_property
    def wheels(self) -> RigidWheelPair:
        """The wheels with their distance; an `InputError` if it follows from no gauge, or they do not fit the rails."""
        wheels = self.wheelset.on(self.track)
        refuse_misfit(self.track, wheels)
        return wheels

    @property
    def has_alike_sides(self) -> bool:
        """Whether left and right are mirror images of each other, but for the load."""
        return self.track.is_symmetric and self.wheelset.is_symmetric


class WheelsetProblem(WheelsetOnTrack):
    """A wheelset on a track under a load: all that its solution depends on."""

    track: Track = Track()
    """the two rails"""
    wheelset: WheelPair = WheelPair()
    """the two wheels and their axle"""
    material: YieldingSteel = YieldingSteel()
    """steel of wheels and rails"""
    position: Position = Position()
    """components of the position that are prescribed"""
    rolling: RollingMotion | None = None
    """steady rolling with friction (default: contact without friction)"""
    contact: WheelRailContact = Spatial()
    """how wheels and rails touch"""
    mesh: Mesh = Mesh()
    """elements of the bodies"""

    @model_validator(mode="after")
    def _goes_together(self) -> "WheelsetProblem":
        weight = {"axle_load_kN", "car"} & self.load.model_fields_set
        if self.position.vertical_mm is not None and weight:
            raise refused_by_check(
                f"position.vertical_mm with load.{' and load.'.join(weight)}",
                "the load, or the vertical position, from which the force follows",
                "leave one of them out",
            )
        if isinstance(self.contact, Plane):
            self._refuse_others(NOT_IN_A_PLANE, "contact.kind = plane", "what a slice of wheel and rail has")
        elif self.rolling is None:
            self._refuse_others(OF_ROLLING, "no table rolling", "it together with a table rolling")
        else:
            speeds = self.rolling.speed_km_h, None if self.load.curve is None else self.load.curve.speed_km_h
            if not any(speeds) or None not in speeds:
                raise refused_by_check(
                    f"rolling with {'no speed' if not any(speeds) else 'a speed of its own in a curve'}",
                    "one speed: rolling.speed_km_h on straight track, load.curve.speed_km_h in a curve",
                    "give one of them",
                )
            for name in ("torque_kNm", "yaw_stiffness_kNm_per_mrad"):
                if getattr(self.rolling, name) and self._has_no_friction:
                    raise refused_by_check(
                        f"rolling.{name} = {getattr(self.rolling, name):g} with rolling.friction = 0",
                        "friction above 0",
                        f"leave {name} out, or give friction",
                    )
        _ = self.forces
        return self

    def _refuse_others(self, paths: Iterable[str], there_is: str, allow: str) -> None:
        """Refuse inputs that have no effect with what there is, if they are not those by default."""
        for path in paths:
            value: Any = self
            for name in path.split("."):
                there, value = value, getattr(value, name)
            if value != type(there).model_fields[name].default:
                raise refused_by_check(f"{path} with {there_is}", allow, f"leave {path} out")

    @property
    def bodies(self) -> tuple[Record, ...]:
        """What the elastic bodies depend on: of the problem all but position, load and rolling."""
        return self.track, self.wheelset, self.material, self.contact, self.mesh

    # --- What of it is in three dimensions.

    @property
    def patch_cells(self) -> int:
        """Cells across each contact patch, and along it."""
        return self.contact.patch_cells if isinstance(self.contact, Spatial) else PATCH_CELLS

    @property
    def _has_no_friction(self) -> bool:
        """Whether the inputs say so: the file of friction along the track is not read for it."""
        rolls = self.rolling is not None and self.rolling.friction != 0.0
        return not rolls and not any(self.track.side(side).friction for side in SIDES)

    @property
    def friction(self) -> RollingMotion | None:
        """How it rolls with friction; None without."""
        rolls = self.rolling is not None and any(self.friction_of(side) > 0.0 for side in SIDES)
        return self.rolling if rolls else None

    def friction_of(self, side: Side) -> float:
        """Static coefficient of friction on the tread of a side; 0 without rolling."""
        if self.rolling is None:
            return 0.0
        own = self.track.side(side).friction
        return self.rolling.coefficient if own is None else own

    @property
    def speed_m_s(self) -> float:
        """Speed of the axle's middle along the track; 0 where it stands."""
        curve = None if self.load.curve is None else self.load.curve.speed_km_h
        own = None if self.rolling is None else self.rolling.speed_km_h
        return (own or curve or 0.0) / 3.6

    @property
    def turning_rad_s(self) -> float:
        """Yaw rate in space of a wheelset that rolls, counter-clockwise from above."""
        own = 0.0 if self.rolling is None else 1e-3 * self.rolling.yaw_rate_mrad_per_s
        return own + (0.0 if self.load.curve is None else self.speed_m_s / self.load.curve.radius_m)

    @property
    def is_symmetric(self) -> bool:
        """Whether left and right are mirror images of each other: profiles, load and motion."""
        rolling = self.rolling
        straight = rolling is None or not (
            self.load.curve or rolling.yaw_rate_mrad_per_s or rolling.lateral_velocity_mm_per_s
        )
        return self.has_alike_sides and straight and self.forces.is_symmetric and not self.position.yaw_mrad

    # --- Elements and materials.

    @property
    def plane(self) -> Plane:
        """Settings of a slice; those by default of three dimensions."""
        return self.contact if isinstance(self.contact, Plane) else Plane()

    def material_of(self, body: Role) -> Elastic:
        """Material of a kind of body."""
        own = self.plane.wheel_material if body == "wheel" else self.plane.rail_material
        return (own or self.material).elastic

    def method_of(self, body: Role) -> Method:
        """Method of a kind of body."""
        return self.plane.mesh_of(body).method or self.mesh.method

    def order_of(self, body: Role) -> int:
        """Order of the elements of a kind of body."""
        return self.plane.mesh_of(body).order or self.mesh.order

    def size_of(self, body: Role) -> float:
        """Size of the triangles of a kind of body where it can touch in the plane, in mm.

        For order 2 twice that for order 1, with nodes as far apart.
        """
        plane, order = self.plane, self.order_of(body)
        own = plane.mesh_of(body).contact_size_mm
        is_primary = (body == "wheel") == (plane.primary == "wheel")
        sizes = plane.wheel_mesh.contact_size_mm or plane.rail_mesh.contact_size_mm
        locks = is_primary and order > 1 and plane.pairing == "node-to-segment" and not sizes
        return (own or plane.contact_size_mm * (PRIMARY_SIZE_RATIO if locks else 1.0)) * self.mesh.size_scale * order

    def element_of(self, body: Role) -> Element:
        """Element of all cells of a kind of body."""
        order = self.order_of(body)
        trace = TraceStabilisation() if self.mesh.stabilisation == "trace" else None
        return Lagrange(order) if self.method_of(body) == "fem" else Virtual(order, trace)

    @property
    def primary(self) -> tuple[Role, str]:
        """Which bodies give the segments of contact in the plane, and why."""
        if self.plane.primary != "auto":
            return self.plane.primary, "chosen by the user"
        spacing = {body: self.size_of(body) / self.order_of(body) for body in ROLES}
        stiffness = {body: self.material_of(body).plane_modulus for body in ROLES}
        for values, why in (
            (spacing, "its nodes are farther apart: the finer surface gives the nodes"),
            (stiffness, "it is the stiffer body"),
        ):
            if not math.isclose(values["wheel"], values["rail"], rel_tol=0.05):
                return "wheel" if values["wheel"] > values["rail"] else "rail", why
        return "rail", "meshes and materials are alike, and the rail is the body that is held"

    def mirrored(self) -> "WheelsetProblem":
        """The problem as a mirror in the middle of the track shows it: right is left, with equal sides."""
        load, position, rolling = self.load, self.position, self.rolling
        load = load.replaced(**_reversed(load, "lateral_force_kN", "superelevation_mm", "offset_mm"))
        if load.curve is not None:
            load = load.replaced(curve=_reversed(load.curve, "radius_m"))
        position = position.replaced(**_reversed(position, "lateral_mm", "roll_rad", "yaw_mrad"))
        if rolling is not None:
            rolling = rolling.replaced(**_reversed(rolling, "yaw_rate_mrad_per_s", "lateral_velocity_mm_per_s"))
        return self.replaced(load=load, position=position, rolling=rolling)


def _reversed(record: Record, *names: str) -> dict[str, float]:
    """Inputs that are written with the other sign."""
    values = {name: getattr(record, name) for name in names if name in record.model_fields_set}
    return {name: 0.0 - value for name, value in values.items() if value is not None}
