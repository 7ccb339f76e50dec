"""Bodies in contact as one tree of records: contacts with their pairing and enforcement, motions, and load steps."""

# ruff: noqa: N815 (units in names)
from typing import Annotated, Literal

import annotated_types as at
import numpy as np
from pydantic import Field

from flangeway.contact.node_to_segment import OPEN_SLACK, NodeToNode, NodeToSegment
from flangeway.contact.pairs import AugmentedLagrange, Barrier, Enforcement, Multiplier, Penalty
from flangeway.contact.segment_to_segment import SegmentToSegment
from flangeway.geometry import Placement
from flangeway.problems.body_records import (
    BodyTable,
    EdgesForce,
    EdgesSpring,
    EdgesSupport,
    HypothesisName,
    Names,
    NodeForce,
    PointSpring,
    PointSupport,
    PressureLoad,
    TemperatureRise,
    TractionLoad,
    VolumeForce,
    Weight,
)
from flangeway.records import Box, Pair, Positive, Record

Role = Literal["secondary", "primary"]
ROLES: tuple[Role, Role] = ("secondary", "primary")


class SegmentPairing(Record):
    """Gaps averaged over the secondary surface."""

    kind: Literal["segment-to-segment"]
    """gaps averaged over the secondary surface"""
    weighting: Literal["standard", "dual"] = "standard"
    """weights of the gap: hat functions, or their biorthogonal ones"""

    @property
    def pairing(self) -> SegmentToSegment:
        """As contacts take it."""
        return SegmentToSegment(weighting=self.weighting)


class NodePairing(Record):
    """Gaps of the secondary nodes to the primary edges."""

    kind: Literal["node-to-segment"]
    """gaps of the secondary nodes to the primary edges"""
    slack: Annotated[float, at.Gt(0.0), at.Le(OPEN_SLACK)] = NodeToSegment.slack
    """how far beyond its edge, in parts of the edge, a node stays paired with it"""

    @property
    def pairing(self) -> NodeToSegment:
        """As contacts take it."""
        return NodeToSegment(slack=self.slack)


class MatchedPairing(Record):
    """Gaps of nodes to nodes; the boundaries get each other's nodes."""

    kind: Literal["node-to-node"]
    """gaps of nodes to nodes: the boundaries get each other's nodes, for small displacements"""

    @property
    def pairing(self) -> NodeToNode:
        """As contacts take it."""
        return NodeToNode()


class MultiplierLaw(Record):
    """Forces as unknowns."""

    kind: Literal["multiplier"]
    """forces as unknowns, which leave no penetration"""

    def law(self, penalty: float) -> Enforcement:  # noqa: ARG002 (others need one)
        """As contacts take it; a penalty that is left out is the suggested one."""
        return Multiplier()


class PenaltyLaw(Record):
    """Pressure in proportion to the penetration."""

    kind: Literal["penalty"]
    """pressure in proportion to the penetration"""
    penalty_MPa_mm: Positive | None = None
    """pressure per penetration (default: from stiffness and edges of the bodies)"""
    nodal_penalty_N_per_mm: Positive | None = None
    """force per penetration at a node of node-to-segment, instead of penalty_MPa_mm"""

    exclusive = (("penalty_MPa_mm", "nodal_penalty_N_per_mm"),)

    def law(self, penalty: float) -> Enforcement:
        """See `MultiplierLaw.law`."""
        return Penalty(*_penalty(self, penalty))


class AugmentedLaw(Record):
    """A penalty about forces that are corrected."""

    kind: Literal["augmented-lagrange"]
    """a penalty about forces that are corrected until the penetration is tolerated"""
    penalty_MPa_mm: Positive | None = None
    """pressure per penetration (default: from stiffness and edges of the bodies)"""
    nodal_penalty_N_per_mm: Positive | None = None
    """force per penetration at a node of node-to-segment, instead of penalty_MPa_mm"""
    penetration_mm: Positive = 1e-5
    """tolerated penetration"""

    exclusive = PenaltyLaw.exclusive

    def law(self, penalty: float) -> Enforcement:
        """See `MultiplierLaw.law`."""
        return AugmentedLagrange(*_penalty(self, penalty), self.penetration_mm)


class BarrierLaw(Record):
    """Forces of a logarithmic barrier."""

    kind: Literal["barrier"]
    """forces of a logarithmic barrier, which keeps the surfaces apart"""
    barrier_N_per_mm: Positive
    """pressure times gap: a thousandth of the expected pressure times the approach to begin with"""
    reach_mm: Positive
    """gap from which there is no pressure: the approach to begin with"""

    def law(self, penalty: float) -> Enforcement:  # noqa: ARG002 (others need one)
        """See `MultiplierLaw.law`."""
        return Barrier(self.barrier_N_per_mm, self.reach_mm)


def _penalty(law: PenaltyLaw | AugmentedLaw, suggested: float) -> tuple[float, Literal["node", "length"]]:
    """Value of a penalty, and what it is per."""
    if law.nodal_penalty_N_per_mm is not None:
        return law.nodal_penalty_N_per_mm, "node"
    return law.penalty_MPa_mm or suggested, "length"


Pairing = Annotated[
    SegmentPairing | NodePairing | MatchedPairing,
    Field(
        default_factory=lambda: SegmentPairing(kind="segment-to-segment"),
        discriminator="kind",
        description="contact discretisation",
    ),
]
Law = Annotated[
    AugmentedLaw | MultiplierLaw | PenaltyLaw | BarrierLaw,
    Field(
        default_factory=lambda: AugmentedLaw(kind="augmented-lagrange"),
        discriminator="kind",
        description="constraint enforcement",
    ),
]


class Shift(Record):
    """Rigid motion of all supports of a body."""

    body: str
    """name of the body"""
    leg: Annotated[int, at.Ge(1), at.Le(100)] = 1
    """leg of the path: motions of 2 follow those of 1; forces act from 1 on"""
    shift_mm: Pair = (0.0, 0.0)
    """shift of the body's supports"""
    rotation_deg: Annotated[float, at.Ge(-90.0), at.Le(90.0)] = 0.0
    """rotation of the supports, counter-clockwise"""
    centre_mm: Pair = (0.0, 0.0)
    """centre of this rotation"""

    @property
    def placement(self) -> Placement:
        """The motion."""
        turn = Placement.about([self.centre_mm], float(np.deg2rad(self.rotation_deg)))
        return Placement(0.0, self.shift_mm).after(turn)


class Push(Record):
    """A force on all supports of a body, in the first leg."""

    body: str
    """name of the body"""
    leg: Literal[1] = 1
    """the leg in which it acts"""
    push_N: Pair
    """force on the supports: they move along it until the contact carries it"""


class ContactTable(Record):
    """A pair of surfaces that may touch; the secondary surface is better the finer one."""

    secondary: str
    """body with the secondary surface, whose nodes or edges carry the constraints"""
    secondary_edges: Names | None = None
    """its edge sets (default: all free edges)"""
    secondary_box_mm: Box | None = None
    """only its edges inside x_min, y_min, x_max, y_max"""
    primary: str
    """body with the primary surface"""
    primary_edges: Names | None = None
    """its edge sets (default: all free edges)"""
    primary_box_mm: Box | None = None
    """only its edges inside x_min, y_min, x_max, y_max"""
    curved: bool | None = None
    """whether gaps are measured between the drawn arcs, not between straight edges of the mesh (default: yes for
    bodies with an outline)"""
    interference: bool = False
    """whether an overlap before any motion is intended: no warning then"""
    pairing: Pairing
    enforcement: Law
    friction: Annotated[float, at.Ge(0.0), at.Le(10.0)] = 0.0
    """coefficient of Coulomb's friction"""

    def side(self, role: Role) -> tuple[str, Names | None, Box | None, str]:
        """Body of a surface, its edge sets, its box, and the key that a message about the edges names."""
        edges = getattr(self, f"{role}_edges")
        return getattr(self, role), edges, getattr(self, f"{role}_box_mm"), role if edges is None else f"{role}_edges"


class StepsTable(Record):
    """How loads and motions are applied."""

    number: Annotated[int, at.Ge(1), at.Le(1000)] | None = None
    """number of equal steps of each leg; a step that does not converge is halved (default: 1, and with friction as
    many as the error of the steps needs)"""


class BodiesProblem(Record):
    """Bodies in the plane with supports, loads, motions and contacts; common axes, x to the right and y up."""

    thickness_mm: Positive = 1.0
    """length of all bodies out of the plane"""
    hypothesis: HypothesisName = "plane-strain"
    """no strain, or no stress, out of the plane; or bodies of revolution about y, x the radius"""
    bodies: Annotated[list[BodyTable], at.MinLen(1)]
    """the bodies: shape, mesh, elements and material of each"""
    supports: list[EdgesSupport | PointSupport] = Field([])
    """supports, with or without a prescribed displacement"""
    springs: list[EdgesSpring | PointSpring] = Field([])
    """elastic supports of edges and points"""
    loads: list[PressureLoad | TractionLoad | EdgesForce | NodeForce | VolumeForce | TemperatureRise | Weight] = Field(
        []
    )
    """pressures, tractions, forces, weight and changes of temperature"""
    motions: list[Shift | Push] = Field([])
    """rigid motions of bodies in contact, or forces on supports"""
    contacts: list[ContactTable] = Field([])
    """pairs of surfaces that may touch"""
    steps: StepsTable = Field(default_factory=lambda: StepsTable(number=None))
    """how loads and motions are applied"""
