"""Profiles of exact or rounded points are read as they were drawn: lines, arcs and joints of the bundled profiles."""

import itertools

import numpy as np
import pytest

from flangeway.cases.rigid_run import GeometryCase, conicities_of
from flangeway.geometry import Contour
from flangeway.railway.profiles.bundled import RAILS, REFERENCE_RAIL, REFERENCE_WHEELS, WHEELS, rail, wheel
from flangeway.railway.profiles.orientation import ReadOptions
from flangeway.railway.profiles.profile_file import read_profile
from flangeway.railway.profiles.smoothing import noise_um, smoothed
from flangeway.railway.rigid.conicity import RollingRadiusDifference

SPACINGS_MM, FEW_MM = (0.25, 1.0, 2.0, 3.0, 5.0, 8.0), (0.25, 2.0, 8.0)
FIRST = ("60E1", "S1002")
"""Profiles that are read at all spacings; the other ones at few."""
KINK_RAD = 2e-4


def drawn(name: str) -> Contour:
    return (rail if name in (*RAILS, REFERENCE_RAIL) else wheel)(name).running_surface


def points_at(contour: Contour, lengths: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Points (n, 2) and curvatures (n,) of lines and arcs at lengths along them."""
    numbers = contour.numbers_at(lengths)
    rows = [
        contour.segments[number].point((length - contour.offsets[number]) / contour.segments[number].length)[0]
        for number, length in zip(numbers, lengths, strict=True)
    ]
    return np.array(rows), np.array([segment.curvature for segment in contour.segments])[numbers]


def every(contour: Contour, spacing: float, phase: float) -> np.ndarray:
    inner = np.arange(phase * spacing, contour.length, spacing)
    return np.unique(np.concatenate(([0.0], inner[inner > 0.02 * spacing], [contour.length])))


def check(contour: Contour, lengths: np.ndarray, read: Contour, allowance_um: float = 0.0) -> None:
    """Half the local sagitta and 2 micrometres; a micrometre on lines that are one spacing away from arcs.

    The local radius is the smallest one in an interval and both beside it, the spacing the largest one of these;
    intervals about corners are left out.
    """
    dense = np.arange(lengths[0], lengths[-1], 0.1)
    points, curvatures = points_at(contour, dense)
    errors = 1e3 * read.closest(points)[2]
    interval = np.clip(np.searchsorted(lengths, dense, side="right") - 1, 0, len(lengths) - 2)
    own = np.zeros(len(lengths) - 1)
    np.maximum.at(own, interval, np.abs(curvatures))
    beside = np.pad(own, 1)
    local = np.maximum.reduce([own, beside[:-2], beside[2:]])
    spacing = np.pad(np.diff(lengths), 1)
    sagitta = 1e3 * np.maximum.reduce([spacing[1:-1], spacing[:-2], spacing[2:]]) ** 2 * local / 8.0
    counted = np.ones(len(dense), dtype=bool)
    for before, after, corner in zip(
        contour.segments[:-1], contour.segments[1:], contour.offsets[1:-1].tolist(), strict=True
    ):
        (a, b), (c, d) = before.tangent(1.0)[0], after.tangent(0.0)[0]
        if abs(np.arctan2(a * d - b * c, a * c + b * d)) > KINK_RAD:
            counted &= np.abs(interval - np.searchsorted(lengths, corner)) > 2
    bound = 0.5 * sagitta[interval] + 2.0 + allowance_um
    assert (errors < bound)[counted].all()
    assert (errors < 1.0 + allowance_um)[counted & (local[interval] == 0.0)].all()


@pytest.mark.parametrize(
    ("name", "spacing", "phase"),
    [
        *((*case, 0.4) for case in itertools.product(FIRST, SPACINGS_MM)),
        ("R-519-H", 8.0, 0.0),
        ("AAR-1B", 8.0, 0.6),
        *(
            pytest.param(name, spacing, phase, marks=pytest.mark.ci)
            for name in (*RAILS, REFERENCE_RAIL, *WHEELS, *REFERENCE_WHEELS)
            for spacing, phase in itertools.product(FEW_MM, (0.0, 0.6))
            if name not in FIRST
        ),
    ],
)
def test_exact_points_are_read_within_half_a_sagitta(name, spacing, phase):
    """Exact points of a bundled profile give its lines and arcs back, whatever their spacing, and no noise."""
    contour = drawn(name)
    lengths = every(contour, spacing, phase)
    points = points_at(contour, lengths)[0]
    found = smoothed(points)
    assert found.wavelength_mm == 0.0
    assert found.noise_um < 0.01
    check(contour, lengths, found.curve)


@pytest.mark.parametrize(("decimals", "spacing"), [(3, 0.5), (3, 3.0), (2, 2.0), (2, 5.0), (1, 5.0)])
def test_rounding_is_noise_of_known_size(decimals, spacing):
    """Points rounded to 3, 2 or 1 decimals: the same bound, and the distance by which rounding displaces."""
    for name in ("60E1", "S1002"):
        contour = drawn(name)
        lengths = every(contour, spacing, 0.7)
        found = smoothed(points_at(contour, lengths)[0].round(decimals))
        assert found.wavelength_mm == 0.0
        check(contour, lengths, found.curve, 1e3 * np.sqrt(0.5) * 10.0**-decimals)


def vertices(n_of_arc: int = 4) -> np.ndarray:
    """The AAR-1B by the ends of its lines, a few points more of its tread, and some of each arc: 28 points for 4."""
    contour = drawn("AAR-1B")
    parts = {"flange_back": n_of_arc + 1, "flange_tip_land": 1, "flange_face_75deg": 1, "tread_1:20": 5, "rim_edge": 3}
    rows = [
        segment.point(np.linspace(0.0, 1.0, parts.get(name, n_of_arc) + 1)[:-1])
        for name, segment in zip(contour.names, contour.segments, strict=True)
    ]
    return np.vstack([*rows, contour.ends[1]])


@pytest.mark.parametrize(("unit", "scale"), [("mm", 1.0), ("in", 25.4)])
@pytest.mark.parametrize("side", [1.0, -1.0])
def test_a_wheel_of_28_points_stays_what_it_is(tmp_path, unit, scale, side):
    """Ends of lines and a few points of arcs, in mm or inches, mirrored or not: the contour to a micrometre."""
    points = vertices()
    assert len(points) == 28
    path = tmp_path / "wheel.txt"
    np.savetxt(path, points * [side / scale, 1.0 / scale], "%.9f")
    read = read_profile(path, ReadOptions(kind="wheel", unit=unit))
    assert 1e3 * drawn("AAR-1B").closest(read.surface.sampled(spacing=0.1))[2].max() < 1.0


@pytest.mark.parametrize("name", ["S1002", "R-519-A"])
def test_points_three_millimetres_apart_have_the_conicity_of_the_profile(tmp_path, name):
    """On 60E1 at amplitudes of 1 to 5 mm, within 2 %."""
    path, conicities, contour = tmp_path / "wheel.txt", [], drawn(name)
    np.savetxt(path, points_at(contour, every(contour, 3.0, 0.4))[0], "%.9f")
    for profile in ({"file": str(path), "unit": "mm", "body": name}, name):
        geometry = GeometryCase(track={"rail": "60E1"}, wheelset={"wheel": profile}).geometry()
        difference = RollingRadiusDifference.of(geometry.locus(np.linspace(-6.0, 6.0, 121)))
        conicities.append(conicities_of(difference, 5.0).integration[5:])
    assert len(conicities[0]) == 41
    np.testing.assert_allclose(*conicities, rtol=0.02)


@pytest.mark.parametrize("decimals", [6, 2])
def test_a_drawn_wheel_stands_in_the_middle_and_runs_as_exact(tmp_path, decimals):
    """28 points, 5 of a tread of 1:20: the rigid wheelset stands in the middle, with the conicity of exact segments."""
    path = tmp_path / "wheel.txt"
    np.savetxt(path, vertices(), f"%.{decimals}f")
    conicities, lateral = [], np.linspace(-6.0, 6.0, 121)
    for profile in ({"file": str(path), "body": "AAR-1B"}, "AAR-1B"):
        case = GeometryCase(track={"rail": "136RE", "gauge_mm": 1600.0}, wheelset={"wheel": profile})
        geometry = case.geometry()
        difference = RollingRadiusDifference.of(geometry.locus(lateral))
        conicities.append(conicities_of(difference, 4.0).integration)
        assert difference.centred_mm == pytest.approx(0.0, abs=1e-6)
    assert len(conicities[0]) > 20
    np.testing.assert_allclose(*conicities, rtol=0.02)


@pytest.mark.parametrize(("spacing", "noise"), [(0.25, 3e-3), (1.0, 0.01), (2.0, 0.02)])
def test_noise_of_measured_points_is_seen_at_any_spacing(spacing, noise):
    """White noise on a crown of 300 mm is estimated within a third; dense points with it are smoothed as measured."""
    random = np.random.default_rng(4)
    angles = np.arange(-0.35, 0.35, spacing / 300.0)
    radii = 300.0 + noise * random.normal(size=len(angles))
    points = radii[:, None] * np.column_stack((np.sin(angles), np.cos(angles)))
    assert noise_um(points) == pytest.approx(1e3 * noise, rel=0.33)
    found = smoothed(points)
    assert (found.wavelength_mm > 0.0) == (spacing == 0.25)
    assert found.noise_um == noise_um(points)
    assert np.abs(np.hypot(*found.curve.sampled(spacing=1.0).T) - 300.0)[5:-5].max() < 2.0 * noise
