"""Limits of repeated rolling with traction: first yield, shakedown, and shakedown with kinematic hardening.

A pressure of Hertz with the maximum p0 and a traction ``mu p`` along the path roll again and again over a half-space
with the shear strength k and nu = 0.3. The limits are values of ``p0 / k``:

- First yield, by von Mises: ``sqrt(J2)`` reaches k. 3.1 (line) and 2.8 (circle) at mu = 0.
- Shakedown of perfectly plastic steel: residual stresses make later passages elastic, as long as the shear stress on
  planes parallel to the surface, in which there is no residual stress, stays below k. 4.0 and 4.7 at mu = 0, and
  ``1 / mu``, flow at the surface, beyond mu = 0.37 (line) or 0.30 (Johnson, 1962; Johnson and Jefferies, 1963, Proc.
  IMechE 177; Johnson, 1985, "Contact Mechanics", 9.2; Ponter, Hearle and Johnson, 1985, J. Mech. Phys. Solids 33). For
  the circle with traction it is a limit of this one mechanism, forward flow.
- Shakedown with kinematic hardening: the stresses of a passage fit at each point into a yield surface of von Mises that
  has moved (Melan, 1938). Beyond it steel yields in each passage, to and fro (plastic shakedown) or forward
  (ratchetting).
"""

from dataclasses import dataclass
from functools import lru_cache
from pathlib import Path
from typing import Literal

import numpy as np
from numpy.typing import ArrayLike

from flangeway.errors import InputError
from flangeway.types import Floats, floats

ABOVE_SHAKEDOWN = "yields"
"""Shakedown state of a patch under which steel yields in each passage."""
TABLE = Path(__file__).with_name("shakedown.csv")


@dataclass(frozen=True, eq=False)
class ShakedownLimits:
    """Values of p0 / k at traction coefficients, each of their shape; see the module."""

    first_yield: Floats
    shakedown: Floats
    hardening: Floats


def shakedown_limits(contact: Literal["line", "point"], traction: ArrayLike) -> ShakedownLimits:
    """Limits of a line contact that rolls across its length, or of a circular (point) contact.

    `TABLE` was computed from the stresses of McEwen (line) and of Love and Cerruti, at the surface of Hamilton and
    Goodman (1966, J. Appl. Mech. 33), within 0.3 %; between, ``k / p0`` is linear.

    Parameters
    ----------
    contact
        ``"line"`` or ``"point"``.
    traction
        Tangential over normal force, 0 to 1.

    Raises
    ------
    InputError
        If a traction coefficient is outside, or the contact another one.

    """
    values = floats(traction)
    if not ((values >= 0.0) & (values <= 1.0)).all():
        raise InputError(f"traction coefficients {values}", "values from 0 to 1", "give tangential over normal force")
    if contact not in ("line", "point"):
        raise InputError(f"shakedown_limits(contact={contact!r})", "line, point", "choose one of them")
    table = _table()
    columns = table[:, 1:4] if contact == "line" else table[:, 4:]
    return ShakedownLimits(*(1.0 / np.interp(values, table[:, 0], 1.0 / column) for column in columns.T))


def shakedown_state(load_factor: float, traction: float) -> str:
    """What a circular patch does to the steel under repeated rolling, in words, by p0 / k and traction coefficient."""
    limits = shakedown_limits("point", min(traction, 1.0))
    if load_factor <= float(limits.first_yield):
        return "elastic"
    if load_factor <= float(limits.shakedown):
        return "shakedown"
    return "hardening" if load_factor <= float(limits.hardening) else ABOVE_SHAKEDOWN


@lru_cache(maxsize=1)
def _table() -> Floats:
    return np.loadtxt(TABLE, delimiter=",", skiprows=1)
