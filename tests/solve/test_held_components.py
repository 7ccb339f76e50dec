"""Bodies that are held in some components only."""

import tracemalloc
from collections.abc import Mapping
from typing import Any

import numpy as np
import pytest
import scipy.sparse as sp

from flangeway.contact import solve_contact
from flangeway.elements import Lagrange
from flangeway.errors import InputError
from flangeway.geometry import Placement
from flangeway.materials import Elastic
from flangeway.mesh import rectangle_grid
from flangeway.problems import Body
from flangeway.solve import CondensedBodies, SparseBodies, SurfaceNodes

MATERIAL = Elastic(20e3, 1.0 / 3.0)
WIDTH, HEIGHT, PRESSURE = 2.0, 1.0, 1125.0


def block(held: str | Mapping[Any, Any] | None) -> Body:
    """A block of quadratic triangles."""
    return Body("block", rectangle_grid(WIDTH, HEIGHT, 4, 3), Lagrange(2), MATERIAL, held, thickness=3.0)


def pressed_top(body: Body) -> tuple[SurfaceNodes, np.ndarray]:
    """Nodes of the top and the forces of a uniform pressure on them."""
    edges = body.space.edge_nodes(body.mesh.edge_sets["top"])
    nodes, place = np.unique(edges, return_inverse=True)
    forces = np.zeros((len(nodes), 2))
    share = PRESSURE * body.thickness * WIDTH / 4.0 * np.array([1.0, 4.0, 1.0]) / 6.0
    np.add.at(forces[:, 1], place.ravel(), -np.tile(share, len(edges)))
    return SurfaceNodes(body, nodes.astype(np.int32)), forces


@pytest.mark.parametrize(
    "held",
    [
        {"bottom": "y", (0.0, 0.0): "x"},
        {"bottom": "y", "left": "x"},
        {"bottom": "y", "left": "x", (0.0, 0.0): "xy"},
    ],
)
@pytest.mark.parametrize("kind", [CondensedBodies, SparseBodies])
@pytest.mark.parametrize("angle", [0.0, 0.6])
def test_a_block_on_a_greased_plate_strains_uniformly(held: Any, kind: Any, angle: float) -> None:
    """A block that slides on its bottom, held sideways at a point or on a line of symmetry, is pressed uniformly."""
    body = block(held)
    surface, forces = pressed_top(body)
    response = kind([surface])
    place = Placement(angle)
    rotations = response.rotations([place])
    moved = response.displacements(rotations, np.arange(len(surface.nodes)), place.vectors(forces))
    modulus = MATERIAL.young / (1.0 - MATERIAL.poisson**2)
    lateral = PRESSURE / modulus * MATERIAL.poisson / (1.0 - MATERIAL.poisson)
    x, y = body.space.nodes[surface.nodes].T
    expected = np.stack((lateral * x, -PRESSURE / modulus * y), axis=1)
    np.testing.assert_allclose(moved, place.vectors(expected), atol=1e-13)
    field = response.fields(rotations, place.vectors(forces))[0][: body.space.n_nodes]
    x, y = body.space.nodes.T
    np.testing.assert_allclose(field, np.stack((lateral * x, -PRESSURE / modulus * y), axis=1), atol=1e-13)


def test_both_paths_answer_alike_where_a_surface_is_held_sideways() -> None:
    """A tangent with geometric stiffness on a node held in x gives one answer on the surface and on all unknowns."""
    body = block({"bottom": "y", "left": "x"})
    surface, forces = pressed_top(body)
    n = 2 * len(surface.nodes)
    rng = np.random.default_rng(3)
    root = rng.normal(size=(n, n))
    right = np.stack((forces.ravel(), rng.normal(size=n)), axis=1)
    answers = []
    for kind in (CondensedBodies, SparseBodies):
        response = kind([surface])
        rotations = response.rotations([Placement(0.3)])
        loads = sp.csr_array(right)
        tangent = sp.csr_array(100.0 * root @ root.T)
        answers.append(response.tangent(rotations, np.arange(len(surface.nodes)), tangent)(loads))
    np.testing.assert_allclose(answers[0], answers[1], atol=1e-10 * np.abs(answers[1]).max())


@pytest.mark.parametrize(
    ("held", "message"),
    [
        ("base", "edge sets: bottom, left, right, top"),
        ({}, "at least one edge set"),
        ({"bottom": "z"}, "'x', 'y' or 'xy'"),
        ({"bottom": "y", "side": "x"}, "held along 'side'"),
        ({"bottom": "y", (0.1, 0.0): "x"}, "a node of the mesh"),
    ],
)
def test_supports_that_make_no_sense_are_refused(held: Any, message: str) -> None:
    """Unknown names, components and points are named."""
    with pytest.raises(InputError, match=message):
        _ = block(held).free


def test_a_surface_that_is_held_wholly_cannot_be_in_contact() -> None:
    """A surface all of whose nodes are held in both components is refused with the name of what holds it."""
    body = block({"bottom": "y", "top": "xy"})
    with pytest.raises(InputError, match="'top': 'xy'"):
        CondensedBodies([pressed_top(body)[0]])


@pytest.mark.parametrize("kind", [CondensedBodies, SparseBodies])
@pytest.mark.parametrize(
    ("held", "motion"),
    [
        ({(0.0, 0.0): "xy", (2.0, 0.0): "x"}, r"can turn about \(0, 0\)"),
        ({(0.0, 0.0): "x", (2.0, 0.0): "x"}, r"can turn about \(0, 0\)"),
    ],
)
def test_a_body_that_can_turn_in_a_first_moment_is_refused(kind: Any, held: Any, motion: str) -> None:
    """A turn that two points allow for a moment only: both paths name it, before anything is factorised."""
    surface, _ = pressed_top(block(held))
    with pytest.raises(InputError, match=f"body `block` {motion}"):
        kind([surface])


@pytest.mark.parametrize(
    ("held", "axes", "turns"),
    [
        ({"bottom": "y"}, "x", False),
        ({(0.0, 0.0): "x", (0.0, 1.0): "x"}, "y", False),
        ({(0.0, 0.0): "xy"}, "", True),
        ({(0.0, 0.0): "y"}, "x", True),
        (None, "xy", True),
        ("bottom", "", False),
    ],
)
def test_motions_that_supports_leave_free_are_known(held: Any, axes: str, turns: bool) -> None:
    """What is held leaves sliding, turning about its one point, or both; a problem of held bodies refuses such ones."""
    body = block(held)
    assert (body.freedom.axes, body.freedom.turns) == (axes, turns)
    surface, _ = pressed_top(body) if held != "bottom" else pressed_top(block("left"))
    if body.freedom.n_motions:
        with pytest.raises(InputError, match="leaves free to move"):
            solve_contact(CondensedBodies([surface]), None, (Placement(),))  # type: ignore[arg-type]


def test_many_held_nodes_take_little_memory():
    """Whether 4,000 held nodes let a body slide is found in less than 10 MB: not by a matrix of nodes by nodes."""
    mesh = rectangle_grid(4000.0, 1.0, 4000, 1)
    body = Body("strip", mesh, Lagrange(1), Elastic(210e3, 0.3), {"bottom": "y"})
    assert body.supported.any()
    tracemalloc.start()
    try:
        assert body.freedom.axes == "x"
        assert tracemalloc.get_traced_memory()[1] < 10e6
    finally:
        tracemalloc.stop()
