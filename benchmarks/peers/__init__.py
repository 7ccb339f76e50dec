"""Other programs, each installed by ``benchmarks/peers/install.sh NAME`` outside of the repository."""

import json
import os
import shutil
import subprocess
import time
from pathlib import Path
from typing import Any

HERE = Path(__file__).parent


class PeerMissingError(RuntimeError):
    """A peer is not installed; the message says how to install it."""


def home(name: str) -> Path:
    """Folder of a peer."""
    cache = os.environ.get("XDG_CACHE_HOME") or str(Path.home() / ".cache")
    return Path(cache) / "flangeway-peers" / name


def threads_tried() -> tuple[int, ...]:
    """Numbers of threads that peers are run with: one, and as many as there are processors."""
    return tuple(sorted({1, len(os.sched_getaffinity(0))}))


def run_python(name: str, script: str, *arguments: str, threads: int = 1) -> dict[str, Any]:
    """Run a script of this folder by a peer's own interpreter; its last line of JSON is returned.

    Raises
    ------
    PeerMissingError
        If the peer is not installed.
    RuntimeError
        If the script fails.

    """
    interpreter = home(name) / "bin" / "python"
    _refuse_missing(name, interpreter)
    environment = {key: value for key, value in os.environ.items() if key != "PYTHONPATH"}
    environment |= {"OMP_NUM_THREADS": str(threads), "OPENBLAS_NUM_THREADS": str(threads)}
    command = [str(interpreter), str(HERE / script), *arguments]
    done = subprocess.run(command, env=environment, capture_output=True, text=True, check=False)
    if done.returncode:
        raise RuntimeError(f"{name} failed with status {done.returncode}: {(done.stderr or done.stdout)[-2000:]}")
    told: dict[str, Any] = json.loads(next(line for line in done.stdout.splitlines()[::-1] if line.startswith("{")))
    return told


def run_calculix(folder: Path, job: str, *, threads: int = 1) -> tuple[float, str]:
    """Run CalculiX, unpacked among the peers or of the system, on ``folder/job.inp``; return its seconds and version.

    Raises
    ------
    PeerMissingError
        If CalculiX is not installed.
    RuntimeError
        If it fails.

    """
    program = home("calculix") / "usr" / "bin" / "ccx"
    environment = os.environ | {"OMP_NUM_THREADS": str(threads)}
    if not program.exists():
        program = Path(shutil.which("ccx") or program)
    _refuse_missing("calculix", program)
    for libraries in (home("calculix") / "usr" / "lib").glob("*-linux-gnu"):
        environment["LD_LIBRARY_PATH"] = ":".join(str(libraries / part) for part in ("", "blas", "lapack"))
    start = time.perf_counter()
    done = subprocess.run([str(program), job], cwd=folder, env=environment, capture_output=True, text=True, check=False)
    seconds = time.perf_counter() - start
    if done.returncode or "Job finished" not in done.stdout:
        raise RuntimeError(f"calculix failed: {(done.stderr + done.stdout)[-2000:]}")
    version = next(line for line in done.stdout.splitlines() if "Version" in line).split("Version")[1].split(",")[0]
    return seconds, version.strip()


def _refuse_missing(name: str, program: Path) -> None:
    if not program.exists():
        raise PeerMissingError(f"{name} is not installed; install it with: sh benchmarks/peers/install.sh {name}")
