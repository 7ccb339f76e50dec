"""Meshes read from the files of other programs, and VTU files with real polygons, for ParaView."""

import base64
import contextlib
import io
import re
import zlib
from collections import defaultdict
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any
from xml.sax.saxutils import quoteattr

import numpy as np
from numpy.typing import ArrayLike, NDArray

from flangeway.errors import InputError, located, short
from flangeway.formats.abaqus_files import read_abaqus
from flangeway.formats.mesh_repair import DrawnMesh, MeshFile, repaired_mesh, second_order_sides
from flangeway.mesh.connectivity import entries_of, next_in_row
from flangeway.mesh.curved import PIECES, as_polylines
from flangeway.mesh.polyhedral_mesh import ELEMENT_FACES, PolyhedralMesh
from flangeway.mesh.polymesh import PolyMesh
from flangeway.system.file_content import is_file
from flangeway.system.memory_limits import memory_limited, refuse_beyond_memory
from flangeway.types import Indices, Ints

_CORNERS = {
    **dict.fromkeys(("line", *(f"line{n}" for n in range(3, 12)), "VTK_LAGRANGE_CURVE"), 2),
    **dict.fromkeys(("triangle", "VTK_LAGRANGE_TRIANGLE"), 3),
    **{f"triangle{n}": 3 for n in (6, 7, 10, 15, 21, 28, 36, 45, 55, 66)},
    **dict.fromkeys(("quad", "VTK_LAGRANGE_QUADRILATERAL"), 4),
    **{f"quad{n}": 4 for n in (8, 9, 16, 25, 36, 49, 64, 81, 100, 121)},
}
"""Number of corners, which come first, of meshio's plane cells and lines."""
_SOLID_FACES = dict(zip(("tetra", "pyramid", "wedge", "hexahedron"), ELEMENT_FACES.values(), strict=True))
"""Faces of meshio's solid cells."""
_VTK_TYPES = {"line": 3, "triangle": 5, "polygon": 7, "hexahedron": 12}
MEMORY_PER_BYTE, MEMORY_OF_LIBRARY = 20, 1_000_000_000
"""Bytes of memory for each byte of a file, and besides; what is packed may be larger than it says."""
OWN_ARRAYS = ("cell_number", "body_id")  # of `write_vtu`, which are no sets
GROUPS = ("gmsh:physical", "medit:ref")
"""Numbers of groups of cells, which may have names."""
CELL_SET, EDGE_SET = "cell_set:", "edge_set:"
"""Before the names of sets in VTU files."""
_BLOCK_BYTES = 1 << 15
"""Bytes of a VTU file that are compressed at once."""


def read_mesh(path: str | Path, *, merge_points: bool = True) -> MeshFile:
    """Read a plane mesh of triangles, quadrilaterals or polygons.

    - Gmsh (``.msh``, versions 2.2, 4.0 and 4.1): physical surfaces become cell sets, physical curves edge sets, by
      their names or, where they have none, their numbers.
    - Abaqus (``.inp``): element sets become cell sets, surfaces and node sets edge sets.
    - What meshio reads by the file's ending, such as Medit, VTU with polygons, VTK, XDMF, MED, Nastran. Cells with the
      same number in an array of integers become a cell set, or lines an edge set: ``"3"`` of Medit's references,
      ``"material_3"`` of an array ``material``. Of `write_vtu`, cells get their numbers back, and sets their names.

    Cells of second or higher order are read as the polygons of their corners. Sides of second order whose middle is
    beside the chord become arcs through both ends and it, see `EdgeCurves`; elements of order 2 have the nodes of the
    file then. Clockwise cells are turned, cells given
    twice and unused points left out, points at one place made one, points that hang on an edge added to its cell; each
    with a notice. Edge sets hold boundary edges.

    Parameters
    ----------
    path
        The file.
    merge_points
        Whether points at the same place become one. With False a crack, or bodies that touch, stay apart, and bodies
        without a common point may overlap.

    Returns
    -------
    MeshFile
        The mesh, ``.mesh``, and the notices, ``.notices``.

    Raises
    ------
    InputError
        If the file is missing, empty, of an unknown kind, broken, not plane, or has cells of other kinds; or if
        cells overlap, see `check`. The message names the place.
    """
    file = Path(path)
    with _opened(file):
        drawn = read_abaqus(file) if file.suffix.lower() == ".inp" else _drawn(*_read_meshio(file))
        return repaired_mesh(drawn, merge_points=merge_points)


@contextlib.contextmanager
def _opened(file: Path) -> Iterator[None]:
    """Refuse a file that is missing, empty or larger than memory; errors about it name it."""
    if not is_file(file):
        raise InputError(f"mesh {file}: there is no such file", "a file that exists", "correct the path")
    size = file.stat().st_size
    if not size:
        raise InputError(f"{file}, which is empty", "a mesh", "export it again")
    refuse_beyond_memory(f"reading {file}", MEMORY_PER_BYTE * size)
    try:
        with located(f"{file}: ", unless=str(file)):
            yield
    except OSError as reason:
        raise InputError(
            f"{file}: {reason.strerror or reason}", "a file that can be read", "check its permissions"
        ) from reason


def read_polyhedra(path: str | Path) -> PolyhedralMesh:
    """Read a mesh of tetrahedra, pyramids, prisms, hexahedra or polyhedra.

    What meshio reads by the file's ending, such as Gmsh, Abaqus, VTU with polyhedra (type 42), Medit, Nastran. Sets of
    cells have the names that `read_mesh` gives them; triangles and quadrilaterals on the boundary make face sets, lines
    are left out. Of cells of second order the corners are read. Faces that are not plane are divided into triangles.

    Raises
    ------
    InputError
        If the file is missing, empty, of an unknown kind or broken, or has no such cells.
    """
    file = Path(path)
    with _opened(file):
        read, names, _ = _read_meshio(file)
        cells: list[list[Ints]] = []
        cell_sets: defaultdict[str, list[Ints]] = defaultdict(list)
        rings: defaultdict[str, list[Ints]] = defaultdict(list)
        for block, table in enumerate(read.cells):
            n_corners = _CORNERS.get(table.type)
            for name, members in _sets_of(read, block, names, 2 if n_corners else 3).items():
                if not n_corners:
                    cell_sets[name].append(len(cells) + members)
                elif n_corners > 2:
                    rings[name] += list(table.data[members][:, :n_corners])
            if table.type.startswith("polyhedron"):
                cells += [list(map(np.asarray, cell)) for cell in table.data]
            elif faces := _SOLID_FACES.get(table.type.rstrip("0123456789")):
                cells += [[row[list(face)] for face in faces] for row in table.data]
        if not cells:
            raise InputError("no solid cells", "tetrahedra, pyramids, prisms, hexahedra, polyhedra", "take read_mesh")
        sets = {name: np.concatenate(parts) for name, parts in cell_sets.items()}
        mesh = PolyhedralMesh.from_cells(read.points, cells, cell_sets=sets).with_rings(rings)
        used = np.unique(mesh.face_points)
        mesh = replace(
            mesh, points=mesh.points[used], face_points=np.searchsorted(used, mesh.face_points).astype(np.int32)
        )
        return mesh.with_plane_faces()


def _read_meshio(file: Path) -> tuple[Any, dict[tuple[int, int], str], tuple[str, ...]]:
    """What meshio reads, the names of groups by dimension and number, and notices."""
    import meshio  # noqa: PLC0415  (slow to import, and few programs read files)

    size, suffix = file.stat().st_size, "".join(file.suffixes[-2:]).lower()
    known = meshio.extension_to_filetypes
    suffix = suffix if suffix in known else file.suffix.lower()
    if suffix not in known:
        raise InputError(f"{file} with the ending '{suffix}'", ", ".join(sorted(known)), "export another format")
    with file.open("rb") as stream:
        start = stream.read(20)
    kind = "gmsh" if suffix == ".msh" and start.startswith(b"$MeshFormat") else known[suffix][0]
    gmsh_readers = meshio.gmsh.main._readers
    gmsh_readers["4"] = gmsh_readers["4.0"]  # as Gmsh writes it, and the library does not
    if kind in ("gmsh", "medit"):
        count = re.search(rb"^[ \t]*\d{%d,}[ \t]*\r?$" % (1 + len(str(size))), file.read_bytes(), re.MULTILINE)
        if count is not None:  # the library would wait for so many lines
            raise InputError(f"{file} with a count of {short(count[0].decode())}", f"{size} bytes or less", "repair it")
    printed_text = io.StringIO()

    def printed() -> str:
        return " ".join(printed_text.getvalue().split())

    try:
        # meshio prints faults on the console and ends the program on some
        with (
            contextlib.redirect_stdout(printed_text),
            contextlib.redirect_stderr(printed_text),
            np.errstate(all="ignore"),
            memory_limited(MEMORY_OF_LIBRARY + MEMORY_PER_BYTE * size),
        ):
            read = meshio.read(file, file_format=kind)
    except (Exception, SystemExit) as reason:  # of any kind in a broken file
        missing = reason.name if isinstance(reason, ModuleNotFoundError) else None
        raise InputError(
            f"{file}, which cannot be read as {kind}, perhaps because it is cut off: "
            f"{printed() or f'{type(reason).__name__}: {reason}'}",
            "a whole file of this format",
            f"install {missing}, or export another format" if missing else "export it again",
        ) from reason
    if "cannot handle" in printed():
        raise InputError(f"{file}: {printed()}", "triangles, quadrilaterals and polygons", "export these only")
    groups = [(name, np.ravel(value)) for name, value in read.field_data.items()]  # number and dimension of each
    names = {(int(group[1]), int(group[0])): name for name, group in groups if len(group) == 2}
    names = _physical_names(file) if kind == "gmsh" else names
    return read, names, (f"Said when reading: {printed()}",) if printed() else ()


def _physical_names(file: Path) -> dict[tuple[int, int], str]:
    """Names of Gmsh's physical groups by dimension and number; meshio mixes up equal ones of two dimensions."""
    section = re.search(rb"\$PhysicalNames\s(.*?)\$EndPhysicalNames", file.read_bytes(), re.DOTALL)
    rows = re.findall(r'^\s*(\d)\s+(\d+)\s+"(.*)"', section[1].decode("utf-8", "replace"), re.M) if section else []
    return {(int(dimension), int(number)): name for dimension, number, name in rows}


def _drawn(read: Any, names: dict[tuple[int, int], str], notices: tuple[str, ...]) -> DrawnMesh:
    cells: list[Ints] = []
    middles: list[Ints] = [np.zeros(0, dtype=np.int64)]
    sides: list[Ints] = [np.zeros((0, 3), dtype=np.int64)]
    cell_sets: defaultdict[str, list[Ints]] = defaultdict(list)
    edge_sets: defaultdict[str, list[Ints]] = defaultdict(list)
    numbers: list[Ints] = []
    for block, given in enumerate(read.cells):
        if given.type == "vertex" or not len(given.data):
            continue
        rows = np.asarray(given.data) if not given.type.startswith("polyhedron") else np.zeros((0, 0))
        n_corners = _CORNERS.get(given.type, rows.shape[1] if given.type == "polygon" else 0)
        if not n_corners or rows.shape[1] < n_corners:
            raise InputError(
                f"{len(given.data)} cells of the kind {given.type}",
                "triangles, quadrilaterals and polygons in the plane",
                "export the plane cells only",
            )
        if rows.min() < 0 or rows.max() >= len(read.points):
            raise InputError("a cell with a point that is missing", f"points 0 to {len(read.points) - 1}", "repair it")
        corners = rows[:, :n_corners].astype(np.int64)
        middles.append(rows[:, n_corners:].ravel().astype(np.int64))
        sides.append(second_order_sides(rows.astype(np.int64), n_corners))
        sets = _sets_of(read, block, names, 1 if n_corners == 2 else 2)
        for name, members in sets.items():
            if n_corners == 2:
                edge_sets[name].append(corners[members])
            else:
                cell_sets[name].append(len(cells) + members)
        if n_corners > 2:
            cells += list(corners)
            if "cell_number" in read.cell_data:
                numbers.append(np.asarray(read.cell_data["cell_number"][block]))
    drawn_sets = {name: np.concatenate(parts) for name, parts in cell_sets.items()}
    if numbers and np.array_equal(np.sort(np.concatenate(numbers)), np.arange(len(cells))):
        order = np.concatenate(numbers).astype(np.int64)
        cells = [cells[row] for row in np.argsort(order)]
        drawn_sets = {name: order[members] for name, members in drawn_sets.items()}
    for name, pairs in read.field_data.items():
        if name.startswith(EDGE_SET):
            edge_sets[name.removeprefix(EDGE_SET)].append(np.reshape(pairs, (-1, 2)).astype(np.int64))
    point_sets = {str(name): np.asarray(members, dtype=np.int64) for name, members in read.point_sets.items()}
    return DrawnMesh(
        read.points,
        cells,
        drawn_sets,
        {name: np.concatenate(parts) for name, parts in edge_sets.items()},
        point_sets,
        notices,
        np.concatenate(middles),
        np.concatenate(sides),
    )


def _sets_of(read: Any, block: int, names: dict[tuple[int, int], str], dimension: int) -> dict[str, Ints]:
    """Members of the named sets, of groups, and of the cells with the same number, in a block of cells.

    Groups are those of Gmsh and the references of Medit; other numbers have the name of their array before them.
    """
    sets: dict[str, Ints] = {}
    for name, parts in read.cell_sets.items():
        members = np.asarray(parts[block] if parts[block] is not None else [], dtype=np.int64)
        if len(members) and not name.startswith("gmsh:"):
            sets[str(name)] = members
    for array, values in read.cell_data.items():
        numbers = np.asarray(values[block])
        numbers = numbers[:, 0] if numbers.ndim == 2 and numbers.shape[1] == 1 else numbers
        if numbers.ndim != 1 or numbers.dtype.kind not in "iu" or array in (*OWN_ARRAYS, "gmsh:geometrical"):
            continue
        is_set = array.startswith(CELL_SET)
        for number in np.unique(numbers[numbers > 0] if is_set or array == "gmsh:physical" else numbers).tolist():
            name = array.removeprefix(CELL_SET) if is_set else f"{array}_{number}"
            name = names.get((dimension, number), str(number)) if array in GROUPS else name
            members = np.flatnonzero(numbers == number)
            sets[name] = np.union1d(sets[name], members) if name in sets else members
    return sets


def write_vtu(
    path: str | Path,
    mesh: PolyMesh,
    point_data: Mapping[str, ArrayLike] | None = None,
    cell_data: Mapping[str, ArrayLike] | None = None,
    corner_data: Mapping[str, ArrayLike] | None = None,
    positions: ArrayLike | None = None,
    *,
    body_id: int = 0,
) -> None:
    """Write a mesh with values at points and cells, binary and compressed.

    Triangles are written as such (VTK type 5), all other cells as polygons (type 7). Cells are grouped by their number
    of points; cell sets are cell arrays of 0 and 1, ``cell_set:NAME``, edge sets are field data, ``edge_set:NAME``, and
    `read_mesh` reads both. The cell array ``cell_number`` is the number in `mesh`, or that which `cell_data` has under
    this name, such as the number of the element of which a cell is a piece. Vectors of two components get a third one,
    zero; symmetric tensors have six: xx, yy, zz, xy, yz, xz, as ParaView names them.

    A curved edge is written as a polyline of 16 pieces with values between those of its ends: the file shows the
    curves, but a mesh that is read from it has straight edges.

    Parameters
    ----------
    path
        File to write; its ending is ``.vtu``.
    mesh
        The mesh.
    point_data
        Arrays (n_points,) or (n_points, n_components) by name.
    cell_data
        Arrays (n_cells,) or (n_cells, n_components) by name.
    corner_data
        Arrays with a row for each entry of ``mesh.cell_points`` by name, for fields that jump between cells. With any,
        each cell gets its own points, in the order of ``mesh.cell_points``.
    positions
        Points in space (n_points, 3) instead of those of the mesh with z = 0; edges between them are straight.
    body_id
        Number of the body, written as the cell array ``body_id``.

    Raises
    ------
    InputError
        If the ending is another one, an array has another length, or a name is given twice.
    """
    at_points = _checked(point_data or {}, mesh.n_points, "points")
    at_cells = _at_cells(cell_data or {}, mesh.n_cells, "cells", body_id)
    at_corners = _checked(corner_data or {}, len(mesh.cell_points), "corners of the cells")
    points = mesh.points if positions is None else positions
    space = _checked({"positions": points}, mesh.n_points, "points")["positions"]
    if at_points.keys() & at_corners.keys():
        raise InputError(f"'{min(at_points.keys() & at_corners.keys())}' at points and corners", "one", "rename one")
    if mesh.curves is not None and positions is None:
        at_points, at_corners = (
            {name: _between(mesh, array, at_entries=arrays is at_corners) for name, array in arrays.items()}
            for arrays in (at_points, at_corners)
        )
        mesh = as_polylines(mesh)
        space = np.column_stack((mesh.points, np.zeros(mesh.n_points)))
    edge_sets: Mapping[str, Indices] = mesh.edge_sets
    cells = np.arange(mesh.n_cells)
    masks = {CELL_SET + name: np.isin(cells, members).astype(np.uint8) for name, members in mesh.cell_sets.items()}
    if at_corners:
        at_points = {name: array[mesh.cell_points] for name, array in at_points.items()} | at_corners
        space = space[mesh.cell_points]
        edge_sets = {name: mesh.rim_entries[mesh.boundary_rows(pairs, name)] for name, pairs in edge_sets.items()}
        mesh = mesh.apart()
    batches = mesh.batches()
    blocks = [("triangle" if n == 3 else "polygon", mesh.batch_points(n, cells)) for n, cells in batches]
    order = np.concatenate([cells for _, cells in batches])
    ordered = {name: array[order] for name, array in (at_cells | masks).items()}
    whole = {EDGE_SET + name: pairs.astype(np.int32) for name, pairs in edge_sets.items()}
    _write_blocks(path, space, blocks, at_points, ordered, whole)


def write_vtu_polyhedra(
    path: str | Path,
    mesh: PolyhedralMesh,
    point_data: Mapping[str, ArrayLike] | None = None,
    cell_data: Mapping[str, ArrayLike] | None = None,
) -> None:
    """Write a mesh of polyhedra (VTK type 42) with values at points and cells; see `write_vtu`.

    Cell sets are cell arrays of 0 and 1, ``cell_set:NAME``, which `read_polyhedra` reads.
    """
    order = np.argsort(mesh.cell_sizes, kind="stable")  # as programs group them that read the file
    masks = {CELL_SET + name: np.isin(order, members).astype(np.uint8) for name, members in mesh.cell_sets.items()}
    at_cells = {name: array[order] for name, array in _at_cells(cell_data or {}, mesh.n_cells, "cells", 0).items()}
    loops = [mesh.loop(face).tolist() for face in range(mesh.n_faces)]
    # of each cell the number of its faces, then each face as the number of its points and these
    streams = [
        [len(row), *(entry for face in row for entry in (len(loops[face]), *loops[face]))]
        for row in (mesh.side_faces[slice(*mesh.side_offsets[cell : cell + 2])] for cell in order)
    ]
    cells: dict[str, NDArray[Any]] = {
        "connectivity": mesh.cell_points[entries_of(mesh.cell_offsets, order)[0]],
        "offsets": np.cumsum(mesh.cell_sizes[order]),
        "types": np.full(mesh.n_cells, 42, dtype=np.uint8),
        "faces": np.concatenate(streams),
        "faceoffsets": np.cumsum(list(map(len, streams))),
    }
    _write_blocks(path, mesh.points, [], point_data or {}, at_cells | masks, cells=cells)


def _between(mesh: PolyMesh, values: NDArray[Any], *, at_entries: bool) -> NDArray[Any]:
    """Values at the points of a mesh, or at its corners, with those between them on curved edges as polylines."""
    assert mesh.curves is not None
    share = np.arange(1, PIECES) / PIECES
    if at_entries:
        after = np.flatnonzero(mesh.curve_rows[mesh.cell_edges] >= 0).astype(np.int64)
        ends = np.column_stack((after, next_in_row(mesh.cell_offsets)[after]))
    else:
        after, ends = np.full(len(mesh.curves.pairs), len(values) - 1), mesh.curves.pairs.astype(np.int64)
    start, end = (values[column][:, None] for column in ends.T)
    share = share.reshape(1, -1, *[1] * (values.ndim - 1))
    # numbers, such as those of points, are not mixed
    added = start + share * (end - start) if values.dtype.kind == "f" else np.where(share < 0.5, start, end)
    return np.insert(values, np.repeat(after + 1, PIECES - 1), added.reshape(-1, *values.shape[1:]), axis=0)


def write_vtu_lines(
    path: str | Path,
    points: ArrayLike,
    lines: ArrayLike,
    point_data: Mapping[str, ArrayLike],
    *,
    body_id: ArrayLike = 0,
) -> None:
    """Write straight lines (VTK type 3) between points, such as a contact surface; see `write_vtu`.

    Parameters
    ----------
    path
        File to write; its ending is ``.vtu``.
    points
        Shape (n_points, 2) or (n_points, 3).
    lines
        Numbers of the two points of each line, shape (n_lines, 2).
    point_data
        Arrays with a row for each point, by name.
    body_id
        Number of the body of all lines, or of each, shape (n_lines,).

    """
    ends = np.asarray(lines)
    blocks = [("line", ends)] if len(ends) else []
    _write_blocks(path, np.asarray(points), blocks, point_data, _at_cells({}, len(ends), "lines", body_id))


def write_vtu_grids(
    path: str | Path, grids: Sequence[NDArray[Any]], point_data: Mapping[str, Sequence[ArrayLike]], *, body_id: int = 0
) -> None:
    """Write structured grids in space as hexahedra (VTK type 12); see `write_vtu`.

    Parameters
    ----------
    path
        File to write; its ending is ``.vtu``.
    grids
        Points of each grid, shape (k, n, m, 3).
    point_data
        By name an array with the shape (k, n, m) or (k, n, m, n_components) for each grid.
    body_id
        Number of the body of all cells.

    """
    cells, first = [np.zeros((0, 8), dtype=np.int64)], 0
    for points in grids:
        numbers = first + np.arange(points[..., 0].size).reshape(points.shape[:3])
        first += numbers.size
        low, high = numbers[:-1], numbers[1:]
        corners = [
            part for layer in (low, high)
            for part in (layer[:, :-1, :-1], layer[:, 1:, :-1], layer[:, 1:, 1:], layer[:, :-1, 1:])
        ]  # fmt: skip
        cells.append(np.stack(corners, axis=-1).reshape(-1, 8))
    hexahedra = np.concatenate(cells)
    space = np.concatenate([points.reshape(-1, 3) for points in grids])
    arrays = {
        name: np.concatenate([np.reshape(part, (-1, *np.shape(part)[3:])) for part in parts])
        for name, parts in point_data.items()
    }
    at_cells = _at_cells({}, len(hexahedra), "cells", body_id)
    _write_blocks(path, space, [("hexahedron", hexahedra)], arrays, at_cells)


def _at_cells(data: Mapping[str, ArrayLike], n: int, where: str, body_id: ArrayLike) -> dict[str, NDArray[Any]]:
    bodies = np.broadcast_to(np.asarray(body_id, dtype=np.int32), n)
    return _checked({"cell_number": np.arange(n), **data, "body_id": bodies}, n, where)


def _write_blocks(
    path: str | Path,
    points: NDArray[Any],
    blocks: list[tuple[str, NDArray[Any]]],
    point_data: Mapping[str, ArrayLike],
    cell_data: Mapping[str, NDArray[Any]],
    field_data: Mapping[str, NDArray[Any]] | None = None,
    cells: dict[str, NDArray[Any]] | None = None,
) -> None:
    """Write points, blocks of cells of one kind, arrays at points and at cells, in their order, and other arrays.

    - `cells`: arrays of cells that are no such blocks.
    """
    file = Path(path)
    if file.suffix != ".vtu":
        raise InputError(f"path {file}", "a name that ends with .vtu", "rename the file")
    n = len(points)
    parts = {"Points": _checked({"Points": points}, n, "points"), "PointData": _checked(point_data, n, "points")}
    if blocks:
        cells = {
            "connectivity": np.concatenate([cells.ravel() for _, cells in blocks]),
            "offsets": np.cumsum(np.concatenate([np.full(len(cells), cells.shape[1]) for _, cells in blocks])),
            "types": np.concatenate([np.full(len(cells), _VTK_TYPES[kind], dtype=np.uint8) for kind, cells in blocks]),
        }
    if cells:
        parts |= {"Cells": cells, "CellData": dict(cell_data)}
    fields = "".join(_vtu_array(*item) for item in (field_data or {}).items())
    fields = fields and f"<FieldData>{fields}</FieldData>"
    text = "".join(
        f"<{part}>{''.join(_vtu_array(*item) for item in arrays.items())}</{part}>" for part, arrays in parts.items()
    )
    n_cells = len(cells["types"]) if cells else 0
    file.write_text(
        '<?xml version="1.0"?><VTKFile type="UnstructuredGrid" version="0.1" byte_order="LittleEndian" '
        f'compressor="vtkZLibDataCompressor"><UnstructuredGrid>{fields}'
        f'<Piece NumberOfPoints="{n}" NumberOfCells="{n_cells}">{text}</Piece>'
        "</UnstructuredGrid></VTKFile>\n",
        encoding="utf-8",
    )


def _vtu_array(name: str, values: NDArray[Any]) -> str:
    """An array as an element of a VTU file, in blocks that are compressed apart, in base 64.

    Compression at the first level takes a quarter of the time of the default one, for files of the same size.
    """
    kind = {"f": "Float", "i": "Int", "u": "UInt"}[values.dtype.kind]
    data = values.astype(values.dtype.newbyteorder("<"), copy=False).tobytes()
    blocks = [data[start : start + _BLOCK_BYTES] for start in range(0, len(data), _BLOCK_BYTES)]
    compressed = [zlib.compress(block, 1) for block in blocks]
    sizes = [len(blocks), _BLOCK_BYTES, len(blocks[-1]) if blocks else 0, *map(len, compressed)]
    components = f' NumberOfComponents="{values.shape[1]}"' if values.ndim == 2 else ""
    components += f' NumberOfTuples="{len(values)}"'
    content = b"".join(map(base64.b64encode, (np.array(sizes, dtype="<u4").tobytes(), b"".join(compressed)))).decode()
    return (
        f'<DataArray type="{kind}{8 * values.dtype.itemsize}" Name={quoteattr(name)}{components} format="binary">'
        f"{content}</DataArray>"
    )


def _checked(data: Mapping[str, ArrayLike], n_rows: int, where: str) -> dict[str, NDArray[Any]]:
    """Return arrays of the right length, with a third component for plane vectors."""
    arrays = {}
    for name, values in data.items():
        array = np.asarray(values)
        if array.ndim not in (1, 2) or len(array) != n_rows:
            raise InputError(
                f"data '{name}' of shape {array.shape}",
                f"shape ({n_rows},) or ({n_rows}, n_components), one row for each of the {where}",
                "pass one row for each, never transposed",
            )
        if array.ndim == 2 and array.shape[1] == 2:
            array = np.column_stack([array, np.zeros(n_rows, dtype=array.dtype)])
        arrays[name] = array
    return arrays
