"""Contact surfaces, search, pairing, gap kinematics and enforcement."""

from flangeway.contact.contact_pair import Contact
from flangeway.contact.enforcement import AugmentedLagrange, Barrier, Enforcement, Multiplier, Penalty
from flangeway.contact.kinematics import NodeEdgeGaps, node_edge_gaps, shape_functions
from flangeway.contact.node_to_node import NodeToNode
from flangeway.contact.node_to_segment import NodeToSegment
from flangeway.contact.pairs import Pairing, Pairs
from flangeway.contact.press import ContactSolution, LoadStep, press
from flangeway.contact.search import nearest_edges
from flangeway.contact.segment_to_segment import SegmentToSegment
from flangeway.contact.surface import Surface
from flangeway.contact.system import ContactLinearisation, ContactSystem

__all__ = [
    "AugmentedLagrange",
    "Barrier",
    "Contact",
    "ContactLinearisation",
    "ContactSolution",
    "ContactSystem",
    "Enforcement",
    "LoadStep",
    "Multiplier",
    "NodeEdgeGaps",
    "NodeToNode",
    "NodeToSegment",
    "Pairing",
    "Pairs",
    "Penalty",
    "SegmentToSegment",
    "Surface",
    "nearest_edges",
    "node_edge_gaps",
    "press",
    "shape_functions",
]
