"""Meshes of wheels and rails, fine in the candidate zones of contact, kept from one process to the next."""

from dataclasses import dataclass
from importlib.metadata import version
from typing import Any

import numpy as np
from numpy.typing import NDArray

from flangeway.errors import InputError
from flangeway.geometry import Contour
from flangeway.geometry.arrays import chain_lengths
from flangeway.mesh import PolyMesh, Refinement, dual, triangulate
from flangeway.problems import Body
from flangeway.railway.profiles.bundled import RailProfile, WheelProfile
from flangeway.railway.track.discretisation import Role
from flangeway.railway.track.placements import Side
from flangeway.railway.track.wheelset_problem import WheelsetProblem
from flangeway.system.disk_cache import Arrays, Cache, cached
from flangeway.types import Bools, Floats
from flangeway.units import sentence

HELD = "support"
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
    settings = problem.discretisation
    profile = problem.wheelset.wheel_of(side) if role == "wheel" else problem.track.rail_of(side)
    surface, size = profile.outline.part(profile.running_names), settings.size_of(role)
    body_size = settings.body_size_mm * settings.size_scale * settings.order_of(role)
    try:
        mesh = mesh_profile(
            problem, role, profile, body_size, Refinement(zone.points(surface), size, settings.growth), cache
        )
    except InputError as error:
        raise InputError(
            sentence(
                "{}: size_scale={:g} makes contact_size_mm {:g} and body_size_mm {:g}, and no mesh comes of it ({})",
                role,
                settings.size_scale,
                size,
                body_size,
                error.given,
            ),
            error.allowed,
            "change size_scale, contact_size_mm or body_size_mm",
        ) from error
    edges = zone.edges(mesh, profile.running_names, role)
    material, thickness = problem.material_of(role), problem.thickness_mm
    return Body(role, mesh, settings.element_of(role), material, HELD, thickness=thickness), edges, surface


def mesh_profile(
    problem: WheelsetProblem,
    role: Role,
    profile: WheelProfile | RailProfile,
    size: float,
    refinement: Refinement,
    cache: Cache | None,
) -> PolyMesh:
    """Mesh a profile by triangles or the polygons dual to them, or take the mesh stored for the same input.

    What is held of it is the edge set `HELD`.
    """
    outline, polygons = profile.outline, problem.discretisation.method_of(role) == "vem"

    def make() -> Arrays:
        mesh = triangulate(outline, size=size, refinements=(refinement,))
        return _packed(dual(mesh) if polygons else mesh)

    fine = refinement.points, refinement.size, refinement.growth
    content = outline.segments, outline.names, size, *fine, polygons, version("gmsh")
    mesh = _unpacked(cached(cache, make, "mesh", *content))
    return mesh.with_edge_set(HELD, np.vstack([mesh.edge_set(name) for name in profile.held_names]))


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
