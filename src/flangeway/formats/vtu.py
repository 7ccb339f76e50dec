"""VTU files with real polygons, for ParaView."""

from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from flangeway.errors import InputError
from flangeway.mesh.polymesh import PolyMesh


def write_vtu(
    path: str | Path,
    mesh: PolyMesh,
    point_data: Mapping[str, ArrayLike] | None = None,
    cell_data: Mapping[str, ArrayLike] | None = None,
    corner_data: Mapping[str, ArrayLike] | None = None,
) -> None:
    """Write a mesh with values at points and cells, binary and compressed.

    Triangles are written as such (VTK type 5), all other cells as polygons (type 7). Cells are
    grouped by their number of points; the cell array ``cell_number`` is the number in `mesh`.
    Vectors and displacements of two components get a third one, zero, as ParaView wants.

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

    Raises
    ------
    InputError
        If the ending is another one, an array has another length, a name is given twice or is ``cell_number``.

    """
    import meshio  # noqa: PLC0415  (slow to import, and few programs write files)

    file = Path(path)
    if file.suffix != ".vtu":
        raise InputError(f"path {file}", "a name that ends with .vtu", "rename the file")
    at_points = _checked(point_data or {}, mesh.n_points, "points")
    at_cells = _checked(cell_data or {}, mesh.n_cells, "cells")
    at_corners = _checked(corner_data or {}, len(mesh.cell_points), "corners of the cells")
    if at_points.keys() & at_corners.keys():
        raise InputError(f"'{min(at_points.keys() & at_corners.keys())}' at points and corners", "one", "rename one")
    if at_corners:
        at_points = {name: array[mesh.cell_points] for name, array in at_points.items()} | at_corners
        mesh = PolyMesh(
            mesh.points[mesh.cell_points], mesh.cell_offsets, np.arange(len(mesh.cell_points), dtype=np.int32)
        )
    if "cell_number" in at_cells:
        raise InputError("cell data named 'cell_number'", "other names", "rename the array")
    batches = mesh.batches()
    blocks = [("triangle" if n == 3 else "polygon", mesh.batch_points(n, cells)) for n, cells in batches]
    values: dict[str, list[NDArray[Any]]] = {
        name: [array[cells] for _, cells in batches] for name, array in at_cells.items()
    }
    values["cell_number"] = [cells for _, cells in batches]
    flat = np.column_stack([mesh.points, np.zeros(mesh.n_points)])
    meshio.Mesh(flat, blocks, point_data=at_points, cell_data=values).write(file, file_format="vtu", binary=True)


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
