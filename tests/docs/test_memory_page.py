"""The how-to on memory, threads and the cache: its commands run, and its numbers are those of the program."""

import os
import re
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest

TEXT = (Path(__file__).parents[2] / "docs" / "how-to" / "memory-threads-and-cache.md").read_text(encoding="utf-8")
BLOCKS = re.findall(r"```(python|sh|text)\n(.*?)```", TEXT, flags=re.DOTALL)

SOLVED = """
import sys
import numpy as np
import flangeway as fw
from flangeway._core import n_threads
from flangeway.solve import solve_elasticity

mesh = fw.mesh.dual(fw.mesh.triangulate(fw.geometry.square(1.0), size=0.03))
space = fw.Space(mesh, fw.Virtual(2))
torsion = fw.Torsion(space)
problem = fw.Elasticity(
    space, fw.Elastic(210e3, 0.3), loads=[fw.Traction("right", (1.0, 2.0))], supports=[fw.fixed("left")]
)
solution = solve_elasticity(problem)
stiffness = torsion.stiffness()
np.savez(
    sys.argv[1], n_threads=n_threads(), values=stiffness.values, indices=stiffness.indices,
    displacements=solution.displacements, function=fw.solve_torsion(torsion).function,
)
"""


def environment(folder, **more):
    return os.environ | {"OPENBLAS_NUM_THREADS": "1", "XDG_CACHE_HOME": str(folder / "cache"), **more}


def ran(folder, *command, **more):
    """Return what a command prints, and its status."""
    done = subprocess.run(
        command, cwd=folder, capture_output=True, text=True, check=False, env=environment(folder, **more), timeout=300
    )
    return done.returncode, done.stdout + done.stderr


@pytest.fixture(scope="module")
def followed(tmp_path_factory):
    """Every block of the page, run in its order in one folder; what each printed, and the folder."""
    folder = tmp_path_factory.mktemp("page")
    printed = []
    for kind, block in BLOCKS:
        if kind == "python":
            printed.append((kind, *ran(folder, sys.executable, "-c", block)))
        elif kind == "sh":
            words = re.sub(
                r"(?m)^((?:[A-Z_]+=\S+ )*)\.venv/bin/flangeway ", rf"\1{sys.executable} -m flangeway ", block
            )
            words = words.replace(" .venv/bin/python ", f" {sys.executable} ")
            last = (folder / "kept").exists() and sorted(path.name for path in (folder / "kept").iterdir())
            printed.append((kind, *ran(folder, "sh", "-ec", words), last))
        else:
            printed.append((kind, block))
    return printed, folder


def test_every_block_runs_and_prints_what_is_shown(followed):
    """Each command and script of the page ends well, but for the two that are refused, and prints what is shown."""
    printed, _ = followed
    statuses = [entry[1] for entry in printed if entry[0] == "sh"]
    assert statuses == [1, 2, 0, 0, 0, 0], printed
    before = ""
    n_shown = 0
    for entry in printed:
        if entry[0] == "text":
            assert entry[1].strip() in before
            n_shown += 1
        else:
            before = entry[2]
    assert n_shown == 4


def test_the_cache_is_where_the_page_says(followed):
    """The named folder is filled by the run, with names of digests, and emptied by the page's command."""
    printed, folder = followed
    kept = printed[-1][3]
    assert kept
    assert all(re.fullmatch(r"[a-z]+-[0-9a-f]{64}\.arrays", name) for name in kept)
    assert {name.split("-")[0] for name in kept} == {"mesh", "flexibility"}
    assert not (folder / "kept").exists()


def test_results_do_not_depend_on_the_number_of_threads(tmp_path):
    """Stiffness, displacements and Prandtl's or the warping function are equal to 1e-12 with one thread and two."""
    found = []
    for number in (1, 2):
        path = tmp_path / f"{number}.npz"
        status, told = ran(tmp_path, sys.executable, "-c", SOLVED, str(path), RAYON_NUM_THREADS=str(number))
        assert status == 0, told
        with np.load(path) as file:
            found.append(dict(file))
        assert found[-1].pop("n_threads") == number
    one, two = found
    assert set(one) == {"values", "indices", "displacements", "function"}
    for name, values in one.items():
        assert np.abs(two[name] - values).max() <= 1e-12 * np.abs(values).max(), name
    assert len(one["values"]) > 20_000
