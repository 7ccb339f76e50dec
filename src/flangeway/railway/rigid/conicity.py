"""Equivalent conicity: the cone that makes a free wheelset swing with the same wavelength.

A wheelset that rolls without slip, with small angles, moves after ``y'' = -dr(y) / (e r0)``: dr is the rolling radius
difference, e the distance of the contact points, r0 the nominal radius, the derivatives are by the distance run. For
cones dr is ``2 y tan(gamma)`` and the wavelength that of W. Klingel (1883), ``L = 2 pi sqrt(e r0 / (2 tan(gamma)))``.
The equivalent conicity for an amplitude is the ``tan(gamma)`` whose wavelength is that of the given dr (UIC 519, 2004;
EN 15302). The product ``e r0`` drops out.
"""

import math

import numpy as np
from numpy.typing import ArrayLike
from scipy.optimize import brentq

from flangeway.checks import as_numbers
from flangeway.errors import InputError
from flangeway.railway.rigid.rolling_radii import NO_DIFFERENCE_MM, RollingRadiusDifference
from flangeway.types import Floats

REFERENCE_AMPLITUDE_MM = 3.0
"""Amplitude for which one number is usually given."""


def equivalent_conicity(difference: RollingRadiusDifference, amplitudes_mm: ArrayLike) -> Floats:
    """Equivalent conicity by integration of the wave motion.

    The motion between its ends y1 and y2 has a first integral, ``y'^2 / 2 + S(y) / (e r0)`` with S the integral of the
    difference. So the amplitude fixes both ends, ``y2 - y1 = 2 a`` and ``S(y1) = S(y2)``, and half a wave takes
    ``integral of dy / y'``. With straight pieces of the difference both are exact: jumps, given as two near points, do
    no harm, and no step is chosen.

    Parameters
    ----------
    difference
        Rolling radius difference; it need not be symmetric.
    amplitudes_mm
        Half the width of the motion, > 0, (n,).

    Returns
    -------
    Floats
        ``tan(gamma)`` for each amplitude, (n,); zero where there is no difference, nan where the wheelset does not
        swing about the middle, because the difference pushes it away on the whole.

    Raises
    ------
    InputError
        If an amplitude is not positive, or the motion leaves the range in which the difference is given.

    """
    amplitudes = _checked(amplitudes_mm)
    waves = np.array([_half_wave(difference, float(amplitude)) for amplitude in amplitudes])
    # of a cone: half a wave is pi / sqrt(2 tan)
    return 0.5 * (math.pi / waves) ** 2


def conicity_by_regression(difference: RollingRadiusDifference, amplitudes_mm: ArrayLike) -> Floats:
    """Equivalent conicity as half the slope of the straight line that fits the difference best.

    Least squares over the whole width of the motion, ``-a`` to ``a`` about the place without difference, every lateral
    motion with the same weight; the integrals are exact for straight pieces.

    Parameters
    ----------
    difference
        Rolling radius difference.
    amplitudes_mm
        Half the width of the motion, > 0, (n,).

    Returns
    -------
    Floats
        Half the slopes, (n,).

    Raises
    ------
    InputError
        If an amplitude is not positive, or the width leaves the range in which the difference is given.

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

    Parameters
    ----------
    conicity
        ``tan(gamma)``, > 0.
    contact_distance_mm
        Distance of the two points of contact; 1500 mm for a gauge of 1435 mm.
    radius_mm
        Nominal rolling radius.

    """
    return 2.0 * math.pi * np.sqrt(contact_distance_mm * radius_mm / (2.0 * np.asarray(conicity, dtype=np.float64)))


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


def _half_wave(difference: RollingRadiusDifference, amplitude: float) -> float:
    """Length of half a wave, with e r0 = 1; inf without a difference, nan if it pushes the wheelset away."""
    middle = _middle(difference, amplitude)
    points = _points_between(difference, middle - amplitude, middle + amplitude)
    values, potential = difference(points), difference.integral(points)
    top = 0.5 * (potential[0] + potential[-1])
    if len(points) == 2:
        # one straight piece from end to end: half a period of its own, or rest
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
    """Middle of the motion: where the potential is the same at both of its ends."""

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
    raise InputError(
        f"an amplitude of {amplitude:g} mm",
        f"a motion inside {difference.lateral_mm[0]:g} to {difference.lateral_mm[-1]:g} mm",
        "give the rolling radius difference over a wider range, or a smaller amplitude",
    )
