"""Prisms and bodies of revolution under loads that vary as a cosine, beside closed forms, also on curved edges."""

import numpy as np
import pytest

from flangeway.elements import Element, Lagrange, Virtual
from flangeway.errors import InputError
from flangeway.geometry import Arc, Contour, Line, Outline, circle
from flangeway.materials import Elastic, Orthotropic
from flangeway.mesh import PolyMesh, curved, dual, rectangle_grid, triangulate
from flangeway.post import cell_stresses
from flangeway.problems import Elasticity, PointForce, PrescribedDisplacement, Pressure, Traction, fixed
from flangeway.problems.harmonic import Foundation, Harmonic, LongitudinalTraction
from flangeway.solve import solve_elasticity
from flangeway.solve.solutions import solve_harmonic
from flangeway.space import Space, interpolate
from flangeway_studies.spatial_study import exact_bar

ELEMENTS = [Lagrange(1), Lagrange(2), Virtual(1), Virtual(2), Virtual(3)]


def ring(inner, outer, height, nx, ny, element):
    """Half section of a body of revolution."""
    mesh = rectangle_grid(outer - inner, height, nx, ny, origin=(inner, 0.0))
    mesh = dual(mesh) if isinstance(element, Virtual) else mesh
    edges, points = mesh.boundary_edges, mesh.points
    for name, axis, value in (("inner", 0, inner), ("outer", 0, outer), ("low", 1, 0.0), ("top", 1, height)):
        on = (np.abs(points[edges][:, :, axis] - value) < 1e-9 * outer).all(axis=1)
        mesh = mesh.with_edge_set(name, edges[on])
    return Space(mesh, element)


@pytest.mark.parametrize("element", ELEMENTS)
def test_at_wavenumber_zero_a_prism_is_in_plane_strain(element) -> None:
    """The amplitudes U and V are the displacements of plane strain to 1e-10, and W is at rest."""
    space = ring(1.0, 3.0, 1.0, 4, 3, element)
    loads = [Traction("outer", (1.0, 2.0)), Pressure("top", 0.5)]
    plane = solve_elasticity(Elasticity(space, Elastic(1.0, 0.3), loads=loads, supports=[fixed("inner")]))
    found = solve_harmonic(Harmonic(Elasticity(space, Elastic(1.0, 0.3), loads=loads), held={"inner": "xyz"}), 0.0)
    np.testing.assert_allclose(
        found.amplitudes[:, :2], plane.displacements, atol=1e-10 * abs(plane.displacements).max()
    )
    assert not found.amplitudes[:, 2].any()
    assert found.energy == pytest.approx(plane.energy, rel=1e-10)


@pytest.mark.parametrize("element", ELEMENTS)
def test_only_rigid_motions_of_a_body_of_revolution_have_no_energy(element) -> None:
    """N = 0 has two motions without energy, n = 1 two (translation and tilt across the axis), n = 3 none."""
    harmonic = Harmonic(Elasticity(ring(1.0, 2.0, 1.0, 2, 2, element), Elastic(1.0, 0.3, "axisymmetric")))
    for number, n_free in ((0, 2), (1, 2), (3, 0)):
        values = np.linalg.eigvalsh(harmonic.stiffness(number).full().toarray())
        assert (values[:n_free] < 1e-12 * values[-1]).all()
        assert values[n_free] > 1e-7 * values[-1]


@pytest.mark.parametrize("element", [Lagrange(2), Virtual(2), Virtual(3)])
def test_a_large_ring_is_a_prism(element) -> None:
    """A ring of radius r = 1000 with n = k r waves deforms as the prism of its section to 0.5 %."""
    wavenumber, radius = 2.0, 1000.0
    amplitudes = []
    for hypothesis, number, depth in (("plane_strain", wavenumber, 1.0), ("axisymmetric", 2001.0, radius)):
        space = ring(radius, radius + 1.0, 1.0, 3, 3, element)
        load = PointForce((radius + 1.0, 1.0), (depth if hypothesis == "plane_strain" else 2.0 * np.pi * depth, 0.0))
        problem = Elasticity(space, Elastic(1.0, 0.3, hypothesis), loads=[load])
        found = solve_harmonic(Harmonic(problem, foundations=[Foundation("low", 1.0, 1.0, 1.0)]), number)
        amplitudes.append(found.amplitudes)
    np.testing.assert_allclose(amplitudes[1], amplitudes[0], atol=5e-3 * abs(amplitudes[0]).max())


def test_a_thin_ring_under_two_opposite_forces_bends_as_curved_beams_do() -> None:
    """The sum of even harmonics gives the change of the other diameter, P R^3 / (E I) (4 / pi - 1) / 2, to 1 %."""
    radius, thickness, width = 100.0, 2.0, 1.0
    space = ring(radius - thickness / 2.0, radius + thickness / 2.0, width, 2, 1, Lagrange(2))
    young, poisson, force = 1000.0, 0.0, 1.0
    sides = 0.0
    for number in range(2, 20, 2):
        # two forces P at t = 0 and pi, inwards: amplitude 2 P / pi of cos nt, spread over the outer edge
        load = Pressure("outer", 2.0 * force / np.pi / (radius + thickness / 2.0) / width)
        problem = Elasticity(space, Elastic(young, poisson, "axisymmetric"), loads=[load])
        found = solve_harmonic(Harmonic(problem), number)
        sides += found.displacements(np.pi / 2.0)[problem.node_at((radius, 0.0)), 0]
    inertia = width * thickness**3 / 12.0
    exact = force * radius**3 / (young * inertia) * (2.0 / np.pi - 0.5)
    assert 2.0 * sides == pytest.approx(exact, rel=1e-2)


def test_a_foundation_carries_a_load_that_varies_slowly() -> None:
    """A stiff block on springs sinks by the load over the stiffness where the wave is long, to 1e-3."""
    space = ring(0.0, 4.0, 2.0, 4, 2, Lagrange(2))
    problem = Elasticity(space, Elastic(1e6, 0.3), loads=[Pressure("top", 2.0)])
    harmonic = Harmonic(problem, foundations=[Foundation("low", 3.0, 5.0, 7.0)])
    found = solve_harmonic(harmonic, 1e-3)
    np.testing.assert_allclose(found.amplitudes[:, 1], -2.0 / 5.0, rtol=1e-3)


def test_an_orthotropic_prism_shears_along_with_its_own_modulus() -> None:
    """A layer under a longitudinal traction at wavenumber 0 shears by stress over G23, along y."""
    space = ring(0.0, 1.0, 2.0, 2, 4, Virtual(2))
    material = Orthotropic((1.0, 1.0, 1.0), (0.2, 0.2, 0.2), 0.4, longitudinal=(0.5, 0.25))
    harmonic = Harmonic(Elasticity(space, material), [LongitudinalTraction("top", 0.3)], held={"low": "z"})
    found = solve_harmonic(harmonic, 0.0)
    assert found.amplitudes[harmonic.elasticity.node_at((1.0, 2.0)), 2] == pytest.approx(0.3 / 0.5 * 2.0, rel=1e-10)
    (batch, *_) = space.batches()
    _, stresses = harmonic.cell_stresses(batch, found.amplitudes, 0.0)
    np.testing.assert_allclose(stresses[4, 0], 0.3, rtol=1e-9)  # yz
    np.testing.assert_allclose(stresses[[0, 1, 2, 3, 5]], 0.0, atol=1e-9)


@pytest.mark.parametrize("element", [Lagrange(1), Virtual(1), Virtual(2)])
def test_resultants_of_the_stresses_balance_the_loads_at_any_place(element) -> None:
    """Over a section dN/dz and dQ/dz are the loads along z and y per length, N of zz and Q of yz, to 1e-9."""
    space = ring(0.0, 1.0, 2.0, 3, 4, element)
    wavenumber, along = 0.7, 0.4
    elasticity = Elasticity(space, Elastic(1.0, 0.3), loads=[Traction("top", (0.0, 0.2))])
    found = solve_harmonic(Harmonic(elasticity, [LongitudinalTraction("top", 0.3)]), wavenumber)
    resultants = space.mesh.cell_areas @ found.stresses(along)
    assert resultants[2] == pytest.approx(0.3 / wavenumber * np.cos(wavenumber * along), rel=1e-9)
    assert resultants[4] == pytest.approx(-0.2 / wavenumber * np.sin(wavenumber * along), rel=1e-9)


def test_what_is_not_held_is_named() -> None:
    """A prism without longitudinal support is refused at wavenumber 0 under a load along z, with the direction."""
    space = ring(0.0, 1.0, 1.0, 2, 2, Lagrange(1))
    harmonic = Harmonic(Elasticity(space, Elastic(1.0, 0.3)), [LongitudinalTraction("top", 1.0)])
    with pytest.raises(InputError, match=r"(?s)move along z.*foundations"):
        solve_harmonic(harmonic, 0.0)
    with pytest.raises(InputError, match="wavenumber -1"):
        solve_harmonic(harmonic, -1.0)


TORUS = [circle(1.0, (2.0, 0.0)), circle(0.4, (2.1, 0.0))]
HALF = Outline((Arc((0.0, -1.0), (0.0, 1.0), (0.0, 0.0), True), Line((0.0, 1.0), (0.0, -1.0))), ("arc", "axis"))
CURVED = [Virtual(2), Virtual(3), Virtual(5), Lagrange(2), Lagrange(3)]
YOUNG, POISSON, PRESSURE = 1000.0, 0.3, 10.0


def section(name: str, element: Element) -> Space:
    """Half section of a hollow torus, or of a ball, whose axis is on the boundary."""
    if name == "torus":
        mesh = triangulate(TORUS[0], size=0.6, holes=TORUS[1:], outline=TORUS)
    else:
        mesh = triangulate(HALF, size=0.6, outline=HALF)
    mesh = dual(mesh) if isinstance(element, Virtual) else mesh
    assert mesh.curves is not None
    return Space(mesh.with_edge_set("rim", mesh.boundary_edges if name == "torus" else mesh.edge_set("arc")), element)


@pytest.mark.parametrize("name", ["torus", "ball"])
@pytest.mark.parametrize("element", CURVED, ids=repr)
def test_uniform_strains_of_bodies_of_revolution_are_exact_on_curved_edges(name: str, element: Element) -> None:
    """Widening and lengthening by constant strains: displacements to 1e-10, stresses uniform to 1e-9."""
    space = section(name, element)
    held = PrescribedDisplacement("rim", lambda p: 1e-3 * p[:, 0], lambda p: 2e-3 * p[:, 1] + 1e-3)
    problem = Elasticity(space, Elastic(YOUNG, POISSON, "axisymmetric"), supports=[held])
    found = solve_elasticity(problem).displacements
    wanted = np.stack((1e-3 * space.nodes[:, 0], 2e-3 * space.nodes[:, 1] + 1e-3), axis=1)
    assert np.abs(found[: space.n_nodes] - wanted).max() < 1e-10 * np.abs(wanted).max()
    stresses = cell_stresses(problem, found).components
    assert np.ptp(stresses, axis=0).max() < 1e-9 * np.abs(stresses).max()


@pytest.mark.parametrize("name", ["torus", "ball"])
@pytest.mark.parametrize("element", CURVED, ids=repr)
def test_rigid_motions_of_harmonics_cost_nothing_on_curved_edges(name: str, element: Element) -> None:
    """Of a body of revolution shift and tilt (n = 1), lift and turn (n = 0); of a prism turn and shift along it."""
    space = section(name, element)
    one, x, y = (interpolate(space, each) for each in (lambda p: np.ones(len(p)), lambda p: p[:, 0], lambda p: p[:, 1]))
    nil = 0.0 * one
    turned, prism = (
        Harmonic(Elasticity(space, Elastic(YOUNG, POISSON, kind))) for kind in ("axisymmetric", "plane_strain")
    )
    motions = [(turned, 1.0, (one, nil, -one)), (turned, 1.0, (y, -x, -y)), (turned, 0.0, (nil, one, nil))]
    motions += [(turned, 0.0, (nil, nil, x)), (prism, 0.0, (-y, x, nil)), (prism, 0.0, (nil, nil, one))]
    for harmonic, wavenumber, motion in motions:
        matrix = harmonic.stiffness(wavenumber).full()
        assert np.abs(matrix @ np.stack(motion, axis=1).ravel()).max() < 1e-12 * np.abs(matrix).max()


def sphere_error(n: int, element: Element) -> float:
    """Relative error of the inner radial displacement of Lame's sphere, radii 1 and 2, under internal pressure."""
    grid = rectangle_grid(1.0, 1.0, n, n)
    radius, angle = 1.0 + grid.points[:, 0], 0.5 * np.pi * grid.points[:, 1]
    points = radius[:, None] * np.stack((np.cos(angle), np.sin(angle)), axis=1)
    points[np.abs(points) < 1e-12] = 0.0
    sides = [Contour((Line(a, b),), ("side",)) for a, b in (((0.0, 1.0), (0.0, 2.0)), ((1.0, 0.0), (2.0, 0.0)))]
    mesh = PolyMesh(points, grid.cell_offsets, grid.cell_points, edge_sets=grid.edge_sets)
    mesh = curved(mesh, [circle(1.0), circle(2.0), *sides])
    mesh = dual(mesh) if isinstance(element, Virtual) else mesh
    held = [PrescribedDisplacement("bottom", y=0.0), PrescribedDisplacement("top", x=0.0)]
    material = Elastic(YOUNG, POISSON, "axisymmetric")
    problem = Elasticity(Space(mesh, element), material, loads=[Pressure("left", PRESSURE)], supports=held)
    # u = p a^3 / (E (b^3 - a^3)) ((1 - 2 nu) r + (1 + nu) b^3 / (2 r^2)) (Timoshenko and Goodier)
    exact = PRESSURE / (7.0 * YOUNG) * (1.0 - 2.0 * POISSON + 4.0 * (1.0 + POISSON))
    return float(solve_elasticity(problem).displacement_at_node((1.0, 0.0))[0]) / exact - 1.0


@pytest.mark.parametrize(
    ("element", "rate", "least"),
    [(Virtual(2), 2.5, 4e-4), (Virtual(3), 3.0, 2e-5), (Virtual(4), 4.0, 1e-6), (Lagrange(3), 3.7, 1e-4)],
    ids=repr,
)
def test_lames_sphere_converges_with_the_order_on_curved_edges(element: Element, rate: float, least: float) -> None:
    """With chords the displacement has errors of 5 % and 1 %, and order 2, whatever the element."""
    coarse, fine = (abs(sphere_error(n, element)) for n in (4, 8))
    assert fine < least
    assert np.log2(coarse / fine) > rate


@pytest.mark.parametrize(("element", "least"), [(Virtual(2), 2e-4), (Virtual(3), 4e-6), (Lagrange(3), 3e-5)], ids=repr)
def test_a_round_bar_under_a_cosine_pressure_is_exact_to_its_order_on_curved_edges(element, least) -> None:
    """Love's radial displacement at ka = 5 with 31 edges around; on chords it is 3e-3 off, whatever the element."""
    errors = []
    for outline in (circle(1.0), None):
        mesh = triangulate(circle(1.0), size=0.2, outline=outline)
        mesh = dual(mesh) if isinstance(element, Virtual) else mesh
        space = Space(mesh.with_edge_set("rim", mesh.boundary_edges), element)
        found = solve_harmonic(Harmonic(Elasticity(space, Elastic(1.0, 0.3), loads=[Pressure("rim", 1.0)])), 5.0)
        errors.append(abs(-found.energy / float(mesh.cell_areas.sum()) / exact_bar()[5.0][0] - 1.0))
    assert errors[0] < least
    assert errors[1] > 10.0 * errors[0]


DISC = circle(1.0, (3.0, 0.0))


@pytest.mark.parametrize("hypothesis", ["plane_strain", "axisymmetric"])
@pytest.mark.parametrize("halves", [False, True])
def test_a_disc_of_chords_names_the_area_beside_them(hypothesis, halves):
    """``1 - n sin(2 pi / n) / (2 pi)`` of the disc for n chords, also in two pieces each; its curve has no notice."""

    def message(mesh):
        mesh = mesh.with_edge_set("low", lambda p: p[:, 1] < -0.8).with_edge_set("top", lambda p: p[:, 1] > 0.8)
        element = Virtual(2) if halves else Lagrange(2)
        body = Elasticity(Space(mesh, element), Elastic(1.0, 0.3, hypothesis), loads=[Traction("top", (0.0, 1.0))])
        return solve_harmonic(Harmonic(body, held={"low": "xyz"}), 2.0).status.message

    mesh = triangulate(DISC, size=0.3)
    n = len(mesh.boundary_edges)
    named = [float(word) for word in message(dual(mesh) if halves else mesh).split() if "e-0" in word]
    assert named[-1] == pytest.approx(1.0 - n * np.sin(2.0 * np.pi / n) / (2.0 * np.pi), rel=0.05)
    drawn = triangulate(DISC, size=0.3, outline=DISC)
    assert "curve" not in message(dual(drawn) if halves else drawn)


def test_straight_sides_and_corners_are_no_chords():
    """The section of a bar with an edge cut off by 45 degrees has no notice."""
    corners = [(1.0, 0.0), (2.0, 0.0), (2.0, 0.8), (1.8, 1.0), (1.0, 1.0)]
    bar = Outline.named([(f"side {i}", Line(corners[i - 1], corners[i])) for i in range(5)])
    assert Elasticity(Space(triangulate(bar, size=0.2), Lagrange(2)), Elastic(1.0, 0.3, "axisymmetric")).facets is None
