"""Stresses below the contact of a wheel and a rail, along the inward normal."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from flangeway.checks import check_positive
from flangeway.errors import InputError, short
from flangeway.exact import LineContact
from flangeway.geometry import Contour
from flangeway.mesh import PolyMesh
from flangeway.post import Stresses, StressLine, stresses_along
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
    (start,), (inward,) = inward_from(surface, part.body.space.mesh, point[None])
    end = start + depth * inward
    field = ElasticField(part.body.elasticity, result.displacements[part.name])
    return stresses_along(field, (start[0], start[1]), (end[0], end[1]), n_points)


def by_normal(line: StressLine) -> Stresses:
    """Stresses of a line along its own axes: xx along the surface, yy across it, in the direction of the line."""
    direction = line.points[-1] - line.points[0]
    y = direction / np.linalg.norm(direction)
    x = np.array([y[1], -y[0]])
    xx, yy, xy, zz = line.stresses.components.T
    rows = [a[0] * b[0] * xx + a[1] * b[1] * yy + (a[0] * b[1] + a[1] * b[0]) * xy for a, b in ((x, x), (y, y), (x, y))]
    return Stresses(np.stack((*rows, zz), axis=1))


def hertz_below(hertz: LineContact, depths_mm: Floats, poisson: float) -> Stresses:
    """Stresses of Hertz's line contact of half planes below its middle, in the axes of `by_normal`, plane strain.

    - `hertz`: the contact (Johnson, 1985, 4.2).
    - `depths_mm`: depths >= 0, shape (n,).
    - `poisson`: Poisson's ratio of the body.
    """
    along, across, shear = hertz.stresses(0.0, depths_mm).T
    return Stresses(np.stack((along, across, shear, poisson * (along + across)), axis=1))


def maximum_shear(result: WheelsetResult, patch: WheelRailPatch, body: Role) -> SubsurfaceExtreme:
    """Maximum in-plane shear stress, half the difference of the principal stresses in the plane, and its depth.

    It is the largest on the line of `stresses_below`, smoothed over the cells about it. Half planes in Hertz's line
    contact have ``0.3003 p0`` at ``0.786 a`` (Johnson, 1985, 4.2); a rail's head and a wheel's rim have more, since
    they bear the force on a small width. An `InputError` as `stresses_below`.
    """
    line = stresses_below(result, patch, body)
    return maximum_on(line.distances, line.stresses.in_plane_shear, SEARCHED)


def maximum_on(depths: Floats, values: Floats, share: float = 1.0) -> SubsurfaceExtreme:
    """Return the largest of values (n,) over depths (n,), and where; see `maximum_of_lines`."""
    return maximum_of_lines(depths[None], values[None], share)[0]


def maximum_of_lines(depths: Floats, values: Floats, share: float = 1.0) -> list[SubsurfaceExtreme]:
    """Return the largest value of each line, and where; smoothed by a cubic if that has a top.

    - `depths`: depths in mm, rising along each line, shape (m, n).
    - `values`: stresses in MPa, shape (m, n), not-a-number outside of the body.
    - `share`: part of each line's length, from its first point, on which the largest value is sought.
    """
    values = np.where(depths <= share * (1.0 + 1e-12) * depths[:, -1:], values, np.nan)
    places = np.nanargmax(values, axis=1)[:, None]
    depth, value = (np.take_along_axis(each, places, axis=1)[:, 0] for each in (depths, values))
    reach = SMOOTHED * depth * (1.0 + 1e-9)  # points at its very end count, whatever the last digit of their depths
    near = np.isfinite(values) & (np.abs(depths - depth[:, None]) <= reach[:, None])
    smoothed = np.flatnonzero(np.count_nonzero(near, axis=1) >= FEWEST)
    tops, heights = _tops(depths[smoothed], values[smoothed], near[smoothed])
    found = np.abs(tops - depth[smoothed]) <= reach[smoothed]  # not-a-number is not
    depth[smoothed[found]], value[smoothed[found]] = tops[found], heights[found]
    return [SubsurfaceExtreme(*pair) for pair in zip(value.tolist(), depth.tolist(), strict=True)]


def _tops(depths: Floats, values: Floats, near: NDArray[np.bool_]) -> tuple[Floats, Floats]:
    """Places and heights (m,) of the tops of the cubics closest to the values that are near; nan for none."""
    low, high = (np.where(near, depths, sign * np.inf) for sign in (1.0, -1.0))
    first, last = low.min(axis=1), high.max(axis=1)
    middle, half = (first + last) / 2.0, (last - first) / 2.0
    place = np.where(near, (depths - middle[:, None]) / half[:, None], 0.0)
    powers = np.where(near, place ** np.arange(4)[:, None, None], 0.0)
    # with places from -1 to 1 the condition of the normal equations is some hundreds
    matrix = np.einsum("amn,bmn->mab", powers, powers)
    right = np.einsum("amn,mn->ma", powers, np.where(near, values, 0.0))
    constant, slope, bend, twist = np.linalg.solve(matrix, right[..., None])[..., 0].T
    # of both places with a level tangent the one where the curvature, twice the root, is negative
    with np.errstate(invalid="ignore", divide="ignore"):
        root = np.sqrt(bend**2 - 3.0 * slope * twist)
        top = np.where(bend < 0.0, slope / (root - bend), -(bend + root) / (3.0 * twist))
        top[~(root > 0.0)] = np.nan
        return middle + half * top, constant + top * (slope + top * (bend + top * twist))


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


def inward_from(surface: Contour, mesh: PolyMesh, points: Floats) -> tuple[Floats, Floats]:
    """Where lines below points (m, 2) begin, on the boundary, and inward normals of the profile there, each (m, 2)."""
    numbers, parameters, _ = surface.closest(points)
    inward = np.empty_like(points)
    for number in np.unique(numbers):
        here = numbers == number
        inward[here] = -surface.segments[number].normal(parameters[here])
    return closest_on_boundary(mesh, points), inward


def closest_on_boundary(mesh: PolyMesh, points: Floats) -> Floats:
    """Closest points (m, 2) of the mesh's boundary: chords of the profile, which the profile itself may leave."""
    (x, y), (end_x, end_y) = np.moveaxis(mesh.points[mesh.boundary_edges], 0, -1)
    along_x, along_y = end_x - x, end_y - y
    from_x, from_y = points[:, :1] - x, points[:, 1:] - y
    share = np.clip((from_x * along_x + from_y * along_y) / (along_x**2 + along_y**2), 0.0, 1.0)
    nearest = np.argmin((from_x - share * along_x) ** 2 + (from_y - share * along_y) ** 2, axis=1)
    share = share[np.arange(len(points)), nearest]
    return np.stack((x[nearest] + share * along_x[nearest], y[nearest] + share * along_y[nearest]), axis=1)
