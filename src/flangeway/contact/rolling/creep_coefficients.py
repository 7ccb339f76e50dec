"""Kalker's creep coefficients of the linear theory, from a table of the exact theory without slip.

For creepages so small that nothing slips, on an ellipse with the semi-axes a (along) and b (across), Kalker's axes,

    F_x = -C11 G a b xi,  F_y = -C22 G a b eta - C23 G (a b)^1.5 phi,  M_z = C23 G (a b)^1.5 eta - C33 G (a b)^2 phi.
"""

from dataclasses import dataclass
from functools import lru_cache
from pathlib import Path

import numpy as np
from scipy.interpolate import CubicSpline

from flangeway.checks import check_positive
from flangeway.errors import InputError

TABLE = Path(__file__).with_name("creep_coefficients.csv")


@dataclass(frozen=True)
class CreepCoefficients:
    """C11, C22, C23 and C33 for one ratio a/b and one Poisson's ratio."""

    c11: float
    c22: float
    c23: float
    c33: float


@lru_cache(maxsize=4096)
def creep_coefficients(ratio: float, poisson: float) -> CreepCoefficients:
    """Coefficients for semi-axes with a ratio a/b (along over across) and Poisson's ratio.

    `TABLE` was computed by `flangeway.contact.rolling.exact_rolling.derivatives` on half-spaces at Poisson's ratios 0,
    1/4 and 1/2, on five or six grids of 24 to 64 cells across the ellipse, extrapolated linearly to cells of no width;
    it is within 1 % of Kalker's (1990, table E.3), which has three digits, mostly within 0.5 %; C23 at a/b = 0.1 and
    nu = 1/2 is 1.1 % less, and stays so on finer grids. Between, logarithms of
    the coefficients are splines of that of a/b, and inverse coefficients parabolas of Poisson's ratio. Beyond the
    table, a/b from 0.05 to 20, the splines' ends are continued straight.

    Raises
    ------
    InputError
        If the ratio is not positive, or Poisson's ratio not from 0 to 1/2.

    """
    check_positive("creep_coefficients", "ratio", ratio)
    if not 0.0 <= poisson <= 0.5:
        raise InputError(f"creep_coefficients(poisson={poisson})", "0 to 0.5", "correct Poisson's ratio")
    spline = _spline()
    x = np.log(ratio)
    inside = float(np.clip(x, *spline.x[[0, -1]]))
    inverse = np.exp(-(spline(inside) + (x - inside) * spline(inside, 1)))
    weights = (
        8.0 * (poisson - 0.25) * (poisson - 0.5),
        -16.0 * poisson * (poisson - 0.5),
        8.0 * poisson * (poisson - 0.25),
    )
    return CreepCoefficients(*(1.0 / np.tensordot(weights, inverse, 1)).tolist())


@lru_cache(maxsize=1)
def _spline() -> CubicSpline:
    """Logarithms of the coefficients (3, 4) by Poisson's ratio and kind, over the logarithm of the ratio."""
    rows = np.loadtxt(TABLE, delimiter=",", skiprows=1)
    return CubicSpline(np.log(rows[::3, 0]), np.log(rows[:, 2:].reshape(-1, 3, 4)), axis=0)
