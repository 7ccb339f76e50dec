"""Creep forces of the Manchester contact benchmark, case A-2.2, left wheel, beside CONTACT."""

from collections.abc import Iterator

import numpy as np

from flangeway.contact.rolling.creepages import Creepages
from flangeway.contact.rolling.exact_rolling import FIRST, STEADY, roll
from flangeway.contact.rolling.friction import Friction
from flangeway.railway.wheelset.rolling.patch_rolling import rolling_contact_of
from flangeway.railway.wheelset.wheel_patch import SpatialPatch
from studies.rolling.rolling_cases import Energy
from studies.study import Row
from studies.wheelset3d.manchester import TABLE, BenchmarkPosition
from studies.wheelset3d.one_wheel import PressedWheel, on_square_cells

MU, CELL_MM = 0.3, 0.2
"""Friction of the benchmark, and CONTACT's cells."""
CREEP_LIMIT = 0.03
LEAST = 0.02
"""Component of the creep force over its resultant below which it is shown only."""
LEAST_LEVER_MM = 0.1 * CELL_MM
"""Spin moment over creep force below which it is shown only."""
WIDEST_MM = {"real": 4.2, "half_spaces": 7.0}
"""Longer semi-axis above which real bodies differ from half-spaces, and the rail from the benchmark's."""
SMALL = "a small component of the creep force"
WIDE = "the patch is 17 mm wide and CONTACT's area 2 % larger: the arcs of the bundled rail are 0.25 mm longer"
BODIES = "a wide patch, on which the bodies are not half-spaces; 2 % are CONTACT's error of first order"
LEVER = f"a lever of the creep force below {LEAST_LEVER_MM:g} mm"
SCHEME = "differences of second order; CONTACT's error of first order is in the published number"
BENT = "the bodies move the patch from the centre of the undeformed overlap, of which the moment is"
VARIANTS = (
    ("", "real", STEADY, None),
    (" of half-spaces", "half_spaces", STEADY, None),
    (" of half-spaces, CONTACT's cells and scheme", "half_spaces", FIRST, CELL_MM),
)


def creep_numbers(position: BenchmarkPosition, energy: Energy) -> Iterator[Row]:
    """Creep force and spin moment of one position at the published creepages.

    CONTACT gives slip and forces of the rail on the wheel, axes x ahead, y to the right, z down; ours are those of the
    wheel on the rail, t to the right on a left rail.
    """
    given = position.published
    motion = Creepages(-given["cksi"], -given["ceta"], given["cphi"])
    force = np.hypot(given["fx"], given["fs"])
    for words, name, differences, cell in VARIANTS:
        pressed: PressedWheel = getattr(position, name)
        pressed = pressed if cell is None else on_square_cells(pressed, cell)
        patch = SpatialPatch(pressed.side, pressed.state, pressed.patches[0])
        contact = rolling_contact_of(patch, Friction(MU), pressed.overlap[1:])
        found = energy.check(f"{TABLE}, {position.code}", roll(contact, motion, differences=differences))
        wide = ""
        if patch.ellipse.semi_axes[0] > WIDEST_MM[name]:
            wide = WIDE if patch.ellipse.semi_axes[0] > max(WIDEST_MM.values()) else BODIES
        steep = "" if position.comparable else "steep or divided contact"
        for quantity, key, unit, value in (
            ("longitudinal creep force", "fx", "N", -found.along),
            ("lateral creep force", "fs", "N", -found.across),
            ("spin moment", "mn", "N mm", found.moment),
        ):
            small = moment = ""
            if unit == "N":
                small = SMALL if abs(given[key]) < LEAST * force else ""
            elif cell is None:
                moment = SCHEME if name == "half_spaces" else BENT
            elif abs(given[key]) < LEAST_LEVER_MM * force:
                moment = LEVER
            note = steep or small or wide or moment
            yield Row(
                TABLE, position.code, quantity + words, unit, value, given[key], None if note else CREEP_LIMIT, note
            )
