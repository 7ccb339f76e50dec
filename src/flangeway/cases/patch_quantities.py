"""What cases of contact patches share: friction as an input, and the numbers of patches that stand or roll."""

import math
from collections.abc import Callable
from functools import partial
from typing import Any

from flangeway.contact.patch.patch_contact import SpatialPatch
from flangeway.contact.rolling.creep_state import CreepState
from flangeway.quantities import Quantity

# --- Numbers of contact patches in three dimensions: of wheels on rails, and of any two bodies.


SEMI_AXES = ("a", "b")
ON_SURFACE = ("across", "along")


MAX_PRESSURE: Quantity[SpatialPatch] = Quantity(
    "max_pressure",
    "maximum pressure",
    lambda patch: patch.max_pressure,
    "MPa",
    ".1f",
    remark=lambda p: p.remark,
)
HERTZ_PRESSURE: Quantity[SpatialPatch] = Quantity(
    "hertz_pressure",
    "  Hertz",
    lambda p: p.hertz and p.hertz.max_pressure,
    "MPa",
    ".1f",
    meaning="maximum pressure of half-spaces with the same force and curvatures; none where these vary too much",
)
AXES: Quantity[SpatialPatch] = Quantity(
    "semi_axes",
    "semi-axis",
    lambda patch: patch.semi_axes,
    "mm",
    ".3f",
    SEMI_AXES,
    "a is the longer one, of the ellipse with the same second moments of pressure as Hertz's",
)
HERTZ_AXES: Quantity[SpatialPatch] = Quantity(
    "hertz_semi_axes",
    "  Hertz",
    lambda p: p.hertz and p.hertz.semi_axes,
    "mm",
    ".3f",
    SEMI_AXES,
    "as Hertz's pressure",
)
ANGLE: Quantity[SpatialPatch] = Quantity(
    "angle",
    "orientation of the major axis",
    lambda p: math.degrees(p.angle_rad),
    "deg",
    ".1f",
    meaning="from z to the major axis",
)
AREA: Quantity[SpatialPatch] = Quantity("area", "area", lambda patch: patch.area, "mm²", ".2f")
CELLS: Quantity[SpatialPatch] = Quantity("cells", "cells", lambda patch: patch.n_cells, "", "d", ON_SURFACE)


# --- Numbers of patches that roll with friction: by one theory, on one body, ahead and to the right.


Creep = Quantity[CreepState]


def _if_rolling(rolls: bool, value: Callable[[CreepState], Any]) -> Callable[[CreepState], Any]:
    """A number that only rolling has, or only a shift."""
    return lambda creep: value(creep) if creep.rolls == rolls else None


_rolling, _shifting = partial(_if_rolling, True), partial(_if_rolling, False)


THEORY: Creep = Quantity("theory", "theory", lambda creep: creep.theory)
LONGITUDINAL_CREEPAGE: Creep = Quantity(
    "longitudinal_creepage", "longitudinal creepage", _rolling(lambda creep: creep.longitudinal_creepage), form=".4%"
)
LATERAL_CREEPAGE: Creep = Quantity(
    "lateral_creepage", "lateral creepage", _rolling(lambda creep: creep.lateral_creepage), form=".4%"
)
SPIN_CREEPAGE: Creep = Quantity(
    "spin_creepage", "spin creepage", _rolling(lambda creep: creep.spin_creepage_per_m), "1/m", ".4f"
)
CREEPAGES = (LONGITUDINAL_CREEPAGE, LATERAL_CREEPAGE, SPIN_CREEPAGE)
LONGITUDINAL_FORCE: Creep = Quantity(
    "longitudinal_force", "longitudinal force", lambda creep: creep.forces.along, "kN", ".4f", factor=1e-3
)
LATERAL_FORCE: Creep = Quantity(
    "lateral_force", "lateral force", lambda creep: creep.lateral_force_N, "kN", ".4f", factor=1e-3
)
SPIN_MOMENT: Creep = Quantity("spin_moment", "spin moment", lambda creep: creep.spin_moment_Nm, "Nm", ".3f")
FORCES = (LONGITUDINAL_FORCE, LATERAL_FORCE, SPIN_MOMENT)
TRACTION: Creep = Quantity(
    "traction_coefficient",
    "traction coefficient",
    lambda creep: creep.used_friction,
    form=".4f",
    meaning="ratio of creep force to normal force",
)
T_GAMMA: Creep = Quantity(
    "t_gamma",
    "T-gamma",
    _rolling(lambda creep: creep.t_gamma_N),
    "N",
    ".3f",
    meaning="frictional power divided by the speed",
)
T_GAMMAS: tuple[Creep, ...] = (
    T_GAMMA,
    Quantity("t_gamma_without_spin", "  forces times creepages", _rolling(lambda f: f.products[0]), "N", ".3f"),
    Quantity("t_gamma_with_spin", "  and spin moment times spin", _rolling(lambda f: sum(f.products)), "N", ".3f"),
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
        "max_power_density", "maximum frictional power density", lambda creep: creep.power_density, "W/mm²", ".2f"
    ),
)
"""What theories with tractions have."""
BY_THEORY: tuple[Creep, ...] = (THEORY, *CREEPAGES, *FORCES, *T_GAMMAS)
SHIFT: tuple[Creep, ...] = (
    Quantity("shift_ahead", "shift ahead", _shifting(lambda creep: creep.longitudinal_creepage), "mm", ".6f"),
    Quantity("shift_right", "shift to the right", _shifting(lambda creep: creep.lateral_creepage), "mm", ".6f"),
    Quantity("shift_rotation", "rotation", _shifting(lambda creep: creep.spin_creepage_per_m), "mrad", ".4f"),
    Quantity("max_slip", "maximum slip", _shifting(lambda creep: creep.max_slip), "mm", ".6f"),
    Quantity("dissipated", "work of friction", _shifting(lambda creep: creep.forces.frictional_power), "N mm", ".4g"),
)
POWER: Creep = Quantity(
    "frictional_power", "frictional power", _rolling(lambda f: f.scale * f.forces.frictional_power), "W", ".1f"
)
