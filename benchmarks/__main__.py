"""Run benchmarks: ``python -m benchmarks [--quick] [report] [NAME...]``, all of them without a name.

``--quick`` takes small problems where there are some; ``report`` also writes ``docs/performance.md``, from these runs
and the last recorded ones of the others. Peers are installed by ``sh benchmarks/peers/install.sh``.
"""

import sys
from collections.abc import Callable, Iterator

from benchmarks import (
    cache,
    damage,
    elasticity,
    force_noise,
    forms,
    friction,
    growth,
    hertz,
    hertz_block_times,
    polygons,
    pushed,
    report,
    rolling,
    spatial,
    stabilisation,
    standing,
    startup,
    sweep,
    symmetric,
    torsion_assembly,
    torsion_sections,
    wheelset3d,
    wheelset_chain,
    worn,
)
from benchmarks.measurement import Measurement

BENCHMARKS: dict[str, Callable[[], Iterator[Measurement]]] = {
    "torsion-assembly": torsion_assembly.measurements,
    "torsion-sections": torsion_sections.measurements,
    "hertz": hertz.measurements,
    "hertz-block": hertz_block_times.measurements,
    "friction": friction.measurements,
    "elasticity": elasticity.measurements,
    "forms": forms.measurements,
    "growth": growth.measurements,
    "polygons": polygons.measurements,
    "pushed": pushed.measurements,
    "wheelset-chain": wheelset_chain.measurements,
    "cache": cache.measurements,
    "startup": startup.measurements,
    "stabilisation": stabilisation.measurements,
    "worn": worn.measurements,
    "spatial": spatial.measurements,
    "rolling": rolling.measurements,
    "wheelset3d": wheelset3d.measurements,
    "standing": standing.measurements,
    "sweep": sweep.measurements,
    "force-noise": force_noise.measurements,
    "damage": damage.measurements,
    "symmetric": symmetric.measurements,
}

ABOUTS = {name: sys.modules[run.__module__].__doc__ or "" for name, run in BENCHMARKS.items()}
"""What each measures: the first words of its module."""

CAMPAIGNS = {"force-noise", "polygons", "pushed", "standing", "startup", "sweep", "symmetric"}
"""Printed, not recorded: many cases that count what converges, most for half an hour or more, and whole commands."""

QUICK: dict[str, Callable[[], Iterator[Measurement]]] = {
    "torsion-assembly": torsion_assembly.quick,
    "torsion-sections": torsion_sections.quick,
    "hertz-block": hertz_block_times.quick,
    "friction": friction.quick,
    "elasticity": elasticity.quick,
    "forms": forms.quick,
    "growth": growth.quick,
    "polygons": polygons.quick,
    "pushed": pushed.quick,
    "stabilisation": stabilisation.quick,
    "wheelset-chain": wheelset_chain.quick,
    "worn": worn.quick,
    "spatial": spatial.quick,
    "rolling": rolling.quick,
    "wheelset3d": wheelset3d.quick,
    "standing": standing.quick,
    "startup": startup.quick,
    "sweep": sweep.quick,
    "damage": damage.quick,
    "symmetric": symmetric.quick,
}


def main(arguments: list[str]) -> int:
    """Print a JSON line a measurement."""
    small, page = "--quick" in arguments, "report" in arguments
    names = [name for name in arguments if name not in ("--quick", "report")]
    known = QUICK if small else BENCHMARKS
    unknown = [name for name in names if name not in known]
    if unknown or (small and page):
        given = ", ".join(unknown) or "report with --quick, whose times mean nothing"
        print(f"unknown: {given}; {'with --quick ' * small}there are: {', '.join(known)}", file=sys.stderr)
        return 2
    for name in names or known:
        found = []
        for measurement in known[name]():
            print(measurement.line(), flush=True)
            found.append(measurement)
        if page:
            report.record(name, found)
    if page:
        print(report.write(ABOUTS), file=sys.stderr)
    return 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
