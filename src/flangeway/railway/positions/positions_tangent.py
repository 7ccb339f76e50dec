"""Tangents of many positions of a wheelset.

With the displacements u of the surfaces, forces ``f = B^T p`` on them and the flexibility F, a change of the contact
forces p and of the wheelset's displacement q leads to

    du = F (B^T dp + h + E r),   r = P du + Q dq,   dg = B du + W dq,

where h are the forces not in equilibrium. ``E r`` is how the forces on the nodes turn with p constant. Forces of a
hundredth of Young's modulus turn little by the strain of the surfaces, but much by the bending of the rail's web: so r
is the displacement of both surfaces as a whole, the rail's against the wheel's (two translations and a rotation) and
the wheel's rotation, fitted to the loaded nodes by P. E is found by differences.
"""

from dataclasses import dataclass

import numpy as np

from flangeway.railway.positions.running_pair import Candidates, Gaps, RunningPair
from flangeway.railway.positions.surface_positions import Loads, SidePose, SurfacePositions, carried
from flangeway.types import Bools, Floats, Ints

DIFFERENCE_MM = 1e-5

MOST_TURNED = 0.8  # maximum eigenvalue of P F E that is used: where forces turn more, the tangent would mislead
ARM_MM = 10.0  # length by which rotations are multiplied, so that all modes move points alike


@dataclass(frozen=True, eq=False)
class Tangent:
    """Tangent of one side of one slot, in the rail's frame.

    - `rows`: hat functions of the window, shape (m,).
    - `matrix`: ``B F B^T`` with the turning of the forces, shape (m, m).
    - `by_turning`: ``B F E T`` with ``T = (1 - P F E)^-1``, shape (m, 4).
    - `turned_by`: ``T P F B^T``, shape (4, m).
    - `inverse`: T, shape (4, 4).
    - `centre`: point about which displacements are counted, shape (2,).
    - `wheel_fit`, `rail_fit`: motion of each surface by its nodes' displacements, shape (3, n, 2).
    - `wheel_turning`, `rail_turning`: E on the nodes, shape (4, n, 2).
    - `resultants`: forces in the track's axes and moment about the axle of E on the wheel, with the side's signs, shape
      (3, 4).
    """

    rows: Ints
    matrix: Floats
    by_turning: Floats
    turned_by: Floats
    inverse: Floats
    centre: Floats
    wheel_fit: Floats
    rail_fit: Floats
    wheel_turning: Floats
    rail_turning: Floats
    resultants: Floats

    def fitted(self, on_wheel: Floats, on_rail: Floats) -> Floats:
        """P of displacements of the nodes (n, 2) in the rail's frame, shape (4,)."""
        wheel, rail = np.einsum("anx,nx->a", self.wheel_fit, on_wheel), np.einsum("anx,nx->a", self.rail_fit, on_rail)
        result: Floats = _SELECTED[0] @ wheel + _SELECTED[1] @ rail
        return result

    def moved(self, pose: SidePose, axle: Floats) -> Floats:
        """Q: the wheel's displacement as a whole by that of the wheelset, shape (4, 3)."""
        back = pose.rail_turn.T
        displacement = np.zeros((3, 3))
        displacement[:2, 0], displacement[:2, 1] = back @ [pose.sign, 0.0], back @ [0.0, 1.0]
        arm = self.centre - axle
        displacement[:, 2] = pose.sign * np.array([-arm[1], arm[0], ARM_MM])
        result: Floats = _SELECTED[0] @ displacement
        return result


def restricted(candidates: Candidates, pair: RunningPair, stays: Bools) -> Candidates:
    """Candidates of some slots, numbered anew."""
    number = np.cumsum(stays) - 1
    n_second, n_first = len(pair.secondary.edges), len(pair.primary.edges)
    slots = candidates.edges // n_second
    mine = stays[slots]
    moved = number[slots[mine]] - slots[mine]
    return Candidates(
        candidates.window[stays], candidates.edges[mine] + moved * n_second, candidates.partners[mine] + moved * n_first
    )


def tangents(
    pose: SidePose, around: SurfacePositions, candidates: Candidates, forces: Floats, chosen: Bools, wanted: Bools
) -> list[Tangent]:
    """Tangents of the slots that are wanted, under contact forces (L, n_hats), of the constraints that are chosen."""
    pair = pose.pair
    around, candidates, forces = around.take(wanted), restricted(candidates, pair, wanted), forces[wanted]
    chosen = chosen[wanted]
    gaps = pair.gaps(around.wheel, around.rail, candidates)
    carried_load = carried(pose, gaps, around, forces)
    size = np.abs(carried_load.rail).sum(axis=2)
    total = size.sum(axis=1)
    centre = np.einsum("ln,lnx->lx", size, around.rail) / np.maximum(total, 1e-300)[:, None]
    turning = _turning(pose, around, candidates, forces, carried_load, centre)
    found = []
    bounds = _bounds(gaps, len(forces))
    order = np.argsort(gaps.rows[:, 0] // forces.shape[1], kind="stable")
    gradients, nodes = (gaps.on_wheel, gaps.on_rail), gaps.nodes
    for slot in range(len(forces)):
        rows = np.flatnonzero(chosen[slot])
        place = np.full(forces.shape[1], len(rows))
        place[rows] = np.arange(len(rows))
        mine = order[bounds[slot] : bounds[slot + 1]]
        at_rows = place[gaps.rows[mine] - slot * forces.shape[1]]
        touched = (at_rows < len(rows)).any(axis=1)
        mine, at_rows = mine[touched], at_rows[touched]
        matrix, fit_turned = np.zeros((len(rows), len(rows))), np.zeros((4, 4))
        by_turning, turned_by = np.zeros((len(rows), 4)), np.zeros((4, len(rows)))
        fits = []
        bodies = (
            (pair.wheel, around.wheel[slot], np.linalg.norm(carried_load.wheel[slot], axis=1), around.turns[slot]),
            (pair.rail, around.rail[slot], np.linalg.norm(carried_load.rail[slot], axis=1), np.eye(2)),
        )
        for number, (chain, positions, weights, turn) in enumerate(bodies):
            within, columns = np.unique(nodes[number][mine] - slot * len(chain.points), return_inverse=True)
            jacobian = _jacobian(gradients[number][mine] @ turn, at_rows, columns, len(rows), len(within))
            dofs = (2 * within[:, None] + np.arange(2)).ravel()
            flexibility = chain.flexibility[np.ix_(dofs, dofs)]
            by_force = flexibility @ jacobian.T
            matrix += jacobian @ by_force
            fit = _fit(positions[within], weights[within], centre[slot])
            fits.append((within, fit))
            if total[slot] == 0.0:
                continue
            local = (turning[number][slot][:, within] @ turn).reshape(4, -1)
            sign = _SELECTED[number] @ (fit @ turn).reshape(3, -1)
            by_turn = flexibility @ local.T
            by_turning += jacobian @ by_turn
            turned_by += sign @ by_force
            fit_turned += sign @ by_turn
        share = min(1.0, MOST_TURNED / max(float(np.linalg.eigvals(fit_turned).real.max()), 1e-300))
        inverse: Floats = np.asarray(np.linalg.inv(np.eye(4) - share * fit_turned), dtype=np.float64)
        by_turning *= share
        full = [np.zeros((3, *chain.points.shape)) for chain in (pair.wheel, pair.rail)]
        for whole, (within, fit) in zip(full, fits, strict=True):
            whole[:, within] = fit
        by_turning = by_turning @ inverse
        matrix += by_turning @ turned_by
        found.append(
            Tangent(
                rows, matrix, by_turning, inverse @ turned_by, inverse, centre[slot], full[0], full[1],
                share * turning[0][slot], share * turning[1][slot],
                _resultants(pose, around.wheel[slot] - around.axles[slot], share * turning[0][slot]),
            )
        )  # fmt: skip
    return found


_SELECTED = (
    np.array([[-1.0, 0.0, 0.0], [0.0, -1.0, 0.0], [0.0, 0.0, -1.0], [0.0, 0.0, 1.0]]),
    np.array([[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0], [0.0, 0.0, 0.0]]),
)
"""Relative displacement and the wheel's rotation by the displacements of the wheel and of the rail."""


def _bounds(gaps: Gaps, n_positions: int) -> Ints:
    slots = np.sort(gaps.rows[:, 0] // gaps.gaps.shape[1], kind="stable")
    return np.searchsorted(slots, np.arange(n_positions + 1))


def _modes(positions: Floats, centre: Floats) -> Floats:
    """Translations and rotation about a centre over `ARM_MM`, shape (3, n, 2)."""
    modes = np.zeros((3, *positions.shape))
    modes[0, :, 0] = modes[1, :, 1] = 1.0
    arms = (positions - centre) / ARM_MM
    modes[2] = np.stack((-arms[:, 1], arms[:, 0]), axis=1)
    return modes


def _fit(positions: Floats, weights: Floats, centre: Floats) -> Floats:
    """Motion as a whole that fits displacements of nodes best, as a linear map of them, shape (3, n, 2)."""
    if not weights.any():
        return np.zeros((3, *positions.shape))
    modes = _modes(positions, centre)
    weighted = modes * weights[:, None]
    normal = np.einsum("anx,bnx->ab", modes, weighted)
    normal[np.diag_indices(3)] += 1e-12 * normal[0, 0]
    return np.einsum("ab,bnx->anx", np.linalg.inv(normal), weighted)


def _resultants(pose: SidePose, arms: Floats, loads: Floats) -> Floats:
    """Forces and moments (3, 4) of loads (4, n, 2) on the wheel.

    The moment does not change where the wheel's rotation turns forces and arms alike.
    """
    forces = loads.sum(axis=1) @ pose.rail_turn.T
    moments = np.einsum("n,an->a", arms[:, 0], loads[..., 1]) - np.einsum("n,an->a", arms[:, 1], loads[..., 0])
    moments[3] = 0.0
    result: Floats = np.vstack((forces.T, moments)) * pose.signs[:, None]
    return result


def _jacobian(gradients: Floats, rows: Ints, columns: Ints, n_rows: int, n_nodes: int) -> Floats:
    """Derivatives of the gaps of a slot's window by the positions of some nodes, shape (n_rows, 2 n_nodes)."""
    columns = columns.reshape(len(gradients), 1, gradients.shape[2])
    flat = np.broadcast_to(rows[:, :, None] * n_nodes + columns, gradients.shape[:3]).ravel()
    size = (n_rows + 1) * n_nodes  # one more row: what is not evaluated
    entries = [np.bincount(flat, gradients[..., x].ravel(), minlength=size) for x in range(2)]
    return np.stack(entries, axis=1).reshape(n_rows + 1, -1)[:-1].astype(np.float64, copy=False)


def _turning(
    pose: SidePose,
    around: SurfacePositions,
    candidates: Candidates,
    forces: Floats,
    carried_load: Loads,
    centre: Floats,
) -> tuple[Floats, Floats]:
    """Changes of the loads by displacements of the rail against the wheel, and by rotation of both, in its frame.

    Two arrays (L, 4, n, 2).
    """
    wheel, rail = carried_load.wheel @ around.turns.swapaxes(1, 2), carried_load.rail
    found: list[list[Floats]] = [[], []]
    arms = (around.rail - centre[:, None]) / ARM_MM
    ones, zeros = np.ones(arms.shape[:2]), np.zeros(arms.shape[:2])
    for mode in ((ones, zeros), (zeros, ones), (-arms[..., 1], arms[..., 0])):
        moved = SurfacePositions(
            around.wheel, around.rail + DIFFERENCE_MM * np.stack(mode, axis=2), around.turns, around.axles,
            around.lowered, around.scale,
        )  # fmt: skip
        after = carried(pose, pose.pair.gaps(moved.wheel, moved.rail, candidates), moved, forces)
        found[0].append((after.wheel @ around.turns.swapaxes(1, 2) - wheel) / DIFFERENCE_MM)
        found[1].append((after.rail - rail) / DIFFERENCE_MM)
    for each, load in zip(found, (wheel, rail), strict=True):
        each.append(np.stack((-load[..., 1], load[..., 0]), axis=2) / ARM_MM)
    return np.stack(found[0], axis=1), np.stack(found[1], axis=1)
