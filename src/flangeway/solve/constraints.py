"""Supports as constraints: displacements at nodes as an affine map of the motions that stay free."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
import scipy.sparse as sp
from numpy.typing import NDArray

from flangeway.errors import InputError, short
from flangeway.geometry.arrays import cross_product, turned_right
from flangeway.problems import Elasticity, PrescribedDisplacement, RigidHandle
from flangeway.problems.prescribed import scalar_at
from flangeway.problems.supports import axes
from flangeway.types import Floats, Ints

RANK = 1e-10
"""Eigenvalue of directions below which they are dependent."""
AXIS = -1
"""Stands for the number of a support in constraints that keep nodes on the axis of revolution."""


def components(nodes: Ints) -> Ints:
    """Numbers of the two components of nodes, one node after the other, shape (2 n,)."""
    return (2 * nodes[:, None] + np.arange(2)).ravel()


@dataclass(frozen=True, eq=False)
class Rows:
    """Constraints ``direction . motion = value`` on groups: a node each, or the nodes that a handle moves.

    - `supports`: number of each row's support among the problem's, or `AXIS`, (n,).
    - `nodes`: node that each row comes from, -1 for a prescribed motion of a handle, (n,).
    - `groups`: that node, or the number of nodes and that of the handle which moves it, (n,).
    - `directions`: along x, y and the rotation about a handle's pivot, (n, 3).
    - `values`: (n,).
    """

    supports: Ints
    nodes: Ints
    groups: Ints
    directions: Floats
    values: Floats

    def products(self, size: float) -> tuple[Ints, Ints, Floats, Floats]:
        """Sums of the directions' products with themselves in each group, rotations times a size.

        Returned: the groups that have rows (g,), the place of each row's group among them (n,), the directions in these
        units (n, 3), and the sums, (g, 3, 3).
        """
        groups, place = np.unique(self.groups, return_inverse=True)
        scaled, sums = self.directions / (1.0, 1.0, size), np.zeros((len(groups), 3, 3))
        np.add.at(sums, place, scaled[:, :, None] * scaled[:, None])
        return groups, place, scaled, sums


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
        Shape (2 n_nodes, n_free), orthonormal columns but for those of handles.
    shift
        Shape (2 n_nodes,).
    groups
        Node of each free unknown, numbers from n_nodes for handles, shape (n_free,).
    kept
        Which displacements are free unknowns themselves, shape (2 n_nodes,), if no frame is turned and no handle there.
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
    kept: NDArray[np.bool_] | None
    rows: Rows
    handles: tuple[HandleNodes, ...]
    bases: tuple[Floats, ...]


def find_constraints(problem: Elasticity) -> SupportConstraints:
    """Gather the supports of a problem.

    Raises
    ------
    InputError
        If two supports contradict each other, or two handles share a node.

    """
    space, scale = problem.space, np.array([1.0, 1.0, problem.size])
    handles = _handles(problem)
    rows = _rows(problem, handles)
    groups, place, scaled, products = rows.products(problem.size)
    at_nodes = groups < space.n_nodes
    products[at_nodes, 2, 2] = 1.0  # a node does not turn
    right = np.zeros((len(groups), 3))
    np.add.at(right, place, scaled * rows.values[:, None])
    held, vectors, motions = _least_motions(products, right)
    _refuse_contradiction(problem, np.einsum("ni,ni->n", scaled, motions[place]) - rows.values, rows, handles)
    nodes, motions, shift = groups[at_nodes], motions / scale, np.zeros((space.n_nodes, 2))
    shift[nodes] = motions[at_nodes, :2]
    bases = [np.eye(3)] * len(handles)
    for i in np.flatnonzero(~at_nodes).tolist():
        number = int(groups[i]) - space.n_nodes
        bases[number] = vectors[i][:, ~held[i]] / scale[:, None]
        shift[handles[number].nodes] = handles[number].arms @ motions[i]

    left = np.where(held[at_nodes, :1], 0.0, vectors[at_nodes, :2, 0])  # the direction of a node that nothing holds
    free = np.zeros((space.n_nodes, 2), dtype=np.bool_)
    for batch in space.batches():
        free[batch.dofs[: len(batch.dofs) - batch.element.n_interior()]] = True
    along_axis = np.abs(left) == 1.0
    free[nodes] = along_axis
    for handle in handles:
        free[handle.nodes] = False
    plain, oblique = np.flatnonzero(free.ravel()), np.flatnonzero(left.any(axis=1) & ~along_axis.any(axis=1))
    # rows, columns and values of the transform, and the groups of its columns
    turned = len(plain) + np.arange(len(oblique))
    entries = [
        (plain, np.arange(len(plain)), np.ones(len(plain))),
        (components(nodes[oblique]), np.repeat(turned, 2), left[oblique].ravel()),
    ]
    of_columns = [plain // 2, nodes[oblique]]
    for number, (handle, basis) in enumerate(zip(handles, bases, strict=True)):
        columns, at = sum(map(len, of_columns)) + np.arange(basis.shape[1]), components(handle.nodes)
        entries.append((np.repeat(at, len(columns)), np.tile(columns, len(at)), (handle.arms @ basis).ravel()))
        of_columns.append(np.full(len(columns), space.n_nodes + number))
    at, columns, values = (np.concatenate(each) for each in zip(*entries, strict=True))
    unknowns = np.concatenate(of_columns).astype(np.int32)
    transform = sp.csr_array(sp.coo_array((values, (at, columns)), shape=(shift.size, len(unknowns))))
    kept = free.ravel() if len(oblique) == 0 and not handles else None
    return SupportConstraints(transform, shift.ravel(), unknowns, kept, rows, tuple(handles), tuple(bases))


def _rows(problem: Elasticity, handles: Sequence[HandleNodes]) -> Rows:
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
        groups, directions = owners[nodes], np.tile(np.append(direction, 0.0), (len(nodes), 1))
        for number, handle in enumerate(handles):
            on = groups == n_nodes + number
            directions[on, 2] = cross_product(points[nodes[on]] - handle.pivot, direction)
        parts.append((np.full(len(nodes), support), nodes, groups, directions, values))

    for number, support in enumerate(problem.supports):
        if isinstance(support, PrescribedDisplacement):
            nodes, name = problem.support_nodes(support), f"PrescribedDisplacement({short(support.where)})"
            for direction, value in zip(axes(support.angle), (support.x, support.y), strict=True):
                if value is not None:
                    add(number, nodes, direction, scalar_at(name, value, points[nodes]))
    if problem.axisymmetric:
        add(AXIS, problem.on_axis, np.array([1.0, 0.0]), np.zeros(len(problem.on_axis)))
    return Rows(*(np.concatenate(each) for each in zip(*parts, strict=True)))


def _handles(problem: Elasticity) -> list[HandleNodes]:
    """Handles and their nodes."""
    taken, found = np.zeros(problem.space.n_nodes, dtype=np.bool_), []
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
        pivot = (points.min(axis=0) + points.max(axis=0)) / 2.0 if support.pivot is None else np.array(support.pivot)
        arms = np.zeros((len(nodes), 2, 3))
        arms[:, 0, 0] = arms[:, 1, 1] = 1.0
        arms[:, :, 2] = -turned_right(points - pivot)
        found.append(HandleNodes(support, number, nodes, arms, pivot))
    return found


def _own_motions(problem: Elasticity, handle: HandleNodes) -> dict[int, tuple[int, float]]:
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


def _least_motions(normal: Floats, right: Floats) -> tuple[NDArray[np.bool_], Floats, Floats]:
    """Least motions (..., n) of normal equations (..., n, n), (..., n); their eigenvectors and which are held."""
    values, vectors = np.linalg.eigh(normal)
    held = values > RANK * np.maximum(1.0, values[..., -1:])
    inverse = np.where(held, 1.0 / np.where(held, values, 1.0), 0.0)
    return held, vectors, np.einsum("...ij,...j,...kj,...k->...i", vectors, inverse, vectors, right)


def _refuse_contradiction(problem: Elasticity, misfit: Floats, rows: Rows, handles: Sequence[HandleNodes]) -> None:
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
        x, y = problem.space.nodes[rows.nodes[first]]
        name += f" at ({x:g}, {y:g})"
    group = rows.groups == rows.groups[first]
    names = {str(problem.supports[number]) for number in rows.supports[group] if number != AXIS}
    raise InputError(
        f"supports that contradict each other: {name} of body `{problem.name}` is given different "
        f"displacements by {' and '.join(sorted(names))}",
        "displacements that agree where supports meet",
        "make them equal there, or leave one component free",
    )
