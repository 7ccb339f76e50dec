"""Stresses below the contact of a wheel and a rail, along the inward normal."""

from dataclasses import dataclass

import numpy as np
from numpy.polynomial import Polynomial

from flangeway.checks import check_positive
from flangeway.errors import InputError, short
from flangeway.geometry import Contour
from flangeway.geometry.arrays import nearest_on_segments
from flangeway.mesh import PolyMesh
from flangeway.post import StressLine, stresses_along
from flangeway.problems import ElasticField
from flangeway.railway.track.discretisation import Role
from flangeway.railway.wheelset.wheelset_model import WheelRailPatch
from flangeway.railway.wheelset.wheelset_result import WheelsetResult
from flangeway.types import Floats

DEPTH = 4.0  # default depth of a line over the half width of the contact

SEARCHED = 0.5
"""Part of such a line on which the maximum stress is sought: two half widths. A wide contact's line ends in the web."""

FEWEST = 8  # points within that distance below which nothing is smoothed

SMOOTHED = 0.5
"""Distance on both sides of the largest value, over its depth, within which a cubic smooths the cells' jumps."""


@dataclass(frozen=True)
class SubsurfaceExtreme:
    """Maximum stress below a contact.

    - `value_MPa`: the stress in MPa, >= 0.
    - `depth_mm`: its depth below the undeformed surface in mm.
    """

    value_MPa: float  # noqa: N815 (the unit megapascal)
    depth_mm: float


def stresses_below(
    result: WheelsetResult, patch: WheelRailPatch, body: Role, depth_mm: float | None = None, n_points: int = 201
) -> StressLine:
    """Stresses from the surface into a body, through the patch's centre of pressure.

    Returned: points and stresses in the frame of the body's profile (right-hand form on both sides), along the inward
    normal of the undeformed profile; `distances` are the depths. Not-a-number where the line has left the body. An
    `InputError` if the depth is not positive, there are fewer than two points, or the body is neither wheel nor rail.

    - `result`: the solution that the patch belongs to.
    - `body`: which of its two bodies.
    - `depth_mm`: length of the line in mm; four half widths of the contact if left out.
    - `n_points`: number of points, both ends included.
    """
    depth = DEPTH * patch.pressure.half_width if depth_mm is None else depth_mm
    check_positive("stresses_below", "depth_mm", depth, "a positive length in mm", "leave it out")
    surface, point = _place(result, patch, body)
    part = result.model.parts[f"{body}-{patch.side}"]
    (number,), parameters, _ = surface.closest(point[None])
    (inward,) = -surface.segments[number].normal(parameters)
    start = closest_on_boundary(part.body.space.mesh, point)
    end = start + depth * inward
    field = ElasticField(part.body.elasticity, result.displacements[part.name])
    return stresses_along(field, (start[0], start[1]), (end[0], end[1]), n_points)


def maximum_shear(result: WheelsetResult, patch: WheelRailPatch, body: Role) -> SubsurfaceExtreme:
    """Maximum in-plane shear stress, half the difference of the principal stresses in the plane, and its depth.

    It is the largest on the line of `stresses_below`, smoothed over the cells about it. Half planes in Hertz's line
    contact have ``0.3003 p0`` at ``0.786 a`` (Johnson, 1985, 4.2); a rail's head and a wheel's rim have more, since
    they bear the force on a small width. An `InputError` as `stresses_below`.
    """
    line = stresses_below(result, patch, body)
    return maximum_on(line.distances, line.stresses.in_plane_shear, SEARCHED)


def maximum_on(depths: Floats, values: Floats, share: float = 1.0) -> SubsurfaceExtreme:
    """Return the largest value of a line, and where; smoothed by a cubic if that has a top.

    - `depths`: rising depths in mm, shape (n,).
    - `values`: stresses in MPa, shape (n,), not-a-number outside of the body.
    - `share`: part of the line's length, from its first point, on which the largest value is sought.
    """
    values = np.where(depths <= share * (1.0 + 1e-12) * depths[-1], values, np.nan)
    place = int(np.nanargmax(values))
    depth, value = float(depths[place]), float(values[place])
    reach = SMOOTHED * depth * (1.0 + 1e-9)  # points at its very end count, whatever the last digit of their depths
    near = np.isfinite(values) & (np.abs(depths - depth) <= reach)
    if np.count_nonzero(near) >= FEWEST:
        cubic = Polynomial.fit(depths[near], values[near], 3)
        for top in (float(each.real) for each in cubic.deriv().roots() if np.isreal(each)):
            if cubic.deriv(2)(top) < 0.0 and abs(top - depth) <= reach:
                return SubsurfaceExtreme(float(cubic(top)), top)
    return SubsurfaceExtreme(value, depth)


def _place(result: WheelsetResult, patch: WheelRailPatch, body: Role) -> tuple[Contour, Floats]:
    """Running surface of the patch's body, and the centre of pressure near it."""
    problem = result.model.problem
    if body == "rail":
        return problem.track.rail_of(patch.side).running_surface, patch.rail_point_mm
    if body == "wheel":
        return problem.wheelset.wheel_of(patch.side).running_surface, patch.wheel_point_mm
    raise InputError(
        f"stresses_below(body={short(body)})", "'wheel' or 'rail'", "name one of the two bodies in contact"
    )


def closest_on_boundary(mesh: PolyMesh, point: Floats) -> Floats:
    """Closest point (2,) of the mesh's boundary to a point (2,): on chords of the profile, which this may leave."""
    starts, ends = mesh.points[mesh.boundary_edges].swapaxes(0, 1)
    (nearest,), (share,), _ = nearest_on_segments(point[None], starts, ends)
    return np.asarray(starts[nearest] + share * (ends - starts)[nearest])
