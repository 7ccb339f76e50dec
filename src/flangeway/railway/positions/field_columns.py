"""Displacements inside a body under many loads on its surface, superposed from those under unit forces."""

from collections.abc import Callable, Sequence

import numpy as np

from flangeway.types import Floats, Ints

Solve = Callable[[Floats], Floats]
"""Displacements (m, n_dofs, 2) of all nodes under loads (m, n, 2) on the surface nodes."""

MOST_BYTES = 200e6
"""Memory for the columns of one body."""

AT_ONCE = 32
"""Loads that are solved for together, and unit forces of a block."""


def fields_at(loads: Floats, wanted: Sequence[Ints], solve: Solve) -> list[Floats]:
    """Displacements at some unknowns of each load's field, each solved for; arguments as `FieldColumns.at` has them."""
    pieces = range(0, len(loads), AT_ONCE)
    fields = (field for first in pieces for field in solve(loads[first : first + AT_ONCE]))
    return [field[dofs] for field, dofs in zip(fields, wanted, strict=True)]


class FieldColumns:
    """Displacements of a body's nodes under unit forces on its surface, each solved for once.

    The unit forces are solved for in blocks, always the same, and each load's field is superposed by itself. So a
    field has the same digits whatever was asked for before.

    Parameters
    ----------
    n_nodes
        Number of the surface's nodes.
    n_dofs
        Number of the unknowns of one component.

    """

    def __init__(self, n_nodes: int, n_dofs: int) -> None:
        self._n_forces = 2 * n_nodes
        self._place = np.full(-(-self._n_forces // AT_ONCE), -1)  # of each block among those that are kept
        self._n_kept = 0
        self._values = np.empty((2 * n_dofs, 0))

    def at(self, loads: Floats, wanted: Sequence[Ints], solve: Solve) -> list[Floats]:
        """Displacements at some unknowns of each load's field.

        Loads whose columns need more than `MOST_BYTES` are solved for.

        Parameters
        ----------
        loads
            Forces on the surface nodes, shape (m, n, 2).
        wanted
            Unknowns of one component, for each load.
        solve
            Solves for fields, the same at each call.

        Returns
        -------
        list
            For each load, shape (n_wanted, 2).

        """
        flat = loads.reshape(len(loads), -1)
        needed = np.unique(np.flatnonzero(flat.any(axis=0)) // AT_ONCE)
        if len(needed) > self._most:
            return fields_at(loads, wanted, solve)
        self._keep(needed, solve)
        found = []
        for forces, dofs in zip(flat, wanted, strict=True):
            loaded = np.flatnonzero(forces)
            columns = AT_ONCE * self._place[loaded // AT_ONCE] + loaded % AT_ONCE
            rows = (2 * dofs[:, None] + np.arange(2)).reshape(-1, 1)
            matrix = self._values.take(rows * self._values.shape[1] + columns)  # of the flat values
            found.append((matrix @ forces[loaded]).reshape(-1, 2))
        return found

    @property
    def n_bytes(self) -> int:
        """Memory that the columns take."""
        return self._values.nbytes

    @property
    def _most(self) -> int:
        return int(MOST_BYTES // (8 * AT_ONCE * len(self._values)))

    def _keep(self, needed: Ints, solve: Solve) -> None:
        """Solve for the blocks that are not kept; all others are forgotten where there is no room."""
        missing = needed[self._place[needed] < 0]
        if self._n_kept + len(missing) > self._most:
            self._place[:], self._n_kept, missing = -1, 0, needed
        self._make_room(self._n_kept + len(missing))
        for block in missing:
            forces = np.arange(AT_ONCE * block, min(AT_ONCE * (block + 1), self._n_forces))
            unit = np.zeros((len(forces), self._n_forces))
            unit[np.arange(len(forces)), forces] = 1.0
            fields = solve(unit.reshape(len(forces), -1, 2))
            first = AT_ONCE * self._n_kept
            self._values[:, first : first + len(forces)] = fields.reshape(len(forces), -1).T
            self._place[block] = self._n_kept
            self._n_kept += 1

    def _make_room(self, n_blocks: int) -> None:
        """Let the values hold so many blocks, and some more where they have to grow."""
        n_rows, n_columns = self._values.shape
        size = n_columns // AT_ONCE
        if n_blocks > size:
            grown = np.empty((n_rows, AT_ONCE * max(n_blocks, min(size + size // 4, self._most))))
            grown[:, :n_columns] = self._values
            self._values = grown
