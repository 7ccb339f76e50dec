"""Compliance of surfaces in three dimensions, and contact with it, beside the half-space's closed forms."""

import time
from dataclasses import replace
from functools import cache

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.interpolate import CubicSpline
from scipy.sparse.linalg import splu

from flangeway._core import n_threads
from flangeway.elements import Lagrange, Virtual
from flangeway.errors import InputError, OutOfMemoryError
from flangeway.exact import half_space_influence
from flangeway.geometry import circle, polygon
from flangeway.materials import Elastic, Orthotropic
from flangeway.mesh import Refinement, dual, rectangle_grid, triangulate
from flangeway.problems import Elasticity
from flangeway.problems.harmonic import Foundation, Harmonic
from flangeway.solve import surface_compliance
from flangeway.solve.surface_compliance import ComplianceTable, SurfaceCells, compliance_table, inverse_weights
from flangeway.space import Space
from flangeway.system.disk_cache import Cache

YOUNG, POISSON = 210e3, 0.3
SIZE, HALF, BLOCK = 0.6, 9.0, 100.0  # mm


def cells_of(element):
    """A row of cells of 0.6 mm in the middle of the top of a block that is held at its base."""
    corners = [(-BLOCK, -BLOCK), (BLOCK, -BLOCK), (BLOCK, 0.0), (HALF, 0.0), (-HALF, 0.0), (-BLOCK, 0.0)]
    along = np.linspace(-HALF, HALF, 31)
    zone = Refinement(np.stack((along, np.zeros(31)), axis=1), size=SIZE, growth=0.4)
    mesh = triangulate(polygon(corners), size=30.0, refinements=[zone])
    mesh = dual(mesh) if isinstance(element, Virtual) else mesh
    edges, points = mesh.boundary_edges, mesh.points
    ends = points[edges]
    base = edges[(np.abs(ends[:, :, 1] + BLOCK) < 1e-9).all(axis=1)]
    top = edges[(np.abs(ends[:, :, 1]) < 1e-9).all(axis=1) & (np.abs(ends[:, :, 0]) < HALF + 1e-9).all(axis=1)]
    top = top[np.argsort(-points[top[:, 0], 0])]
    space = Space(mesh.with_edge_set("base", base), element)
    problem = Harmonic(Elasticity(space, Elastic(YOUNG, POISSON)), held={"base": "xyz"})
    return SurfaceCells(problem, top, np.linspace(0.0, 2.0 * HALF, 31))


@cache
def table_of(element) -> ComplianceTable:
    """Table of the block."""
    return compliance_table(cells_of(element), 1e-3, np.pi / SIZE, 1e-3)


def table() -> ComplianceTable:
    """Table of the block with finite elements."""
    return table_of(Lagrange(2))


@given(
    element=st.sampled_from([Lagrange(1), Lagrange(2), Virtual(1), Virtual(2), Virtual(3)]),
    poisson=st.floats(-0.5, 0.49),
    exponent=st.floats(-3.0, 1.5),
    support=st.sampled_from(["held", "foundation"]),
    share=st.floats(0.05, 0.9),
)
@settings(settings.get_profile("costly"))
def test_the_compliance_at_a_wavenumber_is_symmetric_and_positive_definite(
    element, poisson, exponent, support, share
) -> None:
    """For every element, material, wavenumber and support; so are the coefficients of a force and of one across it."""
    mesh = rectangle_grid(3.0, 2.0, 3, 2)
    mesh = dual(mesh) if isinstance(element, Virtual) else mesh
    edges = mesh.boundary_edges
    heights = mesh.points[edges][:, :, 1]
    mesh = mesh.with_edge_set("base", edges[(heights < 1e-9).all(axis=1)])
    top = edges[(heights > 2.0 - 1e-9).all(axis=1)]
    top = top[np.argsort(-mesh.points[top[:, 0], 0])]
    elasticity = Elasticity(Space(mesh, element), Elastic(7.0, poisson))
    springs = [Foundation("base", 1.0, 0.1, 0.3)]
    problem = Harmonic(elasticity, held={"base": "xyz"}) if support == "held" else Harmonic(elasticity, (), springs)
    cells = SurfaceCells(problem, top, 3.0 * np.array([0.0, share / 2.0, share, 1.0]))
    values = cells.compliance(10.0**exponent)
    np.testing.assert_allclose(values, values.T, atol=1e-12 * values.max())
    assert np.linalg.eigvalsh(values).min() > 0.0
    # at the wavenumbers given the integrals keep the symmetry: what one force moves another moves
    found = ComplianceTable(cells, np.array([0.1, 0.3, 1.0, 3.0]), np.stack([values] * 4), 0.0).influence(0.5, 6)
    np.testing.assert_allclose(found[0], found[0].T, atol=1e-9 * abs(found).max())
    turned = np.tile([1.0, 1.0, -1.0], 3)
    np.testing.assert_allclose(found.swapaxes(1, 2), turned[:, None] * found * turned, atol=1e-9 * abs(found).max())


def test_far_forces_act_as_on_a_half_space() -> None:
    """Normal and longitudinal displacement at 6 mm along z are those of Boussinesq's point force, but for a constant.

    A pull along the normal moves what is beside it away from it: u_z = +(1 + nu)(1 - 2 nu) / (2 pi E z).
    """
    found = table().influence(SIZE, 21).reshape(21, 30, 3, 30, 3)[:, 15, :, 15, :]
    distances = SIZE * np.arange(21)
    exact = (1.0 - POISSON**2) / (np.pi * YOUNG)
    rise = found[5, 1, 1] - found[20, 1, 1]
    assert rise == pytest.approx(exact * (1.0 / distances[5] - 1.0 / distances[20]), rel=0.02)
    sideways = (1.0 + POISSON) * (1.0 - 2.0 * POISSON) / (2.0 * np.pi * YOUNG * distances[10])
    assert found[10, 2, 1] == pytest.approx(sideways, rel=0.05)
    np.testing.assert_allclose(found[:, 1, 2], -found[:, 2, 1], atol=0.02 * abs(found[1, 2, 1]))


@pytest.mark.parametrize("element", [Lagrange(2), Virtual(1)])
def test_coefficients_of_the_nearest_cells_are_those_of_a_half_space(element) -> None:
    """Less what the body adds, all nine are Boussinesq's and Cerruti's to 0.3 % of the largest."""
    exact = half_space_influence(YOUNG, POISSON, SIZE * np.arange(8), SIZE, 5).reshape(5, 7, 3, 7, 3)[:, :, :, 3]
    found = table_of(element).influence(SIZE, 11).reshape(11, 30, 3, 30, 3)[:, 12:19, :, 15]
    body = np.diag(
        found[10, 3].diagonal() - half_space_influence(YOUNG, POISSON, SIZE * np.arange(2), SIZE, 11)[10].diagonal()
    )
    assert abs(found[:5] - body - exact).max() < 3e-3 * exact.max()


def test_cells_of_an_orthotropic_body_are_not_corrected() -> None:
    """There is no closed form: the coefficients are the sums over the wavenumbers alone, at all distances."""
    cells = cells_of(Lagrange(1))
    material = Orthotropic((2e5, 2e5, 2e5), (0.2, 0.2, 0.2), 8e4, longitudinal=(9e4, 9e4))
    elasticity = replace(cells.problem.elasticity, material=material)
    problem = Harmonic(elasticity, held={"base": "xyz"})
    found = compliance_table(SurfaceCells(problem, cells.edges, cells.bounds), 0.1, 4.0, 1e-2)
    even, _ = inverse_weights(found.wavenumbers, SIZE * np.arange(4.0), SIZE)
    expected = np.einsum("zk,kab->zab", even, found.values[:, 1::3, 1::3])
    np.testing.assert_allclose(found.influence(SIZE, 4, (1,)), expected, rtol=1e-9)


def test_short_waves_do_not_need_the_whole_mesh(monkeypatch) -> None:
    """On a mesh cut below the surface the compliance is that of the whole one to 3e-5, with fewer unknowns."""
    cells = cells_of(Lagrange(2))
    depths = {}
    for wavenumber in (0.5, 2.0, 8.0):
        found, n_bytes = cells.compliance_and_bytes(wavenumber)
        monkeypatch.setattr(surface_compliance, "CUTS", ())
        exact, n_whole = cells_of(Lagrange(2)).compliance_and_bytes(wavenumber)
        monkeypatch.undo()
        np.testing.assert_allclose(found, exact, atol=3e-5 * exact.max())
        depths[wavenumber] = n_bytes / n_whole
    assert depths[8.0] < 0.95


@pytest.mark.parametrize("element", [Lagrange(2), Virtual(1), Virtual(3)])
def test_the_compliance_is_the_displacement_of_cells_by_loads_on_them(element) -> None:
    """It is P' K^-1 P of the whole stiffness, with the unknowns inside cells, to 1e-9."""
    cells = cells_of(element)
    problem = cells.problem
    nodes, loads = cells.nodes_and_loads
    free = problem.free(0.2).ravel()
    forces = np.zeros((free.size, loads.shape[1]))
    forces[(3 * nodes[:, None] + np.arange(3)).ravel()] = loads
    exact = forces[free].T @ splu(problem.stiffness(0.2).restricted(free).full().tocsc()).solve(forces[free])
    np.testing.assert_allclose(cells.compliance(0.2), exact, atol=1e-9 * exact.max())


def test_frames_of_cells_on_a_polygon_turn_as_its_circle_does() -> None:
    """On pairs of straight edges and cells that do not fit them, tangents are the circle's to 2 % of an edge."""
    mesh = dual(triangulate(circle(1.0), size=0.1))
    edges = mesh.boundary_edges
    following = dict(edges.tolist())
    chain = [edges[0].tolist()]
    while len(chain) < 40:
        chain.append([chain[-1][1], following[chain[-1][1]]])
    problem = Harmonic(Elasticity(Space(mesh, Virtual(1)), Elastic(1.0, 0.3)))
    cells = SurfaceCells(problem, np.array(chain), np.arange(0.2, 1.5, 0.06))
    radial = cells.middles / np.linalg.norm(cells.middles, axis=1)[:, None]
    errors = radial[:, 0] * cells.frames[:, 1, 1] - radial[:, 1] * cells.frames[:, 1, 0]
    assert abs(errors).max() < 0.02 * cells.longest_edge


def test_the_error_of_the_interpolation_is_not_more_than_what_is_stated() -> None:
    """Between its wavenumbers the table errs by no more than it states, and a smaller tolerance makes it smaller."""
    cells = cells_of(Lagrange(1))
    for tolerance in (3e-3, 1e-5):
        found = compliance_table(cells, 1e-3, np.pi / SIZE, tolerance)
        assert 0.0 < found.error <= tolerance
        logs, scaled = np.log(found.wavenumbers), found.values * found.wavenumbers[:, None, None]
        spline = CubicSpline(logs, scaled)
        for middle in ((logs[:-1] + logs[1:]) / 2.0)[:: len(logs) // 8]:
            exact = np.exp(middle) * cells.compliance(float(np.exp(middle)))
            assert abs(spline(middle) - exact).max() <= found.error * abs(scaled).max()


def test_a_table_is_kept_by_its_content(tmp_path, monkeypatch) -> None:
    """A second process reads the table; another material, foundation or cells compute anew."""
    cache = Cache(tmp_path, 10**9)
    cells = cells_of(Lagrange(1))
    first = compliance_table(cells, 0.1, 2.0, 1e-2, cache=cache)

    def refuse(*_):
        raise AssertionError("computed")

    monkeypatch.setattr(SurfaceCells, "compliance_and_bytes", refuse)
    again = compliance_table(cells_of(Lagrange(1)), 0.1, 2.0, 1e-2, cache=cache)
    np.testing.assert_array_equal(again.values, first.values)
    assert again.error == first.error
    elasticity = cells.problem.elasticity
    softer = replace(elasticity, material=Elastic(YOUNG / 2.0, POISSON))
    for other in (
        SurfaceCells(Harmonic(softer, held={"base": "xyz"}), cells.edges, cells.bounds),
        SurfaceCells(Harmonic(elasticity, foundations=[Foundation("base", 1.0, 1.0, 1.0)]), cells.edges, cells.bounds),
        SurfaceCells(cells.problem, cells.edges, cells.bounds[:-1]),
    ):
        with pytest.raises(AssertionError, match="computed"):
            compliance_table(other, 0.1, 2.0, 1e-2, cache=cache)


def test_an_interrupt_drops_the_wavenumbers_that_have_not_begun(monkeypatch) -> None:
    """Ctrl-C at the third wavenumber ends the computation with few more than those at work."""
    begun = []
    original = SurfaceCells.compliance_and_bytes

    def interrupted(self, wavenumber):
        begun.append(wavenumber)
        if len(begun) == 3:
            raise KeyboardInterrupt
        if len(begun) > 3:
            time.sleep(0.2)  # what drops the others gets the processor, however busy the machine is
        return original(self, wavenumber)

    monkeypatch.setattr(SurfaceCells, "compliance_and_bytes", interrupted)
    with pytest.raises(KeyboardInterrupt):
        compliance_table(cells_of(Lagrange(1)), 1e-6, 100.0, 1e-2)
    assert len(begun) <= 3 + 2 * n_threads()


def test_a_table_asks_for_memory_before_it_takes_it(monkeypatch) -> None:
    """Tables and coefficients that do not fit are refused, with their size."""
    found = table()
    monkeypatch.setenv("FLANGEWAY_MEMORY_GB", "0.001")
    with pytest.raises(OutOfMemoryError, match=r"the compliance of 30 cells at .* wavenumbers, which needs"):
        compliance_table(found.cells, 1e-3, 1.0)
    with pytest.raises(OutOfMemoryError, match="influence coefficients of 30 x 100000 cells"):
        found.influence(SIZE, 100_000)


def test_wrong_cells_are_refused() -> None:
    """Edges that do not follow each other, and a prism that nothing holds, end in clear errors."""
    cells = cells_of(Lagrange(1))
    with pytest.raises(InputError, match="follow each other"):
        SurfaceCells(cells.problem, cells.edges[::-1])
    loose = Harmonic(cells.problem.elasticity)
    with pytest.raises(InputError, match="without strain"):
        SurfaceCells(loose, cells.edges).compliance(1e-9)
