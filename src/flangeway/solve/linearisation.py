"""What the contact solver asks of a system of contacts, and what it measures of two linearisations and forces."""

from collections.abc import Callable
from dataclasses import dataclass
from typing import Protocol

import numpy as np
import scipy.sparse as sp

from flangeway.solve.active_set import AT_LIMIT
from flangeway.types import Floats, Ints


class Linearisation(Protocol):
    """Gaps about some positions, to second order."""

    @property
    def nodes(self) -> Ints:
        """Surface nodes on which any gap depends, shape (n_touched,)."""

    @property
    def keys(self) -> Ints:
        """Identity of each constraint from one linearisation to the next, shape (m,)."""

    @property
    def partners(self) -> Ints:
        """What each constraint is against, shape (m,); a change starts a new linear piece."""

    @property
    def gaps(self) -> Floats:
        """Gaps, open where positive, shape (m,)."""

    @property
    def jacobian(self) -> sp.csr_array:
        """Derivatives of the gaps, shape (m, 2 n_touched)."""

    @property
    def compliances(self) -> Floats:
        """Penetration for each force, shape (m,)."""

    @property
    def barriers(self) -> Floats:
        """Force times gap of a barrier, and its reach, shape (m, 2): 0 and infinite where there is none."""

    @property
    def tolerances(self) -> Floats:
        """Maximum penetration that is tolerated, shape (m,): where finite, forces are corrected until it is reached."""

    @property
    def coefficients(self) -> Floats:
        """Coefficients of friction, shape (m,)."""

    def curvature(self, forces: Floats) -> sp.csr_array:
        """Sum of ``force * second derivative of the gap``, shape (2 n_touched, 2 n_touched)."""

    def slides(self, positions: Floats, before: Floats) -> "Sliding":
        """Slips from earlier positions (n_nodes, 2) of the surface nodes to those of the linearisation."""


@dataclass(frozen=True, eq=False)
class Sliding:
    """Slips of the constraints of a linearisation about its positions, and the directions of tangential forces.

    Parameters
    ----------
    slips
        Slips, shape (m,).
    jacobian
        Derivatives of the slips, shape (m, 2 n_touched).
    directions
        Nodal forces of unit tangential forces, which do the work of the slips, shape (m, 2 n_touched).
    curvature
        Called with tangential forces (m,): derivatives of their nodal forces, not symmetric, (2 n_touched,
        2 n_touched).

    """

    slips: Floats
    jacobian: sp.csr_array
    directions: sp.csr_array
    curvature: Callable[[Floats], sp.csr_array]


class Constraints(Protocol):
    """Inequalities ``gap >= 0`` on the positions of surface nodes."""

    @property
    def reach(self) -> float:
        """Distance within which a surface is certain to be found by those opposite it."""

    def linearise(self, positions: Floats, previous: Linearisation | None, *, settle: bool = False) -> Linearisation:
        """Linearise about positions (n_nodes, 2); pairs of ``previous`` are kept where they can be.

        To ``settle`` is to keep them by a wider margin, for an iteration that goes round in circles.
        """

    def unguarded(self, positions: Floats, lin: Linearisation, forces: Floats) -> Linearisation:
        """Linearise about the positions of ``lin`` without its further constraints; itself if it has none.

        Those of sharp corners under force stay: no other constraint has what such a corner presses on.
        """

    def guarded(self, positions: Floats, lin: Linearisation, forces: Floats, moved: float) -> Linearisation | None:
        """Linearise with further constraints where bodies overlap although those of ``lin`` hold; None if nowhere.

        ``moved`` is the maximum displacement, to which small depths are compared.
        """

    def describe(self, key: int, positions: Floats) -> str:
        """Name a constraint for messages: its node, where that is among positions (n_nodes, 2), and the surfaces."""


def contact_loads(jacobian: sp.csr_array, vectors: Floats) -> sp.csr_array:
    """Unit forces of constraints with a jacobian (m, n), and further vectors (n, r): loads (n, m + r)."""
    n, n_vectors = vectors.shape
    values = np.concatenate((jacobian.data, vectors.T.ravel()))
    rows = np.concatenate((jacobian.indices, np.tile(np.arange(n), n_vectors)))
    starts = np.concatenate((jacobian.indptr, jacobian.indptr[-1] + n * np.arange(1, n_vectors + 1)))
    return sp.csr_array(sp.csc_array((values, rows, starts), shape=(n, len(starts) - 1)))


def carried_forces(before: Linearisation | None, forces: Floats, after: Linearisation) -> Floats:
    """Forces of the constraints in ``after`` that were in ``before``; zero for new ones."""
    result = np.zeros(len(after.keys))
    if before is None or len(before.keys) == 0:
        return result
    order = np.argsort(before.keys)
    place = np.searchsorted(before.keys, after.keys, sorter=order)
    place = order[np.minimum(place, len(order) - 1)]
    known = before.keys[place] == after.keys
    result[known] = forces[place[known]]
    return result


def nodal_forces_of(
    lin: Linearisation, forces: Floats, slides: Sliding | None, tangential: Floats, n_nodes: int
) -> Floats:
    """Forces on all surface nodes (n_nodes, 2) by normal and tangential forces of the constraints, each (m,)."""
    result = np.zeros((n_nodes, 2))
    result[lin.nodes] = (lin.jacobian.T @ forces).reshape(-1, 2)
    if slides is not None:
        result[lin.nodes] += (slides.directions.T @ tangential).reshape(-1, 2)
    return result


def residual_of(slack: Floats, forces: Floats, unbalanced: Floats, most: float, scale: float) -> float:
    """Worst of: residual of nodal forces over the total force; violation of the law over the displacements.

    The total of the forces (m,) is at least the given maximum of nodal forces and loads. ``slack`` (m,) is what gaps
    are beyond those that the law leaves under the forces.
    """
    # a constraint that was left on the way took its force with it: what it moved is not in equilibrium
    total = max(float(forces.sum()), most)
    if total == 0.0:
        return float(np.maximum(-slack, 0.0).max(initial=0.0)) / scale
    residual = float(np.abs(unbalanced).max()) / total
    violation = np.where(forces > 0.0, np.abs(slack), np.maximum(-slack, 0.0))
    return max(residual, float(violation.max(initial=0.0)) / scale)


def changed_keys(
    before: Linearisation, forces: tuple[Floats, Floats], after: Linearisation, new_forces: tuple[Floats, Floats]
) -> tuple[int, ...]:
    """Keys of active constraints that came, went, changed their partner, or between stick and slip."""
    pairs = []
    for lin, (values, tangential) in ((before, forces), (after, new_forces)):
        active = values > 0.0
        signs = np.where(np.abs(tangential) >= (1.0 - AT_LIMIT) * lin.coefficients * values, np.sign(tangential), 0)
        each = (lin.keys[active].tolist(), lin.partners[active].tolist(), signs[active].tolist())
        pairs.append(set(zip(*each, strict=True)))
    return tuple(sorted({key for key, _, _ in pairs[0] ^ pairs[1]}))
