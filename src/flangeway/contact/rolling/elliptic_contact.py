"""What fast theories take of a patch: an ellipse, creepages in Kalker's axes, and creep coefficients."""

from dataclasses import astuple, dataclass
from functools import lru_cache
from pathlib import Path

import numpy as np
from scipy.interpolate import CubicSpline

from flangeway.checks import check_positive
from flangeway.contact.rolling.friction import SlopeReduction
from flangeway.contact.rolling.rolling_contact import Creepages, RollingContact
from flangeway.errors import InputError
from flangeway.types import Floats

# --- Kalker's creep coefficients of the linear theory, from a table of the exact theory without slip.
#
# For creepages so small that nothing slips, on an ellipse with the semi-axes a (along) and b (across), Kalker's axes,
#
#     F_x = -C11 G a b xi,  F_y = -C22 G a b eta - C23 G (a b)^1.5 phi,  M_z = C23 G (a b)^1.5 eta - C33 G (a b)^2 phi.


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


# --- What fast theories take of a patch: an ellipse, and creepages in Kalker's axes.


@dataclass(frozen=True)
class EllipticContact:
    """Ellipse under a Hertzian pressure, creepages of it, and materials.

    Axes are Kalker's: x in the direction of rolling, z into the first body. For rolling to +z they are x = z and y = t
    of `Creepages`, for rolling to -z both are turned over; `direction` is 1 or -1.

    Parameters
    ----------
    along, across
        Semi-axes a and b, those of Hertz's pressure with the second moments of the patch.
    force
        Normal force.
    friction
        Static coefficient of friction, the mean weighted by the normal forces.
    shear, poisson
        Those of two equal bodies: ``2 / G = 1 / G1 + 1 / G2``, ``2 nu / G = nu1 / G1 + nu2 / G2`` (Kalker, 1990, 1.3).
    xi, eta, phi
        Longitudinal, lateral and spin creepage at the centre.
    direction
        Of rolling along z.
    centre
        Length s and z of the centre of pressure from the patch's origin.
    slope, slipping_friction
        Reduction of the initial slope of creep forces, and the mean coefficient at the rigid slip.

    """

    along: float
    across: float
    force: float
    friction: float
    shear: float
    poisson: float
    xi: float
    eta: float
    phi: float
    direction: float
    centre: tuple[float, float]
    slope: SlopeReduction
    slipping_friction: float

    @classmethod
    def of(cls, contact: RollingContact, motion: Creepages) -> "EllipticContact":
        """The ellipse of a patch; creepages of rows are their means weighted by the normal forces.

        Raises
        ------
        InputError
            If the motion is a shift.

        """
        if not motion.rolls:
            raise InputError("a speed of 0", "a speed of rolling", "shift by flangeway.contact.rolling.roll")
        rows, strips = contact.normal_forces.sum(axis=1), contact.normal_forces.sum(axis=0)
        return cls.under(contact, motion, rows, strips)

    @classmethod
    def under(cls, contact: RollingContact, motion: Creepages, rows: Floats, strips: Floats) -> "EllipticContact":
        """As `of` where normal forces of rows (n_cells,) and of strips (n_strips,) have other sums."""
        s, z = contact.places
        total = float(rows.sum())
        s0, z0 = float(rows @ s) / total, float(strips @ z) / total
        a = float(np.sqrt(5.0 * (strips @ (z - z0) ** 2 / total + contact.grid.strip**2 / 12.0)))
        b = float(np.sqrt(5.0 * (rows @ ((s - s0) ** 2 + contact.grid.widths**2 / 12.0) / total)))
        static, kinetic = (
            float(np.broadcast_to(limits, rows.shape) @ rows) / total for limits in contact.friction.limits
        )
        mean = motion.mean(s, rows / total)
        along, across, spin = float(mean.along), float(mean.across), float(mean.spin)
        flexible = [(1.0 + material.poisson) / material.young for material in contact.materials]  # 1 / (2 G)
        poisson = sum(part * material.poisson for part, material in zip(flexible, contact.materials, strict=True))
        direction = float(np.sign(motion.speed))
        return cls(
            a, b, total, static, 1.0 / sum(flexible), poisson / sum(flexible),
            direction * (along + spin * s0), direction * (across - spin * z0), -spin, direction,
            (s0, z0), contact.friction.slope,
            kinetic + (static - kinetic) * float(contact.friction.share(abs(motion.speed) * np.hypot(along, across))),
        )  # fmt: skip

    @property
    def coefficients(self) -> CreepCoefficients:
        """Creep coefficients, times the factor of the slope."""
        unreduced, factor = self._unreduced, self.slope_factor
        return CreepCoefficients(*(factor * coefficient for coefficient in astuple(unreduced)))

    @property
    def slope_factor(self) -> float:
        """Factor of `slope` at these creepages; 1 without friction."""
        limit, c = self.slipping_friction * self.force, self._unreduced
        if limit == 0.0:
            return 1.0
        # pi G a b c s / (4 mu N) with c by the direction of the creepage, and the initial reduction
        steepness = self.slope.initial * float(np.hypot(c.c11 * self.xi, c.c22 * self.lateral))
        return self.slope.factor(np.pi * self.unit * steepness / (4.0 * limit))

    @classmethod
    def slope_of(cls, contact: RollingContact, motion: Creepages) -> float:
        """`slope_factor` of a patch; a shift has that of small creepages."""
        reduction = contact.friction.slope
        if reduction.remaining == 1.0 or not motion.rolls:
            return reduction.initial
        return cls.of(contact, motion).slope_factor

    @property
    def lateral(self) -> float:
        """Polach's lateral creepage: with that of the spin at the leading end, where it is larger."""
        with_spin = self.eta + self.phi * self.along
        return with_spin if abs(with_spin) > abs(self.eta) else self.eta

    @property
    def _unreduced(self) -> CreepCoefficients:
        return creep_coefficients(self.along / self.across, self.poisson)

    @property
    def unit(self) -> float:
        """Force ``G a b`` of linear theory."""
        return self.shear * self.along * self.across

    def forces(self, x: float, y: float, moment: float) -> Floats:
        """Forces along and across and the moment about n, of those in Kalker's axes."""
        along, across = self.direction * x, self.direction * y
        return np.array([along, across, self.centre[0] * along - self.centre[1] * across - moment])
