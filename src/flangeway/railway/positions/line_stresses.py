"""Stresses inside a body on many lines, each under its own forces on the surface.

Displacements are superposed from those under unit forces, and are found only in the cells that the lines run through.
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from typing import Self

import numpy as np

from flangeway.elements import monomials
from flangeway.elements.monomials import Frame
from flangeway.mesh import PolyMesh
from flangeway.post import Stresses
from flangeway.post.lines import NEAR, OUTSIDE
from flangeway.problems import LinearBody
from flangeway.space import CellBatch
from flangeway.types import Bools, Floats, Ints

Solve = Callable[[Floats], Floats]
"""Displacements (m, n_dofs, 2) of all nodes under loads (m, n, 2) on the surface nodes."""

MOST_BYTES = 200e6  # memory for the columns of one body
AT_ONCE = 32  # loads that are solved for together, and unit forces of a block


@dataclass(frozen=True, eq=False)
class Lines:
    """Points of straight lines from the surface into a body, in its frame.

    - `starts`, `directions`: where they begin and unit vectors, each (m, 2).
    - `depths`: distances of the points from the starts, >= 0 and rising along each line, shape (m, n).
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

    - `n_nodes`: number of the nodes of its surface.
    """

    def __init__(self, body: LinearBody, n_nodes: int) -> None:
        self._body = body
        self._columns = FieldColumns(n_nodes, body.space.n_dofs)
        groups: dict[tuple[int, int, int], list[CellBatch]] = {}
        for batch in body.space.batches():
            groups.setdefault((id(batch.element), len(batch.vertices), batch.outline.ndim), []).append(batch)
        self._batches = [_joined(group) for group in groups.values()]
        self._batch_of, self._place_in = np.full((2, body.space.mesh.n_cells), OUTSIDE)
        for number, batch in enumerate(self._batches):
            self._batch_of[batch.cells], self._place_in[batch.cells] = number, np.arange(len(batch.cells))

    def in_plane_shear(self, lines: Lines, forces: Floats, solve: Solve, *, superposed: bool) -> Floats:
        """Maximum in-plane shear stress on the lines, shape (m, n), not-a-number outside of the body.

        - `forces`: for each line the forces on the surface nodes, shape (m, n_nodes, 2).
        - `solve`: gives the fields of forces, the same at each call.
        - `superposed`: whether fields are superposed from those of unit forces, which pays for hundreds of lines over
          all calls.
        """
        cells = cells_along(self._body.space.mesh, lines.starts, lines.directions, lines.depths)
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
                shapes = batch.vertices[..., places], dofs, batch.outline[..., places]
                cells = CellBatch(batch.element, batch.cells[places], *shapes)
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

    - `stretches`: their stretches, shape (k,).
    - `unknowns`: their unknowns, numbered through all lines, shape (n_local, k).
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

    - `lines`, `cells`: of each stretch, shape (k,).
    - `of_point`: stretch of each point, line by line.
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
        np.concatenate([batch.outline for batch in batches], axis=-1),
    )


def fields_at(loads: Floats, wanted: Sequence[Ints], solve: Solve) -> list[Floats]:
    """Displacements at some unknowns of each load's field, each solved for; arguments as `FieldColumns.at` has them."""
    pieces = range(0, len(loads), AT_ONCE)
    fields = (field for first in pieces for field in solve(loads[first : first + AT_ONCE]))
    return [field[dofs] for field, dofs in zip(fields, wanted, strict=True)]


class FieldColumns:
    """Displacements of a body's nodes under unit forces on its surface, each solved for once.

    The unit forces are solved for in blocks, always the same, and each load's field is superposed by itself. So a
    field has the same digits whatever was asked for before.

    - `n_nodes`: number of the surface's nodes.
    - `n_dofs`: number of the unknowns of one component.
    """

    def __init__(self, n_nodes: int, n_dofs: int) -> None:
        self._n_forces = 2 * n_nodes
        self._place = np.full(-(-self._n_forces // AT_ONCE), -1)  # of each block among those that are kept
        self._n_kept = 0
        self._values = np.empty((2 * n_dofs, 0))

    def at(self, loads: Floats, wanted: Sequence[Ints], solve: Solve) -> list[Floats]:
        """Displacements at some unknowns of each load's field.

        Loads whose columns need more than `MOST_BYTES` are solved for. Returned: for each load, shape (n_wanted, 2).

        - `loads`: forces on the surface nodes, shape (m, n, 2).
        - `wanted`: unknowns of one component, for each load.
        - `solve`: solves for fields, the same at each call.
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


@dataclass(frozen=True, eq=False)
class _Passages:
    """Where lines are inside of cells, ordered by line and then by distance, each (k,)."""

    lines: Ints
    cells: Ints
    enters: Floats
    leaves: Floats


def cells_along(mesh: PolyMesh, starts: Floats, directions: Floats, distances: Floats) -> Ints:
    """Cells that points of lines lie in, as `flangeway.post.lines.locate` finds them point by point.

    Each point of the mesh is on one of two sides of a line, so that the line crosses an even number of a cell's edges
    and is in the cell between the first and the second, and so on. An edge of two cells is crossed at one place: the
    cells cover the line without gaps, whatever is rounded. Returned: shape (m, n), -1 outside of the mesh.

    - `starts`, `directions`: where the lines begin and their unit vectors, each (m, 2).
    - `distances`: of the points from the start, >= 0 and rising along each line, shape (m, n).
    """
    near = NEAR * float(np.linalg.norm(np.ptp(mesh.points, axis=0)))
    passages = _passages(mesh, starts, directions, distances[:, -1], near)
    if len(passages.lines) == 0:
        return np.full(distances.shape, OUTSIDE)
    # one row of rising numbers for all lines: each line's are shifted behind those of the one before
    shift = 2.0 * (float(distances[:, -1].max()) + 2.0 * near)
    wanted = (distances + shift * np.arange(len(starts))[:, None]).ravel()
    enters, leaves = passages.enters + shift * passages.lines, passages.leaves + shift * passages.lines

    def apart(places: Ints) -> Floats:
        return np.maximum(wanted - leaves[places], enters[places] - wanted)

    after = np.searchsorted(enters, wanted, "right")
    before, after = np.maximum(after - 1, 0), np.minimum(after, len(enters) - 1)
    nearest = np.where(apart(before) <= apart(after), before, after)
    cells = np.where(apart(nearest) <= near, passages.cells[nearest], OUTSIDE)
    return cells.reshape(distances.shape)


def _passages(mesh: PolyMesh, starts: Floats, directions: Floats, lengths: Floats, near: float) -> _Passages:
    """Find the cells that lines of some lengths run through."""
    reached = _reached(mesh, starts, starts + lengths[:, None] * directions, near)
    edges = np.zeros(mesh.n_edges, dtype=np.bool_)
    edges[mesh.cell_edges[np.repeat(reached, mesh.cell_sizes)]] = True
    numbers = np.flatnonzero(edges)
    crossed, lines, places = _crossings(mesh, numbers, starts, directions)
    cells = mesh.edge_cells[numbers[crossed]].astype(np.int64).ravel()
    lines, places = np.repeat(lines, 2), np.repeat(places, 2)
    kept = (cells != OUTSIDE) & reached[cells]
    cells, lines, places = cells[kept], lines[kept], places[kept]
    order = np.lexsort((places, cells, lines))
    first, second = order[::2], order[1::2]
    lines, cells, enters, leaves = lines[first], cells[first], places[first], places[second]
    kept = (leaves >= -near) & (enters <= lengths[lines] + near)
    lines, cells = lines[kept], cells[kept]
    enters, leaves = np.maximum(enters[kept], -near), np.minimum(leaves[kept], lengths[lines] + near)
    order = np.lexsort((leaves, enters, lines))
    return _Passages(lines[order], cells[order], enters[order], leaves[order])


def _reached(mesh: PolyMesh, starts: Floats, ends: Floats, near: float) -> Bools:
    """Which cells the box around all lines reaches, shape (n_cells,)."""
    corners = mesh.points[mesh.cell_points]
    low = np.minimum.reduceat(corners, mesh.cell_offsets[:-1])
    high = np.maximum.reduceat(corners, mesh.cell_offsets[:-1])
    places = np.concatenate((starts, ends))
    return ((low <= places.max(axis=0) + near) & (high >= places.min(axis=0) - near)).all(axis=1)


def _crossings(mesh: PolyMesh, edges: Ints, starts: Floats, directions: Floats) -> tuple[Ints, Ints, Floats]:
    """Places among some edges, lines, and distances from the lines' starts where they cross, each (k,)."""
    points, ends = np.unique(mesh.edges[edges], return_inverse=True)
    ends = ends.reshape(-1, 2)
    normals = np.stack((directions[:, 1], -directions[:, 0]))
    beside = mesh.points[points] @ normals > np.einsum("mx,xm->m", starts, normals)
    crossed, lines = np.nonzero(beside[ends[:, 0]] != beside[ends[:, 1]])
    first, second = (mesh.points[points[ends[crossed, side]]] - starts[lines] for side in range(2))
    across = [np.einsum("kx,xk->k", each, normals[:, lines]) for each in (first, second)]
    along = [np.einsum("kx,kx->k", each, directions[lines]) for each in (first, second)]
    # an edge along the line, crossed by rounding alone, is crossed somewhere
    step = across[0] - across[1]
    share = np.clip(np.divide(across[0], step, out=np.zeros_like(step), where=step != 0.0), 0.0, 1.0)
    return crossed, lines, along[0] + share * (along[1] - along[0])
