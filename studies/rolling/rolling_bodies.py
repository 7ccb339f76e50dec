"""Rolling with friction on meshed bodies of finite size, beside half-spaces and closed forms."""

from collections.abc import Iterator

import numpy as np

from flangeway.contact.patch.patch_contact import press_patch
from flangeway.contact.rolling.creepages import Creepages
from flangeway.contact.rolling.exact_rolling import derivatives, roll
from flangeway.contact.rolling.friction import Friction
from flangeway.contact.rolling.rolling_contact import RollingContact
from flangeway.contact.rolling.rolling_result import STICKS
from flangeway.exact import PointContact, contact_modulus
from studies.rolling.rolling_cases import MU, Energy
from studies.spatial.patches import HERTZ_STEEL, RADIUS, SEMI_AXIS, crowned
from studies.study import Row

BODY_LIMIT = 0.03
"""Bodies of 400 x 300 mm bend, and friction moves their curved surfaces along the normals."""
SHIFTED = 0.875
"""Force of the shift over the limit of friction."""
WIDE_CROWN, WIDE_TURNING, WIDE_AXIS = 3000.0, 500.0, 5.8
"""Radii across and along, and semi-axis across, in mm of a patch that is 3.2 times as wide as long."""


def body_numbers(energy: Energy) -> Iterator[Row]:
    """Real bodies beside half-spaces under the same pressures, and beside Cattaneo and Mindlin, and Carter."""
    bodies, hertz = _pressed(RADIUS, RADIUS, SEMI_AXIS)
    spaces = RollingContact.between_half_spaces(bodies.grid, bodies.pressures, bodies.friction, bodies.materials)
    limit = MU * bodies.force
    for code, motion in (
        ("longitudinal", Creepages(1e-3)),
        ("lateral and spin", Creepages(0.0, 1e-3, 3e-4)),
        ("all", Creepages(1e-3, 1e-3, -5e-4)),
    ):
        real, plain = (energy.check(f"bodies, {code}", roll(each, motion)) for each in (bodies, spaces))
        for name in ("along", "across", "moment"):
            exact, value = getattr(plain, name) / limit, getattr(real, name) / limit
            if abs(exact) > 0.01:
                yield Row("Bodies", code, name, "", value, exact, BODY_LIMIT, "on the bodies beside half-spaces")
    a, poisson = hertz.semi_axes[0], HERTZ_STEEL.poisson
    shear = HERTZ_STEEL.young / (2.0 + 2.0 * poisson)
    rates = [-derivatives(roll(each, Creepages(1e-9))) for each in (spaces, bodies)]
    for name, row, column, power in (("C11", 0, 0, 2), ("C22", 1, 1, 2), ("C23", 2, 1, 3), ("C33", 2, 2, 4)):
        exact, value = (each[row, column] / (shear * a**power) for each in rates)
        yield Row(
            "Bodies",
            "creep coefficients at a/b = 1",
            name,
            "",
            value,
            exact,
            BODY_LIMIT,
            "on the bodies beside half-spaces on the same cells",
        )
    state = energy.check("bodies, shift", roll(bodies, Creepages(speed=0.0), force_along=-SHIFTED * limit))
    stick = np.sqrt((state.states == STICKS).sum() / (state.states > 0).sum())
    shift = 3.0 * limit * (2.0 - poisson) / (8.0 * shear * a) * (1.0 - (1.0 - SHIFTED) ** (2.0 / 3.0))
    code, note = f"Cattaneo-Mindlin, {SHIFTED:g} of full slip", "on the bodies beside the closed form of half-spaces"
    yield Row("Bodies", code, "shift", "mm", float(state.motion.along), shift, BODY_LIMIT, note)
    yield Row("Bodies", code, "radius of stick", "a", stick, (1.0 - SHIFTED) ** (1.0 / 3.0), BODY_LIMIT, note)
    bodies, hertz = _pressed(WIDE_CROWN, WIDE_TURNING, WIDE_AXIS)
    p0 = 1.5 * bodies.force / (np.pi * hertz.semi_axes[0] * hertz.semi_axes[1])
    middle = slice((len(bodies.pressures) - 1) // 2, len(bodies.pressures) // 2 + 1)
    for part in (0.2, 0.5, 0.8):
        motion = Creepages(part * 4.0 * MU * p0 / HERTZ_STEEL.plane_modulus)
        state = energy.check("bodies, Carter", roll(bodies, motion))
        force = -(state.tractions[middle, :, 1].sum() / (MU * bodies.pressures[middle].sum()))
        yield Row(
            "Bodies",
            f"Carter, {part:g} of full slip",
            "force over its limit",
            "",
            force,
            1.0 - (1.0 - part) ** 2,
            BODY_LIMIT,
            "middle strip of a patch 3.2 times as wide as long, beside plane half-spaces",
        )


def _pressed(crown: float, turning: float, semi_axis: float) -> tuple[RollingContact, PointContact]:
    """A crowned prism below a cylinder across it under the force of Hertz's longer semi-axis, and Hertz's contact."""
    modulus = contact_modulus(HERTZ_STEEL.plane_modulus, HERTZ_STEEL.plane_modulus)
    force = 1e3 * (semi_axis / max(PointContact(1e3, crown, turning, modulus).semi_axes)) ** 3
    found = press_patch(crowned("prism", crown), crowned("cylinder", None, turning), force=force)
    return RollingContact.of_bodies(found, Friction(MU)), PointContact(force, crown, turning, modulus)
