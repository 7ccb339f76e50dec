"""Damage: wear laws, worn areas, indices of rolling contact fatigue and repeated rolling beside closed forms."""

from collections.abc import Iterator
from dataclasses import replace

import numpy as np

from flangeway.cases.wheelset.wheelset_case import Wheelset
from flangeway.contact.rolling.exact_rolling import roll
from flangeway.contact.rolling.friction import Friction
from flangeway.contact.rolling.rolling_contact import Creepages
from flangeway.exact import contact_modulus
from flangeway.railway.damage.rolling_fatigue import DangVan, surface_fatigue_index, t_gamma_damage
from flangeway.railway.damage.rolling_plasticity import RollingLine, RollingSteel
from flangeway.railway.damage.wear_laws import ArchardLaw, CellLoads, UsfdLaw, WearLaw, patch_loads, row_wear
from flangeway.railway.damage.worn_surface import WornSurface
from flangeway.railway.track.rolling import RollingMotion
from flangeway.railway.track.wheelset_loads import Curve, Load
from flangeway.railway.track.wheelset_problem import Mesh, Spatial
from flangeway.railway.wheelset.spatial_result import solve_spatial
from flangeway.types import Floats
from flangeway_studies.rolling_cases import STEEL as STEEL_OF_LINES
from flangeway_studies.rolling_cases import line
from flangeway_studies.study import Limit, Row, Run

A_MM, B_MM, FORCE_N, FRICTION, CREEPAGE, SPEED_m_s = 6.0, 4.0, 1e5, 0.3, 0.01, 30.0
"""Hertz's ellipse in full slip, 2 a along rolling."""
HARDNESS_MPa, WEAR_COEFFICIENT = 2700.0, 0.0035
P0_MPa = 1.5 * FORCE_N / (np.pi * A_MM * B_MM)
LAW_LIMIT, ROUND_OFF, POWER_LIMIT = 1e-3, 1e-10, 1e-6
STEEL = RollingSteel(shear_yield_MPa=300.0)
LOADS = (
    (0.0, 3.95, "shakedown", "Melan"),
    (0.0, 4.05, "ratchetting", "Melan"),
    (0.1, 3.45, "shakedown", "Melan"),
    (0.1, 3.70, "ratchetting", "Melan"),
    (0.0, 3.5, "shakedown", "Bhargava et al. (1985)"),
    (0.0, 4.35, "ratchetting", "Bhargava et al. (1985)"),
    (0.0, 5.0, "ratchetting", "Bhargava et al. (1985)"),
)
"""Friction, p0 / k, and what repeated rolling over perfectly plastic steel comes to by whom."""
FIRST_YIELD = 3.107
"""p0 / k at which von Mises' criterion is reached below a line contact without friction."""
CURVE = Wheelset(
    load=Load(curve=Curve(radius_m=600.0, speed_km_h=80.0)),
    rolling=RollingMotion(friction=0.3),
    contact=Spatial(patch_cells=14),
    mesh=Mesh(size_scale=6.0, order=1),
)
"""A wheelset in a curve on coarse meshes; areas and powers are those of its cells whatever the mesh."""

TWIN_DISC_W = {0.2: 1.3, 0.5: 9.2, 1.0: 25.7, 3.0: 102.6, 7.5: 246.0, 10.0: 327.8, 15.0: 492.1, 20.0: 728.4}
"""Frictional heat by the slip in %, of dry discs of wheel steel R8T and rail steel at 1500 MPa and 400 rpm.

Lewis and Dwyer-Joyce (2004, Proc. IMechE J 218, 467-478), table 3, as the README of the public repository
thiernodms/KPFASTSIMUSFD has it."""
DISC_PRESSURE_MPa, DISC_RPM, FULL_SLIP = 1500.0, 400.0, 7.5
DISC_RADIUS_MM, DISC_WIDTH_MM = 23.5, 10.0
"""The usual discs of this machine: what was read has no sizes. Heat over friction force depends on the radius alone."""


def full_slip(n: int = 600, creepage: float = CREEPAGE) -> tuple[CellLoads, Floats]:
    """Cells of the ellipse in full slip, and the distance y of their rows (n,) from the middle."""
    x, y = ((2.0 * np.arange(n) + 1.0 - n) / n * half for half in (A_MM, B_MM))
    pressures = P0_MPa * np.sqrt(np.maximum(1.0 - (x / A_MM) ** 2 - (y[:, None] / B_MM) ** 2, 0.0))
    along = np.zeros((n, n, 2))
    along[..., 1] = 1.0
    slips = creepage * along * (pressures > 0.0)[..., None]
    areas = np.full((n, n), 4.0 * A_MM * B_MM / n**2)
    return CellLoads(pressures, -FRICTION * pressures[..., None] * along, slips, areas, SPEED_m_s), y


def wear_rows() -> Iterator[Row]:
    """Depths of a passage in full slip, volume and T-gamma."""
    cells, y = full_slip()
    row_integral = P0_MPa * np.pi * A_MM / 2.0  # of the pressure along rolling in the middle, N/mm
    width = y[1] - y[0]
    usfd = 5.3e-3 / 7800.0 * FRICTION * CREEPAGE * row_integral
    exact: dict[str, tuple[WearLaw, float]] = {
        "Archard": (
            ArchardLaw(hardness_MPa=HARDNESS_MPa, k=WEAR_COEFFICIENT),
            WEAR_COEFFICIENT / HARDNESS_MPa * CREEPAGE * row_integral,
        ),
        "USFD": (UsfdLaw(), usfd),
    }
    for name, (law, middle) in exact.items():
        depths = (law.rates(cells) * cells.areas).sum(axis=1) / width
        for at in (0.0, 2.0, 3.5):
            value = middle * (1.0 - (at / B_MM) ** 2)
            yield Row(name, f"y = {at:g} mm", "depth of a passage", "mm", np.interp(at, y, depths), value, LAW_LIMIT)
    volume = 1e3 * (exact["Archard"][0].rates(cells) * cells.areas).sum()
    value = 1e3 * WEAR_COEFFICIENT / HARDNESS_MPa * CREEPAGE * FORCE_N
    yield Row("Archard", "full slip", "volume over distance", "mm^3/m", volume, value, LAW_LIMIT)
    yield Row("full slip", "", "T-gamma", "N", cells.t_gamma_N, FRICTION * FORCE_N * CREEPAGE, LAW_LIMIT)
    law = ArchardLaw(hardness_MPa=HARDNESS_MPa)
    for velocity, pressure, k in ((0.1, 0.5, 5.5e-4), (0.45, 0.5, 35e-4), (0.9, 0.5, 5.5e-4), (0.1, 0.9, 350e-4)):
        computed = law.coefficients(np.array([velocity]), np.array([pressure * HARDNESS_MPa]))[0]
        yield Row("Jendel (2002)", f"{velocity:g} m/s, {pressure:g} H", "wear coefficient", "", computed, k, ROUND_OFF)


def fatigue_rows() -> Iterator[Row]:
    """Surface fatigue index, T-gamma damage and Dang Van's stress."""
    for a, b, friction, k, published in (
        (8.6, 6.18, 0.0064, 300.0, -0.3275387327059806),
        (6.0, 4.0, 0.3, 300.0, 0.14920355262768992),
    ):
        index, code = surface_fatigue_index(friction, (a, b), FORCE_N, k), f"a = {a:g}, b = {b:g} mm"
        yield Row("Ekberg et al. (2002)", code, "FI surf", "", index, published, ROUND_OFF)
        exact = friction - k / (1.5 * FORCE_N / (np.pi * a * b))
        yield Row("Hertz", code, "FI surf less friction less k/p0", "", index - exact, 0.0, ROUND_OFF)
    for t_gamma, damage in ((15.0, 0.0), (65.0, 10.0), (175.0, 0.0)):
        net = 1e6 * float(t_gamma_damage(np.array(t_gamma)).net)
        yield Row("Burstow (2004)", f"{t_gamma:g} N", "damage of an axle", "1e-6", net, damage, ROUND_OFF)
    angles = np.linspace(0.0, 2.0 * np.pi, 60, endpoint=False)
    shear, tension, slope = 100.0 * np.cos(angles), 100.0 * np.cos(angles), 0.3
    none = np.zeros_like(angles)
    for code, history, exact in (
        ("alternating shear", (none, none, none, shear, none, none), 100.0),
        ("alternating tension", (tension, none, none, none, none, none), 50.0 + slope * 100.0 / 3.0),
        ("turning shear", (none, none, none, shear, 100.0 * np.sin(angles), none), 100.0),
    ):
        equivalent = DangVan(limit_MPa=200.0, slope=slope).of(np.stack(history, axis=1)[None]).equivalent_MPa[0]
        yield Row("Dang Van", code, "equivalent stress", "MPa", equivalent, exact, 1e-4)


def rolling_rows(run: Run) -> Iterator[Row]:
    """Repeated rolling of a line contact over perfectly plastic steel."""
    stress = np.linalg.norm(RollingLine(load_factor=1.0, friction=0.0, steel=STEEL, cells=20).elastic, axis=2).max()
    yield Row("Melan", "friction 0", "p0/k at first yield", "", (np.sqrt(2.0) / stress), FIRST_YIELD, LAW_LIMIT)
    for friction, factor, state, source in LOADS:
        rolled = RollingLine(load_factor=factor, friction=friction, steel=STEEL, cells=8, depth=1.0).repeated()
        code = f"friction {friction:g}, p0/k = {factor:g}"
        added, limit = rolled.increments[-1], Limit(state, rolled.state == state)
        yield Row(source, code, "plastic strain of the last passage over k/G", "", added, 0.0, limit)
        passages = np.arange(1, len(rolled.increments) + 1)
        run.curve("passages", f"friction {friction:g}", f"p0/k = {factor:g}", passages, rolled.increments, ".-")
    coarse, fine = (
        RollingLine(load_factor=3.5, friction=0.0, steel=STEEL, cells=cells, depth=1.0).repeated(1).residual_MPa
        for cells in (8, 16)
    )
    for number, axis in enumerate(("along", "axial")):
        values = coarse[:, number].min(), fine[:, number].min()
        yield Row("one passage", "p0/k = 3.5, 8 cells for 16", f"residual stress, {axis}", "MPa", *values, 0.03)


def twin_disc_rows(run: Run) -> Iterator[Row]:
    """Heat of two discs that roll with slip, beside the measured one: T-gamma of a line contact times the speed.

    The coefficient of friction is the measured one at 7.5 % of slip, where all of the contact slips.
    """
    modulus = contact_modulus(STEEL_OF_LINES.plane_modulus, STEEL_OF_LINES.plane_modulus)
    contact = line(DISC_PRESSURE_MPa * DISC_RADIUS_MM / modulus, DISC_PRESSURE_MPa, 160)
    speed = 2e-3 * np.pi * DISC_RADIUS_MM * DISC_RPM / 60.0
    force = contact.force / float(contact.grid.widths[0]) * DISC_WIDTH_MM
    friction = TWIN_DISC_W[FULL_SLIP] / (0.01 * FULL_SLIP * force * speed)
    contact = replace(contact, friction=Friction(friction))
    for slip, heat in TWIN_DISC_W.items():
        if slip == FULL_SLIP:
            continue
        rolling = roll(contact, Creepages(0.01 * slip))
        run.check(f"twin discs, {slip:g} %", rolling.status)
        limit = None if slip < 0.5 else 0.35 if slip < 3.0 else 0.12
        note = (
            f"friction {friction:.2f}, measured at {FULL_SLIP:g} %"
            if slip > 1.0
            else "rough discs slip more than smooth ones"
        )
        watts = rolling.t_gamma * force / contact.force * speed
        yield Row(
            "Lewis and Dwyer-Joyce (2004)", f"slip {slip:g} %", "heat of twin discs", "W", watts, heat, limit, note
        )


def wheelset_rows(run: Run) -> Iterator[Row]:
    """T-gamma and worn areas of a wheelset in a curve."""
    for theory in ("fastsim", "exact"):
        result = solve_spatial(CURVE.replaced(rolling={"theory": theory}))
        run.check(f"wheelset in a curve, {theory}", result.status)
        for number, (_, creep) in enumerate(result.rolling, 1):
            t_gamma = patch_loads(creep).t_gamma_N
            error = t_gamma * creep.speed / creep.power_W - 1.0
            quantity = "T-gamma of the cells by power over speed less 1"
            yield Row("curve", f"{theory}, patch {number}", quantity, "", error, 0.0, POWER_LIMIT)
        wheel, rail = result.problem.wheelset.wheel_of("right"), result.problem.track.rail_of("right")
        for row in row_wear(result, {"wheel": UsfdLaw(), "rail": UsfdLaw()}):
            surface = WornSurface(wheel if row.role == "wheel" else rail)
            area = (surface.deposited(row.ends, row.areas) * surface.worn_lengths).sum()
            value = row.areas.sum()
            yield Row("curve", f"{theory}, {row.side} {row.role}", "worn area", "mm^2", area, value, ROUND_OFF)


def rows(run: Run) -> Iterator[Row]:
    """All of it."""
    yield from wear_rows()
    yield from fatigue_rows()
    yield from rolling_rows(run)
    yield from twin_disc_rows(run)
    yield from wheelset_rows(run)
