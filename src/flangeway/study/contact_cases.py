"""Small contact problems that show what a contact method can and cannot do."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from itertools import pairwise
from typing import Any, Literal, get_args

import numpy as np
from numpy.typing import NDArray

from flangeway.contact import Contact, ContactSolution, Surface, press
from flangeway.contact.contact import Pairing
from flangeway.contact.enforcement import Enforcement
from flangeway.elements import Element, Lagrange, Virtual
from flangeway.errors import InputError
from flangeway.geometry import Arc, Line, Outline, Placement, circle, polygon, rectangle
from flangeway.materials import Elastic
from flangeway.mesh import PolyMesh, dual, triangulate
from flangeway.problems import Body, Part
from flangeway.solve import solve_contact

Floats = NDArray[np.float64]
Method = Literal["fem", "vem"]

STEEL = Elastic(20e3, 1.0 / 3.0)
"""Steel of the published benchmarks in kN and cm."""


@dataclass(frozen=True)
class Discretisation:
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

    def __post_init__(self) -> None:
        if self.method not in get_args(Method):
            raise InputError(f"Discretisation(method={self.method!r})", "'fem' or 'vem'", "choose one of these")
        if not (np.isfinite(self.size) and self.size > 0.0):
            raise InputError(f"Discretisation(size={self.size})", "a positive length", "give the edges' length")

    @property
    def element(self) -> Element:
        """Element of all cells."""
        return Lagrange(self.order) if self.method == "fem" else Virtual(self.order)

    @property
    def edge_length(self) -> float:
        """Length of the edges on the boundary."""
        return self.size if self.method == "fem" else self.size / 2.0

    def mesh(self, outline: Outline, holes: Sequence[Outline] = ()) -> PolyMesh:
        """Mesh of the region inside an outline and outside of holes."""
        triangles = triangulate(outline, size=self.size, holes=holes)
        return triangles if self.method == "fem" else dual(triangles)

    def part(self, name: str, outline: Outline, held: Any, holes: Sequence[Outline] = (), **where: Any) -> Part:
        """Meshed steel body of unit thickness; ``held`` as in `Body`, ``where`` as in `Part`."""
        return Part(name, Body(name, self.mesh(outline, holes), self.element, STEEL, held), **where)


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


def _surface(part: Part, *names: str) -> Surface:
    return Surface(part, np.concatenate([part.body.mesh.edge_set(name) for name in names]))


def _named_circle(radius: float, name: str) -> Outline:
    segments = circle(radius).segments
    return Outline.from_segments(segments, [name] * len(segments))


def _moved(x: float, y: float) -> Placement:
    return Placement(0.0, (x, y))


def pressed_boxes(
    upper: Discretisation,
    lower: Discretisation,
    pairing: Pairing,
    enforcement: Enforcement,
    *,
    width: float = 2.0,
    height: float = 1.0,
    approach: float = 0.1,
    rotation_rad: float = 0.0,
) -> ContactCase:
    """Two equal boxes of which the upper is pressed upon the lower (contact patch test, seed Figure 64).

    The far sides are held upright to themselves and slide along; one point of each, the left corner, is held both ways.
    So the boxes spread freely and the exact solution is a uniform pressure, whatever the meshes.

    Parameters
    ----------
    upper, lower
        Discretisations of the secondary and of the primary box.
    pairing, enforcement
        Of the contact.
    width, height
        Sides of each box.
    approach
        How much nearer the far sides come.
    rotation_rad
        Turn of everything, the direction of the motion included.

    """
    place = Placement(rotation_rad)
    parts = []
    for name, used, sign, far in (("upper", upper, 1.0, "top"), ("lower", lower, -1.0, "bottom")):
        outline = rectangle(width, height, centre=(width / 2.0, sign * height / 2.0))
        held = {far: "y", (0.0, sign * height): "x"}
        parts.append(used.part(name, outline, held, placement=place))
    contact = Contact(_surface(parts[0], "bottom"), _surface(parts[1], "top"), pairing, enforcement)
    x, y = place.vectors([[0.0, -approach]])[0]
    return ContactCase((contact,), {parts[0]: _moved(float(x), float(y))})


def block_on_long_block(
    upper: Discretisation,
    lower: Discretisation,
    pairing: Pairing,
    enforcement: Enforcement,
    *,
    secondary: Literal["upper", "lower"] = "upper",
    sides: bool = False,
    depth: float = 0.02,
) -> ContactCase:
    """A block 2 wide and 1 high pressed upon one 6 wide and 2 high: contact up to sharp edges.

    Parameters
    ----------
    upper, lower
        Discretisations.
    pairing, enforcement
        Of the contact.
    secondary
        Which block is the secondary one.
    sides
        Whether the surface of the upper block goes round its corners and up its sides.
    depth
        How far the upper block's held top moves down.

    """
    short = upper.part("upper", rectangle(2.0, 1.0, centre=(0.0, 0.5)), "top")
    if sides:
        short = upper.part("upper", _block_with_ears(), "top")
    long = lower.part("lower", rectangle(6.0, 2.0, centre=(0.0, -1.0)), "bottom")
    names = ("left", "bottom", "right") if sides else ("bottom",)
    surfaces = [_surface(short, *names), _surface(long, "top")]
    if secondary == "lower":
        surfaces.reverse()
    return ContactCase((Contact(surfaces[0], surfaces[1], pairing, enforcement),), {short: _moved(0.0, -depth)})


def _block_with_ears() -> Outline:
    """Outline of the short block whose sides are cut below the held top, which no contact surface may touch."""
    points = [(-1.0, 0.0), (1.0, 0.0), (1.0, 0.7), (1.0, 1.0), (-1.0, 1.0), (-1.0, 0.7)]
    return polygon(points, ["bottom", "right", "upper_right", "top", "upper_left", "left"])


def pin_in_bore(
    pin: Discretisation,
    bore: Discretisation,
    pairing: Pairing,
    enforcement: Enforcement,
    *,
    clearance: float = 0.01,
    depth: float = 0.02,
) -> ContactCase:
    """A pin of radius 1 with a held core in a bore of a block, pressed down (conforming contact).

    Parameters
    ----------
    pin, bore
        Discretisations of the secondary and the primary side.
    pairing, enforcement
        Of the contact.
    clearance
        Radius of the bore less that of the pin.
    depth
        How far the pin's core moves down after first touch.

    """
    inner = pin.part("pin", _named_circle(1.0, "rim"), "core", [_named_circle(0.4, "core")])
    block = rectangle(5.0, 5.0, centre=(0.0, 0.0))
    outer = bore.part("bore", block, "bottom", [_named_circle(1.0 + clearance, "rim")])
    contact = Contact(_surface(inner, "rim"), _surface(outer, "rim"), pairing, enforcement)
    return ContactCase((contact,), {inner: _moved(0.0, -clearance - depth)})


def block_into_corner(
    block: Discretisation,
    walls: Discretisation,
    pairing: Pairing,
    enforcement: Enforcement,
    *,
    as_one: bool = False,
    gap: float = 0.01,
    motion: tuple[float, float] = (-0.02, -0.03),
) -> ContactCase:
    """A block moved into the corner of a floor and a wall of one body.

    Parameters
    ----------
    block, walls
        Discretisations of the secondary and the primary side.
    pairing, enforcement
        Of the contact.
    as_one
        One contact of surfaces with a corner, or one contact for the floor and one for the wall that share the block's
        corner node.
    gap
        Distance from floor and wall at first.
    motion
        Motion of the block's held far sides.

    """
    outline = polygon(
        [(-1.0, -1.0), (2.0, -1.0), (2.0, 0.0), (0.0, 0.0), (0.0, 2.0), (-1.0, 2.0)],
        ["base", "right", "floor", "wall", "top", "back"],
    )
    corner = walls.part("walls", outline, {"base": "xy", "back": "xy"})
    square = polygon(
        [(0.0, 0.0), (1.0, 0.0), (1.2, 0.2), (1.2, 1.2), (0.2, 1.2), (0.0, 1.0)],
        ["bottom", "lower_right", "right", "top", "upper_left", "left"],
    )
    moved = block.part("block", square, {"right": "xy", "top": "xy"}, placement=_moved(gap, gap))
    if as_one:
        pairs = [(_surface(moved, "left", "bottom"), _surface(corner, "floor", "wall"))]
    else:
        pairs = [
            (_surface(moved, "bottom"), _surface(corner, "floor")),
            (_surface(moved, "left"), _surface(corner, "wall")),
        ]
    contacts = tuple(Contact(mine, other, pairing, enforcement) for mine, other in pairs)
    return ContactCase(contacts, {moved: _moved(*motion)})


def stack_of_three(
    discretisations: tuple[Discretisation, Discretisation, Discretisation],
    pairing: Pairing,
    enforcement: Enforcement,
    *,
    depth: float = 0.02,
) -> ContactCase:
    """A plate held at its ends between a block above that is pressed down and one below that is held.

    Parameters
    ----------
    discretisations
        Of the block above, the plate, and the block below.
    pairing, enforcement
        Of both contacts.
    depth
        How far the upper block's held top moves down.

    """
    upper = discretisations[0].part("upper", rectangle(2.0, 1.0, centre=(0.0, 0.75)), "top")
    plate = discretisations[1].part(
        "plate",
        polygon(
            [(x, -0.25) for x in (-3.0, -2.0, 2.0, 3.0)] + [(x, 0.25) for x in (3.0, 2.0, -2.0, -3.0)],
            ["left_below", "bottom", "right_below", "right", "right_above", "top", "left_above", "left"],
        ),
        {"left": "xy", "right": "xy"},
    )
    lower = discretisations[2].part("lower", rectangle(3.0, 1.0, centre=(0.3, -0.75)), "bottom")
    contacts = (
        Contact(_surface(upper, "bottom"), _surface(plate, "top"), pairing, enforcement),
        Contact(_surface(plate, "bottom"), _surface(lower, "top"), pairing, enforcement),
    )
    return ContactCase(contacts, {upper: _moved(0.0, -depth)})


@dataclass(frozen=True, eq=False)
class Slide:
    """Forces of a block that slides.

    Parameters
    ----------
    distances
        How far it has moved, shape (n,).
    forces
        Force on it at each place, shape (n, 2).
    node_forces
        Vertical contact forces of the block's surface nodes at each place, shape (n, n_nodes).
    imbalances
        Largest difference of force or moment between both sides over the force, shape (n,).
    iterations
        Newton iterations of each step, shape (n,).
    failure
        Message of the step that did not converge, empty if all did; the arrays end before it.

    """

    distances: Floats
    forces: Floats
    node_forces: Floats
    imbalances: Floats
    iterations: NDArray[np.int64]
    failure: str

    @property
    def roughness(self) -> float:
        """Largest distance of the normal force from its smooth part, a parabola along the path, over its mean."""
        normal = self.forces[:, 1]
        return float(np.abs(self._rough(normal[:, None])).max() / normal.mean())

    @property
    def node_roughness(self) -> float:
        """The same for the force of each node, over the largest force of a node."""
        return float(np.abs(self._rough(self.node_forces)).max() / self.node_forces.max())

    def _rough(self, values: Floats) -> Floats:
        """Values (n, m) less their parabolas along the path."""
        powers = np.vander(self.distances / max(float(self.distances[-1]), np.finfo(np.float64).tiny), 3)
        rest: Floats = values - powers @ np.linalg.lstsq(powers, values, rcond=None)[0]
        return rest


def slide_block(
    block: Discretisation,
    ground: Discretisation,
    pairing: Pairing,
    enforcement: Enforcement,
    *,
    depth: float = 0.01,
    n_edges: int = 20,
    steps_per_edge: int = 8,
    round_edges: bool = False,
) -> Slide:
    """Press a block upon a long one and slide it over edges of the ground.

    Parameters
    ----------
    block, ground
        Discretisations of the secondary block, 1 wide, and the primary one, 6 wide.
    pairing, enforcement
        Of the contact.
    depth
        How far the block's held top is pressed down.
    n_edges
        Edges of the ground that the block passes over.
    steps_per_edge
        Steps for each of them.
    round_edges
        Whether the block's bottom is a shallow arc instead of a line between sharp edges.

    """
    outline = _sledge() if round_edges else rectangle(1.0, 1.0, centre=(0.0, 0.5))
    start = _moved(-n_edges * ground.edge_length / 2.0, 0.0)
    moved = block.part("block", outline, "top", placement=start)
    rest = ground.part("ground", rectangle(6.0, 2.0, centre=(0.0, -1.0)), "bottom")
    contact = Contact(_surface(moved, "bottom"), _surface(rest, "top"), pairing, enforcement)
    pressed = press([contact], {moved: _moved(0.0, -depth)})
    system, response, state = pressed.system, pressed.response, pressed.state
    distances = np.arange(n_edges * steps_per_edge + 1) * ground.edge_length / steps_per_edge
    forces, at_nodes, imbalances, iterations = [], [], [], []
    failure = "" if state.status.converged else state.status.message
    for distance in distances:
        if failure:
            break
        where = {moved: _moved(float(distance), -depth).after(start)}
        placements = tuple(where.get(part, part.placement) for part in system.parts)
        state = solve_contact(response, system, placements, start=state)
        if not state.status.converged:
            failure = f"at {distance:.6g}: {state.status.message}"
            break
        solution = ContactSolution(system, response, state, (), pressed.initial_penetration)
        forces.append(solution.forces[0])
        at_nodes.append(state.nodal_forces[system.nodes_of(contact.secondary), 1])
        imbalances.append(imbalance(solution))
        iterations.append(state.status.iterations)
    return Slide(
        distances[: len(forces)], np.array(forces).reshape(-1, 2), np.array(at_nodes), np.array(imbalances),
        np.array(iterations), failure,
    )  # fmt: skip


def _sledge() -> Outline:
    """Block 1 wide whose bottom is an arc of radius 5."""
    radius, half = 5.0, 0.5
    rise = radius - np.sqrt(radius**2 - half**2)
    arc = Arc((-half, float(rise)), (half, float(rise)), (0.0, radius), counter_clockwise=True)
    corners = [arc.end, (half, 1.0), (-half, 1.0), arc.start]
    lines = [Line(a, b) for a, b in pairwise(corners)]
    return Outline.from_segments([arc, *lines], ["bottom", "right", "top", "left"])


def imbalance(solution: ContactSolution) -> float:
    """Largest difference of force or moment between the two sides of a contact, over its force and the bodies' size."""
    forces = solution.resultants
    size = max(float(np.abs(part.body.mesh.points).max()) for part in solution.system.parts)
    scale = np.array([1.0, 1.0, size]) * max(float(np.abs(forces[..., :2]).max()), np.finfo(np.float64).tiny)
    return float((np.abs(forces.sum(axis=1)) / scale).max())
