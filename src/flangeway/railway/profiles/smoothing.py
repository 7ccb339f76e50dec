"""Points to a smooth curve of arcs, and the parts of a profile that a wheel coming down can touch."""

import math
from dataclasses import dataclass

import numpy as np
from scipy.interpolate import BSpline, make_smoothing_spline

from flangeway.errors import InputError
from flangeway.geometry import Contour, FloatArray, Segment
from flangeway.geometry.arrays import chain_lengths, cross_product, norms, step_lengths
from flangeway.geometry.biarcs import Curve, biarcs
from flangeway.railway.profiles.arc_interpolation import arc_chain
from flangeway.types import Bools, Floats, floats

# --- Points to a smooth curve of arcs. Exact and rounded points, as of drawings, get lines and arcs through or near
# them (`arc_interpolation`), measured ones a smoothing spline on arc length, whose deviation is reported and limited.
#
# Both coordinates are cubic smoothing splines of the length along the chords (C. H. Reinsch, "Smoothing by spline
# functions", Numerische Mathematik 10, 1967). On points a distance h apart such a spline passes waves of angular wave
# number w with the gain 1 / (1 + weight h w^4), so that the weight follows from the wavelength whose height is halved.
# Points that would be moved further than the limit get more weight until they are not.


ARC_TOLERANCE_MM = 2e-4  # maximum distance between the spline and the arcs that replace it

USUAL_WAVELENGTH_MM = 5.0
"""Wavelength that noisy points are smoothed by: about the width of a contact. Very noisy ones need a longer one."""

MAX_USUAL_WAVELENGTH_MM = 20.0  # maximum wavelength by default

CURVATURE_NOISE_PER_MM = 1e-3
"""Noise of the smooth curve's curvature above which the wavelength grows: a quarter of a crown of 10 in."""

WAVELENGTHS_MM = (0.1, 100.0)  # allowed wavelengths
LIMITS_UM = (0.1, 10_000.0)  # allowed limits
NOISE_UM = 0.02  # noise below which no points are smoothed by default
DENSE_MM = 0.6  # spacing up to which waves of noise show, and no waves of the drawn curve
DRAWN_NOISE_UM, ROUNDINGS, MAX_DRAWN_ROUNDING_UM = 0.1, 2.5, 0.3
"""Dense points are drawn, not measured, if their noise is at most the first, and the second times their rounding, which
is at most the third: coarser roundings hide the noise of instruments."""
USUAL_LIMIT_UM = 20.0  # maximum deviation of a point, or six times the noise if that is more, by default

MIN_POINTS = 10
_PIECE_MM = 4.0
_GAIN_INTEGRAL = 0.2777
_N_ROUNDS = 60
_MAX_WEIGHT = 1e3
_N_FOOT_STEPS = 10
_SAME_MM = 1e-9  # neighbours that differ by rounding are one point


@dataclass(frozen=True, eq=False)
class Smoothing:
    """A smooth curve near measured points.

    - `points`: points (n, 2) on the curve that belong to the given ones.
    - `curve`: arcs along the spline, within `ARC_TOLERANCE_MM` of it, in the direction of the points.
    - `deviations_um`: signed distance (n,) of each given point from the curve, positive to the left of its direction.
    - `wavelength_mm`: wavelength whose height is halved; 0 for a curve through all points.
    - `limit_um`: maximum distance that was allowed.
    - `noise_um`: noise of the points, estimated.
    - `n_held`: number of points that were held to the limit.
    """

    points: FloatArray
    curve: Contour
    deviations_um: FloatArray
    wavelength_mm: float
    limit_um: float
    noise_um: float
    n_held: int

    @property
    def rms_um(self) -> float:
        """Root mean square of the deviations."""
        return float(np.sqrt(np.mean(self.deviations_um**2)))

    @property
    def maximum_um(self) -> float:
        """Maximum deviation."""
        return float(np.abs(self.deviations_um).max())


def refuse_few(points: FloatArray) -> None:
    """Refuse fewer points (n, 2) than `MIN_POINTS`, as an `InputError`."""
    if len(points) < MIN_POINTS:
        raise InputError(
            f"{len(points)} points", f"{MIN_POINTS} or more", "give the whole profile; hundreds of points are usual"
        )


def noise_um(points: FloatArray) -> float:
    """Estimate the standard deviation of the noise across a curve from neighbouring points (n, 2) in mm.

    Each point and its four neighbours, less the cubic through them, leave noise alone; the median of all of them is not
    moved by corners or single bad points. Noise that neighbours share is not seen. Points further apart than `DENSE_MM`
    leave joints of the curve too. But of noise, cubics through three of four points are missed by the fourth to one
    side and the other in turn: the product of neighbouring distances is negative for 77 %, its quantile of 60 % is
    -0.144 times the variance.
    """
    if np.median(step_lengths(points)) <= DENSE_MM:
        return _spread_um(points)
    fourth = _differences(points, 4)
    return 1e3 * math.sqrt(max(-float(np.quantile(fourth[1:] * fourth[:-1], 0.6)), 0.0) / 0.144)


def _spread_um(points: FloatArray) -> float:
    """Standard deviation of what is left of five neighbours each by the cubic, from the median of its size."""
    return 1.4826e3 * float(np.median(np.abs(_differences(points, 5))))


def _differences(points: FloatArray, n: int) -> FloatArray:
    """Divided differences across the curve of n neighbours each among points, whose noise is that of the points."""
    rows = np.arange(len(points) - n + 1)[:, None] + np.arange(n)
    local = chain_lengths(points)[rows]
    gaps = local[:, :, None] - local[:, None, :] + np.eye(n)
    weights = 1.0 / gaps.prod(axis=2)
    weights /= np.sqrt((weights**2).sum(axis=1))[:, None]
    along = points[rows[:, -1]] - points[rows[:, 0]]
    across: FloatArray = cross_product(np.einsum("ij,ijk->ik", weights, points[rows]), along) / norms(along)
    return across


def rounding_um(points: FloatArray, unit_mm: float = 1.0) -> float:
    """Return the standard deviation of the rounding of points (n, 2) to decimals of a unit; 0 for six and more."""
    decimals = (n for n in range(6) if np.abs(points - points.round(n)).max() < 1e-9)
    return next((1e3 * unit_mm * 10.0**-n / math.sqrt(12.0) for n in decimals), 0.0)


def _are_measured(points: FloatArray, noise: float, rounding: float) -> bool:
    """Whether dense points (n, 2) have more noise, in waves of up to four mm, than exact or rounded ones."""
    spacing = float(np.median(step_lengths(points)))
    if spacing > DENSE_MM or noise <= NOISE_UM:
        return False
    return max(noise, _spread_um(points[:: max(int(1.0 / spacing), 1)])) > DRAWN_NOISE_UM + ROUNDINGS * min(
        rounding, MAX_DRAWN_ROUNDING_UM
    )


def usual_wavelength_mm(noise_um: float, spacing_mm: float) -> float:
    """Wavelength, in whole mm, at which the noise of the curvature is `CURVATURE_NOISE_PER_MM` at most.

    White noise of standard deviation s on points a distance h apart leaves the smooth curve, whose halved wavelength
    has the wave number k, with a curvature of variance ``s^2 h k^5 / pi`` times the integral of
    ``t^4 / (1 + t^4)^2`` over all t > 0, which is 0.2777.

    - `noise_um`: standard deviation of the noise across the curve.
    - `spacing_mm`: distance of neighbouring points.
    """
    variance = (1e-3 * noise_um) ** 2 * spacing_mm / math.pi * _GAIN_INTEGRAL
    if variance == 0.0:
        return USUAL_WAVELENGTH_MM
    wavelength = 2.0 * math.pi * (variance / CURVATURE_NOISE_PER_MM**2) ** 0.2
    return float(min(max(round(wavelength), USUAL_WAVELENGTH_MM), MAX_USUAL_WAVELENGTH_MM))


def smoothed(
    points: FloatArray,
    wavelength_mm: float | None = None,
    limit_um: float | None = None,
    name: str = "profile",
    rounding: float | None = None,
) -> Smoothing:
    """Return a smooth curve near points (n, 2) in mm.

    An `InputError` if there are fewer than `MIN_POINTS` points, a number is out of range, or the smooth curve meets
    itself.

    - `points`: in order along the profile, neighbours differing.
    - `wavelength_mm`: wavelength whose height is halved; 0 for a curve through all points; None for
      `usual_wavelength_mm` of measured points, and for lines and arcs within the rounding of drawn ones.
    - `limit_um`: maximum deviation of any point; `USUAL_LIMIT_UM` or six times the noise if left out.
    - `name`: name of the segments of the curve.
    - `rounding`: `rounding_um` of the points in their file; that of the points if left out.
    """
    low, high = WAVELENGTHS_MM
    if wavelength_mm is not None and wavelength_mm != 0.0 and not low <= wavelength_mm <= high:
        raise InputError(
            f"--smooth {wavelength_mm:g}",
            f"a wavelength of {low:g} to {high:g} mm, or 0 for none",
            "leave it out",
        )
    low, high = LIMITS_UM
    if limit_um is not None and not low <= limit_um <= high:
        raise InputError(f"--limit {limit_um:g}", f"{low:g} to {high:g} micrometres", "leave it out")
    points = points[np.concatenate(([True], np.diff(chain_lengths(points)) > _SAME_MM))]
    refuse_few(points)
    noise = noise_um(points)
    limit = max(USUAL_LIMIT_UM, 6.0 * noise) if limit_um is None else limit_um
    s = chain_lengths(points)
    wavelength, sigma = wavelength_mm, 0.0
    if wavelength is None:
        rounding = rounding_um(points) if rounding is None else rounding
        measured = _are_measured(points, noise, rounding)
        wavelength = usual_wavelength_mm(noise, float(np.median(np.diff(s)))) if measured else 0.0
        # the lattice of rounded points shows up to three times their noise
        noise = sigma = noise if measured or noise > 3.0 * rounding else rounding
    if wavelength == 0.0:
        chain = arc_chain(points, 1e-3 * sigma)
        curve = _arcs(chain.at, chain.joints, name)
        return Smoothing(chain.points, curve, 1e3 * chain.offsets, 0.0, limit, noise, 0)
    spline, deviations, n_held = _limited_spline(s, points, wavelength, limit)
    derivative = spline.derivative()
    breaks = np.linspace(0.0, s[-1], max(math.ceil(s[-1] / _PIECE_MM), 1) + 1)
    curve = _arcs(lambda t: (spline(t), derivative(t)), breaks, name)
    return Smoothing(spline(s), curve, deviations, wavelength, limit, noise, n_held)


def _arcs(curve: Curve, breaks: FloatArray, name: str) -> Contour:
    segments = biarcs(curve, breaks, ARC_TOLERANCE_MM)
    try:
        return Contour.from_segments(segments, [name] * len(segments))
    except InputError as reason:
        raise InputError(
            "the smooth curve: " + reason.given, "a profile that does not meet itself", "clean the points there"
        ) from reason


def _limited_spline(
    s: FloatArray, points: FloatArray, wavelength: float, limit: float
) -> tuple[BSpline, FloatArray, int]:
    """Return the spline, the deviations in um, and how many points got more weight to keep to the limit."""
    before, after = _extension(s, points, wavelength), _extension(-s[::-1], points[::-1], wavelength)
    all_s = np.concatenate([before[0][::-1], s, -after[0]])
    all_points = np.vstack([before[1][::-1], points, after[1]])
    own_points = slice(len(before[0]), len(before[0]) + len(s))
    # a point represents the length about it, so that dense parts are not smoothed less
    spacing = np.gradient(all_s)
    bending = (wavelength / (2.0 * math.pi)) ** 4
    weight = np.ones(len(all_s))
    held: Bools = np.zeros(len(s), dtype=np.bool_)
    for _ in range(_N_ROUNDS):
        spline = _spline(all_s, all_points, weight * spacing, bending)
        deviations = _distances(spline, s, points)
        excess = np.abs(deviations) / limit
        if excess.max() <= 1.0:
            return spline, deviations, int(held.sum())
        held |= excess > 1.0
        weight[own_points] *= np.where(excess > 1.0, np.minimum(1.5 * excess**2, _MAX_WEIGHT), 1.0)
    worst = int(np.argmax(np.abs(deviations)))
    x, y = points[worst]
    raise InputError(
        f"the point ({x:.6g}, {y:.6g}), which smoothing moves by {abs(deviations[worst]):.3g} micrometres",
        f"up to {limit:.3g} micrometres",
        "raise --limit, lower --smooth, or remove the point",
    )


def _spline(s: FloatArray, points: FloatArray, weight: FloatArray, bending: float) -> BSpline:
    """Return the smoothing spline of both coordinates; older versions of SciPy take one at a time."""
    x, y = (make_smoothing_spline(s, values, w=weight, lam=bending) for values in points.T)
    return BSpline(x.t, np.column_stack([x.c, y.c]), x.k)


def _extension(s: FloatArray, points: FloatArray, wavelength: float) -> tuple[FloatArray, FloatArray]:
    """Return lengths and points before the first, along the parabola of the first ones.

    A smoothing spline is straight at its ends; the ends of the profile shall keep their curvature.
    """
    near = max(int(np.searchsorted(s, s[0] + wavelength)), 6)
    local = s[:near] - s[0]
    shape = np.polynomial.polynomial.polyfit(local, points[:near], 2)
    step = float(np.median(np.diff(s[:near])))
    n_steps = min(max(math.ceil(wavelength / step), 3), 400)
    beyond = -np.linspace(wavelength / n_steps, wavelength, n_steps)
    points_beyond: FloatArray = floats(np.polynomial.polynomial.polyval(beyond, shape)).T
    return floats(s[0] + beyond), points_beyond


def _distances(spline: BSpline, s: FloatArray, points: FloatArray) -> FloatArray:
    """Signed distances (n,) in um of points from the spline over s, positive to its left.

    The foot of each perpendicular is found by Newton's method from the point's own length. Where a step would lead
    away from the point, or past an end, the foot stays where it was.
    """
    velocity, acceleration = spline.derivative(), spline.derivative(2)
    foot = s.copy()
    apart = points - spline(foot)
    for _ in range(_N_FOOT_STEPS):
        tangent = velocity(foot)
        along = (apart * tangent).sum(axis=1)
        speed = (tangent**2).sum(axis=1)
        bent = speed - (apart * acceleration(foot)).sum(axis=1)
        trial = np.clip(foot + along / np.where(bent > 0.1 * speed, bent, speed), s[0], s[-1])
        trial_apart = points - spline(trial)
        nearer = norms(trial_apart) < norms(apart)
        foot, apart = np.where(nearer, trial, foot), np.where(nearer[:, None], trial_apart, apart)
        if not nearer.any():
            break
    tangent = velocity(foot)
    distances: FloatArray = 1e3 * np.copysign(norms(apart), cross_product(tangent, apart))
    return distances


# --- Parts of a profile that a wheel coming down can touch: graphs over the lateral coordinate, between overhangs.


STEEPEST_RAD = math.radians(89.0)
"""Steeper parts of a profile are left out: a wheel that comes from above cannot touch there first."""
MAX_CLIPPED = 0.5
"""Width of a part beyond an overhang relative to that of the running surface, above which it may be a second one."""


def graphs_of(contour: Contour, steepest_rad: float = STEEPEST_RAD) -> list[Floats]:
    """Return the parts of a contour that are less steep than an angle, the widest first; up to 90 degrees x grows.

    Each is a table (n, 5) of its pieces: x and y of the start, angle of the tangent there, curvature, length.
    """
    if contour.ends[1][0] < contour.ends[0][0]:
        contour = contour.reversed()
    runs: list[list[tuple[float, ...]]] = [[]]
    for segment in contour.segments:
        row, reaches_start, reaches_end = _running_part(segment, steepest_rad)
        if not reaches_start:
            runs.append([])
        if row is not None:
            runs[-1].append(row)
        if not reaches_end:
            runs.append([])
    return sorted((np.array(run) for run in runs if run), key=extent, reverse=True)


def extent(rows: Floats) -> float:
    """Return the width in x of such a part."""
    return float(rows[:, 4] @ np.cos(rows[:, 2] + 0.5 * rows[:, 3] * rows[:, 4]))


def _running_part(segment: Segment, steepest_rad: float) -> tuple[tuple[float, ...] | None, bool, bool]:
    """Part of a segment that is not too steep, and whether it reaches the segment's start and end.

    Returned: x, y, angle, curvature and length of the part, or None; two flags.
    """
    tangent = segment.tangent(0.0)[0]
    angle = math.atan2(tangent[1], tangent[0])
    curvature = segment.curvature
    first, last = 0.0, segment.length
    if curvature == 0.0:
        if abs(angle) > steepest_rad:
            return None, False, False
    else:
        # the lengths at which the angle takes both limits; files give arcs shorter than half a turn
        limits = sorted(((-steepest_rad - angle) / curvature, (steepest_rad - angle) / curvature))
        first, last = max(first, limits[0]), min(last, limits[1])
        if last - first < 1e-9 * segment.length:
            return None, False, False
    start = segment.point(first / segment.length)[0]
    row = (float(start[0]), float(start[1]), angle + curvature * first, curvature, last - first)
    return row, first == 0.0, last == segment.length
