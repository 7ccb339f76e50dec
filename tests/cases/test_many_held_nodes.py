"""Bodies held at very many nodes."""

import tracemalloc

from flangeway import Body, Elastic, Lagrange
from flangeway.mesh import rectangle_grid


def test_many_held_nodes_take_little_memory():
    """Whether 4,000 held nodes let a body slide is found in less than 10 MB: not by a matrix of nodes by nodes."""
    mesh = rectangle_grid(4000.0, 1.0, 4000, 1)
    body = Body("strip", mesh, Lagrange(1), Elastic(210e3, 0.3), {"bottom": "y"})
    assert body.supported.any()
    tracemalloc.start()
    try:
        assert body.freedom.axes == "x"
        assert tracemalloc.get_traced_memory()[1] < 10e6
    finally:
        tracemalloc.stop()
