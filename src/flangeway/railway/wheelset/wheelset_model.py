"""From profiles to four elastic parts in contact: meshes, surfaces, penalty; and the regions of contact."""

import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import ArrayLike, NDArray

from flangeway.contact import Contact, ContactSystem, Surface
from flangeway.exact import LineContact, contact_modulus
from flangeway.geometry import Contour, Placement
from flangeway.post import PressurePatch
from flangeway.problems import LinearBody, Part
from flangeway.railway.profiles.measures import conforming, relative_curvature
from flangeway.railway.rigid.elastic_start import RigidStart, rigid_start
from flangeway.railway.track.discretisation import ROLES, Role
from flangeway.railway.track.placements import SIDES, Side, WheelsetPosition
from flangeway.railway.track.wheelset_problem import WheelsetProblem
from flangeway.railway.wheelset.wheelset_mesh import Zone, meshed_body
from flangeway.system.disk_cache import Cache
from flangeway.types import Floats

BENDING_MM = 10.0  # how far the bending of the rail may shift a contact


LEAST_CURVATURE_PER_MM = 1e-4  # relative curvature that conforming curves are given for the size of the zones


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

        None where the profiles conform; see `flangeway.railway.profiles.measures.conforming`.
        """
        wheel, rail = self.problem.wheelset.wheel_of(side), self.problem.track.rail_of(side)
        curvature = relative_curvature(wheel, wheel_point, rail, rail_point)
        if not curvature > 0.0:
            return None
        found = LineContact(force / self.problem.thickness_mm, curvature, self.hertz.modulus)
        return None if conforming(wheel, wheel_point, rail, rail_point, found.half_width) else found

    def placements(self, position: WheelsetPosition) -> tuple[Placement, ...]:
        """Placements of the system's parts at a position of the wheelset."""
        wheelset = self.problem.wheelset
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
    settings = problem.discretisation
    start = rigid_start(problem)
    hertz = LineContact(
        problem.load.vertical_N / 2.0 / problem.thickness_mm,
        max(start.relative_curvature_per_mm, LEAST_CURVATURE_PER_MM),
        contact_modulus(*(problem.material_of(role).plane_modulus for role in ROLES)),
    )
    width = 2.0 * hertz.half_width
    zones = _zones(
        problem, _with_wide(start.near_points(), start.close_points(), width), math.inf if whole else width + BENDING_MM
    )
    wheelset, track = problem.wheelset, problem.track
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
        contacts.append(Contact(second, first, settings.pairing_law(), settings.enforcement_law(hertz.modulus)))
    return WheelsetModel(problem, start, hertz, ContactSystem(contacts), parts)


def _with_wide(places: Mapping[str, Floats], close: Mapping[str, Floats], width: float) -> dict[str, Floats]:
    """Places of contact, and besides those close to it that are farther than a width from all of them."""
    found = {}
    for name, at in places.items():
        apart = np.linalg.norm(close[name][:, None] - at, axis=2).min(axis=1, initial=np.inf)
        found[name] = np.vstack((at, close[name][apart > width]))
    return found


def _zones(problem: WheelsetProblem, near: Mapping[str, Floats], reach: float) -> dict[str, Zone]:
    """Zone of each part; equal profiles of both sides share one zone."""
    places = {name: [(float(x), float(y)) for x, y in points] for name, points in near.items()}
    if problem.track.is_symmetric:
        places["rail-left"] = places["rail-right"] = places["rail-left"] + places["rail-right"]
    if problem.wheelset.left_wheel is None:
        places["wheel-left"] = places["wheel-right"] = places["wheel-left"] + places["wheel-right"]
    return {name: Zone(tuple(at), reach) for name, at in places.items()}


GAUGE_SIDE = np.tan(np.deg2rad(15.0))  # slope of the contact from which it is named after the gauge corner


@dataclass(frozen=True, eq=False)
class WheelRailPatch:
    """One region of contact between a wheel and a rail.

    - `pressure`: nodes, forces and pressures in space; forces are those on the secondary side.
    - `force_on_wheel_N`: resultant on the wheel, axes of the track, shape (2,).
    - `wheel_point_mm`, `rail_point_mm`: centre of pressure on the undeformed profiles, in their frames (both sides in
      the right-hand form).
    - `hertz`: Hertz's contact with the same force and the profiles' curvatures at the centre, None where these have
      none.
    """

    side: Side
    pressure: PressurePatch
    force_on_wheel_N: Floats  # noqa: N815 (the unit newton)
    wheel_point_mm: Floats
    rail_point_mm: Floats
    hertz: LineContact | None

    @property
    def region(self) -> str:
        """Part of the rail in contact: ``crown``, ``gauge corner`` or ``field corner``."""
        lateral, vertical = self.force_on_wheel_N
        return region_of(self.side, float(lateral), float(vertical))


def region_of(side: Side, lateral: float, vertical: float) -> str:
    """Part of the rail in contact by the force on a wheel in the track's axes; see `WheelRailPatch.region`."""
    inward = -lateral if side == "right" else lateral
    if abs(inward) < GAUGE_SIDE * vertical:
        return "crown"
    return "gauge corner" if inward > 0.0 else "field corner"


def wheel_rail_patch(model: WheelsetModel, patch: PressurePatch) -> WheelRailPatch:
    """Return a region of contact of the model's system as one of a wheel and a rail."""
    side, sign = SIDES[patch.contact], 1.0
    on_wheel, on_rail = patch.secondary_point, patch.primary_point
    if not model.contact(side).secondary.part.name.startswith("wheel"):
        on_wheel, on_rail, sign = on_rail, on_wheel, -1.0
    hertz = model.hertz_at(side, on_wheel, on_rail, float(patch.normal_forces.sum()))
    return WheelRailPatch(side, patch, sign * patch.force, on_wheel, on_rail, hertz)
