"""Regions of contact between a wheel and a rail."""

from dataclasses import dataclass

import numpy as np

from flangeway.exact import LineContact
from flangeway.post import PressurePatch
from flangeway.railway.track.placements import SIDES, Side
from flangeway.railway.wheelset.wheelset_model import WheelsetModel
from flangeway.types import Floats

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
