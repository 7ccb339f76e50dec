"""Rolling with friction: what ``flangeway reproduce rolling`` computes, with meshed bodies and plane rollers."""

from collections.abc import Iterator
from dataclasses import replace

import numpy as np
from scipy.integrate import quad
from scipy.special import k0e

from flangeway.contact.patch.patch_contact import press_patch
from flangeway.contact.patch.patch_grid import PatchGrid
from flangeway.contact.rolling.exact_rolling import FIRST_STEP_WEIGHTS, creep_curve, derivatives, roll
from flangeway.contact.rolling.fast_theories import fastrip, fastsim, linear_theory, polach
from flangeway.contact.rolling.friction import Friction, Heat, Heating, SlopeReduction
from flangeway.contact.rolling.rolling_contact import STICKS, Creepages, RollingContact
from flangeway.exact import LineContact, PointContact, contact_modulus
from flangeway.materials import Elastic
from flangeway_studies.patches import HERTZ_STEEL, RADIUS, SEMI_AXIS, crowned
from flangeway_studies.rolling_cases import (
    COARSE_LIMIT,
    MU,
    PUBLISHED_CELLS,
    STEEL,
    WIDE,
    Energy,
    coefficient_numbers,
    contact_numbers,
    creep_numbers,
    elliptic,
    plane_numbers,
    published,
    sphere_numbers,
)
from flangeway_studies.study import Row, Run
from flangeway_studies.wheelset3d_study import benchmark_positions

# --- Rolling with friction on meshed bodies of finite size, beside half-spaces and closed forms.


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
        real, plain = (energy.check(f"bodies, {code}", roll(pair, motion)) for pair in (bodies, spaces))
        for name in ("along", "across", "moment"):
            exact, value = getattr(plain, name) / limit, getattr(real, name) / limit
            if abs(exact) > 0.01:
                yield Row("Bodies", code, name, "", value, exact, BODY_LIMIT, "on the bodies beside half-spaces")
    a, poisson = hertz.semi_axes[0], HERTZ_STEEL.poisson
    shear = HERTZ_STEEL.young / (2.0 + 2.0 * poisson)
    rates = [-derivatives(roll(pair, Creepages(1e-9))) for pair in (spaces, bodies)]
    for name, row, column, power in (("C11", 0, 0, 2), ("C22", 1, 1, 2), ("C23", 2, 1, 3), ("C33", 2, 2, 4)):
        exact, value = (rate[row, column] / (shear * a**power) for rate in rates)
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
    contact = press_patch(crowned("prism", crown), crowned("cylinder", None, turning), force=force)
    return RollingContact.of_bodies(contact, Friction(MU)), PointContact(force, crown, turning, modulus)


# --- Plane rollers of different materials, friction that falls, and the onset of rolling.


ALUMINIUM, BRASS = Elastic(2.62 * 23000.0, 0.31), Elastic(100e3, 0.34)
ROLLER_RADIUS, LOAD = 25.0, 16.2019
"""Relative radius in mm and load in N/mm of the rollers of CONTACT's example."""
FREE_CELLS, FREE_LIMIT = 160, 0.01
CONTACT_STRIP, CONTACT_STRIPS = 0.001, 216
"""CONTACT's cells: 200 of them in contact."""
HALF_LOADED = 0.403973
"""Half width t, over that of contact, of the middle with half of the load: t sqrt(1 - t^2) + arcsin t = pi / 4."""
BAND, BAND_SPEED, WARM_LIMIT = 2.0, 3.0, 0.01
"""Half length in mm of a band of heat, its speed in m/s, and the limit of flash temperatures beside closed forms."""
FAR = 10.0
"""Factor of the creepage of a published example at which slip is rigid."""
STICKING, SMOOTH = 10.0, 1e-4
"""Coefficients of friction with which nothing and everything slips."""


def free_numbers(energy: Energy) -> Iterator[Row]:
    """Rollers of different materials that roll freely or transmit a force."""
    for name, pair, load in (
        ("aluminium on steel", (ALUMINIUM, STEEL), LOAD),
        ("steel on brass", (STEEL, BRASS), 100.0),
    ):
        modulus = contact_modulus(*(material.plane_modulus for material in pair))
        hertz = LineContact(load, 1.0 / ROLLER_RADIUS, modulus).half_width
        # free surfaces of a half-space stretch by -(1 - 2 nu) p / (2 G) along, and 2 G = E / (1 + nu)
        first, second = (
            (1.0 - 2.0 * material.poisson) * (1.0 + material.poisson) / material.young for material in pair
        )
        slip = np.sqrt(1.0 - HALF_LOADED**2) * (first - second) * 2.0 * load / (np.pi * hertz)
        beta = (first - second) * modulus / 2.0  # Dundurs
        eta = np.arctanh(beta) / np.pi
        half = hertz / np.sqrt(1.0 + 4.0 * eta**2)  # friction keeps the patch shorter
        for mu, exact, a in ((SMOOTH, slip, hertz), (STICKING, 2.0 * eta * half / ROLLER_RADIUS, half)):
            # cells that end where the contact does
            contact = _rollers(pair, load, 4.0 * WIDE * a, 2.0 * a / FREE_CELLS, FREE_CELLS + FREE_CELLS // 5, mu)
            rolling = energy.check(f"free rolling, {name}, mu = {mu:g}", roll(contact, Creepages(), force_along=0.0))
            note = f"closed form; {FREE_CELLS} cells; {'everything slips' if mu == SMOOTH else 'nothing slips'}"
            yield Row(
                "Free rolling",
                f"{name}, mu={mu:g}",
                "creepage",
                "",
                float(rolling.motion.along),
                exact,
                FREE_LIMIT,
                note,
            )
    width = (
        4.0
        * WIDE
        * LineContact(
            LOAD, 1.0 / ROLLER_RADIUS, contact_modulus(ALUMINIUM.plane_modulus, STEEL.plane_modulus)
        ).half_width
    )
    rollers = _rollers((ALUMINIUM, STEEL), LOAD, width, CONTACT_STRIP, CONTACT_STRIPS, STICKING)
    for (code, _), exact in published("bentall").items():
        mu, part = map(float, code.split(" "))
        contact = replace(rollers, friction=Friction(mu))
        rolling = energy.check(
            f"rollers, {code}",
            roll(contact, Creepages(), force_along=part * mu * contact.force, differences=FIRST_STEP_WEIGHTS),
        )
        words = f"force {part:g} of its limit" if part else "no force"
        note = f"CONTACT's cells and its differences of first order; {words}"
        yield Row(
            "Rollers", f"mu={mu:g}, {words}", "creepage", "", float(rolling.motion.along), exact, FREE_LIMIT, note
        )


def _rollers(
    pair: tuple[Elastic, Elastic], load: float, width: float, strip: float, n_strips: int, mu: float
) -> RollingContact:
    """Rollers under a load over their width."""
    grid = PatchGrid(width / 2.0 * np.array([-1.0, 1.0]), strip, n_strips)
    gaps = grid.along[None] ** 2 / (2.0 * ROLLER_RADIUS)
    return RollingContact.of_half_spaces(grid, gaps, Friction(mu), pair, force=load * width)


def falling_numbers(energy: Energy) -> Iterator[Row]:
    """A wheel of 460 mm on a plane at 45 m/s, with friction that falls with the slip velocity, a half each 0.1 m/s."""
    (exact,) = published("falling").values()
    grid = PatchGrid(np.array([-100.0, 100.0]), 0.1, 92)
    friction, gaps = Friction(0.3, 0.18, 100.0 / np.log(2.0)), grid.along[None] ** 2 / 920.0
    contact = RollingContact.of_half_spaces(grid, gaps, friction, (STEEL, STEEL), force=622216.0)
    rolling = energy.check("falling friction", roll(contact, Creepages(-0.0009999, speed=45000.0)))
    yield Row(
        "CONTACT",
        "friction that falls with slip",
        "force over its limit",
        "",
        rolling.along / (0.3 * contact.force),
        exact,
        COARSE_LIMIT,
        "81 cells along the patch",
    )


def warm_numbers(energy: Energy) -> Iterator[Row]:
    """Flash temperatures of a band and of an ellipse that slide, friction that falls with them, and reduced slopes."""
    steel, n = Heat(temperature_C=0.0), PUBLISHED_CELLS
    warm = Friction(MU, heating=Heating(steel, steel))
    # a band under even pressures, by whose speed everything slips
    grid = PatchGrid(WIDE * np.array([-1.0, 1.0]), 2.0 * BAND / (4 * n), 4 * n)
    contact = RollingContact.between_half_spaces(grid, np.full((1, 4 * n), 500.0), warm, (STEEL, STEEL))
    rolling = energy.check("band of heat", roll(contact, Creepages(0.2, speed=BAND_SPEED)))
    assert rolling.flash_temperatures is not None
    diffusivity = steel.conductivity_W_per_m_K / (steel.density_kg_m3 * steel.capacity_J_per_kg_K)
    peclet = BAND_SPEED / (2.0 * diffusivity)  # over a length in m

    # Carslaw and Jaeger's line sources (1959, 10.7), of half of the heat: K_0(z) exp(z) ahead, K_0(z) exp(-z) behind,
    # with z = V distance / (2 kappa), seven eighths along the band
    middle = n // 2
    behind = 1e-3 * grid.strip * (middle + 0.5)
    sides = (
        quad(lambda length: k0e(peclet * length), 0.0, 2e-3 * BAND - behind, points=[1e-5], limit=200)[0],
        quad(lambda length: k0e(peclet * length) * np.exp(-2.0 * peclet * length), 0.0, behind, points=[1e-5])[0],
    )
    power = 1e6 * MU * 500.0 * 0.2 * BAND_SPEED / 2.0
    exact = power / (np.pi * steel.conductivity_W_per_m_K) * sum(sides)
    note = f"line sources, V a / (2 kappa) = {1e-3 * BAND * peclet:.0f}; {4 * n} cells"
    rise = rolling.flash_temperatures[0, middle]
    yield Row("Flash temperature", "band at even pressures", "rise", "K", rise, exact, WARM_LIMIT, note)

    ((code, published_rise),) = ((code, value) for (code, _), value in published("warm").items())
    speed, semi_axes, force = 30.0, (10.54, 5.88), 100e3
    contact = RollingContact.under_hertz(semi_axes, force, (n, 2 * n), warm, (STEEL, STEEL))
    rolling = energy.check("ellipse of heat", roll(contact, Creepages(FAR * float(code), speed=speed)))
    assert rolling.flash_temperatures is not None
    peak = 1.5 * force / (np.pi * semi_axes[0] * semi_axes[1])
    # in the middle strip, x from the leading end over a: the largest integral of sqrt(1 - xi^2) / sqrt(x - xi)
    integrals = [
        quad(lambda u, x=x: 2.0 * np.sqrt(max(1.0 - (x - u**2) ** 2, 0.0)), 0.0, np.sqrt(x + 1.0))[0]
        for x in np.linspace(-0.5, 1.0, 151)
    ]
    flow = 1e6 * MU * peak * FAR * abs(float(code)) * speed * np.sqrt(1e-3 * semi_axes[1])
    exact = flow / (2.0 * steel.effusivity * np.sqrt(np.pi * speed)) * max(integrals)
    rise, note = rolling.flash_temperatures.max(), f"integral of the middle strip; {n} x {2 * n} cells"
    yield Row("Flash temperature", "ellipse that slides", "maximum", "K", rise, exact, WARM_LIMIT, note)
    rolling = energy.check("ellipse at 1 m/s", roll(contact, Creepages(float(code), speed=speed)))
    assert rolling.flash_temperatures is not None
    rise = rolling.flash_temperatures.max()
    note = "CONTACT on 59 cells along, which adds the heat of the cell itself twice"
    yield Row("CONTACT", "ellipse that slides at 1 m/s", "maximum", "K", rise, published_rise, None, note)

    friction = Friction(0.36, 0.1368, 0.99 / np.log(2.0), slope=SlopeReduction(initial=0.54, remaining=0.02, rate=0.62))
    contact = RollingContact.under_hertz((12.61, 6.304), 106700.0, (n, n), friction, (STEEL, STEEL))
    for (code, _), exact in published("reduced").items():
        motion = Creepages(float(code), speed=10.0)
        value = fastsim(contact, motion).along / contact.force
        note = "modified FASTSIM on 40 cells; exact theory: "
        note += f"{energy.check(code, roll(contact, motion)).along / contact.force:.4f}"
        yield Row("CONTACT", f"reduced slope, {code}", "force over load", "", value, exact, COARSE_LIMIT, note)


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
            state = roll(contact, motion, force_along=wanted, before=state, start=state, differences=FIRST_STEP_WEIGHTS)
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


# --- Rolling with friction: what ``flangeway reproduce rolling`` computes.


CURVE = tuple(np.linspace(0.0, 0.004, 17).tolist())
SPIN = 3e-4  # per mm, of the second creep curve
THEORIES = {"linear theory": linear_theory, "Polach": polach, "FASTSIM": fastsim, "FaStrip": fastrip}


def rows(run: Run) -> Iterator[Row]:
    """Rows of all parts."""
    energy, numbers = Energy(run), list[Row]()
    for name, part in (
        ("cylinders", plane_numbers),
        ("spheres", sphere_numbers),
        ("different materials", free_numbers),
        ("examples of CONTACT", contact_numbers),
        ("falling friction", falling_numbers),
        ("temperature and reduced slope", warm_numbers),
        ("onset of rolling", onset_numbers),
    ):
        run.progress(name)
        numbers += part(energy)
    numbers += coefficient_numbers(run.progress)
    run.progress("real bodies")
    numbers += body_numbers(energy)
    for position in benchmark_positions(run, every=1):
        numbers += creep_numbers(position, energy)
    run.progress("creep curves")
    contact = elliptic(8.0, 4.0, 82000.0, (PUBLISHED_CELLS, PUBLISHED_CELLS))
    limit = contact.friction.limits[0][0] * contact.force
    for spin in (0.0, SPIN):
        motions = [Creepages(creepage, 0.0, spin) for creepage in CURVE]
        exact = [energy.check("creep curve", state) for state in creep_curve(contact, motions)]
        forces = {"exact": [(state.along, state.across) for state in exact]}
        for name, theory in THEORIES.items():
            forces[name] = [(state.along, state.across) for state in (theory(contact, motion) for motion in motions)]
        for name, curve in forces.items():
            along, across = np.array(curve).T / limit
            words = f"spin {1e3 * spin:g} per m" if spin else "without spin"
            run.curve("creep_curves", f"along, {words}", name, 1e3 * np.array(CURVE), along)
            if spin:
                run.curve("creep_curves", f"across, {words}", name, 1e3 * np.array(CURVE), across)
    yield energy.row()
    yield from numbers
