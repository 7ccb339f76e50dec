"""Rigid equilibrium as the start of the elastic search, and the points where the elastic bodies need a fine mesh."""

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from flangeway.errors import InputError
from flangeway.geometry import Placement
from flangeway.railway.rigid.rigid_equilibrium import RigidEquilibrium, rigid_equilibrium
from flangeway.railway.rigid.rigid_geometry import RigidGeometry, TouchingPositions
from flangeway.railway.rigid.rigid_locus import ContactLocus
from flangeway.railway.track.placements import SIDE_SIGN, SIDES, Side, WheelsetPosition
from flangeway.railway.track.wheelset_problem import WheelsetProblem
from flangeway.types import Floats

FLANGE_MM = 1.0  # how much farther than a rigid one an elastic wheelset may go sideways
CLOSE_MM = 0.2  # gap in the rigid equilibrium that elastic bodies close

MARGIN_MM = 8.0
"""Gap in the rigid equilibrium within which a second point may come into contact: flanges may push the rails apart."""

END_MM = 2.0  # points nearer to the end of a running surface are where it ends, not where smooth curves come close

CLIMBING_RAD = math.radians(45.0)
"""Contact angle above which a rigid flange climbs; elastic rails deflect there, and no flange rises."""

CLIMBED_MM = 3.0  # rise of the axle from the middle of the track above which a flange has climbed

SCAN_MM = 0.1
"""Distance of the positions in which the contact angle is checked, up to a prescribed lateral displacement."""

Points = dict[str, Floats]
"""Points (n, 2) in the frame of the profile, by the part's name such as ``wheel-left``."""


@dataclass(frozen=True, eq=False)
class RigidStart:
    """A rigid wheelset in equilibrium under its load, or at the lateral displacement that is prescribed.

    Beyond the lateral displacement at which a rigid flange begins to climb it is where the flange does not climb yet:
    rigid rails would lift it by some millimetres, elastic ones deflect.

    - `geometry`: rigid geometry of the wheelset on its track.
    - `motion`: displacement of the axle's middle in the equilibrium that is reached, or at a prescribed lateral
      displacement, or before it where the flange does not climb yet.
    - `equilibrium`: all equilibria under the load; None at a prescribed lateral displacement.
    """

    geometry: RigidGeometry
    motion: WheelsetPosition
    equilibrium: RigidEquilibrium | None

    @property
    def relative_curvature_per_mm(self) -> float:
        """Sum of the curvatures of wheel and rail where they touch, on the side where it is smaller."""
        curvature = self._beside(0.0)
        return float(min(side.relative_curvature[0, 0] for side in (curvature.left, curvature.right)))

    def near_points(self, margin_mm: float = MARGIN_MM, further_mm: float = FLANGE_MM) -> Points:
        """Points with a gap up to a margin, at the start and up to a distance further sideways."""
        lateral = self.motion.lateral_mm
        further = math.copysign(further_mm, lateral) if abs(lateral) > FLANGE_MM else 0.0
        near_by_kind: dict[str, list[Floats]] = {}
        for offset in (0.0, 0.5 * further, further) if further else (0.0,):
            try:
                positions = self._beside(offset)
            except InputError:
                if offset == 0.0:
                    raise
                continue  # what lies beyond a rail adds nothing
            locus = self.geometry.located(positions)
            for side in SIDES:
                touches, at = positions.side(side), locus.side(side)
                near = (at.gaps_mm[0] <= margin_mm) & self._inside(side, touches.wheel_arc[0], touches.x[0])
                near[0] = True
                near_by_kind.setdefault(f"wheel-{side}", []).append(at.wheel_points_mm[0, near])
                near_by_kind.setdefault(f"rail-{side}", []).append(at.rail_points_mm[0, near])
        return {name: np.concatenate(points) for name, points in near_by_kind.items()}

    def close_points(self) -> Points:
        """All points at the start with a gap below `CLOSE_MM`.

        Where worn profiles conform they reach farther than the curvatures at the touch show.
        """
        start = self._beside(0.0)
        lateral, lift = float(self.geometry.axle_lateral(start)[0]), float(start.lift[0])
        points: Points = {}
        for side, sign in SIDE_SIGN.items():
            curves, roll = self.geometry.side(side), sign * float(start.roll[0])
            arcs = curves.close_arcs(sign * lateral, roll, lift, CLOSE_MM)
            on_wheel = np.column_stack(curves.wheel.at(arcs)[:2])
            moved = Placement(roll, (sign * lateral, lift)).points(on_wheel)
            on_rail = np.column_stack(curves.rail.over(moved[:, 0])[:2])
            points[f"wheel-{side}"] = curves.wheel_frame.inverse().points(on_wheel)
            points[f"rail-{side}"] = curves.rail_frame.inverse().points(on_rail)
        return points

    def _beside(self, offset_mm: float) -> TouchingPositions:
        """The position beside the start by a lateral offset at the height of the rails."""
        level = self.motion.lateral_mm + self.geometry.reference_height_mm * math.sin(self.motion.roll_rad) + offset_mm
        return self.geometry.touching(np.array([level]), gaps=True)

    def _inside(self, side: Side, wheel_arc: Floats, rail_x: Floats) -> NDArray[np.bool_]:
        curves = self.geometry.side(side)
        first, last = curves.rail.joints[[0, -1]]
        on_wheel = (wheel_arc > END_MM) & (wheel_arc < curves.wheel.length - END_MM)
        inside: NDArray[np.bool_] = on_wheel & (rail_x > first + END_MM) & (rail_x < last - END_MM)
        return inside


def rigid_start(problem: WheelsetProblem, geometry: RigidGeometry | None = None) -> RigidStart:
    """Find the equilibrium that a rigid wheelset reaches from the middle of the track, or its prescribed position.

    An `InputError` if the wheels do not fit the rails, or the load overturns the wheelset or carries a flange over its
    rail.

    - `problem`: wheelset, track, load and prescribed displacements.
    - `geometry`: rigid geometry of this wheelset on this track, if it is there already.
    """
    geometry = geometry or RigidGeometry.of(problem.track, problem.wheelset)
    lateral = problem.prescribed.lateral_mm
    if lateral is not None:
        return RigidStart(geometry, _prescribed_start(geometry, lateral), None)
    equilibrium = rigid_equilibrium(geometry, problem.load)
    if problem.track.is_symmetric and problem.wheelset.is_symmetric and problem.load.in_track[0] == 0.0:
        # the middle is in equilibrium, though it need not be stable
        middle = geometry.located(geometry.touching(np.array([0.0]), at_axle=True)).motion(0)
        return RigidStart(geometry, middle, equilibrium)
    return RigidStart(geometry, equilibrium.reached().motion, equilibrium)


def _prescribed_start(geometry: RigidGeometry, lateral: float) -> WheelsetPosition:
    """The position at a prescribed lateral displacement; before it, the last one in which the flange does not climb."""
    low, high = geometry.limits(abs(lateral))
    inside = low <= lateral <= high
    reached = lateral if inside else SCAN_MM * math.trunc(min(max(lateral, low), high) / SCAN_MM)
    ends = geometry.locus([reached, 0.0])
    at_it = ends.motion(0)
    if _steepest(ends)[0] <= CLIMBING_RAD and at_it.vertical_mm - ends.vertical_mm[1] <= CLIMBED_MM:
        return at_it
    n_steps = max(math.ceil(abs(reached) / SCAN_MM), 1)
    scan = geometry.locus(reached * np.arange(n_steps) / n_steps)
    climbing = np.flatnonzero(_steepest(scan) > CLIMBING_RAD)
    last = int(climbing[0]) - 1 if len(climbing) else n_steps - 1
    return at_it if last < 0 else scan.motion(last)


def _steepest(locus: ContactLocus) -> Floats:
    """Contact angle of the steeper side, shape (n,)."""
    angles: Floats = np.maximum(*(locus.side(side).contact_angles_rad[:, 0] for side in SIDES))
    return angles
