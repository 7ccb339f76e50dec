"""Where the sets and surfaces of an Abaqus deck are on its bodies."""

import re
from collections.abc import Collection, Iterable, Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from flangeway.errors import InputError
from flangeway.mesh import PolyMesh
from flangeway.mesh.abaqus_assembly import DeckBlock
from flangeway.mesh.mending import DrawnMesh
from flangeway.study.abaqus_history import DeckHistory
from flangeway.study.bodies_places import edge_middles
from flangeway.study.bodies_shape import part_of_mesh

Floats = NDArray[np.float64]
Ints = NDArray[np.int64]
Place = tuple[float, float]


def named(word: str, known: Collection[str]) -> str | None:
    """Name among those known that a word of a deck means, capitals or not, without its instance."""
    name = word.strip('"').rpartition(".")[2]
    if name in known:
        return name
    return next((each for each in known if each.casefold() == name.casefold()), None)


class DeckPlaces:
    """Places of a deck.

    Parameters
    ----------
    history
        The deck's keywords.
    mesh
        Its mesh.
    drawn
        The mesh as it stands in the deck.
    pieces
        Cells of each body.
    titles
        Name of each body.

    """

    def __init__(
        self,
        history: DeckHistory,
        mesh: PolyMesh,
        drawn: DrawnMesh,
        pieces: Sequence[Ints],
        titles: Sequence[str],
    ) -> None:
        self.history, self.mesh, self.pieces, self.titles = history, mesh, pieces, titles
        self.wrong = history.wrong
        self.parts = [part_of_mesh(mesh, piece) for piece in pieces]
        self.point_sets = drawn.point_sets
        for sets in (drawn.point_sets, mesh.cell_sets, mesh.edge_sets):
            self._refuse_twins(sets)
        rows = [row for block in history.blocks if block.keyword == "NODE" for row in block.rows]
        self.row_of_node = {int(row[0]): place for place, row in enumerate(rows)}
        self.second_order: set[int] = set()
        self.place_of_row = self._places_of_rows(drawn)

    def _refuse_twins(self, names: Iterable[str]) -> None:
        """Raise `InputError` for names that differ by capitals alone: for Abaqus they are one set."""
        first: dict[str, str] = {}
        for name in names:
            twin = first.setdefault(name.casefold(), name)
            if twin != name:
                raise InputError(
                    f"{self.history.file}: the sets {twin} and {name}, which are one",
                    "names that differ by more than capitals",
                    "write the name alike wherever the set is defined",
                )

    def order(self, number: int) -> int:
        """Order of the elements of a body."""
        return 2 if number in self.second_order else 1

    def supports(self, where: str, block: DeckBlock) -> list[dict[str, Any]]:
        """A set's edges, and the points of it that are on none of them; nodes of no element are left out."""
        members = self.spots(where, block)
        name = named(where, self.point_sets)
        tables: list[dict[str, Any]] = []
        covered: set[tuple[int, Place]] = set()
        for number, part in enumerate(self.parts):
            if name is not None and name in part.edge_sets:
                pairs = part.edge_sets[name]
                spots = {(number, _place(spot)) for spot in part.points[np.unique(pairs)]}
                if self.order(number) == 2:
                    spots |= {(number, _place(spot)) for spot in edge_middles(part.points, pairs)}
                if spots <= set(members):
                    tables.append({"body": self.titles[number], "edges": name})
                    covered |= spots
        alone = [member for member in members if member not in covered]
        return tables + [{"body": self.titles[number], "point_mm": list(spot)} for number, spot in alone]

    def loaded(self, where: str, block: DeckBlock) -> list[tuple[int, Place]]:
        """Number of the body and place of each node of a set; an InputError if a node is of no element."""
        for row in self._rows(where, block):
            if row not in self.place_of_row:
                raise self.wrong(block, f"{where}, which has a node of no element", "nodes of elements")
        return self.spots(where, block)

    def spots(self, where: str, block: DeckBlock) -> list[tuple[int, Place]]:
        """Number of the body and place of each node of a set that an element has; an InputError if there is none."""
        found = [self.place_of_row[row] for row in self._rows(where, block) if row in self.place_of_row]
        if not found:
            raise self.wrong(block, f"{where}, which has no node of an element", "nodes of elements")
        return found

    def edges(self, where: str, block: DeckBlock) -> list[dict[str, Any]]:
        """Body and edge set of a surface, for each body that it is on."""
        known = sorted(self.mesh.edge_sets)
        name = named(where, known)
        found = [
            {"body": self.titles[number], "edges": name}
            for number, part in enumerate(self.parts)
            if name in part.edge_sets
        ]
        if not found:
            raise self.wrong(
                block, f"the surface {where!r}", f"surfaces of elements or nodes on the boundary: {', '.join(known)}"
            )
        return found

    def cells(self, where: str, block: DeckBlock) -> str | None:
        """Element set of a name, None for all."""
        if not where:
            return None
        known = sorted(self.mesh.cell_sets)
        name = named(where, known)
        if name is None:
            raise self.wrong(block, f"the element set {where!r}", ", ".join(known))
        return name

    def bodies_of(self, cells: NDArray[np.int32]) -> list[str]:
        """Bodies that have some of the cells."""
        return [self.titles[number] for number, piece in enumerate(self.pieces) if np.isin(cells, piece).any()]

    def _rows(self, where: str, block: DeckBlock) -> list[int]:
        """Nodes of a set, or a node by its number, as rows of the deck's list."""
        name = named(where, self.point_sets)
        if name is not None:
            return [int(row) for row in self.point_sets[name]]
        if where.isdigit() and int(where) in self.row_of_node:
            return [self.row_of_node[int(where)]]
        known = ", ".join(sorted(self.point_sets)) or "it has none"
        raise self.wrong(block, f"the node set {where!r}", f"numbers of nodes, and node sets: {known}")

    def _places_of_rows(self, drawn: DrawnMesh) -> dict[int, tuple[int, Place]]:
        """Body and place of each node of an element; middles of sides are on the straight line, as they are read."""
        points = np.asarray(drawn.points)[:, :2]
        used = np.unique(np.concatenate(drawn.cells))
        if points[used].shape != self.mesh.points.shape or not np.array_equal(points[used], self.mesh.points):
            raise InputError(
                f"{self.history.file}, whose mesh has elements without area or given twice",
                "a sound mesh: flangeway.mesh.read_mesh tells what is wrong",
                "repair the mesh, or write a case file that names the deck as file",
            )
        piece_of_cell = np.empty(self.mesh.n_cells, dtype=np.int64)
        for number, piece in enumerate(self.pieces):
            piece_of_cell[piece] = number
        piece_of_point = np.empty(self.mesh.n_points, dtype=np.int64)
        piece_of_point[self.mesh.cell_points] = np.repeat(piece_of_cell, self.mesh.cell_sizes)
        pieces = dict(zip(used.tolist(), piece_of_point.tolist(), strict=True))
        found = {row: (piece, _place(points[row])) for row, piece in pieces.items()}
        for row, (start, end) in self._middles().items():
            found[row] = (pieces[start], _place(0.5 * (points[start] + points[end])))
            self.second_order.add(pieces[start])
        return found

    def _middles(self) -> dict[int, tuple[int, int]]:
        """Rows of the ends of the side that a middle node is on."""
        found: dict[int, tuple[int, int]] = {}
        for block in self.history.blocks:
            kind = re.match(r"CP[ES]([68])", block.parameters.get("TYPE", "").upper())
            if block.keyword == "ELEMENT" and kind:
                n_nodes = int(kind[1])
                flat = [int(word) for row in block.rows for word in row]
                for element in np.array(flat).reshape(-1, n_nodes + 1)[:, 1:].tolist():
                    corners = [self.row_of_node[node] for node in element[: n_nodes // 2]]
                    for place, node in enumerate(element[n_nodes // 2 :]):
                        found[self.row_of_node[node]] = (corners[place], corners[(place + 1) % len(corners)])
        return found


def _place(spot: Floats) -> Place:
    return float(spot[0]), float(spot[1])
