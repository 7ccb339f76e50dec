"""Plane meshes from input files of Abaqus, and stiffness matrices that CalculiX writes."""

import re
from collections import defaultdict
from collections.abc import Sequence
from dataclasses import dataclass, field, replace
from pathlib import Path

import numpy as np
import scipy.sparse as sp
from numpy.typing import ArrayLike

from flangeway.checks import parsed_number
from flangeway.errors import MAX_LETTERS_OF_VALUE, InputError, short
from flangeway.formats.mesh_repair import DrawnMesh, second_order_sides
from flangeway.geometry.arrays import sides_of
from flangeway.types import Floats, Ints

# --- Stiffness matrices that CalculiX writes.


@dataclass(frozen=True, eq=False)
class CalculixMatrix:
    """A stiffness matrix of CalculiX, without the unknowns that its supports hold.

    Parameters
    ----------
    matrix
        Stiffness, both triangles, shape (n, n).
    nodes
        Number of the node of each row, shape (n,).
    directions
        Direction of each row, 1 for x and 2 for y, shape (n,).

    """

    matrix: sp.csr_array
    nodes: Ints
    directions: Ints

    def rows(self, numbers: ArrayLike) -> Ints:
        """Row of the x and the y component of nodes by their numbers (n,), -1 for one that is held, shape (n, 2)."""
        given = np.asarray(numbers)
        order = np.lexsort((self.directions, self.nodes))
        keys = 2 * self.nodes[order] + self.directions[order] - 1
        wanted = 2 * given[:, None] + np.arange(2)
        rows = np.minimum(np.searchsorted(keys, wanted), len(keys) - 1)
        return np.where(keys[rows] == wanted, order[rows], -1).astype(np.int64)


def read_calculix_matrix(path: str | Path) -> CalculixMatrix:
    """Read the files ``.sti`` and ``.dof`` that ``*FREQUENCY, SOLVER=MATRIXSTORAGE`` writes.

    Lines of the first have a row, a column and a value of the upper triangle, those of the second ``node.direction``
    of a row each. They have 14 digits.

    Parameters
    ----------
    path
        Either file, or their common name without an ending.

    Raises
    ------
    InputError
        If a file is not there or not of this form, or the model is not plane.

    """
    stem = Path(path)
    stem = stem.with_suffix("") if stem.suffix in (".sti", ".dof", ".mas", ".inp") else stem
    entries, numbers = (
        _columns(stem.with_name(stem.name + ending), width) for ending, width in ((".sti", 3), (".dof", 2))
    )
    nodes, directions = numbers.T.astype(np.int64)
    n = len(nodes)
    if not np.isin(directions, (1, 2)).all():
        raise InputError(
            f"{stem}.dof with the direction {directions.max()}",
            "1 and 2: a plane model",
            "take plane elements (CPE3, CPE6, CPS3, CPS6)",
        )
    first, second = entries[:, :2].T.astype(np.int64) - 1
    if len(entries) == 0 or min(first.min(), second.min()) < 0 or max(first.max(), second.max()) >= n:
        raise InputError(
            f"{stem}.sti with rows other than the {n} of {stem}.dof", "two files of one run", "run CalculiX once more"
        )
    upper = sp.csr_array(sp.coo_array((entries[:, 2], (np.minimum(first, second), np.maximum(first, second))), (n, n)))
    return CalculixMatrix(sp.csr_array(upper + sp.triu(upper, 1).T), nodes, directions)


def _columns(path: Path, width: int) -> Floats:
    """Numbers of a file, (n_lines, width); a point separates those of ``.dof``."""
    try:
        text = path.read_text(encoding="ascii")
        values = np.array((text if width == 3 else text.replace(".", " ")).split(), dtype=np.float64)
        return values.reshape(-1, width)
    except OSError as reason:
        advice = "run CalculiX with *FREQUENCY, SOLVER=MATRIXSTORAGE, which writes it"
        raise InputError(f"{path}: {reason.strerror}", "files .sti and .dof of one run", advice) from reason
    except ValueError as reason:
        form = "row, column and value" if width == 3 else "node.direction"
        raise InputError(f"{path}: {short(str(reason))}", f"lines of {form}", "take the file of CalculiX") from reason


# --- Plane meshes from Abaqus input files.


_PLANE = re.compile(r"(?:CPE|CPS|CAX|CPEG|CGAX|M3D|S|STRI|R3D)(3|4|6|8|9|65)(?:[A-Z0-9]*)$")
_LINES = {"T2D2": 2, "T2D3": 3, "T3D2": 2, "T3D3": 3, "B21": 2, "B22": 3, "B31": 2, "B32": 3, "R2D2": 2, "RAX2": 2}
_GENERATING = (
    *("NGEN", "NFILL", "NCOPY", "NMAP", "ELGEN", "ELCOPY", "INCLUDE", "SYSTEM"),
    *("PARAMETER", "IMPERFECTION", "IMPORT", "IMPORT NSET", "IMPORT ELSET"),
)
_READ = {
    "NODE": ("NSET", "SYSTEM"),
    "ELEMENT": ("TYPE", "ELSET"),
    "NSET": ("NSET", "ELSET", "GENERATE", "INSTANCE", "INTERNAL", "UNSORTED"),
    "ELSET": ("ELSET", "GENERATE", "INSTANCE", "INTERNAL"),
    "SURFACE": ("NAME", "TYPE", "INTERNAL"),
    "INSTANCE": ("NAME", "PART"),
}
"""Keywords that are read, with the parameters that are known."""
WHOLE = re.compile(r"[+-]?[0-9]{1,18}(\.0*)?")  # what 64 bits hold
MAX_MEMBERS = 5_000_000  # numbers in a set
MAX_KEYWORD_LETTERS = 10_000  # with its parameters, on all of its lines
MAX_NAMED = 30
_SILENT = ("HEADING", "PREPRINT", "PART", "END PART", "ASSEMBLY", "END ASSEMBLY", "END INSTANCE")


@dataclass(frozen=True)
class _Block:
    """A keyword in capitals, parameters by their names in capitals, words of its data lines, and the lines of all."""

    keyword: str
    parameters: dict[str, str]
    line: int
    rows: list[tuple[str, ...]] = field(default_factory=list)
    lines: list[int] = field(default_factory=list)

    @property
    def place(self) -> str:
        """How messages call it."""
        return f"*{self.keyword} in line {self.line}"

    def place_of(self, entry: tuple[str, ...]) -> str:
        """How messages call one of its rows."""
        line = self.lines[next(number for number, row in enumerate(self.rows) if row is entry)]
        return f"line {line} in the block of {self.place}"


def _blocks(text: str) -> list[_Block]:
    """Keywords of a deck with their data lines, comments left out."""
    blocks: list[_Block] = []
    pending = ""
    for number, raw in enumerate(text.splitlines(), 1):
        row, pending = pending + raw.strip(), ""
        if not row or row.startswith("**"):
            continue
        if row.startswith("*") and len(row) > MAX_KEYWORD_LETTERS:
            raise InputError(f"line {number}: a keyword of {len(row)} letters", "short keywords", "repair the lines")
        words = [word.strip() for word in row.split(",")]
        if row.startswith("*") and words[-1] == "":
            pending = row
        elif row.startswith("*"):
            pairs = [word.partition("=") for word in words[1:] if word]
            parameters = {key.strip().upper(): value.strip().strip('"') for key, _, value in pairs}
            blocks.append(_Block(" ".join(words[0][1:].upper().split()), parameters, number))
        elif blocks:
            blocks[-1].rows.append(tuple(words[:-1] if words[-1] == "" else words))
            blocks[-1].lines.append(number)
    return blocks


@dataclass
class _Model:
    """What has been read so far; elements and nodes by the numbers of the file."""

    nodes: dict[int, list[float]] = field(default_factory=dict)
    cells: dict[int, list[int]] = field(default_factory=dict)
    lines: dict[int, list[int]] = field(default_factory=dict)
    node_sets: defaultdict[str, list[int]] = field(default_factory=lambda: defaultdict(list))
    element_sets: defaultdict[str, list[int]] = field(default_factory=lambda: defaultdict(list))
    surfaces: defaultdict[str, list[tuple[str, str]]] = field(default_factory=lambda: defaultdict(list))
    notices: list[str] = field(default_factory=list)
    middles: list[int] = field(default_factory=list)
    sides: list[Ints] = field(default_factory=lambda: [np.zeros((0, 3), dtype=np.int64)])
    n_instances: int = 0


def read_abaqus(path: Path) -> DrawnMesh:
    """Read nodes, plane elements, sets and surfaces; of a deck of parts those of its one instance, which is not moved.

    Element sets become cell sets. Surfaces of elements (``S1`` to ``S4``, or the whole rim), sets of line elements, and
    the boundary edges with both ends in a node set become edge sets, in this order of precedence for one name. Elements
    of second order are read as their corners. An `InputError` if the file generates, includes or moves nodes, has
    elements that are not plane, or is broken, and for unknown parameters of a keyword; other keywords are named in a
    notice.
    """
    try:
        text = path.read_text(encoding="utf-8-sig", errors="strict")
    except UnicodeDecodeError:
        text = path.read_text(encoding="latin-1")
    if "\0" in text:
        raise InputError(f"{path}, which is binary", "an Abaqus input file, which is text", "export it as .inp")
    model = _Model()
    left: dict[str, None] = {}
    in_assembly = False
    for block in _blocks(text):
        in_assembly |= block.keyword == "ASSEMBLY"
        if in_assembly and block.keyword == "NODE":
            continue  # reference points: no element has them
        if block.keyword in _READ or block.keyword in _GENERATING:
            _take(model, block)
        elif block.keyword not in _SILENT:
            left[f"*{block.keyword[:MAX_LETTERS_OF_VALUE]}"] = None
    if left:
        named = ", ".join([*left][:MAX_NAMED]) + (f" and {len(left) - MAX_NAMED} others" * (len(left) > MAX_NAMED))
        model.notices.append(
            f"Only nodes, elements, sets and surfaces are read; not {named}: give materials, supports, loads and "
            "contacts in the case."
        )
    if not model.nodes:
        raise InputError(f"{path} without *NODE", "an Abaqus input file with nodes and elements", "export the mesh")
    return _drawn(model)


def _take(model: _Model, block: _Block) -> None:
    if block.keyword in _GENERATING:
        raise InputError(block.place, "a file that lists its nodes and elements", "export the mesh as plain lists")
    for name in block.parameters:
        if name not in _READ[block.keyword]:
            raise InputError(
                f"{block.place} with the parameter {short(name)}",
                f"the parameters {', '.join(_READ[block.keyword])}",
                "export the mesh as plain lists, without it",
            )
    if block.keyword == "NODE":
        _take_nodes(model, block)
    elif block.keyword == "ELEMENT":
        _take_elements(model, block)
    elif block.keyword in ("NSET", "ELSET"):
        sets = model.node_sets if block.keyword == "NSET" else model.element_sets
        name = block.parameters.get(block.keyword, "")
        members = _members(sets, block)
        if block.keyword == "NSET" and "ELSET" in block.parameters:
            elements = _members(model.element_sets, replace(block, rows=[(block.parameters["ELSET"],)]))
            of_element = model.cells | model.lines
            members = [node for element in elements for node in of_element.get(element, ())]
        sets[name] += members
    elif block.keyword == "SURFACE":
        _take_surface(model, block)
    else:
        model.n_instances += 1
        if model.n_instances > 1 or block.rows:
            raise InputError(
                f"{block.place}, {'a second one' if model.n_instances > 1 else 'which is moved'}",
                "one part, or one instance at its own place",
                "export each part by itself, and place and join the meshes afterwards",
            )


def _take_nodes(model: _Model, block: _Block) -> None:
    if block.parameters.get("SYSTEM", "R").upper() != "R":
        raise InputError(f"{block.place} in another system", "rectangular coordinates", "export them as such")
    for row in block.rows:
        try:
            (number,) = _numbers(block, row[:1])
            coordinates = [parsed_number(word.upper().replace("D", "E")) for word in row[1:4]]
        except ValueError as reason:
            raise InputError(
                f"{block.place_of(row)}: {', '.join(row)}", "a number and coordinates", "repair it"
            ) from reason
        if len(coordinates) < 2:
            raise InputError(
                f"{block.place_of(row)}: node {number} with {len(coordinates)} coordinates", "2 or 3", "repair it"
            )
        if number in model.nodes:
            raise InputError(
                f"{block.place_of(row)}: node {number} for the second time",
                "one part, with each number once",
                "export each part by itself",
            )
        model.nodes[number] = [*coordinates, 0.0][:3]
        if "NSET" in block.parameters:
            model.node_sets[block.parameters["NSET"]].append(number)


def _take_elements(model: _Model, block: _Block) -> None:
    kind = block.parameters.get("TYPE", "").upper()
    plane = _PLANE.match(kind)
    if plane is None and kind not in _LINES:
        raise InputError(
            f"{block.place} of type {kind or 'unknown'}",
            f"plane elements such as CPE3, CPS4, CAX6, and lines {', '.join(_LINES)}",
            "export the plane elements only",
        )
    n_nodes = {"65": 6}.get(plane[1], int(plane[1])) if plane else _LINES[kind]
    n_corners = (3 if n_nodes in (3, 6) else 4) if plane else 2
    flat = [number for row in block.rows for number in _numbers(block, row)]
    if len(flat) % (n_nodes + 1):
        raise InputError(
            f"{block.place} of type {kind} with {len(flat)} numbers",
            f"{n_nodes + 1} for each element: its own and {n_nodes} nodes",
            "repair the lines",
        )
    if plane:
        model.sides.append(second_order_sides(np.reshape(flat, (-1, n_nodes + 1))[:, 1:], n_corners))
    for start in range(0, len(flat), n_nodes + 1):
        number, nodes = flat[start], flat[start + 1 : start + 1 + n_nodes]
        corners = nodes[:n_corners] if plane else nodes[:: n_nodes - 1]  # a line's middle is its second node
        model.middles += [node for node in nodes if node not in corners]
        if number in model.cells or number in model.lines:
            raise InputError(f"{block.place}: element {number} for the second time", "each number once", "repair it")
        (model.cells if plane else model.lines)[number] = corners
        if "ELSET" in block.parameters:
            model.element_sets[block.parameters["ELSET"]].append(number)


def _members(sets: dict[str, list[int]], block: _Block) -> list[int]:
    """Numbers of a set: given one by one, as ranges, or by the names of other sets."""
    members: list[int] = []
    for row in block.rows:
        further: list[Sequence[int]] = []
        if "GENERATE" in block.parameters:
            limits = _numbers(block, row)
            if len(limits) not in (2, 3) or limits[-1] < 1:
                raise InputError(f"{block.place}: {', '.join(row)}", "first, last and step", "repair the line")
            further.append(range(limits[0], limits[1] + 1, limits[2] if len(limits) == 3 else 1))
        else:
            for word in row:
                name = word.strip('"').rpartition(".")[2]
                if WHOLE.fullmatch(word):
                    further.append(_numbers(block, [word]))
                elif name in sets:
                    further.append(sets[name])
                else:
                    raise InputError(
                        f"{block.place} with the set {short(word)}",
                        "whole numbers, and sets defined before",
                        "correct it",
                    )
        for numbers in further:
            # before a range is expanded; its length is a machine's integer, since its ends have 18 digits at most
            if len(members) + len(numbers) > MAX_MEMBERS:
                raise InputError(f"{block.place} of more than {MAX_MEMBERS} numbers", "a set of the mesh", "correct it")
            members += numbers
    return members


def _take_surface(model: _Model, block: _Block) -> None:
    name = block.parameters.get("NAME", "")
    kind = block.parameters.get("TYPE", "ELEMENT").upper()
    if kind == "NODE":
        for row in block.rows:
            word = row[0].rpartition(".")[2]
            model.node_sets[name] += [int(word)] if WHOLE.fullmatch(word) else model.node_sets.get(word, [])
    elif kind == "ELEMENT":
        model.surfaces[name] += [
            (row[0].rpartition(".")[2], row[1].upper() if len(row) > 1 else "") for row in block.rows
        ]
    else:
        model.notices.append(f"Surface '{name}' of type {kind} left out.")


def _faces(model: _Model, where: str, face: str) -> list[list[int]]:
    """Edges of the elements of a set, or of one element: a numbered face of each, or all that no other of them has."""
    members = [int(where)] if where.isdigit() else model.element_sets.get(where, [])
    cells = [model.cells[number] for number in members if number in model.cells]
    if face in ("S1", "S2", "S3", "S4"):
        first = int(face[1]) - 1
        return [[cell[first], cell[(first + 1) % len(cell)]] for cell in cells if first < len(cell)]
    count: dict[tuple[int, int], list[int]] = {}
    for cell in cells:
        for a, b in sides_of(cell):
            count.setdefault((min(a, b), max(a, b)), []).append(a)
    return [list(pair) for pair, elements in count.items() if len(elements) == 1]


def _drawn(model: _Model) -> DrawnMesh:
    row_of_node = {number: row for row, number in enumerate(model.nodes)}
    for number, corners in (model.cells | model.lines).items():
        missing = [node for node in corners if node not in row_of_node]
        if missing:
            raise InputError(
                f"element {number} with node {missing[0]}, which is missing",
                "nodes that the file lists under *NODE",
                "add the node, or correct the element",
            )
    sides = np.concatenate(model.sides).tolist()
    row_of = {number: row for row, number in enumerate(model.cells)}
    cell_sets, surfaces = {}, {}
    for kind, sets, known in (
        ("Element", model.element_sets, row_of.keys() | model.lines.keys()),
        ("Node", model.node_sets, row_of_node.keys()),
    ):
        for name, members in sets.items():
            if n_unknown := sum(number not in known for number in members):
                model.notices.append(
                    f"{kind} set '{name}': {n_unknown} of {len(members)} numbers are not in the file; left out."
                )
    for name, members in model.element_sets.items():
        rows = [row_of[number] for number in members if number in row_of]
        pairs = [model.lines[number] for number in members if number in model.lines]
        if rows:
            cell_sets[name] = np.array(rows)
        if pairs:
            surfaces[name] = pairs
    for name, entries in model.surfaces.items():
        pairs = [pair for where, face in entries for pair in _faces(model, where, face)]
        if pairs:
            surfaces[name] = pairs
        else:
            model.notices.append(f"Surface '{name}': no edge of a plane element is in it; left out.")
    return DrawnMesh(
        np.array(list(model.nodes.values())),
        [np.array([row_of_node[node] for node in corners]) for corners in model.cells.values()],
        cell_sets,
        {name: np.array([[row_of_node[a], row_of_node[b]] for a, b in pairs]) for name, pairs in surfaces.items()},
        {
            name: np.array([row_of_node[node] for node in members if node in row_of_node], dtype=np.int64)
            for name, members in model.node_sets.items()
        },
        tuple(model.notices),
        np.array([row_of_node[node] for node in model.middles if node in row_of_node], dtype=np.int64),
        np.array([[row_of_node[n] for n in side] for side in sides if side[2] in row_of_node], np.int64).reshape(-1, 3),
    )


def _numbers(block: _Block, row: Sequence[str]) -> list[int]:
    """Whole numbers of a row; 1.0 is one, as spreadsheets write it."""
    if not all(map(WHOLE.fullmatch, row)):
        raise InputError(f"{block.place}: {short(', '.join(row))}", "whole numbers", "repair the line")
    return [int(word.partition(".")[0]) for word in row]
