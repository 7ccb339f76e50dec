"""Stresses below the contact of a wheel and a rail, along the inward normal."""

from dataclasses import dataclass

import numpy as np
from numpy.polynomial import Polynomial
from numpy.typing import NDArray

from flangeway.errors import InputError
from flangeway.exact import LineContact
from flangeway.geometry import Contour
from flangeway.mesh import PolyMesh
from flangeway.post import Stresses, StressLine, stresses_along
from flangeway.problems import ElasticField
from flangeway.railway.discretisation import Role
from flangeway.railway.result import WheelRailPatch, WheelsetResult

Floats = NDArray[np.float64]

DEPTH = 4.0
"""Default depth of a line over the half width of the contact."""

FEWEST = 8
"""Points within that distance below which nothing is smoothed."""

SMOOTHED = 0.5
"""Distance on both sides of the largest value, over its depth, within which a cubic smooths the cells' jumps."""


@dataclass(frozen=True)
class SubsurfaceExtreme:
    """Largest stress below a contact.

    Parameters
    ----------
    value_MPa
        The stress in MPa, >= 0.
    depth_mm
        Its depth below the undeformed surface in mm.

    """

    value_MPa: float  # noqa: N815 (the unit megapascal)
    depth_mm: float


def stresses_below(
    result: WheelsetResult, patch: WheelRailPatch, body: Role, depth_mm: float | None = None, n_points: int = 201
) -> StressLine:
    """Stresses from the surface into a body, through the patch's centre of pressure.

    Parameters
    ----------
    result
        The solution that the patch belongs to.
    patch
        Region of contact.
    body
        Which of its two bodies.
    depth_mm
        Length of the line in mm; four half widths of the contact if left out.
    n_points
        Number of points, both ends included.

    Returns
    -------
    StressLine
        Points and stresses in the frame of the body's profile (right-hand form on both sides), along the inward normal
        of the undeformed profile; `distances` are the depths. Not-a-number where the line has left the body.

    Raises
    ------
    InputError
        If the depth is not positive, there are fewer than two points, or the body is neither wheel nor rail.

    """
    depth = DEPTH * patch.pressure.half_width if depth_mm is None else depth_mm
    if not (np.isfinite(depth) and depth > 0.0):
        raise InputError(f"stresses_below(depth_mm={depth_mm})", "a positive length in mm", "leave it out")
    surface, point = _place(result, patch, body)
    number, parameter, _ = surface.closest([point])
    inward = -surface.segments[int(number[0])].normal(parameter)[0]
    part = result.model.parts[f"{body}-{patch.side}"]
    start = closest_on_boundary(part.body.mesh, point)
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

    Parameters
    ----------
    hertz
        The contact (Johnson, 1985, 4.2).
    depths_mm
        Depths >= 0, shape (n,).
    poisson
        Poisson's ratio of the body.

    """
    along, across, shear = hertz.stresses(0.0, depths_mm).T
    return Stresses(np.stack((along, across, shear, poisson * (along + across)), axis=1))


def largest_shear(result: WheelsetResult, patch: WheelRailPatch, body: Role) -> SubsurfaceExtreme:
    """Largest in-plane shear stress, half the difference of the principal stresses in the plane, and its depth.

    It is the largest on the line of `stresses_below`, smoothed over the cells about it. Half planes in Hertz's line
    contact have ``0.3003 p0`` at ``0.786 a`` (Johnson, 1985, 4.2); a rail's head and a wheel's rim have more, since
    they bear the force on a small width.

    Raises
    ------
    InputError
        As `stresses_below`.

    """
    line = stresses_below(result, patch, body)
    return largest_on(line.distances, line.stresses.in_plane_shear)


def largest_on(depths: Floats, values: Floats) -> SubsurfaceExtreme:
    """Return the largest of values (n,) over depths (n,), and where; smoothed by a cubic if that has a top.

    Parameters
    ----------
    depths
        Rising depths in mm, shape (n,).
    values
        Stresses in MPa, shape (n,), not-a-number outside of the body.

    """
    place = int(np.nanargmax(values))
    depth, value = float(depths[place]), float(values[place])
    near = np.isfinite(values) & (np.abs(depths - depth) <= SMOOTHED * depth)
    if np.count_nonzero(near) < FEWEST:
        return SubsurfaceExtreme(value, depth)
    cubic = Polynomial.fit(depths[near], values[near], 3)
    roots = cubic.deriv().roots()
    tops: Floats = roots[np.isreal(roots)].real.astype(np.float64)
    tops = tops[(np.abs(tops - depth) <= SMOOTHED * depth) & (cubic.deriv(2)(tops) < 0.0)]
    if len(tops) == 0:
        return SubsurfaceExtreme(value, depth)
    return SubsurfaceExtreme(float(cubic(tops[0])), float(tops[0]))


def _place(result: WheelsetResult, patch: WheelRailPatch, body: Role) -> tuple[Contour, Floats]:
    """Running surface of the patch's body, and the centre of pressure near it."""
    problem = result.model.problem
    if body == "rail":
        return problem.track.rail_of(patch.side).running_surface, patch.rail_point_mm
    if body == "wheel":
        return problem.wheelset.wheel_of(patch.side).running_surface, patch.wheel_point_mm
    raise InputError(f"stresses_below(body={body!r})", "'wheel' or 'rail'", "name one of the two bodies in contact")


def closest_on_boundary(mesh: PolyMesh, point: Floats) -> Floats:
    """Closest point of the mesh's boundary: chords of the profile, which the profile itself may leave."""
    first, second = mesh.points[mesh.boundary_edges].swapaxes(0, 1)
    along = second - first
    share = np.einsum("ni,ni->n", point - first, along) / np.einsum("ni,ni->n", along, along)
    feet = first + np.clip(share, 0.0, 1.0)[:, None] * along
    nearest: Floats = feet[np.argmin(np.linalg.norm(feet - point, axis=1))]
    return nearest
