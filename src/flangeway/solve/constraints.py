"""Supports as constraints: displacements at nodes as an affine map of the motions that stay free."""

from dataclasses import dataclass, replace

import numpy as np
import scipy.sparse as sp
from numpy.typing import NDArray

from flangeway.errors import InputError, short
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
    """Constraints ``direction . motion = value`` of nodes (2 motions) or of one handle (3 motions)."""

    supports: Ints  # number of each row's support among the problem's, or `AXIS`, (n,)
    nodes: Ints  # node that each row comes from, or -1, (n,)
    directions: Floats  # (n, 2) or (n, 3)
    values: Floats  # (n,)

    def where(self, mask: NDArray[np.bool_]) -> "Rows":
        """The rows of a mask."""
        return Rows(self.supports[mask], self.nodes[mask], self.directions[mask], self.values[mask])

    @staticmethod
    def joined(parts: "list[Rows]", width: int) -> "Rows":
        """Rows one after the other, with directions of a width."""
        if not parts:
            none = np.empty(0, dtype=np.int64)
            return Rows(none, none, np.empty((0, width)), np.empty(0))
        return Rows(
            np.concatenate([part.supports for part in parts]),
            np.concatenate([part.nodes for part in parts]),
            np.concatenate([part.directions for part in parts]),
            np.concatenate([part.values for part in parts]),
        )


@dataclass(frozen=True, eq=False)
class HandleNodes:
    """A rigid handle with its nodes."""

    support: int  # number among the problem's supports
    nodes: Ints  # its nodes, (n,)
    arms: Floats  # displacements of the nodes by the handle's motions x, y and rotation about its pivot, (n, 2, 3)
    pivot: Floats  # (2,)
    rows: Rows  # constraints on its three motions
    basis: Floats  # motions that stay free, (3, n_free)


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
    node_rows
        Constraints on nodes outside of handles.
    handles
        Handles with their constraints.

    """

    transform: sp.csr_array
    shift: Floats
    groups: NDArray[np.int32]
    kept: NDArray[np.bool_] | None
    node_rows: Rows
    handles: tuple[HandleNodes, ...]


def find_constraints(problem: Elasticity) -> SupportConstraints:
    """Gather the supports of a problem.

    Raises
    ------
    InputError
        If two supports contradict each other, or two handles share a node.

    """
    rows = _prescribed_rows(problem)
    handles = _handles(problem, rows)
    space = problem.space
    on_handle = np.zeros(space.n_nodes, dtype=np.bool_)
    for handle in handles:
        on_handle[handle.nodes] = True
    node_rows = rows.where(~on_handle[rows.nodes])
    free = np.zeros((space.n_nodes, 2), dtype=np.bool_)
    for batch in space.batches():
        n_interior = batch.element.n_interior()
        free[batch.dofs[: len(batch.dofs) - n_interior]] = True
    free[on_handle] = False
    shift = np.zeros((space.n_nodes, 2))
    entries: list[tuple[Ints, Ints, Floats]] = []  # rows, columns and values of the transform
    n_free, turned = _resolve_nodes(problem, node_rows, free, shift, entries)
    groups = [np.flatnonzero(free.ravel()) // 2, turned]
    for number, handle in enumerate(handles):
        basis, motion = _resolve(problem, handle.rows, f"handle `{_handle_name(problem, handle)}`")
        handles[number] = replace(handle, basis=basis)
        shift[handle.nodes] = handle.arms @ motion
        columns = np.arange(n_free, n_free + basis.shape[1])
        values = handle.arms @ basis
        at = components(handle.nodes)
        entries.append((np.repeat(at, len(columns)), np.tile(columns, len(at)), values.ravel()))
        groups.append(np.full(len(columns), space.n_nodes + number))
        n_free += len(columns)
    transform = sp.csr_array(
        sp.coo_array(
            (
                np.concatenate([values for _, _, values in entries]),
                (np.concatenate([r for r, _, _ in entries]), np.concatenate([c for _, c, _ in entries])),
            ),
            shape=(2 * space.n_nodes, n_free),
        )
    )
    kept = free.ravel() if len(turned) == 0 and not handles else None
    return SupportConstraints(
        transform, shift.ravel(), np.concatenate(groups).astype(np.int32), kept, node_rows, tuple(handles)
    )


def _prescribed_rows(problem: Elasticity) -> Rows:
    """Constraints on nodes of prescribed displacements, and of the axis of revolution."""
    parts = []
    for number, support in enumerate(problem.supports):
        if not isinstance(support, PrescribedDisplacement):
            continue
        nodes = problem.support_nodes(support)
        for direction, value in zip(axes(support.angle), (support.x, support.y), strict=True):
            if value is not None:
                given = scalar_at(f"PrescribedDisplacement({short(support.where)})", value, problem.space.nodes[nodes])
                directions = np.broadcast_to(direction, (len(nodes), 2))
                parts.append(Rows(np.full(len(nodes), number), nodes, directions, given))
    if problem.axisymmetric:
        nodes = problem.on_axis
        directions = np.broadcast_to(np.array([1.0, 0.0]), (len(nodes), 2))
        parts.append(Rows(np.full(len(nodes), AXIS), nodes, directions, np.zeros(len(nodes))))
    return Rows.joined(parts, 2)


def _handles(problem: Elasticity, rows: Rows) -> list[HandleNodes]:
    """Handles; prescribed displacements of their nodes become constraints on their motion."""
    taken = np.full(problem.space.n_nodes, -1)
    result = []
    for number, support in enumerate(problem.supports):
        if not isinstance(support, RigidHandle):
            continue
        nodes = problem.support_nodes(support)
        if (taken[nodes] >= 0).any():
            x, y = problem.space.nodes[nodes[np.argmax(taken[nodes] >= 0)]]
            raise InputError(
                f"rigid handles `{support.edges}` and another at the point ({x:g}, {y:g})",
                "handles apart from each other",
                "make one handle of both edge sets",
            )
        taken[nodes] = number
        points = problem.space.nodes[nodes]
        pivot = (points.min(axis=0) + points.max(axis=0)) / 2.0 if support.pivot is None else np.array(support.pivot)
        arms = np.zeros((len(nodes), 2, 3))
        arms[:, 0, 0] = arms[:, 1, 1] = 1.0
        arms[:, 0, 2], arms[:, 1, 2] = -(points[:, 1] - pivot[1]), points[:, 0] - pivot[0]
        place = np.full(problem.space.n_nodes, -1)
        place[nodes] = np.arange(len(nodes))
        here = rows.where(place[rows.nodes] >= 0)
        through = np.einsum("ni,nij->nj", here.directions, arms[place[here.nodes]])
        own = _own_rows(problem, number, support)
        parts = [own, Rows(here.supports, here.nodes, through, here.values)]
        result.append(HandleNodes(number, nodes, arms, pivot, Rows.joined(parts, 3), np.eye(3)))
    return result


def _own_rows(problem: Elasticity, number: int, support: RigidHandle) -> Rows:
    """Prescribed motions of a handle; in a body of revolution it only moves along the axis."""
    motions = [(i, value) for i, value in enumerate(support.prescribed) if value is not None]
    supports = np.full(len(motions), number)
    if problem.axisymmetric:
        given = {i for i, _ in motions}
        held = [(i, 0.0) for i in (0, 2) if i not in given]
        motions += held
        supports = np.append(supports, np.full(len(held), AXIS))
        if any(value != 0.0 for i, value in motions if i != 1) or support.force[0] or support.moment:
            raise InputError(
                f"RigidHandle({short(support.edges)}) of an axisymmetric body with more than a motion along the axis",
                "y and force y",
                "leave x, rotation, force x and moment",
            )
    directions = np.eye(3)[[i for i, _ in motions]].reshape(-1, 3)
    nowhere = np.full(len(motions), -1)
    return Rows(supports.astype(np.int64), nowhere, directions, np.array([value for _, value in motions], dtype=float))


def _handle_name(problem: Elasticity, handle: HandleNodes) -> str:
    support = problem.supports[handle.support]
    return support.edges if isinstance(support, RigidHandle) else ""


def _resolve(problem: Elasticity, rows: Rows, name: str) -> tuple[Floats, Floats]:
    """Free motions (n, n_free) and a particular motion (n,) of one group of constraints."""
    scale = np.ones(rows.directions.shape[1])
    scale[2:] = problem.size
    scaled = rows.directions / scale
    held, vectors, motion = _least_motions(scaled.T @ scaled, scaled.T @ rows.values)
    _refuse_contradiction(problem, scaled @ motion - rows.values, rows, name)
    return vectors[:, ~held] / scale[:, None], motion / scale


def _least_motions(normal: Floats, right: Floats) -> tuple[NDArray[np.bool_], Floats, Floats]:
    """Least motions (..., n) of normal equations (..., n, n), (..., n); their eigenvectors and which are held."""
    values, vectors = np.linalg.eigh(normal)
    held = values > RANK * np.maximum(1.0, values[..., -1:])
    inverse = np.where(held, 1.0 / np.where(held, values, 1.0), 0.0)
    return held, vectors, np.einsum("...ij,...j,...kj,...k->...i", vectors, inverse, vectors, right)


def _resolve_nodes(
    problem: Elasticity,
    rows: Rows,
    free: NDArray[np.bool_],
    shift: Floats,
    entries: list[tuple[Ints, Ints, Floats]],
) -> tuple[int, Ints]:
    """Hold what the rows hold in ``free`` and ``shift``, and write the transform's entries.

    Returns the number of free unknowns, and the nodes of those in a turned direction, which come last.
    """
    nodes, place = np.unique(rows.nodes, return_inverse=True)
    gram = np.zeros((len(nodes), 2, 2))
    np.add.at(gram, place, rows.directions[:, :, None] * rows.directions[:, None])
    rhs = np.zeros((len(nodes), 2))
    np.add.at(rhs, place, rows.directions * rows.values[:, None])
    held, vectors, shift[nodes] = _least_motions(gram, rhs)
    given = np.einsum("ni,ni->n", rows.directions, shift[rows.nodes])
    _refuse_contradiction(problem, given - rows.values, rows, "the point")
    free[nodes] = False
    left = vectors[:, :, 0]  # the direction without constraint where there is one
    sliding = ~held[:, 0]
    along_axis = sliding & (np.abs(left).max(axis=1) == 1.0)
    free[nodes[along_axis], np.abs(left[along_axis]).argmax(axis=1)] = True
    plain = np.flatnonzero(free.ravel())
    entries.append((plain, np.arange(len(plain)), np.ones(len(plain))))
    oblique = np.flatnonzero(sliding & ~along_axis)
    columns = len(plain) + np.arange(len(oblique))
    at = components(nodes[oblique])
    entries.append((at, np.repeat(columns, 2), left[oblique].ravel()))
    return len(plain) + len(oblique), nodes[oblique]


def _refuse_contradiction(problem: Elasticity, misfit: Floats, rows: Rows, name: str) -> None:
    wrong = np.abs(misfit) > 1e-9 * max(np.abs(rows.values).max(initial=0.0), np.finfo(np.float64).tiny)
    if not wrong.any():
        return
    first = int(wrong.argmax())
    place = ""
    if rows.nodes[first] >= 0:
        x, y = problem.space.nodes[rows.nodes[first]]
        place = f" at ({x:g}, {y:g})"
    group = rows.nodes == rows.nodes[first] if name == "the point" else np.ones(len(rows.nodes), dtype=np.bool_)
    names = {str(problem.supports[number]) for number in rows.supports[group] if number != AXIS}
    raise InputError(
        f"supports that contradict each other: {name}{place} of body `{problem.name}` is given different "
        f"displacements by {' and '.join(sorted(names))}",
        "displacements that agree where supports meet",
        "make them equal there, or leave one component free",
    )
