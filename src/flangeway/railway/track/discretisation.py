"""How wheels and rails are meshed, and how their contact is enforced."""

from dataclasses import dataclass
from typing import Literal

from flangeway.checks import check_integer, check_positive
from flangeway.contact import AugmentedLagrange, Multiplier, NodeToSegment, Penalty, SegmentToSegment
from flangeway.elements import Element, Lagrange, Stabilisation, Virtual
from flangeway.errors import InputError, short

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
