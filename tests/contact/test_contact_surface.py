"""Surfaces are one chain of boundary edges, however they are given."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from flangeway.contact import Surface
from flangeway.elements import Lagrange
from flangeway.errors import InputError
from flangeway.geometry import Placement
from flangeway.materials import Elastic
from flangeway.mesh import rectangle_grid
from flangeway.problems import Body, Part

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
