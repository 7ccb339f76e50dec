"""Contact surfaces, search, pairing, gap kinematics, enforcement, and Newton's method for them."""

from flangeway.contact.contact_pair import Contact
from flangeway.contact.enforcement import AugmentedLagrange, Barrier, Enforcement, Multiplier, Penalty
from flangeway.contact.kinematics import NodeEdgeGaps, node_edge_gaps, shape_functions
from flangeway.contact.linearisation import ContactLinearisation
from flangeway.contact.newton import ContactState, solve_contact
from flangeway.contact.node_to_node import NodeToNode
from flangeway.contact.node_to_segment import NodeToSegment
from flangeway.contact.pairs import Constraints, Pairing, Pairs
from flangeway.contact.press import ContactSolution, LoadStep, press
from flangeway.contact.press_nonlinear import NonlinearContact, press_nonlinear
from flangeway.contact.search import nearest_edges
from flangeway.contact.segment_to_segment import SegmentToSegment
from flangeway.contact.surface import Surface
from flangeway.contact.system import ContactSystem

__all__ = [
    "AugmentedLagrange",
    "Barrier",
    "Constraints",
    "Contact",
    "ContactLinearisation",
    "ContactSolution",
    "ContactState",
    "ContactSystem",
    "Enforcement",
    "LoadStep",
    "Multiplier",
    "NodeEdgeGaps",
    "NodeToNode",
    "NodeToSegment",
    "NonlinearContact",
    "Pairing",
    "Pairs",
    "Penalty",
    "SegmentToSegment",
    "Surface",
    "nearest_edges",
    "node_edge_gaps",
    "press",
    "press_nonlinear",
    "shape_functions",
    "solve_contact",
]
