"""Rigid motions that the supports of a body leave free."""

from dataclasses import replace

import numpy as np
import scipy.sparse as sp
from scipy.sparse.linalg import splu

from flangeway.errors import InputError, short
from flangeway.geometry.arrays import point_text
from flangeway.problems import Body, Elasticity, LinearBody, PrescribedDisplacement
from flangeway.solve.constraints import SupportConstraints, find_constraints
from flangeway.types import Floats, Ints

ENERGY = 1e-13
"""Energy of a rigid motion over that of the stiffness's diagonal alone, below which it is rounding."""

SINGLE_ENERGY = 1e-6
"""The same of a stiffness all of whose entries are numbers of single precision."""

FREE = 1e-9
"""Singular value of the constraints, over the maximum, below which a motion is free."""


def refuse_free_motions(problem: Elasticity, constraints: SupportConstraints) -> None:
    """Raise `InputError` with the motion that nothing holds, found from the constraints before anything is factorised.

    The mesh's pieces (cells joined by edges) have two translations and a rotation each; they are tied by common points
    and by the supports.
    """
    pieces, n_pieces = _pieces(problem)
    centre = problem.space.mesh.points.mean(axis=0)
    motions = _unheld(problem, constraints, pieces, n_pieces, centre)
    for piece in range(n_pieces):
        described = described_motions(motions[3 * piece : 3 * piece + 3], centre, problem.size)
        if described:
            raise InputError(
                f"body `{problem.name}`{_which(problem, pieces, piece, n_pieces)} {described}",
                "supports that hold both translations and the rotation of every piece of the mesh",
                "add a support against this motion (in Python a spring will do as well)",
            )


def _unheld(
    problem: Elasticity, constraints: SupportConstraints, pieces: Ints, n_pieces: int, centre: Floats
) -> Floats:
    """Rigid motions of the pieces that nothing resists, rotations times the size, shape (3 n_pieces, n_free).

    With the velocities M of the nodes by the motions c, ``(I - T T^+) M c`` is what supports forbid, of which T is the
    transform, and what springs resist is ``K M c`` with their stiffness; pieces that share a point move it alike.
    """
    nodes, owners = _nodes_of_pieces(problem, pieces)
    arms = (problem.space.nodes[nodes] - centre) / problem.size
    # M_(n i)(p j): component i of a node's velocity by motion j of its piece
    each, by_piece = np.arange(len(nodes)), np.zeros((len(nodes), 2, n_pieces, 3))
    by_piece[each, 0, owners, 0] = by_piece[each, 1, owners, 1] = 1.0
    by_piece[each, 0, owners, 2], by_piece[each, 1, owners, 2] = -arms[:, 1], arms[:, 0]
    velocities = by_piece.reshape(len(nodes), 2, 3 * n_pieces)
    new = np.diff(nodes, prepend=-1) > 0
    later = np.flatnonzero(~new)
    at_nodes = np.zeros((problem.space.n_nodes, 2, 3 * n_pieces))
    at_nodes[nodes[new]] = velocities[new]
    moved, transform = at_nodes.reshape(-1, 3 * n_pieces), sp.csc_array(constraints.transform)
    allowed = np.zeros_like(moved)
    if transform.shape[1]:
        allowed = transform @ splu(sp.csc_array(transform.T @ transform)).solve(transform.T @ moved)
    conditions = [moved - allowed, (velocities[later] - velocities[later - 1]).reshape(-1, 3 * n_pieces)]
    for spring in problem.springs:
        unit = problem.spring_stiffness(replace(spring, x=float(spring.x > 0.0), y=float(spring.y > 0.0)))
        conditions.append(unit @ moved / abs(unit).max())
    if problem.axisymmetric:  # a body of revolution only moves along its axis
        conditions.append(np.eye(3 * n_pieces)[np.arange(3 * n_pieces) % 3 != 1])
    _, values, vectors = np.linalg.svd(np.linalg.qr(np.concatenate(conditions), mode="r"))
    return vectors[values <= FREE * max(values.max(), 1.0)].T


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
        along_x = components[here] == 0
        motions = np.column_stack((along_x, ~along_x, np.where(along_x, -arm[:, 1], arm[:, 0]))).astype(np.float64)
        part = stiffness[here][:, here]
        weights = np.sqrt(part.diagonal())[:, None]
        # unit motions by the work that the diagonal alone would do
        left, values, right = np.linalg.svd(weights * motions, full_matrices=False)
        there = values > FREE * values.max(initial=0.0)
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


def _pieces(problem: Elasticity) -> tuple[Ints, int]:
    """Number of each cell's piece, and how many there are."""
    mesh = problem.space.mesh
    pairs = mesh.edge_cells[mesh.edge_cells[:, 1] >= 0]
    graph = sp.coo_array((np.ones(len(pairs)), (pairs[:, 0], pairs[:, 1])), shape=(mesh.n_cells, mesh.n_cells))
    n_pieces, labels = sp.csgraph.connected_components(graph, directed=False)
    return labels.astype(np.int64), int(n_pieces)


def _nodes_of_pieces(problem: Elasticity, pieces: Ints) -> tuple[Ints, Ints]:
    """Pairs of a node and a piece that it belongs to, sorted by nodes."""
    keys = []
    for batch in problem.space.batches():
        outer = batch.dofs[: len(batch.dofs) - batch.element.n_interior()]
        keys.append(np.unique(outer.astype(np.int64) * (pieces.max() + 1) + pieces[batch.cells]))
    nodes, owners = np.divmod(np.unique(np.concatenate(keys)), pieces.max() + 1)
    return nodes, owners


def _which(problem: Elasticity, pieces: Ints, piece: int, n_pieces: int) -> str:
    if n_pieces == 1:
        return ""
    x, y = problem.space.mesh.cell_centroids[np.flatnonzero(pieces == piece)[0]]
    return f", its piece with the cell at ({x:g}, {y:g}),"


def described_motions(motions: Floats, centre: Floats, size: float) -> str:
    """Words for the motions (3, n) of a piece, empty if it stays at rest."""
    left, values, _ = np.linalg.svd(motions, full_matrices=False)
    basis = left[:, values > 1e-6]
    if basis.shape[1] == 0:
        return ""
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
