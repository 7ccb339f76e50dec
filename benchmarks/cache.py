"""The second run of wheelset cases beside the first: what is kept on disk is not computed again.

Accuracy is the largest difference of a patch's force from that of the first run, over the load.
"""

import os
import subprocess
import sys
from collections.abc import Iterator
from tempfile import TemporaryDirectory

from benchmarks.measurement import Measurement

CASES = {
    "wheelset-tangent": "WheelsetTangentCase()",
    "wheelset-curve": "WheelsetCurveCase()",
    "wheelset-tangent, vem, order 2": "WheelsetTangentCase(method='vem', order=2)",
}

FIRST_RUN = "flangeway"
"""The peer is the first run of the same program."""

RUN = """
import time
from flangeway.railway.result import solve_wheelset
from flangeway.study import WheelsetCurveCase, WheelsetTangentCase
problem = {case}.problem()
start = time.perf_counter()
result = solve_wheelset(problem)
seconds = time.perf_counter() - start
forces = [float(each) for patch in result.patches for each in patch.force_on_wheel_N]
print(repr((seconds, problem.load.vertical_N, forces, result.timings_s)))
"""


def measurements() -> Iterator[Measurement]:
    """First and second run of each case, each in a process of its own, imports not counted."""
    for name, case in CASES.items():
        with TemporaryDirectory() as folder:
            first, load, forces, _ = _run(case, folder)
            second, _, again, stages = _run(case, folder)
        apart = max(abs(one - other) for one, other in zip(forces, again, strict=True)) / load
        told = ", ".join(f"{stage} {value:.2f} s" for stage, value in stages.items())
        yield Measurement(f"second run of {name}", FIRST_RUN, second, first, apart, None, told, asked=5.0)


def _run(case: str, folder: str) -> tuple[float, float, list[float], dict[str, float]]:
    environment = os.environ | {"FLANGEWAY_CACHE": folder}
    done = subprocess.run(
        [sys.executable, "-c", RUN.format(case=case)], env=environment, capture_output=True, text=True, check=True
    )
    result: tuple[float, float, list[float], dict[str, float]] = eval(done.stdout)
    return result
