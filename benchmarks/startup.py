"""Processor time of whole commands, imports included: the help, and a wheelset whose bodies are in the cache.

``python -m benchmarks.startup CHECKOUT [LIMIT]`` compares with another checkout that has its compiled core, both in
turns; the exit status is 1 where a ratio of its time to ours is below the limit.
"""

import os
import resource
import subprocess
import sys
from collections.abc import Iterator
from functools import partial
from pathlib import Path
from tempfile import TemporaryDirectory

from benchmarks.measurement import ITSELF, NO_PEER, Measurement, fastest_in_turns, taken
from benchmarks.samples import ROOT

ROUNDS = 10
COMMANDS = {
    "flangeway --help": (1.0 / 0.6, ("--help",)),
    "flangeway run wheelset, second run": (1.0 / 0.8, ("run", "wheelset", "-q", "--no-pictures")),
}
"""Least ratio of the time of commit ec5b1e5a to ours, and arguments."""


def measurements(other: Path | None = None, rounds: int = ROUNDS) -> Iterator[Measurement]:
    """Each command, beside that of another checkout if there is one."""
    checkouts = [ROOT] if other is None else [ROOT, other]
    for work, (asked, words) in COMMANDS.items():
        with TemporaryDirectory() as folder:
            jobs = {str(root): partial(_processor_time, root, words, Path(folder)) for root in checkouts}
            for first in jobs.values():  # compiles modules, and fills the cache
                first()
            best = fastest_in_turns(jobs, dict.fromkeys(jobs, rounds), float)
        ours, *theirs = (taken(best[name]) for name in jobs)
        if other is None:
            yield Measurement(work, NO_PEER, ours, None, None, None)
        else:
            yield Measurement(work, ITSELF, ours, theirs[0], None, None, f"beside {other}", asked=asked)


def quick() -> Iterator[Measurement]:
    """Each command twice."""
    return measurements(rounds=1)


def _processor_time(root: Path, words: tuple[str, ...], folder: Path) -> float:
    """Seconds of all processors that the command of a checkout takes; each checkout has a cache of its own."""
    where = folder / root.name
    where.mkdir(exist_ok=True)
    paths = os.pathsep.join(map(str, (root / "src", root / "studies", root)))
    variables = {"PYTHONPATH": paths, "FLANGEWAY_CACHE": str(where / "cache"), "OPENBLAS_NUM_THREADS": "1"}
    environment = {name: value for name, value in os.environ.items() if name != "PYTHONDONTWRITEBYTECODE"} | variables
    before = resource.getrusage(resource.RUSAGE_CHILDREN)
    command = [sys.executable, "-m", "flangeway", *words]
    subprocess.run(command, cwd=where, env=environment, check=True, stdout=subprocess.DEVNULL)
    after = resource.getrusage(resource.RUSAGE_CHILDREN)
    return after.ru_utime + after.ru_stime - before.ru_utime - before.ru_stime


def main(arguments: list[str]) -> int:
    """Print the lines beside another checkout."""
    found = []
    for measurement in measurements(Path(arguments[0]).resolve()):
        print(measurement.line(), flush=True)
        found.append(measurement.ratio or 0.0)
    return int(min(found) < float(arguments[1] if len(arguments) > 1 else 0.0))


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
