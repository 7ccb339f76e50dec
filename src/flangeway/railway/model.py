"""From profiles to four elastic parts in contact: meshes, surfaces, penalty."""

from collections.abc import Callable
from dataclasses import dataclass, field
from functools import cached_property
from typing import Literal

import numpy as np
from numpy.typing import NDArray

from flangeway.contact import Contact, ContactSystem, NodeToSegment, Penalty, Surface
from flangeway.elements import Element, Lagrange, Virtual
from flangeway.errors import InputError
from flangeway.exact import LineContact, contact_modulus
from flangeway.geometry import Contour, Outline, Placement
from flangeway.materials import Elastic
from flangeway.mesh import PolyMesh, Refinement, dual, triangulate
from flangeway.problems import Body, Part
from flangeway.railway.first_touch import FirstTouch, touching_motion
from flangeway.railway.track import SIDES, Side, Track, Wheelset, WheelsetMotion

Method = Literal["fem", "vem"]
Role = Literal["rail", "wheel"]


@dataclass(frozen=True)
class Load:
    """Force on the wheelset at the car's barycentre, axes of space.

    Parameters
    ----------
    vertical_N
        Weight, down, > 0.

    """

    vertical_N: float  # noqa: N815 (the unit newton)

    def __post_init__(self) -> None:
        if not (np.isfinite(self.vertical_N) and self.vertical_N > 0.0):
            raise InputError(
                f"Load(vertical_N={self.vertical_N})",
                "a positive weight: it presses the wheels on the rails",
                "give the load of the axle in N, 300000 for 30 t",
            )


@dataclass(frozen=True)
class Discretisation:
    """How the bodies are meshed and joined.

    Parameters
    ----------
    method
        ``"fem"``: triangles. ``"vem"``: the polygons dual to the same triangles.
    order
        Order of the elements.
    contact_size_mm
        Size of the triangles in the candidate contact zones.
    body_size_mm
        Size of the triangles far from them.
    growth
        Growth of the size per distance from the zones.
    size_scale
        Factor on both sizes.
    penalty_factor
        Penalty as pressure per penetration, over the contact modulus per mm.
    primary
        Which bodies give the segments; the others give the nodes.

    """

    method: Method = "fem"
    order: int = 1
    contact_size_mm: float = 0.25
    body_size_mm: float = 1.5
    growth: float = 0.1
    size_scale: float = 1.0
    penalty_factor: float = 20.0
    primary: Role = "rail"

    def __post_init__(self) -> None:
        for name in ("contact_size_mm", "body_size_mm", "growth", "size_scale", "penalty_factor"):
            value = getattr(self, name)
            if not (np.isfinite(value) and value > 0.0):
                raise InputError(f"Discretisation({name}={value})", "a positive number", "leave it out")
        for name, allowed in (("method", ("fem", "vem")), ("primary", ("rail", "wheel"))):
            if getattr(self, name) not in allowed:
                raise InputError(
                    f"Discretisation({name}={getattr(self, name)!r})",
                    " or ".join(repr(value) for value in allowed),
                    "choose one of these",
                )

    @property
    def element(self) -> Element:
        """Element of all cells."""
        return Lagrange(self.order) if self.method == "fem" else Virtual(self.order)


@dataclass(frozen=True)
class WheelsetProblem:
    """A wheelset on a track under a load.

    Parameters
    ----------
    track, wheelset, load
        What stands where, and the force on it.
    material
        Material of wheels and rails.
    thickness_mm
        Length of the bodies along the track.
    discretisation
        How the bodies are meshed and joined.

    """

    track: Track
    wheelset: Wheelset
    load: Load
    material: Elastic
    thickness_mm: float = 10.0
    discretisation: Discretisation = field(default_factory=Discretisation)


@dataclass(frozen=True, eq=False)
class WheelsetModel:
    """Meshed parts and their contacts.

    Parameters
    ----------
    problem
        What is modelled.
    touch_motion
        Motion of the wheelset from its reference position to first touch.
    touches
        First touch of each side, left then right.
    hertz
        Contact of one wheel by Hertz's theory for half the load and the curvatures at first touch: sets the zones.
    wheel, rail
        The bodies of the right side; the left side uses the same, mirrored.
    system
        The contacts of both sides.
    parts
        The placed parts by name: ``wheel-left``, ``rail-left``, ``wheel-right``, ``rail-right``.

    """

    problem: WheelsetProblem
    touch_motion: WheelsetMotion
    touches: tuple[FirstTouch, ...]
    hertz: LineContact
    wheel: Body
    rail: Body
    system: ContactSystem
    parts: dict[str, Part]

    @cached_property
    def moving(self) -> NDArray[np.bool_]:
        """Which of the system's parts are wheels."""
        return np.array([part.body is self.wheel for part in self.system.parts])

    @cached_property
    def sides(self) -> tuple[Side, ...]:
        """Side of each of the system's parts."""
        left = (self.contact("left").secondary.part, self.contact("left").primary.part)
        return tuple("left" if part in left else "right" for part in self.system.parts)

    def contact(self, side: Side) -> Contact:
        """Contact of a side."""
        return self.system.contacts[SIDES.index(side)]

    def placements(self, motion: WheelsetMotion) -> tuple[Placement, ...]:
        """Where the system's parts stand after a motion of the wheelset."""
        wheelset = self.problem.wheelset
        return tuple(
            motion.placement(wheelset, side) if moves else part.placement
            for part, side, moves in zip(self.system.parts, self.sides, self.moving, strict=True)
        )


def build_model(problem: WheelsetProblem, progress: Callable[[str], None] = lambda _: None) -> WheelsetModel:
    """Mesh the bodies, fine where they can touch, and pair their surfaces.

    The candidate zone reaches two half widths of Hertz's contact and 10 mm (for the bending of the rail, which
    shifts the contact) to both sides of the first touch.
    """
    settings = problem.discretisation
    touch_motion, touches = touching_motion(problem.track, problem.wheelset)
    right = touches[SIDES.index("right")]
    modulus = problem.material.plane_modulus
    hertz = LineContact(
        problem.load.vertical_N / 2.0 / problem.thickness_mm,
        right.relative_curvature_per_mm,
        contact_modulus(modulus, modulus),
    )
    reach = 2.0 * hertz.half_width + 10.0
    wheel_profile, rail_profile = problem.wheelset.wheel, problem.track.rail
    progress("meshing the wheel")
    wheel, wheel_edges = _body(
        problem, "wheel", wheel_profile.outline, wheel_profile.running_names,
        right.wheel_point_mm, reach, "cut",
    )  # fmt: skip
    progress("meshing the rail")
    rail, rail_edges = _body(
        problem, "rail", rail_profile.outline, rail_profile.head_names,
        right.rail_point_mm, reach, rail_profile.base_names,
    )  # fmt: skip
    penalty = Penalty(settings.penalty_factor * hertz.modulus, per="length")
    parts, contacts = {}, []
    for side in SIDES:
        placed_wheel = Part(f"wheel-{side}", wheel, problem.wheelset.placement(side))
        placed_rail = Part(f"rail-{side}", rail, problem.track.placement(side))
        parts.update({part.name: part for part in (placed_wheel, placed_rail)})
        secondary, primary = Surface(placed_wheel, wheel_edges), Surface(placed_rail, rail_edges)
        if settings.primary == "wheel":
            secondary, primary = primary, secondary
        contacts.append(Contact(secondary, primary, NodeToSegment(), penalty))
    return WheelsetModel(problem, touch_motion, tuple(touches), hertz, wheel, rail, ContactSystem(contacts), parts)


def _body(
    problem: WheelsetProblem,
    name: Role,
    outline: Outline,
    contact_names: tuple[str, ...],
    touch: tuple[float, float],
    reach: float,
    held: str | tuple[str, ...],
) -> tuple[Body, NDArray[np.int32]]:
    """Mesh one body; return it with the edges of its candidate zone."""
    settings = problem.discretisation
    size = settings.contact_size_mm * settings.size_scale
    zone = _zone(outline.part(contact_names), touch, reach)
    body_size = settings.body_size_mm * settings.size_scale
    try:
        mesh = triangulate(outline, size=body_size, refinements=(Refinement(zone, size, settings.growth),))
    except InputError as error:
        raise InputError(
            f"{name}: size_scale={settings.size_scale:g} makes contact_size_mm {size:g} and body_size_mm {body_size:g},"
            f" and no mesh comes of it ({error.given})",
            error.allowed,
            "change size_scale, contact_size_mm or body_size_mm",
        ) from error
    if settings.method == "vem":
        mesh = dual(mesh)
    edges = _edges_within(mesh, contact_names, touch, reach, name)
    if not isinstance(held, str):
        mesh = mesh.with_edge_set("held", np.vstack([mesh.edge_set(part) for part in held]))
        held = "held"
    body = Body(name, mesh, settings.element, problem.material, held, thickness=problem.thickness_mm)
    return body, edges


def _zone(curve: Contour, touch: tuple[float, float], reach: float) -> NDArray[np.float64]:
    """Points of a curve within reach of the first touch, along the curve."""
    points = curve.sampled(spacing=0.25)
    along = _arc_lengths(points)
    middle = along[np.argmin(np.linalg.norm(points - touch, axis=1))]
    return points[np.abs(along - middle) <= reach]


def _edges_within(
    mesh: PolyMesh, names: tuple[str, ...], touch: tuple[float, float], reach: float, name: str
) -> NDArray[np.int32]:
    chain = mesh.chain(*names)
    points = mesh.points[chain]
    along = _arc_lengths(points)
    middle = along[np.argmin(np.linalg.norm(points - touch, axis=1))]
    inside = np.flatnonzero(np.abs(along - middle) <= reach)
    if len(inside) < 3:
        raise InputError(
            f"a mesh with {max(len(inside) - 1, 0)} edges in the contact zone of the {name}",
            "at least two",
            "lower size_scale or contact_size_mm",
        )
    nodes = chain[inside[0] : inside[-1] + 1]
    return np.stack((nodes[:-1], nodes[1:]), axis=1).astype(np.int32)


def _arc_lengths(points: NDArray[np.float64]) -> NDArray[np.float64]:
    steps = np.linalg.norm(np.diff(points, axis=0), axis=1)
    return np.concatenate(([0.0], np.cumsum(steps)))
