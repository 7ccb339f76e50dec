"""How much memory may be used, and what is refused beyond it."""

import os
import re
import subprocess
import sys

import numpy as np
import pytest

from flangeway.elements import Lagrange, Virtual
from flangeway.errors import FlangewayError, InputError, OutOfMemoryError
from flangeway.geometry import square
from flangeway.materials import Elastic
from flangeway.mesh import triangulate
from flangeway.problems import Body, Elasticity, Torsion, fixed
from flangeway.solve import CondensedBodies, SparseBodies, SurfaceNodes, solve_elasticity, solve_torsion
from flangeway.solve.linear import cholesky, ldlt
from flangeway.space import Space
from flangeway.space.core_limits import BYTES_AN_ENTRY
from flangeway.system import memory_limits as memory
from flangeway.system.memory_limits import memory_left, peak_memory_bytes, refuse_beyond_memory

LIMIT = "FLANGEWAY_MEMORY_GB"
MEASURED = """
import gc, re
import numpy as np
from flangeway.elements import Lagrange
from flangeway.geometry import square
from flangeway.materials import Elastic
from flangeway.system import memory_limits as memory
from flangeway.mesh import triangulate
from flangeway.problems import Elasticity, fixed
from flangeway.solve.constraints import find_constraints
from flangeway.solve.linear import cholesky
from flangeway.space import Space

def resident(name):
    return 1024 * int(re.search(name + r":\\s+(\\d+)", open("/proc/self/status").read())[1])

def begun():
    gc.collect()
    open("/proc/self/clear_refs", "w").write("5")  # the peak counts from here
    return resident("VmRSS")

space = Space(triangulate(square(1.0), size=0.016), Lagrange(2))
problem = Elasticity(space, Elastic(210e3, 0.3), supports=[fixed("left")])
constraints = find_constraints(problem)
list(space.batches())
before = begun()
matrix = problem.stiffness()
entries = sum((2 * len(batch.dofs)) ** 2 * len(batch.cells) for batch in space.batches())
print((resident("VmHWM") - before) / entries)
matrix = matrix.restricted(constraints.kept)
before = begun()
factor = cholesky(matrix, constraints.groups)
print((resident("VmHWM") - before) / factor.peak_bytes)
"""
STARVED = """
import re, resource, sys
import numpy as np
import flangeway.solve, gmsh
from flangeway._core import Cholesky, Ldlt, Pattern
from flangeway.space import Space

def starve(megabytes):
    used = int(re.search(r"VmSize:\\s+(\\d+)", open("/proc/self/status").read())[1]) * 1024
    resource.setrlimit(resource.RLIMIT_AS, (used + megabytes * 2**20, -1))

n = 400_000
pointers, numbers = np.arange(n + 1, dtype=np.int64), np.arange(n, dtype=np.int32)
cells = numbers.reshape(4, -1).copy()
matrices = [np.ones((4, 4, n // 4))]
pattern = Pattern(n, [cells])
factor = Cholesky(pointers, numbers, np.ones(n), numbers, numbers[:0])
columns = np.ones((n, 40))
works = {
    "pattern": lambda: Pattern(n, [cells]),
    "scatter": lambda: pattern.scatter(matrices),
    "cholesky": lambda: Cholesky(pointers, numbers, np.ones(n), numbers, numbers[:0]),
    "trailing": lambda: Cholesky(pointers, numbers, np.ones(n), numbers, numbers[:5000]),
    "ldlt": lambda: Ldlt(pointers, numbers, np.ones(n), numbers),
    "solve": lambda: factor.solve(columns),
}
for megabytes in (4, 20, 70):
    starve(megabytes)
    for name, work in works.items():
        try:
            work()
        except MemoryError as error:
            print(megabytes, name, "refused")
        else:
            print(megabytes, name, "done")
"""


def ran(code):
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=False, timeout=300)
    assert done.returncode == 0, done.stderr[-2000:]
    return done.stdout.splitlines()


needs_linux = pytest.mark.skipif(sys.platform != "linux", reason="memory is measured and limited as Linux does")


@pytest.fixture(scope="module")
def space():
    return Space(triangulate(square(1.0), size=0.2), Lagrange(2))


@needs_linux
def test_estimates_are_near_what_is_measured():
    """The memory of the assembly and of the factorisation is estimated to 30 % of the peak that is measured."""
    a_entry, of_factor = map(float, ran(MEASURED))
    assert 0.7 <= a_entry / BYTES_AN_ENTRY <= 1.3
    assert 0.7 <= of_factor <= 1.3


@needs_linux
def test_the_core_never_ends_the_process():
    """Where the address space ends, each piece of the core's work raises a MemoryError instead of aborting."""
    lines = ran(STARVED)
    assert len(lines) == 18
    assert [line for line in lines if line.startswith("4 ")] == [
        f"4 {name} refused" for name in ("pattern", "scatter", "cholesky", "trailing", "ldlt", "solve")
    ]


def test_each_work_is_refused_with_what_it_needs(space, monkeypatch):
    """Assembly, factorisations, torsion and elasticity are refused beyond the limit, with sizes and advice."""
    problem = Elasticity(space, Elastic(1.0, 0.3), supports=[fixed("left")])
    body = Body("block", space.mesh, Lagrange(2), Elastic(1.0, 0.3), held="left")
    matrix, groups = body.stiffness, body.free_nodes
    surface = SurfaceNodes(body, np.unique(space.mesh.edge_set("right")).astype(np.int32))
    # what is in use already leaves nothing
    monkeypatch.setenv(LIMIT, "0.001")
    works = {
        "the assembly of the stiffness": lambda: solve_elasticity(problem),
        f"the factorisation of {matrix.n} unknowns": lambda: cholesky(matrix, groups),
        f"the factorisation of {matrix.n} unknowns ": lambda: ldlt(matrix, groups),
        f"the factorisation of {matrix.n} unknowns  ": lambda: SparseBodies([surface]),
        "the flexibility of a surface": lambda: CondensedBodies([surface]),
        "the assembly of the stiffness ": lambda: solve_torsion(Torsion(Space(space.mesh, Virtual(3)))),
    }
    for begin, work in works.items():
        with pytest.raises(OutOfMemoryError) as caught:
            work()
        told = str(caught.value)
        assert told.startswith(begin.strip())
        assert re.search(r"needs about [\d.]+ [MG]B of memory\n  allowed: 0 MB, what FLANGEWAY_MEMORY_GB", told)
        assert "what to do: make the elements larger" in told
        assert isinstance(caught.value, MemoryError)
        assert isinstance(caught.value, FlangewayError)


def test_the_limit_counts_what_is_in_use(monkeypatch):
    """The variable limits what the process holds in all: what is left is the limit less what is in use."""
    monkeypatch.setenv(LIMIT, "1000")
    left = memory_left()
    assert 0 < peak_memory_bytes() < 1e11
    assert 1e12 - peak_memory_bytes() <= left < 1e12
    refuse_beyond_memory("work", left // 2)
    with pytest.raises(OutOfMemoryError, match="work, which needs about 2e\\+03 GB"):
        refuse_beyond_memory("work", 2 * 10**12)


@pytest.mark.parametrize("given", ["none", "-1", "0", "nan", "inf"])
def test_a_limit_that_is_no_number_is_refused(monkeypatch, given):
    """A limit that is not a positive number is an InputError that names the variable."""
    monkeypatch.setenv(LIMIT, given)
    with pytest.raises(InputError, match=f"{LIMIT}={given}\n  allowed: a positive number of gigabytes"):
        memory_left()


@pytest.mark.parametrize(
    ("table", "files", "left"),
    [
        ("0::/a/b", {"a/memory.max": "500", "a/memory.current": "200", "a/b/memory.max": "max"}, [300]),
        ("0::/", {"memory.max": "500", "memory.current": "200", "memory.stat": "x 1\ninactive_file 50"}, [350]),
        ("4:memory:/a", {"memory/a/memory.limit_in_bytes": "9", "memory/a/memory.usage_in_bytes": "4"}, [5]),
        ("4:cpu:/a", {"memory/a/memory.limit_in_bytes": "9", "memory/a/memory.usage_in_bytes": "4"}, []),
        ("0::/", {}, []),
    ],
)
def test_control_groups_limit(tmp_path, table, files, left):
    """Limits of control groups of both versions count, those of parents too, and cached files do not."""
    (tmp_path / "proc/self").mkdir(parents=True)
    (tmp_path / "proc/self/cgroup").write_text(table + "\n")
    for name, text in files.items():
        path = tmp_path / "sys/fs/cgroup" / name
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_text(text + "\n")
    assert list(memory._control_groups(tmp_path)) == left


@pytest.mark.parametrize("place", ["before", "behind", "joined"])
def test_the_option_limits_a_run(call, tmp_path, place):
    """With --memory a run that needs more ends with status 1, a sentence with both sizes, and no file."""
    run, option = ["run", "cook", "--set", "bodies.membrane.size_mm=0.5", "--out", "results"], ["--memory", "0.05"]
    arguments = {"before": option + run, "behind": run + option, "joined": [*run, "--memory=0.05"]}[place]
    status, out, err = call(*arguments)
    assert status == 1
    assert "flangeway: out of memory, nothing was written: the assembly of the stiffness, which needs about" in err
    assert "or --memory (0.05 GB) leaves beside" in err
    assert out == ""
    assert list(tmp_path.iterdir()) == []
    assert LIMIT not in os.environ


def test_a_run_tells_its_peak(call, tmp_path):
    """The summary holds the most memory that the process has held."""
    status, _, err = call("section", "136RE", "--size", "20", "--order", "1", "--out", "results")
    assert status == 0, err
    found = re.search(r'"peak_memory_MB": ([\d.]+)', next((tmp_path / "results").glob("*.json")).read_text())
    assert found
    assert 10.0 < float(found[1]) <= peak_memory_bytes() / 1e6
