"""Boundaries that get each other's nodes, of random bodies: the same in either order, each point once."""

import numpy as np
import pytest
from scipy.spatial import cKDTree

from flangeway.contact import Surface
from flangeway.contact.node_to_segment import matching_nodes
from flangeway.elements import Virtual
from flangeway.errors import InputError
from flangeway.geometry import Placement, Region, circle, polygon, rectangle
from flangeway.materials import Elastic
from flangeway.mesh import dual, match_boundaries, triangulate
from flangeway.mesh.structured import rectangle_grid
from flangeway.problems import Body, Part


def boxes(rng):
    """Two boxes, one above the other, with gap, overlap or neither, and with or without their vertical sides."""
    width, other_width = rng.uniform(1.0, 4.0, 2) if rng.random() < 0.7 else (2.0, 2.0)
    shift, gap = rng.choice([0.0, rng.uniform(-0.9, 0.9)]), rng.choice([0.0, 0.02, -0.02])
    counts = rng.integers(2, 7, 4).tolist()
    upper = rectangle_grid(width, 1.0, counts[0], counts[1]).placed(Placement(0.0, (shift, 1.0 + gap)))
    lower = rectangle_grid(other_width, 1.0, counts[2], counts[3])
    sides = [["left", "right"], [], ["left"]][int(rng.integers(3))]
    return upper, ["bottom", *sides], lower, ["top", *sides]


def slanted(rng):
    """Two triangulated quadrilaterals that share a slanted side, with everything around it in the sets."""
    top, foot = rng.uniform(0.5, 1.5, 2)
    one = polygon([(0, 0), (1, 0), (1, top), (0, foot)], ("a", "b", "c", "d"))
    other = polygon([(0, foot), (1, top), (1, 2.5), (0, 2.5)], ("a", "b", "c", "d"))
    sizes = rng.uniform(0.15, 0.4, 2)
    return (
        dual(triangulate(one, size=sizes[0])), ["b", "c", "d"], dual(triangulate(other, size=sizes[1])), ["d", "a", "b"]
    )  # fmt: skip


def shaft(rng):
    """A disc in a ring with a gap, meshes of any sizes."""
    sizes, gap = rng.uniform(0.2, 0.5, 2), rng.choice([0.0, 1e-3, 0.05])
    hub = Region(rectangle(4.0, 4.0), (circle(1.0 + gap, n_arcs=5),))
    disc = triangulate(circle(1.0), size=sizes[0])
    return disc, ["circle"], triangulate(hub, size=sizes[1]), ["circle"]


def roller(rng):
    """A disc above a box, all of their boundaries."""
    disc = triangulate(circle(1.0, (rng.uniform(-0.5, 0.5), 1.01)), size=rng.uniform(0.2, 0.4))
    box = rectangle_grid(5.0, 1.0, int(rng.integers(6, 20)), 2).placed(Placement(0.0, (-2.5, -1.0)))
    return disc, ["circle"], box, ["left", "top", "right", "bottom"]


def points_of(mesh):
    return mesh.points[np.unique(mesh.boundary_edges)]


def same_points(one, other):
    return len(one) == len(other) and cKDTree(one).query(other)[0].max() < 1e-6


@pytest.mark.parametrize("seed", range(60))
def test_order_does_not_matter(seed):
    """Both orders give the same nodes, no two at one place; again gives none; node-to-node finds partners both ways."""
    rng = np.random.default_rng(seed)
    one, names, other, other_names = [boxes, boxes, slanted, shaft, roller][seed % 5](rng)
    turn = Placement(float(rng.uniform(0.0, 6.0)), (float(rng.uniform(-9, 9)), 3.0))
    one, other = one.placed(turn), other.placed(turn)
    edges, other_edges = (
        np.vstack([mesh.edge_set(n) for n in sets]) for mesh, sets in ((one, names), (other, other_names))
    )
    first, second = match_boundaries(one, edges, other, other_edges)
    again, back = match_boundaries(other, other_edges, one, edges)
    assert same_points(points_of(first), points_of(back))
    assert same_points(points_of(second), points_of(again))
    for mesh in (first, second):
        assert not cKDTree(mesh.points).query_pairs(1e-6)
    one, other = (mesh.with_edge_set("touching", edges_) for mesh, edges_ in ((one, edges), (other, other_edges)))
    first, second = match_boundaries(one, "touching", other, "touching")
    assert [m.n_points for m in match_boundaries(second, "touching", first, "touching")] == [
        second.n_points,
        first.n_points,
    ]
    parts = [
        Part(name, Body(name, mesh, Virtual(1), Elastic(1.0, 0.3))) for name, mesh in (("a", first), ("b", second))
    ]
    surfaces = [Surface(part, mesh.edge_set("touching")) for part, mesh in zip(parts, (first, second), strict=True)]
    one_way, other_way = matching_nodes(*surfaces), matching_nodes(*surfaces[::-1])
    assert len(one_way.nodes) == len(other_way.nodes) > 1


def test_bodies_back_to_back_do_not_face():
    """The top of a lower box and the bottom of one below it, seen through both bodies, are not opposite each other."""
    upper = rectangle_grid(2.0, 1.0, 3, 2).placed(Placement(0.0, (0.0, 1.5)))
    lower = rectangle_grid(2.0, 1.0, 4, 2)
    with pytest.raises(InputError, match="opposite"):
        match_boundaries(upper, "top", lower, "bottom")
