"""Rolling with friction on half-spaces beside closed forms, published numbers and the Manchester contact benchmark."""

from collections.abc import Iterator

import numpy as np

from flangeway.contact.patch.patch_grid import PatchGrid
from flangeway.contact.rolling.exact_rolling import FIRST_STEP_WEIGHTS, STEADY_WEIGHTS, derivatives, roll
from flangeway.contact.rolling.fast_theories import fastrip, fastsim
from flangeway.contact.rolling.friction import Friction
from flangeway.contact.rolling.rolling_contact import STICKS, Creepages, Rolling, RollingContact
from flangeway.exact import PointContact, contact_modulus
from flangeway.materials import Elastic
from flangeway.railway.wheelset.wheel_patch import WheelPatch, rolling_contact_of
from flangeway.types import Floats, Progress
from flangeway_studies.study import Published, Row, Run, published_values
from flangeway_studies.wheelset3d_study import TABLE, BenchmarkPosition, PressedWheel, on_square_cells

# --- Rolling with friction beside closed forms and published numbers.


STEEL = Elastic(2.56 * 82000.0, 0.28)
PEAK, MU = 113.89008307646377, 0.3
"""Maximum pressure in MPa of Carter's cylinders, half length 1 mm, and the coefficient of friction."""
WIDE = 1000.0
"""Half width of the only cells across where the problem is plane, over the half length of contact."""
PLANE_CELLS, SHIFTED_CELLS = (20, 40, 80, 160), 240
LINE_LIMIT, POINT_LIMIT = 5e-3, 5e-3
SPHERES = (24, 48, 72)
COEFFICIENT_CELLS = (24, 30, 36, 42, 48)
COEFFICIENT_LIMITS = {"c11": 0.01, "c22": 0.01, "c23": 0.01, "c33": 0.03}
SLENDER = 0.6
"""Exponent of a/b in the number of strips for one row, for a > b."""
FLEXIBILITIES = (0.4937e-4, 0.5152e-4, 0.4090e-4)
PUBLISHED_CELLS, FASTSIM_LIMIT, COARSE_LIMIT = 40, 5e-3, 0.03
ENERGY_LIMIT, MIN_POWER = 1e-9, 1e-12


class Energy:
    """Maximum difference of frictional power from that of forces and creepages, of states of a run."""

    def __init__(self, run: Run) -> None:
        self.run, self.error, self.count = run, 0.0, 0

    def check(self, name: str, rolling: Rolling) -> Rolling:
        """Note a state, which has to be converged."""
        self.run.check(name, rolling.status)
        if rolling.motion.rolls:
            power = abs(rolling.motion.speed) * rolling.t_gamma
            size = max(abs(power) + abs(rolling.rolling_power), MIN_POWER)
            self.error = max(self.error, abs(rolling.frictional_power - power) / size)
            self.count += 1
        return rolling

    def row(self) -> Row:
        """The row of the table."""
        note = f"largest of {self.count} states of steady rolling: difference over the power"
        return Row(
            "Energy", "all", "power of friction less forces times creepages", "", self.error, 0.0, ENERGY_LIMIT, note
        )


def published(case: str) -> Published:
    """Published values of a case by code and quantity."""
    return published_values("rolling.csv", case)


def elliptic(
    along: float,
    across: float,
    force: float,
    cells: tuple[int, int],
    friction: float = MU,
    materials: tuple[Elastic, Elastic] = (STEEL, STEEL),
) -> RollingContact:
    """Half-spaces under Hertz's pressure on an ellipse of cells, numbers across and along its axes."""
    return RollingContact.under_hertz((across, along), force, cells, Friction(friction), materials)


def line(half: float, peak: float, n: int) -> RollingContact:
    """Plane contact of like bodies under Hertz's pressure."""
    grid = PatchGrid(WIDE * half * np.array([-1.0, 1.0]), 2.0 * half / n, n)
    ends = np.linspace(-1.0, 1.0, n + 1)
    pressures = peak * np.diff(ends * np.sqrt(1.0 - ends**2) + np.arcsin(ends)) * n / 4.0
    return RollingContact.between_half_spaces(grid, pressures[None], Friction(MU), (STEEL, STEEL))


def plane_numbers(energy: Energy) -> Iterator[Row]:
    """Carter's cylinders, and the shift of cylinders by Cattaneo and Mindlin."""
    exact = published("carter")
    code = "0.00024"
    for n in PLANE_CELLS:
        contact = line(1.0, PEAK, n)
        rolling = energy.check("Carter", roll(contact, Creepages(float(code))))
        force = -rolling.along / (MU * contact.force)
    stick = (rolling.states == STICKS).mean()
    note = f"{n} cells; the error falls with their number"
    yield Row("Carter", code, "force over its limit", "", force, exact[code, "force"], LINE_LIMIT, note)
    yield Row("Carter", code, "half width of stick", "a", stick, exact[code, "stick"], LINE_LIMIT, note)
    saturation = 2.0 * MU * PEAK * 2.0 * (1.0 - STEEL.poisson**2) / STEEL.young
    for part in (0.2, 0.6, 0.8):
        rolling = energy.check("Carter", roll(contact, Creepages(part * saturation)))
        force = -rolling.along / (MU * contact.force)
        yield Row(
            "Carter",
            f"{part:g} of full slip",
            "force over its limit",
            "",
            force,
            1.0 - (1.0 - part) ** 2,
            LINE_LIMIT,
            note,
        )
    n = SHIFTED_CELLS
    contact = line(1.0, PEAK, n)
    for part in (0.25, 0.5, 0.75, 0.9):
        limit = MU * contact.force
        rolling = energy.check("Cattaneo", roll(contact, Creepages(speed=0.0), force_along=-part * limit))
        stick = (rolling.states == STICKS).mean()
        yield Row(
            "Cattaneo-Mindlin",
            f"cylinders, {part:g} of full slip",
            "half width of stick",
            "a",
            stick,
            np.sqrt(1.0 - part),
            LINE_LIMIT,
            f"{n} cells",
        )


def sphere_numbers(energy: Energy) -> Iterator[Row]:
    """Spheres shifted by 0.875 of the limit of friction (Cattaneo, Mindlin); large creepage, and large spin."""
    material, force, mu, part = Elastic(2.84 * 200.0, 0.42), 9.1954, 0.4, 0.875
    modulus = contact_modulus(material.plane_modulus, material.plane_modulus)
    radius = 4.0 * modulus / (3.0 * force)
    hertz = PointContact(force, radius, radius, modulus)
    a = hertz.semi_axes[0]
    shift = 3.0 * mu * force * (2.0 - 0.42) / (8.0 * 200.0 * a) * (1.0 - (1.0 - part) ** (2.0 / 3.0))
    errors = []
    for n in SPHERES:
        contact = elliptic(a, a, force, (n, n), mu, (material, material))
        state = energy.check("spheres", roll(contact, Creepages(speed=0.0), force_along=-part * mu * force))
        stick = np.sqrt((state.states == STICKS).sum() / (state.states > 0).sum())
        # cells in the circle have not its area
        size = np.sqrt((contact.pressures > 0.0).sum() * contact.areas[0, 0] / np.pi)
        errors.append((state.motion.along * size / a, stick))
    values = extrapolated(SPHERES, np.array(errors))
    note = f"{len(SPHERES)} grids of {SPHERES[0]} to {SPHERES[-1]} cells across, extrapolated"
    yield Row("Cattaneo-Mindlin", "spheres, 0.875 of full slip", "shift", "mm", values[0], shift, POINT_LIMIT, note)
    note = f"{SPHERES[-1]} cells across: the square root of their share"
    yield Row(
        "Cattaneo-Mindlin", "spheres, 0.875 of full slip", "radius of stick", "a", errors[-1][1], 0.5, POINT_LIMIT, note
    )
    contact = elliptic(1.0, 1.0, 1000.0, (30, 30))
    limit = MU * contact.force
    for code, motion, exact in (
        ("large creepage along", Creepages(0.1), (-1.0, 0.0, 0.0)),
        ("large creepage across", Creepages(0.06, -0.08), (-0.6, 0.8, 0.0)),
        ("large spin", Creepages(spin=10.0), (0.0, 0.0, -3.0 * np.pi / 16.0)),
    ):
        state = energy.check(code, roll(contact, motion))
        values = np.array([state.along, state.across, state.moment]) / limit
        for name, wanted, value in zip(("F_z", "F_t", "M_n"), exact, values.tolist(), strict=True):
            if wanted:
                yield Row(
                    "Saturation", code, name, "limit" if name < "M" else "limit a", value, wanted, 0.01, "30 x 30 cells"
                )


def extrapolated(cells: tuple[int, ...], values: Floats) -> Floats:
    """Values (n_grids, m) extrapolated linearly to cells of no width."""
    terms = np.stack((np.ones(len(cells)), 1.0 / np.array(cells)), axis=1)
    fit: Floats = np.linalg.lstsq(terms, values)[0][0]
    return fit


def coefficients(ratio: float, poisson: float, n: int) -> tuple[float, float, float, float]:
    """Kalker's coefficients C11, C22, C23 and C33 on n cells across an ellipse with a/b = ratio."""
    material = Elastic(2.0 * (1.0 + poisson), poisson)
    along = n if ratio <= 1.0 else 2 * round(n * ratio**SLENDER / 2.0)
    contact = elliptic(1.0, 1.0 / ratio, 1.0, (n, along), MU, (material, material))
    # cells in the ellipse have not its area
    area = (contact.areas[0, 0] * (contact.pressures > 0.0).sum()) / np.pi
    rates = -derivatives(roll(contact, Creepages(1e-9)))
    mixed = (rates[2, 1] - rates[1, 2]) / 2.0
    return (rates[0, 0] / area), (rates[1, 1] / area), (mixed / area**1.5), (rates[2, 2] / area**2)


def coefficient_numbers(progress: Progress) -> Iterator[Row]:
    """Kalker's coefficients for five ellipses."""
    table = published("coefficients")
    for code in dict.fromkeys(code for code, _ in table):
        progress(f"creep coefficients at a/b = {code}")
        computed = np.array([coefficients(float(code), 0.25, n) for n in COEFFICIENT_CELLS])
        best = extrapolated(COEFFICIENT_CELLS, computed)
        for number, (name, limit) in enumerate(COEFFICIENT_LIMITS.items()):
            exact = table[code, name]
            note = (
                f"{computed[-1, number]:.4g} on {COEFFICIENT_CELLS[-1]} cells across, extrapolated from "
                f"{len(COEFFICIENT_CELLS)} grids; published with three digits"
            )
            yield Row("Creep coefficients", f"a/b={code}", name.upper(), "", best[number], exact, limit, note)


def contact_numbers(energy: Energy) -> Iterator[Row]:
    """Examples of CONTACT: spin with lateral creepage, and a creep curve, by the exact theory and by FASTSIM."""
    table, n = published("fastsim"), PUBLISHED_CELLS
    limit = MU * 82000.0
    motion = Creepages(0.0, -0.000625, -0.000625)
    contact = elliptic(8.0, 4.0, 82000.0, (n, n))
    state = energy.check("spin", roll(contact, motion))
    for name, value in (("F_y", state.across / limit), ("M_z", -state.moment)):
        note = f"{n} x {n} cells; the published one has an error of first order"
        yield Row("CONTACT", "spin, exact", name, "", value, table["exact", name], COARSE_LIMIT, note)
    fine = elliptic(8.0, 4.0, 82000.0, (5 * n, n))
    for bound in ("parabolic", "elliptic"):
        simple = fastsim(fine, motion, flexibilities=FLEXIBILITIES, parabolic=bound == "parabolic", n_steps=5 * n)
        for name, value in (("F_y", simple.across / limit), ("M_z", -simple.moment)):
            coarse, better = (table[f"{bound} {steps}", name] for steps in (n, 5 * n))
            note = f"{better:.4g} on {5 * n} steps and {coarse:.4g} on {n}, extrapolated"
            yield Row(
                "FASTSIM", f"spin, {bound}", name, "", value, better + (better - coarse) / 4.0, FASTSIM_LIMIT, note
            )
    strip = fastrip(fine, motion)
    note = "FaStrip beside the exact theory"
    yield Row("FaStrip", "spin", "F_y", "", strip.across / limit, state.across / limit, None, note)
    yield Row("FaStrip", "spin", "M_z", "", -strip.moment, -state.moment, None, note)
    contact = elliptic(6.304, 12.61, 106700.0, (n, n), 0.33)
    for (code, theory), exact in published("curve").items():
        motion = Creepages(float(code))
        rolling = energy.check(code, roll(contact, motion)) if theory == "exact" else fastsim(contact, motion)
        value = rolling.along / (0.33 * contact.force)
        yield Row(
            "CONTACT" if theory == "exact" else theory,
            f"creepage {code}",
            "force over its limit",
            "",
            value,
            exact,
            COARSE_LIMIT,
            f"published on {n} cells, error of first order",
        )


# --- Creep forces of the Manchester contact benchmark, case, left wheel, beside CONTACT.


MANCHESTER_MU, CELL_MM = 0.3, 0.2
"""Friction of the benchmark, and CONTACT's cells."""
CREEP_LIMIT = 0.03
LEAST = 0.02
"""Component of the creep force over its resultant below which it is shown only."""
MIN_LEVER_MM = 0.1 * CELL_MM
"""Spin moment over creep force below which it is shown only."""
MAX_WIDTH_MM = {"real": 4.2, "half_spaces": 7.0}
"""Longer semi-axis above which real bodies differ from half-spaces, and the rail from the benchmark's."""
SMALL = "a small component of the creep force"
WIDE_PATCH = "the patch is 17 mm wide and CONTACT's area 2 % larger: the arcs of the bundled rail are 0.25 mm longer"
BODIES = "a wide patch, on which the bodies are not half-spaces; 2 % are CONTACT's error of first order"
LEVER = f"a lever of the creep force below {MIN_LEVER_MM:g} mm"
SCHEME = "differences of second order; CONTACT's error of first order is in the published number"
BENT = "the bodies move the patch from the centre of the undeformed overlap, of which the moment is"
VARIANTS = (
    ("", "real", STEADY_WEIGHTS, None),
    (" of half-spaces", "half_spaces", STEADY_WEIGHTS, None),
    (" of half-spaces, CONTACT's cells and scheme", "half_spaces", FIRST_STEP_WEIGHTS, CELL_MM),
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
        patch = WheelPatch(pressed.state.cells, pressed.patches[0].inside, pressed.side, pressed.state)
        contact = rolling_contact_of(patch, Friction(MANCHESTER_MU), pressed.overlap[1:])
        rolling = energy.check(f"{TABLE}, {position.code}", roll(contact, motion, differences=differences))
        wide = ""
        if patch.semi_axes[0] > MAX_WIDTH_MM[name]:
            wide = WIDE_PATCH if patch.semi_axes[0] > max(MAX_WIDTH_MM.values()) else BODIES
        steep = "" if position.comparable else "steep or divided contact"
        for quantity, key, unit, value in (
            ("longitudinal creep force", "fx", "N", -rolling.along),
            ("lateral creep force", "fs", "N", -rolling.across),
            ("spin moment", "mn", "N mm", rolling.moment),
        ):
            small = moment = ""
            if unit == "N":
                small = SMALL if abs(given[key]) < LEAST * force else ""
            elif cell is None:
                moment = SCHEME if name == "half_spaces" else BENT
            elif abs(given[key]) < MIN_LEVER_MM * force:
                moment = LEVER
            note = steep or small or wide or moment
            yield Row(
                TABLE, position.code, quantity + words, unit, value, given[key], None if note else CREEP_LIMIT, note
            )
