"""Prisms and bodies of revolution under loads that vary as a cosine, beside closed forms."""

import numpy as np
import pytest

from flangeway.elements import Lagrange, Virtual
from flangeway.errors import InputError
from flangeway.materials import Elastic, Orthotropic
from flangeway.mesh import dual, rectangle_grid
from flangeway.problems import Elasticity, PointForce, Pressure, Traction, fixed
from flangeway.problems.harmonic import Foundation, Harmonic, LongitudinalTraction
from flangeway.solve import solve_elasticity
from flangeway.solve.harmonic_solution import solve_harmonic
from flangeway.space import Space

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
