"""A body of any material: stresses and tangents at quadrature points, from the elements' projected strains."""

from dataclasses import dataclass, replace
from functools import cached_property
from typing import Protocol, Self

import numpy as np
import scipy.sparse as sp

from flangeway.elements import polygon_quadrature
from flangeway.problems.elasticity_problem import Elasticity
from flangeway.problems.items import Item
from flangeway.problems.strains import STRAIN_PLACES
from flangeway.space import CellBatch
from flangeway.types import Floats, Ints


class StressLaw(Protocol):
    """Stresses from strains and what happened before; arrays have one column a quadrature point."""

    def initial(self, n_points: int) -> Floats:
        """History of virgin points, shape (n_values, n_points)."""

    def respond(self, strains: Floats, history: Floats) -> tuple[Floats, Floats, Floats]:
        """Stresses xx, yy, xy, zz and their derivatives by the strains xx, yy, 2 xy, zz, and the new history.

        Parameters
        ----------
        strains
            Shape (4, n_points).
        history
            Of the last accepted state, shape (n_values, n_points).

        Returns
        -------
        tuple of Floats
            Shapes (4, n_points), (4, 4, n_points) and (n_values, n_points).

        """


@dataclass(frozen=True, eq=False)
class _Points:
    """Quadrature points of a batch of cells."""

    batch: CellBatch  # the cells
    places: Floats  # the points, (n_points * n_cells, 2)
    rates: Floats  # derivatives of the strains by the unknowns of one component, (n_slots, n_points, n_local, n_cells)
    weights: Floats  # volumes that belong to the points, (n_points, n_cells)
    stabilisation: Floats  # of the elastic cells, (2 n_local, 2 n_local, n_cells)

    @property
    def strain_places(self) -> list[tuple[int, int, int]]:
        """Component, slot of its rates, and place among the strains xx, yy, 2 xy, zz, of all that is not zero."""
        found = [(i, slot, int(STRAIN_PLACES[i, slot])) for i in range(2) for slot in range(len(self.rates))]
        return [each for each in found if each[2] >= 0]

    def strains(self, local: Floats) -> Floats:
        """Strains (4, n_points, n_cells) from displacements (n_local, 2, n_cells)."""
        strains = np.zeros((4, *self.weights.shape))
        for i, slot, place in self.strain_places:
            # e_qe = sum over m of rate_qme u_me
            strains[place] += np.einsum("qme,me->qe", self.rates[slot], local[:, i])
        return strains

    def forces(self, stresses: Floats) -> Floats:
        """Internal forces (n_local, 2, n_cells) of stresses (4, n_points, n_cells)."""
        forces = np.zeros((self.rates.shape[2], 2, self.rates.shape[3]))
        for i, slot, place in self.strain_places:
            forces[:, i] += np.einsum("qme,qe->me", self.rates[slot], self.weights * stresses[place])
        return forces

    def tangents(self, moduli: Floats) -> Floats:
        """Tangents (2 n_local, 2 n_local, n_cells) of moduli (4, 4, n_points, n_cells)."""
        n, n_cells = self.rates.shape[2:]
        tangents = np.zeros((n, 2, n, 2, n_cells))
        for i, slot, row in self.strain_places:
            for j, other, column in self.strain_places:
                # K_mne = sum over q of rate_qme w_qe D_qe rate_qne
                weighted = self.rates[slot] * (self.weights * moduli[row, column])[:, None]
                tangents[:, i, :, j] += np.einsum("qme,qne->mne", weighted, self.rates[other])
        return tangents.reshape(2 * n, 2 * n, n_cells) + self.stabilisation


@dataclass(frozen=True, eq=False)
class NonlinearBody(Item):
    """A body with a nonlinear stress law; its unknowns are numbered as those of an elastic problem.

    What the projected strains do not see keeps the elastic stabilisation.

    Parameters
    ----------
    problem
        The elastic problem that gives space, thickness and stabilisation; loads and supports are not read.
    law
        The stress law.
    history
        What happened before, one array for each batch of cells; left out: nothing.

    """

    problem: Elasticity
    law: StressLaw
    history: tuple[Floats, ...] = ()

    def __post_init__(self) -> None:
        if not self.history:
            virgin = tuple(self.law.initial(points.weights.size) for points in self._points)
            object.__setattr__(self, "history", virgin)

    @property
    def unknowns(self) -> Ints:
        """See `Item.unknowns`."""
        return np.arange(2 * self.problem.space.n_dofs)

    def residual(self, state: Floats) -> Floats:
        """See `Item.residual`."""
        result = np.zeros(len(state))
        for points, (stresses, _, _) in zip(self._points, self._responses(state), strict=True):
            numbers = points.batch.vector_dofs(2)
            forces = points.forces(stresses).reshape(numbers.shape)
            forces += np.einsum("mne,ne->me", points.stabilisation, state[numbers])
            np.add.at(result, numbers, forces)
        return result

    def tangent(self, state: Floats) -> sp.csr_array:
        """See `Item.tangent`."""
        responses = zip(self._points, self._responses(state), strict=True)
        tangents = {points.batch.cells[0]: points.tangents(moduli) for points, (_, moduli, _) in responses}
        return self.problem.space.assemble(lambda batch: tangents[batch.cells[0]], n_components=2).full()

    def commit(self, state: Floats) -> Self:
        """See `Item.commit`."""
        return replace(self, history=tuple(after for _, _, after in self._responses(state)))

    def stresses(self, state: Floats) -> tuple[Floats, Floats]:
        """Quadrature points (n, 2) and stresses xx, yy, xy, zz there, shape (4, n)."""
        places = [points.places for points in self._points]
        stresses = [stresses.reshape(4, -1) for stresses, _, _ in self._responses(state)]
        return np.concatenate(places), np.concatenate(stresses, axis=1)

    def _responses(self, state: Floats) -> list[tuple[Floats, Floats, Floats]]:
        """Stresses (4, n_points, n_cells), moduli (4, 4, n_points, n_cells) and new history of each batch."""
        found = []
        for points, before in zip(self._points, self.history, strict=True):
            strains = points.strains(state[points.batch.vector_dofs(2)].reshape(-1, 2, len(points.batch.cells)))
            stresses, moduli, after = self.law.respond(strains.reshape(4, -1), before)
            shape = points.weights.shape
            found.append((stresses.reshape(4, *shape), moduli.reshape(4, 4, *shape), after))
        return found

    @cached_property
    def _points(self) -> tuple[_Points, ...]:
        found = []
        for batch in self.problem.space.batches():
            reconstruction = self.problem.for_energy(batch.element.reconstruct(batch.outline))
            coefficients = self.problem.strains(batch, reconstruction).coefficients
            # products of two strains of degree k - 1, about an axis times the radius
            degree = max(2 * (reconstruction.order - 1) + self.problem.axisymmetric, 1)
            places, weights = polygon_quadrature(batch.outline, degree)
            rates = np.einsum("aqe,asme->sqme", reconstruction.at(places)[: len(coefficients)], coefficients)
            rows = places.swapaxes(1, 2)
            stabilisation = self.problem.cell_stabilisation(batch)
            found.append(_Points(batch, rows.reshape(-1, 2), rates, weights * self.problem.depth(rows), stabilisation))
        return tuple(found)
