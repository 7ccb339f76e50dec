"""Elastic contact in two dimensions with finite and virtual elements, up to a wheelset on two rails.

The packages follow the flow of data: `geometry`, `mesh`, `elements`, `space`, `materials`, `problems`, `solve`,
`contact`, `post`, `railway`, `study`, `report`. What most scripts need stands here.
"""

from importlib.metadata import version

from flangeway import elements, exact, geometry, mesh, post
from flangeway.contact import Contact, ContactSystem, NodeToSegment, Penalty, Surface
from flangeway.elements import Lagrange, Virtual
from flangeway.errors import FlangewayError, InputError
from flangeway.geometry import Outline, Placement
from flangeway.materials import Elastic
from flangeway.mesh import PolyMesh
from flangeway.problems import Body, Elasticity, Part, Torsion
from flangeway.solve import CondensedBodies, ContactState, SparseBodies, Status, solve_contact, solve_torsion
from flangeway.space import Space

__version__ = version("flangeway")

__all__ = [
    "Body",
    "CondensedBodies",
    "Contact",
    "ContactState",
    "ContactSystem",
    "Elastic",
    "Elasticity",
    "FlangewayError",
    "InputError",
    "Lagrange",
    "NodeToSegment",
    "Outline",
    "Part",
    "Penalty",
    "Placement",
    "PolyMesh",
    "Space",
    "SparseBodies",
    "Status",
    "Surface",
    "Torsion",
    "Virtual",
    "elements",
    "exact",
    "geometry",
    "mesh",
    "post",
    "solve_contact",
    "solve_torsion",
]
