"""Large meshes: bounded before they are made, refused beyond the memory, announced, and ended by Ctrl-C."""

import os
import re
import signal
import subprocess
import sys
import time
from pathlib import Path

import numpy as np
import pytest

from flangeway.errors import InputError, OutOfMemoryError
from flangeway.geometry import Arc, Line, Outline, Placement, Region, Section, circle, polygon, rectangle, square
from flangeway.mesh import (
    Refinement,
    dual,
    gmsh_mesher,
    long_meshes_reported,
    rectangle_grid,
    refined,
    triangulate,
    triangulate_section,
)
from flangeway.mesh.gmsh_mesher import mesh_bound
from flangeway.system.memory_limits import refuse_beyond_memory
from flangeway.system.own_process import in_own_process
from tests.processes import started

BOTTOM = [(-0.5, -0.5), (0.5, -0.5)]
AROUND = [*BOTTOM, (0.5, 0.5), (-0.5, 0.5), (-0.5, -0.5)]
HALF_DISC = Outline.from_segments(
    [Line((-1.0, 0.0), (1.0, 0.0)), Arc((1.0, 0.0), (-1.0, 0.0), (0.0, 0.0), True)], ["cut", "round"]
)
RIM = HALF_DISC.segments[1].point(np.linspace(0.3, 0.7, 20))
TEETH = [
    (x + dx, y)
    for x in np.arange(0.9, 0.0, -0.1).tolist()
    for dx, y in ((0.1, 1.0), (0.05, 1.0), (0.05, 0.1), (0.0, 0.1))
]
COMB = polygon([(0.0, 0.0), (1.0, 0.0), *TEETH])
SHAPES = {
    "a square": (square(1.0), 0.02, [], ()),
    "a disc with a hole": (circle(1.0), 0.04, [], (circle(0.4, (0.2, 0.1)),)),
    "a strip five elements wide": (rectangle(50.0, 0.5), 0.1, [], ()),
    "a comb": (COMB, 0.01, [], ()),
    "a side": (square(1.0), 0.05, [Refinement(BOTTOM, 0.002, 0.15)], ()),
    "all sides": (square(1.0), 0.1, [Refinement(AROUND, 0.005, 0.3)], ()),
    "the round of a half disc": (HALF_DISC, 0.2, [Refinement(RIM, 0.004, 0.13)], ()),
    "a place inside": (square(1.0), 0.1, [Refinement([(0.1, 0.2)], 1e-5, 0.08)], ()),
    "a corner": (square(1.0), 0.1, [Refinement([(0.5, 0.5)], 1e-4, 0.1)], ()),
    "places on each other": (square(1.0), 0.1, [Refinement([(0.1, 0.2)], 1e-4, 0.1)] * 3, ()),
    "a line beyond the body": (square(1.0), 0.1, [Refinement([(0.0, -0.5), (0.0, -9.0)], 0.01, 0.1)], ()),
}
MEASURED = """
import os, re
import gmsh
from flangeway.geometry import Region, Section, rectangle, square
from flangeway.mesh import Refinement, triangulate, triangulate_section
from flangeway.mesh.gmsh_mesher import mesh_bound

def resident(name):
    return 1024 * int(re.search(name + r":\\s+(\\d+)", open("/proc/self/status").read())[1])

def compare(expected, make):
    if os.fork():
        return os.wait()
    triangulate_section(two, size=0.3)  # loads what all need
    before = resident("VmRSS")
    open("/proc/self/clear_refs", "w").write("5")  # the peak counts from here
    make()
    print(expected.n_bytes / (resident("VmHWM") - before), flush=True)
    os._exit(0)

whole, side = square(1.0), Refinement([(-0.5, -0.5), (0.5, -0.5)], 0.0007, 0.15)
two = Section({"left": Region(rectangle(1.0, 1.0)), "right": Region(rectangle(1.0, 1.0, (1.0, 0.0)))})
for size, fine in [(0.014, ()), (0.009, ()), (0.006, ()), (0.05, (side,))]:
    expected = mesh_bound([Region(whole)], size, fine)
    compare(expected, lambda: triangulate(whole, size=size, refinements=fine))
compare(mesh_bound(two.regions, 0.012), lambda: triangulate_section(two, size=0.012))
"""
NEEDS_LINUX = pytest.mark.skipif(sys.platform != "linux", reason="memory and processes are looked at as in Linux")


def same(first, second):
    """Whether two meshes are equal to the last bit."""
    arrays = [[mesh.points, mesh.cell_offsets, mesh.cell_points] for mesh in (first, second)]
    for sets in ("cell_sets", "edge_sets"):
        one, other = getattr(first, sets), getattr(second, sets)
        if list(one) != list(other):
            return False
        arrays[0] += one.values()
        arrays[1] += other.values()
    return all(a.dtype == b.dtype and np.array_equal(a, b) for a, b in zip(*arrays, strict=True))


@pytest.mark.parametrize(("outline", "size", "refinements", "holes"), SHAPES.values(), ids=SHAPES)
def test_the_bound_is_above_the_truth(outline, size, refinements, holes):
    """No mesh has more triangles than the bound, within 20 %; of one size the bound is the number, to 20 %.

    Refinements raise it up to 4.5 times each; a part of their polyline that is beyond the body does it still more.
    """
    n_triangles = triangulate(outline, size=size, refinements=refinements, holes=holes).n_cells
    bound = mesh_bound([Region(outline, holes)], size, refinements).n_triangles
    beyond = max((np.abs(refinement.points).max() for refinement in refinements), default=0.0) > 1.0
    assert 0.8 * n_triangles < bound
    assert beyond or bound < (4.5 * len(refinements) or 1.2) * n_triangles


def test_a_growth_of_one_is_bounded():
    """Where the size grows faster than triangles can, the bound is above the number still."""
    line = Refinement(BOTTOM, 0.002, 1.0)
    made = triangulate(square(1.0), size=0.1, refinements=[line]).n_cells
    assert 0.8 < mesh_bound([Region(square(1.0))], 0.1, [line]).n_triangles / made < 2.0


@pytest.mark.ci
@NEEDS_LINUX
def test_the_memory_is_near_what_is_measured():
    """Gmsh's memory is estimated to 20 % of the measured peak, at three sizes and for sections.

    With a refinement along a side up to 2.5 times of it.
    """
    done = subprocess.run([sys.executable, "-c", MEASURED], capture_output=True, text=True, check=True, timeout=300)
    ratios = [float(line) for line in done.stdout.splitlines()]
    assert 1.0 < ratios.pop(3) < 2.5
    assert ratios == pytest.approx([1.0] * 4, abs=0.2)


def no_gmsh():
    raise AssertionError("Gmsh was called")


@pytest.fixture
def little_memory(monkeypatch):
    """Leave nothing to work that is compared, and let no work reach Gmsh."""
    monkeypatch.setenv("FLANGEWAY_MEMORY_GB", "0.001")
    monkeypatch.setattr(gmsh_mesher, "load_gmsh", no_gmsh)


HALVES = Section({"left": Region(rectangle(1.0, 1.0)), "right": Region(rectangle(1.0, 1.0, (1.0, 0.0)))})
GRID = rectangle_grid(1.0, 1.0, 120, 120)
WORKS = {
    "the triangulation into up to about 26,000 triangles": lambda: triangulate(square(1.0), size=0.01),
    "the triangulation into up to about 53,000 triangles": lambda: triangulate_section(HALVES, size=0.01),
    "the dual polygons of 28,800 triangles": lambda: dual(GRID),
    "the refinement of 28,800 cells": lambda: refined(GRID),
    "the refinement of 9,999 cells": lambda: refined(GRID, np.arange(9999)),
    "a grid of 400 by 300 squares": lambda: rectangle_grid(1.0, 1.0, 400, 300),
}


@pytest.mark.parametrize(("reported", "work"), WORKS.items(), ids=WORKS)
def test_what_needs_more_memory_is_refused_before_it_begins(reported, work, little_memory):
    """Beyond the limit Gmsh is not called: the error says what, how much it needs, what is left, and what to do."""
    with pytest.raises(OutOfMemoryError) as caught:
        work()
    message = str(caught.value)
    assert re.match(rf"{reported}, which needs about [\d.]+ MB of memory\n  allowed: 0 MB, what FLANGEWAY_M", message)
    assert "what to do: make the elements larger" in message


def test_small_meshes_are_made_under_any_limit(monkeypatch):
    """What needs less than 10 MB is not compared with the limit."""
    monkeypatch.setenv("FLANGEWAY_MEMORY_GB", "0.001")
    assert dual(triangulate(square(1.0), size=0.1)).n_cells > 100


FAR_TOO_LARGE = {
    "triangles": (square(1.0), 1e-4, []),
    "edges along one side": (rectangle(1e5, 0.1), 0.1, []),
    "edges along one side ": (square(1.0), 0.1, [Refinement(BOTTOM, 8e-6, 0.3)]),
    "points along refinements": (square(1.0), 0.1, [Refinement(BOTTOM, 5e-6, 3.0)] * 9),
    "triangles ": (square(1.0), 0.1, [Refinement(BOTTOM, 1e-5, 0.01)]),
    "triangles  ": (square(1.0), 0.1, [Refinement([(0.0, 0.0), (0.1, 0.1)], 1e-6, 0.05)]),
}


@pytest.mark.parametrize(("kind", "given"), FAR_TOO_LARGE.items(), ids=FAR_TOO_LARGE)
def test_what_would_take_hours_is_refused(kind, given, monkeypatch):
    """Too many triangles, edges along a side or points of refinements are reported at once, with the number allowed."""
    monkeypatch.setattr(gmsh_mesher, "load_gmsh", no_gmsh)
    outline, size, refinements = given
    with pytest.raises(InputError) as caught:
        triangulate(outline, size=size, refinements=refinements)
    assert re.search(rf"about [\d.e+]+ {kind.strip()}$", caught.value.given)
    assert re.fullmatch(rf"sizes that make up to \d+000 {kind.strip()}", caught.value.allowed)


def test_a_process_of_its_own_makes_the_same_mesh(monkeypatch):
    """A long triangulation is reported, and made by another process, the same to the last bit; a short one is not."""
    reports = []

    def both():
        with long_meshes_reported(reports.append):
            hole = square(0.3).transformed(Placement(0.3, (3.0, 2.0)))
            fine = Refinement([(3.0, 3.0)], 0.02, 0.2)
            yield triangulate(circle(1.0, (3.0, 2.0)), size=0.2, refinements=[fine], holes=[hole])
            yield triangulate_section(HALVES, size=0.1)

    here = list(both())
    assert reports == []
    monkeypatch.setattr(gmsh_mesher, "REPORT_AFTER_S", 0.0)
    monkeypatch.setattr(gmsh_mesher, "load_gmsh", no_gmsh)  # of this process
    for mine, other in zip(here, both(), strict=True):
        assert same(mine, other)
    assert len(reports) == 2
    assert all(
        re.fullmatch(r"triangulating: up to about [\d,]+ triangles, which can take about 0 seconds", line)
        for line in reports
    )


def test_errors_come_back_from_the_other_process():
    """Errors have the same message; a defect and an end without an answer are reported as what they are."""
    with pytest.raises(InputError) as caught:
        in_own_process(rectangle, -1.0, 1.0)
    with pytest.raises(InputError) as here:
        rectangle(-1.0, 1.0)
    assert str(caught.value) == str(here.value)
    with pytest.raises(OutOfMemoryError) as lacking:
        in_own_process(refuse_beyond_memory, "the work", 10**18)
    assert str(lacking.value).startswith("the work, which needs about 1e+09 GB of memory\n  allowed: ")
    assert str(lacking.value).count("allowed: ") == 1
    with pytest.raises(RuntimeError, match="TypeError"):
        in_own_process(square, "wide", "high", "deep", "long")
    with pytest.raises(InputError, match="its process ended with status 3"):
        in_own_process(os._exit, 3)


@pytest.mark.skipif(sys.platform == "win32", reason="signals are those of other systems")
def test_a_killed_process_is_reported(interruptible):
    """If the system kills the process, memory has ended; if the terminal interrupts it, this one is interrupted."""
    with pytest.raises(OutOfMemoryError, match="killed"):
        in_own_process(signal.raise_signal, signal.SIGKILL)
    with pytest.raises(KeyboardInterrupt):
        in_own_process(signal.raise_signal, signal.SIGINT)


def children(process):
    """Numbers of the processes that a process has begun."""
    return Path(f"/proc/{process.pid}/task/{process.pid}/children").read_text().split()


def working(folder, width):
    """Begin a check that meshes for a long time; return it when its other process works, with that one's number."""
    process = started(folder, "check", "contact-patch", "--set", f"bodies.upper.rectangle.width_mm={width}")
    end = time.monotonic() + 300.0
    while not (begun := children(process)) and process.poll() is None and time.monotonic() < end:
        time.sleep(0.05)
    time.sleep(0.5)
    return process, begun[0]


@pytest.mark.ci
@NEEDS_LINUX
@pytest.mark.parametrize("with_signal", [signal.SIGINT, signal.SIGKILL])
def test_an_end_while_gmsh_works_is_prompt(with_signal, tmp_path, interruptible):
    """Ctrl-C ends a long triangulation at once with status 130 and the usual words; a kill ends both processes."""
    process, other = working(tmp_path, 1e5)
    try:
        process.send_signal(with_signal)
        begun = time.monotonic()
        out, err = process.communicate(timeout=300)
    finally:  # whatever happens, no process and no open file is left to the next test
        process.kill()
        process.communicate()
    assert time.monotonic() - begun < 100.0  # the triangulation takes about 7 minutes
    interrupted = with_signal == signal.SIGINT
    assert process.returncode == (130 if interrupted else -signal.SIGKILL)
    reported = "flangeway: interrupted; nothing was written\n"
    assert err.endswith(reported if interrupted else "")
    assert err.count("flangeway: ") == interrupted
    assert "Traceback" not in err
    assert out == ""
    assert list(tmp_path.iterdir()) == []
    end = time.monotonic() + 100.0
    while Path(f"/proc/{other}").exists() and "Z" not in Path(f"/proc/{other}/stat").read_text():
        assert time.monotonic() < end, "the other process still works"
        time.sleep(0.05)
