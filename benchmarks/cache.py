"""The second run of wheelset cases beside the first: what is kept on disk is not computed again.

Accuracy is the maximum difference of a patch's force from that of the first run, over the load.
"""

import json
import sys
from collections.abc import Iterator
from tempfile import TemporaryDirectory
from typing import Any

from benchmarks.measurement import ITSELF, Measurement, timed
from benchmarks.samples import sample
from flangeway.cases import Wheelset, load_case
from flangeway.railway.wheelset.plane_wheelset import solve_wheelset

CASES: dict[str, tuple[str, dict[str, Any]]] = {
    "wheelset-tangent": ("wheelset-tangent", {}),
    "wheelset-curve": ("wheelset-curve", {}),
    "wheelset-tangent, vem, order 2": ("wheelset-tangent", {"method": "vem", "order": 2}),
}


def measurements() -> Iterator[Measurement]:
    """First and second run of each case, each in a process of its own, imports not counted."""
    for name in CASES:
        with TemporaryDirectory() as folder:
            first, second = (sample("benchmarks.cache", name, FLANGEWAY_CACHE=folder) for _ in range(2))
        pairs = zip(first["forces_N"], second["forces_N"], strict=True)
        apart = max(abs(one - other) for one, other in pairs) / first["load_N"]
        told = ", ".join(f"{stage} {value:.2f} s" for stage, value in second["stages_s"].items())
        yield Measurement(f"second run of {name}", ITSELF, second["seconds"], first["seconds"], apart, None, told)


def _run(name: str) -> dict[str, Any]:
    """Solve a case in this process."""
    case, values = CASES[name]
    problem = load_case(case, **values)
    assert isinstance(problem, Wheelset)
    seconds, result = timed(lambda: solve_wheelset(problem))
    return {
        "seconds": seconds,
        "load_N": problem.forces.vertical_N,
        "forces_N": [float(each) for patch in result.patches for each in patch.force_on_wheel_N],
        "stages_s": result.timings_s,
    }


if __name__ == "__main__":
    print(json.dumps(_run(sys.argv[1])))
