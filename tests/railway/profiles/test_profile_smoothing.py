"""Smoothing splines and arcs: what they keep, what they take away, and how far they move points."""

import itertools
import math

import numpy as np
import pytest
from hypothesis import example, given, settings
from hypothesis import strategies as st

from flangeway.errors import InputError
from flangeway.geometry import Contour
from flangeway.railway.profiles.bundled import rail
from flangeway.railway.profiles.smoothing import ARC_TOLERANCE_MM, NOISE_UM, biarcs, noise_um, smoothed


def circle(n, radius=30.0, low=0.2, high=2.9):
    angle = np.linspace(low, high, n)
    return radius * np.column_stack([np.cos(angle), np.sin(angle)])


def noisy(points, noise_mm, seed=1):
    along = np.gradient(points, axis=0)
    normals = np.column_stack([-along[:, 1], along[:, 0]]) / np.hypot(*along.T)[:, None]
    return points + normals * np.random.default_rng(seed).normal(0.0, noise_mm, len(points))[:, None]


def head(spacing=0.3):
    return rail("60E1").running_surface.sampled(spacing=spacing)


@pytest.mark.parametrize(("noise", "n"), [(1e-3, 600), (2e-2, 150)])
def test_noise_is_estimated(noise, n):
    """The noise across a circle is found within 15 %, whatever the spacing of the points."""
    assert noise_um(noisy(circle(n), noise)) == pytest.approx(1e3 * noise, rel=0.15)


def test_exact_points_have_no_noise():
    """A nominal head, written with five decimals, has noise below the smoothing's threshold; with two it has above."""
    points = head()
    assert noise_um(np.round(points, 5)) < NOISE_UM
    assert smoothed(np.round(points, 5)).wavelength_mm == 0.0
    assert noise_um(np.round(points, 2)) > NOISE_UM
    assert smoothed(np.round(points, 2)).wavelength_mm > 0.0


def test_smoothing_brings_points_nearer_to_the_truth():
    """Of 10 micrometres of noise on a circle less than a half is left, ends included, and the radius is there again."""
    points = noisy(circle(300), 0.01)
    found = smoothed(points, 5.0)
    errors = np.hypot(*found.points.T) - 30.0
    assert np.sqrt(np.mean(errors**2)) < 0.005
    assert np.abs(errors).max() < 0.015
    weights = [segment.length for segment in found.curve.segments]
    mean = np.average([segment.curvature for segment in found.curve.segments], weights=weights)
    assert mean == pytest.approx(1.0 / 30.0, rel=0.01)
    assert found.rms_um == pytest.approx(10.0, rel=0.15)


@pytest.mark.parametrize("wavelength", [4.0, 20.0])
def test_a_wave_of_the_wavelength_is_halved(wavelength):
    """Of a wave with the wavelength of smoothing half is left; of one three times as long nearly all."""
    x = np.arange(0.0, 10.0 * wavelength, 0.1)
    for length, gain in ((wavelength, 0.5), (3.0 * wavelength, 1.0 / (1.0 + 3.0**-4))):
        points = np.column_stack([x, 0.01 * np.sin(2.0 * math.pi * x / length)])
        found = smoothed(points, wavelength, 1e4)
        middle = slice(len(x) // 3, 2 * len(x) // 3)
        left = found.points[middle] @ [0.0, 1.0]
        assert np.ptp(left) / np.ptp(points[middle, 1]) == pytest.approx(gain, rel=0.02)


HEAD = head(0.5)


@settings.get_profile("costly")
@given(
    limit=st.floats(1.0, 100.0),
    wavelength=st.floats(0.5, 60.0),
    noise=st.floats(0.0, 0.02),
    seed=st.integers(0, 1000),
    n=st.just(len(HEAD) // 2),
)
@example(limit=1.0, wavelength=1.0, noise=2e-4, seed=391, n=len(HEAD))
@example(limit=21.5, wavelength=20.0, noise=0.02, seed=1, n=len(HEAD))  # feet of perpendiculars a tenth of a mm away
def test_no_point_is_moved_further_than_the_limit(limit, wavelength, noise, seed, n):
    """Whatever wavelength and noise, the maximum deviation reported is within the limit, and it is the true one."""
    points = noisy(HEAD[:n], noise, seed)
    try:
        found = smoothed(points, wavelength, limit)
    except InputError:  # so much noise that the limit leaves a curve that no arcs follow
        found = None
    assert found is not None or noise > 2e-4 * limit
    if found is None:
        return
    assert found.maximum_um <= limit
    distances = 1e3 * found.curve.closest(points)[2]
    apart = 1.02e3 * ARC_TOLERANCE_MM  # the arcs are compared with the spline at many places, but not at all
    assert distances.max() <= limit + apart
    assert np.abs(np.abs(found.deviations_um) - distances).max() < apart


def test_corners_are_held_while_noise_is_smoothed():
    """A long wavelength rounds a small corner by no more than the limit, and says how many points it held."""
    points = noisy(head(), 0.002)
    free, held = smoothed(points, 10.0, 1e4), smoothed(points, 10.0, 15.0)
    assert free.maximum_um > 30.0
    assert free.n_held == 0
    assert held.maximum_um <= 15.0
    assert 0 < held.n_held < len(points) / 2


def test_without_smoothing_the_curve_goes_through_all_points():
    """Wavelength 0 moves nothing, and the arcs pass every point within their tolerance."""
    points = noisy(head(), 0.003)
    found = smoothed(points, 0.0)
    assert found.maximum_um == 0.0
    np.testing.assert_allclose(found.points, points, atol=1e-9)
    assert found.curve.closest(points)[2].max() <= ARC_TOLERANCE_MM * 1.01


def test_biarcs_are_smooth_and_within_their_tolerance():
    """Arcs along an ellipse meet tangentially, within the tolerance; halved lengths have an eighth of the error."""

    def ellipse(t):
        points = np.column_stack([50.0 * np.cos(t), 20.0 * np.sin(t)])
        return points, np.column_stack([-50.0 * np.sin(t), 20.0 * np.cos(t)])

    fine = ellipse(np.linspace(0.0, math.pi, 5001))[0]
    for tolerance in (1e-2, 1e-4, 1e-6):
        segments = biarcs(ellipse, np.array([0.0, 1.0, math.pi]), tolerance)
        chain = Contour.from_segments(segments, ["e"] * len(segments))
        assert chain.closest(fine)[2].max() <= 1.3 * tolerance
        for a, b in itertools.pairwise(segments):
            assert a.tangent(1.0)[0] @ b.tangent(0.0)[0] == pytest.approx(1.0, abs=1e-12)
    errors = []
    for n in (16, 32):
        segments = biarcs(ellipse, np.linspace(0.0, math.pi, n + 1), 1.0)
        errors.append(Contour.from_segments(segments, ["e"] * len(segments)).closest(fine)[2].max())
    assert errors[0] / errors[1] == pytest.approx(8.0, rel=0.25)
