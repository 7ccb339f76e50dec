"""Two boxes pressed upon each other, whose exact pressure is uniform, with any meshes, elements and contact."""

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any, Literal

import numpy as np

from flangeway.contact import Contact, ContactSolution, Pairing, Surface, press
from flangeway.contact.pairs import Enforcement
from flangeway.elements import Element, Lagrange, Virtual
from flangeway.geometry import Outline, Placement, rectangle
from flangeway.materials import Elastic
from flangeway.mesh import dual, triangulate
from flangeway.problems import Body, Part

Method = Literal["fem", "vem"]

STEEL = Elastic(20e3, 1.0 / 3.0)
"""Steel of the published benchmarks in kN and cm."""


@dataclass(frozen=True)
class BoxDiscretisation:
    """Mesh and elements of one body.

    Parameters
    ----------
    size
        Edge length of the triangles; the dual polygons' edges on the boundary have half of it.
    method
        ``"fem"``: Lagrange triangles; ``"vem"``: virtual elements on the triangles' dual polygons.
    order
        Order of the elements.

    """

    size: float
    method: Method = "fem"
    order: int = 1

    @property
    def element(self) -> Element:
        """Element of all cells."""
        return Lagrange(self.order) if self.method == "fem" else Virtual(self.order)

    @property
    def edge_length(self) -> float:
        """Length of the edges on the boundary."""
        return self.size if self.method == "fem" else self.size / 2.0

    def part(self, name: str, outline: Outline, held: Any, **where: Any) -> Part:
        """Meshed steel body of unit thickness; ``held`` as in `Body`, ``where`` as in `Part`."""
        mesh = triangulate(outline, size=self.size)
        mesh = mesh if self.method == "fem" else dual(mesh)
        return Part(name, Body(name, mesh, self.element, STEEL, held), **where)


@dataclass(frozen=True, eq=False)
class ContactCase:
    """Contacts among some parts and the motion that presses them.

    Parameters
    ----------
    contacts
        The contacts.
    motion
        Motion of the parts that move, in space.

    """

    contacts: tuple[Contact, ...]
    motion: Mapping[Part, Placement] = field(default_factory=dict)

    def solve(self, **options: Any) -> ContactSolution:
        """Press the parts; options as in `flangeway.contact.press`."""
        return press(self.contacts, self.motion, **options)

    def part(self, name: str) -> Part:
        """Part of a name."""
        sides = [side.part for contact in self.contacts for side in (contact.secondary, contact.primary)]
        return next(part for part in sides if part.name == name)


def surface_of(part: Part, *names: str) -> Surface:
    """Contact surface along edge sets of a part's mesh."""
    return Surface(part, np.concatenate([part.body.mesh.edge_set(name) for name in names]))


def pressed_boxes(
    upper: BoxDiscretisation,
    lower: BoxDiscretisation,
    pairing: Pairing,
    enforcement: Enforcement,
    *,
    width: float = 2.0,
    height: float = 1.0,
    approach: float = 0.1,
    rotation_rad: float = 0.0,
) -> ContactCase:
    """Two equal boxes of which the upper is pressed upon the lower (contact patch test, Moherdaui (2021) Figure 64).

    The far sides slide along their supports; the left corner of each is fixed. So the boxes expand freely and the exact
    solution is a uniform pressure, whatever the meshes. The upper box is the secondary one, `approach` the relative
    displacement of the far sides, and `rotation_rad` rotates everything, the direction of the approach included.
    """
    place = Placement(rotation_rad)
    parts = []
    for name, used, sign, far in (("upper", upper, 1.0, "top"), ("lower", lower, -1.0, "bottom")):
        outline = rectangle(width, height, centre=(width / 2.0, sign * height / 2.0))
        held = {far: "y", (0.0, sign * height): "x"}
        parts.append(used.part(name, outline, held, placement=place))
    contact = Contact(surface_of(parts[0], "bottom"), surface_of(parts[1], "top"), pairing, enforcement)
    x, y = place.vectors([[0.0, -approach]])[0]
    return ContactCase((contact,), {parts[0]: Placement(0.0, (float(x), float(y)))})
