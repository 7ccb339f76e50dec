"""Creep forces of an ellipse in closed form: Kalker's linear theory, and Polach's."""

from dataclasses import dataclass

import numpy as np

from flangeway.checks import are_finite
from flangeway.contact.rolling.creepages import Creepages
from flangeway.contact.rolling.elliptic_contact import EllipticContact
from flangeway.contact.rolling.rolling_contact import RollingContact
from flangeway.contact.rolling.rolling_result import CreepForces
from flangeway.errors import InputError
from flangeway.solve import Status


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
    return _closed_form("linear theory", contact, motion, ellipse, (x, y, moment), notices)


def polach(contact: RollingContact, motion: Creepages, *, adhesion: float = 1.0, slip: float = 1.0) -> PolachForces:
    """Polach's formula (1999, Vehicle System Dynamics 33 supplement; 2005, Wear 258).

    Range: one patch that is nearly an ellipse, any creepages; the force is within about 5 % of the limit of friction of
    the exact one without spin, and up to 30 % off with the spin of wheel flanges. It has no spin moment: that is 0.

    Parameters
    ----------
    contact, motion
        The patch and its motion.
    adhesion, slip
        Reductions of the initial slope in the areas of stick and slip (2005): ``0 < k_S <= k_A <= 1``; they multiply
        that of `Friction.slope`, which all theories have.

    Raises
    ------
    InputError
        If the motion is a shift, the reductions are not as above, or friction falls with temperature, which needs
        tractions.

    """
    if contact.friction.by_temperature:
        raise InputError(
            "Polach's formula with friction that falls with temperature",
            "a theory with tractions: exact, FASTSIM or FaStrip",
            "take one of these, or let friction fall with the slip velocity",
        )
    if not (are_finite((slip, adhesion), 2) and 0.0 < slip <= adhesion <= 1.0):
        raise InputError(f"adhesion={adhesion}, slip={slip}", "0 < slip <= adhesion <= 1", "exchange or correct them")
    ellipse = EllipticContact.of(contact, motion)
    c, a, b = ellipse.coefficients, ellipse.along, ellipse.across
    creep, lateral = np.hypot(ellipse.xi, ellipse.eta), ellipse.lateral
    whole = np.hypot(ellipse.xi, lateral)
    static, kinetic = (np.broadcast_to(each, contact.grid.widths.shape) for each in contact.friction.limits)
    rows = contact.normal_forces.sum(axis=1)
    share = contact.friction.share(abs(motion.speed) * whole)
    limit = float((kinetic + (static - kinetic) * share) @ rows)
    x = y = work = 0.0
    if whole > 0.0 and limit > 0.0:
        stiffness = np.hypot(c.c11 * ellipse.xi, c.c22 * ellipse.eta) / creep if creep > 0.0 else c.c22
        gradient = np.pi * ellipse.unit * stiffness * whole / (4.0 * limit)
        ahead = adhesion * gradient
        force = -2.0 * limit / np.pi * (ahead / (1.0 + ahead**2) + np.arctan(slip * gradient))
        spread = 1.0 + 6.3 * (1.0 - np.exp(-a / b))
        turning = 8.0 * ellipse.shear * b * np.sqrt(a * b) * c.c23 * abs(lateral) / (3.0 * limit * spread)
        delta = (turning**2 - 1.0) / (turning**2 + 1.0)
        shape = turning * (delta**3 / 3.0 - delta**2 / 2.0 + 1.0 / 6.0) - (1.0 - delta**2) ** 1.5 / 3.0
        by_spin = -9.0 / 16.0 * a * limit * shape * spread
        x = force * ellipse.xi / whole
        y = (force * ellipse.eta - by_spin * ellipse.phi) / whole
        work = -float(force * creep**2 / whole)
    found = _closed_form("Polach", contact, motion, ellipse, (float(x), float(y), 0.0))
    return PolachForces(**vars(found), t_gamma=work)


def _closed_form(
    theory: str,
    contact: RollingContact,
    motion: Creepages,
    ellipse: EllipticContact,
    found: tuple[float, float, float],
    notices: tuple[str, ...] = (),
) -> CreepForces:
    along, across, moment = ellipse.forces(*found).tolist()
    return CreepForces(
        motion=motion,
        along=along,
        across=across,
        moment=moment,
        theory=theory,
        status=Status(True, "closed form", 0),
        notices=(*motion.notices, *contact.notices, *notices),
    )
