"""Run benchmarks by name: ``python -m benchmarks torsion-assembly``; ``elasticity --quick`` takes small meshes."""

import sys
from collections.abc import Callable, Iterator

from benchmarks import elasticity, hertz, torsion_assembly
from benchmarks.measurement import Measurement

BENCHMARKS: dict[str, Callable[[], Iterator[Measurement | elasticity.Row]]] = {
    "torsion-assembly": torsion_assembly.measurements,
    "hertz": hertz.measurements,
    "elasticity": elasticity.measurements,
}


def main(names: list[str]) -> int:
    """Print a line a measurement, JSON or of a table; without a name, run all."""
    if "--quick" in names:
        if sorted(names) != ["--quick", "elasticity"]:
            print("--quick is for elasticity alone: python -m benchmarks elasticity --quick", file=sys.stderr)
            return 2
        for row in elasticity.measurements(quick=True):
            print(row.line(), flush=True)
        return 0
    unknown = [name for name in names if name not in BENCHMARKS]
    if unknown:
        print(f"unknown benchmark {', '.join(unknown)}; there are: {', '.join(BENCHMARKS)}", file=sys.stderr)
        return 2
    for name in names or BENCHMARKS:
        for measurement in BENCHMARKS[name]():
            print(measurement.line(), flush=True)
    return 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
