"""Supports as constraints, and the rigid motions of a body that they leave free."""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
import scipy.sparse as sp
from numpy.typing import NDArray
from scipy.sparse.linalg import splu

from flangeway.errors import InputError, short
from flangeway.geometry.arrays import box_middle, components_of, cross_product, joined_columns, point_text, sums_at
from flangeway.mesh.connectivity import connected
from flangeway.problems import Body, Elasticity, LinearBody, PrescribedDisplacement, RigidHandle
from flangeway.problems.loads import axes, scalar_at
from flangeway.types import Bools, Floats, Ints

# --- Supports as constraints: displacements at nodes as an affine map of the motions that stay free.


RANK = 1e-10
"""Eigenvalue of directions below which they are dependent."""
AXIS = -1
"""Stands for the number of a support in constraints that keep nodes on the axis of revolution."""


@dataclass(frozen=True, eq=False)
class Rows:
    """Constraints ``direction . motion = value`` on groups: a node each, or the nodes that a handle moves.

    - `supports`: number of each row's support among the problem's, or `AXIS`, (n,).
    - `nodes`: node that each row comes from, -1 for a prescribed motion of a handle, (n,).
    - `groups`: that node, or the number of nodes and that of the handle which moves it, (n,).
    - `directions`: along x, y and the rotation about a handle's pivot, in space along x, y, z, (n, 3).
    - `values`: (n,).
    """

    supports: Ints
    nodes: Ints
    groups: Ints
    directions: Floats
    values: Floats

    def products(self, scale: Floats) -> tuple[Ints, Ints, Floats, Floats]:
        """Sums of the directions' products with themselves in each group, motions times a scale (3,).

        Returned: the groups that have rows (g,), the place of each row's group among them (n,), the directions in these
        units (n, 3), and the sums, (g, 3, 3).
        """
        groups, group_rows = np.unique(self.groups, return_inverse=True)
        scaled = self.directions / scale
        return groups, group_rows, scaled, sums_at(group_rows, scaled[:, :, None] * scaled[:, None], len(groups))


@dataclass(frozen=True, eq=False)
class HandleNodes:
    """A rigid handle with its nodes.

    - `support`, `number`: the handle, and its number among the problem's supports.
    - `nodes`: (n,).
    - `arms`: displacements of the nodes by the handle's motions x, y and rotation about its pivot, (n, 2, 3).
    - `pivot`: (2,).
    """

    support: RigidHandle
    number: int
    nodes: Ints
    arms: Floats
    pivot: Floats


@dataclass(frozen=True, eq=False)
class SupportConstraints:
    """Displacements at nodes ``u = transform q + shift`` that satisfy all supports.

    Parameters
    ----------
    transform
        Shape (d n_nodes, n_free), orthonormal columns but for those of handles.
    shift
        Shape (d n_nodes,).
    groups
        Node of each free unknown, numbers from n_nodes for handles, shape (n_free,).
    kept
        Which displacements are free unknowns themselves, shape (d n_nodes,), if no frame is turned and no handle there.
    rows
        All constraints.
    handles
        The handles.
    bases
        Motions of each handle that stay free, (3, n_free).

    """

    transform: sp.csr_array
    shift: Floats
    groups: NDArray[np.int32]
    kept: Bools | None
    rows: Rows
    handles: tuple[HandleNodes, ...]
    bases: tuple[Floats, ...]


def find_constraints(problem: Elasticity[Any]) -> SupportConstraints:
    """Gather the supports of a problem.

    Raises
    ------
    InputError
        If two supports contradict each other, or two handles share a node.

    """
    space, d, scale = problem.space, problem.dimension, problem.motion_scale
    handles = _handles(problem)
    rows = _rows(problem, handles)
    groups, group_rows, scaled, products = rows.products(scale)
    at_nodes = groups < space.n_nodes
    if d == 2:
        products[at_nodes, 2, 2] = 1.0  # a node does not turn
    right = sums_at(group_rows, scaled * rows.values[:, None], len(groups))
    held, vectors, motions = _least_motions(products, right)
    _refuse_contradiction(problem, np.einsum("ni,ni->n", scaled, motions[group_rows]) - rows.values, rows, handles)
    nodes, motions, shift = groups[at_nodes], motions / scale, np.zeros((space.n_nodes, d))
    shift[nodes] = motions[at_nodes, :d]
    bases = [np.eye(3)] * len(handles)
    for i in np.flatnonzero(~at_nodes).tolist():
        number = int(groups[i]) - space.n_nodes
        bases[number] = vectors[i][:, ~held[i]] / scale[:, None]
        shift[handles[number].nodes] = handles[number].arms @ motions[i]

    # the directions in which nothing holds a node, by columns: (n, d, d)
    left = np.where(held[at_nodes, None], 0.0, vectors[at_nodes])[:, :d, :d]
    free = np.zeros((space.n_nodes, d), dtype=np.bool_)
    for batch in space.batches():
        free[batch.outer_dofs] = True
    along_axis = (np.abs(left) == 1.0).any(axis=2)
    free[nodes] = along_axis
    for handle in handles:
        free[handle.nodes] = False
    plain = np.flatnonzero(free.ravel())
    oblique, column = np.nonzero(left.any(axis=1) & ~(np.abs(left) == 1.0).any(axis=1))
    # rows, columns and values of the transform, and the groups of its columns
    turned = len(plain) + np.arange(len(oblique))
    entries = [
        (plain, np.arange(len(plain)), np.ones(len(plain))),
        (components_of(nodes[oblique], d).ravel(), np.repeat(turned, d), left[oblique, :, column].ravel()),
    ]
    of_columns = [plain // d, nodes[oblique]]
    for number, (handle, basis) in enumerate(zip(handles, bases, strict=True)):
        columns, at = sum(map(len, of_columns)) + np.arange(basis.shape[1]), components_of(handle.nodes).ravel()
        entries.append((np.repeat(at, len(columns)), np.tile(columns, len(at)), (handle.arms @ basis).ravel()))
        of_columns.append(np.full(len(columns), space.n_nodes + number))
    at, columns, values = joined_columns(entries)
    unknowns = np.concatenate(of_columns).astype(np.int32)
    transform = sp.csr_array((values, (at, columns)), shape=(shift.size, len(unknowns)))
    kept = free.ravel() if len(oblique) == 0 and not handles else None
    return SupportConstraints(transform, shift.ravel(), unknowns, kept, rows, tuple(handles), tuple(bases))


def _rows(problem: Elasticity[Any], handles: Sequence[HandleNodes]) -> Rows:
    """Constraints by prescribed motions of handles and of nodes, and by the axis of revolution."""
    points, n_nodes = problem.space.nodes, problem.space.n_nodes
    none, owners = np.empty(0, dtype=np.int64), np.arange(n_nodes)
    parts = [(none, none, none, np.empty((0, 3)), np.empty(0))]
    for number, handle in enumerate(handles):
        owners[handle.nodes] = n_nodes + number
        motions = _own_motions(problem, handle)
        supports = np.array([support for support, _ in motions.values()], dtype=np.int64)
        of_handle = np.full(len(motions), n_nodes + number)
        values = np.array([value for _, value in motions.values()], dtype=np.float64)
        parts.append((supports, np.full(len(motions), -1), of_handle, np.eye(3)[list(motions)], values))

    def add(support: int, nodes: Ints, direction: Floats, values: Floats) -> None:
        groups, directions = owners[nodes], np.tile(np.append(direction, 0.0)[:3], (len(nodes), 1))
        for number, handle in enumerate(handles):
            on = groups == n_nodes + number
            directions[on, 2] = cross_product(points[nodes[on]] - handle.pivot, direction)
        parts.append((np.full(len(nodes), support), nodes, groups, directions, values))

    for number, support in enumerate(problem.supports):
        if isinstance(support, PrescribedDisplacement):
            nodes, name = problem.support_nodes(support), f"PrescribedDisplacement({short(support.where)})"
            d = problem.dimension
            for direction, value in zip(axes(support.angle, d), support.components[:d], strict=True):
                if value is not None:
                    add(number, nodes, direction, scalar_at(name, value, points[nodes]))
    if problem.axisymmetric:
        add(AXIS, problem.on_axis, np.array([1.0, 0.0]), np.zeros(len(problem.on_axis)))
    return Rows(*joined_columns(parts))


def _handles(problem: Elasticity[Any]) -> list[HandleNodes]:
    """Handles and their nodes."""
    taken, handles = np.zeros(problem.space.n_nodes, dtype=np.bool_), []
    for number, support in enumerate(problem.supports):
        if not isinstance(support, RigidHandle):
            continue
        nodes = problem.support_nodes(support)
        points = problem.space.nodes[nodes]
        if taken[nodes].any():
            x, y = points[np.argmax(taken[nodes])]
            raise InputError(
                f"rigid handles `{support.edges}` and another at the point ({x:g}, {y:g})",
                "handles apart from each other",
                "make one handle of both edge sets",
            )
        taken[nodes] = True
        pivot = box_middle(points) if support.pivot is None else np.array(support.pivot)
        handles.append(HandleNodes(support, number, nodes, rigid_motions(points - pivot), pivot))
    return handles


def _own_motions(problem: Elasticity[Any], handle: HandleNodes) -> dict[int, tuple[int, float]]:
    """Prescribed motions of a handle, each with its support; in a body of revolution it only moves along the axis."""
    support = handle.support
    motions = {i: (handle.number, value) for i, value in enumerate(support.prescribed) if value is not None}
    if not problem.axisymmetric:
        return motions
    if any(value != 0.0 for i, (_, value) in motions.items() if i != 1) or support.force[0] or support.moment:
        raise InputError(
            f"RigidHandle({short(support.edges)}) of an axisymmetric body with more than a motion along the axis",
            "y and force y",
            "leave x, rotation, force x and moment",
        )
    return {0: (AXIS, 0.0), 2: (AXIS, 0.0), **motions}


def _least_motions(normal: Floats, right: Floats) -> tuple[Bools, Floats, Floats]:
    """Least motions (..., n) of normal equations (..., n, n), (..., n); their eigenvectors and which are held."""
    values, vectors = np.linalg.eigh(normal)
    held = values > RANK * np.maximum(1.0, values[..., -1:])
    inverse = np.where(held, 1.0 / np.where(held, values, 1.0), 0.0)
    return held, vectors, np.einsum("...ij,...j,...kj,...k->...i", vectors, inverse, vectors, right)


def _refuse_contradiction(problem: Elasticity[Any], misfit: Floats, rows: Rows, handles: Sequence[HandleNodes]) -> None:
    # values of all nodes are compared with their maximum, those of each handle with its own
    kinds = np.maximum(rows.groups - (problem.space.n_nodes - 1), 0)
    most = np.full(1 + len(handles), np.finfo(np.float64).tiny)
    np.maximum.at(most, kinds, np.abs(rows.values))
    wrong = np.abs(misfit) > 1e-9 * most[kinds]
    if not wrong.any():
        return
    first = int(wrong.argmax())
    name = f"handle `{handles[kinds[first] - 1].support.edges}`" if kinds[first] else "the point"
    if rows.nodes[first] >= 0:
        name += f" at {point_text(problem.space.nodes[rows.nodes[first]])}"
    group = rows.groups == rows.groups[first]
    names = {str(problem.supports[number]) for number in rows.supports[group] if number != AXIS}
    raise InputError(
        f"supports that contradict each other: {name} of body `{problem.name}` is given different "
        f"displacements by {' and '.join(sorted(names))}",
        "displacements that agree where supports meet",
        "make them equal there, or leave one component free",
    )


# --- Rigid motions that the supports of a body leave free.


ENERGY = 1e-13
"""Energy of a rigid motion relative to that of the stiffness's diagonal alone, below which it is rounding."""

SINGLE_ENERGY = 1e-6
"""The same of a stiffness all of whose entries are numbers of single precision."""

MIN_CONSTRAINED = 1e-9
"""Singular value of the constraints, relative to the maximum, below which a motion is free."""


def rigid_motions(arms: Floats) -> Floats:
    """Velocities of points with arms (n, d) by unit translations, then rotations: (n, d, 3), in space (n, d, 6)."""
    n, d = arms.shape
    planes = ((0, 1),) if d == 2 else ((1, 2), (2, 0), (0, 1))
    motions = np.zeros((n, d, d + len(planes)))
    motions[:, np.arange(d), np.arange(d)] = 1.0
    for number, (i, j) in enumerate(planes):  # turned from axis i to axis j
        motions[:, i, d + number], motions[:, j, d + number] = -arms[:, j], arms[:, i]
    return motions


def refuse_free_motions(problem: Elasticity[Any], constraints: SupportConstraints) -> None:
    """Raise `InputError` with the motion that nothing holds, found from the constraints before anything is factorised.

    The mesh's pieces (cells joined by edges, in space by faces) have two translations and a rotation each, in space
    three of both; they are tied by common points and by the supports.
    """
    pieces, n_pieces = _pieces(problem)
    centre = problem.space.mesh.points.mean(axis=0)
    motions = _unheld(problem, constraints, pieces, n_pieces, centre)[0]
    for piece in range(n_pieces):
        n = len(motions) // n_pieces
        described = described_motions(motions[n * piece : n * piece + n], centre, problem.size)
        if described:
            raise InputError(
                f"body `{problem.name}`{_which(problem, pieces, piece, n_pieces)} {described}",
                "supports that hold all translations and rotations of every piece of the mesh",
                "add a support against this motion (in Python a spring will do as well)",
            )


def unheld_velocities(problem: Elasticity[Any], constraints: SupportConstraints) -> Floats:
    """Velocities of the nodes by rigid motions that nothing resists, shape (d n_nodes, n_free)."""
    return _unheld(problem, constraints, *_pieces(problem), problem.space.mesh.points.mean(axis=0))[1]


def _unheld(
    problem: Elasticity[Any], constraints: SupportConstraints, pieces: Ints, n_pieces: int, centre: Floats
) -> tuple[Floats, Floats]:
    """Rigid motions of the pieces that nothing resists, rotations times the size, shape (3 or 6 n_pieces, n_free).

    And the velocities of the nodes by them, (d n_nodes, n_free).

    With the velocities M of the nodes by the motions c, ``(I - T T^+) M c`` is what supports forbid, of which T is the
    transform, and what springs resist is ``K M c`` with their stiffness; pieces that share a point move it alike.
    """
    nodes, owners = _nodes_of_pieces(problem, pieces)
    arms = (problem.space.nodes[nodes] - centre) / problem.size
    # M_(n i)(p j): component i of a node's velocity by motion j of its piece
    unit = rigid_motions(arms)
    by_piece = np.zeros((*unit.shape[:2], n_pieces, unit.shape[2]))
    by_piece[np.arange(len(nodes)), :, owners] = unit
    n_motions = n_pieces * unit.shape[2]
    velocities = by_piece.reshape(len(nodes), -1, n_motions)
    new = np.diff(nodes, prepend=-1) > 0
    later = np.flatnonzero(~new)
    at_nodes = np.zeros((problem.space.n_nodes, problem.dimension, n_motions))
    at_nodes[nodes[new]] = velocities[new]
    moved, transform = at_nodes.reshape(-1, n_motions), sp.csc_array(constraints.transform)
    allowed = np.zeros_like(moved)
    if transform.shape[1]:
        allowed = transform @ splu(sp.csc_array(transform.T @ transform)).solve(transform.T @ moved)
    conditions = [moved - allowed, (velocities[later] - velocities[later - 1]).reshape(-1, n_motions)]
    for spring in problem.springs:
        x, y, z = (float(stiffness > 0.0) for stiffness in (spring.x, spring.y, spring.z))
        stiffness = problem.spring_stiffness(replace(spring, x=x, y=y, z=z))
        conditions.append(stiffness @ moved / abs(stiffness).max())
    if problem.axisymmetric:  # a body of revolution only moves along its axis
        conditions.append(np.eye(n_motions)[np.arange(n_motions) % 3 != 1])
    _, values, vectors = np.linalg.svd(np.linalg.qr(np.concatenate(conditions), mode="r"))
    free = vectors[values <= MIN_CONSTRAINED * max(values.max(), 1.0)].T
    return free, moved @ free


def refuse_floating(body: LinearBody) -> None:
    """Raise `InputError` with the motion that what is held of a body leaves free.

    Sliding, turning about one held point, and all three where nothing is held are no such motion: see `Body.freedom`.
    Of a body given by its stiffness matrix it is a rigid motion, of all or of unknowns that nothing couples to the
    others, that has no strain energy.
    """
    if not isinstance(body, Body):
        _refuse_without_energy(body)
        return
    pins = {(*body.space.nodes[node].tolist(),): components for node, components in body.freedom.pins.items()}
    supports = [
        PrescribedDisplacement(where, 0.0 if "x" in components else None, 0.0 if "y" in components else None)
        for where, components in [*body.supports.items(), *pins.items()]
    ]
    problem = replace(body.elasticity, supports=[*supports, *body.springs])
    try:
        refuse_free_motions(problem, find_constraints(problem))
    except InputError as reason:
        raise InputError(
            reason.given,
            "one piece that is held in x and y and cannot turn, slides along an axis, turns about one held point, or "
            "is not held at all",
            f"hold more or less of it in Body(held=...), now {short(body.held)}, and join its pieces",
        ) from reason


def _refuse_without_energy(body: LinearBody) -> None:
    stiffness, nodes = body.stiffness.full(), body.free_nodes
    components = np.flatnonzero(body.free) % 2
    centre = body.nodes.mean(axis=0)
    n_pieces, pieces = sp.csgraph.connected_components(stiffness, directed=False)
    limit = SINGLE_ENERGY if (stiffness.data == stiffness.data.astype(np.float32)).all() else ENERGY
    for piece in range(n_pieces):
        here = np.flatnonzero((pieces == piece) & (nodes < len(body.nodes)))
        arm = (body.nodes[nodes[here]] - centre) / body.size
        motions = rigid_motions(arm)[np.arange(len(here)), components[here]]
        part = stiffness[here][:, here]
        weights = np.sqrt(part.diagonal())[:, None]
        # unit motions by the work that the diagonal alone would do
        left, values, right = np.linalg.svd(weights * motions, full_matrices=False)
        there = values > MIN_CONSTRAINED * values.max(initial=0.0)
        units = left[:, there] / weights
        energies, shares = np.linalg.eigh(units.T @ (part @ units))
        loose = energies < -limit if energies[0] < -limit else energies <= limit
        described = described_motions(right[there].T @ (shares[:, loose] / values[there, None]), centre, body.size)
        if loose.any():
            which = (
                ""
                if n_pieces == 1
                else f", its piece with node {nodes[here[0]]} at {point_text(body.nodes[nodes[here[0]]])},"
            )
            if energies[0] < -limit:
                raise InputError(
                    f"body {body.name!r}{which} {described} with the energy {energies[0]:.2g} of what the diagonal of "
                    "its stiffness alone gives: the matrix is indefinite",
                    "a positive definite matrix of the unknowns that are not held: no elastic body gains energy",
                    "assemble it without pressures, multipliers and loads that follow the motion; look for wrong signs",
                )
            raise InputError(
                f"body {body.name!r}{which} {described}: its stiffness has no energy in that motion",
                "a stiffness in which what is held fixes both translations and the rotation of every piece",
                f"hold more of it with held=..., now {body.held_by}; contact alone holds nothing",
            )


def _pieces(problem: Elasticity[Any]) -> tuple[Ints, int]:
    """Number of each cell's piece, and how many there are."""
    mesh = problem.space.mesh
    labels = connected(mesh.cell_neighbours, mesh.n_cells)
    return labels, int(labels.max()) + 1


def _nodes_of_pieces(problem: Elasticity[Any], pieces: Ints) -> tuple[Ints, Ints]:
    """Pairs of a node and a piece that it belongs to, sorted by nodes."""
    keys = []
    for batch in problem.space.batches():
        outer = batch.outer_dofs
        keys.append(np.unique(outer.astype(np.int64) * (pieces.max() + 1) + pieces[batch.cells]))
    nodes, owners = np.divmod(np.unique(np.concatenate(keys)), pieces.max() + 1)
    return nodes, owners


def _which(problem: Elasticity[Any], pieces: Ints, piece: int, n_pieces: int) -> str:
    if n_pieces == 1:
        return ""
    mesh = problem.space.mesh
    corners = mesh.corners(np.flatnonzero(pieces == piece)[0])
    return f", its piece with the cell at {point_text(mesh.points[corners].mean(axis=0))},"


def described_motions(motions: Floats, centre: Floats, size: float) -> str:
    """Words for the motions (3, n) of a piece, in space (6, n), empty if it stays at rest."""
    left, values, _ = np.linalg.svd(motions, full_matrices=False)
    basis = left[:, values > 1e-6]
    if basis.shape[1] == 0:
        return ""
    if len(basis) == 6:
        words = [f"{name} {axis}" for name in ("slide in", "turn about") for axis in "xyz"]
        return "can " + ", ".join(word for word, row in zip(words, basis, strict=True) if np.abs(row).max() > 1e-6)
    if basis.shape[1] == 3:
        return "can slide in x, slide in y and turn: nothing holds it"
    turn = basis[2]
    words = []
    if np.abs(turn).max() > 1e-6:
        # the combination with the largest rotation turns about the centre nearest to the middle of the body
        x, y, rotation = basis @ (turn / np.linalg.norm(turn))
        rate = rotation / size
        at = centre + np.array([-y, x]) / rate
        at[np.abs(at) < 1e-9 * size] = 0.0
        words.append(f"turn about ({at[0]:g}, {at[1]:g})")
        other = np.linalg.svd(turn[None])[2][1:]
        translations = [basis @ row for row in other]
    else:
        translations = [basis[:, i] for i in range(basis.shape[1])]
    if len(translations) == 2:
        words = ["slide in x", "slide in y", *words]
    elif translations:
        words.insert(0, f"slide {_direction(translations[0][:2])}")
    return "can " + " and ".join(words)


def _direction(vector: Floats) -> str:
    x, y = vector / np.linalg.norm(vector)
    if abs(y) < 1e-6:
        return "in x"
    if abs(x) < 1e-6:
        return "in y"
    x, y = (x, y) if x > 0.0 else (-x, -y)
    return f"along ({x:.3g}, {y:.3g})"
