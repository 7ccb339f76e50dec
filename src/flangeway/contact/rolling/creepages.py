"""Motion of two bodies over each other: creepages and spin, or a shift."""

from dataclasses import dataclass, replace
from typing import Self

import numpy as np

from flangeway.checks import as_numbers, check_finite
from flangeway.errors import InputError
from flangeway.types import Floats

PERCENT = 0.1
"""Creepage above which a notice is given."""


@dataclass(frozen=True, eq=False)
class Creepages:
    """Rigid slip of the second body on the first one, over the speed of rolling.

    The axes of a patch are t (along the first body's surface across, as the grid's bounds rise), n (outwards from the
    first body into the second one) and z (along), with ``n x t = z``. At the place (s, z) from the patch's origin
    the second body slips on the first one by ``across - spin z`` along t and ``along + spin s`` along z. Kalker's and
    CONTACT's axes for rolling to +z are x = z, y = t and z = -n: their creepages are ``xi = along``, ``eta = across``,
    ``phi = -spin``.

    Parameters
    ----------
    along, across
        Longitudinal and lateral creepage; each a number, or one for each row of cells where contact angles differ.
    spin
        Relative rotation about n over the speed of rolling, per length; again a number, or one for each row.
    speed
        Velocity of the patch along z; negative: it rolls to -z. At 0 the bodies do not roll but shift: along and across
        are then displacements, spin is an angle.

    Raises
    ------
    InputError
        If a value is no finite number.

    """

    along: float | Floats = 0.0
    across: float | Floats = 0.0
    spin: float | Floats = 0.0
    speed: float = 1.0

    def __post_init__(self) -> None:
        for name in ("along", "across", "spin"):
            values = as_numbers("creepages", getattr(self, name))
            if not np.isfinite(values).all() or values.size == 0:
                raise InputError(f"Creepages({name}={getattr(self, name)})", "finite numbers", "correct the value")
        check_finite("Creepages", "speed", self.speed, "a finite speed, 0 for a shift")

    @property
    def rolls(self) -> bool:
        """Whether the bodies roll; otherwise they shift."""
        return self.speed != 0.0

    @property
    def notices(self) -> tuple[str, ...]:
        """What is unusual about the numbers."""
        most = float(max(np.abs(self.along).max(), np.abs(self.across).max()))
        if self.rolls and most > PERCENT:
            return (f"a creepage of {most:g} is above {PERCENT:g}: creepages are ratios, not percent",)
        return ()

    def moved(self, along: float, across: float) -> Self:
        """The same with changes of the creepages."""
        return replace(self, along=self.along + along, across=self.across + across)

    def about(self, s: float, z: float) -> Self:
        """The same motion about a place at (s, z) from the origin, which becomes the origin."""
        return replace(self, along=self.along + self.spin * s, across=self.across - self.spin * z)

    def mean(self, s: Floats, weights: Floats) -> Self:
        """Numbers for all rows at places s with weights whose sum is 1."""
        along, across, spin = (np.broadcast_to(each[:, 0], s.shape) for each in self._rows(len(s)))
        turning = float(spin @ weights)
        ahead = float((along + spin * s) @ weights) - turning * float(s @ weights)
        return replace(self, along=ahead, across=float(across @ weights), spin=turning)

    def rigid(self, s: Floats, z: Floats) -> Floats:
        """Rigid slip (t, z) at places s (n_cells,) and z (n_strips,) from the origin, (n_cells, 2, n_strips)."""
        found = np.empty((len(s), 2, len(z)))
        along, across, spin = self._rows(len(s))
        found[:, 0] = across - spin * z
        found[:, 1] = along + spin * s[:, None]
        return found

    def _rows(self, n_rows: int) -> list[Floats]:
        """Columns of along, across and spin, one number or one for each row of cells; an `InputError` if it is not."""
        found = [
            np.reshape(np.asarray(each, dtype=np.float64), (-1, 1)) for each in (self.along, self.across, self.spin)
        ]
        for values in found:
            if len(values) not in (1, n_rows):
                raise InputError(
                    f"{len(values)} creepages for {n_rows} rows of cells",
                    "one number, or one for each row",
                    "give as many as the grid has cells across",
                )
        return found
