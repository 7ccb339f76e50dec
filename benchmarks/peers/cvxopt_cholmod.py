"""Factorise a stored symmetric matrix and solve with CHOLMOD, as in the wheel of CVXOPT; run in its own environment.

``cvxopt_cholmod.py MATRIX OUT [ROUNDS]`` reads the lower triangle in compressed columns and a load, stores the
solution, and prints the least seconds of some rounds, those of the processor, and the peak of memory as JSON.
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


def main(path: str, out: str, rounds: str = "1") -> dict[str, Any]:
    """Factorise, solve, tell."""
    with np.load(path) as stored:
        indptr, rows, values, load = (stored[name] for name in ("indptr", "indices", "values", "load"))
    columns = np.repeat(np.arange(len(load)), np.diff(indptr))
    matrix = cvxopt.spmatrix(
        cvxopt.matrix(values), cvxopt.matrix(rows.astype(np.int64)), cvxopt.matrix(columns), (len(load), len(load))
    )
    seconds, processor = float("inf"), float("inf")
    for _ in range(int(rounds)):
        right = cvxopt.matrix(load)
        start, start_of_processor = time.perf_counter(), time.process_time()
        factor = cholmod.symbolic(matrix)
        cholmod.numeric(matrix, factor)
        cholmod.solve(factor, right)
        seconds = min(seconds, time.perf_counter() - start)
        processor = min(processor, time.process_time() - start_of_processor)
    lines = Path("/proc/self/status").read_text(encoding="utf-8").splitlines()
    peak = float(next(line for line in lines if line.startswith("VmHWM")).split()[1]) / 1024.0
    np.save(out, np.array(right).ravel())
    return {"seconds": seconds, "processor_s": processor, "peak_mb": peak, "version": version("cvxopt")}


if __name__ == "__main__":
    print(json.dumps(main(*sys.argv[1:])))
