"""Gaps of all contacts about some positions, and what is measured of two linearisations and forces."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import cached_property, partial

import numpy as np
import scipy.sparse as sp

from flangeway.contact.pairs import Constraints, Pairs
from flangeway.contact.slip import Slides
from flangeway.solve.active_set import AT_LIMIT
from flangeway.types import Bools, Floats, Ints


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


@dataclass(frozen=True, eq=False)
class ContactLinearisation:
    """Gaps of all contacts about some positions, to second order.

    Parameters
    ----------
    pairs
        The constraints of each contact; their parts follow each other.
    starts
        First constraint of each part, and the number of all.
    nodes
        Surface nodes on which any gap depends, shape (n_touched,).
    keys
        Identity of each constraint from one linearisation to the next, shape (m,).
    partners
        What each constraint is against, shape (m,); a change starts a new linear piece.
    gaps
        Gaps, open where positive, shape (m,).
    compliances
        Penetration for each force, shape (m,).
    barriers
        Force times gap of a barrier, and its reach, shape (m, 2): 0 and infinite where there is none.
    tolerances
        Maximum penetration that is tolerated, shape (m,): where finite, forces are corrected until it is reached.
    coefficients
        Coefficients of friction, shape (m,).
    term_points
        Numbers among the touched points of those of each part's terms, arrays (p, w).
    spread
        Positions of the touched points by those of ``nodes``, components after each other; None: they are the nodes.
    guarded_nodes
        Which nodes of each contact's secondary and primary surface are guarded, see `flangeway.contact.guards`.

    """

    pairs: tuple[Constraints, ...]
    starts: Ints
    nodes: Ints
    keys: Ints
    partners: Ints
    gaps: Floats
    compliances: Floats
    barriers: Floats
    tolerances: Floats
    coefficients: Floats
    term_points: tuple[Ints, ...]
    guarded_nodes: tuple[tuple[Bools, Bools], ...]
    spread: sp.csr_array | None = None

    @property
    def parts(self) -> list[Pairs]:
        """Constraints of one kind each, contact by contact."""
        return [part for pairs in self.pairs for part in pairs.parts]

    @cached_property
    def jacobian(self) -> sp.csr_array:
        """Derivatives of the gaps, shape (m, 2 n_touched)."""
        return self._by_nodes([part.gradients for part in self.parts])

    def curvature(self, forces: Floats) -> sp.csr_array:
        """Sum of ``force * second derivative of the gap`` over the constraints, shape (2 n_touched, 2 n_touched)."""
        return self._second([part.curvatures for part in self.parts], forces)

    def slides(self, positions: Floats, before: Floats) -> Sliding:
        """Slips since earlier positions (n_nodes, 2) of the surface nodes, which are at others now."""
        now, was = self.points(positions), self.points(before)
        found = []
        for number, (pairs, terms) in enumerate(zip(self.parts, self.term_points, strict=True)):
            if self.coefficients[self.starts[number] : self.starts[number + 1]].any():
                found.append(pairs.slides(now[terms], was[terms]))
            else:
                found.append(_no_slides(pairs))
        jacobian = self._by_nodes([slides.rates for slides in found])
        directions = self._by_nodes([slides.directions for slides in found])
        slips = np.concatenate([slides.slips for slides in found])
        return Sliding(slips, jacobian, directions, partial(self._second, [slides.turns for slides in found]))

    def _by_nodes(self, all_gradients: Sequence[Floats]) -> sp.csr_array:
        """Derivatives of all constraints by the touched nodes, from those (p, r, w, 2) of each part's terms."""
        rows, columns, values = [], [], []
        for start, part, place, gradients in zip(
            self.starts[:-1], self.parts, self.term_points, all_gradients, strict=True
        ):
            rows.append(np.broadcast_to(start + part.rows[:, :, None, None], gradients.shape).ravel())
            columns.append(np.broadcast_to(components_of(place)[:, None], gradients.shape).ravel())
            values.append(gradients.ravel())
        found = self._matrix(int(self.starts[-1]), rows, columns, values)
        return found if self.spread is None else sp.csr_array(found @ self.spread)

    def _second(self, seconds: Sequence[Callable[[Floats], tuple[Ints, Floats]]], forces: Floats) -> sp.csr_array:
        """Sum of ``force * second derivative`` by a function of each part, which has those of its terms."""
        rows, columns, values = [], [], []
        for number, second in enumerate(seconds):
            own = forces[self.starts[number] : self.starts[number + 1]]
            if not own.any():
                continue
            loaded, found = second(own)
            dofs = components_of(self.term_points[number][loaded]).reshape(len(loaded), -1)
            rows.append(np.broadcast_to(dofs[:, :, None], found.shape).ravel())
            columns.append(np.broadcast_to(dofs[:, None, :], found.shape).ravel())
            values.append(found.ravel())
        if not values:
            return sp.csr_array((2 * len(self.nodes), 2 * len(self.nodes)))
        found = self._matrix(None, rows, columns, values)
        return found if self.spread is None else sp.csr_array(self.spread.T @ found @ self.spread)

    def _matrix(
        self, n_rows: int | None, rows: Sequence[Ints], columns: Sequence[Ints], values: Sequence[Floats]
    ) -> sp.csr_array:
        """Matrix of entries whose columns, and rows where no number is given, are components of the touched points."""
        n = 2 * len(self.nodes) if self.spread is None else self.spread.shape[0]
        entries = np.concatenate(rows), np.concatenate(columns)
        shape = (n if n_rows is None else n_rows, n)
        found = sp.csr_array(sp.coo_array((np.concatenate(values), entries), shape=shape))
        found.eliminate_zeros()
        return found

    def points(self, positions: Floats) -> Floats:
        """Positions of the touched points by those of all surface nodes (n_nodes, 2), shape (n, 2)."""
        touched = positions[self.nodes]
        return touched if self.spread is None else (self.spread @ touched.ravel()).reshape(-1, 2)


def _no_slides(pairs: Pairs) -> Slides:
    """Those of a contact without friction."""
    nothing = np.zeros(pairs.gradients.shape)
    return Slides(np.zeros(len(pairs.keys)), nothing, nothing, pairs.curvatures)


def components_of(nodes: Ints) -> Ints:
    """Numbers of the components of nodes (..., w), shape (..., w, 2)."""
    return 2 * nodes[..., None] + np.arange(2)


def carried_forces(before: ContactLinearisation | None, forces: Floats, after: ContactLinearisation) -> Floats:
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
    lin: ContactLinearisation, forces: Floats, slides: Sliding | None, tangential: Floats, n_nodes: int
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
    before: ContactLinearisation,
    forces: tuple[Floats, Floats],
    after: ContactLinearisation,
    new_forces: tuple[Floats, Floats],
) -> tuple[int, ...]:
    """Keys of active constraints that came, went, changed their partner, or between stick and slip."""
    pairs = []
    for lin, (values, tangential) in ((before, forces), (after, new_forces)):
        active = values > 0.0
        signs = np.where(np.abs(tangential) >= (1.0 - AT_LIMIT) * lin.coefficients * values, np.sign(tangential), 0)
        each = (lin.keys[active].tolist(), lin.partners[active].tolist(), signs[active].tolist())
        pairs.append(set(zip(*each, strict=True)))
    return tuple(sorted({key for key, _, _ in pairs[0] ^ pairs[1]}))
