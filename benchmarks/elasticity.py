"""Plane elasticity of 100,000 cells beside scikit-fem and SciPy: assembly, local matrices, factorisation, memory.

Every sample is a process of its own, so that its peak of resident memory is its own, and the samples of all programs
take turns, so that a busy machine slows all of them; the table gives medians. BLAS has one thread. ``cpu s`` is the
time of all processors, which other work on the machine disturbs less. Times of assembly are from a mesh to the sparse
matrix, numbering and pattern included, after one run that is not counted. scikit-fem runs twice: as it is, with the
quadrature that it chooses by itself, of degree 4, and with that of degree 2, exact here and cheaper; ratios are
given to both. Times of factors hold no assembly.
"""

import json
import os
import subprocess
import sys
import tempfile
import time
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path
from statistics import median
from typing import Any

import numpy as np
import scipy.sparse as sp

from flangeway.elements import Element, Lagrange, Virtual
from flangeway.geometry import square
from flangeway.materials import Elastic
from flangeway.mesh import PolyMesh, dual, triangulate
from flangeway.problems import Elasticity, Traction, fixed
from flangeway.solve.constraints import find_constraints
from flangeway.space import Space, SymmetricMatrix

TRIANGLE_SIZE, POLYGON_SIZE = 0.00512, 0.00363  # 100,000 triangles and 100,000 points in the unit square
COARSER = 16.0  # by which --quick's meshes are
MATERIAL = Elastic(210e3, 0.3)
ROUNDS = {"assembly": 5, "factor": 3, "splu default": 1}

Times = tuple[float, float]
"""Seconds on the clock, and of all processors."""

Result = tuple[Times, dict[str, Any]]
"""Times, and what else is told."""


@dataclass(frozen=True)
class Row:
    """A line of the table, printed as it stands."""

    text: str

    def line(self) -> str:
        """The line."""
        return self.text


def measurements(*, quick: bool = False) -> Iterator[Row]:
    """All parts, on coarse meshes if ``quick``."""
    with tempfile.TemporaryDirectory() as name:
        folder, factor = Path(name), COARSER if quick else 1.0
        triangles = triangulate(square(1.0), size=TRIANGLE_SIZE * factor)
        polygons = dual(triangulate(square(1.0), size=POLYGON_SIZE * factor))
        _save(folder / "triangles.npz", triangles)
        _save(folder / "polygons.npz", polygons)
        yield Row(
            f"{'work':<66} {'median s':>9} {'cpu s':>7} {'asked':>6} {'ratio':>6} {'to deg. 2':>9} "
            f"{'MB peak':>8} {'before':>7}"
        )
        yield from _assembly(folder, triangles.n_cells, polygons.n_cells)
        yield from _factors(folder)


def _assembly(folder: Path, n_triangles: int, n_polygons: int) -> Iterator[Row]:
    peers = {"scikit-fem": "scikit-fem as it is", "scikit-fem 2": "scikit-fem with degree 2"}
    jobs = ("assemble", *peers, "local matrices 1", "local matrices 2")
    taken = _samples(folder, jobs, dict.fromkeys(jobs, ROUNDS["assembly"]))
    triangles = f"stiffness of {n_triangles} triangles of order 2"
    for job, name in peers.items():
        yield _row(f"{triangles}, {name}", taken[job])
    polygons = f"local matrices of {n_polygons} polygons of order"
    for job, work, asked in (
        ("assemble", triangles, 4.0),
        ("local matrices 1", f"{polygons} 1", 10.0),
        ("local matrices 2", f"{polygons} 2", 3.0),
    ):
        ratios = [_seconds(taken[peer]) / _seconds(taken[job]) for peer in peers]
        yield _row(f"{work}, flangeway", taken[job], asked, ratios)
    apart = _sample(folder, "compare assembly")["difference"]
    yield Row(f"  both stiffnesses of the triangles differ by {apart:.1e} of the largest entry")


def _factors(folder: Path) -> Iterator[Row]:
    _sample(folder, "store matrix")
    jobs = ("factor", "splu symmetric", "splu default")
    rounds = dict.fromkeys(jobs, ROUNDS["factor"]) | {"splu default": ROUNDS["splu default"]}
    taken = _samples(folder, jobs, rounds)
    unknowns = f"factor of {taken['factor'][0]['n']} unknowns"
    ours = _seconds(taken["factor"])
    yield _row(f"{unknowns}, flangeway", taken["factor"])
    for job, name, asked in (
        ("splu symmetric", "splu in symmetric mode", 4.0),
        ("splu default", "splu as it is", None),
    ):
        yield _row(f"{unknowns}, {name}", taken[job], asked, [_seconds(taken[job]) / ours])
    found = np.load(folder / "factor.npy")
    for job in jobs[1:]:
        other = np.load(folder / f"{job}.npy")
        apart = np.abs(found - other).max() / np.abs(found).max()
        yield Row(f"  displacements by flangeway and by {job} differ by {apart:.1e} of the largest")
    entries = ", ".join(f"{job} {taken[job][0]['entries']:,}" for job in jobs)
    yield Row(f"  entries of the factors (of L, and of L and U): {entries}")


def _row(work: str, samples: list[dict[str, Any]], asked: float | None = None, ratios: Sequence[float] = ()) -> Row:
    texts = ["" if asked is None else f"{asked:.0f}", *(f"{ratio:.1f}" for ratio in ratios), "", ""]
    peak, before = (max(sample[name] for sample in samples) for name in ("peak_mb", "before_mb"))
    processors = median(sample["processors"] for sample in samples)
    return Row(
        f"{work:<66} {_seconds(samples):>9.3f} {processors:>7.3f} {texts[0]:>6} {texts[1]:>6} {texts[2]:>9} "
        f"{peak:>8.0f} {before:>7.0f}"
    )


def _seconds(samples: list[dict[str, Any]]) -> float:
    return median(sample["seconds"] for sample in samples)


def _samples(folder: Path, jobs: tuple[str, ...], rounds: dict[str, int]) -> dict[str, list[dict[str, Any]]]:
    taken: dict[str, list[dict[str, Any]]] = {job: [] for job in jobs}
    for number in range(max(rounds.values())):
        for job in jobs:
            if number < rounds[job]:
                taken[job].append(_sample(folder, job))
    return taken


def _sample(folder: Path, job: str) -> dict[str, Any]:
    """Run a job in a process of its own."""
    done = subprocess.run(
        [sys.executable, "-m", "benchmarks.elasticity", job, str(folder)],
        env=os.environ | {"OPENBLAS_NUM_THREADS": "1"},
        cwd=Path(__file__).parents[1],
        stdout=subprocess.PIPE,
        text=True,
        check=True,
    )
    sample: dict[str, Any] = json.loads(done.stdout.splitlines()[-1])
    return sample


# in the process of a sample


def _save(path: Path, mesh: PolyMesh) -> None:
    sets = {f"edges {name}": edges for name, edges in mesh.edge_sets.items()}
    np.savez(path, points=mesh.points, offsets=mesh.cell_offsets, cells=mesh.cell_points, **sets)


def _load(path: Path) -> PolyMesh:
    with np.load(path) as stored:
        sets = {name.removeprefix("edges "): stored[name] for name in stored if name.startswith("edges ")}
        return PolyMesh(stored["points"], stored["offsets"], stored["cells"], edge_sets=sets)


def _timed(work: Callable[[], Any]) -> tuple[Times, Any]:
    """Seconds on the clock and of all processors, and the result."""
    start, used = time.perf_counter(), time.process_time()
    result = work()
    return (time.perf_counter() - start, time.process_time() - used), result


def _warm(work: Callable[[], Any]) -> tuple[Times, Any]:
    """Times and result of the second run."""
    work()
    return _timed(work)


def _ours(folder: Path) -> Result:
    triangles = _load(folder / "triangles.npz")
    seconds, matrix = _warm(lambda: _problem(triangles, Lagrange(2)).stiffness())
    return seconds, {"n": matrix.n}


def _theirs(folder: Path, degree: int | None) -> Result:
    import skfem  # noqa: PLC0415

    triangles = _load(folder / "triangles.npz")
    mesh = skfem.MeshTri(
        np.ascontiguousarray(triangles.points.T),
        np.ascontiguousarray(triangles.cell_points.reshape(-1, 3).T.astype(np.int64)),
    )
    seconds, (_, matrix) = _warm(lambda: _by_scikit_fem(mesh, degree))
    return seconds, {"n": matrix.shape[0]}


def _by_scikit_fem(mesh: Any, degree: int | None) -> tuple[Any, Any]:
    import skfem  # noqa: PLC0415
    from skfem.models.elasticity import lame_parameters, linear_elasticity  # noqa: PLC0415

    basis = skfem.Basis(mesh, skfem.ElementVector(skfem.ElementTriP2()), intorder=degree)
    return basis, skfem.asm(linear_elasticity(*lame_parameters(MATERIAL.young, MATERIAL.poisson)), basis)


def _local_matrices(folder: Path, order: int) -> Result:
    polygons = _load(folder / "polygons.npz")
    problem = _problem(polygons, Virtual(order))

    def all_cells() -> int:
        return sum(problem.cell_stiffness(batch).shape[-1] for batch in problem.space.batches())

    seconds, n_cells = _warm(all_cells)
    return seconds, {"n": n_cells}


def _compare(folder: Path) -> Result:
    """Largest difference of both stiffnesses, unknowns matched by place and component."""
    import skfem  # noqa: PLC0415
    from scipy.spatial import cKDTree  # noqa: PLC0415

    mesh = _load(folder / "triangles.npz")
    problem = _problem(mesh, Lagrange(2))
    ours = problem.stiffness().full()
    triangles = np.ascontiguousarray(mesh.cell_points.reshape(-1, 3).T.astype(np.int64))
    basis, theirs = _by_scikit_fem(skfem.MeshTri(np.ascontiguousarray(mesh.points.T), triangles), 2)
    first = np.arange(0, basis.N, 2)
    nodes = cKDTree(problem.space.nodes).query(basis.doflocs[:, first].T)[1]
    ours_of = np.stack((2 * nodes, 2 * nodes + 1), axis=1).ravel()
    apart = sp.csr_array(theirs) - ours[ours_of][:, ours_of]
    return (0.0, 0.0), {"difference": float(np.abs(apart.data).max() / np.abs(ours.data).max())}


def _problem(mesh: PolyMesh, element: Element) -> Elasticity:
    return Elasticity(Space(mesh, element), MATERIAL)


def _store(folder: Path) -> Result:
    """Stiffness of the triangles held on the left, its load on the right, and the nodes of the unknowns."""
    space = Space(_load(folder / "triangles.npz"), Lagrange(2))
    problem = Elasticity(space, MATERIAL, loads=[Traction("right", (1.0, 2.0))], supports=[fixed("left")])
    constraints = find_constraints(problem)
    assert constraints.kept is not None
    matrix = problem.stiffness().restricted(constraints.kept)
    np.savez(
        folder / "matrix.npz",
        indptr=matrix.indptr,
        indices=matrix.indices,
        values=matrix.values,
        groups=constraints.groups,
        load=constraints.transform.T @ problem.load_vector().ravel(),
    )
    return (0.0, 0.0), {"n": matrix.n}


def _factor(folder: Path) -> Result:
    from flangeway._core import Cholesky  # noqa: PLC0415

    with np.load(folder / "matrix.npz") as stored:
        lower, groups, load = (
            [stored[name] for name in ("indptr", "indices", "values")],
            stored["groups"],
            stored["load"],
        )
    seconds, factor = _timed(lambda: Cholesky(*lower, groups, np.empty(0, dtype=np.int32)))
    np.save(folder / "factor.npy", factor.solve(load))
    return seconds, {"n": factor.n, "entries": factor.factor_nonzeros}


def _splu(folder: Path, *, symmetric: bool) -> Result:
    from scipy.sparse.linalg import splu  # noqa: PLC0415

    with np.load(folder / "matrix.npz") as stored:
        n, load = len(stored["load"]), stored["load"]
        matrix = sp.csc_array(SymmetricMatrix(n, stored["indptr"], stored["indices"], stored["values"]).full())
    options: dict[str, Any] = {}
    if symmetric:
        options = {"permc_spec": "MMD_AT_PLUS_A", "diag_pivot_thresh": 0.0, "options": {"SymmetricMode": True}}
    seconds, factor = _timed(lambda: splu(matrix, **options))
    np.save(folder / f"splu {'symmetric' if symmetric else 'default'}.npy", factor.solve(load))
    return seconds, {"n": n, "entries": int(factor.nnz)}


JOBS: dict[str, Callable[[Path], Result]] = {
    "assemble": _ours,
    "scikit-fem": lambda folder: _theirs(folder, None),
    "scikit-fem 2": lambda folder: _theirs(folder, 2),
    "local matrices 1": lambda folder: _local_matrices(folder, 1),
    "local matrices 2": lambda folder: _local_matrices(folder, 2),
    "compare assembly": _compare,
    "store matrix": _store,
    "factor": _factor,
    "splu symmetric": lambda folder: _splu(folder, symmetric=True),
    "splu default": lambda folder: _splu(folder, symmetric=False),
}


def _resident_mb(what: str) -> float:
    """Resident memory now (``VmRSS``) or at its peak (``VmHWM``), never that of the parent as by getrusage."""
    status = Path("/proc/self/status")
    if not status.exists():
        return float("nan")
    found = next(line for line in status.read_text(encoding="utf-8").splitlines() if line.startswith(what))
    return float(found.split()[1]) / 1024.0


def _run(job: str, folder: Path) -> None:
    before = _resident_mb("VmRSS")
    (seconds, processors), told = JOBS[job](folder)
    print(
        json.dumps(
            {
                "seconds": seconds,
                "processors": processors,
                "before_mb": before,
                "peak_mb": _resident_mb("VmHWM"),
                **told,
            }
        )
    )


if __name__ == "__main__":
    _run(sys.argv[1], Path(sys.argv[2]))
