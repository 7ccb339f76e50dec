"""Files for ParaView: solutions with their orders shown, and series of steps in time."""

from collections.abc import Iterable, Mapping
from dataclasses import dataclass, field
from pathlib import Path
from xml.sax.saxutils import quoteattr

import numpy as np
from numpy.typing import ArrayLike

from flangeway.errors import InputError
from flangeway.formats import write_vtu
from flangeway.mesh import PolyMesh
from flangeway.post import Stresses, corner_stresses
from flangeway.problems import ElasticField
from flangeway.report.figures.display import display, displayed_stresses

STRESS_NAMES = ("xx", "yy", "xy", "zz")


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
    corner_data
        Arrays with a row for each entry of ``mesh.cell_points``, for fields that jump between cells.
    part
        Name of the part.

    """

    time: float
    mesh: PolyMesh
    point_data: Mapping[str, ArrayLike] = field(default_factory=dict)
    cell_data: Mapping[str, ArrayLike] = field(default_factory=dict)
    corner_data: Mapping[str, ArrayLike] = field(default_factory=dict)
    part: str = "body"


def solution_frame(
    solution: ElasticField, time: float = 0.0, *, pieces: int | None = None, averaged: bool = False, part: str = "body"
) -> SeriesFrame:
    """Displacements and stresses of a solution, for `write_frame` and `write_series`.

    Order 1 is shown on the cells themselves. Of higher orders each cell is cut into triangles, its sides into `pieces`,
    with the elements' own fields at their points. Point arrays: ``displacement``; ``stress_xx``, ``_yy``, ``_xy``,
    ``_zz``, ``von_mises``, which jump between cells. The cell array ``cell`` has the cell of each triangle.

    Parameters
    ----------
    time
        Its time.
    pieces
        Number of pieces of each side, by default the order; 1 shows the cells.
    averaged
        Whether stresses are averaged over the cells at each place.
    part
        Name of the part.

    """
    space = solution.problem.space
    pieces = space.order if pieces is None else pieces
    mesh = space.mesh
    if pieces == 1 and not averaged:
        moved = {"displacement": solution.displacements[: mesh.n_points]}
        stresses = corner_stresses(solution.problem, solution.displacements)
        return SeriesFrame(time, mesh, moved, {"cell": np.arange(mesh.n_cells)}, _stress_arrays(stresses), part)
    shown = display(space, pieces)
    stresses = displayed_stresses(solution, shown)
    if averaged:
        stresses = Stresses(shown.averaged(stresses.components))
    offsets = np.arange(len(shown.triangles) + 1, dtype=np.int32) * 3
    triangles = PolyMesh(shown.points, offsets, shown.triangles.astype(np.int32).ravel())
    arrays = {"displacement": shown.function(solution.displacements), **_stress_arrays(stresses)}
    return SeriesFrame(time, triangles, arrays, {"cell": shown.cells[shown.triangles[:, 0]]}, part=part)


def _stress_arrays(stresses: Stresses) -> dict[str, ArrayLike]:
    arrays: dict[str, ArrayLike] = {f"stress_{name}": stresses.components[:, i] for i, name in enumerate(STRESS_NAMES)}
    return {**arrays, "von_mises": stresses.von_mises}


def write_frame(path: str | Path, frame: SeriesFrame) -> None:
    """Write one frame as a VTU file, with real polygons; see `write_vtu` for what is refused.

    With values at corners the points are written once for each cell, so that the values may jump.
    """
    write_vtu(path, frame.mesh, frame.point_data, frame.cell_data, frame.corner_data)


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
        write_frame(target, frame)
        written.append(target)
        entries.append((time, frame.part, target.name))
        write_collection(file, entries)
    if not written:
        raise InputError("a series without frames", "one or more", "give the frames")
    return tuple(written)


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
