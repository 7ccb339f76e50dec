"""Plane rollers of different materials, friction that falls, and the onset of rolling."""

from collections.abc import Iterator
from dataclasses import replace

import numpy as np

from flangeway.contact.patch.patch_grid import PatchGrid
from flangeway.contact.rolling.creepages import Creepages
from flangeway.contact.rolling.exact_rolling import FIRST, roll
from flangeway.contact.rolling.friction import Friction
from flangeway.contact.rolling.rolling_contact import RollingContact
from flangeway.exact import LineContact, contact_modulus
from flangeway.materials import Elastic
from studies.rolling.rolling_cases import COARSE_LIMIT, STEEL, WIDE, Energy, published
from studies.study import Row

ALUMINIUM, BRASS = Elastic(2.62 * 23000.0, 0.31), Elastic(100e3, 0.34)
RADIUS, LOAD = 25.0, 16.2019
"""Relative radius in mm and load in N/mm of the rollers of CONTACT's example."""
FREE_CELLS, FREE_LIMIT = 160, 0.01
CONTACT_STRIP, CONTACT_STRIPS = 0.001, 216
"""CONTACT's cells: 200 of them in contact."""
HALF_LOADED = 0.403973
"""Half width t, over that of contact, of the middle with half of the load: t sqrt(1 - t^2) + arcsin t = pi / 4."""
STICKING, SMOOTH = 10.0, 1e-4
"""Coefficients of friction with which nothing and everything slips."""


def free_numbers(energy: Energy) -> Iterator[Row]:
    """Rollers of different materials that roll freely or transmit a force."""
    for name, pair, load in (
        ("aluminium on steel", (ALUMINIUM, STEEL), LOAD),
        ("steel on brass", (STEEL, BRASS), 100.0),
    ):
        modulus = contact_modulus(*(each.plane_modulus for each in pair))
        hertz = LineContact(load, 1.0 / RADIUS, modulus).half_width
        # free surfaces of a half-space stretch by -(1 - 2 nu) p / (2 G) along, and 2 G = E / (1 + nu)
        first, second = ((1.0 - 2.0 * each.poisson) * (1.0 + each.poisson) / each.young for each in pair)
        slip = np.sqrt(1.0 - HALF_LOADED**2) * (first - second) * 2.0 * load / (np.pi * hertz)
        beta = (first - second) * modulus / 2.0  # Dundurs
        eta = np.arctanh(beta) / np.pi
        half = hertz / np.sqrt(1.0 + 4.0 * eta**2)  # friction keeps the patch shorter
        for mu, exact, a in ((SMOOTH, slip, hertz), (STICKING, 2.0 * eta * half / RADIUS, half)):
            # cells that end where the contact does
            contact = _rollers(pair, load, 4.0 * WIDE * a, 2.0 * a / FREE_CELLS, FREE_CELLS + FREE_CELLS // 5, mu)
            found = energy.check(f"free rolling, {name}, mu = {mu:g}", roll(contact, Creepages(), force_along=0.0))
            note = f"closed form; {FREE_CELLS} cells; {'everything slips' if mu == SMOOTH else 'nothing slips'}"
            yield Row(
                "Free rolling", f"{name}, mu={mu:g}", "creepage", "", float(found.motion.along), exact, FREE_LIMIT, note
            )
    width = (
        4.0
        * WIDE
        * LineContact(LOAD, 1.0 / RADIUS, contact_modulus(ALUMINIUM.plane_modulus, STEEL.plane_modulus)).half_width
    )
    rollers = _rollers((ALUMINIUM, STEEL), LOAD, width, CONTACT_STRIP, CONTACT_STRIPS, STICKING)
    for (code, _), exact in published("bentall").items():
        mu, part = map(float, code.split(" "))
        contact = replace(rollers, friction=Friction(mu))
        found = energy.check(
            f"rollers, {code}",
            roll(contact, Creepages(), force_along=part * mu * contact.force, differences=FIRST),
        )
        words = f"force {part:g} of its limit" if part else "no force"
        note = f"CONTACT's cells and its differences of first order; {words}"
        yield Row("Rollers", f"mu={mu:g}, {words}", "creepage", "", float(found.motion.along), exact, FREE_LIMIT, note)


def _rollers(
    pair: tuple[Elastic, Elastic], load: float, width: float, strip: float, n_strips: int, mu: float
) -> RollingContact:
    """Rollers under a load over their width."""
    grid = PatchGrid(width / 2.0 * np.array([-1.0, 1.0]), strip, n_strips)
    gaps = grid.along[None] ** 2 / (2.0 * RADIUS)
    return RollingContact.of_half_spaces(grid, gaps, Friction(mu), pair, force=load * width)


def falling_numbers(energy: Energy) -> Iterator[Row]:
    """A wheel of 460 mm on a plane at 45 m/s, with friction that falls with the slip velocity, a half each 0.1 m/s."""
    (exact,) = published("falling").values()
    grid = PatchGrid(np.array([-100.0, 100.0]), 0.1, 92)
    friction, gaps = Friction(0.3, 0.18, 100.0 / np.log(2.0)), grid.along[None] ** 2 / 920.0
    contact = RollingContact.of_half_spaces(grid, gaps, friction, (STEEL, STEEL), force=622216.0)
    found = energy.check("falling friction", roll(contact, Creepages(-0.0009999, speed=45000.0)))
    yield Row(
        "CONTACT",
        "friction that falls with slip",
        "force over its limit",
        "",
        found.along / (0.3 * contact.force),
        exact,
        COARSE_LIMIT,
        "81 cells along the patch",
    )


def onset_numbers(energy: Energy) -> Iterator[Row]:
    """From Cattaneo's shift to steady rolling under a constant force, in steps of one cell (Kalker, 1990, 5.2.2.5)."""
    material, mu, force, cell = Elastic(2.56, 0.28), 0.4013, 0.4705, 0.25
    grid = PatchGrid(cell * (np.arange(34.0) - 16.5), cell, 34)
    across = (grid.bounds[1:] + grid.bounds[:-1]) / 2.0
    gaps = 0.002963 * (across[:, None] ** 2 + grid.along**2)
    contact = RollingContact.of_half_spaces(grid, gaps, Friction(mu), (material, material), force=force)
    wanted = -0.657 * mu * force
    state = energy.check("onset", roll(contact, Creepages(speed=0.0), force_along=wanted))
    exact, creepage = published("onset"), 0.0
    for step in range(1 + max(int(code) for code, _ in exact)):
        if step:
            motion = Creepages(creepage)
            state = roll(contact, motion, force_along=wanted, before=state, start=state, differences=FIRST)
            creepage = float(state.motion.along)
            energy.run.check(f"onset, step {step}", state.status)
        for name in ("shift", "creepage"):
            if (str(step), name) in exact:
                yield Row(
                    "CONTACT",
                    f"onset of rolling, {step} steps",
                    name,
                    "mm" if name == "shift" else "",
                    float(state.motion.along),
                    exact[str(step), name],
                    COARSE_LIMIT,
                    "CONTACT's cells and its differences of first order",
                )
