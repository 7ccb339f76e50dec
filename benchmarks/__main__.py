"""Run benchmarks by name: ``python -m benchmarks torsion-assembly``."""

import sys
from collections.abc import Callable, Iterator

from benchmarks import hertz, torsion_assembly
from benchmarks.measurement import Measurement

BENCHMARKS: dict[str, Callable[[], Iterator[Measurement]]] = {
    "torsion-assembly": torsion_assembly.measurements,
    "hertz": hertz.measurements,
}


def main(names: list[str]) -> int:
    """Print one JSON line a measurement; without a name, run all."""
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
