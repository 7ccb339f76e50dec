"""Where rigid wheels stand on rigid rails at each lateral shift, and where a load would take them.

Only a first guess for the elastic search and the places where it has to mesh finely: curves are heights over x, roll is
small. Along the positions in which both wheels touch, the potential of the load is followed downhill from the middle.
"""

from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray
from scipy.ndimage import minimum_filter1d

from flangeway.errors import InputError
from flangeway.geometry import Contour, Placement
from flangeway.railway.load import Load
from flangeway.railway.track import SIDES, Side, Track, Wheelset, WheelsetMotion

Floats = NDArray[np.float64]

SPACING_MM = 0.02
STEP_MM = 0.1
FARTHEST_MM = 60.0
APART_MM = 2.0
"""Least distance of two places that count as two."""


@dataclass(frozen=True, eq=False)
class _Graphs:
    """Lower edge of a wheel and upper edge of its rail as heights over grids of one spacing."""

    wheel_start: int
    wheel: Floats
    rail_start: int
    rail: Floats

    def gaps(self, shift: int) -> tuple[Floats, Floats]:
        """Places x and vertical gaps with the wheel moved by a number of spacings."""
        first = max(self.wheel_start + shift, self.rail_start)
        last = min(self.wheel_start + shift + len(self.wheel), self.rail_start + len(self.rail))
        if last - first < 3:
            return np.zeros(0), np.zeros(0)
        wheel = self.wheel[first - self.wheel_start - shift : last - self.wheel_start - shift]
        rail = self.rail[first - self.rail_start : last - self.rail_start]
        gap: Floats = wheel - rail
        places = np.arange(first, last, dtype=np.float64) * SPACING_MM
        return places, gap


@dataclass(frozen=True, eq=False)
class Standing:
    """Positions in which both rigid wheels touch.

    Parameters
    ----------
    track, wheelset
        What stands where.

    """

    track: Track
    wheelset: Wheelset

    @property
    def is_symmetric(self) -> bool:
        """Whether the left side mirrors the right one."""
        wheelset = self.wheelset
        return self.track.left_rail is None and wheelset.left_wheel is None and wheelset.left_radius_mm is None

    @cached_property
    def _graphs(self) -> dict[Side, _Graphs]:
        found = {}
        for side in SIDES:
            wheel, rail = self.wheelset.wheel_of(side), self.track.rail_of(side)
            found[side] = _Graphs(
                *_edge(self.wheelset.placement(side), wheel.outline.part(wheel.running_names), lowest=True),
                *_edge(self.track.placement(side), rail.outline.part(rail.head_names), lowest=False),
            )
        return found

    @cached_property
    def path(self) -> Floats:
        """Rows (shift at the rails' height, axle's lateral and vertical motion, roll, widest touch), shape (n, 5)."""
        rows = []
        for number in range(-round(FARTHEST_MM / STEP_MM), round(FARTHEST_MM / STEP_MM) + 1):
            shift = number * round(STEP_MM / SPACING_MM)
            lifts, places = [], []
            for side in SIDES:
                x, gap = self._graphs[side].gaps(shift)
                if len(x) and np.argmin(gap) not in (0, len(x) - 1):
                    lifts.append(-float(gap.min()))
                    places.append(float(x[np.argmin(gap)]))
            if len(lifts) == 2:
                roll = (lifts[1] - lifts[0]) / (places[1] - places[0])
                at_rails = number * STEP_MM
                lateral = at_rails - self.wheelset.tape_radius_mm * roll
                rows.append((at_rails, lateral, lifts[1] - places[1] * roll, roll, places[1] - places[0]))
        return np.array(rows).reshape(-1, 5)

    def rest(self, load: Load) -> WheelsetMotion:
        """Where the wheelset comes to rest when it starts in the middle.

        Raises
        ------
        InputError
            If the load overturns the wheelset or carries a flange over its rail.

        """
        along, onto = load.in_track
        path = self.path
        if not len(path):
            raise InputError(
                "wheels that touch their rails in no position",
                "wheels that stand over their rails",
                "check gauge_mm and back_to_back_mm",
            )
        height = self.wheelset.tape_radius_mm + self.wheelset.barycentre_height_mm
        self._refuse_overturning(along, onto, height)
        potential = onto * path[:, 2] - along * (path[:, 1] - self.wheelset.barycentre_height_mm * path[:, 3])
        place = int(np.argmin(np.abs(path[:, 0])))
        downhill = 1 if potential[min(place + 1, len(path) - 1)] < potential[max(place - 1, 0)] else -1
        if along == 0.0 and self.is_symmetric:
            downhill = 0  # the middle is in balance, though not always stable
        while downhill:
            after = place + downhill
            if not 0 <= after < len(path) or abs(path[after, 0] - path[place, 0]) > 1.5 * STEP_MM:
                self._refuse_derailment(along, onto)
            if potential[after] >= potential[place]:
                break
            place = after
        return WheelsetMotion(float(path[place, 1]), float(path[place, 2]), float(path[place, 3]))

    def at(self, lateral_mm: float) -> WheelsetMotion:
        """Return the position in which both wheels touch at a lateral motion of the axle.

        Raises
        ------
        InputError
            If there is none.

        """
        path = self.path
        if not len(path) or np.abs(path[:, 1] - lateral_mm).min() > STEP_MM:
            raise InputError(
                f"a lateral motion of {lateral_mm:g} mm",
                "one at which both wheels stand over their rails",
                "check lateral_mm, gauge_mm and back_to_back_mm",
            )
        _, lateral, vertical, roll, _ = path[np.argmin(np.abs(path[:, 1] - lateral_mm))]
        return WheelsetMotion(float(lateral), float(vertical), float(roll))

    def near_places(self, motion: WheelsetMotion, margin_mm: float) -> dict[Side, tuple[Floats, Floats]]:
        """Places on wheel and rail, in their frames, where they come within a margin of touching.

        Each wheel is lowered on its rail, at the lateral shift of the motion; two arrays (n, 2) a side.
        """
        at_rails = motion.lateral_mm + self.wheelset.tape_radius_mm * motion.roll_rad
        shift = round(at_rails / SPACING_MM)
        found: dict[Side, tuple[Floats, Floats]] = {}
        for side in SIDES:
            graphs = self._graphs[side]
            x, gap = graphs.gaps(shift)
            if not len(x):
                found[side] = np.zeros((0, 2)), np.zeros((0, 2))
                continue
            reach = round(APART_MM / SPACING_MM)
            least = gap == minimum_filter1d(gap, 2 * reach + 1)
            least &= gap - gap.min() <= margin_mm
            least[:reach] = least[-reach:] = False  # ends of a curve, where no smooth curves touch
            cells = np.rint(x[least] / SPACING_MM).astype(int)
            on_rail = np.column_stack((x[least], graphs.rail[cells - graphs.rail_start]))
            moved = x[least] - shift * SPACING_MM
            on_wheel = np.column_stack((moved, graphs.wheel[cells - shift - graphs.wheel_start]))
            found[side] = (
                self.wheelset.placement(side).inverse().points(on_wheel),
                self.track.placement(side).inverse().points(on_rail),
            )
        return found

    def _refuse_overturning(self, along: float, onto: float, height: float) -> None:
        middle = self.path[np.argmin(np.abs(self.path[:, 0]))]
        if abs(along) * height > 0.5 * middle[4] * onto:
            raise InputError(
                f"a lateral force of {along / 1e3:.4g} kN along the track's plane against {onto / 1e3:.4g} kN onto it "
                f"(L/V {along / onto:.3g}), {height:.4g} mm above the rails",
                f"L/V below {0.5 * middle[4] / height:.3g}, above which the wheelset overturns",
                "lower lateral force, speed or barycentre, raise the load or the superelevation",
            )

    def _refuse_derailment(self, along: float, onto: float) -> None:
        raise InputError(
            f"a lateral force of {along / 1e3:.4g} kN along the track's plane against {onto / 1e3:.4g} kN onto it "
            f"(L/V {along / onto:.3g})",
            "a force that a flange can hold",
            "the wheelset derails: no position of the rigid wheels holds this force; check it and the gauge",
        )


def _edge(placement: Placement, curve: Contour, *, lowest: bool) -> tuple[int, Floats]:
    """Lowest or highest height of a placed curve over each place of a grid, with the number of the first place."""
    points = placement.points(curve.sampled(spacing=SPACING_MM))
    sign = 1.0 if lowest else -1.0
    cell = np.rint(points[:, 0] / SPACING_MM).astype(int)
    start, n = int(cell.min()), int(cell.max() - cell.min()) + 1
    height = np.full(n, np.inf)
    np.minimum.at(height, cell - start, sign * points[:, 1])
    known = np.isfinite(height)
    places = np.arange(n)
    return start, sign * np.interp(places, places[known], height[known])
