"""Triangulation with Gmsh: geometry kept, sizes kept, and what is refused."""

import importlib
import math
import signal
import subprocess
import sys
from concurrent.futures import ThreadPoolExecutor

import numpy as np
import pytest

from flangeway.errors import InputError
from flangeway.geometry import Arc, Line, Outline, circle, polygon, rectangle, square
from flangeway.mesh import Refinement, check, triangulate
from tests.geometry.test_outline import HALF_DISC


def spacings(mesh, name):
    return np.hypot(*np.diff(mesh.points[mesh.chain(name)], axis=0).T)


@pytest.mark.parametrize("n", [10, 14, 20, 40])
def test_a_square_gets_the_edges_asked_for(n):
    """A size of 1/n makes n equal edges a side, and the triangles fill the square."""
    mesh = triangulate(square(1.0), size=1.0 / n)
    check(mesh, region_area=1.0)
    for name in ("bottom", "right", "top", "left"):
        np.testing.assert_allclose(spacings(mesh, name), 1.0 / n, rtol=1e-9)


@pytest.mark.parametrize("n_arcs", [2, 3])
def test_arcs_of_half_a_turn_and_more_are_meshed(n_arcs):
    """Arcs that Gmsh does not take in one piece are halved, and keep one name."""
    long_arc = [Arc((1.0, 0.0), (0.0, 1.0), (0.0, 0.0), False), Line((0.0, 1.0), (1.0, 0.0))]
    for outline in (circle(1.0, n_arcs=n_arcs), Outline.from_segments(long_arc, ["arc", "chord"])):
        mesh = triangulate(outline, size=0.2)
        check(mesh, region_area=outline.area, area_tolerance=0.02)
        assert set(mesh.edge_sets) == set(outline.names)


@pytest.mark.parametrize("size", [0.02, 0.03, 0.007])
def test_spacing_inside_a_refinement_is_uniform_and_as_asked(size):
    """Along the refined part of the boundary edges are equal to the size within 10 %."""
    part = HALF_DISC.part(["round"]).sampled(spacing=0.01)
    part = part[np.abs(part[:, 0]) < 0.5]
    mesh = triangulate(HALF_DISC, size=0.3, refinements=[Refinement(part, size, 0.15)])
    points = mesh.points[mesh.chain("round")]
    inside = np.all(np.abs([points[1:, 0], points[:-1, 0]]) < 0.5 - size, axis=0)
    lengths = spacings(mesh, "round")[inside]
    assert len(lengths) > 0.9 / size - 4
    np.testing.assert_allclose(lengths, size, rtol=0.1)
    assert lengths.max() / lengths.min() < 1.05


@pytest.mark.parametrize("growth", [0.05, 0.3, 1.0, 3.0])
def test_spacing_does_not_depend_on_the_growth(growth):
    """On a refined straight side edges have the size asked for, however fast it grows beside it."""
    line = Refinement([(-1.5, -2.0), (0.3127, -2.0), (1.7, -2.0)], 0.05, growth)
    mesh = triangulate(square(4.0), size=0.5, refinements=[line])
    inside = np.abs(mesh.points[mesh.chain("bottom"), 0][:-1]) < 1.3
    np.testing.assert_allclose(spacings(mesh, "bottom")[inside], 0.05, rtol=0.02)


def test_triangles_follow_the_target_size():
    """Inside, the edges' lengths are about the local size: most within a factor of 1.5."""
    spot = Refinement([(0.5, 0.5)], 0.01, 0.2)
    mesh = triangulate(square(4.0), size=0.3, refinements=[spot])
    edges = mesh.points[mesh.edges]
    lengths = np.hypot(*(edges[:, 1] - edges[:, 0]).T)
    distances = np.hypot(*(edges.mean(axis=1) - spot.points).T)
    ratio = lengths / np.minimum(0.3, spot.size + spot.growth * distances)
    assert np.median(ratio) == pytest.approx(1.0, abs=0.15)
    assert np.mean((ratio > 1 / 1.5) & (ratio < 1.5)) > 0.95


def test_holes_have_the_body_on_their_outside():
    """A hole takes its area away and its named boundary has the body on the left."""
    hole = rectangle(1.0, 1.0, (1.0, 0.5))
    mesh = triangulate(square(4.0), size=0.3, holes=[hole, circle(0.4, (-1.0, -1.0))])
    region = 16.0 - 1.0 - 0.16 * math.pi
    check(mesh, region_area=region, area_tolerance=3e-3)
    ring = mesh.points[mesh.chain("circle")]
    x, y = ring.T
    assert 0.5 * np.sum(x[:-1] * y[1:] - x[1:] * y[:-1]) == pytest.approx(-0.16 * math.pi, rel=0.1)


def test_a_callers_gmsh_is_left_as_it_was():
    """Within a caller's Gmsh the mesh is the same; his model, options and handlers stay."""
    alone = triangulate(HALF_DISC, size=0.2)
    handler = signal.getsignal(signal.SIGINT)
    gmsh = importlib.import_module("gmsh")
    assert not gmsh.isInitialized()
    gmsh.initialize(interruptible=False)
    try:
        gmsh.option.setNumber("General.Terminal", 0)
        gmsh.option.setNumber("Mesh.Algorithm", 8)
        gmsh.model.add("mine")
        gmsh.model.geo.addPoint(1.0, 2.0, 3.0)
        gmsh.model.geo.synchronize()
        within = triangulate(HALF_DISC, size=0.2)
        assert gmsh.isInitialized()
        assert gmsh.model.getCurrent() == "mine"
        assert gmsh.model.getEntities() == [(0, 1)]
        assert gmsh.option.getNumber("Mesh.Algorithm") == 8
        assert "flangeway" not in gmsh.model.list()
    finally:
        gmsh.finalize()
    assert np.array_equal(within.points, alone.points)
    assert signal.getsignal(signal.SIGINT) is handler


def test_threads_may_triangulate():
    """Away from the main thread, where Python allows no signal handlers, the mesh is the same."""
    with ThreadPoolExecutor(2) as pool:
        meshes = list(pool.map(lambda size: triangulate(HALF_DISC, size=size), [0.2, 0.3, 0.2]))
    assert np.array_equal(meshes[0].points, meshes[2].points)
    assert np.array_equal(meshes[0].points, triangulate(HALF_DISC, size=0.2).points)
    assert meshes[1].n_cells < meshes[0].n_cells


def test_gmsh_is_silent(capfd):
    """Nothing is printed, neither by Python nor by the library."""
    triangulate(square(1.0), size=0.2)
    out, err = capfd.readouterr()
    assert (out, err) == ("", "")


def test_gmsh_is_imported_only_when_it_is_needed():
    """Importing the package of meshes imports neither Gmsh nor meshio."""
    code = "import sys, flangeway.mesh; print('gmsh' in sys.modules, 'meshio' in sys.modules)"
    run = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert run.stdout.split() == ["False", "False"]


def near(points=((0.0, 0.0),), size=0.1, growth=0.1):
    return Refinement(points, size, growth)


@pytest.mark.parametrize(
    ("make", "word"),
    [
        *((lambda s=s: triangulate(square(1.0), size=s), "size") for s in (0.0, -1.0, math.nan, math.inf, 1.01, 1e-5)),
        (lambda: near(size=0.0), "size"),
        (lambda: near(growth=0.0), "growth"),
        (lambda: near(points=np.zeros((0, 2))), "point"),
        (lambda: triangulate(square(4.0), size=0.3, holes=[circle(0.5), circle(0.5, (0.7, 0.0))]), "keep apart"),
    ],
)
def test_what_makes_no_mesh_is_refused(make, word):
    """Sizes that are none, larger than the body or far too small, quickly; wrong refinements; holes as by `Region`."""
    with pytest.raises(InputError, match=word):
        make()


@pytest.mark.parametrize("scale", [1e-4, 1e5])
def test_units_do_not_matter(scale):
    """A body in other units gets the same number of points and the same mesh, scaled."""
    shape = np.array([(0, 0), (3, 0), (3, 1), (1, 1), (1, 2), (0, 2)], dtype=float)
    usual = triangulate(polygon(shape), size=0.2)
    other = triangulate(polygon(scale * shape), size=0.2 * scale)
    check(other, region_area=4.0 * scale**2)
    assert other.n_points == pytest.approx(usual.n_points, rel=0.03)
