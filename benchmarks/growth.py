"""Time and memory over the number of unknowns, from ten thousand to a million: plane elasticity on triangles.

Elements are of order 2 and each size is a process of its own. The unit square is held on the left and pulled on the
right; the mesh is made before.
Exponents are the slopes of straight lines through the logarithms.
"""

import json
import sys
import tempfile
from collections.abc import Iterator, Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np

from benchmarks.measurement import NO_PEER, Measurement, timed
from benchmarks.samples import load_mesh, resident_mb, sample, save_mesh
from flangeway.elements import Lagrange
from flangeway.geometry import square
from flangeway.materials import Elastic
from flangeway.mesh import triangulate
from flangeway.problems import Elasticity, Traction, fixed
from flangeway.solve.constraints import find_constraints
from flangeway.space import Space

UNKNOWNS = (10_000, 30_000, 100_000, 300_000, 1_000_000)
QUICK = (2_000, 4_000, 8_000)
REPEATS = 3  # up to a hundred thousand unknowns; the fastest counts
STAGES = ("assembly", "factor", "solve")
MAX_MB = 24.0 * 1024.0
MAX_EXPONENT = 1.6


def exponent(sizes: Sequence[Mapping[str, Any]], name: str, least: int = 0) -> float:
    """Slope of the logarithm of what is measured over that of the unknowns, for sizes of about `least` and more."""
    chosen = [size for size in sizes if size["unknowns"] > 0.8 * least]
    logs = np.log([[size["unknowns"], size[name]] for size in chosen])
    return float(np.polyfit(logs[:, 0], logs[:, 1], 1)[0])


def measurements(unknowns: tuple[int, ...] = UNKNOWNS) -> Iterator[Measurement]:
    """A line for each size, and one of the exponents."""
    sizes = []
    for number in unknowns:
        size = _size(number)
        sizes.append(size)
        stages = ", ".join(f"{name} {size[name]:.3f} s" for name in STAGES)
        yield Measurement(
            f"plane elasticity, {size['unknowns']} unknowns on {size['cells']} triangles of order 2: assembly, factor "
            "and solution",
            NO_PEER, size["total"], None, size["residual"], None, stages, more=size,
        )  # fmt: skip
    middle = 100_000 if max(unknowns) > 100_000 else 0
    exponents, exponents_of_all = (
        {name: round(exponent(sizes, name, least), 3) for name in (*STAGES, "total", "peak_mb")}
        for least in (middle, 0)
    )
    yield Measurement(
        f"growth from {sizes[0]['unknowns']} to {sizes[-1]['unknowns']} unknowns",
        NO_PEER, sizes[-1]["total"], None, sizes[-1]["residual"], None,
        f"exponents over the unknowns, those of `exponents` from {middle or sizes[0]['unknowns']} on",
        more={
            "exponents": exponents,
            "exponents_of_all": exponents_of_all,
            "asked_exponent": MAX_EXPONENT,
            "asked_mb": MAX_MB,
        },
    )  # fmt: skip


def quick() -> Iterator[Measurement]:
    """Small sizes."""
    yield from measurements(QUICK)


def _size(unknowns: int) -> dict[str, Any]:
    with tempfile.TemporaryDirectory() as name:
        path = Path(name) / "mesh.npz"
        # about four unknowns a triangle of order 2, and 2.6 triangles a square of their size
        save_mesh(path, triangulate(square(1.0), size=float(np.sqrt(10.4 / unknowns))))
        runs = [sample("benchmarks.growth", str(path)) for _ in range(REPEATS if unknowns <= 100_000 else 1)]
    return min(runs, key=lambda run: float(run["total"]))


def _run(path: Path) -> dict[str, Any]:
    """Assemble, factorise and solve in this process."""
    from flangeway._core import Cholesky  # noqa: PLC0415

    mesh = load_mesh(path)
    _ = mesh.edges
    before = resident_mb("VmRSS")

    def assemble() -> tuple[Any, Any, Any]:
        problem = Elasticity(
            Space(mesh, Lagrange(2)),
            Elastic(210e3, 0.3),
            loads=[Traction("right", (1.0, 2.0))],
            supports=[fixed("left")],
        )
        constraints = find_constraints(problem)
        assert constraints.kept is not None
        matrix = problem.stiffness().restricted(constraints.kept)
        return matrix, constraints.groups, constraints.transform.T @ problem.load_vector().ravel()

    assembly, (matrix, groups, load) = timed(assemble)
    after_assembly = resident_mb()
    none = np.empty(0, dtype=np.int32)
    factoring, factor = timed(lambda: Cholesky(matrix.indptr, matrix.indices, matrix.values, groups, none))
    solving, values = timed(lambda: factor.solve(load))
    peak = round(resident_mb())
    residual = _residual(matrix, values, load)
    return {
        "unknowns": matrix.n,
        "cells": mesh.n_cells,
        "assembly": assembly,
        "factor": factoring,
        "solve": solving,
        "total": assembly + factoring + solving,
        "before_mb": round(before),
        "assembly_peak_mb": round(after_assembly),
        "peak_mb": peak,
        "factor_entries": factor.factor_nonzeros,
        "residual": float(np.abs(residual).max() / np.abs(load).max()),
    }


def _residual(matrix: Any, values: Any, load: Any) -> Any:
    """``K u - f`` from the lower triangle."""
    import scipy.sparse as sp  # noqa: PLC0415

    lower = sp.csc_array((matrix.values, matrix.indices, matrix.indptr), shape=(matrix.n, matrix.n))
    return lower @ values + lower.T @ values - lower.diagonal() * values - load


if __name__ == "__main__":
    print(json.dumps(_run(Path(sys.argv[1]))))
