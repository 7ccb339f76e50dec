"""Samples in processes of their own, so that the peak of memory is that of one piece of work."""

import json
import os
import subprocess
import sys
from pathlib import Path
from typing import Any

import numpy as np

from flangeway.mesh import PolyMesh

ROOT = Path(__file__).parents[1]


def sample(module: str, *arguments: str, **variables: str) -> dict[str, Any]:
    """Run a benchmark's module with arguments in a process of its own; its last line is JSON.

    Parameters
    ----------
    module
        Name of the module.
    arguments
        Its arguments.
    variables
        Variables of the environment beside those of this process.

    Raises
    ------
    RuntimeError
        If it fails.

    """
    done = subprocess.run(
        [sys.executable, "-m", module, *arguments],
        env=os.environ | {"OPENBLAS_NUM_THREADS": "1"} | variables,
        cwd=ROOT,
        capture_output=True,
        text=True,
        check=False,
    )
    if done.returncode:
        raise RuntimeError(f"{module} {' '.join(arguments)} failed: {done.stderr[-2000:]}")
    result: dict[str, Any] = json.loads(done.stdout.splitlines()[-1])
    return result


def resident_mb(what: str = "VmHWM") -> float:
    """Resident memory of this process at its peak (``VmHWM``) or now (``VmRSS``), never that of the parent."""
    status = Path("/proc/self/status")
    if not status.exists():
        return float("nan")
    found = next(line for line in status.read_text(encoding="utf-8").splitlines() if line.startswith(what))
    return float(found.split()[1]) / 1024.0


def save_mesh(path: Path, mesh: PolyMesh) -> None:
    """Store a mesh as arrays, the edges' numbering included, for peers that need it."""
    sets: dict[str, Any] = {f"edges {name}": edges for name, edges in mesh.edge_sets.items()}
    np.savez(
        path,
        points=mesh.points,
        offsets=mesh.cell_offsets,
        cells=mesh.cell_points,
        edges=mesh.edges,
        cell_edges=mesh.cell_edges,
        **sets,
    )


def load_mesh(path: Path) -> PolyMesh:
    """A stored mesh."""
    with np.load(path) as stored:
        sets = {name.removeprefix("edges "): stored[name] for name in stored if name.startswith("edges ")}
        return PolyMesh(stored["points"], stored["offsets"], stored["cells"], edge_sets=sets)
