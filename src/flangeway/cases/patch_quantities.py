"""What cases of contact patches share: friction as an input, and the numbers of patches that stand or roll."""

import math
from collections.abc import Callable
from dataclasses import dataclass
from functools import partial
from typing import Any, Protocol

import numpy as np

from flangeway.contact.patch.patch_contact import ContactEllipse
from flangeway.contact.rolling.fast_theories import TITLES, SimplifiedRolling
from flangeway.contact.rolling.rolling_contact import NO_CONTACT, SLIPS, Creepages, CreepForces, Rolling
from flangeway.exact import PointContact
from flangeway.quantities import Quantity
from flangeway.types import Floats

# --- Numbers of contact patches in three dimensions: of wheels on rails, and of any two bodies.


SEMI_AXES = ("a", "b")
ON_SURFACE = ("across", "along")


class EllipticPatch(Protocol):
    """A patch with its equivalent ellipse."""

    @property
    def ellipse(self) -> ContactEllipse:
        """Resultant, and the ellipse with the same second moments of pressure as Hertz's."""

    @property
    def hertz(self) -> PointContact | None:
        """Hertz's contact for the same force and curvatures; None where these vary too much within the patch."""

    @property
    def remark(self) -> str | None:
        """What limits the maximum pressure, None if nothing does."""


MAX_PRESSURE: Quantity[EllipticPatch] = Quantity(
    "max_pressure",
    "maximum pressure",
    lambda patch: patch.ellipse.max_pressure,
    "MPa",
    ".1f",
    remark=lambda p: p.remark,
)
HERTZ_PRESSURE: Quantity[EllipticPatch] = Quantity(
    "hertz_pressure",
    "  Hertz",
    lambda p: p.hertz and p.hertz.max_pressure,
    "MPa",
    ".1f",
    meaning="maximum pressure of half-spaces with the same force and curvatures; none where these vary too much",
)
AXES: Quantity[EllipticPatch] = Quantity(
    "semi_axes",
    "semi-axis",
    lambda patch: patch.ellipse.semi_axes,
    "mm",
    ".3f",
    SEMI_AXES,
    "a is the longer one, of the ellipse with the same second moments of pressure as Hertz's",
)
HERTZ_AXES: Quantity[EllipticPatch] = Quantity(
    "hertz_semi_axes",
    "  Hertz",
    lambda p: p.hertz and p.hertz.semi_axes,
    "mm",
    ".3f",
    SEMI_AXES,
    "as Hertz's pressure",
)
ANGLE: Quantity[EllipticPatch] = Quantity(
    "angle",
    "orientation of the major axis",
    lambda p: math.degrees(p.ellipse.angle_rad),
    "deg",
    "z.1f",
    meaning="from z to the major axis",
)
AREA: Quantity[EllipticPatch] = Quantity("area", "area", lambda patch: patch.ellipse.area, "mm²", ".2f")
CELLS: Quantity[EllipticPatch] = Quantity("cells", "cells", lambda patch: patch.ellipse.cells, "", "d", ON_SURFACE)


# --- Numbers of patches that roll with friction: by one theory, on one body, ahead and to the right.


@dataclass(frozen=True, eq=False)
class CreepResult:
    """Creep forces of a patch on its second body.

    Parameters
    ----------
    forces
        Creep forces in the patch's axes.
    creepages
        Creepages at the patch's origin, one number each.
    normal_force
        In N.
    sign
        1 where t of the patch is to the right, -1 where it is to the left.
    scale
        Speed in m/s over the speed of the forces' motion.

    """

    forces: CreepForces
    creepages: Creepages
    normal_force: float
    sign: float = 1.0
    scale: float = 1.0

    @property
    def rolls(self) -> bool:
        """Whether the bodies roll; otherwise the second one is shifted, and creepages are shifts."""
        return self.forces.motion.rolls

    @property
    def theory(self) -> str:
        """The theory's name."""
        return TITLES["exact"] if isinstance(self.forces, Rolling) else self.forces.theory

    @property
    def moment(self) -> float:
        """Spin moment about the normal, N m, counter-clockwise from above."""
        return 1e-3 * self.sign * self.forces.moment

    @property
    def products(self) -> tuple[float, float]:
        """Creep forces times creepages, and spin moment times spin, N."""
        return self.forces.products(self.creepages)

    @property
    def cells(self) -> Rolling | SimplifiedRolling | None:
        """Tractions, slip and states, which only some theories have."""
        return self.forces if isinstance(self.forces, Rolling | SimplifiedRolling) else None

    @property
    def slip_fraction(self) -> float | None:
        """Cells that slip over those in contact."""
        cells = self.cells
        return None if cells is None else float((cells.states[cells.states != NO_CONTACT] == SLIPS).mean())

    def maximum(self, values: Callable[[Rolling | SimplifiedRolling], Floats]) -> float | None:
        """Maximum magnitude over the cells; None of theories without tractions."""
        cells = self.cells
        return None if cells is None else float(np.linalg.norm(np.atleast_3d(values(cells)), axis=2).max())

    @property
    def max_slip(self) -> float | None:
        """Maximum slip velocity, m/s, of a shift the slip, mm."""
        slip = self.maximum(lambda cells: cells.slip_velocities)
        return None if slip is None else self.scale * slip

    @property
    def flash_temperature(self) -> float | None:
        """Maximum temperature of the cells above that without friction, K; None without temperatures."""
        cells = self.cells
        if cells is None or cells.flash_temperatures is None:
            return None
        return float(cells.flash_temperatures[cells.states != NO_CONTACT].max())

    @property
    def power_density(self) -> float | None:
        """Maximum power over area, W/mm²; None for a shift."""
        power = self.maximum(lambda cells: cells.power_density.clip(min=0.0))
        return self.scale * power if self.rolls and power is not None else None


Creep = Quantity[CreepResult]


def _if_rolling(rolls: bool, value: Callable[[CreepResult], Any]) -> Callable[[CreepResult], Any]:
    """A number that only rolling has, or only a shift."""
    return lambda creep: value(creep) if creep.rolls == rolls else None


_rolling, _shifting = partial(_if_rolling, True), partial(_if_rolling, False)


THEORY: Creep = Quantity("theory", "theory", lambda creep: creep.theory)
LONGITUDINAL_CREEPAGE: Creep = Quantity(
    "longitudinal_creepage", "longitudinal creepage", _rolling(lambda creep: creep.creepages.along), form="z.4%"
)
LATERAL_CREEPAGE: Creep = Quantity(
    "lateral_creepage", "lateral creepage", _rolling(lambda f: f.sign * f.creepages.across), form="z.4%"
)
SPIN_CREEPAGE: Creep = Quantity(
    "spin_creepage", "spin creepage", _rolling(lambda f: 1e3 * f.sign * f.creepages.spin), "1/m", "z.4f"
)
CREEPAGES = (LONGITUDINAL_CREEPAGE, LATERAL_CREEPAGE, SPIN_CREEPAGE)
LONGITUDINAL_FORCE: Creep = Quantity(
    "longitudinal_force", "longitudinal force", lambda creep: creep.forces.along, "kN", "z.4f", factor=1e-3
)
LATERAL_FORCE: Creep = Quantity(
    "lateral_force", "lateral force", lambda f: f.sign * f.forces.across, "kN", "z.4f", factor=1e-3
)
SPIN_MOMENT: Creep = Quantity("spin_moment", "spin moment", lambda creep: creep.moment, "Nm", "z.3f")
FORCES = (LONGITUDINAL_FORCE, LATERAL_FORCE, SPIN_MOMENT)
TRACTION: Creep = Quantity(
    "traction_coefficient",
    "traction coefficient",
    lambda f: float(np.hypot(f.forces.along, f.forces.across)) / f.normal_force,
    form=".4f",
    meaning="ratio of creep force to normal force",
)
T_GAMMA: Creep = Quantity(
    "t_gamma",
    "T-gamma",
    _rolling(lambda f: f.forces.t_gamma),
    "N",
    "z.3f",
    meaning="frictional power divided by the speed",
)
T_GAMMAS: tuple[Creep, ...] = (
    T_GAMMA,
    Quantity("t_gamma_without_spin", "  forces times creepages", _rolling(lambda f: f.products[0]), "N", "z.3f"),
    Quantity("t_gamma_with_spin", "  and spin moment times spin", _rolling(lambda f: sum(f.products)), "N", "z.3f"),
)
SLIP_AREA: Creep = Quantity("slipping_share", "slip area", lambda creep: creep.slip_fraction, form=".1%")
MAX_TRACTION: Creep = Quantity(
    "max_traction", "maximum traction", lambda f: f.maximum(lambda c: c.tractions), "MPa", ".1f"
)
FIELDS: tuple[Creep, ...] = (
    SLIP_AREA,
    MAX_TRACTION,
    Quantity("max_slip_velocity", "maximum slip velocity", _rolling(lambda creep: creep.max_slip), "m/s", ".4f"),
    Quantity(
        "flash_temperature",
        "maximum flash temperature",
        lambda creep: creep.flash_temperature,
        "K",
        ".1f",
        meaning="temperature of the surfaces in contact above that without friction",
    ),
    Quantity(
        "max_power_density", "maximum frictional power density", lambda creep: creep.power_density, "W/mm²", "z.2f"
    ),
)
"""What theories with tractions have."""
BY_THEORY: tuple[Creep, ...] = (THEORY, *CREEPAGES, *FORCES, *T_GAMMAS)
SHIFT: tuple[Creep, ...] = (
    Quantity("shift_ahead", "shift ahead", _shifting(lambda creep: creep.creepages.along), "mm", "z.6f"),
    Quantity("shift_right", "shift to the right", _shifting(lambda f: f.sign * f.creepages.across), "mm", "z.6f"),
    Quantity("shift_rotation", "rotation", _shifting(lambda f: 1e3 * f.sign * f.creepages.spin), "mrad", "z.4f"),
    Quantity("max_slip", "maximum slip", _shifting(lambda creep: creep.max_slip), "mm", ".6f"),
    Quantity("dissipated", "work of friction", _shifting(lambda creep: creep.forces.frictional_power), "N mm", ".4g"),
)
POWER: Creep = Quantity(
    "frictional_power", "frictional power", _rolling(lambda f: f.scale * f.forces.frictional_power), "W", "z.1f"
)
