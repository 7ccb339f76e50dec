"""Whole wheels as bodies of revolution beside plane rings, plates and the prism; axles beside beams."""

from dataclasses import replace
from functools import cache as kept

import numpy as np
import pytest

from flangeway.elements import Lagrange
from flangeway.geometry import rectangle
from flangeway.materials import Elastic
from flangeway.mesh import Refinement, triangulate
from flangeway.problems import Elasticity, Harmonic
from flangeway.railway.profiles.bundled import WHEELS, WheelProfile, wheel
from flangeway.railway.profiles.formats.instrument_files import write_segment_csv
from flangeway.railway.profiles.joining import whole_profile
from flangeway.railway.profiles.profile_file import read_profile
from flangeway.railway.track.supports import ElasticAxle, WholeWheel
from flangeway.railway.wheelset.whole_wheel import revolved, wheel_correction, whole_wheel
from flangeway.solve import SurfaceCells
from flangeway.space import Space

YOUNG, RADIUS = 210e3, 460.0
N, Z = 1, 2  # axes of a cell


def cells_of(profile: WheelProfile, low: float, high: float, count: int, poisson: float = 0.3) -> SurfaceCells:
    """Cells of the prism of a profile, held at its cut, between two places x of the running surface."""
    points = profile.running_surface.sampled(spacing=0.5)
    points = points[(points[:, 0] >= low) & (points[:, 0] <= high)]
    edge = min((high - low) / count / 3.0, 2.5)
    mesh = triangulate(profile.outline, size=10.0, refinements=[Refinement(points, edge, 0.3)])
    chain = mesh.chain(*profile.running_names).astype(np.int64)
    places = mesh.points[chain]
    lengths = np.concatenate(([0.0], np.cumsum(np.linalg.norm(np.diff(places, axis=0), axis=1))))
    first, last = np.interp([low, high], places[:, 0], lengths)
    problem = Harmonic(Elasticity(Space(mesh, Lagrange(2)), Elastic(YOUNG, poisson)), held={"cut": "xyz"})
    return SurfaceCells(problem, np.stack((chain[:-1], chain[1:]), axis=1), np.linspace(first, last, count + 1))


def plain(width: float, height: float) -> WheelProfile:
    """A straight running surface on a rectangle."""
    outline = rectangle(width, height, (0.0, height / 2.0))
    names = {"bottom": "running", "right": "outer_face", "top": "cut", "left": "back_face"}
    outline = replace(outline, names=tuple(names[name] for name in outline.names))
    return WheelProfile("plain", outline, ("running",), 0.0, width / 2.0, "", "")


@kept
def s1002() -> tuple[WheelProfile, SurfaceCells]:
    """The whole wheel S1002 of 920 mm, and four cells on the tread of its rim."""
    profile = wheel("S1002")
    return whole_wheel(profile, RADIUS), cells_of(profile, -10.0, 10.0, 4)


@kept
def correction() -> np.ndarray:
    """What the whole wheel S1002 gives more than the prism of its rim."""
    return wheel_correction(s1002()[0], RADIUS, s1002()[1])


def ring_compliance(waves: float, bore: float, radius: float, *, curved: bool = True) -> np.ndarray:
    """Displacements by unit forces per radian at the edge of a plane ring without Poisson's effect, by collocation.

    Radial and around, for n waves around, held at the bore; not curved: of a layer of the same height under n / radius
    waves per length, forces per length.
    """
    m = 28
    t = np.cos(np.pi * np.arange(m) / (m - 1))
    weights = np.where((np.arange(m) == 0) | (np.arange(m) == m - 1), 2.0, 1.0) * (-1.0) ** np.arange(m)
    apart = t[:, None] - t + np.eye(m)
    d = np.outer(weights, 1.0 / weights) / apart
    d -= np.diag(d.sum(axis=1))
    d *= 2.0 / (radius - bore)
    r = bore + (radius - bore) * (1.0 + t) / 2.0  # the first one is the edge, the last one the bore
    over = np.diag(1.0 / r) if curved else np.zeros((m, m))
    k = np.diag(waves / r) if curved else waves / radius * np.eye(m)
    zero, one = np.zeros((m, m)), np.eye(m)
    u, v = np.hstack((one, zero)), np.hstack((zero, one))
    radial, around = YOUNG * d @ u, YOUNG * (over @ u + k @ v)
    shear = YOUNG / 2.0 * ((d - over) @ v - k @ u)
    first = d @ radial + over @ (radial - around) + k @ shear
    second = d @ shear - k @ around + 2.0 * over @ shear
    first[0], first[-1], second[0], second[-1] = radial[0], u[-1], shear[0], v[-1]
    loads = np.zeros((2 * m, 2))
    loads[0, 0] = loads[m, 1] = 1.0 / (radius if curved else 1.0)
    return np.linalg.solve(np.vstack((first, second)), loads)[[0, m]]


@pytest.mark.parametrize("waves", [0, 1, 40])
def test_a_ring_under_waves_is_that_of_plane_elasticity(waves) -> None:
    """Radial and circumferential compliance of a ring of 20 mm loaded over its width, nu = 0, to 2e-4."""
    cells = cells_of(plain(20.0, 60.0), -10.0, 10.0, 1, poisson=0.0)
    found = revolved(plain(20.0, 200.0), 300.0, cells).compliance(float(waves))[N:, N:]
    expected = ring_compliance(waves, 100.0, 300.0) / 20.0
    if waves == 0:
        expected[0, 1] = expected[1, 0] = 0.0
    np.testing.assert_allclose(found, expected, atol=2e-4 * np.abs(expected).max())


def test_the_sum_of_the_harmonics_is_that_of_plane_elasticity() -> None:
    """What a ring gives more than a layer of the height of its rim, nu = 0, from exact sums, to 0.3 %."""
    cells = cells_of(plain(20.0, 60.0), -10.0, 10.0, 1, poisson=0.0)
    found = wheel_correction(plain(20.0, 200.0), 300.0, cells)[0, :, 0]
    total = np.zeros((2, 2))
    for n in range(200):
        more = ring_compliance(n, 100.0, 300.0) - ring_compliance(n, 240.0, 300.0, curved=False) / 300.0
        total += more * (0.5 if n == 0 else 1.0) / 20.0 / np.pi
    np.testing.assert_allclose(found[[N, Z], [N, Z]], np.diag(total), rtol=3e-3)
    assert found[N, Z] == found[Z, N] == 0.0


def plate_deflection(waves: int, bore: float, radius: float, thickness: float, poisson: float) -> float:
    """Deflection of a plate, clamped at its bore, at its edge by a unit force per radian times cos nt (Kirchhoff)."""
    powers = {0: [(0, 0), (0, 1), (2, 0), (2, 1)], 1: [(1, 0), (-1, 0), (3, 0), (1, 1)]}
    n = waves
    basis = powers.get(n, [(n, 0), (-n, 0), (n + 2, 0), (2 - n, 0)])

    def of(p: int, log: int, order: int, r: float) -> float:
        """Derivative of ``r^p`` or ``r^p ln r``."""
        value, slope = (0.0, 1.0) if log else (1.0, 0.0)  # r^p (value + slope ln r)
        for _ in range(order):
            value, slope, p = p * value + slope, p * slope, p - 1
        return r**p * (value + slope * np.log(r))

    rigidity = YOUNG * thickness**3 / 12.0 / (1.0 - poisson**2)
    matrix = np.zeros((4, 4))
    for j, (p, log) in enumerate(basis):
        f = [of(p, log, order, radius) for order in range(4)]
        moment = f[2] + poisson * (f[1] / radius - n**2 * f[0] / radius**2)
        laplacian = f[3] + f[2] / radius - (1 + n**2) * f[1] / radius**2 + 2 * n**2 * f[0] / radius**3
        shear = laplacian - (1.0 - poisson) * n**2 / radius**2 * (f[1] - f[0] / radius)
        matrix[:, j] = [of(p, log, 0, bore), of(p, log, 1, bore), moment, -rigidity * shear]
    shares = np.linalg.solve(matrix, [0.0, 0.0, 0.0, 1.0 / radius])
    return float(sum(share * of(p, log, 0, radius) for share, (p, log) in zip(shares, basis, strict=True)))


def test_a_disc_bends_as_a_plate() -> None:
    """Lateral displacement of the edge of a disc of 20 mm, clamped at its bore: that of Kirchhoff's plate to 2 %."""
    cells = cells_of(plain(20.0, 60.0), -10.0, 10.0, 1)
    disc = revolved(plain(20.0, 300.0), 400.0, cells)
    for n in range(5):
        found, expected = disc.compliance(float(n))[0, 0], plate_deflection(n, 100.0, 400.0, 20.0, 0.3)
        assert 1.0 < found / expected < 1.02 + 0.01 * n


def test_short_waves_do_not_see_the_wheel() -> None:
    """Compliance of the tread: much more than the prism's for few waves, within 2e-3 of it for many."""
    whole, cells = s1002()
    wheel_cells = revolved(whole, RADIUS, cells)
    mean = float(wheel_cells.middles[:, 0].mean())
    ratios = []
    for n in (1.0, 5.0, 20.0, 100.0):
        found, prism = wheel_cells.compliance(n), cells.compliance(n / mean) / mean
        ratios.append(found[4, 4] / prism[4, 4])
    assert ratios[0] > 1.4
    assert (np.diff(np.abs(np.array(ratios) - 1.0)) < 0.0).all()
    assert ratios[-1] == pytest.approx(1.0, abs=2e-3)


def test_a_whole_wheel_gives_way_as_one_of_920_mm_should() -> None:
    """A force of 150 kN moves the tread by 0.02 to 0.05 mm more than the rim alone.

    The prism of the whole section leaves 0.002 to 0.012 mm of that. Laterally 10 kN move it by 0.1 to 0.2 mm.
    """
    whole, rim = s1002()[0], correction()
    assert 0.02 < 150e3 * rim[1, N, 1, N] < 0.05
    assert 0.1 < 10e3 * rim[1, 0, 1, 0] < 0.2
    np.testing.assert_allclose(rim, rim.transpose(2, 3, 0, 1), atol=1e-12 * rim.max())
    section = replace(whole, running_names=wheel("S1002").running_names)
    left = wheel_correction(whole, RADIUS, cells_of(section, -10.0, 10.0, 4))
    assert 0.002 < 150e3 * left[1, N, 1, N] < 0.012


def test_a_symmetric_wheel_gives_a_symmetric_matrix() -> None:
    """Mirrored cells exchange their rows, with the sign of what points across."""
    disc = WholeWheel(web_middle_mm=(0.0, 0.0), hub_mm=(-80.0, 80.0))
    profile = plain(120.0, 50.0)
    found = wheel_correction(whole_wheel(profile, RADIUS, disc), RADIUS, cells_of(profile, -18.0, 18.0, 4))
    signs = np.array([-1.0, 1.0, 1.0])
    mirrored = found[::-1, :, ::-1] * signs[:, None, None] * signs
    np.testing.assert_allclose(mirrored, found, atol=2e-3 * np.abs(found).max())


@pytest.mark.parametrize("name", WHEELS)
def test_every_bundled_wheel_gets_a_web_and_a_hub(name) -> None:
    """The running surface stays, the bore is the cut."""
    profile = wheel(name)
    whole = whole_wheel(profile, RADIUS)
    np.testing.assert_array_equal(
        whole.running_surface.sampled(spacing=5.0), profile.running_surface.sampled(spacing=5.0)
    )
    low, high = whole.outline.bounds(["cut"])
    assert low[1] == high[1] == RADIUS - WholeWheel().bore_radius_mm
    assert high[0] - low[0] == 180.0
    assert 20e3 < whole.outline.area < 30e3


def test_a_whole_section_comes_from_a_file(tmp_path) -> None:
    """A file with the outline of a wheel down to its bore gives the same wheel."""
    whole = s1002()[0]
    file = tmp_path / "wheel.csv"
    file.write_text(write_segment_csv(whole.outline, "wheel", "a wheel", "tape", 70.0))
    found = whole_profile(read_profile(file))
    assert found.outline.area == pytest.approx(whole.outline.area, rel=1e-9)
    assert found.outline.bounds(["cut"]) == pytest.approx(whole.outline.bounds(["cut"]))


PLACES = np.array([-750.0, 750.0])
DIAMETER = 173.0
RIGIDITY = YOUNG * np.pi * DIAMETER**4 / 64.0
UNIFORM = ElasticAxle(journals_mm=2000.0, diameters_mm=((0.0, DIAMETER), (1100.0, DIAMETER)), young_MPa=YOUNG)


def tilts(axle, forces):
    """Rotations of both seats against the line through them by forces and moments, (2, 2) by seat."""
    left, left_tilt, right, right_tilt = axle.compliance(PLACES) @ np.ravel(forces)
    return np.subtract((left_tilt, right_tilt), (right - left) / np.ptp(PLACES))


def test_outside_journals_bend_the_middle_up() -> None:
    """Equal wheel forces: bending Q (L - b) / 2 between the wheels, whose lower parts come closer, Q a^2 / 3 beside."""
    force = 112.5e3
    expected = force * 250.0 * 750.0 / RIGIDITY
    forces = np.array([[force, 0.0], [force, 0.0]])
    np.testing.assert_allclose(tilts(UNIFORM, forces), [expected, -expected], rtol=1e-12)
    risen = expected * 250.0 + force * 250.0**3 / (3.0 * RIGIDITY)
    np.testing.assert_allclose((UNIFORM.compliance(PLACES) @ forces.ravel())[::2], [risen, risen], rtol=1e-12)


def test_inside_journals_bend_the_middle_down() -> None:
    """Four-point bending: the slope at the ends is Q a (b - a) / (2 E I) with a from the wheel to the journal."""
    inside = UNIFORM.replaced(journals_mm=1100.0)
    force, arm = 100e3, 200.0
    expected = force * arm * (1500.0 - arm) / 2.0 / RIGIDITY
    found = tilts(inside, [[force, 0.0], [force, 0.0]])
    np.testing.assert_allclose(found, [-expected, expected], rtol=1e-10)


def test_a_moment_on_one_wheel_bends_a_supported_beam() -> None:
    """A moment at the end of a beam whose journals are in the wheels: M l / 3 E I there, - M l / 6 E I at the other."""
    found = UNIFORM.replaced(journals_mm=1500.0).compliance(PLACES) @ (0.0, 0.0, 0.0, 20e6)
    slope = 20e6 * 1500.0 / RIGIDITY
    np.testing.assert_allclose(found, [0.0, -slope / 6.0, 0.0, slope / 3.0], rtol=1e-10, atol=1e-12)


@pytest.mark.parametrize("axle", [ElasticAxle(), ElasticAxle(journals_mm=1000.0)])
def test_an_axle_bends_as_a_beam_of_finite_elements(axle) -> None:
    """Hermite elements of an axle with steps, 5 mm long, seats beside its middle: all 16 entries to 1e-3; symmetric."""
    places, half = np.array([-745.0, 760.0]), axle.journals_mm / 2.0
    x = np.unique(np.append(np.arange(-1100.0, 1101.0, 5.0), (*places, -half, half)))
    size, middle = np.diff(x), (x[1:] + x[:-1]) / 2.0
    drawn = np.array(axle.diameters_mm)
    rigidity = axle.young_MPa * np.pi * np.interp(abs(middle), *drawn.T) ** 4 / 64.0
    stiffness = np.zeros((2 * len(x), 2 * len(x)))
    for number, (length, stiff) in enumerate(zip(size.tolist(), rigidity.tolist(), strict=True)):
        row, other = (
            np.array([12.0, 6.0 * length, -12.0, 6.0 * length]),
            np.array([6.0, 4.0 * length, -6.0, 2.0 * length]),
        )
        last = np.array([6.0, 2.0 * length, -6.0, 4.0 * length])
        of_one = np.array([row, length * other, -row, length * last]) * stiff / length**3
        stiffness[2 * number : 2 * number + 4, 2 * number : 2 * number + 4] += of_one
    held = 2 * np.searchsorted(x, (-half, half))
    free = np.setdiff1d(np.arange(2 * len(x)), held)
    inverse = np.zeros_like(stiffness)
    inverse[np.ix_(free, free)] = np.linalg.inv(stiffness[np.ix_(free, free)])
    seats = np.ravel([(2 * at, 2 * at + 1) for at in np.searchsorted(x, places)])
    compliance = axle.compliance(places)
    np.testing.assert_allclose(compliance, compliance.T, rtol=1e-12)
    expected = inverse[np.ix_(seats, seats)]
    scale = np.sqrt(np.outer(expected.diagonal(), expected.diagonal()))
    np.testing.assert_allclose(compliance / scale, expected / scale, atol=1e-3)


def test_sides_exchange_with_their_loads() -> None:
    """Of seats at equal distances the mirrored load bends the mirrored axle, with the sign of rotations."""
    compliance, mirror = ElasticAxle().compliance(PLACES), np.kron([[0.0, 1.0], [1.0, 0.0]], np.diag([1.0, -1.0]))
    np.testing.assert_allclose(mirror @ compliance @ mirror, compliance, rtol=1e-10)
