"""Coulomb's friction, constant or falling with the slip velocity."""

from dataclasses import dataclass

import numpy as np

from flangeway.checks import as_numbers, check_finite
from flangeway.errors import InputError
from flangeway.types import Floats

UNUSUAL = 1.0
"""Coefficient above which a notice is given."""


@dataclass(frozen=True, eq=False)
class Friction:
    """Coefficient of friction ``mu(w) = kinetic + (static - kinetic) exp(-w / decay)`` at the slip velocity w.

    The exponential is Polach's (2005, Wear 258, "Creep forces in simulations of traction vehicles running on adhesion
    limit"): his A is kinetic / static, his B is 1 / decay. With ``decay=0`` it is kinetic as soon as surfaces slip.

    Parameters
    ----------
    static
        Coefficient of surfaces that stick, >= 0; a number, or one for each row of cells across. 0 is without friction.
    kinetic
        Coefficient of surfaces that slip fast, from 0 to static; left out: static.
    decay
        Slip velocity in which the difference falls to 1/e, >= 0, in the unit of the speed of rolling.

    Raises
    ------
    InputError
        If a coefficient is negative or no number, or the kinetic one exceeds the static one.

    """

    static: float | Floats
    kinetic: float | Floats | None = None
    decay: float = 0.0

    def __post_init__(self) -> None:
        static, kinetic = self.limits
        sizes = {static.size, kinetic.size} - {1}
        if max(static.ndim, kinetic.ndim) > 1 or 0 in sizes or len(sizes) > 1:
            raise InputError(
                f"coefficients of friction of shapes {static.shape} and {kinetic.shape}",
                "a number, or one for each row of cells across, as many static as kinetic ones",
                "give one for each row; along the patch they do not vary",
            )
        if not (np.isfinite(static).all() and (static >= 0.0).all() and (kinetic >= 0.0).all()):
            raise InputError(
                f"Friction(static={self.static}, kinetic={self.kinetic})",
                "finite coefficients >= 0",
                "give 0 for contact without friction",
            )
        if not (kinetic <= static).all():
            raise InputError(
                f"Friction(static={self.static}, kinetic={self.kinetic})",
                "a kinetic coefficient that is not above the static one",
                "exchange them, or leave the kinetic one out",
            )
        check_finite("Friction", "decay", self.decay)
        if self.decay < 0.0:
            raise InputError(f"Friction(decay={self.decay})", "a slip velocity >= 0", "correct the sign")

    @property
    def limits(self) -> tuple[Floats, Floats]:
        """Static and kinetic coefficients, each one number or one for each row."""
        given = self.static, self.static if self.kinetic is None else self.kinetic
        static, kinetic = (np.atleast_1d(as_numbers("coefficients of friction", each)) for each in given)
        return static, kinetic

    def of_rows(self, rows: slice) -> "Friction":
        """The same on some of the rows of cells."""
        static, kinetic = self.limits
        if max(len(static), len(kinetic)) == 1:
            return self
        static, kinetic = (each if len(each) == 1 else each[rows] for each in (static, kinetic))
        return Friction(static, kinetic, self.decay)

    @property
    def constant(self) -> bool:
        """Whether the coefficient does not depend on the slip velocity."""
        static, kinetic = self.limits
        return bool((static == kinetic).all())

    @property
    def notices(self) -> tuple[str, ...]:
        """What is unusual about the numbers."""
        most = float(self.limits[0].max())
        return (f"a coefficient of friction of {most:g} is above {UNUSUAL:g}",) if most > UNUSUAL else ()

    def coefficients(self, slip_velocities: Floats) -> Floats:
        """Coefficients at slip velocities >= 0, shape (n_cells, n_strips)."""
        static, kinetic = (each[:, None] for each in self.limits)
        if self.decay > 0.0:
            share: Floats = np.exp(-slip_velocities / self.decay)
        else:
            share = np.where(slip_velocities > 0.0, 0.0, 1.0)
        found: Floats = kinetic + (static - kinetic) * share
        return found
