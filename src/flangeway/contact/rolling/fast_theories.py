"""Theories of rolling on an ellipse: linear, Polach, FASTSIM and FaStrip."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from typing import Any, Literal

import numpy as np

from flangeway.checks import are_finite, check_integer
from flangeway.contact.rolling.elliptic_contact import EllipticContact
from flangeway.contact.rolling.friction import Friction
from flangeway.contact.rolling.rolling_contact import NO_CONTACT, SLIPS, STICKS, Creepages, CreepForces, RollingContact
from flangeway.errors import InputError
from flangeway.geometry.arrays import middles_of, quotients
from flangeway.solve import Status
from flangeway.types import Bools, Floats, Ints

# --- Creep forces of an ellipse in closed form: Kalker's linear theory, and Polach's.


@dataclass(frozen=True, eq=False, kw_only=True)
class PolachForces(CreepForces):
    """Creep forces by Polach's formula.

    Parameters
    ----------
    t_gamma
        Energy dissipated over the distance rolled by the force against longitudinal and lateral slip. The force by spin
        does no work here: in linear theory its work is that of the spin moment by lateral slip, with the other sign,
        and the formula has no moment. So it is a lower bound where there is spin.

    """

    t_gamma: float = 0.0


CLOSED_FORM = Status(True, "closed form", 0)


def linear_theory(contact: RollingContact, motion: Creepages) -> CreepForces:
    """Kalker's linear theory (1967, thesis, Delft; 1990, 2.2.3): no slip, forces in proportion to creepages.

    Range: forces up to about a third of the limit of friction, where it is some 20 % too large. A notice is given
    where they exceed the limit; without friction there are none.
    """
    ellipse = EllipticContact.of(contact, motion)
    c, unit = ellipse.coefficients, ellipse.unit
    size = np.sqrt(ellipse.along * ellipse.across)
    x = -c.c11 * unit * ellipse.xi
    y = -unit * (c.c22 * ellipse.eta + c.c23 * size * ellipse.phi)
    moment = unit * size * (c.c23 * ellipse.eta - c.c33 * size * ellipse.phi)
    limit = ellipse.friction * ellipse.force
    beyond = float(np.hypot(x, y))
    notices: tuple[str, ...] = ()
    if limit == 0.0:
        x = y = moment = 0.0
    elif beyond > limit:
        notices = (f"linear theory gives {beyond / limit:.3g} times the limit of friction",)
    common = _resultants("linear theory", contact, motion, ellipse, (x, y, moment), notices)
    return CreepForces(**common, status=CLOSED_FORM)


def polach(contact: RollingContact, motion: Creepages) -> PolachForces:
    """Polach's formula (1999, Vehicle System Dynamics 33 supplement; 2005, Wear 258).

    Range: one patch that is nearly an ellipse, any creepages; the force is within about 5 % of the limit of friction of
    the exact one without spin, and up to 30 % off with the spin of wheel flanges. It has no spin moment: that is 0.

    Parameters
    ----------
    contact, motion
        The patch and its motion.

    Raises
    ------
    InputError
        If the motion is a shift, or friction falls with temperature, which needs tractions.

    """
    if contact.friction.by_temperature:
        raise InputError(
            "Polach's formula with friction that falls with temperature",
            "a theory with tractions: exact, FASTSIM or FaStrip",
            "take one of these, or let friction fall with the slip velocity",
        )
    ellipse = EllipticContact.of(contact, motion)
    c, a, b = ellipse.coefficients, ellipse.along, ellipse.across
    creep, lateral = np.hypot(ellipse.xi, ellipse.eta), ellipse.lateral
    whole = np.hypot(ellipse.xi, lateral)
    static, kinetic = (np.broadcast_to(limits, contact.grid.widths.shape) for limits in contact.friction.limits)
    rows = contact.normal_forces.sum(axis=1)
    share = contact.friction.share(abs(motion.speed) * whole)
    limit = float((kinetic + (static - kinetic) * share) @ rows)
    x = y = work = 0.0
    if whole > 0.0 and limit > 0.0:
        stiffness = np.hypot(c.c11 * ellipse.xi, c.c22 * ellipse.eta) / creep if creep > 0.0 else c.c22
        gradient = np.pi * ellipse.unit * stiffness * whole / (4.0 * limit)
        force = -2.0 * limit / np.pi * (gradient / (1.0 + gradient**2) + np.arctan(gradient))
        spread = 1.0 + 6.3 * (1.0 - np.exp(-a / b))
        turning = 8.0 * ellipse.shear * b * np.sqrt(a * b) * c.c23 * abs(lateral) / (3.0 * limit * spread)
        delta = (turning**2 - 1.0) / (turning**2 + 1.0)
        shape = turning * (delta**3 / 3.0 - delta**2 / 2.0 + 1.0 / 6.0) - (1.0 - delta**2) ** 1.5 / 3.0
        by_spin = -9.0 / 16.0 * a * limit * shape * spread
        x = force * ellipse.xi / whole
        y = (force * ellipse.eta - by_spin * ellipse.phi) / whole
        work = -float(force * creep**2 / whole)
    common = _resultants("Polach", contact, motion, ellipse, (float(x), float(y), 0.0))
    return PolachForces(**common, status=CLOSED_FORM, t_gamma=work)


def _resultants(
    theory: str,
    contact: RollingContact,
    motion: Creepages,
    ellipse: EllipticContact,
    resultant: tuple[float, float, float],
    notices: tuple[str, ...] = (),
) -> dict[str, Any]:
    """What all theories have, by resultants in Kalker's axes: see `CreepForces`."""
    forces = zip(("along", "across", "moment"), ellipse.forces(*resultant).tolist(), strict=True)
    notices = *motion.notices, *contact.notices, *notices
    return {"theory": theory, "motion": motion, "notices": notices, **dict(forces)}


# --- FASTSIM and FaStrip: tractions of an ellipse, strip by strip from the leading to the trailing edge.


STEPS = 30
"""Least number of steps along each strip."""
MIN_FRICTION = 1e-12
"""Coefficient of friction that is none."""


@dataclass(frozen=True, eq=False)
class _Strips:
    """Strips of ellipses, one for each row of cells, with nodes from the leading edge, in Kalker's axes.

    Nodes are close to each other at both ends, as cosines of even angles. Rows beyond an ellipse have strips without
    length. Of m ellipses arrays (..., n) are (..., m, n).

    Parameters
    ----------
    ellipse
        Semi-axes along and across: numbers, or shape (m, 1).
    y, half
        Place across and half length of each strip, (..., n).
    widths
        Widths of the strips, shape (n,).
    x
        Places of the nodes, shape (n_steps + 1, ..., n).

    """

    ellipse: tuple[Floats | float, Floats | float]
    y: Floats
    half: Floats
    widths: Floats
    x: Floats

    @classmethod
    def of(
        cls,
        contact: RollingContact,
        ellipse: tuple[Floats | float, Floats | float],
        y: Floats,
        n_steps: int = STEPS,
    ) -> "_Strips":
        along, across = ellipse
        half = along * np.sqrt(np.maximum(1.0 - (y / across) ** 2, 0.0))
        cosines = np.cos(np.pi * np.arange(n_steps + 1) / n_steps)
        return cls(ellipse, y, half, contact.grid.widths, cosines.reshape(-1, *[1] * y.ndim) * half)

    def pressures(self, force: Floats | float, *, parabolic: bool) -> Floats:
        """Pressures at the nodes, shape as x."""
        along, across = self.ellipse
        share = np.maximum(1.0 - (self.x / along) ** 2 - (self.y / across) ** 2, 0.0)
        return np.asarray(force / (np.pi * along * across) * (2.0 * share if parabolic else 1.5 * np.sqrt(share)))

    def forces(self, tractions: Floats) -> Floats:
        """Forces of the inner nodes by tractions (n_steps + 1, 2, ..., n), which are 0 at both ends."""
        return np.asarray(tractions[1:-1] * ((self.x[:-2] - self.x[2:]) * self.widths / 2.0)[:, None])


@dataclass(frozen=True, eq=False, kw_only=True)
class SimplifiedRolling(CreepForces):
    """Creep forces with fields on the cells of the patch, interpolated along the strips.

    Parameters
    ----------
    contact
        The patch.
    ellipse, strips
        Its ellipse and strips; forces are integrals of the tractions along them.
    nodes
        Tractions and slip over the distance (n_steps + 1, 2, n), and which nodes slip, in Kalker's axes.

    """

    contact: RollingContact
    ellipse: EllipticContact
    strips: _Strips
    nodes: tuple[Floats, Floats, Bools]

    @cached_property
    def tractions(self) -> Floats:
        """As those of `flangeway.contact.rolling.rolling_contact.Rolling`, shape (n_cells, n_strips, 2)."""
        return self._on_cells(self.nodes[0])

    @cached_property
    def slip_velocities(self) -> Floats:
        """Slip of the second body on the first one, shape (n_cells, n_strips, 2)."""
        return abs(self.motion.speed) * self._on_cells(self.nodes[1])

    @cached_property
    def states(self) -> Ints:
        """`NO_CONTACT`, `STICKS` or `SLIPS`, shape (n_cells, n_strips)."""
        position, met = self._places
        near = np.clip(np.rint(position).astype(int), 1, len(self.strips.x) - 2)
        slips = self.nodes[2][near, np.arange(len(near))[:, None]]
        return np.where(met, np.where(slips, SLIPS, STICKS), NO_CONTACT)

    @cached_property
    def t_gamma(self) -> float:
        """Energy dissipated over the distance rolled: tractions times slip of the strips, see `CreepForces.t_gamma`.

        With flexibilities that differ it is not forces times creepages: they bend the rigid slip by spin.
        """
        return float(self._work[-1] @ self.strips.widths)

    @cached_property
    def _work(self) -> Floats:
        """Energy dissipated over the width and the distance rolled from the leading edge to the nodes, shape as theirs.

        With one flexibility the elastic part ``L (T_k + T_(k-1)) (T_k - T_(k-1)) / 2`` of a step sums to zero.
        """
        (tractions, slips, _), x = self.nodes, self.strips.x
        # slip at a node is that of the step before it
        means = middles_of(tractions)
        steps = -np.sum(means * slips[1:], axis=1) * (x[:-1] - x[1:])
        return np.concatenate((np.zeros((1, x.shape[1])), np.cumsum(steps, axis=0)))

    @cached_property
    def power_density(self) -> Floats:
        """Frictional power over area: tractions times slip, means over the cells, whose sum is the power."""
        z, strip = self.contact.places[1], self.contact.grid.strip
        # the ellipse of the moments reaches beyond the grid where the pressures end at its edge: to the cells there
        position, _ = self._places_of(np.concatenate(([-np.inf], z[1:] - strip / 2.0, [np.inf])))
        nodes = np.arange(len(self.strips.x))
        work = np.stack([np.interp(at, nodes, of) for at, of in zip(position, self._work.T, strict=True)])
        return abs(self.motion.speed) * -self.ellipse.direction * np.diff(work, axis=1) / strip

    @cached_property
    def flash_temperatures(self) -> Floats | None:
        """As those of `flangeway.contact.rolling.rolling_contact.Rolling`, by the power of the cells."""
        heating, speed = self.contact.friction.heating, self.motion.speed
        return None if heating is None else heating.rises(self.power_density, self.contact.grid.strip, speed)

    @cached_property
    def _places(self) -> tuple[Floats, Bools]:
        return self._places_of(self.contact.places[1])

    def _places_of(self, z: Floats) -> tuple[Floats, Bools]:
        """Places along z (m,) among the nodes of the strips, and which lie on these, (n, m)."""
        x, half = self.ellipse.direction * (z - self.ellipse.centre[1]), self.strips.half[:, None]
        cosine = np.clip(x / np.where(half > 0.0, half, self.ellipse.along), -1.0, 1.0)
        return np.arccos(cosine) * (len(self.strips.x) - 1) / np.pi, np.abs(x) < half

    def _on_cells(self, values: Floats) -> Floats:
        position, met = self._places
        before = np.clip(position.astype(int), 0, len(self.strips.x) - 2)
        part, rows = (position - before)[..., None], np.arange(len(before))[:, None]
        on_cells = values[before, :, rows] * (1.0 - part) + values[before + 1, :, rows] * part
        return np.asarray(self.ellipse.direction * (on_cells * met[..., None])[..., ::-1])


def fastsim(
    contact: RollingContact,
    motion: Creepages,
    *,
    flexibilities: tuple[float, float, float] | None = None,
    parabolic: bool = True,
    n_steps: int | None = None,
) -> SimplifiedRolling:
    """Kalker's simplified theory (1982, Vehicle System Dynamics 11): displacements in proportion to tractions.

    Range: one patch that is nearly an ellipse, bodies of one material, a spin up to that of wheel flanges. The force is
    then within about 10 % of the limit of friction of the exact one. Where everything slips, different flexibilities
    turn it by some degrees. Friction falls with the rigid slip (Spiryagin, Polach and Cole, 2013), and with the
    temperature by the slip of the steps before.

    Parameters
    ----------
    contact, motion
        The patch and its motion; pressures are replaced by those of an ellipse with the same moments.
    flexibilities
        L1, L2 and L3 (length over stress) for longitudinal creepage, lateral creepage and spin; left out: those with
        the forces of linear theory. One mean of them, three times, makes forces of everything that slips exact.
    parabolic
        Whether the limit of friction is a paraboloid, as in the original, or Hertz's ellipsoid.
    n_steps
        Steps along each strip; left out: 30, or as many as there are strips of cells.

    """
    ellipse = EllipticContact.of(contact, motion)
    if flexibilities is not None and not (are_finite(flexibilities, 3) and min(flexibilities) > 0.0):
        raise InputError(f"flexibilities={flexibilities}", "L1, L2 and L3 > 0", "leave them out for linear theory's")
    strips = _strips_of(contact, ellipse, n_steps)
    pressures = strips.pressures(ellipse.force, parabolic=parabolic)
    softness = np.array(flexibilities or _flexibilities(ellipse))[:, None]
    creepages = ellipse.xi, ellipse.eta, ellipse.phi
    tractions, slips, _ = _traced(strips, creepages, softness, pressures, contact.friction, motion.speed)
    return _record("FASTSIM", contact, motion, (ellipse, strips), (tractions, slips, (slips != 0.0).any(axis=1)))


def fastsim_rows(
    contact: RollingContact,
    ellipses: Sequence[EllipticContact],
    speed: float,
    *,
    parabolic: bool = True,
) -> tuple[Floats, Floats]:
    """Forces of `fastsim` on the rows of cells of a patch for m ellipses with creepages at once.

    Returned: forces along t and z, (m, n_cells, 2), and sums of z times those along t, (m, n_cells), about the patch's
    origin. Rows beyond an ellipse have none.
    """
    names = ("along", "across", "force", "xi", "eta", "phi", "direction")
    a, b, force, *creepages, direction = (
        np.array([[getattr(ellipse, name)] for ellipse in ellipses]) for name in names
    )
    s0, z0 = np.array([ellipse.centre for ellipse in ellipses]).T[..., None]
    strips = _Strips.of(contact, (a, b), direction * (contact.places[0] - s0))
    flexibilities = np.array([_flexibilities(ellipse) for ellipse in ellipses]).T[..., None]
    pressures = strips.pressures(force, parabolic=parabolic)
    tractions, _, _ = _traced(strips, creepages, flexibilities, pressures, contact.friction, speed)
    # F_cm = sum over steps of tractions (n_steps + 1, 2, m, n) and areas
    forces = direction * strips.forces(tractions)
    ahead = np.einsum("kmn,kmn->mn", z0 + direction * strips.x[1:-1], forces[:, 1])
    return forces.sum(axis=0)[::-1].transpose(1, 2, 0), ahead


def fastsim_forces(contact: RollingContact, creepages: Floats) -> Floats:
    """Forces along and across and moments of `fastsim` under Hertz's limit, at many creepages at once, (n, 3) both.

    Rolling to +z; friction has its static coefficient.
    """
    ellipse = EllipticContact.of(contact, Creepages())
    s0, z0 = ellipse.centre
    static = replace(contact, friction=Friction(contact.friction.static))
    moved = [
        replace(ellipse, xi=along + spin * s0, eta=across - spin * z0, phi=-spin)
        for along, across, spin in np.asarray(creepages).tolist()
    ]
    rows, ahead = fastsim_rows(static, moved, 1.0, parabolic=False)
    moments = rows[..., 1] @ contact.places[0] - ahead.sum(axis=1)
    return np.column_stack((rows.sum(axis=1)[:, ::-1], moments))


def fastrip(contact: RollingContact, motion: Creepages, *, n_steps: int | None = None) -> SimplifiedRolling:
    """FaStrip (Sichani, Enblom and Berg, 2016, Vehicle System Dynamics 54): strip theory where it sticks.

    Where strips stick, tractions are those of plane contact in each strip (Kalker, 1967), scaled to linear theory;
    where they slip, they have Hertz's limit and the direction of FASTSIM. Their slip is FASTSIM's, times the factor
    with which they dissipate forces times creepages, as half-spaces of one material do. Range: as FASTSIM, with
    tractions nearer to the exact theory; spin below that at which `psi` is 1, beyond it strips slip as in FASTSIM.
    """
    ellipse = EllipticContact.of(contact, motion)
    strips = _strips_of(contact, ellipse, n_steps)
    c, a, b, nu = ellipse.coefficients, ellipse.along, ellipse.across, ellipse.poisson
    # one flexibility, so that all that slips has its direction
    mean, creepages = a / ellipse.shear * 8.0 / (1.5 * (c.c11 + c.c22)), (ellipse.xi, ellipse.eta, ellipse.phi)
    pressures = strips.pressures(ellipse.force, parabolic=True)
    given = strips, creepages, np.full((3, 1), mean), pressures, contact.friction, motion.speed
    directions, slips, coefficients = _traced(*given)
    pressure = 1.5 * ellipse.force / (np.pi * a * b)
    mu = contact.friction.limits[0]
    unit = ellipse.shear / (2.0 * np.maximum(mu, MIN_FRICTION) * pressure)
    plane = 4.0 * (1.0 - nu) / np.pi**2
    xi, eta = -unit * plane * c.c11 * ellipse.xi, -unit * plane * c.c22 * ellipse.eta
    psi = -unit * 3.0 / np.pi * np.sqrt(a * b) * c.c23 * ellipse.phi
    across = xi - psi * strips.y / a
    rest = 1.0 - psi**2
    turned = np.abs(psi) < 1.0
    rest = np.where(turned, rest, 1.0)
    # half of the length of slip of each strip, at its trailing end
    slip = np.where(turned, (np.sqrt(eta**2 + rest * across**2) + eta * psi) / rest * a / (1.0 - nu), np.inf)
    slip = np.clip(slip, 0.0, strips.half)
    ahead = eta + psi * slip / a
    size = np.maximum(np.hypot(across, ahead), np.finfo(float).tiny)
    whole = np.sqrt(np.maximum(strips.half**2 - strips.x**2, 0.0))
    inner = (strips.half - slip) ** 2 - (strips.x - slip) ** 2
    sticks = ((inner > 0.0) & (slip < strips.half))[:, None]
    inner = np.sqrt(np.maximum(inner, 0.0))
    kappa, lam = across / size, ahead / size
    sticking = np.stack((kappa * (whole - inner), lam * whole - (lam - psi) * inner), axis=1) * (mu * pressure / a)
    limit = coefficients * (pressure / a) * whole
    length = np.linalg.norm(directions, axis=1)
    sliding = directions * quotients(limit, length)[:, None]
    tractions, slips = np.where(sticks, sticking, sliding), np.where(sticks, 0.0, slips)
    rolling = _record("FaStrip", contact, motion, (ellipse, strips), (tractions, slips, ~sticks[:, 0]))
    # FASTSIM's slip has the energy of its own tractions, which end as a parabola; half-spaces dissipate forces times
    # creepages
    dissipated = max(sum(rolling.products(motion.mean(contact.places[0], contact.row_shares))), 0.0)
    scale = dissipated / rolling.t_gamma if rolling.t_gamma > 0.0 else 1.0
    return replace(rolling, nodes=(tractions, scale * slips, ~sticks[:, 0]))


def _strips_of(contact: RollingContact, ellipse: EllipticContact, n_steps: int | None) -> _Strips:
    """Strips of one ellipse, with a number of steps or the usual one."""
    number = max(STEPS, contact.grid.n_strips) if n_steps is None else check_integer("FASTSIM", "n_steps", n_steps, 2)
    y = ellipse.direction * (contact.places[0] - ellipse.centre[0])
    return _Strips.of(contact, (ellipse.along, ellipse.across), y, number)


def _traced(
    strips: _Strips,
    creepages: Sequence[Floats | float],
    flexibilities: Floats,
    pressures: Floats,
    friction: Friction,
    speed: float,
) -> tuple[Floats, Floats, Floats]:
    """Tractions and slip over the distance rolled at the nodes of strips, both (n_steps + 1, 2, ..., n).

    Also the coefficients of friction there, (n_steps + 1, ..., n). Slip at a node is that of the step before it.

    - `creepages`: xi, eta and phi; `flexibilities`: L1, L2 and L3, (3, ..., 1).
    - `pressures`: of the nodes.
    """
    (x, y), (xi, eta, phi), (first, second, third) = (strips.x, strips.y), creepages, flexibilities
    steps = x[:-1] - x[1:]
    change = np.empty((len(steps), 2, *x.shape[1:]))
    change[:, 0] = xi / first - phi * y / third
    change[:, 1] = eta / second + phi * (x[1:] + x[:-1]) / (2.0 * third)
    change *= steps[:, None]
    static, kinetic = friction.limits
    velocities = abs(speed) * np.hypot(xi - phi * y, eta + phi * x)
    heating = friction.heating if friction.by_temperature else None
    limits = (kinetic + (static - kinetic) * friction.share(velocities)) * pressures
    tractions, slips = (np.zeros((len(pressures), 2, *x.shape[1:])) for _ in range(2))
    heat, last = np.zeros(pressures.shape), tractions[0]
    for number, step in enumerate(steps, 1):
        trial = last - change[number - 1]
        length = np.maximum(np.sqrt(trial[0] ** 2 + trial[1] ** 2), 1e-300)
        if heating is not None:
            # heat of this step as of the one before it
            heat[number] = heat[number - 1]
            ahead = np.stack((x[1 : number + 1], x[:number])) - x[number]
            rise = np.sum(heat[1 : number + 1] * heating.warming(ahead, speed), axis=0)
            share = friction.share(velocities[number], rise)
            limits[number] = (kinetic + (static - kinetic) * share) * pressures[number]
        last = trial * np.minimum(limits[number] / length, 1.0)
        slip = (last - trial) * flexibilities[:2]
        tractions[number], slips[number] = last, quotients(slip, step)
        heat[number] = abs(speed) * np.sqrt(np.sum(last**2, axis=0) * np.sum(slips[number] ** 2, axis=0))
    return tractions, slips, quotients(limits, pressures)


def _flexibilities(ellipse: EllipticContact) -> tuple[float, float, float]:
    """Those with the forces of linear theory."""
    c, a, b = ellipse.coefficients, ellipse.along, ellipse.across
    unit = a / ellipse.shear
    spinning = float(np.pi * np.sqrt(a / b) / (4.0 * c.c23))
    return 8.0 * unit / (3.0 * c.c11), 8.0 * unit / (3.0 * c.c22), spinning * unit


def _record(
    theory: str,
    contact: RollingContact,
    motion: Creepages,
    places: tuple[EllipticContact, _Strips],
    nodes: tuple[Floats, Floats, Bools],
) -> SimplifiedRolling:
    """Resultants of tractions, with slip and where strips slip."""
    ellipse, strips = places
    forces, n_steps = strips.forces(nodes[0]), len(strips.x) - 1
    moment = np.sum(strips.x[1:-1] * forces[:, 1] - strips.y * forces[:, 0])
    resultant = float(forces[:, 0].sum()), float(forces[:, 1].sum()), float(moment)
    common = _resultants(theory, contact, motion, ellipse, resultant)
    status = Status(True, f"{np.count_nonzero(strips.half)} strips of {n_steps} steps", n_steps)
    return SimplifiedRolling(**common, status=status, contact=contact, ellipse=ellipse, strips=strips, nodes=nodes)


# --- The theories of rolling with friction by name: the exact one and the fast ones.


Theory = Literal["exact", "fastsim", "fastrip", "polach", "linear"]

FAST: dict[Theory, Callable[[RollingContact, Creepages], CreepForces]] = {
    "fastsim": fastsim,
    "fastrip": fastrip,
    "polach": polach,
    "linear": linear_theory,
}
"""Theories on an ellipse; the exact one is `flangeway.contact.rolling.exact_rolling.roll`."""
TITLES: dict[Theory, str] = {
    "exact": "exact theory",
    "fastsim": "FASTSIM",
    "fastrip": "FaStrip",
    "polach": "Polach",
    "linear": "linear theory",
}
WITH_TRACTIONS: tuple[Theory, ...] = ("exact", "fastsim", "fastrip")
"""Theories that give tractions, slip and states of the cells."""
