"""The wheelset in three dimensions beside the plane one: first runs, further positions, and CONTACT's published times.

Each first run is a process of its own, without anything in the cache (cold) or with what the cold one left (warm): "to
the numbers" is from its start, imports included, to the equilibrium and its patches, "to all files" until report,
pictures and tables are written. Further positions are the same wheelset moved sideways, lateral position given, on one
core. Accuracy is the error of the equilibrium over the load. CONTACT's time is that which its performance test of 2016
publishes for the normal contact of 3148 cells (perfc_test/get_times.ref_out, norm_problm_1p, on vortech32.vortech.nl,
Linux, processor not named): not this machine.
"""

import json
import sys
import time
from collections.abc import Iterator
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any

import numpy as np

from benchmarks.measurement import NO_PEER, Measurement, timed
from benchmarks.samples import resident_mb, sample
from benchmarks.spatial import contact_of
from benchmarks.sweep import wheelset_of
from benchmarks.worn import worn_pair
from flangeway.cases import Wheelset
from flangeway.report.case_outputs import write_case
from flangeway.types import Floats

ASKED_COLD_S, ASKED_WARM_S, ASKED_MB = 25.0, 3.0, 2048.0
FURTHER: dict[str, tuple[dict[str, Any], float]] = {
    "without friction": ({}, 0.15),
    "with friction": ({"rolling.friction": 0.3, "rolling.speed_km_h": 72.0}, 0.4),
}
"""Inputs of the wheelset that is moved, and the seconds that are asked."""
PLACES: dict[str, tuple[tuple[float, float], int]] = {
    "README": ((-6.0, 6.0), 50),
    "worn pair": ((-2.0, 2.0), 10),
    "two patches and flange contact": ((5.8, 7.0), 10),
}
"""Lateral positions from and to, mm, and their number; a pair of files as instruments write, or the bundled one."""
QUICK_POSITIONS = 3
CONTACT_CELLS, CONTACT_S = 3148, 0.1
GRID = (89, 89)
"""Cells of a window whose patch has about as many cells under pressure."""


def measurements() -> Iterator[Measurement]:
    """First runs of both models, further positions, and normal contact of the size that CONTACT publishes."""
    for model in ("spatial", "plane"):
        yield from _first_runs(model)
    yield from _further()
    yield _normal_contact()


def quick() -> Iterator[Measurement]:
    """A few further positions."""
    yield from _further(QUICK_POSITIONS)


def _further(most: int | None = None) -> Iterator[Measurement]:
    """Further positions of all pairs, at most so many of each."""
    with TemporaryDirectory() as folder:
        for pair, ((first, last), count) in PLACES.items():
            files = worn_pair(Path(folder)) if pair == "worn pair" else {}
            laterals = np.linspace(first, last, min(count, most or count))
            for name, (inputs, asked_s) in FURTHER.items():
                yield _positions(laterals, f"{name}, {pair}", files | inputs, asked_s)


def _first_runs(model: str) -> Iterator[Measurement]:
    with TemporaryDirectory() as folder:
        for name in ("cold", "warm"):
            # the cache is in the folder: the first run finds none
            start, out = repr(time.time()), str(Path(folder) / name)
            found = sample("benchmarks.wheelset3d", model, start, out, FLANGEWAY_CACHE=str(Path(folder) / "cache"))
            asked_s = ASKED_COLD_S if name == "cold" else ASKED_WARM_S
            asked = {"asked_s": asked_s, "asked_mb": ASKED_MB} if model == "spatial" else {}
            seconds = found["files_s"] if name == "cold" else found["numbers_s"]
            yield Measurement(
                f"run wheelset, {model} model, {name}", NO_PEER, seconds, None, found["error"], None,
                "to all files" if name == "cold" else "to the numbers",
                more={name: found[name] for name in ("numbers_s", "files_s", "peak_mb")} | asked,
            )  # fmt: skip


def _run(model: str, start: float, folder: Path) -> dict[str, Any]:
    """Run the case in this process, which began at a time."""
    done = Wheelset.from_values({"contact": model}).run()
    numbers = time.time() - start
    write_case(done, folder)
    return {
        "numbers_s": numbers,
        "files_s": time.time() - start,
        "error": done.result.equilibrium.residuals.equilibrium_residual,
        "peak_mb": round(resident_mb()),
    }


def _positions(laterals: Floats, name: str, inputs: dict[str, Any], asked_s: float) -> Measurement:
    """Further positions of a wheelset whose bodies and rigid geometry are ready, as those of a campaign."""
    wheelset = wheelset_of(inputs)
    _ = wheelset.geometry.limits(float(np.abs(laterals).max()))
    times, errors, missing = [], [], 0
    for lateral in laterals.tolist():
        moved = wheelset.at(wheelset.problem.replaced(position={"lateral_mm": lateral}))
        seconds, found = timed(moved.solve, time.process_time)
        times.append(seconds)
        missing += not found.status.converged
        if found.status.converged:
            errors.append(found.residuals.equilibrium_residual)
    ends = f"{laterals[0]:g} to {laterals[-1]:g} mm"
    return Measurement(
        f"further position {name}, mean of {len(laterals)} from {ends}", NO_PEER, float(np.mean(times)), None,
        max(errors), None, "seconds of the processor; each from its rigid position",
        more={
            "slowest_s": max(times), "ten_thousand_on_two_cores_min": 1e4 * float(np.mean(times)) / 120.0,
            "not_found": missing, "asked_s": asked_s,
        },
    )  # fmt: skip


def _normal_contact() -> Measurement:
    """Normal contact of a patch with as many cells under pressure as CONTACT's performance test has."""
    size, error = contact_of(*GRID)
    return Measurement(
        f"normal contact of half-spaces, {size['loaded']} cells under pressure", NO_PEER, size["cold"], None, error,
        None,
        f"CONTACT (revision 1274) on another machine: {CONTACT_CELLS} cells, printed to 0.1 s",
        more={"iterations": size["iterations"], "contact_published_s": CONTACT_S},
    )  # fmt: skip


if __name__ == "__main__":
    print(json.dumps(_run(sys.argv[1], float(sys.argv[2]), Path(sys.argv[3]))))
