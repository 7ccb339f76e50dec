"""Bodies given by a stiffness matrix: the same contact as that of our own mesh, and what is refused."""

from dataclasses import replace
from typing import Any

import numpy as np
import pytest
import scipy.sparse as sp

from flangeway.contact import Contact, Multiplier, NodeToSegment, Penalty, SegmentToSegment, Surface, press
from flangeway.elements import Lagrange, Virtual
from flangeway.errors import InputError
from flangeway.geometry import Placement, circle, rectangle
from flangeway.materials import Elastic, Orthotropic
from flangeway.mesh import PolyMesh, dual, rectangle_grid, triangulate
from flangeway.problems import Body, Part, StiffnessBody

STEEL = Elastic(210e3, 0.3)
LOWER = rectangle_grid(3.0, 1.0, 7, 3, origin=(-1.5, -1.0))
UPPER = rectangle_grid(1.0, 1.0, 4, 3, origin=(-0.5, 0.0))


def around(mesh: PolyMesh, body: Body) -> list[int]:
    """Nodes of the closed boundary, from the lower left corner."""
    edges = body.edge_nodes(mesh.boundary_edges)
    following = {int(edge[0]): edge for edge in edges}
    line = [int(edges[0, 0])]
    while len(line) == 1 or line[-1] != line[0]:
        line += following[line[-1]][1:].tolist()
    return line


def foreign(body: Body, *, seed: int = 0, only_free: bool = False, inner: bool = False) -> StiffnessBody:
    """The body's stiffness with its nodes and unknowns in a random order, as another program may number them."""
    rng = np.random.default_rng(seed)
    matrix = sp.csr_array(
        (body.elasticity.stiffness() if inner else body.elasticity.condensed_stiffness().matrix).full()
    )
    n_nodes, n = len(body.nodes), matrix.shape[0]
    node_order, order = rng.permutation(n_nodes), rng.permutation(n)
    place = np.argsort(order)  # row of each unknown
    rows = place[: 2 * n_nodes].reshape(-1, 2)
    free = np.ones(n, dtype=bool)
    free[: 2 * n_nodes] = body.free[: 2 * n_nodes]
    held: Any = np.isin(rows, place[np.flatnonzero(~free)])
    matrix = matrix[order][:, order]
    if only_free:
        kept = np.setdiff1d(np.arange(n), rows[held])
        number = np.full(n, -1)
        number[kept] = np.arange(len(kept))
        matrix, rows, held = matrix[kept][:, kept], number[rows], np.zeros_like(held)
    mine = np.argsort(node_order)
    line = mine[around(body.mesh, body)]
    return Body.from_stiffness(
        body.name,
        matrix,
        body.nodes[node_order],
        {"boundary": line.tolist()},
        order=body.space.order,
        rows=rows[node_order],
        held=held[node_order],
        thickness=body.thickness,
    )


def surface(part: Part, low: float, high: float) -> Surface:
    """The part's edges between two heights of its own frame."""
    edges = part.body.boundary_edges
    heights = part.body.nodes[edges][:, :, 1]
    return Surface(part, edges[((heights >= low) & (heights <= high)).all(axis=1)])


def pressed(lower: Any, upper: Any, pairing: Any, enforcement: Any, **options: Any) -> Any:
    """Two blocks, the upper one turned with the ground and mirrored, pressed upon the lower one."""
    ground = Placement(0.4, (2.0, 1.0))
    parts = [Part("lower", lower, ground), Part("upper", upper, Placement(0.43, (2.0, 1.0), mirrored=True))]
    contact = Contact(surface(parts[1], 0.0, 0.0), surface(parts[0], 0.0, 0.0), pairing, enforcement)
    down = ground.vectors([[0.0, -0.02]])[0]
    return parts, press([contact], {parts[1]: Placement(0.0, (float(down[0]), float(down[1])))}, **options)


CASES = {
    "linear": (Lagrange(1), SegmentToSegment(), Multiplier(), {}),
    "quadratic": (Lagrange(2), NodeToSegment(), Penalty(1e7, per="length"), {"only_free": True}),
    "virtual": (Virtual(2), SegmentToSegment(), Multiplier(), {"inner": True}),
}


@pytest.mark.parametrize(("case", "path"), [("linear", "condensed"), ("quadratic", "sparse"), ("virtual", "sparse")])
def test_a_matrix_in_any_order_gives_the_contact_of_its_mesh(case: str, path: Any) -> None:
    """Forces, displacements and nodal forces equal those of the meshes, whatever the numbering and the placement."""
    element, pairing, enforcement, how = CASES[case]
    own = [
        Body("lower", LOWER, element, STEEL, "bottom", 2.0),
        Body("upper", UPPER, element, STEEL, {"top": "xy"}, 2.0),
    ]
    (lower, upper), expected = pressed(*own, pairing, enforcement)
    given = [foreign(body, seed=number, **how) for number, body in enumerate(own)]
    parts, found = pressed(*given, pairing, enforcement, path=path)
    assert expected.status.converged
    assert found.status.converged, found.status.message
    assert np.abs(expected.forces).max() > 100.0
    np.testing.assert_allclose(found.forces, expected.forces, rtol=1e-10)
    for part, mine in zip((lower, upper), parts, strict=True):
        same = [np.abs(mine.body.nodes - node).sum(axis=1).argmin() for node in part.body.nodes]
        forces = expected.nodal_forces(part)
        np.testing.assert_allclose(found.nodal_forces(mine)[same], forces, atol=1e-10 * np.abs(forces).max())
        field = expected.unknowns(part).reshape(-1, 2)[: len(same)]
        given = np.asarray(mine.body.rows)[same]
        moved = np.where(given >= 0, found.unknowns(mine)[given], 0.0)
        np.testing.assert_allclose(moved, field, atol=1e-10 * np.abs(field).max())


def test_stresses_and_meshes_are_refused_with_what_there_is() -> None:
    """A body of a matrix has no elements here: the message says what to take."""
    body = foreign(Body("lower", LOWER, Lagrange(1), STEEL, "bottom"))
    (lower, _), found = pressed(body, Body("upper", UPPER, Lagrange(1), STEEL, "top"), SegmentToSegment(), Multiplier())
    with pytest.raises(InputError, match=r"stresses of body 'lower'.*(?s:.*)solution.unknowns"):
        found.field(lower)


def good() -> dict[str, Any]:
    """A body that is right."""
    body = Body("block", LOWER, Lagrange(1), STEEL, "bottom")
    matrix = body.elasticity.stiffness().full()
    held = body.supported
    top = LOWER.edge_sets["top"]
    return {
        "stiffness": matrix,
        "coordinates": LOWER.points,
        "surfaces": {"top": [*top[:, 0].tolist(), int(top[-1, 1])]},
        "held": held,
    }


def made(**changes: Any) -> StiffnessBody:
    """The right body with some arguments changed."""
    return Body.from_stiffness("block", **{**good(), **changes})


@pytest.mark.parametrize("order", [1, 2])
def test_edges_in_any_order_and_direction_are_the_chain_of_their_nodes(order: int) -> None:
    """As mesh programs list them: shuffled, turned, the middle node last; open, and closed around the body."""
    body = Body("block", LOWER, Lagrange(order), STEEL, "bottom")
    rng = np.random.default_rng(order)
    for pairs in (LOWER.edge_sets["top"], LOWER.boundary_edges):
        edges = body.edge_nodes(np.where(rng.random(len(pairs))[:, None] < 0.5, pairs, pairs[:, ::-1]))
        edges = rng.permutation(edges)[:, [0, 2, 1] if order == 2 else [0, 1]]
        surface = {
            "stiffness": body.elasticity.stiffness().full(),
            "coordinates": body.nodes,
            "surfaces": {"s": edges},
            "held": body.supported,
            "order": order,
        }
        chain = Body.from_stiffness("block", **surface)
        found = chain.edge_nodes(chain.edge_sets["s"])
        np.testing.assert_array_equal(found[1:, 0], found[:-1, -1])
        np.testing.assert_array_equal(np.unique(found, axis=0), np.unique(body.edge_nodes(pairs), axis=0))


def unsymmetric() -> Any:
    matrix = good()["stiffness"].tolil()
    matrix[3, 2] += 1.0
    return matrix


def with_nan() -> Any:
    matrix = good()["stiffness"].toarray()
    matrix[5, 4] = np.nan
    return matrix


REFUSED = {
    "unsymmetric": (lambda: {"stiffness": unsymmetric()}, r"K\[2, 3\] is .* and K\[3, 2\] is"),
    "nan": (lambda: {"stiffness": with_nan()}, r"K\[5, 4\] is nan"),
    "complex": (lambda: {"stiffness": good()["stiffness"] * 1j}, "real numbers"),
    "too few nodes": (lambda: {"coordinates": LOWER.points[:-1]}, "64 rows with coordinates of 31 nodes"),
    "rows beyond": (lambda: {"rows": np.arange(1, 65).reshape(-1, 2)}, "numbers of rows below 64"),
    "all held": (lambda: {"held": np.ones((32, 2), dtype=bool)}, "all unknowns are held"),
    "indefinite on the diagonal": (lambda: {"stiffness": -good()["stiffness"]}, "positive definite"),
    "surface not in K": (lambda: {"surfaces": {"top": [30, 31, 32]}}, "surface 'top' has node 32"),
    "edges with a gap": (lambda: {"surfaces": {"top": [[31, 30], [29, 28]]}}, "have a gap at node 29"),
    "edges that branch": (lambda: {"surfaces": {"top": [[31, 30], [30, 29], [30, 22]]}}, "branch at node 30"),
    "flat mask": (lambda: {"held": np.ones(64, dtype=bool)}, r"shape \(32, 2\)"),
    "pairs": (lambda: {"held": np.ones((32, 2), dtype=int)}, "True for each component"),
    "middle nodes missing": (lambda: {"order": 2, "surfaces": {"top": [31, 30, 29, 28]}}, "odd number"),
    "crossing": (lambda: {"surfaces": {"top": [31, 22, 23, 30]}}, r"'top' crosses itself with the edges \(31, 22\)"),
    "clockwise": (lambda: {"surfaces": {"all": around(LOWER, Body("b", LOWER, Lagrange(1), STEEL, "top"))[::-1]}},
                  r"'all' has the body on its right"),
}  # fmt: skip


@pytest.mark.parametrize("what", REFUSED)
def test_what_is_wrong_is_refused_with_its_place(what: str) -> None:
    """Each wrong argument is an error that names where."""
    change, message = REFUSED[what]
    with pytest.raises(InputError, match=message):
        made(**change())


def hourglass(removed: float = 1.0) -> Any:
    """A stiffness that has a motion without energy which is not rigid, or above 1 with a negative energy."""
    matrix = good()["stiffness"].toarray()
    free = np.flatnonzero(~good()["held"])
    mode = np.zeros(64)
    mode[free] = np.random.default_rng(0).standard_normal(len(free))
    mode[free[-1]] = 9.0
    forces = matrix @ mode  # in equilibrium, so that rigid motions still make no force
    return matrix - removed * np.outer(forces, forces) / (mode @ forces)


@pytest.mark.parametrize(
    ("change", "message"),
    [
        (lambda: {"held": None}, "can slide in x, slide in y and turn"),
        (lambda: {"held": good()["held"] & [True, False]}, r"can slide in y and turn about \(0, -1\): its stiffness"),
        (lambda: {"held": good()["held"] & (np.arange(32) == 0)[:, None]}, r"can turn about \(-1.5, -1\)"),
        (lambda: {"stiffness": hourglass()}, "zero energy .* largest at node 31 at .* in y"),
        (lambda: {"stiffness": hourglass(1.5)}, "negative energy .* largest at node 31 at .* in y"),
    ],
)  # fmt: skip
def test_motions_without_energy_are_named(change: Any, message: str) -> None:
    """Rigid and other motions that the stiffness leaves free, or drives, are named before the iteration."""
    body = made(**change())
    upper = Body("upper", UPPER, Lagrange(1), STEEL, "top")
    with pytest.raises(InputError, match=message):
        pressed(body, upper, SegmentToSegment(), Multiplier())


def _rigid_case() -> tuple[Any, Any, Any]:
    mesh = rectangle_grid(2.0, 1.0, 6, 4)
    body = Body("block", mesh, Lagrange(1), STEEL, {"top": "xy"})
    matrix = sp.csr_array(body.elasticity.condensed_stiffness().matrix.full())
    return matrix, mesh.points, around(mesh, body)


@pytest.mark.parametrize("order", ["blocked", "swapped", "shifted", "permuted"])
def test_a_stiffness_in_another_order_than_its_nodes_is_refused(order) -> None:
    """Forces of rigid motions show rows by components, swapped axes, nodes counted from 1, and a permutation."""
    matrix, points, line = _rigid_case()
    of_node = np.arange(2 * len(points)).reshape(-1, 2)
    taken = {
        "blocked": of_node.T.ravel(),
        "swapped": of_node[:, ::-1].ravel(),
        "shifted": np.roll(of_node, 1, axis=0).ravel(),
        "permuted": of_node[np.random.default_rng(1).permutation(len(points))].ravel(),
    }[order]
    with pytest.raises(InputError, match="rigid motion"):
        Body.from_stiffness("block", matrix[taken][:, taken], points, {"boundary": line})


def test_springs_and_held_rows_in_a_stiffness_are_no_mistake() -> None:
    """A foundation on one side, rows without supports, and rows that were replaced for supports are accepted."""
    matrix, points, line = _rigid_case()
    top = np.flatnonzero(points[:, 1] == points[:, 1].max())
    held = (2 * top[:, None] + np.arange(2)).ravel()
    mask = np.isin(np.arange(len(points)), top)[:, None].repeat(2, axis=1)
    springs = np.zeros(matrix.shape[0])
    springs[held] = 1e4
    Body.from_stiffness("block", matrix + sp.diags_array(springs), points, {"boundary": line})
    kept = np.setdiff1d(np.arange(matrix.shape[0]), held)
    rows = np.full(matrix.shape[0], -1)
    rows[kept] = np.arange(len(kept))
    Body.from_stiffness("block", matrix[kept][:, kept], points, {"boundary": line}, rows=rows.reshape(-1, 2))
    free = 1.0 - mask.ravel()
    replaced = sp.diags_array(free) @ matrix @ sp.diags_array(free) + sp.diags_array(1.0 - free)
    Body.from_stiffness("block", replaced, points, {"boundary": line}, held=mask)


def _ring(n_edges: int, layers: int, size: float) -> PolyMesh:
    """Squares around a hole of radius 1."""
    turns, radii = np.meshgrid(np.arange(n_edges) * 2.0 * np.pi / n_edges, 1.0 + size * np.arange(layers + 1))
    points = np.column_stack(((radii * np.cos(turns)).ravel(), (radii * np.sin(turns)).ravel()))
    i, j = (each.ravel() for each in np.meshgrid(np.arange(n_edges), np.arange(layers)))
    following = (i + 1) % n_edges
    corners = (j * n_edges + i, (j + 1) * n_edges + i, (j + 1) * n_edges + following, j * n_edges + following)
    return PolyMesh.from_cells(points, np.column_stack(corners))


def _bodies() -> dict[str, Body]:
    """Bodies of linear, quadratic and virtual elements, straight, round, hollow and thin."""
    disc = triangulate(circle(5.0), size=1.5)
    meshes: dict[str, tuple[PolyMesh, Any]] = {
        "linear": (rectangle_grid(3.0, 1.0, 9, 3), Lagrange(1)),
        "quadratic": (rectangle_grid(3.0, 1.0, 8, 3), Lagrange(2)),
        "polygons": (dual(triangulate(rectangle(3.0, 2.0), size=0.4)), Virtual(1)),
        "round": (disc, Lagrange(1)),
        "round and quadratic": (disc, Lagrange(2)),
        "flat cells": (rectangle_grid(3.0, 0.1, 8, 10), Lagrange(2)),
        "hole": (_ring(7, 2, 0.5), Virtual(1)),
        "thin ring": (_ring(24, 1, 0.2), Virtual(2)),
    }
    return {name: Body(name, mesh, element, STEEL) for name, (mesh, element) in meshes.items()}


def _on_boundary(matrix: Any, lines: list[list[int]]) -> tuple[Any, Any]:
    """K condensed to the nodes of closed lines, and these nodes."""
    nodes = np.unique(np.concatenate(lines))
    kept = (2 * nodes[:, None] + np.arange(2)).ravel()
    inner = np.setdiff1d(np.arange(matrix.shape[0]), kept)
    full = matrix.toarray()
    follow = np.linalg.solve(full[np.ix_(inner, inner)], full[np.ix_(inner, kept)])
    condensed = full[np.ix_(kept, kept)] - full[np.ix_(kept, inner)] @ follow
    return (condensed + condensed.T) / 2.0, nodes


def _lines(body: Body) -> list[list[int]]:
    """Nodes of each closed boundary of a body."""
    edges = body.edge_nodes(body.mesh.boundary_edges)
    following = {int(edge[0]): edge for edge in edges}
    lines = []
    while following:
        line = [min(following)]
        while len(line) == 1 or line[-1] != line[0]:
            line += following.pop(line[-1])[1:].tolist()
        lines.append(line)
    return lines


@pytest.mark.parametrize("condensed", [True, False])
@pytest.mark.parametrize("name", _bodies())
def test_edges_that_are_not_those_of_the_stiffness_are_refused(name: str, condensed: bool) -> None:
    """Surfaces that skip nodes or have edges of another order have not the forces of a uniform pressure.

    Nor have holes, and surfaces of a stiffness condensed to the boundary, which couples all nodes.
    """
    body = _bodies()[name]
    order, nodes, lines = body.space.order, body.nodes, _lines(body)
    matrix = sp.csr_array(body.elasticity.condensed_stiffness().matrix.full())
    if condensed:
        matrix, kept = _on_boundary(matrix, lines)
        nodes, lines = nodes[kept], [np.searchsorted(kept, line).tolist() for line in lines]
    held = (np.arange(len(nodes)) < 2)[:, None].repeat(2, axis=1)
    for line in lines:
        for right in (line, line[: 4 * order + 1]):
            Body.from_stiffness(name, matrix, nodes, {"s": right}, order=order, held=held)
        skipping = line[::2] if line[-1] == line[::2][-1] else [*line[::2], line[0]]
        shifted = [*line[1:], line[1]] if order == 2 else line[: (len(line) - 1) // 2 * 2 + 1]
        wrong = [(1, skipping), (1, line[:2] + line[3:])] + ([(1, line), (2, shifted)] if order == 2 else [])
        if order == 1 and len(line) > 10:
            wrong.append((2, shifted))
        for other, surface in wrong:
            with pytest.raises(InputError, match=r"no edge of an element|forces of a uniform pressure"):
                Body.from_stiffness(name, matrix, nodes, {"s": surface}, order=other, held=held)


@pytest.mark.parametrize("name", ["linear", "quadratic", "hole", "thin ring"])
def test_the_side_of_an_open_surface_is_that_of_the_pressure(name: str) -> None:
    """Edges in any direction have the body on their left, around a hole too; turned chains are refused."""
    body = _bodies()[name]
    matrix, order = body.elasticity.condensed_stiffness().matrix.full(), body.space.order
    for line in _lines(body):
        part = line[: 3 * order + 1]
        edges = np.array(part)[np.arange(0, 3 * order, order)[:, None] + np.arange(order + 1)]
        chain = Body.from_stiffness(name, matrix, body.nodes, {"s": edges[:, ::-1]}, order=order)
        np.testing.assert_array_equal(chain.edge_nodes(chain.edge_sets["s"]), edges)
        with pytest.raises(InputError, match="on its right"):
            Body.from_stiffness(name, matrix, body.nodes, {"s": part[::-1]}, order=order)


def test_linings_and_wood_are_no_skipped_nodes() -> None:
    """Forces at an interface, and normal stresses that differ by direction, are those of a right body."""
    grid = rectangle_grid(3.0, 1.0, 9, 5)
    lining = grid.cell_centroids[:, 1] > 0.8
    lined = replace(grid, cell_sets={"steel": np.flatnonzero(~lining), "rubber": np.flatnonzero(lining)})
    wood = Orthotropic((11e3, 0.9e3, 0.6e3), (0.4, 0.3, 0.4), 0.7e3, 0.5)
    for order in (1, 2):
        for mesh, material in ((lined, {"steel": STEEL, "rubber": Elastic(3.0, 0.45)}), (_ring(24, 2, 0.2), wood)):
            body = Body("body", mesh, Virtual(order), material)
            matrix = body.elasticity.condensed_stiffness().matrix.full()
            surfaces = dict(zip("ab", _lines(body), strict=False))
            Body.from_stiffness("body", matrix, body.nodes, surfaces, order=order)


@pytest.mark.parametrize("first", [0, 1])
def test_numbers_in_place_of_held_components_are_refused(first: int) -> None:
    """Numbers of nodes or of rows could be both: what is held is true or false for each component of each node."""
    matrix, points, line = _rigid_case()
    nodes = np.flatnonzero(points[:, 1] == 1.0)
    for numbers in (nodes + first, (2 * nodes[:, None] + np.arange(2)).ravel(), nodes.tolist()):
        with pytest.raises(InputError, match="held_nodes"):
            Body.from_stiffness("block", matrix, points, {"boundary": line}, held=numbers)
