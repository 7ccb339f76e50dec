"""Contact surfaces, search, pairing, gap kinematics, enforcement, and Newton's method for them."""

from flangeway.contact.contact_records import (
    AugmentedLaw,
    BarrierLaw,
    ContactTable,
    MatchedPairing,
    MultiplierLaw,
    NodePairing,
    PenaltyLaw,
    Push,
    SegmentPairing,
    Shift,
    StepsTable,
)
from flangeway.contact.contact_state import ContactState
from flangeway.contact.kinematics import NodeEdgeGaps, node_edge_gaps, shape_functions
from flangeway.contact.newton import solve_contact
from flangeway.contact.node_to_segment import NodeToNode, NodeToSegment
from flangeway.contact.pairs import (
    AugmentedLagrange,
    Barrier,
    Constraints,
    Enforcement,
    Multiplier,
    Pairing,
    Pairs,
    Penalty,
)
from flangeway.contact.press import ContactSolution, LoadStep, NonlinearContact, press, press_nonlinear
from flangeway.contact.press_spatial import SpatialForces, SpatialSolution, press_spatial
from flangeway.contact.search import nearest_edges
from flangeway.contact.segment_to_segment import SegmentToSegment
from flangeway.contact.spatial_contact import (
    FaceSurface,
    RigidCylinder,
    RigidPlane,
    RigidSphere,
    RigidSurface,
    SpatialContact,
)
from flangeway.contact.surface import Surface
from flangeway.contact.system import Contact, ContactLinearisation, ContactSystem

__all__ = [
    "AugmentedLagrange",
    "AugmentedLaw",
    "Barrier",
    "BarrierLaw",
    "Constraints",
    "Contact",
    "ContactLinearisation",
    "ContactSolution",
    "ContactState",
    "ContactSystem",
    "ContactTable",
    "Enforcement",
    "FaceSurface",
    "LoadStep",
    "MatchedPairing",
    "Multiplier",
    "MultiplierLaw",
    "NodeEdgeGaps",
    "NodePairing",
    "NodeToNode",
    "NodeToSegment",
    "NonlinearContact",
    "Pairing",
    "Pairs",
    "Penalty",
    "PenaltyLaw",
    "Push",
    "RigidCylinder",
    "RigidPlane",
    "RigidSphere",
    "RigidSurface",
    "SegmentPairing",
    "SegmentToSegment",
    "Shift",
    "SpatialContact",
    "SpatialForces",
    "SpatialSolution",
    "StepsTable",
    "Surface",
    "nearest_edges",
    "node_edge_gaps",
    "press",
    "press_nonlinear",
    "press_spatial",
    "shape_functions",
    "solve_contact",
]
