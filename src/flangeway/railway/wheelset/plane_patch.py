"""Region of contact of a plane wheel and rail, and the stresses below it."""

from collections.abc import Mapping
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.polynomial import Polynomial

from flangeway.checks import check_positive
from flangeway.errors import InputError, short
from flangeway.exact import LineContact
from flangeway.geometry import Contour
from flangeway.geometry.arrays import nearest_on_segments
from flangeway.mesh import PolyMesh
from flangeway.post import PressurePatch, StressLine, stresses_along
from flangeway.problems import ElasticField
from flangeway.railway.track.placements import SIDE_SIGN, SIDES, Side
from flangeway.railway.track.wheelset_problem import ROLES, Role
from flangeway.railway.wheelset.wheelset_model import WheelsetModel, region_of
from flangeway.types import Floats


@dataclass(frozen=True)
class SubsurfaceExtreme:
    """Maximum stress below a contact.

    - `value_MPa`: the stress in MPa, >= 0.
    - `depth_mm`: its depth below the undeformed surface in mm.
    """

    value_MPa: float  # noqa: N815 (the unit megapascal)
    depth_mm: float


@dataclass(frozen=True, eq=False, kw_only=True)
class WheelRailPatch(PressurePatch):
    """One region of contact between a wheel and a rail in a plane; nodes and pressures are those of the secondary one.

    - `model`: the bodies and their contacts.
    - `displacements`: of all nodes of each part in its own frame, by name, each (n_dofs, 2).
    """

    model: WheelsetModel
    displacements: Mapping[str, Floats]

    @property
    def side(self) -> Side:
        """Of the track."""
        return SIDES[self.contact]

    @property
    def _wheel_is_secondary(self) -> bool:
        return self.model.contact(self.side).secondary.part.name.startswith("wheel")

    @property
    def force_on_wheel_N(self) -> Floats:  # noqa: N802
        """Resultant on the wheel, N, axes of the track, shape (2,)."""
        return self.force if self._wheel_is_secondary else -self.force

    @property
    def normal_force_N(self) -> float:  # noqa: N802
        """Without friction it is the whole force, N."""
        return float(np.linalg.norm(self.force))

    @property
    def centre_mm(self) -> Floats:
        """Centre of pressure in the track's axes, shape (2,)."""
        return self.centre

    @property
    def contact_angle_rad(self) -> float:
        """Angle of the tangent to which the force is normal, positive towards the flange."""
        lateral, vertical = self.force_on_wheel_N
        return float(np.arctan2(-SIDE_SIGN[self.side] * lateral, vertical))

    @property
    def region(self) -> str:
        """Part of the rail in contact: ``crown``, ``gauge corner`` or ``field corner``."""
        lateral, vertical = self.force_on_wheel_N.tolist()
        return region_of(self.side, lateral, vertical)

    @property
    def wheel_point_mm(self) -> Floats:
        """Centre of pressure on the undeformed wheel, in its frame (both sides in the right-hand form), shape (2,)."""
        return self.secondary_point if self._wheel_is_secondary else self.primary_point

    @property
    def rail_point_mm(self) -> Floats:
        """The same on the undeformed rail."""
        return self.primary_point if self._wheel_is_secondary else self.secondary_point

    @cached_property
    def hertz(self) -> LineContact | None:
        """Hertz's contact with its force and the profiles' curvatures at the centre, None where these have none."""
        force = float(self.normal_forces.sum())
        return self.model.hertz_at(self.side, self.wheel_point_mm, self.rail_point_mm, force)

    @cached_property
    def below(self) -> dict[Role, tuple[SubsurfaceExtreme, SubsurfaceExtreme]]:
        """Maximum in-plane shear and von Mises stress on the normals below the centre of pressure.

        The in-plane shear stress is half the difference of the principal stresses in the plane. Half planes in Hertz's
        line contact have ``0.3003 p0`` at ``0.786 a`` (Johnson, 1985, 4.2); a rail's head and a wheel's rim have more,
        since they carry the force on a small width.
        """
        lines = {role: stresses_below(self, role) for role in ROLES}
        return {
            role: (
                maximum_on(line.distances, line.stresses.in_plane_shear, SEARCHED_FRACTION),
                maximum_on(line.distances, line.stresses.von_mises, SEARCHED_FRACTION),
            )
            for role, line in lines.items()
        }


# --- Stresses below the contact of a wheel and a rail, along the inward normal.


DEPTH = 4.0  # default depth of a line relative to the half width of the contact

SEARCHED_FRACTION = 0.5
"""Part of such a line on which the maximum stress is sought: two half widths. A wide contact's line ends in the web."""

MIN_SMOOTHED_POINTS = 8  # points within that distance below which nothing is smoothed

SMOOTHED_DISTANCE = 0.5
"""Distance on both sides of the largest value, relative to its depth, within which a cubic smooths the cells' jumps."""


def stresses_below(patch: WheelRailPatch, body: Role, depth_mm: float | None = None, n_points: int = 201) -> StressLine:
    """Stresses from the surface into a body, through the patch's centre of pressure.

    Returned: points and stresses in the frame of the body's profile (right-hand form on both sides), along the inward
    normal of the undeformed profile; `distances` are the depths. Not-a-number where the line has left the body. An
    `InputError` if the depth is not positive, there are fewer than two points, or the body is neither wheel nor rail.

    - `body`: which of its two bodies.
    - `depth_mm`: length of the line in mm; four half widths of the contact if left out.
    - `n_points`: number of points, both ends included.
    """
    depth = DEPTH * patch.half_width if depth_mm is None else depth_mm
    check_positive("stresses_below", "depth_mm", depth, "a positive length in mm", "leave it out")
    surface, point = _place(patch, body)
    part = patch.model.parts[f"{body}-{patch.side}"]
    (number,), parameters, _ = surface.closest(point[None])
    (inward,) = -surface.segments[number].normal(parameters)
    start = closest_on_boundary(part.body.space.mesh, point)
    end = start + depth * inward
    field = ElasticField(part.body.elasticity, patch.displacements[part.name])
    return stresses_along(field, (start[0], start[1]), (end[0], end[1]), n_points)


def maximum_on(depths: Floats, values: Floats, share: float = 1.0) -> SubsurfaceExtreme:
    """Return the largest value of a line, and where; smoothed by a cubic if that has a top.

    - `depths`: rising depths in mm, shape (n,).
    - `values`: stresses in MPa, shape (n,), not-a-number outside of the body.
    - `share`: part of the line's length, from its first point, on which the largest value is sought.
    """
    values = np.where(depths <= share * (1.0 + 1e-12) * depths[-1], values, np.nan)
    row = int(np.nanargmax(values))
    depth, value = float(depths[row]), float(values[row])
    # points at its very end count, whatever the last digit of their depths
    reach = SMOOTHED_DISTANCE * depth * (1.0 + 1e-9)
    near = np.isfinite(values) & (np.abs(depths - depth) <= reach)
    if np.count_nonzero(near) >= MIN_SMOOTHED_POINTS:
        cubic = Polynomial.fit(depths[near], values[near], 3)
        for top in (float(root.real) for root in cubic.deriv().roots() if np.isreal(root)):
            if cubic.deriv(2)(top) < 0.0 and abs(top - depth) <= reach:
                return SubsurfaceExtreme(float(cubic(top)), top)
    return SubsurfaceExtreme(value, depth)


def _place(patch: WheelRailPatch, body: Role) -> tuple[Contour, Floats]:
    """Running surface of the patch's body, and the centre of pressure near it."""
    problem = patch.model.problem
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
