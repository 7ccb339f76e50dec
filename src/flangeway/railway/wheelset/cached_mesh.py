"""Meshes of bodies, kept from one process to the next."""

from importlib.metadata import version
from typing import Any

import numpy as np
from numpy.typing import NDArray

from flangeway.geometry import Outline
from flangeway.mesh import PolyMesh, Refinement, dual, triangulate
from flangeway.system.disk_cache import Arrays, Cache, content_key


def meshed(outline: Outline, size: float, refinement: Refinement, *, polygons: bool, cache: Cache | None) -> PolyMesh:
    """Mesh an outline, or take the mesh that was made before of the same outline and sizes by the same mesher.

    Parameters
    ----------
    outline
        The body.
    size, refinement
        See `flangeway.mesh.triangulate`.
    polygons
        Whether the polygons dual to the triangles are wanted.
    cache
        Where meshes are kept; None: nowhere.

    Raises
    ------
    InputError
        As `triangulate`.

    """

    def make() -> PolyMesh:
        mesh = triangulate(outline, size=size, refinements=(refinement,))
        return dual(mesh) if polygons else mesh

    key = content_key(
        "mesh",
        outline.segments,
        outline.names,
        size,
        refinement.points,
        refinement.size,
        refinement.growth,
        polygons,
        version("gmsh"),
    )
    if cache is None or key is None:
        return make()
    found = cache.load(key)
    if found is not None:
        return _unpacked(found)
    mesh = make()
    cache.store(key, _packed(mesh))
    return mesh


def _packed(mesh: PolyMesh) -> Arrays:
    arrays: dict[str, NDArray[Any]] = {
        "points": mesh.points,
        "cell_offsets": mesh.cell_offsets,
        "cell_points": mesh.cell_points,
    }
    for kind, sets in (("cell", mesh.cell_sets), ("edge", mesh.edge_sets)):
        arrays[f"{kind}_names"] = np.array(list(sets), dtype=np.str_)
        arrays |= {f"{kind}_{number}": values for number, values in enumerate(sets.values())}
    return arrays


def _unpacked(arrays: Arrays) -> PolyMesh:
    sets = [
        {str(name): np.asarray(arrays[f"{kind}_{number}"]) for number, name in enumerate(arrays[f"{kind}_names"])}
        for kind in ("cell", "edge")
    ]
    return PolyMesh(arrays["points"], arrays["cell_offsets"], arrays["cell_points"], *sets)
