"""Rolling radius difference over the lateral displacement, and the equivalent conicity that follows from it.

A wheelset that rolls without slip, with small angles, moves after ``y'' = -dr(y) / (e r0)``: dr is the rolling radius
difference, e the distance of the contact points, r0 the nominal radius, the derivatives are by the distance run. For
cones dr is ``2 y tan(gamma)`` and the wavelength that of W. Klingel (1883), ``L = 2 pi sqrt(e r0 / (2 tan(gamma)))``.
The equivalent conicity for an amplitude is the ``tan(gamma)`` whose wavelength is that of the given dr (UIC 519, 2004;
EN 15302). The product ``e r0`` drops out.
"""

import math
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path
from typing import Self

import numpy as np
from numpy.typing import ArrayLike
from scipy.interpolate import BSpline, make_interp_spline
from scipy.optimize import brentq

from flangeway.checks import as_numbers
from flangeway.errors import InputError
from flangeway.formats.drawn_section import UNITS_MM
from flangeway.railway.profiles.formats.two_column import read_two_column
from flangeway.railway.rigid.rigid_geometry import ContactLocus
from flangeway.system.file_content import file_content, path_of
from flangeway.types import Floats, Ints, floats

REFERENCE_AMPLITUDE_MM = 3.0  # amplitude for which one number is usually given

NO_DIFFERENCE_MM = 1e-4
"""Difference of rolling radii below which there is none, as between cylinders: less than is measured or published."""

_COLUMNS = (("lateral", "rolling"), ("y", "delta"), ("y", "dr"))  # first words of their names, if there are several
MAX_LATERAL_MM = 50.0  # lateral displacement beyond which a file holds something else, as a profile


@dataclass(frozen=True, eq=False)
class RollingRadiusDifference:
    """Rolling radius of the right wheel less that of the left one; straight between the given points.

    An `InputError` if the arrays differ in length, are too short, not finite, or the displacements do not increase.

    - `lateral_mm`: lateral displacements to the right, increasing, (n,), n >= 2.
    - `difference_mm`: differences there, (n,).
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
                f"lateral displacements of shape {lateral.shape} and differences of shape {difference.shape}",
                "two arrays of the same length, two or more points",
                "give one difference for each lateral displacement",
            )
        if not (np.isfinite(lateral).all() and np.isfinite(difference).all()):
            raise InputError("a rolling radius difference with nan or inf", "finite numbers", "leave such points out")
        if not (np.diff(lateral) > 0.0).all():
            raise InputError("lateral displacements that do not increase", "increasing ones", "sort them, each once")

    @classmethod
    def of(cls, locus: ContactLocus) -> Self:
        """Return the rolling radius difference of a contact locus with increasing lateral displacements."""
        return cls(locus.lateral_mm, locus.rolling_radius_difference_mm)

    def __call__(self, lateral_mm: ArrayLike) -> Floats:
        """Differences at lateral displacements inside the given ones."""
        wanted = floats(lateral_mm)
        self.refuse_outside(wanted)
        return np.interp(wanted, self.lateral_mm, self.difference_mm)

    def refuse_outside(self, lateral_mm: ArrayLike) -> None:
        """Raise an InputError if a lateral displacement is outside the given ones."""
        wanted = np.atleast_1d(floats(lateral_mm))
        low, high = self.lateral_mm[[0, -1]]
        slack = 1e-9 * (high - low)
        if ((wanted < low - slack) | (wanted > high + slack)).any():
            raise InputError(
                f"a lateral displacement of {wanted[np.argmax(np.abs(wanted))]:g} mm",
                f"{low:g} to {high:g} mm, where the rolling radius difference is given",
                "give the difference over a wider range, or ask for a smaller one",
            )

    @cached_property
    def _integral(self) -> BSpline:
        """Integral of the difference from the first point, exact for straight pieces."""
        return make_interp_spline(self.lateral_mm, self.difference_mm, k=1).antiderivative()

    def integral(self, lateral_mm: ArrayLike) -> Floats:
        """Integral of the difference from the first point to lateral displacements."""
        self.refuse_outside(lateral_mm)
        value: Floats = self._integral(np.clip(lateral_mm, *self.lateral_mm[[0, -1]]))
        return value

    @cached_property
    def centred_mm(self) -> float:
        """Lateral displacement without a difference of the radii, about which the wheelset oscillates.

        Of several the one nearest to zero. An `InputError` if the difference has no zero at which it grows.
        """
        sides = np.flatnonzero(np.abs(self.difference_mm) > NO_DIFFERENCE_MM)
        signs = self.difference_mm[sides]
        through = np.flatnonzero((signs[:-1] < 0.0) & (signs[1:] > 0.0))
        if not len(through):
            raise InputError(
                "a rolling radius difference that does not grow through zero",
                "a wheelset that steers towards the middle",
                "check the signs: the right wheel's radius less the left one's, lateral displacement to the right",
            )
        before, after = sides[through], sides[through + 1]
        # in a stretch without difference its middle
        low = self._at(before, -NO_DIFFERENCE_MM)
        high = self._at(after - 1, NO_DIFFERENCE_MM)
        middles = 0.5 * (low + high)
        return float(middles[np.argmin(np.abs(middles))])

    def _at(self, piece: Ints, difference_mm: float) -> Floats:
        """Lateral displacements at which straight pieces have a difference."""
        lateral, given = self.lateral_mm, self.difference_mm
        part = (difference_mm - given[piece]) / (given[piece + 1] - given[piece])
        positions: Floats = lateral[piece] + part * (lateral[piece + 1] - lateral[piece])
        return positions


def read_rolling_radius_difference(file: str | Path, unit: str | None = None) -> RollingRadiusDifference:
    """Read lateral displacements and rolling radius differences from a text file of two columns.

    An `InputError` if the file cannot be read, names no unit, or does not hold a rolling radius difference.

    - `file`: lateral displacement to the right, and radius of the right wheel less that of the left one; separators,
      decimal commas and comments as in profiles of two columns. Rows in either order. Of several columns, as in
      ``table.csv`` of ``flangeway geometry``, those named ``lateral_mm`` and ``rolling_radius_difference_mm``.
    - `unit`: unit of both columns, one of `flangeway.formats.UNITS`; by default what the file
      says in a comment such as ``# unit: mm`` or in the names of its columns such as ``y_mm, delta_r_mm``.
    """
    path = path_of("read_rolling_radius_difference", file)
    try:
        text = file_content(path, "a rolling radius difference").decode("utf-8-sig", "replace")
        table = read_two_column(text, _COLUMNS, "two numbers, lateral displacement and rolling radius difference")
        chosen = table.unit if unit is None else unit
        if chosen not in UNITS_MM:
            raise InputError(
                "no unit of its two columns" if chosen is None else f"unit = {chosen!r}",
                f"one of: {', '.join(UNITS_MM)}",
                "add a line `# unit: mm` at the top, name the columns y_mm and delta_r_mm, or give --set unit=mm",
            )
        rows = table.points * UNITS_MM[chosen]
        if len(rows) and np.abs(rows[:, 0]).max() > MAX_LATERAL_MM:
            raise InputError(
                f"lateral displacements up to {np.abs(rows[:, 0]).max():.4g} mm",
                f"up to {MAX_LATERAL_MM:g} mm: a column of lateral displacements and one of rolling radius differences",
                "check the unit; a profile is given in a case file as wheel or rail",
            )
        return RollingRadiusDifference(*(rows if len(rows) < 2 or rows[0, 0] <= rows[-1, 0] else rows[::-1]).T)
    except InputError as error:
        raise InputError(f"{path}: " + error.given, error.allowed, error.advice) from error


def equivalent_conicity(difference: RollingRadiusDifference, amplitudes_mm: ArrayLike) -> Floats:
    """Equivalent conicity by integration of the kinematic (Klingel) motion.

    The motion between its ends y1 and y2 has a first integral, ``y'^2 / 2 + S(y) / (e r0)`` with S the integral of the
    difference. So the amplitude fixes both ends, ``y2 - y1 = 2 a`` and ``S(y1) = S(y2)``, and half a wave takes
    ``integral of dy / y'``. With straight pieces of the difference both are exact: jumps, given as two near points, do
    no harm, and no step is chosen. Returned: ``tan(gamma)`` for each amplitude, (n,); zero where there is no
    difference, nan where the wheelset does not oscillate about the middle, because the difference pushes it away on the
    whole. An `InputError` if an amplitude is not positive, or the motion leaves the range in which the difference is
    given.

    - `difference`: rolling radius difference; it need not be symmetric.
    - `amplitudes_mm`: half the width of the motion, > 0, (n,).
    """
    amplitudes = _checked(amplitudes_mm)
    middles = motion_middles(difference, amplitudes)
    if np.isnan(middles).any():
        low, high = difference.lateral_mm[[0, -1]]
        raise InputError(
            f"an amplitude of {amplitudes[np.argmax(np.isnan(middles))]:g} mm",
            f"a motion inside {low:g} to {high:g} mm",
            "give the rolling radius difference over a wider range, or a smaller amplitude",
        )
    waves = np.array(
        [_half_wave(difference, *motion) for motion in zip(middles.tolist(), amplitudes.tolist(), strict=True)]
    )
    # of a cone: half a wave is pi / sqrt(2 tan)
    return 0.5 * (math.pi / waves) ** 2


def motion_middles(difference: RollingRadiusDifference, amplitudes_mm: Floats) -> Floats:
    """Middles (n,) of the kinematic motions of amplitudes (n,): the potential is the same at both ends of a motion.

    nan where the motion leaves the range in which the difference is given.
    """
    return np.array([_middle(difference, float(amplitude)) for amplitude in amplitudes_mm])


def conicity_by_regression(difference: RollingRadiusDifference, amplitudes_mm: ArrayLike) -> Floats:
    """Equivalent conicity as half the slope of the straight line that fits the difference best.

    Least squares over the whole width of the motion, ``-a`` to ``a`` about the position without difference, every
    lateral displacement with the same weight; the integrals are exact for straight pieces. Returned: half the slopes,
    (n,). An `InputError` if an amplitude is not positive, or the width leaves the range in which the difference is
    given.

    - `amplitudes_mm`: half the width of the motion, > 0, (n,).
    """
    middle = difference.centred_mm
    slopes = []
    for amplitude in _checked(amplitudes_mm):
        low, high = middle - amplitude, middle + amplitude
        points = _points_between(difference, low, high)
        values = difference(points)
        step, arm = np.diff(points), points - middle
        # Simpson's rule is exact for the product of two straight lines
        halves = 0.25 * (arm[1:] + arm[:-1]) * (values[1:] + values[:-1])
        first_moment = float(step @ (arm[1:] * values[1:] + 4.0 * halves + arm[:-1] * values[:-1])) / 6.0
        slopes.append(first_moment / (2.0 * amplitude**3 / 3.0))
    return 0.5 * np.array(slopes)


def klingel_wavelength(conicity: ArrayLike, contact_distance_mm: float, radius_mm: float) -> Floats:
    """Wavelength of a wheelset of cones in mm (Klingel, 1883).

    - `conicity`: ``tan(gamma)``, > 0.
    - `contact_distance_mm`: distance of the two points of contact; 1500 mm for a gauge of 1435 mm.
    - `radius_mm`: nominal rolling radius.
    """
    return 2.0 * math.pi * np.sqrt(contact_distance_mm * radius_mm / (2.0 * floats(conicity)))


def _checked(amplitudes_mm: ArrayLike) -> Floats:
    amplitudes = np.atleast_1d(as_numbers("amplitudes", amplitudes_mm))
    if not (np.isfinite(amplitudes) & (amplitudes > 0.0)).all():
        raise InputError("an amplitude that is not positive", "amplitudes > 0 in mm", "give 3 for the usual one")
    return amplitudes


def _points_between(difference: RollingRadiusDifference, low: float, high: float) -> Floats:
    """Ends of an interval and the given points inside it, none so near to an end that only rounding parts them."""
    difference.refuse_outside([low, high])
    given, apart = difference.lateral_mm, 1e-9 * (high - low)
    return np.concatenate(([low], given[(given > low + apart) & (given < high - apart)], [high]))


def _half_wave(difference: RollingRadiusDifference, middle: float, amplitude: float) -> float:
    """Length of half a wave, with e r0 = 1; inf without a difference, nan if it pushes the wheelset away."""
    points = _points_between(difference, middle - amplitude, middle + amplitude)
    values, potential = difference(points), difference.integral(points)
    top = 0.5 * (potential[0] + potential[-1])
    if len(points) == 2:
        # one straight piece from end to end: half its period
        slope = float(values[1] - values[0]) / (2.0 * amplitude)
        return math.pi / math.sqrt(slope) if slope > 0.0 else math.inf
    squares = 2.0 * (top - potential[1:-1])
    least = float(squares.min())
    if least < -4.0 * NO_DIFFERENCE_MM * amplitude:
        return math.nan
    if least <= 1e-12 * amplitude * float(np.abs(difference.difference_mm).max()):
        return math.inf
    speed = np.concatenate(([0.0], np.sqrt(squares), [0.0]))
    step = np.diff(points)
    slopes = np.diff(values) / step
    # on a straight piece: step / (mean speed), corrected by the piece's own circular or hyperbolic frequency
    quotient = step / np.maximum(speed[1:] + speed[:-1], 1e-300)
    frequency = np.sqrt(np.abs(slopes))
    argument = frequency * quotient
    with np.errstate(divide="ignore", invalid="ignore"):
        circular, hyperbolic = np.arctan(argument) / argument, np.arctanh(argument) / argument
    factor = np.where(argument < 1e-8, 1.0, np.where(slopes > 0.0, circular, hyperbolic))
    return float(np.sum(2.0 * quotient * factor))


def _middle(difference: RollingRadiusDifference, amplitude: float) -> float:
    """Middle of the motion, nan if it does not stay where the difference is given."""

    def unequal(middle: float) -> float:
        ends = difference.integral(np.array([middle - amplitude, middle + amplitude]))
        return float(ends[1] - ends[0])

    low = difference.lateral_mm[0] + amplitude
    high = difference.lateral_mm[-1] - amplitude
    if low <= high:
        start = min(max(difference.centred_mm, low), high)
        value = unequal(start)
        if value == 0.0:
            return start
        # the ends move towards the side on which the potential is lower
        limit = low if value > 0.0 else high
        for part in np.geomspace(1e-4, 1.0, 24):
            tried = start + float(part) * (limit - start)
            if unequal(tried) * value <= 0.0:
                return float(brentq(unequal, start, tried, xtol=1e-13, rtol=1e-14))
    return math.nan
