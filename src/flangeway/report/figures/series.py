"""Files for ParaView: solutions with their orders shown, and series of steps in time."""

from collections.abc import Iterable, Mapping
from dataclasses import dataclass, field
from pathlib import Path
from xml.sax.saxutils import quoteattr

import numpy as np
from numpy.typing import ArrayLike

from flangeway.contact import ContactState, ContactSystem
from flangeway.errors import InputError
from flangeway.formats import write_vtu, write_vtu_lines
from flangeway.geometry import Placement
from flangeway.mesh import PolyMesh
from flangeway.post import Stresses, contact_lines
from flangeway.problems import ElasticField
from flangeway.report.figures.display import shown_cells
from flangeway.system.output_folder import Writer
from flangeway.types import Floats


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
    place, shown = placement or Placement(), shown_cells(solution.space, pieces)
    moved, stresses = shown.values(solution)
    arrays = field_arrays(place.vectors(moved), placed_stresses(stresses, place), unit, length_unit)
    return SeriesFrame(time, shown.mesh.placed(place), arrays, {"cell_number": shown.cells}, part)


def field_arrays(
    displacement: Floats, stresses: Stresses, unit: str | None = "MPa", length_unit: str | None = "mm"
) -> dict[str, ArrayLike]:
    """Arrays at points by their names in all files, each with its unit if there is one.

    ``displacement_mm``; ``stress_MPa``: the tensor's xx, yy, zz, xy, yz, xz, tension positive; ``von_mises_MPa``.
    """
    ending, length = (f"_{each}" if each else "" for each in (unit, length_unit))
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
    found = contact_lines(system, state)
    parts = [line.contact.secondary.part for line in found]
    nodes = zip(parts, found, strict=True)
    points = np.vstack([starts[part.name].points(part.body.space.nodes[line.nodes]) for part, line in nodes])
    first = np.cumsum([0, *(len(line.nodes) for line in found)])
    numbers = [list(starts).index(part.name) for part in parts]
    arrays = {
        "pressure_MPa": np.concatenate([line.pressures for line in found]),
        "gap_mm": np.concatenate([line.gaps for line in found]),
        "displacement_mm": np.vstack([line.positions for line in found]) - points,
    }
    if state.friction is not None:
        arrays["traction_MPa"] = np.concatenate([line.tractions for line in found])
        arrays["slip_mm"] = np.concatenate([line.slips for line in found])
    lines = np.vstack([line.lines + start for line, start in zip(found, first[:-1], strict=True)])
    write_vtu_lines(path, points, lines, arrays, body_id=np.repeat(numbers, [len(line.lines) for line in found]))


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
