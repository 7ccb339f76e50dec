"""Factorise a stored symmetric matrix and solve with CHOLMOD, as in the wheel of CVXOPT; run in its own environment.

``cvxopt_cholmod.py MATRIX OUT`` reads the lower triangle in compressed columns and a load, stores the solution, and
prints seconds and the peak of memory as JSON.
"""

import json
import sys
import time
from importlib.metadata import version
from pathlib import Path
from typing import Any

import cvxopt
import numpy as np
from cvxopt import cholmod


def main(path: str, out: str) -> dict[str, Any]:
    """Factorise, solve, tell."""
    with np.load(path) as stored:
        indptr, rows, values, load = (stored[name] for name in ("indptr", "indices", "values", "load"))
    columns = np.repeat(np.arange(len(load)), np.diff(indptr))
    matrix = cvxopt.spmatrix(
        cvxopt.matrix(values), cvxopt.matrix(rows.astype(np.int64)), cvxopt.matrix(columns), (len(load), len(load))
    )
    right = cvxopt.matrix(load)
    start = time.perf_counter()
    factor = cholmod.symbolic(matrix)
    cholmod.numeric(matrix, factor)
    cholmod.solve(factor, right)
    seconds = time.perf_counter() - start
    lines = Path("/proc/self/status").read_text(encoding="utf-8").splitlines()
    peak = float(next(line for line in lines if line.startswith("VmHWM")).split()[1]) / 1024.0
    np.save(out, np.array(right).ravel())
    return {"seconds": seconds, "peak_mb": peak, "version": version("cvxopt")}


if __name__ == "__main__":
    print(json.dumps(main(sys.argv[1], sys.argv[2])))
