"""Running surfaces of a wheelset and its track: the sections meshed, and their compliance tabulated."""

import math
from collections.abc import Callable
from dataclasses import replace
from typing import TypeAlias

import numpy as np
from scipy.spatial import cKDTree

from flangeway.contact.patch.normal_contact import ElasticSurface, elastic_surface
from flangeway.geometry.arrays import chain_lengths
from flangeway.mesh import Refinement
from flangeway.problems import Elasticity, Harmonic
from flangeway.railway.profiles.bundled import RailProfile, WheelProfile
from flangeway.railway.rigid.rigid_side import RigidCurve, RigidSide
from flangeway.railway.track.placements import SIDES, Side
from flangeway.railway.track.supports import Continuous, Sleepers, Support, WheelSection, WholeWheel
from flangeway.railway.track.wheelset_problem import Role, WheelsetProblem
from flangeway.railway.wheelset.side_contact import SideSurfaces
from flangeway.railway.wheelset.supported_rail import rail_problem, sleeper_compliance, supported_rail
from flangeway.railway.wheelset.wheelset_model import SUPPORT, mesh_profile
from flangeway.railway.wheelset.whole_wheel import wheel_correction, whole_wheel
from flangeway.solve import SurfaceCells
from flangeway.space import Space
from flangeway.system.disk_cache import Cache, cached
from flangeway.types import Floats

CELL_MM = 2.0
"""Width of the cells on which the compliance is tabulated; half of it changes no pressure by more than 0.1 %."""
EDGE_MM = 0.5
"""Length of the mesh's edges there for order 1, twice that for order 2."""
BODY_MM = 6.0
"""The same inside the bodies."""
GROWTH = 0.2
"""Growth of the edges per distance for order 1, twice that for order 2."""
WALL_RAD = math.radians(95.0)
"""Steepest part of a rail that touches: a gauge face of 1:20 on a rail inclined by 1:20 is upright, and a patch on the
gauge corner reaches it."""
SAMPLED_MM, ON_CURVE_MM = 0.02, 0.01
"""Distance of points of a curve near which corners of a mesh are sought, and their distance from it."""


ElasticBodies: TypeAlias = dict[tuple[object, ...], tuple[ElasticSurface, Floats]]
"""Compliance of bodies, and corners of their meshes, by the profile and what else they depend on."""


def running_surfaces(
    problem: WheelsetProblem,
    *,
    cache: Cache | None = None,
    progress: Callable[[str], None] = lambda _: None,
    done: ElasticBodies | None = None,
) -> dict[Side, SideSurfaces]:
    """Mesh wheels and rails and tabulate their compliance; equal bodies once.

    - `done`: bodies that are ready, to which new ones are added.
    """
    done = {} if done is None else done
    surfaces: dict[Side, SideSurfaces] = {}
    alike = problem.has_alike_sides
    for side in SIDES[:1] if alike else SIDES:
        curves = RigidSide.of(problem.track, problem.wheels, side)
        rail, bodies = problem.track.rail_of(side), []
        wheel, support = problem.wheels.wheel_of(side), problem.track.support_of(side)
        for profile, radius, held, material in (
            (wheel, problem.wheels.tape_radius_of(side), problem.wheelset.section, problem.material_of("wheel")),
            (rail, 0.0, support, problem.material_of("rail")),
        ):
            key = profile, radius, material, held, problem.mesh
            if key not in done:
                done[key] = _elastic(problem, profile, radius, held, cache, progress)
            bodies.append(done[key])
        (wheel_elastic, on_wheel_mesh), (rail_elastic, on_rail_mesh) = bodies
        on_rail = RigidCurve.from_contour(rail.running_surface, curves.rail_frame, WALL_RAD)
        surfaces[side] = SideSurfaces(
            curves.wheel,
            on_rail,
            wheel_elastic,
            rail_elastic,
            _stations(curves.wheel, curves.wheel_frame.points(on_wheel_mesh)),
            _stations(on_rail, curves.rail_frame.points(on_rail_mesh)),
            curves.wheel_frame,
            curves.rail_frame,
        )
    # sides are seen from their own gauge: those of a symmetric pair are one
    return dict.fromkeys(SIDES, surfaces[SIDES[0]]) if alike else surfaces


def _elastic(
    problem: WheelsetProblem,
    profile: WheelProfile | RailProfile,
    radius_mm: float,
    held: Support | WheelSection,
    cache: Cache | None,
    progress: Callable[[str], None],
) -> tuple[ElasticSurface, Floats]:
    """Compliance of a wheel of a radius or of a rail, and corners of its mesh along the running surface, (n, 2)."""
    cells = running_cells(problem, profile, held, cache)
    surface = elastic_surface(cells, cache=cache, progress=progress)
    if isinstance(profile, WheelProfile):
        if isinstance(held, WholeWheel):
            progress("harmonics of the whole wheel")
            surface = surface.plus(wheel_correction(whole_wheel(profile, radius_mm, held), radius_mm, cells, cache))
    elif isinstance(held, Sleepers):
        material = problem.material_of("rail")

        def make() -> dict[str, Floats]:
            progress("sleepers")
            rail = supported_rail(profile, material, held, cache=cache)
            return {"added": sleeper_compliance(rail, surface.points, surface.frames)}

        content = profile.outline.segments, material, held, surface.points, surface.frames
        surface = surface.plus(cached(cache, make, "sleepers", *content)["added"])
    return surface, cells.chain


def running_cells(
    problem: WheelsetProblem, profile: WheelProfile | RailProfile, held: Support | WheelSection, cache: Cache | None
) -> SurfaceCells:
    """Even cells along the running surface of a wheel's rim or a rail on its support, spread along z."""
    role: Role = "wheel" if isinstance(profile, WheelProfile) else "rail"
    material, order, scale = problem.material_of(role), problem.order_of(role), problem.mesh.size_scale
    surface, edge_mm = profile.outline.part(profile.running_names), EDGE_MM * order * scale
    # edges are short along the running surface
    fine = Refinement(surface.sampled(spacing=EDGE_MM), edge_mm, GROWTH * order)
    mesh = mesh_profile(problem, role, profile, BODY_MM * order * scale, fine, cache)
    space = Space(mesh, problem.element_of(role))
    if isinstance(held, Sleepers | Continuous):
        body = rail_problem(space, material, SUPPORT, held)
    else:
        body = Harmonic(Elasticity(space, material, name=role), held={SUPPORT: "xyz"})
    chain = mesh.chain(*profile.running_names).astype(np.int64)
    cells = SurfaceCells(body, np.stack((chain[:-1], chain[1:]), axis=1))
    length = float(cells.limits[-1])
    return replace(cells, bounds=np.linspace(0.0, length, int(np.ceil(length / CELL_MM)) + 1))


def _stations(curve: RigidCurve, corners: Floats) -> Floats:
    """Lengths along a curve, and along the chain of its mesh's corners, at these, by rising lengths: (n, 2).

    Corners that the curve leaves out, as beyond an overhang, are left out.
    """
    arcs = np.linspace(0.0, curve.length, 1 + int(np.ceil(curve.length / SAMPLED_MM)))
    at = curve.at(arcs)
    numbers = cKDTree(np.column_stack((at.x, at.y))).query(corners)[1]
    dx, dy = corners[:, 0] - at.x[numbers], corners[:, 1] - at.y[numbers]
    nearest = arcs[numbers] + dx * np.cos(at.angle[numbers]) + dy * np.sin(at.angle[numbers])
    nearest = np.clip(nearest, 0.0, curve.length)  # a corner at an end may lie beyond it by round-off
    there = curve.at(nearest)
    on_curve = np.hypot(corners[:, 0] - there.x, corners[:, 1] - there.y) < ON_CURVE_MM
    pairs = np.stack((nearest, chain_lengths(corners)), axis=1)[on_curve]
    return pairs if pairs[-1, 0] > pairs[0, 0] else pairs[::-1]
