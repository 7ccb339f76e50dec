"""Plane elasticity of 100,000 cells beside scikit-fem, SciPy and CHOLMOD: assembly, local matrices, factors.

Every sample is a process of its own, so that its peak of resident memory is its own, and the samples of all programs
take turns, so that a busy machine slows all of them; the fastest counts. BLAS has one thread in flangeway; CHOLMOD is
tried with one and with all. Times of assembly are from a mesh to the sparse matrix, numbering and pattern included,
after one run that is not counted. scikit-fem runs with the quadrature that it chooses by itself, of degree 4, and with
that of degree 2, exact here and cheaper. Times of factors hold the ordering, the factor and one solution, no assembly.

Accuracy of a stiffness is the relative error of the energy of the displacement ``ux = x``, of a solution the largest
residual over that of the product of all absolute values.
"""

import json
import sys
import tempfile
from collections.abc import Callable, Iterator
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np
import scipy.sparse as sp

from benchmarks.measurement import ITSELF, Measurement, fastest, fastest_in_turns, taken, timed
from benchmarks.peers import PeerMissingError, run_python, threads_tried
from benchmarks.samples import load_mesh, resident_mb, sample, save_mesh
from flangeway.elements import Element, Lagrange, Virtual
from flangeway.geometry import square
from flangeway.materials import Elastic
from flangeway.mesh import PolyMesh, check, dual, triangulate
from flangeway.problems import Elasticity, Traction, fixed
from flangeway.solve.constraints import find_constraints
from flangeway.space import Space, SymmetricMatrix

TRIANGLE_SIZE, POLYGON_SIZE = 0.00512, 0.00363  # 100,000 triangles and 100,000 points in the unit square
COARSER = 16.0  # by which the quick meshes are
MATERIAL = Elastic(210e3, 0.3)
ROUNDS = 5
FACTOR_ROUNDS = {"factor": 3, "splu symmetric": 2, "splu default": 1}

Run = dict[str, Any]
"""What a sample tells: seconds, memory and accuracy at least."""


def measurements(*, coarser: float = 1.0, rounds: int = ROUNDS) -> Iterator[Measurement]:
    """All parts, on meshes that many times coarser, each sample so many times at most."""
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        save_mesh(folder / "triangles.npz", triangulate(square(1.0), size=TRIANGLE_SIZE * coarser))
        save_mesh(folder / "polygons.npz", dual(triangulate(square(1.0), size=POLYGON_SIZE * coarser)))
        yield from _assembly(folder, rounds)
        yield from _factors(folder, rounds)
        yield from _checks(folder)


def quick() -> Iterator[Measurement]:
    """Coarse meshes, and each sample once."""
    yield from measurements(coarser=COARSER, rounds=1)


def _assembly(folder: Path, rounds: int) -> Iterator[Measurement]:
    jobs: dict[str, Callable[[], Run]] = {
        job: partial(_sample, job, folder) for job in ("assemble", "local matrices 1", "local matrices 2")
    }
    for degree in (0, 2):
        jobs[f"degree {degree}"] = partial(_scikit_fem, folder, degree)
    found = fastest_in_turns(jobs, dict.fromkeys(jobs, rounds), _seconds)
    for job, work, asked in (
        ("assemble", "stiffness of {n} triangles of order 2", 4.0),
        ("local matrices 1", "local matrices of {n} polygons of order 1", 10.0),
        ("local matrices 2", "local matrices of {n} polygons of order 2", 3.0),
    ):
        for degree, name in ((0, "its own quadrature"), (2, "quadrature of degree 2")):
            note = f"scikit-fem assembles the triangles' stiffness, with {name}"
            ours = taken(found[job])
            yield _measurement(work.format(n=ours["cells"]), "scikit-fem", ours, found[f"degree {degree}"], note, asked)
    peer = found["degree 2"]
    if not isinstance(peer, PeerMissingError):
        _scikit_fem(folder, 2, store=True)
        apart = _sample("compare assembly", folder)["difference"]
        yield Measurement(
            "maximum difference of both stiffnesses of the triangles over the largest entry", "scikit-fem",
            taken(found["assemble"])["seconds"], peer["seconds"], apart, apart, "quadrature of degree 2",
            peer["version"],
        )  # fmt: skip


def _factors(folder: Path, most_rounds: int) -> Iterator[Measurement]:
    _sample("store matrix", folder)
    jobs: dict[str, Callable[[], Run]] = {job: partial(_sample, job, folder) for job in FACTOR_ROUNDS}
    for threads in threads_tried():
        jobs[f"cholmod {threads}"] = partial(_cholmod, folder, threads)
    rounds = FACTOR_ROUNDS | {job: FACTOR_ROUNDS["factor"] for job in jobs if job.startswith("cholmod")}
    found = fastest_in_turns(jobs, {job: min(n, most_rounds) for job, n in rounds.items()}, _seconds)
    ours = taken(found["factor"])
    work = f"factor and solution of {ours['n']} unknowns"
    for job, name, asked in (("splu symmetric", "in symmetric mode", 4.0), ("splu default", "as it is", None)):
        yield _measurement(work, "scipy", ours, found[job], f"SuperLU {name}", asked)
    best = fastest([found[job] for job in jobs if job.startswith("cholmod")], _seconds)
    yield _measurement(work, "cvxopt", ours, best, "CHOLMOD, supernodal, as in CVXOPT's wheel", 1.0)


def _checks(folder: Path) -> Iterator[Measurement]:
    for name in ("triangles", "polygons"):
        ours = _sample(f"check {name}", folder)
        yield Measurement(
            f"check of a mesh of {ours['cells']} {name} beside the assembly of order 1", ITSELF, ours["seconds"],
            ours["assembly"], None, None, "both on a mesh with numbered edges", asked=20.0,
        )  # fmt: skip


def _measurement(
    work: str, name: str, ours: Run, peer: Run | PeerMissingError, note: str, asked: float | None
) -> Measurement:
    more: dict[str, Any] = {"ours_peak_mb": round(ours["peak_mb"])}
    if isinstance(peer, PeerMissingError):
        return Measurement(work, name, ours["seconds"], None, ours["accuracy"], None, str(peer), None, asked, more)
    more["peer_peak_mb"] = round(peer["peak_mb"])
    return Measurement(
        work, name, ours["seconds"], peer["seconds"], ours["accuracy"], peer["accuracy"], note, peer.get("version"),
        asked, more,
    )  # fmt: skip


def _seconds(run: Run) -> float:
    return float(run["seconds"])


def _sample(job: str, folder: Path) -> Run:
    return sample("benchmarks.elasticity", job, str(folder))


def _scikit_fem(folder: Path, degree: int, *, store: bool = False) -> Run:
    out = [str(folder / "scikit-fem.npz")] if store else []
    young, poisson = str(MATERIAL.young), str(MATERIAL.poisson)
    run = run_python(
        "scikit-fem", "scikit_fem.py", "elasticity", str(folder / "triangles.npz"), str(degree), young, poisson, *out
    )
    return run | {"accuracy": _energy_error(run["energy"])}


def _cholmod(folder: Path, threads: int) -> Run:
    matrix, out = folder / "matrix.npz", folder / "cholmod.npy"
    run = run_python("cvxopt", "cvxopt_cholmod.py", str(matrix), str(out), threads=threads)
    return run | {"accuracy": _backward_error(matrix, np.load(out))}


def _energy_error(energy: float) -> float:
    """Relative error of the energy of ``ux = x`` in the unit square."""
    return abs(energy / float(MATERIAL.matrix[0, 0]) - 1.0)


def _backward_error(path: Path, solution: Any) -> float:
    """Maximum residual over the product of absolute values."""
    with np.load(path) as stored:
        n, load = len(stored["load"]), stored["load"]
        full = SymmetricMatrix(n, stored["indptr"], stored["indices"], stored["values"]).full()
    apart = np.abs(full @ solution - load)
    return float(apart.max() / (abs(full) @ np.abs(solution)).max())


# in the process of a sample


def _ours(folder: Path) -> Run:
    triangles = load_mesh(folder / "triangles.npz")
    _problem(triangles, Lagrange(2)).stiffness()
    seconds, matrix = timed(lambda: _problem(triangles, Lagrange(2)).stiffness())
    peak = resident_mb()
    space = Space(triangles, Lagrange(2))
    u = np.zeros(matrix.n)
    u[0::2] = space.nodes[:, 0]
    accuracy = _energy_error(float(u @ (matrix.full() @ u)))
    return {"seconds": seconds, "cells": triangles.n_cells, "accuracy": accuracy, "peak_mb": peak}


def _local_matrices(folder: Path, order: int) -> Run:
    polygons = load_mesh(folder / "polygons.npz")
    problem = _problem(polygons, Virtual(order))

    def all_cells() -> int:
        return sum(problem.cell_stiffness(batch).shape[-1] for batch in problem.space.batches())

    all_cells()
    seconds, n_cells = timed(all_cells)
    return {"seconds": seconds, "cells": n_cells, "accuracy": None, "peak_mb": resident_mb()}


def _check(folder: Path, name: str, element: Element) -> Run:
    stored = load_mesh(folder / f"{name}.npz")
    checks, assemblies = [], []
    for _ in range(ROUNDS):
        mesh = PolyMesh(stored.points, stored.cell_offsets, stored.cell_points)  # not known to be sound
        _ = mesh.n_edges
        checks.append(timed(partial(check, mesh))[0])
        assemblies.append(timed(_problem(mesh, element).stiffness)[0])
    return {"seconds": min(checks), "assembly": min(assemblies), "cells": stored.n_cells}


def _compare(folder: Path) -> Run:
    """Maximum difference of both stiffnesses, unknowns matched by place and component."""
    from scipy.spatial import cKDTree  # noqa: PLC0415

    problem = _problem(load_mesh(folder / "triangles.npz"), Lagrange(2))
    ours = problem.stiffness().full()
    with np.load(folder / "scikit-fem.npz") as stored:
        places = stored["places"]
        theirs = sp.csr_array((stored["values"], stored["indices"], stored["indptr"]), shape=(ours.shape))
    nodes = cKDTree(problem.space.nodes).query(places[:, 0::2].T)[1]
    ours_of = np.stack((2 * nodes, 2 * nodes + 1), axis=1).ravel()
    apart = theirs - ours[ours_of][:, ours_of]
    return {"difference": float(np.abs(apart.data).max() / np.abs(ours.data).max())}


def _problem(mesh: PolyMesh, element: Element) -> Elasticity:
    return Elasticity(Space(mesh, element), MATERIAL)


def _store(folder: Path) -> Run:
    """Stiffness of the triangles held on the left, its load on the right, and the nodes of the unknowns."""
    space = Space(load_mesh(folder / "triangles.npz"), Lagrange(2))
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
    return {"n": matrix.n}


def _factor(folder: Path) -> Run:
    from flangeway._core import Cholesky  # noqa: PLC0415

    with np.load(folder / "matrix.npz") as stored:
        indptr, indices, values = (stored[name] for name in ("indptr", "indices", "values"))
        groups, load = stored["groups"], stored["load"]
    none = np.empty(0, dtype=np.int32)
    seconds, solution = timed(lambda: Cholesky(indptr, indices, values, groups, none).solve(load))
    peak = resident_mb()
    accuracy = _backward_error(folder / "matrix.npz", solution)
    return {"seconds": seconds, "n": len(load), "accuracy": accuracy, "peak_mb": peak}


def _splu(folder: Path, *, symmetric: bool) -> Run:
    from scipy.sparse.linalg import splu  # noqa: PLC0415

    with np.load(folder / "matrix.npz") as stored:
        n, load = len(stored["load"]), stored["load"]
        matrix = sp.csc_array(SymmetricMatrix(n, stored["indptr"], stored["indices"], stored["values"]).full())
    options: dict[str, Any] = {}
    if symmetric:
        options = {"permc_spec": "MMD_AT_PLUS_A", "diag_pivot_thresh": 0.0, "options": {"SymmetricMode": True}}
    seconds, solution = timed(lambda: splu(matrix, **options).solve(load))
    peak = resident_mb()
    return {"seconds": seconds, "accuracy": _backward_error(folder / "matrix.npz", solution), "peak_mb": peak}


JOBS: dict[str, Callable[[Path], Run]] = {
    "assemble": _ours,
    "local matrices 1": lambda folder: _local_matrices(folder, 1),
    "local matrices 2": lambda folder: _local_matrices(folder, 2),
    "check triangles": lambda folder: _check(folder, "triangles", Lagrange(1)),
    "check polygons": lambda folder: _check(folder, "polygons", Virtual(1)),
    "compare assembly": _compare,
    "store matrix": _store,
    "factor": _factor,
    "splu symmetric": lambda folder: _splu(folder, symmetric=True),
    "splu default": lambda folder: _splu(folder, symmetric=False),
}

if __name__ == "__main__":
    print(json.dumps(JOBS[sys.argv[1]](Path(sys.argv[2]))))
