"""Solutions cut into small triangles for display, and their files for ParaView."""

from collections.abc import Iterable, Mapping
from dataclasses import dataclass, field
from functools import cached_property
from pathlib import Path
from typing import TypeAlias
from xml.sax.saxutils import quoteattr

import numpy as np
from numpy.typing import ArrayLike, NDArray
from scipy.interpolate import BarycentricInterpolator

from flangeway.contact import ContactState, ContactSystem
from flangeway.elements.quadrature import gauss_lobatto
from flangeway.errors import InputError
from flangeway.formats import write_vtu, write_vtu_lines
from flangeway.geometry import Placement
from flangeway.mesh import PolyMesh
from flangeway.mesh.cutting import cell_centres, kernel_centre, star_parts
from flangeway.post import Stresses, contact_lines, corner_stresses
from flangeway.post.stress import polynomials_at, stress_polynomials, value_polynomials
from flangeway.problems import ElasticField
from flangeway.space import Space
from flangeway.system.output_folder import Writer
from flangeway.types import Floats, Ints

# --- Cells cut into small triangles for display, with the elements' own reconstruction evaluated at their points.


_Fans: TypeAlias = tuple[Floats, Ints, Ints, Ints, Ints]

NO_EDGE = -1


@dataclass(frozen=True, eq=False)
class Display:
    """Small triangles that fill the cells; the points of each cell are its own, so that fields may jump between cells.

    Each cell is divided into triangles between a centre that sees it whole and its sides (a cell without such a centre
    first into parts that have one), and each of these into `pieces` squared.
    """

    space: Space  # whose cells are shown
    pieces: int  # number of pieces of each side
    points: Floats  # shape (n, 2)
    cells: Ints  # cell of each point, shape (n,)
    triangles: Ints  # counter-clockwise triangles of points (m, 3)
    edge: Ints  # edge of the mesh on which a point lies, `NO_EDGE` for points inside, shape (n,)
    step: Ints  # place on that edge, from 0 at its lower point to `pieces`, shape (n,)

    @property
    def mesh(self) -> PolyMesh:
        """The mesh whose cells are shown."""
        return self.space.mesh

    @cached_property
    def places(self) -> Ints:
        """Number of the place of each point, the same for points of several cells there, shape (n,)."""
        mesh = self.mesh
        numbers = mesh.n_points + mesh.n_edges * (self.pieces - 1) + np.arange(len(self.points))
        on_edge = self.edge != NO_EDGE
        inner = on_edge & (self.step > 0) & (self.step < self.pieces)
        numbers[inner] = mesh.n_points + self.edge[inner] * (self.pieces - 1) + self.step[inner] - 1
        for end, step in enumerate((0, self.pieces)):
            of_step = on_edge & (self.step == step)
            numbers[of_step] = mesh.edges[self.edge[of_step], end]
        return numbers

    def function(self, dofs: Floats) -> Floats:
        """Values (n, m) of a continuous function with unknowns (n_dofs, m): on edges its own, inside the projection."""
        values = polynomials_at(self.space, self.points, self.cells, value_polynomials(dofs), dofs.shape[1])
        on_edge = np.flatnonzero(self.edge != NO_EDGE)
        nodes = self.space.edge_nodes(self.mesh.edges[self.edge[on_edge]])
        weights = edge_weights(self.space.order, self.pieces)[self.step[on_edge]]
        values[on_edge] = np.einsum("pn,pni->pi", weights, dofs[nodes])
        return values


def edge_weights(order: int, pieces: int) -> Floats:
    """Weights of an edge's nodes at its equal pieces' ends, (pieces + 1, order + 1): Lagrange's polynomials."""
    lagrange = BarycentricInterpolator(gauss_lobatto(order + 1)[0], np.eye(order + 1))
    return np.asarray(lagrange(np.arange(pieces + 1) / pieces))


def display(space: Space, pieces: int | None = None) -> Display:
    """Cut the elements of a space into small triangles, each side into `pieces`.

    By default these are the order, on meshes with curved edges twice the order.
    """
    if pieces is None:
        pieces = space.order if space.mesh.curves is None else 2 * space.order
    if pieces < 1:
        raise InputError(f"pieces={pieces}", "1 or more", "leave it out for the order of the elements")
    mesh = space.mesh
    parts = []
    for n_vertices, cells in mesh.batches():
        centres, seen = cell_centres(mesh, cells)
        entries = mesh.batch_places(n_vertices, cells)
        if seen.any():
            parts.append(
                _fans(space, pieces, cells[seen], entries[seen], centres[seen], mesh.cell_edges[entries[seen]])
            )
        for row in np.flatnonzero(~seen).tolist():
            parts += _star_fans(space, pieces, int(cells[row]), entries[row])
    starts = np.cumsum([0, *(len(part[0]) for part in parts[:-1])])
    triangles = np.concatenate([part[2] + start for part, start in zip(parts, starts, strict=True)])
    points = np.concatenate([part[0] for part in parts])
    owner, edge, step = (np.concatenate([part[i] for part in parts]) for i in (1, 3, 4))
    return Display(space, pieces, points, owner, triangles, edge, step)


def _star_fans(space: Space, pieces: int, cell: int, entries: Ints) -> list[_Fans]:
    fans, mesh = [], space.mesh
    for part in star_parts(np.arange(len(entries), dtype=np.int32), mesh.points[mesh.cell_points[entries]]):
        whole = (np.roll(part, -1) - part) % len(entries) == 1  # a side of the cell, not a diagonal
        edges = np.where(whole, mesh.cell_edges[entries[part]], NO_EDGE)
        centre = kernel_centre(mesh.points[mesh.cell_points[entries[part]]])[0]
        fans.append(_fans(space, pieces, np.array([cell]), entries[part][None], centre[None], edges[None]))
    return fans


def _fans(
    space: Space, pieces: int, cells: NDArray[np.integer], entries: Ints, centres: Floats, edges: NDArray[np.integer]
) -> _Fans:
    """What makes a `Display`, from its points on, of star-shaped polygons (n_cells, n_vertices) of one size.

    The points of a cell lie on rings about its centre, ring j with j points to each side; the last ring is the rim.
    """
    mesh, (n_cells, n) = space.mesh, entries.shape
    corners = mesh.points[mesh.cell_points[entries]]
    along = np.roll(corners, -1, axis=1) - corners
    bent = (edges != NO_EDGE) & (mesh.curve_rows[edges] >= 0) & (space.order > 1)
    numbers = mesh.cell_points[entries]
    nodes = space.nodes[space.edge_nodes(np.stack((numbers, np.roll(numbers, -1, axis=1)), axis=-1)[bent])]
    layers = [centres[:, None]]
    for j in range(1, pieces + 1):
        on_rim = corners[:, :, None] + (np.arange(j) / j)[:, None] * along[:, :, None]
        on_rim[bent] = np.einsum("tn,eni->eti", edge_weights(space.order, j)[:-1], nodes)
        ring = centres[:, None, None] + (j / pieces) * (on_rim - centres[:, None, None])
        layers.append((on_rim if j == pieces else ring).reshape(n_cells, -1, 2))
    points = np.concatenate(layers, axis=1)
    n_each = points.shape[1]
    local = _ring_triangles(n, pieces)
    triangles = (np.arange(n_cells)[:, None, None] * n_each + local).reshape(-1, 3)
    forward = mesh.cell_points[entries] < np.roll(mesh.cell_points[entries], -1, axis=1)
    t = np.arange(pieces)
    steps = np.where(forward[..., None], t, pieces - t)
    edge = np.full((n_cells, n_each), NO_EDGE, dtype=np.int64)
    step = np.zeros((n_cells, n_each), dtype=np.int64)
    edge[:, n_each - n * pieces :] = np.repeat(edges, pieces, axis=1)
    step[:, n_each - n * pieces :] = steps.reshape(n_cells, -1)
    # a corner between a diagonal and a side belongs to the side
    for corner in np.flatnonzero((edges == NO_EDGE).any(axis=0) & (np.roll(edges, 1, axis=1) != NO_EDGE).any(axis=0)):
        start = n_each - n * pieces + corner * pieces
        edge[:, start] = edges[:, corner - 1]
        step[:, start] = np.where(forward[:, corner - 1], pieces, 0)
    return (
        points.reshape(-1, 2),
        np.repeat(cells.astype(np.int64), n_each),
        triangles,
        edge.ravel(),
        step.ravel(),
    )


def _ring_triangles(n: int, pieces: int) -> Ints:
    """Triangles (n pieces^2, 3) between the rings about a centre, counter-clockwise."""

    def number(j: int, side: int, t: int) -> int:
        return 0 if j == 0 else 1 + n * j * (j - 1) // 2 + (side * j + t) % (n * j)

    rows = []
    for side in range(n):
        for j in range(1, pieces + 1):
            rows += [[number(j - 1, side, t), number(j, side, t), number(j, side, t + 1)] for t in range(j)]
            rows += [[number(j - 1, side, t), number(j, side, t + 1), number(j - 1, side, t + 1)] for t in range(j - 1)]
    return np.array(rows, dtype=np.int64)


def displayed_stresses(solution: ElasticField, shown: Display) -> Stresses:
    """Stresses at the points of a display, each from its own cell."""
    return Stresses(polynomials_at(shown.space, shown.points, shown.cells, stress_polynomials(solution), 4))


@dataclass(frozen=True, eq=False)
class ShownCells:
    """Cells for files and the page, each with points of its own: as they are, or cut into triangles."""

    mesh: PolyMesh  # what is shown
    cells: Ints  # cell of the space that each shown cell is a piece of
    places: Ints  # number of each point's place, the same for the points of several cells there, shape (n_points,)
    n_rim_places: int  # places below this number are on the rims of the cells of the space, the others inside
    space: Space
    display: Display | None  # how the cells were cut, None where they are shown as they are

    def values(self, field: ElasticField) -> tuple[Floats, Stresses]:
        """Displacements (n_points, 2) and stresses at the points, in the axes of the field, each from its own cell."""
        if self.display is not None:
            return self.display.function(field.displacements), displayed_stresses(field, self.display)
        corners = self.space.mesh.cell_points
        return field.displacements[corners], corner_stresses(field.problem, field.displacements)


def shown_cells(space: Space, pieces: int | None = None) -> ShownCells:
    """Cut the cells' sides into some pieces, see `display`; with one piece the cells are shown as they are."""
    mesh = space.mesh
    if pieces == 1 or (pieces is None and space.order == 1):
        used, numbers_of_points = np.unique(mesh.cell_points, return_inverse=True)
        return ShownCells(mesh.apart(), np.arange(mesh.n_cells), numbers_of_points, len(used), space, None)
    shown = display(space, pieces)
    numbers, numbers_of_points = np.unique(shown.places, return_inverse=True)
    n_rim = int(np.searchsorted(numbers, mesh.n_points + mesh.n_edges * (shown.pieces - 1)))
    cut = PolyMesh.from_cells(shown.points, shown.triangles)
    return ShownCells(cut, shown.cells[shown.triangles[:, 0]], numbers_of_points, n_rim, space, shown)


# --- Files for ParaView: solutions with their orders shown, and series of steps in time.


@dataclass(frozen=True, eq=False)
class SeriesFrame:
    """What is shown at one time: a mesh with values; several frames of one time are parts of one picture.

    Parameters
    ----------
    time
        Time, or the number of a load step.
    mesh
        The mesh.
    point_data
        Arrays (n_points,) or (n_points, n_components) by name.
    cell_data
        Arrays (n_cells,) or (n_cells, n_components) by name.
    part
        Name of the part.

    """

    time: float
    mesh: PolyMesh
    point_data: Mapping[str, ArrayLike] = field(default_factory=dict)
    cell_data: Mapping[str, ArrayLike] = field(default_factory=dict)
    part: str = "body"


def solution_frame(
    solution: ElasticField,
    time: float = 0.0,
    *,
    pieces: int | None = None,
    part: str = "body",
    unit: str | None = None,
    length_unit: str | None = None,
    placement: Placement | None = None,
) -> SeriesFrame:
    """Displacements and stresses of a solution, for `write_frame` and `write_series`.

    Order 1 is shown on the cells themselves, each with points of its own. Of higher orders each cell is cut into
    triangles, its sides into `pieces`, with the elements' own fields at their points. Arrays: see `field_arrays`; the
    stresses jump between cells. The cell array ``cell_number`` has the element of each cell.

    Parameters
    ----------
    time
        Its time.
    pieces
        Number of pieces of each side, by default the order, twice it with curved edges; 1 shows the cells.
    part
        Name of the part.
    unit, length_unit
        Units of stresses and lengths, for the names of the arrays.
    placement
        Where the body is shown; displacements and stresses are in the axes of that space.

    """
    placed, shown = placement or Placement(), shown_cells(solution.space, pieces)
    moved, stresses = shown.values(solution)
    arrays = field_arrays(placed.vectors(moved), placed_stresses(stresses, placed), unit, length_unit)
    return SeriesFrame(time, shown.mesh.placed(placed), arrays, {"cell_number": shown.cells}, part)


def field_arrays(
    displacement: Floats, stresses: Stresses, unit: str | None = "MPa", length_unit: str | None = "mm"
) -> dict[str, ArrayLike]:
    """Arrays at points by their names in all files, each with its unit if there is one.

    ``displacement_mm``; ``stress_MPa``: the tensor's xx, yy, zz, xy, yz, xz, tension positive; ``von_mises_MPa``.
    """
    ending, length = (f"_{word}" if word else "" for word in (unit, length_unit))
    return {
        f"displacement{length}": displacement,
        f"stress{ending}": stresses.tensors,
        f"von_mises{ending}": stresses.von_mises,
    }


def placed_stresses(stresses: Stresses, placement: Placement) -> Stresses:
    """Stresses of a body's frame in the axes of space, ``Q s Q^T`` with the placement's Q."""
    xx, yy, xy, zz = stresses.components.T
    turn = placement.matrix
    plane = np.array([[xx, xy], [xy, yy]])
    moved = np.einsum("ik,kln,jl->ijn", turn, plane, turn)
    return Stresses(np.stack((moved[0, 0], moved[1, 1], moved[0, 1], zz), axis=1))


def write_frame(path: str | Path, frame: SeriesFrame, body_id: int = 0) -> None:
    """Write one frame as a VTU file, with real polygons; see `write_vtu` for what is refused."""
    write_vtu(path, frame.mesh, frame.point_data, frame.cell_data, body_id=body_id)


def write_contacts(path: Path, system: ContactSystem, state: ContactState, starts: Mapping[str, Placement]) -> None:
    """Write pressure and gap at the nodes of all secondary surfaces, as lines, with their displacement.

    Point arrays: ``pressure_MPa``, 0 where the contact is open; ``gap_mm``, not-a-number where the primary surface is
    out of reach; ``displacement_mm`` from where the bodies are drawn; with friction ``traction_MPa`` and ``slip_mm`` of
    the last step, on the secondary surface along the primary's edges, whose body is on their left. Cell array
    ``body_id``: number of the body.

    - `starts`: where the bodies are drawn, by their names in the order of their numbers.
    """
    lines_of_contacts = contact_lines(system, state)
    parts = [line.contact.secondary.part for line in lines_of_contacts]
    nodes = zip(parts, lines_of_contacts, strict=True)
    points = np.vstack([starts[part.name].points(part.body.space.nodes[line.nodes]) for part, line in nodes])
    first = np.cumsum([0, *(len(line.nodes) for line in lines_of_contacts)])
    numbers = [list(starts).index(part.name) for part in parts]
    arrays = {
        "pressure_MPa": np.concatenate([line.pressures for line in lines_of_contacts]),
        "gap_mm": np.concatenate([line.gaps for line in lines_of_contacts]),
        "displacement_mm": np.vstack([line.positions for line in lines_of_contacts]) - points,
    }
    if state.friction is not None:
        arrays["traction_MPa"] = np.concatenate([line.tractions for line in lines_of_contacts])
        arrays["slip_mm"] = np.concatenate([line.slips for line in lines_of_contacts])
    lines = np.vstack([line.lines + start for line, start in zip(lines_of_contacts, first[:-1], strict=True)])
    write_vtu_lines(
        path, points, lines, arrays, body_id=np.repeat(numbers, [len(line.lines) for line in lines_of_contacts])
    )


def write_series(path: str | Path, frames: Iterable[SeriesFrame]) -> tuple[Path, ...]:
    """Write one VTU file per frame beside a PVD file that opens them as a series in time.

    The frames may be made one after the other while the computation runs: after each of them the PVD is whole.

    Parameters
    ----------
    path
        The PVD file. The others are named after it: ``name_0000.vtu``, ``name_0001.vtu``, ...
    frames
        In order of time.

    Returns
    -------
    tuple of Path
        The VTU files.

    Raises
    ------
    InputError
        If the ending is another one, times fall, a part comes twice at one time, or there is no frame.

    """
    file = Path(path)
    if file.suffix != ".pvd":
        raise InputError(f"path {file}", "a name that ends with .pvd", "rename the file")
    entries: list[tuple[float, str, str]] = []
    written: list[Path] = []
    seen: set[str] = set()
    bodies: dict[str, int] = {}
    time = -np.inf
    for frame in frames:
        if not np.isfinite(frame.time) or frame.time < time or (frame.time == time and frame.part in seen):
            raise InputError(
                f"a frame of the part '{frame.part}' at the time {frame.time:g} after {time:g}",
                "finite times that do not fall, each part once at each time",
                "sort the frames, and name the parts",
            )
        seen = seen | {frame.part} if frame.time == time else {frame.part}
        time = frame.time
        target = file.with_name(f"{file.stem}_{len(written):04d}.vtu")
        write_frame(target, frame, bodies.setdefault(frame.part, len(bodies)))
        written.append(target)
        entries.append((time, frame.part, target.name))
        write_collection(file, entries)
    if not written:
        raise InputError("a series without frames", "one or more", "give the frames")
    return tuple(written)


def collection(files: Iterable[str]) -> Writer:
    """What writes a PVD file that opens the VTU files among files together, each a part of its name."""
    entries = [(0.0, Path(file).stem, file) for file in files if file.endswith(".vtu")]
    return lambda path: write_collection(path, entries)


def write_collection(path: str | Path, entries: Iterable[tuple[float, str, str]]) -> None:
    """Write a PVD file that opens VTU files of its folder together; `write_series` writes both.

    - `entries`: time, name of the part and name of the file, for each VTU file.
    """
    file = Path(path)
    numbers: dict[str, int] = {}
    rows = [
        f"    <DataSet timestep='{time:.17g}' group='' part='{numbers.setdefault(part, len(numbers))}' "
        f"name={quoteattr(part)} file={quoteattr(name)}/>"
        for time, part, name in entries
    ]
    lines = [
        "<?xml version='1.0'?>",
        "<VTKFile type='Collection' version='0.1' byte_order='LittleEndian'>",
        "  <Collection>",
        *rows,
        "  </Collection>",
        "</VTKFile>",
    ]
    # the old file stays whole until the new one is
    new = file.with_suffix(".pvd.part")
    new.write_text("\n".join(lines) + "\n", encoding="utf-8")
    new.replace(file)
