"""From profiles to four elastic parts in contact: meshes, surfaces, penalty; and the regions of validity."""

import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from functools import cached_property
from importlib.metadata import version
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from flangeway.contact import Contact, ContactSystem, Surface
from flangeway.errors import InputError
from flangeway.exact import LineContact, contact_modulus
from flangeway.geometry import Contour, Placement
from flangeway.geometry.arrays import chain_lengths
from flangeway.mesh import PolyMesh, Refinement, dual, triangulate
from flangeway.problems import Body, LinearBody, Part
from flangeway.railway.profiles.bundled import RailProfile, WheelProfile
from flangeway.railway.profiles.orientation import conforming, relative_curvature
from flangeway.railway.rigid.rigid_equilibrium import RigidStart, rigid_start
from flangeway.railway.track.placements import SIDES, Side, WheelsetPosition
from flangeway.railway.track.wheelset_problem import ROLES, Role, WheelsetProblem
from flangeway.system.disk_cache import Arrays, Cache, cached
from flangeway.types import Bools, Floats

# --- Meshes of wheels and rails, fine in the candidate zones of contact, kept from one process to the next.


SUPPORT = "support"
"""Edge set of what is held of a wheel or rail, or stands on a foundation."""


@dataclass(frozen=True)
class Zone:
    """A stretch of a curve about some points.

    - `centres`: points on or near the curve in its frame, at least one.
    - `reach`: length of the stretch beyond the first and the last of them, along the curve; infinite: all of it.
    """

    centres: tuple[tuple[float, float], ...]
    reach: float

    def points(self, curve: Contour) -> Floats:
        """Points of the curve inside of the zone, shape (n, 2)."""
        points = curve.sampled(spacing=0.25)
        return points[self._inside(points)]

    def edges(self, mesh: PolyMesh, names: tuple[str, ...], body: str) -> NDArray[np.int32]:
        """Edges of a mesh inside of the zone, along the named edge sets, shape (n, 2)."""
        chain = mesh.chain(*names)
        inside = np.flatnonzero(self._inside(mesh.points[chain]))
        if len(inside) < 3:
            raise InputError(
                f"a mesh with {max(len(inside) - 1, 0)} edges in the contact zone of the {body}",
                "at least two",
                "lower size_scale or contact_size_mm",
            )
        nodes = chain[inside[0] : inside[-1] + 1]
        return np.stack((nodes[:-1], nodes[1:]), axis=1).astype(np.int32)

    def _inside(self, points: Floats) -> Bools:
        along = chain_lengths(points)
        at = [along[np.argmin(np.linalg.norm(points - centre, axis=1))] for centre in self.centres]
        inside: Bools = (along >= min(at) - self.reach) & (along <= max(at) + self.reach)
        return inside


def meshed_body(
    problem: WheelsetProblem, role: Role, side: Side, zone: Zone, cache: Cache | None
) -> tuple[Body, NDArray[np.int32], Contour]:
    """Mesh one body; return it with the edges of its candidate zone, and the drawn surface there."""
    plane, scale = problem.plane, problem.mesh.size_scale
    profile = problem.wheels.wheel_of(side) if role == "wheel" else problem.track.rail_of(side)
    surface, size = profile.outline.part(profile.running_names), problem.size_of(role)
    body_size = plane.body_size_mm * scale * problem.order_of(role)
    try:
        mesh = mesh_profile(
            problem, role, profile, body_size, Refinement(zone.points(surface), size, plane.growth), cache
        )
    except InputError as error:
        raise InputError(
            f"{role}: size_scale={scale:g} makes contact_size_mm {size:g} and body_size_mm "
            f"{body_size:g}, and no mesh comes of it ({error.given})",
            error.allowed,
            "change size_scale, contact_size_mm or body_size_mm",
        ) from error
    edges = zone.edges(mesh, profile.running_names, role)
    material, thickness = problem.material_of(role), plane.thickness_mm
    return Body(role, mesh, problem.element_of(role), material, SUPPORT, thickness=thickness), edges, surface


def mesh_profile(
    problem: WheelsetProblem,
    role: Role,
    profile: WheelProfile | RailProfile,
    size: float,
    refinement: Refinement,
    cache: Cache | None,
) -> PolyMesh:
    """Mesh a profile by triangles or the polygons dual to them, or take the mesh stored for the same input.

    What is held of it is the edge set `SUPPORT`.
    """
    outline, polygons = profile.outline, problem.method_of(role) == "vem"

    def make() -> Arrays:
        mesh = triangulate(outline, size=size, refinements=(refinement,))
        return _packed(dual(mesh) if polygons else mesh)

    fine = refinement.points, refinement.size, refinement.growth
    content = outline.segments, outline.names, size, *fine, polygons, version("gmsh")
    mesh = _unpacked(cached(cache, make, "mesh", *content))
    return mesh.with_edge_set(SUPPORT, np.vstack([mesh.edge_set(name) for name in profile.held_names]))


def _packed(mesh: PolyMesh) -> Arrays:
    arrays: dict[str, NDArray[Any]] = {
        "points": mesh.points,
        "cell_offsets": mesh.cell_offsets,
        "cell_points": mesh.cell_points,
    }
    for kind, sets in (("cell", mesh.cell_sets), ("edge", mesh.edge_sets)):
        arrays[f"{kind}_names"] = np.array(list(sets), dtype=np.str_)
        arrays |= {f"{kind}_{number}": values for number, values in enumerate(sets.values())}
    return arrays


def _unpacked(arrays: Arrays) -> PolyMesh:
    cell_sets, edge_sets = (
        {str(name): np.asarray(arrays[f"{kind}_{number}"]) for number, name in enumerate(arrays[f"{kind}_names"])}
        for kind in ("cell", "edge")
    )
    return PolyMesh(arrays["points"], arrays["cell_offsets"], arrays["cell_points"], cell_sets, edge_sets)


# --- From profiles to four elastic parts in contact: meshes, surfaces, penalty; and the regions of contact.


BENDING_MM = 10.0  # how far the bending of the rail may shift a contact


MIN_CURVATURE_PER_MM = 1e-4  # relative curvature that conforming curves are given for the size of the zones


@dataclass(frozen=True, eq=False)
class WheelsetModel:
    """Meshed parts and their contacts.

    - `rigid_start`: equilibria of the rigid wheelset: the search for the elastic one starts there.
    - `hertz`: Hertz's contact of one wheel for half the load and the curvatures of the rigid contact: sets the zones.
    - `parts`: the placed parts by name: ``wheel-left``, ``rail-left``, ``wheel-right``, ``rail-right``.
    """

    problem: WheelsetProblem
    rigid_start: RigidStart
    hertz: LineContact
    system: ContactSystem
    parts: dict[str, Part]

    @property
    def rigid_position(self) -> WheelsetPosition:
        """Position of the rigid wheelset in equilibrium."""
        return self.rigid_start.motion

    @property
    def wheel(self) -> LinearBody:
        """Body of the right wheel."""
        return self.parts["wheel-right"].body

    @property
    def rail(self) -> LinearBody:
        """Body of the right rail."""
        return self.parts["rail-right"].body

    @cached_property
    def bodies(self) -> tuple[LinearBody, ...]:
        """All bodies, wheels first, each once."""
        names = ("wheel-right", "wheel-left", "rail-right", "rail-left")
        return tuple(dict.fromkeys(self.parts[name].body for name in names))

    @cached_property
    def moving(self) -> NDArray[np.bool_]:
        """Which of the system's parts are wheels."""
        return np.array([part.name.startswith("wheel") for part in self.system.parts])

    @cached_property
    def sides(self) -> tuple[Side, ...]:
        """Side of each of the system's parts."""
        return tuple("left" if part.name.endswith("left") else "right" for part in self.system.parts)

    def contact(self, side: Side) -> Contact:
        """Contact of a side."""
        return self.system.contacts[SIDES.index(side)]

    def hertz_at(self, side: Side, wheel_point: ArrayLike, rail_point: ArrayLike, force: float) -> LineContact | None:
        """Hertz's contact under a normal force with the curvatures at points of undeformed profiles, each (2,).

        None where the profiles conform; see `flangeway.railway.profiles.orientation.conforming`.
        """
        wheel, rail = self.problem.wheels.wheel_of(side), self.problem.track.rail_of(side)
        curvature = relative_curvature(wheel, wheel_point, rail, rail_point)
        if not curvature > 0.0:
            return None
        contact = LineContact(force / self.problem.plane.thickness_mm, curvature, self.hertz.modulus)
        return None if conforming(wheel, wheel_point, rail, rail_point, contact.half_width) else contact

    def placements(self, position: WheelsetPosition) -> tuple[Placement, ...]:
        """Placements of the system's parts at a position of the wheelset."""
        wheelset = self.problem.wheels
        return tuple(
            position.placement(wheelset, side) if moves else part.placement
            for part, side, moves in zip(self.system.parts, self.sides, self.moving, strict=True)
        )


def build_model(
    problem: WheelsetProblem,
    progress: Callable[[str], None] = lambda _: None,
    *,
    whole: bool = False,
    cache: Cache | None = None,
) -> WheelsetModel:
    """Mesh the bodies, fine where they can touch, and pair their surfaces.

    The candidate zones go round the places where rigid wheels touch or nearly touch where the load takes them, with two
    half widths of Hertz's contact and what the bending of the rail shifts beyond. An `InputError` if no rigid wheelset
    stands on this track under this load, or a body cannot be meshed.

    - `progress`: called with a sentence at each stage.
    - `whole`: zones over the whole running surfaces and heads, for contact anywhere.
    - `cache`: where meshes are kept from one process to the next; None: nowhere.
    """
    start = rigid_start(problem)
    hertz = LineContact(
        problem.forces.vertical_N / 2.0 / problem.plane.thickness_mm,
        max(start.relative_curvature_per_mm, MIN_CURVATURE_PER_MM),
        contact_modulus(*(problem.material_of(role).plane_modulus for role in ROLES)),
    )
    width = 2.0 * hertz.half_width
    zones = _zones(
        problem, _with_wide(start.near_points(), start.close_points(), width), math.inf if whole else width + BENDING_MM
    )
    wheelset, track = problem.wheels, problem.track
    bodies: dict[tuple[Role, int], tuple[LinearBody, NDArray[np.int32], Contour]] = {}
    parts, edges, curves = {}, {}, {}
    for side in SIDES:
        for role in ROLES:
            placement = wheelset.placement(side) if role == "wheel" else track.placement(side)
            profile = wheelset.wheel_of(side) if role == "wheel" else track.rail_of(side)
            name = f"{role}-{side}"
            if (role, id(profile)) not in bodies:
                progress(f"meshing the {role}" if not bodies or len(bodies) < 2 else f"meshing the other {role}")
                bodies[role, id(profile)] = meshed_body(problem, role, side, zones[name], cache)
            body, edges[name], curves[name] = bodies[role, id(profile)]
            parts[name] = Part(name, body, placement)
    contacts = []
    for side in SIDES:
        primary, secondary = f"rail-{side}", f"wheel-{side}"
        if problem.primary[0] == "wheel":
            primary, secondary = secondary, primary
        second, first = (
            Surface(parts[name], edges[name], curves[name], nodes_only=True) for name in (secondary, primary)
        )
        contacts.append(Contact(second, first, problem.plane.pairing_law, problem.plane.enforcement_law(hertz.modulus)))
    return WheelsetModel(problem, start, hertz, ContactSystem(contacts), parts)


def _with_wide(points: Mapping[str, Floats], close: Mapping[str, Floats], width: float) -> dict[str, Floats]:
    """Places of contact, and besides those close to it that are farther than a width from all of them."""
    boxes = {}
    for name, at in points.items():
        apart = np.linalg.norm(close[name][:, None] - at, axis=2).min(axis=1, initial=np.inf)
        boxes[name] = np.vstack((at, close[name][apart > width]))
    return boxes


def _zones(problem: WheelsetProblem, near: Mapping[str, Floats], reach: float) -> dict[str, Zone]:
    """Zone of each part; equal profiles of both sides share one zone."""
    points_by_name = {name: [(float(x), float(y)) for x, y in points] for name, points in near.items()}
    if problem.track.rail_of("left") is problem.track.rail_of("right"):
        points_by_name["rail-left"] = points_by_name["rail-right"] = (
            points_by_name["rail-left"] + points_by_name["rail-right"]
        )
    if problem.wheels.wheel_of("left") is problem.wheels.wheel_of("right"):
        points_by_name["wheel-left"] = points_by_name["wheel-right"] = (
            points_by_name["wheel-left"] + points_by_name["wheel-right"]
        )
    return {name: Zone(tuple(at), reach) for name, at in points_by_name.items()}


GAUGE_SIDE = np.tan(np.deg2rad(15.0))  # slope of the contact from which it is named after the gauge corner


def region_of(side: Side, lateral: float, vertical: float) -> str:
    """Part of the rail in contact by the force on a wheel in the track's axes.

    ``crown``, ``gauge corner`` or ``field corner``.
    """
    inward = -lateral if side == "right" else lateral
    if abs(inward) < GAUGE_SIDE * vertical:
        return "crown"
    return "gauge corner" if inward > 0.0 else "field corner"
