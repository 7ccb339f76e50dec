"""The general case from an Abaqus deck: materials, supports, loads and contact pairs as they stand in it."""

from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np
import scipy.sparse as sp
from numpy.typing import NDArray

from flangeway.errors import InputError
from flangeway.mesh import PolyMesh, read_mesh
from flangeway.mesh.abaqus import read_abaqus
from flangeway.mesh.abaqus_assembly import DeckBlock, deck_blocks, flat_deck
from flangeway.mesh.mending import DrawnMesh
from flangeway.study.bodies_shape import part_of_mesh

Ints = NDArray[np.int64]

ENDING = ".inp"
HOLDS = {"ENCASTRE": "xy", "PINNED": "xy", "XSYMM": "x", "YSYMM": "y"}
REFUSED = (
    *("RIGID BODY", "EQUATION", "TIE", "MPC", "COUPLING", "PLASTIC", "HYPERELASTIC", "EMBEDDED ELEMENT", "DYNAMIC"),
    *("CONTACT", "CONTACT INCLUSIONS", "BEAM SECTION", "ORIENTATION", "TRANSFORM", "COHESIVE SECTION", "TEMPERATURE"),
)
"""Keywords that change the answer and that no case of bodies has."""


def abaqus_values(file: Path) -> dict[str, Any]:
    """Inputs of the case ``two-bodies`` that a deck describes; its units must be mm, N and MPa.

    Each piece of the mesh is a body. Read are ``*SOLID SECTION``, ``*ELASTIC``, ``*BOUNDARY``, ``*CLOAD``, ``*DSLOAD``
    with a pressure, ``*DLOAD`` with BX and BY, and ``*CONTACT PAIR``; of several steps all loads together.

    Raises
    ------
    InputError
        If the mesh cannot be read, or the deck has what cannot be computed; the message names keyword and line.

    """
    mesh = read_mesh(file, merge_points=False).mesh
    return _Deck(file, mesh).values()


class _Deck:
    """One call of `abaqus_values`."""

    def __init__(self, file: Path, mesh: PolyMesh) -> None:
        self.file, self.mesh = file, mesh
        self.blocks = list(deck_blocks(flat_deck(_text(file))))
        for block in self.blocks:
            if block.keyword in REFUSED:
                raise self._wrong(block, f"*{block.keyword}", "linear elastic bodies in frictionless contact pairs")
        drawn = read_abaqus(file)
        self.point_sets = drawn.point_sets
        self.kept = self._kept(drawn)
        self.pieces = self._pieces()
        self.piece_of_point = np.empty(mesh.n_points, dtype=np.int64)
        for number, piece in enumerate(self.pieces):
            for cell in piece:
                self.piece_of_point[mesh.cell_points[mesh.cell_offsets[cell] : mesh.cell_offsets[cell + 1]]] = number
        self.names = [self._cells_of(piece) for piece in self.pieces]

    def values(self) -> dict[str, Any]:
        """All inputs."""
        bodies = [self._body(number) for number in range(len(self.pieces))]
        self.titles = [body["name"] for body in bodies]
        supports, loads, contacts = self._supports(), self._loads(), self._contacts()
        return {
            "thickness_mm": self._thickness(),
            "hypothesis": self._hypothesis(),
            "bodies": bodies,
            "supports": supports,
            "loads": loads,
            "contacts": contacts,
        }

    # bodies

    def _pieces(self) -> list[Ints]:
        """Cells of each piece of the mesh."""
        mesh = self.mesh
        pairs = mesh.edge_cells[mesh.edge_cells[:, 1] >= 0]
        graph = sp.coo_array((np.ones(len(pairs)), (pairs[:, 0], pairs[:, 1])), shape=(mesh.n_cells, mesh.n_cells))
        count, labels = sp.csgraph.connected_components(graph, directed=False)
        return [np.flatnonzero(labels == number) for number in range(count)]

    def _cells_of(self, piece: Ints) -> list[str]:
        """Cell sets that are a piece together: one if possible."""
        inside = {name: set(c.tolist()) for name, c in self.mesh.cell_sets.items() if np.isin(c, piece).all()}
        whole = set(piece.tolist())
        exact = sorted((name for name, cells in inside.items() if cells == whole), key=len)
        if exact:
            return exact[:1]
        found: list[str] = []
        left = set(whole)
        for name, cells in sorted(inside.items(), key=lambda each: -len(each[1])):
            if cells & left:
                found.append(name)
                left -= cells
        if left:
            x, y = self.mesh.cell_centroids[min(left)]
            raise InputError(
                f"{self.file}: the piece of the mesh with the element at ({x:g}, {y:g}), which is no element set",
                "an element set for each body",
                "add *ELSET for it",
            )
        return found

    def _body(self, number: int) -> dict[str, Any]:
        cells = self.names[number]
        sizes = self.mesh.cell_sizes[self.pieces[number]]
        materials = self._materials(self.pieces[number])
        body: dict[str, Any] = {
            "name": cells[0],
            "file": str(self.file),
            "cells": cells[0] if len(cells) == 1 else cells,
            "method": "fem" if (sizes == 3).all() else "vem",
            "order": self._order(),
        }
        if len(materials) == 1:
            return {**body, **next(iter(materials.values()))}
        return {**body, "materials": materials}

    def _materials(self, piece: Ints) -> dict[str, dict[str, float]]:
        """Material of each section's element set that is in a piece."""
        found = {}
        for block in self._all("SOLID SECTION"):
            name = block.parameters.get("ELSET", "").rpartition(".")[2]
            if name in self.mesh.cell_sets and np.isin(self.mesh.cell_sets[name], piece).any():
                found[name] = self._elastic(block)
        if not found:
            raise InputError(
                f"{self.file} without *SOLID SECTION of the element sets of a body",
                "a section with a material for every element",
                "add *SOLID SECTION, *MATERIAL and *ELASTIC, or write a case file that names the deck as file",
            )
        return found

    def _elastic(self, section: DeckBlock) -> dict[str, float]:
        wanted, current = section.parameters.get("MATERIAL", "").upper(), ""
        for block in self.blocks:
            if block.keyword == "MATERIAL":
                current = block.parameters.get("NAME", "").upper()
            elif block.keyword == "ELASTIC" and current == wanted:
                if block.parameters.get("TYPE", "ISOTROPIC").upper() != "ISOTROPIC" or len(block.rows) != 1:
                    raise self._wrong(block, "*ELASTIC of another type or with temperatures", "one row: E, nu")
                return {"young_MPa": self._number(block, 0, 0), "poisson": self._number(block, 0, 1)}
        raise self._wrong(section, f"the material {wanted!r} without *ELASTIC", "a linear elastic material")

    def _order(self) -> int:
        for block in self._all("ELEMENT"):
            kind = block.parameters.get("TYPE", "").upper()
            if any(kind.startswith(start) for start in ("CPE6", "CPE8", "CPS6", "CPS8")):
                return 2
        return 1

    def _hypothesis(self) -> str:
        for block in self._all("ELEMENT"):
            kind = block.parameters.get("TYPE", "").upper()
            if kind.startswith("CAX"):
                raise self._wrong(block, f"elements {kind}", "CPE and CPS: contact is of plane bodies")
            if kind.startswith("CPS"):
                return "plane-stress"
        return "plane-strain"

    def _thickness(self) -> float:
        found = {self._number(block, 0, 0) for block in self._all("SOLID SECTION") if block.rows and block.rows[0][0]}
        if len(found) > 1:
            raise InputError(
                f"{self.file} with sections of the thicknesses {', '.join(f'{each:g}' for each in sorted(found))}",
                "one thickness for all bodies",
                "make them equal",
            )
        return found.pop() if found else 1.0

    # supports, loads, contacts

    def _supports(self) -> list[dict[str, Any]]:
        """Supports of each set, later rows before earlier ones, as steps replace what stood before."""
        given: dict[tuple[str, str], tuple[float, DeckBlock]] = {}
        for block in self._all("BOUNDARY"):
            for number, row in enumerate(block.rows):
                words = [*row, "", "", ""]
                kind = words[1].upper()
                if kind in HOLDS:
                    for component in HOLDS[kind]:
                        given[row[0], component] = (0.0, block)
                    continue
                first = self._freedom(block, number, 1)
                last = self._freedom(block, number, 2) if words[2] else first
                value = self._number(block, number, 3) if words[3] else 0.0
                for component in (name for dof, name in ((1, "x"), (2, "y")) if first <= dof <= last):
                    given[row[0], component] = (value, block)
        tables = []
        for (where, component), (value, block) in given.items():
            held = {"hold": component, **({f"{component}_mm": value} if value else {})}
            tables += [{**place, **held} for place in self._places(where, block)]
        return tables

    def _loads(self) -> list[dict[str, Any]]:
        tables: list[dict[str, Any]] = []
        for block in self._all("CLOAD"):
            for number, row in enumerate(block.rows):
                dof, value = self._freedom(block, number, 1), self._number(block, number, 2)
                if dof not in (1, 2):
                    raise self._wrong(block, f"a load on the degree of freedom {dof}", "1 and 2")
                force = [value, 0.0] if dof == 1 else [0.0, value]
                points = self._points(row[0], block)
                tables += [{"body": body, "point_mm": point, "force_N": force} for body, point in points]
        for block in self._all("DSLOAD"):
            for number, row in enumerate(block.rows):
                if [word.upper() for word in row[1:2]] != ["P"]:
                    raise self._wrong(block, f"a load of the type {', '.join(row[1:2])}", "P, a pressure on a surface")
                value = self._number(block, number, 2)
                tables += [{**place, "pressure_MPa": value} for place in self._edges(row[0], block)]
        for block in self._all("DLOAD"):
            for number, row in enumerate(block.rows):
                kind = "".join(row[1:2]).upper()
                if kind not in ("BX", "BY"):
                    raise self._wrong(
                        block, f"a load of the type {kind}", "BX and BY; pressures by *DSLOAD on surfaces"
                    )
                value = self._number(block, number, 2)
                force = [value, 0.0] if kind == "BX" else [0.0, value]
                tables += [{**place, "body_force_N_mm3": force} for place in self._cells(row[0], block)]
        return tables

    def _contacts(self) -> list[dict[str, Any]]:
        for block in self._all("FRICTION"):
            if any(self._number(block, number, 0) != 0.0 for number in range(len(block.rows))):
                raise self._wrong(block, "a coefficient of friction", "0: contact is frictionless")
        tables = []
        for block in self._all("CONTACT PAIR"):
            for row in block.rows:
                if len(row) < 2:
                    raise self._wrong(block, "a contact of a surface with itself", "two surfaces of two bodies")
                both = [self._edges(name, block) for name in row[:2]]
                if any(len(places) != 1 for places in both):
                    raise self._wrong(block, f"surfaces {', '.join(row[:2])} of several bodies", "one body each")
                (secondary,), (primary,) = both
                tables.append(
                    {
                        "secondary": secondary["body"],
                        "secondary_edges": secondary["edges"],
                        "primary": primary["body"],
                        "primary_edges": primary["edges"],
                        "enforcement": "multiplier",
                    }
                )
        return tables

    # places

    def _places(self, where: str, block: DeckBlock) -> list[dict[str, Any]]:
        """A set's edges, and the points of it that are on none of them."""
        points = self._points(where, block)
        name = where.rpartition(".")[2]
        tables: list[dict[str, Any]] = []
        covered: set[tuple[str, float, float]] = set()
        for number, piece in enumerate(self.pieces):
            part = part_of_mesh(self.mesh, piece)
            if name in part.edge_sets:
                tables.append({"body": self.titles[number], "edges": name})
                ends = part.points[np.unique(part.edge_sets[name])]
                covered |= {(self.titles[number], x, y) for x, y in ends.tolist()}
        alone = [(body, point) for body, point in points if (body, *point) not in covered]
        return tables + [{"body": body, "point_mm": point} for body, point in alone]

    def _edges(self, where: str, block: DeckBlock) -> list[dict[str, Any]]:
        name = where.rpartition(".")[2]
        found = [
            {"body": self.titles[number], "edges": name}
            for number, piece in enumerate(self.pieces)
            if name in part_of_mesh(self.mesh, piece).edge_sets
        ]
        if not found:
            known = ", ".join(sorted(self.mesh.edge_sets))
            raise self._wrong(
                block, f"the surface {where!r}", f"surfaces of elements or nodes on the boundary: {known}"
            )
        return found

    def _cells(self, where: str, block: DeckBlock) -> list[dict[str, Any]]:
        name = where.rpartition(".")[2]
        members = self.mesh.cell_sets.get(name)
        if members is None:
            raise self._wrong(block, f"the element set {where!r}", ", ".join(sorted(self.mesh.cell_sets)))
        touched = [n for n, piece in enumerate(self.pieces) if np.isin(members, piece).any()]
        return [{"body": self.titles[number], "cells": name} for number in touched]

    def _points(self, where: str, block: DeckBlock) -> list[tuple[str, list[float]]]:
        """Bodies and places of the nodes of a set, or of one node."""
        name = where.rpartition(".")[2]
        if name not in self.point_sets:
            known = ", ".join(sorted(self.point_sets))
            raise self._wrong(block, f"the node set {where!r}", f"node sets: {known}; single nodes as sets of one")
        points = self.kept[self.point_sets[name]]
        return [
            (self.titles[self.piece_of_point[point]], self.mesh.points[point].tolist()) for point in points[points >= 0]
        ]

    def _kept(self, drawn: DrawnMesh) -> Ints:
        """Number in the mesh of each node of the file, -1 for those that no element's corner has."""
        used = np.zeros(len(drawn.points), dtype=np.bool_)
        for corners in drawn.cells:
            used[corners] = True
        points = np.asarray(drawn.points)[used, :2]
        if points.shape != self.mesh.points.shape or not np.array_equal(points, self.mesh.points):
            raise InputError(
                f"{self.file}, whose mesh has elements without area or given twice",
                "a sound mesh: flangeway.mesh.read_mesh tells what is wrong",
                "repair the mesh, or write a case file that names the deck as file",
            )
        return np.where(used, np.cumsum(used) - 1, -1)

    # words

    def _all(self, keyword: str) -> list[DeckBlock]:
        return [block for block in self.blocks if block.keyword == keyword]

    def _number(self, block: DeckBlock, row: int, place: int) -> float:
        words: Sequence[str] = block.rows[row] if row < len(block.rows) else ()
        try:
            value = float(words[place].upper().replace("D", "E"))
        except (ValueError, IndexError) as reason:
            raise self._wrong(block, ", ".join(words), "a number in each place") from reason
        if not np.isfinite(value):
            raise self._wrong(block, ", ".join(words), "finite numbers")
        return value

    def _freedom(self, block: DeckBlock, row: int, place: int) -> int:
        """A degree of freedom: 1 is x, 2 is y."""
        value = self._number(block, row, place)
        if value not in (1.0, 2.0, 3.0, 4.0, 5.0, 6.0):
            raise self._wrong(block, f"the degree of freedom {value:g}", "1 to 6, of which 1 and 2 are in the plane")
        return int(value)

    def _wrong(self, block: DeckBlock, given: str, allowed: str) -> InputError:
        return InputError(
            f"{self.file}, {block.place}: {given}",
            allowed,
            "change it, or write a case file that names the deck as file and says the rest",
        )


def _text(file: Path) -> str:
    try:
        return file.read_text(encoding="utf-8-sig")
    except UnicodeDecodeError:
        return file.read_text(encoding="latin-1")
