"""Contact measured from the drawn curve instead of the straight edges of the mesh."""

import numpy as np
import pytest

from flangeway.contact import Contact, Multiplier, SegmentToSegment, Surface, press
from flangeway.elements import DiagonalStabilisation, Lagrange, Virtual
from flangeway.errors import InputError
from flangeway.geometry import Arc, Contour, Line, Outline, Placement
from flangeway.materials import Elastic
from flangeway.mesh import Refinement, dual, triangulate
from flangeway.post import pressure_patches
from flangeway.problems import Body, Part

RADIUS = 8.0


def half_disc(kind: str, size: float) -> tuple[Part, np.ndarray, Outline]:
    """A half disc that stands on the origin, the edges near it, and its outline."""
    arc = Arc((-RADIUS, RADIUS), (RADIUS, RADIUS), (0.0, RADIUS), counter_clockwise=True)
    outline = Outline.from_segments([arc, Line((RADIUS, RADIUS), (-RADIUS, RADIUS))], ["arc", "cut"])
    zone = np.array([[-0.7, 0.0], [0.7, 0.0]])
    mesh = triangulate(outline, size=1.0, refinements=(Refinement(zone, size, 0.25),))
    element = Lagrange(2)
    if kind == "polygons":
        mesh, element = dual(mesh), Virtual(2, DiagonalStabilisation())
    edges = mesh.edge_set("arc")
    near = (np.abs(mesh.points[edges][..., 0]) < 0.7).all(axis=1) & (mesh.points[edges][..., 1] < RADIUS).all(axis=1)
    return Part("disc", Body("disc", mesh, element, Elastic(21e3, 0.3), "cut")), edges[near], outline


def test_a_curve_takes_the_corners_of_the_mesh_out_of_the_pressure() -> None:
    """Two discs of polygons: with the curve the pressure is Hertz's within 1 % of p0, without it not within 4 %."""
    part, edges, outline = half_disc("polygons", 0.03)
    other, other_edges, _ = half_disc("polygons", 0.034)
    below = Part("below", other.body, Placement(np.pi))
    worst = []
    for curve in (outline, None):
        surfaces = Surface(part, edges, curve=curve), Surface(below, other_edges, curve=curve)
        contact = Contact(*surfaces, SegmentToSegment(), Multiplier())
        solution = press([contact], {part: Placement(0.0, (0.0, -0.05))})
        assert solution.status.converged
        force = solution.forces[0, 1]
        modulus = 21e3 / (1.0 - 0.3**2) / 2.0
        half_width = np.sqrt(4.0 * force * RADIUS / 2.0 / (np.pi * modulus))
        peak = 2.0 * force / (np.pi * half_width)
        (patch,) = pressure_patches(solution.system, solution.state)
        # Hertz's x is that of the undeformed surface
        nodes = surfaces[0].nodes[solution.state.linearisation.pairs[0].nodes[solution.state.forces > 0.0]]
        x = part.body.space.nodes[nodes, 0]
        inside = np.abs(x) < half_width - 0.06
        exact = peak * np.sqrt(1.0 - (x[inside] / half_width) ** 2)
        worst.append(abs(patch.pressures[inside] - exact).max() / peak)
    assert worst[0] < 0.01
    assert worst[1] > 0.04


def test_a_curve_elsewhere_is_refused() -> None:
    """A curve that is not the meshed outline is refused with the node that is far from it."""
    part, edges, _ = half_disc("triangles", 0.1)
    line = Contour((Line((-1.0, -1.0), (1.0, -1.0)),), ("line",))
    with pytest.raises(InputError, match=r"is 1\.\d+ from its curve"):
        Surface(part, edges, curve=line)
