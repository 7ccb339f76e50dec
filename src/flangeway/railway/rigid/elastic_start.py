"""Where the rigid wheelset rests: first guess of the elastic search, and the places where it has to mesh finely."""

import math
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from flangeway.errors import InputError
from flangeway.geometry import Placement
from flangeway.railway.rigid.rigid_contact import RigidWheelset, Settled, contact_locus, locus_of, settle
from flangeway.railway.rigid.rigid_equilibrium import RigidEquilibrium, rigid_equilibrium
from flangeway.railway.rigid.rigid_locus import ContactLocus
from flangeway.railway.track.placements import SIDES, Side, WheelsetMotion
from flangeway.railway.track.wheelset_load import Load
from flangeway.railway.track.wheelset_problem import WheelsetProblem
from flangeway.types import Floats

END_MM = 2.0
"""Places nearer to the end of a running surface are where it ends, not where smooth curves come close."""

APART_MM = 0.1
"""Lateral distance below which two positions count as one."""

CLIMBING_RAD = math.radians(45.0)
"""Contact angle above which a rigid flange counts as climbing; elastic rails give way there, and no flange rises."""

CLIMBED_MM = 3.0
"""Rise of the axle from the middle of the track above which a flange has climbed."""

SCAN_MM = 0.1
"""Distance of the positions in which the flange is looked at, on the way to a prescribed lateral motion."""


@dataclass(frozen=True, eq=False)
class RigidStart:
    """A rigid wheelset at rest under its load, or at the lateral motion that is prescribed.

    Beyond the lateral motion at which a rigid flange begins to climb it stands where it does not climb yet: rigid
    rails would lift it by some millimetres, elastic ones let it go on.

    Parameters
    ----------
    wheelset
        Rigid curves.
    starts
        Motions of the axle's middle in which the load is in balance, or might be for elastic wheels: the one that is
        reached first, then the others, and the middle of the track. At a prescribed lateral motion: where the flange
        does not climb yet, then, if that is elsewhere, at the lateral motion itself.
    load
        The load; None at a prescribed lateral motion.
    known
        All balances of the load, if they were found already.

    """

    wheelset: RigidWheelset
    starts: tuple[WheelsetMotion, ...]
    load: Load | None
    known: RigidEquilibrium | None = None

    @cached_property
    def equilibrium(self) -> RigidEquilibrium | None:
        """All balances of the load; None at a prescribed lateral motion."""
        if self.load is None:
            return None
        return self.known or rigid_equilibrium(self.wheelset, self.load)

    @property
    def motion(self) -> WheelsetMotion:
        """Motion of the axle's middle."""
        return self.starts[0]

    @property
    def relative_curvature_per_mm(self) -> float:
        """Sum of the curvatures of wheel and rail where they touch, on the side where it is smaller."""
        settled = self._settled(0.0)
        return float(min(each.relative_curvature[0, 0] for each in (settled.left, settled.right)))

    def near_places(self, asides_mm: tuple[float, ...], margin_mm: float) -> dict[Side, tuple[Floats, Floats]]:
        """Places on wheel and rail, in their frames, that touch or are within a margin of it; two arrays (n, 2) a side.

        Parameters
        ----------
        asides_mm
            Lateral motions beside the rest, at the height of the rails, that are looked at; what lies beyond a rail
            adds nothing.
        margin_mm
            Largest vertical gap.

        """
        found: dict[Side, list[tuple[Floats, Floats]]] = {side: [] for side in SIDES}
        for lateral_offset in asides_mm:
            try:
                settled = self._settled(lateral_offset)
            except InputError:
                if lateral_offset == 0.0:
                    raise
                continue
            locus = locus_of(self.wheelset, settled)
            for side in SIDES:
                touches = settled.left if side == "left" else settled.right
                at = locus.side(side)
                near = (at.gaps_mm[0] <= margin_mm) & self._inside(side, touches.wheel_arc[0], touches.x[0])
                near[0] = True
                found[side].append((at.wheel_points_mm[0, near], at.rail_points_mm[0, near]))
        return {
            side: (np.concatenate([pair[0] for pair in pairs]), np.concatenate([pair[1] for pair in pairs]))
            for side, pairs in found.items()
        }

    def close_places(self, gap_mm: float) -> dict[Side, tuple[Floats, Floats]]:
        """Places on wheel and rail, in their frames, at rest, with a gap below a limit; two arrays (n, 2) a side.

        Parameters
        ----------
        gap_mm
            Largest vertical gap: of wide places that conform all points are in it, not only the one that touches.

        """
        settled = self._settled(0.0)
        lateral = float(settled.rail_level[0] - self.wheelset.reference_height_mm * math.sin(settled.roll[0]))
        found: dict[Side, tuple[Floats, Floats]] = {}
        for side, sign in zip(SIDES, (-1.0, 1.0), strict=True):
            curves, roll = self.wheelset.side(side), sign * float(settled.roll[0])
            arcs = curves.close_arcs(sign * lateral, roll, float(settled.lift[0]), gap_mm)
            on_wheel = np.column_stack(curves.wheel.at(arcs)[:2])
            moved = Placement(roll, (sign * lateral, float(settled.lift[0]))).points(on_wheel)
            on_rail = np.column_stack(curves.rail.over(moved[:, 0])[:2])
            found[side] = curves.wheel_frame.inverse().points(on_wheel), curves.rail_frame.inverse().points(on_rail)
        return found

    def _settled(self, lateral_offset_mm: float) -> Settled:
        height = self.wheelset.reference_height_mm
        level = self.motion.lateral_mm + height * math.sin(self.motion.roll_rad) + lateral_offset_mm
        return settle(self.wheelset, np.array([level]), gaps=True)

    def _inside(self, side: Side, wheel_arc: Floats, rail_x: Floats) -> NDArray[np.bool_]:
        curves = self.wheelset.side(side)
        first, last = curves.rail.joints[[0, -1]]
        on_wheel = (wheel_arc > END_MM) & (wheel_arc < curves.wheel.length - END_MM)
        inside: NDArray[np.bool_] = on_wheel & (rail_x > first + END_MM) & (rail_x < last - END_MM)
        return inside


def rigid_start(problem: WheelsetProblem) -> RigidStart:
    """Find where a rigid wheelset comes to rest when it starts in the middle of the track.

    Raises
    ------
    InputError
        If the wheels do not stand on the rails, the load overturns the wheelset or carries a flange over its rail, or
        a prescribed lateral motion cannot be reached.

    """
    wheelset = RigidWheelset.of(problem.track, problem.wheelset)
    lateral = problem.prescribed.lateral_mm
    if lateral is not None:
        return RigidStart(wheelset, _held_starts(wheelset, lateral), None)
    equilibrium = rigid_equilibrium(wheelset, problem.load)
    # the path of contact, which the balance has followed, need not be followed again for its middle
    middle = locus_of(wheelset, settle(wheelset, np.array([0.0]), at_axle=True)).motion(0)
    found = [*(position.motion for position in equilibrium.positions), middle]
    if problem.track.is_symmetric and problem.wheelset.is_symmetric and problem.load.in_track[0] == 0.0:
        # the middle is in balance, though it need not be stable
        found.insert(0, middle)
    else:
        found.insert(0, equilibrium.reached().motion)
    starts: list[WheelsetMotion] = []
    for motion in found:
        if all(abs(motion.lateral_mm - other.lateral_mm) > APART_MM for other in starts):
            starts.append(motion)
    return RigidStart(wheelset, tuple(starts), problem.load, equilibrium)


def _held_starts(wheelset: RigidWheelset, lateral: float) -> tuple[WheelsetMotion, ...]:
    """Where rigid wheels stand at a prescribed lateral motion; before it where the flange does not climb yet."""
    ends = contact_locus(wheelset, [lateral, 0.0])
    at_it = ends.motion(0)
    if _steepest(ends)[0] <= CLIMBING_RAD and at_it.vertical_mm - ends.vertical_mm[1] <= CLIMBED_MM:
        return (at_it,)
    n_steps = max(math.ceil(abs(lateral) / SCAN_MM), 1)
    try:
        way = contact_locus(wheelset, lateral * np.arange(n_steps) / n_steps)
    except InputError:
        return (at_it,)
    climbing = np.flatnonzero(_steepest(way) > CLIMBING_RAD)
    last = int(climbing[0]) - 1 if len(climbing) else n_steps - 1
    return (at_it,) if last < 0 else (way.motion(last), at_it)


def _steepest(locus: ContactLocus) -> Floats:
    """Contact angle of the steeper side, shape (n,)."""
    found: Floats = np.maximum(*(locus.side(side).contact_angles_rad[:, 0] for side in SIDES))
    return found
