"""Stiffness of triangles with scikit-fem; run by the interpreter of its own environment.

``scikit_fem.py laplace MESH ORDER`` or ``elasticity MESH DEGREE YOUNG POISSON [OUT]`` with a degree of quadrature, 0
for scikit-fem's own choice. Prints as JSON the best time from a mesh to the sparse matrix after one run that is not
counted, the energy of u = x (or of ``ux = x``), and the peak of memory. With OUT the matrix and the places of the
unknowns are stored.
"""

import json
import sys
import time
from collections.abc import Callable
from importlib.metadata import version
from pathlib import Path
from typing import Any

import numpy as np
import skfem
from skfem.models.elasticity import lame_parameters, linear_elasticity
from skfem.models.poisson import laplace

REPEATS = {"laplace": 5, "elasticity": 1}


def mesh_of(path: str) -> skfem.MeshTri:
    """The stored triangles."""
    with np.load(path) as stored:
        return skfem.MeshTri(
            np.ascontiguousarray(stored["points"].T),
            np.ascontiguousarray(stored["cells"].reshape(-1, 3).T.astype(np.int64)),
        )


def best(work: Callable[[], Any], repeats: int) -> tuple[float, Any]:
    """Shortest time after a run that is not counted, and the result."""
    work()
    shortest, result = float("inf"), None
    for _ in range(repeats):
        start = time.perf_counter()
        result = work()
        shortest = min(shortest, time.perf_counter() - start)
    return shortest, result


def main(what: str, path: str, number: int, *rest: str) -> dict[str, Any]:
    """Assemble and tell."""
    mesh = mesh_of(path)
    if what == "laplace":
        element = (skfem.ElementTriP1, skfem.ElementTriP2, skfem.ElementTriP3)[number - 1]
        seconds, matrix = best(lambda: laplace.assemble(skfem.Basis(mesh, element())), REPEATS[what])
        u = skfem.Basis(mesh, element()).project(lambda x: x[0])
        return {"seconds": seconds, "energy": float(u @ (matrix @ u))}
    young, poisson = map(float, rest[:2])

    def stiffness() -> tuple[Any, Any]:
        basis = skfem.Basis(mesh, skfem.ElementVector(skfem.ElementTriP2()), intorder=number or None)
        return basis, skfem.asm(linear_elasticity(*lame_parameters(young, poisson)), basis)

    seconds, (basis, matrix) = best(stiffness, REPEATS[what])
    result = {"seconds": seconds, "peak_mb": peak_mb()}
    u = np.zeros(basis.N)
    u[0::2] = basis.doflocs[0, 0::2]
    if rest[2:]:
        full = matrix.tocsr()
        np.savez(rest[2], indptr=full.indptr, indices=full.indices, values=full.data, places=basis.doflocs)
    return result | {"energy": float(u @ (matrix @ u))}


def peak_mb() -> float:
    """Peak of resident memory."""
    lines = Path("/proc/self/status").read_text(encoding="utf-8").splitlines()
    return float(next(line for line in lines if line.startswith("VmHWM")).split()[1]) / 1024.0


if __name__ == "__main__":
    told = main(sys.argv[1], sys.argv[2], int(sys.argv[3]), *sys.argv[4:])
    print(json.dumps(told | {"version": version("scikit-fem")}))
