"""Assembly of the scalar stiffness (Laplace) of 10,000 polygons and 20,000 triangles beside other programs.

Our time is from a mesh to the assembled sparse matrix, numbering and pattern included. Accuracy is the relative error
of the energy of u = x, which is the area. The programs take turns; each run is the best of several.
"""

import tempfile
from collections.abc import Iterator
from pathlib import Path
from typing import Any

from benchmarks.measurement import Measurement, best_time, fastest_in_turns, taken
from benchmarks.peers import PeerMissingError, run_python
from benchmarks.samples import save_mesh
from flangeway.elements import Element, Lagrange, Virtual
from flangeway.geometry import square
from flangeway.mesh import PolyMesh, dual, triangulate
from flangeway.problems import Torsion
from flangeway.space import Space, SymmetricMatrix, interpolate

SIZE = 0.01163  # of the triangles: the unit square then has 9,978 points, one polygon each
QUICK_SIZE = 0.1
ORDERS = (1, 2, 3)
ROUNDS = 3


def measurements(size: float = SIZE) -> Iterator[Measurement]:
    """Polygons against pypolydim, triangles against scikit-fem."""
    triangles = triangulate(square(1.0, (0.5, 0.5)), size=size)
    polygons = dual(triangles)
    with tempfile.TemporaryDirectory() as name:
        for mesh, file in ((triangles, "triangles.npz"), (polygons, "polygons.npz")):
            save_mesh(Path(name) / file, mesh)
        for order in ORDERS:
            yield _against_pypolydim(polygons, Path(name) / "polygons.npz", order)
        for order in ORDERS:
            yield _against_skfem(triangles, Path(name) / "triangles.npz", order)


def quick() -> Iterator[Measurement]:
    """A coarse mesh."""
    yield from measurements(QUICK_SIZE)


def _ours(mesh: PolyMesh, element: Element) -> dict[str, Any]:
    def assemble() -> SymmetricMatrix:
        return Torsion(Space(mesh, element)).stiffness()

    seconds, matrix = best_time(assemble)
    u = interpolate(Space(mesh, element), lambda points: points[:, 0])
    return {"seconds": seconds, "energy": float(u @ (matrix.full() @ u))}


def _against_pypolydim(mesh: PolyMesh, path: Path, order: int) -> Measurement:
    work = f"scalar stiffness of {mesh.n_cells} polygons, virtual elements of order {order}"
    found = fastest_in_turns(
        {
            "ours": lambda: _ours(mesh, Virtual(order)),
            "pypolydim": lambda: run_python("pypolydim", "pypolydim_laplace.py", str(path), str(order)),
        },
        {"ours": ROUNDS, "pypolydim": ROUNDS},
        lambda run: run["seconds"],
    )
    note = "vem_pcc to triplets; its geometry, numbering and conversion to a sparse matrix are not in its time"
    return _measurement(work, "pypolydim", found, note, 10.0)


def _against_skfem(mesh: PolyMesh, path: Path, order: int) -> Measurement:
    work = f"scalar stiffness of {mesh.n_cells} triangles, Lagrange elements of order {order}"
    found = fastest_in_turns(
        {
            "ours": lambda: _ours(mesh, Lagrange(order)),
            "scikit-fem": lambda: run_python("scikit-fem", "scikit_fem.py", "laplace", str(path), str(order)),
        },
        {"ours": ROUNDS, "scikit-fem": ROUNDS},
        lambda run: run["seconds"],
    )
    return _measurement(work, "scikit-fem", found, "from a mesh to a compressed sparse matrix", None)


def _measurement(work: str, name: str, found: dict[str, Any], note: str, asked: float | None) -> Measurement:
    ours, peer = taken(found["ours"]), found[name]
    if isinstance(peer, PeerMissingError):
        return Measurement(work, name, ours["seconds"], None, abs(ours["energy"] - 1.0), None, str(peer), asked=asked)
    our_error, peer_error = (abs(run["energy"] - 1.0) for run in (ours, peer))
    return Measurement(
        work, name, ours["seconds"], peer["seconds"], our_error, peer_error, note, peer["version"], asked
    )
