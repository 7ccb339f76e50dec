"""What the numbers of a file are taken for, points that cannot be used, and how they are smoothed."""

import itertools
import math

import numpy as np
import pytest
from hypothesis import example, given, settings
from hypothesis import strategies as st

from flangeway.errors import InputError
from flangeway.geometry import Contour
from flangeway.geometry.biarcs import biarcs
from flangeway.railway.profiles.bundled import rail, wheel
from flangeway.railway.profiles.orientation import ReadOptions
from flangeway.railway.profiles.profile_file import read_profile
from flangeway.railway.profiles.smoothing import ARC_TOLERANCE_MM, NOISE_UM, noise_um, smoothed

RAW = ReadOptions(smooth_mm=0.0)


def wheel_points(spacing=0.5):
    """S1002 from the flange's back to the rim, in this package's frame."""
    return wheel("S1002").running_surface.sampled(spacing=spacing)


def rail_points(spacing=0.5):
    """A head with a worn gauge side, from the field side to the gauge side, from its top."""
    points = rail("60E1").running_surface.sampled(spacing=spacing) - [0.0, 172.0]
    worn = points[:, 0] < -20.0
    return np.column_stack([points[:, 0] + np.where(worn, 0.1 * (-20.0 - points[:, 0]), 0.0), points[:, 1]])


def saved(folder, points, name="p.txt", head="# unit: mm"):
    np.savetxt(folder / name, points, "%.7f", header=head, comments="")
    return folder / name


@pytest.mark.parametrize("reverse", [False, True])
@pytest.mark.parametrize("up", [1.0, -1.0])
@pytest.mark.parametrize("side", [1.0, -1.0])
def test_wheels_are_turned_by_their_flange(side, up, reverse, tmp_path):
    """However a wheel lies in its file, the flange comes to negative x with its tip down, from back to rim."""
    shown = wheel_points() * [side, up]
    path = saved(tmp_path, shown[::-1] if reverse else shown)
    found = read_profile(path, RAW)
    np.testing.assert_allclose(found.points, wheel_points(), atol=1e-6)
    assert found.orientation.mirrored == (side < 0.0)
    assert found.orientation.upwards == (up > 0.0)
    assert found.orientation.reversed_order == reverse
    assert found.orientation.how["kind"] == "from the shape"


@pytest.mark.parametrize("reverse", [False, True])
@pytest.mark.parametrize("up", [1.0, -1.0])
def test_rails_are_turned_by_their_head(up, reverse, tmp_path):
    """A head's top comes up, its points go from the field side to the gauge side; its side is the file's."""
    shown = rail_points() * [1.0, up]
    found = read_profile(saved(tmp_path, shown[::-1] if reverse else shown), RAW)
    np.testing.assert_allclose(found.points, rail_points(), atol=1e-6)
    assert found.kind == "rail"
    assert found.orientation.how["side"] == "assumed"


def test_mirrored_rails_are_those_of_the_other_side(tmp_path):
    """--mirror, or a comment, reverses the first coordinate of a rail; both together do nothing."""
    shown = rail_points() * [-1.0, 1.0]
    for head, mirror in (("# unit: mm", True), ("# unit: mm\n# mirror", False)):
        found = read_profile(saved(tmp_path, shown, head=head), ReadOptions(mirror=mirror, smooth_mm=0.0))
        np.testing.assert_allclose(found.points, rail_points(), atol=1e-6)
        assert found.orientation.mirrored


@pytest.mark.parametrize(("points", "ending", "kind"), [(wheel_points, "ban", "rail"), (rail_points, "whl", "wheel")])
def test_wheel_and_rail_swapped_are_refused(points, ending, kind, tmp_path):
    """A file whose ending says the other kind than its shape is refused; --kind insists, with a notice."""
    path = saved(tmp_path, points(), f"p.{ending}", head="ColumnDef=X,Y\n")
    with pytest.raises(InputError, match="of the shape of"):
        read_profile(path)
    found = read_profile(path, ReadOptions(kind=kind))
    assert any("nevertheless" in notice for notice in found.notices)


def test_a_shape_that_shows_nothing_needs_the_kind(tmp_path):
    """A straight line is a rail or a wheel only if somebody says so."""
    path = saved(tmp_path, np.column_stack([np.arange(-40.0, 40.0), np.zeros(80)]))
    with pytest.raises(InputError, match="--kind rail or --kind wheel"):
        read_profile(path)
    assert read_profile(path, ReadOptions(kind="rail")).kind == "rail"


@pytest.mark.parametrize(
    ("shift", "origin", "label"),
    [((0.0, 172.0), None, "base"), ((0.0, 0.0), None, "top"), ((36.0, 0.0), None, "gauge"), ((3.0, 9.0), "3,9", "3,9")],
)
def test_origins_of_rails(shift, origin, label, tmp_path):
    """Top, base and gauge face are reported by the numbers; a place in the file becomes the origin if it is given."""
    found = read_profile(saved(tmp_path, rail_points() + shift), ReadOptions(origin=origin, smooth_mm=0.0))
    assert found.orientation.origin == label
    expected = rail_points() + (np.zeros(2) if origin else np.array(shift))
    np.testing.assert_allclose(found.points, expected, atol=1e-6)


def test_origins_of_wheels(tmp_path):
    """From the flange's back, from the tape line, or from a given place: the tread at the tape line becomes (0, 0)."""
    side, up = -1.0, -1.0
    for shift, origin in (((70.0, 0.0), None), ((0.0, 0.0), None), ((70.0, 4.0), None), ((12.0, 5.0), "given")):
        shown = (wheel_points() + shift) * [side, up]
        given = f"{side * shift[0]},{up * shift[1]}" if origin else None
        found = read_profile(saved(tmp_path, shown), ReadOptions(origin=given, smooth_mm=0.0))
        np.testing.assert_allclose(found.points, wheel_points(), atol=2e-4)
        assert any("moved to zero" in notice for notice in found.notices) == (shift[1] == 4.0)


@pytest.mark.parametrize(
    ("options", "message"),
    [
        (ReadOptions(origin="middle"), "--origin middle"),
        (ReadOptions(unit="yard"), "'yard'"),
        (ReadOptions(unit="in"), "--unit in for a file in mm"),
        (ReadOptions(kind="tram"), "--kind tram"),
        (ReadOptions(mirror=True), "--mirror"),  # would bring the flange outside
        (ReadOptions(origin="flange-back", tape_mm=5.0), "tape line 5 mm"),
    ],
)
def test_wrong_options_are_refused(options, message, tmp_path):
    """Options that are unknown, out of range, or against the file are named in the message."""
    with pytest.raises(InputError, match=message):
        read_profile(saved(tmp_path, wheel_points()), options)


@pytest.mark.parametrize(("factor", "unit"), [(1.0 / 25.4, "in"), (0.1, "cm")])
def test_a_file_in_another_unit_than_assumed_is_refused_with_a_guess(factor, unit, tmp_path):
    """Without a named unit, inches, metres and centimetres are no mm: the message guesses the unit; naming it helps."""
    path = saved(tmp_path, wheel_points() * factor, head="#")
    with pytest.raises(InputError, match=f"--unit {unit}"):
        read_profile(path)
    assert read_profile(path, ReadOptions(unit=unit)).kind == "wheel"


def test_doubled_points_are_left_out_with_a_notice(tmp_path):
    """Points given twice change nothing; the notice counts them and names the first line."""
    points = wheel_points()
    found = read_profile(saved(tmp_path, np.repeat(points, [1] * 20 + [3] + [1] * (len(points) - 21), axis=0)), RAW)
    np.testing.assert_allclose(found.points, points, atol=1e-6)
    assert any(notice.startswith("2 of") and "line 23" in notice for notice in found.notices)


def test_points_denser_than_their_noise_are_merged(tmp_path):
    """20,000 points of a scanner, 7 micrometres apart with noise of 10, give the wheel within 10 micrometres."""
    points = wheel_points()
    along = np.linspace(0.0, len(points) - 1.0, 20_000)
    dense = np.stack([np.interp(along, np.arange(len(points)), column) for column in points.T], axis=1)
    dense += 0.01 * np.random.default_rng(4).normal(size=dense.shape)
    found = read_profile(saved(tmp_path, dense))
    assert any("denser than their noise" in notice for notice in found.notices)
    inside = found.surface.sampled(spacing=0.5)[10:-10]
    assert np.abs(wheel("S1002").running_surface.closest(inside)[2]).max() < 0.01


def test_outliers_are_left_out(tmp_path):
    """A point off the curve is left out with a notice of its line, and nothing else; many are refused."""
    points = wheel_points()
    wrong = points.copy()
    wrong[100] += [0.0, 0.8]
    path = saved(tmp_path, wrong)
    found = read_profile(path, ReadOptions(smooth_mm=0.0))
    np.testing.assert_allclose(found.points, np.delete(points, 100, axis=0), atol=1e-6)
    assert any("line 102" in notice for notice in found.notices)
    wrong[20:-20:4] += [0.0, 0.8]
    with pytest.raises(InputError, match=r"off the curve|turn back"):
        read_profile(saved(tmp_path, wrong))


def test_sharp_corners_and_noise_are_no_outliers(tmp_path):
    """A square edge of a rim and noise of 20 micrometres pass the search for outliers."""
    points = np.vstack([wheel_points(), [[60.0, 3.0 + 0.5 * i] for i in range(1, 30)]])
    points += 0.02 * np.random.default_rng(3).normal(size=points.shape)
    assert len(read_profile(saved(tmp_path, points)).points) == len(points)


def test_points_out_of_order_are_refused(tmp_path):
    """Shuffled points, and a stretch that runs backwards, are refused with the line where it begins."""
    points = wheel_points()
    wrong = np.vstack([points[:150], points[180:150:-1], points[181:]])
    with pytest.raises(InputError, match=r"line 15\d: the points turn back|off the curve"):
        read_profile(saved(tmp_path, wrong))
    with pytest.raises(InputError, match=r"turn back|off the curve"):
        read_profile(saved(tmp_path, np.random.default_rng(0).permutation(points)))


def test_small_overlaps_are_left_out(tmp_path):
    """Where two sweeps of an instrument overlap by less than a millimetre, the points that go back are left out."""
    points = wheel_points(0.3)
    doubled = np.vstack([points[:200], points[198:] + np.array([0.0, 0.02])])
    found = read_profile(saved(tmp_path, doubled), RAW)
    assert any("go back" in notice for notice in found.notices)
    assert np.diff(found.points[:, 0]).min() > -1e-9


@pytest.mark.parametrize(
    ("first", "last", "bridged"),
    [(-58.0, -50.0, False), (-35.0, -25.0, False), (5.0, 15.0, True), (-10.0, 40.0, False)],
)
def test_gaps_are_bridged_only_where_the_profile_is_straight(first, last, bridged, tmp_path):
    """A missing centimetre of tread is bridged with a notice; of flange or root, or five of tread, it is refused."""
    points = wheel_points()
    left = points[(points[:, 0] < first) | (points[:, 0] > last)]
    path = saved(tmp_path, left)
    if not bridged:
        with pytest.raises(InputError, match="a gap of"):
            read_profile(path)
        return
    found = read_profile(path, RAW)
    assert any("is bridged" in notice for notice in found.notices)
    assert found.surface.closest(points)[2].max() < 0.05


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
    assert found.maximum_um < 1e-6
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
