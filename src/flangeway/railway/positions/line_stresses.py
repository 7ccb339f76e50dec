"""Stresses inside a body on many lines, each under its own forces on the surface."""

from dataclasses import dataclass, replace
from typing import Self

import numpy as np

from flangeway.elements import monomials
from flangeway.elements.monomials import Frame
from flangeway.post import Stresses
from flangeway.post.location import OUTSIDE
from flangeway.problems import Body
from flangeway.railway.positions.field_columns import FieldColumns, Solve, fields_at
from flangeway.railway.positions.line_cells import cells_along
from flangeway.space import CellBatch
from flangeway.types import Floats, Ints


@dataclass(frozen=True, eq=False)
class Lines:
    """Points of straight lines from the surface into a body, in its frame.

    Parameters
    ----------
    starts, directions
        Where they begin and unit vectors, each (m, 2).
    depths
        Distances of the points from the starts, >= 0 and rising along each line, shape (m, n).

    """

    starts: Floats
    directions: Floats
    depths: Floats

    @property
    def points(self) -> Floats:
        """The points, shape (m, n, 2)."""
        return self.starts[:, None] + self.depths[:, :, None] * self.directions[:, None]


class LineStresses:
    """A body with what serves all lines: its cells, and the displacements under unit forces that were needed so far.

    Parameters
    ----------
    body
        The body.
    n_nodes
        Number of the nodes of its surface.

    """

    def __init__(self, body: Body, n_nodes: int) -> None:
        self._body = body
        self._columns = FieldColumns(n_nodes, body.space.n_dofs)
        groups: dict[tuple[int, int], list[CellBatch]] = {}
        for batch in body.space.batches():
            groups.setdefault((id(batch.element), len(batch.vertices)), []).append(batch)
        self._batches = [_joined(group) for group in groups.values()]
        self._batch_of, self._place_in = np.full((2, body.mesh.n_cells), OUTSIDE)
        for number, batch in enumerate(self._batches):
            self._batch_of[batch.cells], self._place_in[batch.cells] = number, np.arange(len(batch.cells))

    def in_plane_shear(self, lines: Lines, forces: Floats, solve: Solve, *, superposed: bool) -> Floats:
        """Maximum in-plane shear stress on the lines, shape (m, n), not-a-number outside of the body.

        Parameters
        ----------
        lines
            The lines.
        forces
            For each line the forces on the surface nodes, shape (m, n_nodes, 2).
        solve
            Gives the fields of forces, the same at each call.
        superposed
            Whether fields are superposed from those of unit forces, which pays for hundreds of lines over all calls.

        """
        cells = cells_along(self._body.mesh, lines.starts, lines.directions, lines.depths)
        shear = np.full(cells.size, np.nan)
        stretches = _Stretches.of(cells)
        chosen = self._chosen(stretches)
        if not chosen:
            return shear.reshape(cells.shape)
        unknowns, displacements = self._displacements(chosen, forces, solve, superposed)
        points, column = lines.points.reshape(-1, 2), np.full(len(stretches.cells), OUTSIDE)
        for each in chosen:
            reconstruction, stress = self._body.elasticity.cell_stresses(each.numbered(unknowns), displacements)
            column[each.stretches] = np.arange(len(each.stretches))
            here = np.flatnonzero(column[stretches.of_point] != OUTSIDE)
            columns = column[stretches.of_point[here]]
            frame = Frame(reconstruction.frame.origin[:, columns], reconstruction.frame.map[..., columns])
            values = monomials.evaluate(reconstruction.order - 1, frame.local(points[here].T))
            shear[here] = Stresses(np.einsum("sae,ae->es", stress[..., columns], values)).in_plane_shear
            column[each.stretches] = OUTSIDE
        return shear.reshape(cells.shape)

    def _chosen(self, stretches: "_Stretches") -> list["_Chosen"]:
        """Cells of each kind that the lines run through."""
        batch_of = np.where(stretches.cells == OUTSIDE, OUTSIDE, self._batch_of[stretches.cells])
        chosen = []
        for number, batch in enumerate(self._batches):
            here = np.flatnonzero(batch_of == number)
            if len(here):
                places = self._place_in[stretches.cells[here]]
                dofs = batch.dofs[:, places]
                cells = CellBatch(batch.element, batch.cells[places], batch.vertices[..., places], dofs)
                chosen.append(_Chosen(here, cells, dofs + self._body.space.n_dofs * stretches.lines[here]))
        return chosen

    def _displacements(
        self, chosen: list["_Chosen"], forces: Floats, solve: Solve, superposed: bool
    ) -> tuple[Ints, Floats]:
        """Unknowns of each line's cells, numbered through all lines and rising, and displacements (k, 2) there."""
        n_dofs = self._body.space.n_dofs
        unknowns = np.unique(np.concatenate([each.unknowns.ravel() for each in chosen]))
        of_lines = np.split(unknowns % n_dofs, np.searchsorted(unknowns, n_dofs * np.arange(1, len(forces))))
        found = self._columns.at if superposed else fields_at
        return unknowns, np.concatenate(found(forces, of_lines, solve))


@dataclass(frozen=True, eq=False)
class _Chosen:
    """Cells of one kind that lines run through, once for each line.

    Parameters
    ----------
    stretches
        Their stretches, shape (k,).
    cells
        The cells.
    unknowns
        Their unknowns, numbered through all lines, shape (n_local, k).

    """

    stretches: Ints
    cells: CellBatch
    unknowns: Ints

    def numbered(self, unknowns: Ints) -> CellBatch:
        """Cells with the places of their unknowns among some rising ones."""
        return replace(self.cells, dofs=np.searchsorted(unknowns, self.unknowns).astype(np.int32))


@dataclass(frozen=True, eq=False)
class _Stretches:
    """Neighbouring points of a line in the same cell.

    Parameters
    ----------
    lines, cells
        Of each stretch, shape (k,).
    of_point
        Stretch of each point, line by line.

    """

    lines: Ints
    cells: Ints
    of_point: Ints

    @classmethod
    def of(cls, cells: Ints) -> Self:
        """Return those of points in cells (m, n)."""
        begins = np.ones(cells.shape, dtype=np.bool_)
        begins[:, 1:] = cells[:, 1:] != cells[:, :-1]
        return cls(np.nonzero(begins)[0], cells[begins], np.cumsum(begins.ravel()) - 1)


def _joined(batches: list[CellBatch]) -> CellBatch:
    """Batches of one element and number of vertices as one."""
    return CellBatch(
        batches[0].element,
        np.concatenate([batch.cells for batch in batches]),
        np.concatenate([batch.vertices for batch in batches], axis=-1),
        np.concatenate([batch.dofs for batch in batches], axis=-1),
    )
