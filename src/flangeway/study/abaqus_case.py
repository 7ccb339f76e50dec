"""The general case from an Abaqus deck: materials, supports, loads and contact pairs as they stand in it."""

import re
from collections.abc import Iterator, Sequence
from functools import cached_property
from pathlib import Path
from typing import Any

import numpy as np
import scipy.sparse as sp
from numpy.typing import NDArray

from flangeway.errors import InputError
from flangeway.mesh import PolyMesh, read_mesh
from flangeway.mesh.abaqus import read_abaqus
from flangeway.mesh.abaqus_assembly import DeckBlock, flat_blocks
from flangeway.study.abaqus_history import DeckHistory, Label, Row
from flangeway.study.abaqus_places import DeckPlaces, Place, named

Ints = NDArray[np.int64]
Floats = NDArray[np.float64]

ENDING = ".inp"
HOLDS = {"ENCASTRE": "xy", "PINNED": "xy", "XSYMM": "x", "YSYMM": "y"}


def abaqus_values(file: Path) -> dict[str, Any]:
    """Inputs of the case ``two-bodies`` that a deck describes; its units must be mm, N and MPa.

    Each piece of the mesh is a body. Read are ``*SOLID SECTION``, ``*ELASTIC``, ``*BOUNDARY``, ``*CLOAD``, ``*DSLOAD``
    with a pressure, ``*DLOAD`` with BX, BY and GRAV, and ``*CONTACT PAIR``, hard or with a linear pressure-overclosure;
    of several steps what stands at the end of the last one.

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
        self.blocks = flat_blocks(_text(file))
        self.history = DeckHistory(file, self.blocks)
        self.wrong = self.history.wrong
        self.pieces = self._pieces()
        self.names = [self._cells_of(piece) for piece in self.pieces]
        self.hypothesis = self._hypothesis()
        titles = [cells[0] for cells in self.names]
        self.places = DeckPlaces(self.history, mesh, read_abaqus(file), self.pieces, titles)

    def values(self) -> dict[str, Any]:
        """All inputs."""
        return {
            "thickness_mm": self._thickness(),
            "hypothesis": self.hypothesis,
            "bodies": [self._body(number) for number in range(len(self.pieces))],
            "supports": self._supports(),
            "loads": [*self._forces(), *self._pressures(), *self._body_forces()],
            "contacts": self._contacts(),
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
            "order": self.places.order(number),
        }
        if len(materials) == 1:
            return {**body, **next(iter(materials.values()))}
        return {**body, "materials": materials}

    @cached_property
    def _sections(self) -> dict[str, DeckBlock]:
        """Section of each element set that has one."""
        found: dict[str, DeckBlock] = {}
        for block in self._all("SOLID SECTION"):
            word = block.parameters.get("ELSET", "")
            name = named(word, sorted(self.mesh.cell_sets))
            if name is None:
                raise self.wrong(
                    block, f"the element set {word!r}, of which no element is plane", "sets of CPE and CPS"
                )
            found[name] = block
        return found

    def _materials(self, piece: Ints) -> dict[str, dict[str, float]]:
        """Material of each section's element set that is in a piece."""
        sections: dict[str, DeckBlock] = {}
        count = np.zeros(len(piece), dtype=np.int64)
        for name, section in self._sections.items():
            covered = np.isin(piece, self._cells(name))
            count += covered
            if covered.any():
                sections[name] = section
        wrong = np.flatnonzero(count != 1)
        if len(wrong):
            x, y = self.mesh.cell_centroids[piece[wrong[0]]]
            how = "without" if count[wrong[0]] == 0 else "with more than one"
            raise InputError(
                f"{self.file} {how} *SOLID SECTION for the element at ({x:g}, {y:g})",
                "a section with a material for every element",
                "add *SOLID SECTION, *MATERIAL and *ELASTIC, or write a case file that names the deck as file",
            )
        return {name: self._elastic(block) for name, block in sections.items()}

    def _elastic(self, section: DeckBlock) -> dict[str, float]:
        block = self._of_material(section, "ELASTIC")
        kind = block.parameters.get("TYPE", "ISOTROPIC").upper()
        if kind not in ("ISO", "ISOTROPIC") or len(block.rows) != 1:
            raise self.wrong(block, "*ELASTIC of another type or with temperatures", "one row: E, nu")
        return {"young_MPa": self._number(block, 0, 0), "poisson": self._number(block, 0, 1)}

    def _of_material(self, section: DeckBlock, keyword: str) -> DeckBlock:
        """Keyword of a section's material."""
        wanted = section.parameters.get("MATERIAL", "").upper()
        found = next(self._under("MATERIAL", wanted, keyword), None)
        if found is None:
            raise self.wrong(section, f"the material {wanted!r} without *{keyword}", f"a material with *{keyword}")
        return found

    def _hypothesis(self) -> str:
        """Plane strain or stress, from the types of elements; line elements only name edges."""
        found: dict[str, DeckBlock] = {}
        for block in self._all("ELEMENT"):
            kind = block.parameters.get("TYPE", "").upper()
            if re.match(r"CP[ES]\d", kind):
                found.setdefault(kind[:3], block)
            elif not re.match(r"[BTR]\dD?\d", kind):
                raise self.wrong(block, f"elements {kind}", "CPE and CPS: contact is of plane bodies")
        if len(found) > 1:
            raise self.wrong(
                list(found.values())[-1], "CPE and CPS in one deck", "all in plane strain, or all in stress"
            )
        return "plane-stress" if "CPS" in found else "plane-strain"

    def _thickness(self) -> float:
        blocks = self._sections.values()
        found = {self._number(block, 0, 0) if block.rows and block.rows[0][0] else 1.0 for block in blocks}
        if len(found) > 1:
            raise InputError(
                f"{self.file} with sections of the thicknesses {', '.join(f'{each:g}' for each in sorted(found))}",
                "one thickness for all bodies; it is 1 where none is given",
                "make them equal",
            )
        return found.pop()

    # supports, loads, contacts

    def _supports(self) -> list[dict[str, Any]]:
        """Supports of each set."""
        standing = dict(self.history.last("BOUNDARY", self._held))
        tables = []
        given: dict[tuple[str, int, Place], tuple[float, Row]] = {}
        for (name, component), row in standing.items():
            value = self._held(row.block, row.number)[name, component] * row.factor
            for number, spot in self.places.spots(row.where, row.block):
                other, first = given.setdefault((component, number, spot), (value, row))
                if other != value:
                    raise self.wrong(
                        row.block,
                        f"{row.where} with {component} = {value:g}, where {first.where} in line {first.block.line} has "
                        f"{component} = {other:g} at ({spot[0]:g}, {spot[1]:g})",
                        "one displacement for each node at the end of the last step",
                        "give it anew to the set that had it before, or take sets without common nodes",
                    )
            held = {"hold": component, **({f"{component}_mm": value} if value else {})}
            tables += [{**place, **held} for place in self.places.supports(row.where, row.block)]
        return tables

    def _held(self, block: DeckBlock, row: int) -> dict[tuple[str, str], float]:
        """Displacement of each set and component of a row of ``*BOUNDARY``."""
        words = [*block.rows[row], "", "", ""]
        where, kind = words[0].casefold(), words[1].upper()
        if kind in HOLDS:
            return {(where, component): 0.0 for component in HOLDS[kind]}
        first = self._freedom(block, row, 1)
        last = self._freedom(block, row, 2) if words[2] else first
        value = self._number(block, row, 3) if words[3] else 0.0
        return {(where, name): value for dof, name in ((1, "x"), (2, "y")) if first <= dof <= last}

    def _forces(self) -> list[dict[str, Any]]:
        tables: list[dict[str, Any]] = []
        for (_, component), row in self.history.last("CLOAD", self._pushed):
            value = row.factor * self._number(row.block, row.number, 2)
            force = [value, 0.0] if component == "x" else [0.0, value]
            for number, spot in self.places.loaded(row.where, row.block):
                tables.append({"body": self.places.titles[number], "point_mm": list(spot), "force_N": force})
        return tables

    def _pushed(self, block: DeckBlock, row: int) -> list[Label]:
        """Set and component of a row of ``*CLOAD``."""
        dof = self._freedom(block, row, 1)
        if dof not in (1, 2):
            raise self.wrong(block, f"a load on the degree of freedom {dof}", "1 and 2")
        return [(block.rows[row][0].casefold(), "xy"[dof - 1])]

    def _pressures(self) -> list[dict[str, Any]]:
        tables: list[dict[str, Any]] = []
        for (_, kind), row in self.history.last("DSLOAD", _place_and_kind):
            if kind != "P":
                raise self.wrong(row.block, f"a load of the type {kind}", "P, a pressure on a surface")
            value = row.factor * self._number(row.block, row.number, 2)
            tables += [{**place, "pressure_MPa": value} for place in self.places.edges(row.where, row.block)]
        return tables

    def _body_forces(self) -> list[dict[str, Any]]:
        tables: list[dict[str, Any]] = []
        for (_, kind), row in self.history.last("DLOAD", _place_and_kind):
            block = row.block
            if kind not in ("BX", "BY", "GRAV"):
                side = re.fullmatch(r"P([1-4])", kind)
                told = (
                    f"write *SURFACE, NAME=A with {row.where}, S{side[1]}, and *DSLOAD with A, P, value" if side else ""
                )
                allowed = "BX, BY and GRAV; pressures by *DSLOAD on surfaces"
                raise self.wrong(block, f"a load of the type {kind}", allowed, told)
            value = row.factor * self._number(block, row.number, 2)
            name = self.places.cells(row.where, block)
            if kind == "GRAV":
                way = value * np.array([self._number(block, row.number, place) for place in (3, 4)])
                tables += self._weights(name, way, block)
            else:
                tables += self._spread(name, [value, 0.0] if kind == "BX" else [0.0, value])
        return tables

    def _weights(self, name: str | None, acceleration: Floats, block: DeckBlock) -> list[dict[str, Any]]:
        """Body forces of the elements of a set, each section with its density."""
        tables: list[dict[str, Any]] = []
        loaded = np.arange(self.mesh.n_cells) if name is None else self._cells(name)
        for section, each in self._sections.items():
            mine = np.isin(self._cells(section), loaded)
            if mine.any():
                density = self._number(self._of_material(each, "DENSITY"), 0, 0)
                if not mine.all() and not np.isin(loaded, self._cells(section)).all():
                    raise self.wrong(block, f"{name}, which has parts of several sections", "whole sections, or one")
                tables += self._spread(section if mine.all() else name, (density * acceleration).tolist())
        return tables

    def _spread(self, name: str | None, force: list[float]) -> list[dict[str, Any]]:
        """A body force on a cell set, None for all, of each body that has some of it."""
        if name is None:
            return [{"body": body, "body_force_N_mm3": force} for body in self.places.titles]
        bodies = self.places.bodies_of(self._cells(name))
        return [{"body": body, "cells": name, "body_force_N_mm3": force} for body in bodies]

    def _contacts(self) -> list[dict[str, Any]]:
        for block in self._all("FRICTION"):
            if any(self._number(block, number, 0) != 0.0 for number in range(len(block.rows))):
                raise self.wrong(block, "a coefficient of friction", "0: contact is frictionless")
        tables = []
        for block in self._all("CONTACT PAIR"):
            for row in block.rows:
                if len(row) < 2:
                    raise self.wrong(block, "a contact of a surface with itself", "two surfaces of two bodies")
                both = [self.places.edges(name, block) for name in row[:2]]
                if any(len(places) != 1 for places in both):
                    raise self.wrong(block, f"surfaces {', '.join(row[:2])} of several bodies", "one body each")
                (secondary,), (primary,) = both
                tables.append(
                    {
                        "secondary": secondary["body"],
                        "secondary_edges": secondary["edges"],
                        "primary": primary["body"],
                        "primary_edges": primary["edges"],
                        **self._enforcement(block.parameters.get("INTERACTION", "")),
                    }
                )
        return tables

    def _enforcement(self, interaction: str) -> dict[str, Any]:
        """How the contact of a surface interaction keeps penetration off: hard, or a linear pressure-overclosure."""
        for block in self._under("SURFACE INTERACTION", interaction.upper(), "SURFACE BEHAVIOR"):
            kind = block.parameters.get("PRESSURE-OVERCLOSURE", "HARD").upper()
            if kind == "LINEAR":
                return {"enforcement": "penalty", "penalty_MPa_mm": self._number(block, 0, 0)}
            if kind != "HARD":
                raise self.wrong(block, f"PRESSURE-OVERCLOSURE={kind}", "HARD or LINEAR")
        return {"enforcement": "multiplier"}

    # words

    def _all(self, keyword: str) -> list[DeckBlock]:
        return [block for block in self.blocks if block.keyword == keyword]

    def _under(self, keyword: str, name: str, wanted: str) -> Iterator[DeckBlock]:
        """Blocks of the wanted keyword that stand below another one, such as ``*MATERIAL``, of a name in capitals."""
        current = ""
        for block in self.blocks:
            if block.keyword == keyword:
                current = block.parameters.get("NAME", "").upper()
            elif block.keyword == wanted and current == name:
                yield block

    def _cells(self, name: str) -> NDArray[np.int32]:
        return self.mesh.cell_sets[name]

    def _number(self, block: DeckBlock, row: int, place: int) -> float:
        words: Sequence[str] = block.rows[row] if row < len(block.rows) else ()
        try:
            value = float(words[place].upper().replace("D", "E"))
        except (ValueError, IndexError) as reason:
            raise self.wrong(block, ", ".join(words), "a number in each place") from reason
        if not np.isfinite(value):
            raise self.wrong(block, ", ".join(words), "finite numbers")
        return value

    def _freedom(self, block: DeckBlock, row: int, place: int) -> int:
        """A degree of freedom: 1 is x, 2 is y."""
        value = self._number(block, row, place)
        if value not in (1.0, 2.0, 3.0, 4.0, 5.0, 6.0):
            raise self.wrong(block, f"the degree of freedom {value:g}", "1 to 6, of which 1 and 2 are in the plane")
        return int(value)


def _place_and_kind(block: DeckBlock, row: int) -> list[Label]:
    """Set or surface, and type, of a row of ``*DLOAD`` or ``*DSLOAD``."""
    words = [*block.rows[row], "", ""]
    return [(words[0].casefold(), words[1].upper())]


def _text(file: Path) -> str:
    try:
        return file.read_text(encoding="utf-8-sig")
    except UnicodeDecodeError:
        return file.read_text(encoding="latin-1")
