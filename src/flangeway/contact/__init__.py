"""Contact surfaces, search, pairing, gap kinematics and enforcement."""

from flangeway.contact.contact import Contact, ContactLinearisation, ContactSystem
from flangeway.contact.enforcement import Penalty
from flangeway.contact.node_to_segment import NodeToSegment
from flangeway.contact.surface import Surface

__all__ = [
    "Contact",
    "ContactLinearisation",
    "ContactSystem",
    "NodeToSegment",
    "Penalty",
    "Surface",
]
