"""Contact patches in three dimensions: prisms, bodies of revolution, grids with random gaps and materials."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.special import ellipeinc, ellipkinc

from flangeway.contact.patch.normal_contact import Convolution, solve_normal
from flangeway.contact.patch.patch_contact import PatchContact, press_patch
from flangeway.contact.patch.patch_grid import Axis, PatchBody, grid_about
from flangeway.elements import Element, Lagrange, Virtual
from flangeway.errors import InputError
from flangeway.exact import PointContact, half_space_influence
from flangeway.geometry import Arc, Line, Outline, Placement
from flangeway.materials import Elastic
from flangeway.mesh import Refinement, dual, triangulate
from flangeway.post.patch_stresses import depth_profile, patch_stresses
from flangeway.problems import Elasticity, Harmonic
from flangeway.space import Space
from flangeway.types import Floats

STEEL = Elastic(210e3, 0.3)
FORCE = 20e3
HALF, HEIGHT = 15.0, 25.0


def block(
    crown: float | None, size: float = 0.3, element: Element | None = None, *, zone: float = 5.0, **placed
) -> PatchBody:
    """A block below y = 0 whose top is an arc of a radius, or flat, held at its base."""
    element = element or Lagrange(2)
    drop = 0.0 if crown is None else np.sqrt(crown**2 - HALF**2) - crown
    left, right = (-HALF, drop), (HALF, drop)
    top = Line(right, left) if crown is None else Arc(right, left, (0.0, -crown), counter_clockwise=True)
    sides = [Line((-HALF, -HEIGHT), (HALF, -HEIGHT)), Line((HALF, -HEIGHT), right), top, Line(left, (-HALF, -HEIGHT))]
    outline = Outline.from_segments(sides, ["base", "right", "top", "left"])
    mesh = triangulate(outline, size=6.0, refinements=[Refinement(np.array([[-zone, 0.0], [zone, 0.0]]), size, 0.3)])
    if isinstance(element, Virtual):
        mesh = dual(mesh)
    problem = Harmonic(Elasticity(Space(mesh, element), STEEL, name="block"), held={"base": "xyz"})
    return PatchBody(problem, "top", outline.part(["top"]), **placed)


TURNED = Placement(np.pi)


def hertz(one: float, other: float, force: float, angle: float = np.pi / 2.0) -> tuple[float, float, float]:
    """Longer and shorter semi-axis, and largest pressure, of cylinders of two radii whose axes cross."""
    modulus = STEEL.plane_modulus / 2.0
    total = 0.5 * (1.0 / one + 1.0 / other)
    difference = 0.5 * np.sqrt(1 / one**2 + 1 / other**2 + 2.0 / (one * other) * np.cos(2.0 * angle))
    ellipse = PointContact(force, 1.0 / (total - difference), 1.0 / (total + difference), modulus)
    return *ellipse.semi_axes, ellipse.max_pressure


def check(found: PatchContact, wanted: tuple[float, float, float], axes: float, pressure: float) -> None:
    assert found.status.converged
    assert len(found.patches) == 1
    np.testing.assert_allclose(found.patches[0].semi_axes, wanted[:2], rtol=axes)
    assert found.pressures.max() == pytest.approx(wanted[2], rel=pressure)
    assert found.force[1] == pytest.approx(FORCE, rel=1e-9)
    assert found.pressures.min() >= 0.0
    assert found.closed_error < 1e-6
    assert found.overlap < 1e-6


def test_crossed_cylinders_touch_as_hertz_says() -> None:
    """A cylinder across a prism at 45 degrees: semi-axes and pressure within 1 %, the patch turned as its axes.

    The longer axis lies between the axes of the cylinders, for equal radii in the middle.
    """
    turned = np.pi / 4.0
    cylinder = block(None, 0.08, placement=TURNED, axis=Axis((0.0, -50.0), (-1.0, 0.0), turned))
    found = press_patch(block(50.0, 0.08), cylinder, force=FORCE, tolerance=1e-2)
    check(found, hertz(50.0, 50.0, FORCE, np.pi / 4.0), 1e-2, 1e-2)
    assert abs(found.patches[0].angle_rad) == pytest.approx(np.pi / 8.0, abs=0.01)


@pytest.mark.ci
def test_patches_are_equal_under_mirror_and_under_exchange_of_the_bodies() -> None:
    """Both bodies mirrored: equal to 1e-7 of the pressure; upside down with the bodies exchanged: 1e-3."""
    lower = block(40.0, 0.12, placement=Placement.about((0.0, 0.0), 0.02))
    upper = block(None, 0.12, placement=TURNED, axis=Axis((0.0, -60.0)))
    grid = grid_about(lower, upper, 0.15, (4.5, 6.0))
    found = press_patch(lower, upper, force=FORCE, grid=grid, tolerance=1e-2)
    # x -> -x after the rotation about the origin is x -> -x before the opposite one
    mirror = [
        PatchBody(body.problem, body.surface, body.curve, Placement(-body.placement.rotation_rad, mirrored=True), axis)
        for body, axis in ((lower, None), (upper, upper.axis))
    ]
    mirrored = press_patch(*mirror, force=FORCE, grid=grid_about(*mirror, 0.15, (4.5, 6.0)), tolerance=1e-2)
    peak = found.pressures.max()
    np.testing.assert_allclose(mirrored.pressures[::-1], found.pressures, atol=1e-4 * peak)
    over = Placement(np.pi)
    upside = [PatchBody(b.problem, b.surface, b.curve, over.after(b.placement), b.axis) for b in (upper, lower)]
    exchanged = press_patch(*upside, force=FORCE, grid=grid_about(*upside, 0.15, (4.5, 6.0)), tolerance=1e-2)
    np.testing.assert_allclose(exchanged.patches[0].semi_axes, found.patches[0].semi_axes, rtol=2e-3)
    assert exchanged.pressures.max() == pytest.approx(peak, rel=2e-3)
    assert exchanged.approach == pytest.approx(found.approach, rel=1e-3)


@pytest.mark.ci
def test_other_loads_start_from_a_solution_and_an_approach_gives_its_force() -> None:
    """From a near load in half of the iterations the same pressures; the approach of a force gives this force again."""
    upper = block(None, 0.15, placement=TURNED, axis=Axis((0.0, -60.0)))
    found = press_patch(block(60.0, 0.15), upper, force=FORCE, tolerance=1e-2)
    more = found.pair.press(force=1.0001 * FORCE)
    warm = found.pair.press(force=1.0001 * FORCE, start=found.contact.forces)
    np.testing.assert_allclose(warm.pressures, more.pressures, atol=1e-5 * more.pressures.max())
    assert warm.status.iterations < 0.6 * more.status.iterations
    again = found.pair.press(approach=found.approach)
    assert again.force[1] == pytest.approx(FORCE, rel=1e-6)


def hertz_below(long: float, short: float, pressure: float, depths: Floats) -> Floats:
    """Stresses along the longer axis, the shorter one and the depth, below the middle of Hertz's ellipse, (n, 3).

    Thomas and Hoersch (1930), as in Johnson (1985), "Contact Mechanics", 4.2.
    """
    nu, square = STEEL.poisson, 1.0 - (short / long) ** 2
    zeta, ratio = depths / long, (long / short) ** 2
    first, second = (of(np.arctan2(1.0, zeta), square) for of in (ellipkinc, ellipeinc))
    t = np.sqrt((short**2 + depths**2) / (long**2 + depths**2))
    x = -(1.0 - t) / 2.0 + zeta * (first - second) + nu * (1.0 - ratio * t + zeta * (ratio * second - first))
    y = 0.5 + 0.5 / t - ratio * t + zeta * (ratio * second - first) + nu * (-1.0 + t + zeta * (first - second))
    z = -(1.0 - t**2) / (2.0 * t)
    return 2.0 * pressure * short / (square * long) * np.stack((x, y, z), axis=1)


@pytest.mark.ci
def test_stresses_below_a_patch_are_those_of_hertz_and_symmetric() -> None:
    """Below the middle within 2.5 % of the pressure ; before and behind it equal, shears along z opposite."""
    crown, radius = 40.0, 80.0
    roller = block(None, 0.12, placement=TURNED, axis=Axis((0.0, -radius)))
    found = press_patch(block(crown, 0.12), roller, force=FORCE, tolerance=1e-2)
    long, short, pressure = hertz(crown, radius, FORCE)
    depths = np.array([0.05, 0.4, 0.8, 1.2, 1.6, 2.4, 3.2])
    for which in (0, 1):
        section = patch_stresses(found, which)
        below = depth_profile(section, found.patches[0], depths).stresses
        wanted = hertz_below(long, short, pressure, depths)
        np.testing.assert_allclose(below.components[:, [2, 0, 1]], wanted, atol=0.025 * pressure)
        np.testing.assert_allclose(below.components[:, 3:], 0.0, atol=0.01 * pressure)
        one, two, three = wanted[:, [0, 1, 2]].T
        mises = np.sqrt(((one - two) ** 2 + (two - three) ** 2 + (three - one) ** 2) / 2.0)
        np.testing.assert_allclose(below.von_mises, mises, atol=0.025 * pressure)
        np.testing.assert_allclose(below.tresca, np.ptp(wanted, axis=1), atol=0.025 * pressure)
        ahead, behind = (patch_stresses(found, which, z=z) for z in (1.0, -1.0))
        points = np.array([[0.2, -0.7], [-0.5, -1.1]]) * (1.0 if which == 0 else -1.0)
        signs = np.array([1.0, 1.0, 1.0, 1.0, -1.0, -1.0])
        values = ahead.at(points).components
        np.testing.assert_allclose(behind.at(points).components * signs, values, atol=1e-6 * pressure)
        assert np.abs(values[:, 4]).min() > 0.05 * pressure
    assert np.isnan(section.at(np.array([[500.0, 0.0]])).components).all()


@pytest.mark.ci
def test_two_crowns_make_two_patches() -> None:
    """A block with two humps under a flat roller: two equal patches, whose forces are the load."""
    half, height = 2.0, 0.15
    radius, edge = (half**2 + height**2) / (2.0 * height), (2.0 * half, -height)
    humps = [
        *(Line((-15.0, -25.0), (15.0, -25.0)), Line((15.0, -25.0), (15.0, -height)), Line((15.0, -height), edge)),
        Arc(edge, (0.0, -height), (half, -radius), counter_clockwise=True),
        Arc((0.0, -height), (-edge[0], -height), (-half, -radius), counter_clockwise=True),
        *(Line((-edge[0], -height), (-15.0, -height)), Line((-15.0, -height), (-15.0, -25.0))),
    ]
    outline = Outline.from_segments(humps, ["base", "right", "side", "top", "top", "other", "left"])
    along = outline.part(["top"]).sampled(spacing=0.5)
    mesh = triangulate(outline, size=6.0, refinements=[Refinement(along, 0.06, 0.4)])
    lower = PatchBody(
        Harmonic(Elasticity(Space(mesh, Lagrange(1)), STEEL, name="humps"), held={"base": "xyz"}),
        "top",
        outline.part(["top"]),
    )
    roller = block(None, 0.06, Lagrange(1), zone=4.0, placement=TURNED, axis=Axis((0.0, -15.0)))
    found = press_patch(lower, roller, force=FORCE, tolerance=0.05)
    assert len(found.patches) == 2
    assert found.patches[0].force[1] == pytest.approx(FORCE / 2.0, rel=1e-2)
    assert sum(each.force[1] for each in found.patches) == pytest.approx(FORCE, rel=1e-9)
    assert sorted(round(float(each.centre[0]), 1) for each in found.patches) == [-2.0, 2.0]


def test_what_cannot_be_pressed_is_refused() -> None:
    """Windows, cells, meshes, loads and positions that do not fit end in errors that say what to do."""
    lower, upper = block(60.0, 0.25), block(None, 0.25, placement=TURNED, axis=Axis((0.0, -60.0)))
    beside = block(None, 0.25, placement=Placement(np.pi, (200.0, 0.0)))
    for words, bodies, load, grid in (
        ("lifts off", (lower, upper), -FORCE, None),
        ("nowhere above", (lower, beside), FORCE, None),
        ("reaches the end of the contact surface", (lower, upper), 1e4 * FORCE, None),
        ("refine the mesh along", (lower, upper), FORCE, (0.1, (5.0, 5.0))),
        ("take cells of 0\\.", (lower, upper), FORCE, (0.6, (6.0, 6.0))),
        ("a larger window", (lower, upper), FORCE, (0.3, (3.0, 3.0))),
    ):
        with pytest.raises(InputError, match=words):
            press_patch(*bodies, force=load, grid=grid and grid_about(*bodies, *grid), tolerance=0.1)
    with pytest.raises(InputError, match="without a support along z"):
        PatchBody(Harmonic(lower.problem.elasticity, held={"base": "xy"}), "top", lower.curve)
    with pytest.raises(InputError, match="exchange the bodies"):
        Axis((0.0, 0.0), yaw_rad=1.2)


def grid_of(seed: int) -> tuple[Convolution, np.ndarray, float]:
    """Influence on cells of random widths, gaps of two curvatures with waves on them, and a strip's width."""
    random = np.random.default_rng(seed)
    n_cells, n_strips, strip = int(random.integers(3, 9)), int(random.integers(3, 9)), float(random.uniform(0.3, 2.0))
    bounds = np.concatenate(([0.0], np.cumsum(random.uniform(0.5, 1.5, n_cells))))
    coefficients = half_space_influence(
        random.uniform(0.1, 9.0), random.uniform(0.0, 0.49), bounds, strip, n_strips, (1,)
    )
    x, z = (bounds[1:] + bounds[:-1]) / 2.0, strip * np.arange(n_strips)
    gaps = (x[:, None] - random.uniform(0.0, x[-1])) ** 2 * random.uniform(0.0, 0.2)
    gaps = gaps + (z - random.uniform(0.0, z[-1])) ** 2 * random.uniform(0.0, 0.2)
    return Convolution(coefficients), gaps + random.uniform(0.0, 0.3, gaps.shape), strip


@given(seed=st.integers(0, 10**6), force=st.floats(1e-3, 1e3))
def test_the_solution_is_complementary(seed, force) -> None:
    """No force pulls, none acts across a gap, no cells overlap, and the resultant is the load."""
    influence, gaps, _ = grid_of(seed)
    found = solve_normal(influence, gaps, force=force, tolerance=1e-10)
    assert found.status.converged
    assert found.forces.min() >= 0.0
    assert found.forces.sum() == pytest.approx(force, rel=1e-12)
    depth = influence(found.forces).max()
    assert abs(found.gaps[found.forces > 0.0]).max() < 1e-6 * depth
    assert found.gaps.min() > -1e-6 * depth
    np.testing.assert_allclose(found.gaps, gaps + influence(found.forces) - found.approach, atol=1e-12 * depth)


@given(seed=st.integers(0, 10**6), force=st.floats(1e-3, 1e3))
def test_an_approach_gives_the_force_that_it_comes_from(seed, force) -> None:
    """The same forces belong to a force and to its approach, cold and from the forces of another load."""
    influence, gaps, _ = grid_of(seed)
    found = solve_normal(influence, gaps, force=force, tolerance=1e-10)
    other = solve_normal(influence, gaps, force=0.7 * force, start=found.forces, tolerance=1e-10)
    for start in (None, other.forces):
        again = solve_normal(influence, gaps, approach=found.approach, start=start, tolerance=1e-10)
        assert again.status.converged
        np.testing.assert_allclose(again.forces, found.forces, atol=1e-5 * found.forces.max())
    assert other.approach < found.approach


@given(seed=st.integers(0, 10**6))
def test_products_by_transform_are_those_of_the_whole_matrix(seed) -> None:
    """Coefficients that are symmetric in z give the sums over all cells, whatever cells are loaded."""
    random = np.random.default_rng(seed)
    n, m = int(random.integers(1, 5)), int(random.integers(1, 6))
    coefficients = random.normal(size=(m, n, n))
    forces = random.normal(size=(n, m)) * (random.uniform(size=(n, 1)) < 0.7)
    exact = np.zeros((n, m))
    for place in range(m):
        for source in range(m):
            exact[:, place] += coefficients[abs(place - source)] @ forces[:, source]
    np.testing.assert_allclose(Convolution(coefficients)(forces), exact, atol=1e-12)


@pytest.mark.parametrize("wrong", [{}, {"force": 1.0, "approach": 1.0}, {"force": 0.0}, {"force": np.nan}])
def test_one_positive_force_or_one_approach_is_asked_for(wrong) -> None:
    """Neither, both, and a force that does not press end in a clear error."""
    influence, gaps, _ = grid_of(1)
    with pytest.raises(InputError, match="a force > 0 or an approach"):
        solve_normal(influence, gaps, **wrong)
