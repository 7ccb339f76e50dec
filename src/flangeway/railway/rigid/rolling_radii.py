"""The difference of the two wheels' rolling radii as a function of the lateral motion of a wheelset."""

from dataclasses import dataclass
from functools import cached_property
from typing import Self

import numpy as np
from numpy.typing import ArrayLike, NDArray

from flangeway.checks import as_numbers
from flangeway.errors import InputError
from flangeway.railway.rigid.rigid_locus import ContactLocus
from flangeway.types import Floats

NO_DIFFERENCE_MM = 1e-4
"""Difference of rolling radii that counts as none, as between cylinders: below what is measured or published."""


@dataclass(frozen=True, eq=False)
class RollingRadiusDifference:
    """Rolling radius of the right wheel less that of the left one; straight between the given points.

    Parameters
    ----------
    lateral_mm
        Lateral motions to the right, increasing, (n,), n >= 2.
    difference_mm
        Differences there, (n,).

    Raises
    ------
    InputError
        If the arrays differ in length, are too short, not finite, or the motions do not increase.

    """

    lateral_mm: Floats
    difference_mm: Floats

    def __post_init__(self) -> None:
        for name in ("lateral_mm", "difference_mm"):
            array = as_numbers(name, getattr(self, name)).copy()
            array.setflags(write=False)
            object.__setattr__(self, name, array)
        lateral, difference = self.lateral_mm, self.difference_mm
        if lateral.ndim != 1 or lateral.shape != difference.shape or len(lateral) < 2:
            raise InputError(
                f"lateral motions of shape {lateral.shape} and differences of shape {difference.shape}",
                "two arrays of the same length, two or more points",
                "give one difference for each lateral motion",
            )
        if not (np.isfinite(lateral).all() and np.isfinite(difference).all()):
            raise InputError("a rolling radius difference with nan or inf", "finite numbers", "leave such points out")
        if not (np.diff(lateral) > 0.0).all():
            raise InputError(
                "lateral motions that do not increase", "increasing ones", "sort them, and remove what is given twice"
            )

    @classmethod
    def of(cls, locus: ContactLocus) -> Self:
        """Return the rolling radius difference of a contact locus with increasing lateral motions."""
        return cls(locus.lateral_mm, locus.rolling_radius_difference_mm)

    def __call__(self, lateral_mm: ArrayLike) -> Floats:
        """Differences at lateral motions inside the given ones."""
        wanted = np.asarray(lateral_mm, dtype=np.float64)
        self.refuse_outside(wanted)
        return np.interp(wanted, self.lateral_mm, self.difference_mm)

    def refuse_outside(self, lateral_mm: ArrayLike) -> None:
        """Raise an InputError if a lateral motion is outside the given ones."""
        wanted = np.atleast_1d(np.asarray(lateral_mm, dtype=np.float64))
        low, high = self.lateral_mm[[0, -1]]
        slack = 1e-9 * (high - low)
        if ((wanted < low - slack) | (wanted > high + slack)).any():
            raise InputError(
                f"a lateral motion of {wanted[np.argmax(np.abs(wanted))]:g} mm",
                f"{low:g} to {high:g} mm, where the rolling radius difference is given",
                "give the difference over a wider range, or ask for a smaller motion",
            )

    @cached_property
    def integral_mm2(self) -> Floats:
        """Integral of the difference from the first point to each point, exact for straight pieces, (n,)."""
        steps = np.diff(self.lateral_mm)
        means = 0.5 * (self.difference_mm[1:] + self.difference_mm[:-1])
        return np.concatenate(([0.0], np.cumsum(steps * means)))

    def integral(self, lateral_mm: ArrayLike) -> Floats:
        """Integral of the difference from the first point to lateral motions."""
        wanted = np.asarray(lateral_mm, dtype=np.float64)
        self.refuse_outside(wanted)
        piece = np.clip(np.searchsorted(self.lateral_mm, wanted, side="right") - 1, 0, len(self.lateral_mm) - 2)
        start, difference = self.lateral_mm[piece], self.difference_mm[piece]
        slope = (self.difference_mm[piece + 1] - difference) / (self.lateral_mm[piece + 1] - start)
        step = wanted - start
        value: Floats = self.integral_mm2[piece] + step * (difference + 0.5 * slope * step)
        return value

    @cached_property
    def centred_mm(self) -> float:
        """Lateral motion without a difference of the radii, about which the wheelset swings; the least one if several.

        Raises
        ------
        InputError
            If the difference has no zero at which it grows.

        """
        sides = np.flatnonzero(np.abs(self.difference_mm) > NO_DIFFERENCE_MM)
        signs = self.difference_mm[sides]
        through = np.flatnonzero((signs[:-1] < 0.0) & (signs[1:] > 0.0))
        if not len(through):
            raise InputError(
                "a rolling radius difference that does not grow through zero",
                "a wheelset that steers towards the middle",
                "check the signs: the right wheel's radius less the left one's, lateral motion to the right",
            )
        before, after = sides[through], sides[through + 1]
        # in a stretch without difference its middle
        low = self._at(before, -NO_DIFFERENCE_MM)
        high = self._at(after - 1, NO_DIFFERENCE_MM)
        places = 0.5 * (low + high)
        return float(places[np.argmin(np.abs(places))])

    def _at(self, piece: NDArray[np.int64], difference_mm: float) -> Floats:
        """Lateral motions at which straight pieces have a difference."""
        lateral, given = self.lateral_mm, self.difference_mm
        part = (difference_mm - given[piece]) / (given[piece + 1] - given[piece])
        places: Floats = lateral[piece] + part * (lateral[piece + 1] - lateral[piece])
        return places
