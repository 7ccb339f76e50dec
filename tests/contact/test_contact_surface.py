"""Surfaces are one chain of boundary edges; long ones choose a path; their compliance is a half-space's and more."""

import sys

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from flangeway.contact import Multiplier, SegmentToSegment, Surface
from flangeway.contact.patch.normal_contact import elastic_surface
from flangeway.elements import Lagrange
from flangeway.errors import InputError
from flangeway.exact import half_space_influence
from flangeway.geometry import Placement, circle
from flangeway.materials import Elastic
from flangeway.mesh import rectangle_grid, triangulate
from flangeway.problems import Body, Elasticity, Harmonic, Part
from flangeway.solve import CondensedBodies, SparseBodies, SurfaceCells, compliance_table, condensed_bytes
from flangeway.solve.surface_compliance import half_spaces_on
from flangeway.space import Space
from tests.contact.steel_boxes import BoxDiscretisation, pressed_boxes
from tests.contact.test_friction import blocks, pushed

MESH = rectangle_grid(3.0, 2.0, 6, 4)
BLOCK = Part("block", Body("block", MESH, Lagrange(2), Elastic(210e3, 0.3), "bottom"))
TOP = MESH.edge_sets["top"]


@given(st.permutations(range(6)), st.lists(st.booleans(), min_size=6, max_size=6))
def test_order_and_direction_do_not_matter(order: list[int], turned: list[bool]) -> None:
    """Edges in any order, each in either direction, make the surface that they make in order."""
    edges = TOP[np.array(order)].copy()
    edges[np.array(turned)] = edges[np.array(turned)][:, ::-1]
    surface = Surface(BLOCK, edges)
    assert surface.edges.tolist() == TOP.tolist()
    assert surface.nodes.tolist() == Surface(BLOCK, TOP).nodes.tolist()


def test_names_and_a_box_make_the_surface_of_their_edges() -> None:
    """By name it is the surface of the edge set; with a box that of the edges inside; parts share a body's part."""
    assert Surface(BLOCK, "top").edges.tolist() == TOP.tolist()
    assert Surface(BLOCK, ["top", "left"]).edges.tolist() == [*TOP.tolist(), *MESH.edge_set("left")[:-1].tolist()]
    inner = Surface(BLOCK, "top", within=(0.4, 1.0, 2.1, 3.0))
    assert inner.edges.tolist() == TOP[2:-1].tolist()
    body = BLOCK.body
    assert Surface(body.part, "top").part is Surface(body.part, "left").part
    assert body.part.name == body.name


def test_the_surface_by_default_is_all_that_can_move() -> None:
    """Without edges a surface is the boundary without the edges that meet what is held."""
    free = Surface(BLOCK)
    assert len(free.edges) == len(MESH.boundary_edges) - len(MESH.edge_set("bottom")) - 2
    assert free.part.body.nodes[free.nodes][:, 1].min() == 0.5
    with pytest.raises(InputError, match="held all along"):
        Surface(BLOCK, "bottom")
    with pytest.raises(InputError, match="within"):
        Surface(BLOCK, TOP, within=(0.0, 0.0, 1.0, 1.0))


def test_closed_surfaces_stay_closed() -> None:
    """The whole boundary in any order is one closed chain with as many points as edges."""
    edges = MESH.boundary_edges
    shuffled = np.random.default_rng(0).permutation(edges)[:, ::-1]
    surface = Surface(BLOCK, shuffled)
    assert (surface.edges[1:, 0] == surface.edges[:-1, 1]).all()
    assert surface.edges[-1, 1] == surface.edges[0, 0]
    assert len(surface.nodes) == 2 * len(edges)


def test_mirrored_parts_have_their_body_on_the_left() -> None:
    """Nodes of a mirrored part run the other way in the mesh, so that in space the body is on the left again."""
    mirrored = Part("twin", BLOCK.body, Placement(mirrored=True))
    plain, twin = Surface(BLOCK, TOP[::-1]), Surface(mirrored, TOP[:, ::-1])
    assert twin.nodes.tolist() == plain.nodes[::-1].tolist()


@pytest.mark.parametrize(
    ("edges", "message"),
    [
        (np.zeros((0, 2), dtype=np.int32), "shape"),
        (np.array([0, 1]), "shape"),
        (np.array([[0.0, 1.0]]), "type float64"),
        (np.array([[0, 8]]), "inside the body"),
        (np.array([[0, 2]]), "the ends of an edge"),
        (np.array([[0, 99]]), "numbers from 0 to"),
        (np.concatenate((TOP, TOP[:1, ::-1])), "contact surface of 'block'"),
        (np.concatenate((TOP[:2], TOP[3:])), "2 chains, which start at"),
        (np.concatenate((TOP, MESH.edge_sets["bottom"])), "one contact for each chain"),
    ],
)
def test_what_is_no_chain_is_refused(edges: np.ndarray, message: str) -> None:
    """Edges inside the body, missing, doubled, interrupted or on two sides are refused with the reason."""
    with pytest.raises(InputError, match=message):
        Surface(BLOCK, edges)


def test_the_path_that_is_chosen_has_the_same_answer(monkeypatch: pytest.MonkeyPatch) -> None:
    """Condensed below the limit, sparse above it with few loads at a time: both agree to 1e-9."""
    meshes = BoxDiscretisation(0.31, "fem", 2), BoxDiscretisation(0.23, "vem", 1)
    case = pressed_boxes(*meshes, SegmentToSegment(), Multiplier(), rotation_rad=0.3)
    condensed = case.solve()
    assert isinstance(condensed.response, CondensedBodies)
    needed = condensed_bytes(condensed.system.surface_nodes)
    assert needed > 8 * 6 * max(2 * len(each.nodes) for each in condensed.system.surface_nodes) ** 2
    monkeypatch.setattr(sys.modules["flangeway.contact.press"], "MAX_DENSE_BYTES", needed - 1)
    monkeypatch.setattr("flangeway.solve.condensed.ENTRIES_AT_ONCE", 1000)
    sparse = case.solve()
    assert isinstance(sparse.response, SparseBodies)
    assert sparse.status.converged
    np.testing.assert_allclose(sparse.forces, condensed.forces, rtol=1e-9)
    pressures = condensed.state.forces
    np.testing.assert_allclose(sparse.state.forces, pressures, atol=1e-9 * pressures.max())


def test_friction_without_a_dense_matrix_has_the_same_answer(monkeypatch: pytest.MonkeyPatch) -> None:
    """Above the limits bodies and constraints are solved in one sparse factorisation: pressed and pushed to and fro."""

    def solved():
        path = (0.0, -0.01), (0.004, 0.0), (-0.003, 0.0)
        return pushed(blocks(SegmentToSegment(), Multiplier(), order=2), *path)

    dense = solved()
    assert isinstance(dense.response, CondensedBodies)
    monkeypatch.setattr(sys.modules["flangeway.contact.press"], "MAX_DENSE_BYTES", 1e4)
    monkeypatch.setattr("flangeway.contact.contact_step.MAX_DENSE_EQUATIONS", 0)
    monkeypatch.setattr("flangeway.solve.active_set.equations", None)  # which solves dense ones
    sparse = solved()
    assert isinstance(sparse.response, SparseBodies)
    assert sparse.status.converged, sparse.status.message
    assert dense.state.friction is not None
    assert sparse.state.friction is not None
    assert dense.state.friction.sticks.any()
    assert dense.dissipated_work.any()
    atol = 1e-9 * dense.state.forces.max()
    np.testing.assert_allclose(sparse.state.forces, dense.state.forces, atol=atol)
    np.testing.assert_allclose(sparse.state.friction.forces, dense.state.friction.forces, atol=atol)


STEEL = Elastic(210e3, 0.3)


@pytest.fixture(scope="module")
def bar():
    """A steel bar of the radius 20 mm, held at its lower half; and the edges of its upper half."""
    mesh = triangulate(circle(20.0), size=1.5)
    chain = mesh.chain(*sorted(mesh.edge_sets))[:-1]
    points = mesh.points[chain]
    start = int(np.flatnonzero((points[:, 1] > 0.0) & (np.roll(points[:, 1], 1) <= 0.0))[0])
    chain = np.roll(chain, -start).astype(np.int64)
    count = int((mesh.points[chain][:, 1] > 0.0).sum())
    edges = np.stack((chain[:-1], chain[1:]), axis=1)
    mesh = mesh.with_edge_set("below", edges[count + 2 :])
    return Harmonic(Elasticity(Space(mesh, Lagrange(2)), STEEL), held={"below": "xyz"}), edges[: count - 1]


def cells_of(bar, count):
    problem, edges = bar
    points = problem.elasticity.space.mesh.points
    length = float(np.linalg.norm(points[edges[:, 1]] - points[edges[:, 0]], axis=1).sum())
    return SurfaceCells(problem, edges, np.linspace(0.0, length, count + 1))


def test_cells_of_a_plane_have_the_coefficients_of_a_half_space() -> None:
    """On a flat surface cells have the half-space's coefficients to round-off, with frames and without."""
    limits = np.array([0.0, 0.4, 0.8, 2.0, 2.3])
    expected = half_space_influence(210e3, 0.3, limits, 0.5, 4).reshape(4, 4, 3, 4, 3)
    for frames in (np.tile(np.diag([1.0, -1.0, 1.0]), (4, 1, 1)), None):
        assert half_spaces_on((STEEL,), limits, frames, 0.5, 4) == pytest.approx(expected, rel=1e-12)


@pytest.mark.ci
def test_half_space_and_remainder_give_the_compliance_on_other_cells(bar) -> None:
    """Interpolated to cells of half the width, they agree with the compliance of these cells to 2 % of the largest."""
    surface = elastic_surface(cells_of(bar, 20))
    fine = cells_of(bar, 40)
    strip, n_strips = 1.5, 10
    direct = compliance_table(fine, 2e-5, 2.0 * np.pi / strip).influence(strip, n_strips)
    direct = direct.reshape(n_strips, 40, 3, 40, 3)
    stations = (fine.limits[1:] + fine.limits[:-1]) / 2.0
    across, along = surface.interpolation(stations), surface.along(strip * np.arange(n_strips))
    remainder = np.einsum("zk,ia,xakyb,jb->zixjy", along, across, surface.on_splines, across, optimize=True)
    remainder = np.einsum("iax,zixjy,jby->ziajb", fine.frames, remainder, fine.frames, optimize=True)
    total = half_spaces_on((STEEL,), fine.limits, fine.frames, strip, n_strips) + remainder
    middle = slice(6, 34)
    for axis in (0, 1):
        expected = direct[:, middle, axis, middle, axis]
        assert total[:, middle, axis, middle, axis] == pytest.approx(expected, abs=0.02 * expected.max())
