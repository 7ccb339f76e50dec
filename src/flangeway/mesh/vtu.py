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
) -> None:
    """Write a mesh with values at points and cells, binary and compressed.

    Triangles are written as such (VTK type 5), all other cells as polygons (type 7). Cells are
    grouped by their number of points; the cell array ``cell_number`` tells the number in `mesh`.
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

    Raises
    ------
    InputError
        If the ending is another one, an array has another length, or a name is ``cell_number``.

    """
    import meshio  # noqa: PLC0415  (slow to import, and few programs write files)

    file = Path(path)
    if file.suffix != ".vtu":
        raise InputError(f"path {file}", "a name that ends with .vtu", "rename the file")
    at_points = _checked(point_data or {}, mesh.n_points, "points")
    at_cells = _checked(cell_data or {}, mesh.n_cells, "cells")
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
