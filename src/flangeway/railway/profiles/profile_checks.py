"""Checks of measured points: doubled ones are left out, other errors are refused with their line."""

import math

import numpy as np
from numpy.typing import NDArray

from flangeway.errors import InputError
from flangeway.geometry import FloatArray
from flangeway.geometry.arrays import cross_product, norms, step_lengths
from flangeway.railway.profiles.smoothing import MIN_POINTS, noise_um, refuse_few
from flangeway.units import sentence

SAME_MM = 0.01  # neighbours nearer than this are one point given twice
MERGED_NOISES = 8.0
"""Distance over the noise within which neighbours are merged, if most are as near: farther ones are in order."""
MAX_MERGED_MM = 0.25
"""The same at most: the usual spacing of points."""
LENGTHS_MM = (5.0, 1000.0)  # lengths along a profile, for a unit that the file or the user names
USUAL_LENGTHS_MM = (40.0, 500.0)  # lengths along a profile, for a unit that is assumed

UNITS_TO_GUESS = {"in": 25.4, "m": 1000.0, "cm": 10.0}

MAX_GAP_MM = 25.0
_SMALL_GAP_MM = 5.0
_TURN_OVER_GAP_DEG = 12.0
_FOLD_DEG = 100.0
_MAX_FOLD_MM = 1.0
_MAX_FOLDED = 20
_HOOK = 3  # points at the end of a file that may be a stray stroke
_OUTLIER_UM = 100.0
MAX_OUTLIERS = 0.05  # part of the points that may be off the curve

Lines = NDArray[np.int64]


def checked_points(points: FloatArray, lines: Lines, *, unit_is_sure: bool) -> tuple[FloatArray, Lines, list[str]]:
    """Return the points (n, 2) in mm that can be used, their lines (n,), and a notice of what was left out or bridged.

    An `InputError` if there are too few points, the length is no profile's, points are out of order, many are off the
    curve, or a part is missing.

    - `points`: points (n, 2) in mm, in the order of the file.
    - `lines`: line of the file of each.
    - `unit_is_sure`: whether the unit was named; lengths of a profile in an assumed unit have to be usual ones.
    """
    refuse_few(points)
    refuse_length(points, unit_is_sure)
    notices: list[str] = []
    for repaired in (_merged, _without_outliers, _without_folds):
        points, lines, more = repaired(points, lines)
        refuse_few(points)
        notices += more
    return points, lines, notices + _gaps(points, lines)


def refuse_length(points: FloatArray, unit_is_sure: bool) -> None:
    """Refuse points (n, 2) in mm along a curve that is far shorter or longer than any rail or wheel.

    An `InputError` if it is; the message names the unit that the file may have.
    """
    low, high = LENGTHS_MM if unit_is_sure else USUAL_LENGTHS_MM
    # noise lengthens the path of dense points, the box does not
    size = float(norms(np.ptp(points, axis=0)))
    path = float(step_lengths(points).sum())
    if not (0.5 * low <= size and path >= low and size <= high):
        # the unit that makes it about as long as heads and treads are
        guess = min(UNITS_TO_GUESS, key=lambda unit: abs(math.log(max(path, 1e-9) * UNITS_TO_GUESS[unit] / 150.0)))
        fits = not unit_is_sure and 40.0 <= path * UNITS_TO_GUESS[guess] <= high
        advice = (
            f"is its unit {guess}? Then give --unit {guess}" if fits else "check the unit, --unit mm if it is right"
        )
        raise InputError(
            sentence("a profile of {:.4g mm} along its curve", path),
            sentence("{:g (mm)} to {:g mm}", low, high),
            "check the numbers and the unit that is named" if unit_is_sure else advice,
        )


def _merged(points: FloatArray, lines: Lines) -> tuple[FloatArray, Lines, list[str]]:
    """Take means of points given twice, and of points denser than their noise, which has no order along the curve."""
    starts = _starts(points, SAME_MM)
    if len(starts) < MIN_POINTS:
        return points[starts], lines[starts], []
    reach = float(np.clip(MERGED_NOISES * 1e-3 * noise_um(points[starts]), SAME_MM, MAX_MERGED_MM))
    if float(np.median(step_lengths(points[starts]))) < reach:
        starts = _starts(points, reach)
    else:
        reach = SAME_MM
    n_merged = len(points) - len(starts)
    if not n_merged:
        return points, lines, []
    means = np.add.reduceat(points, starts) / np.diff(np.append(starts, len(points)))[:, None]
    first = lines[np.setdiff1d(np.arange(len(points)), starts)[0]]
    why = " of each other" if reach == SAME_MM else ", denser than their noise,"
    notice = sentence("{} of {} points within {:.2g mm}{} are merged into means", n_merged, len(points), reach, why)
    return means, lines[starts], [sentence("{}, the first in line {}.", notice, first)]


def _starts(points: FloatArray, reach_mm: float) -> NDArray[np.int64]:
    """Numbers of the points (n, 2) that are at least a distance from the start before them."""
    starts = [0]
    places = points.tolist()
    for number, place in enumerate(places):
        if math.dist(place, places[starts[-1]]) >= reach_mm:
            starts.append(number)
    return np.array(starts, dtype=np.int64)


def _outliers(points: FloatArray) -> NDArray[np.int64]:
    """Numbers of single points that stick out of a curve which is smooth without them."""
    before, here, after = points[:-2], points[1:-1], points[2:]
    out = np.zeros(len(points))
    out[1:-1] = _off_line(here, before, after)
    without = np.zeros(len(points))
    # how much the curve bends about the point, seen by the neighbours that pass it over
    without[2:-2] = np.maximum(
        _off_line(points[1:-3], points[:-4], points[3:-1]), _off_line(points[3:-1], points[1:-3], points[4:])
    )
    # where sweeps overlap, the neighbours lie beside each other; that is no outlier but a fold
    steps = step_lengths(points)
    apart = np.zeros(len(points), dtype=np.bool_)
    apart[2:-2] = norms(points[3:-1] - points[1:-3]) > 0.7 * np.minimum(steps[:-3], steps[3:])
    least = 1e-3 * max(_OUTLIER_UM, 10.0 * noise_um(points))
    outliers: NDArray[np.int64] = np.flatnonzero((out > least) & (out > 6.0 * without) & apart)
    return outliers


def _off_line(points: FloatArray, starts: FloatArray, ends: FloatArray) -> FloatArray:
    """Distances (n,) of points from the lines through two others each."""
    along = ends - starts
    apart = points - starts
    length = np.maximum(norms(along), 1e-12)
    distances: FloatArray = np.abs(cross_product(along, apart)) / length
    return distances


def _without_outliers(points: FloatArray, lines: Lines) -> tuple[FloatArray, Lines, list[str]]:
    outliers = _outliers(points)
    if not len(outliers):
        return points, lines, []
    what = sentence("line {}: the point {:.6g mm}", lines[outliers[0]], tuple(points[outliers[0]]))
    if len(outliers) > MAX_OUTLIERS * len(points):
        raise InputError(
            f"{len(outliers)} points off the curve, the first in " + what, "a smooth curve", "measure again"
        )
    kept = np.setdiff1d(np.arange(len(points)), outliers)
    return (
        points[kept],
        lines[kept],
        [sentence("{} of {} points off the curve are left out, the first in {}.", len(outliers), len(points), what)],
    )


def _without_folds(points: FloatArray, lines: Lines) -> tuple[FloatArray, Lines, list[str]]:
    """Leave out points that go back a little, as where two sweeps of an instrument overlap; refuse larger folds."""
    kept = [0, 1]
    dropped = []
    for i in range(2, len(points)):
        last = points[kept[-1]]
        turn = float(_turns_deg((last - points[kept[-2]])[None], (points[i] - last)[None])[0])
        if turn <= _FOLD_DEG:
            kept.append(i)
            continue
        dropped.append(i)
        if len(points) - i <= _HOOK:
            notice = (
                f"The last {len(points) - i} of {len(points)} points turn back and are left out, from line {lines[i]}."
            )
            return points[kept], lines[kept], [notice]
        if math.dist(points[i], last) > _MAX_FOLD_MM or len(dropped) > _MAX_FOLDED:
            raise InputError(
                sentence("line {}: the points turn back at {:.6g mm}", lines[i], tuple(last)),
                sentence("points in order along the profile, or overlaps up to {:g mm}", _MAX_FOLD_MM),
                "sort the points along the profile, or remove those that are wrong",
            )
    if not dropped:
        return points, lines, []
    place = sentence("line {} at {:.6g mm}", lines[dropped[0]], tuple(points[dropped[0]]))
    return (
        points[kept],
        lines[kept],
        [sentence("{} of {} points that go back are left out, the first in {}.", len(dropped), len(points), place)],
    )


def _gaps(points: FloatArray, lines: Lines) -> list[str]:
    """Refuse missing parts where the profile turns; return notices of those that are bridged."""
    steps = np.diff(points, axis=0)
    lengths = norms(steps)
    wide = np.flatnonzero(lengths > max(_SMALL_GAP_MM, 8.0 * float(np.median(lengths))))
    notices = []
    for i in wide.tolist():
        both = tuple(points[i]), tuple(points[i + 1])
        gap = sentence("gap of {:.3g mm} from {:.5g (mm)} to {:.5g mm}, line {}", lengths[i], *both, lines[i])
        before = points[i] - points[max(i - 4, 0)]
        after = points[min(i + 5, len(points) - 1)] - points[i + 1]
        around = [d for d in (before, after) if norms(d) > 0.0]
        turn = max(float(_turns_deg(steps[i][None], d[None])[0]) for d in around) if around else 180.0
        at_end = len(around) < 2
        if lengths[i] > MAX_GAP_MM or turn > _TURN_OVER_GAP_DEG or at_end:
            raise InputError(
                "a " + gap,
                sentence("gaps up to {:g mm}, and only where the profile is straight", MAX_GAP_MM),
                "measure it again",
            )
        notices.append("A " + gap + ", is bridged: the profile is straight there.")
    return notices


def _turns_deg(first: FloatArray, second: FloatArray) -> FloatArray:
    """Angles (n,) between directions (n, 2)."""
    turns: FloatArray = np.degrees(np.abs(np.arctan2(cross_product(first, second), (first * second).sum(axis=1))))
    return turns
