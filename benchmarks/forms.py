"""Forms beside scikit-fem: assembly and solution of Poisson's equation on triangles of order 2.

Seconds are those of the processor, the least of three runs after each other (SuperLU with most unknowns: of one), so
that other programs on the machine count little. scikit-fem solves as it does by default, with SciPy's SuperLU, and with
CHOLMOD (of CVXOPT's wheel), and assembles with quadrature of degree 2; numbering and boundary conditions are included.
CHOLMOD alone stands beside our factor, condition and solution. The matrix of the dual polygons of the same triangles is
assembled by pypolydim. CHOLMOD and pypolydim run in environments of their own, see `benchmarks.peers`. A second
solution with the kept factor has no peer.
"""

import tempfile
import time
from collections.abc import Iterator
from dataclasses import replace
from functools import partial
from importlib import import_module
from pathlib import Path
from typing import Any

import numpy as np
import scipy.sparse as sp

from benchmarks.measurement import ITSELF, Measurement, best_time
from benchmarks.peers import PeerMissingError, run_python
from benchmarks.samples import save_mesh
from flangeway.elements import Lagrange, Virtual
from flangeway.forms import Factor, interpolate, load, stiffness
from flangeway.geometry import square
from flangeway.mesh import PolyMesh, dual, triangulate
from flangeway.space import Space
from flangeway.types import Floats

CLOCK = time.process_time
SIZES = (0.0126, 0.0063, 0.0034)  # of edges in the unit square: 30,000, 120,000 and 400,000 unknowns of order 2
ROUNDS = 3


def measurements(*, sizes: tuple[float, ...] = SIZES, rounds: int = ROUNDS) -> Iterator[Measurement]:
    """All sizes."""
    skfem = import_module("skfem")  # of the development group, without types

    for size in sizes:
        mesh = triangulate(square(1.0), size=size)
        n_rounds = 1 if size < SIZES[1] else rounds
        ours, u = best_time(partial(_ours, mesh), rounds, CLOCK)
        assembly, system = best_time(partial(_scikit_fem_system, skfem, mesh), rounds, CLOCK)
        solution, v = best_time(partial(_scikit_fem_solution, skfem, system), n_rounds, CLOCK)
        apart = float(np.abs(u[: mesh.n_points] - v).max() / np.abs(v).max())
        condensed, _ = best_time(lambda system=system: _condensed(skfem, system), rounds, CLOCK)  # type: ignore[misc]
        work = f"assembly and solution of {len(u)} unknowns of Poisson's equation"
        note = "triangles of order 2; maximum difference at the points"
        yield Measurement(work, "scikit-fem", ours, assembly + solution, apart, apart, note, skfem.__version__)
        alone = _against_cholmod(mesh, rounds)
        peer = "scikit-fem and CHOLMOD"
        both = None if alone.peer_s is None else assembly + condensed + alone.peer_s
        yield Measurement(work, peer, ours, both, apart, alone.peer_accuracy, note, skfem.__version__)
        yield alone
        space = Space(dual(mesh), Virtual(2))
        yield _against_pypolydim(space, rounds)
        matrix, rhs = stiffness(space), load(space, 1.0)
        first, factor = best_time(partial(_factored, matrix, space, rhs), rounds, CLOCK)
        again, _ = best_time(partial(factor.solve, rhs), rounds, CLOCK)
        yield Measurement(
            f"a solution with the kept factor of {space.n_dofs} unknowns", ITSELF, again, first, None, None,
            "polygons of order 2; beside the first solution: factor, condition and solution",
        )  # fmt: skip


def quick() -> Iterator[Measurement]:
    """A coarse mesh, once."""
    yield from measurements(sizes=(0.1,), rounds=1)


def _against_cholmod(mesh: PolyMesh, rounds: int) -> Measurement:
    """Factor, condition and solution of the unknowns inside, beside factor and solution."""
    space = Space(mesh, Lagrange(2))
    free = np.setdiff1d(np.arange(space.n_dofs), space.boundary_dofs())
    matrix, rhs = sp.csr_array(stiffness(space)[free][:, free]), load(space, 1.0, degree=2)[free]
    ours, u = best_time(lambda: Factor(matrix).solve(rhs), rounds, CLOCK)
    work = f"factor and solution of {len(free)} unknowns of Poisson's equation"
    with tempfile.TemporaryDirectory() as folder:
        path, out, lower = Path(folder) / "matrix.npz", Path(folder) / "u.npy", sp.csc_array(sp.tril(matrix))
        np.savez(path, indptr=lower.indptr, indices=lower.indices, values=lower.data, load=rhs)
        try:
            run = run_python("cvxopt", "cvxopt_cholmod.py", str(path), str(out), str(rounds))
        except PeerMissingError as missing:
            return Measurement(work, "CHOLMOD", ours, None, None, None, str(missing))
        apart = float(np.abs(u - np.load(out)).max() / np.abs(u).max())
    return Measurement(
        work,
        "CHOLMOD",
        ours,
        run["processor_s"],
        apart,
        apart,
        "triangles of order 2; maximum difference",
        run["version"],
    )


def _against_pypolydim(space: Space, rounds: int) -> Measurement:
    """Assembly of the matrix, from a mesh; pypolydim's geometry, numbering and sparse matrix are not in its time."""
    mesh, work = space.mesh, f"assembly of {space.n_dofs} unknowns of Poisson's equation"
    ours, matrix = best_time(lambda: stiffness(Space(replace(mesh), Virtual(2))), rounds, CLOCK)
    u = interpolate(space, lambda p: p[:, 0])
    with tempfile.TemporaryDirectory() as folder:
        save_mesh(Path(folder) / "mesh.npz", mesh)
        try:
            run = run_python("pypolydim", "pypolydim_laplace.py", str(Path(folder) / "mesh.npz"), "2")
        except PeerMissingError as missing:
            return Measurement(work, "pypolydim", ours, None, None, None, str(missing))
    errors = abs(float(u @ (matrix @ u)) - 1.0), abs(run["energy"] - 1.0)
    return Measurement(
        work,
        "pypolydim",
        ours,
        run["processor_s"],
        *errors,
        "polygons of order 2; error of the energy of x",
        run["version"],
    )


def _ours(mesh: PolyMesh) -> Floats:
    """All unknowns; the mesh is taken as new, without what it keeps, as scikit-fem's is made anew."""
    space = Space(replace(mesh), Lagrange(2))
    return Factor(stiffness(space), space.boundary_dofs()).solve(load(space, 1.0, degree=2))


def _factored(matrix: Any, space: Space, rhs: Floats) -> Factor:
    factor = Factor(matrix, space.boundary_dofs())
    factor.solve(rhs)
    return factor


def _scikit_fem_system(skfem: Any, mesh: PolyMesh) -> tuple[Any, ...]:
    """Basis, matrix and load."""
    basis = skfem.Basis(
        skfem.MeshTri(mesh.points.T, mesh.cell_points.reshape(-1, 3).T), skfem.ElementTriP2(), intorder=2
    )
    K = skfem.BilinearForm(lambda u, v, _: u.grad[0] * v.grad[0] + u.grad[1] * v.grad[1]).assemble(basis)
    return basis, K, skfem.LinearForm(lambda v, _: 1.0 * v).assemble(basis)


def _condensed(skfem: Any, system: tuple[Any, ...]) -> Any:
    """Matrix, load and numbers of the unknowns inside."""
    basis, K, b = system
    return skfem.condense(K, b, D=basis.get_dofs().all())


def _scikit_fem_solution(skfem: Any, system: tuple[Any, ...]) -> Floats:
    """Values at the points."""
    solution: Floats = skfem.solve(*_condensed(skfem, system))
    return solution[system[0].nodal_dofs[0]]
