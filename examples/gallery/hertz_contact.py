"""A half disc of polygons is pressed on a block: contact and Hertz's pressure (scikit-fem, example 4)."""

import numpy as np
from gallery_drawing import curves
from matplotlib.figure import Figure

import flangeway as fw
from flangeway.contact import Contact, Multiplier, SegmentToSegment, Surface, press
from flangeway.exact import LineContact
from flangeway.geometry import Arc, Line, Outline, Placement, rectangle
from flangeway.mesh import Refinement, dual, triangulate
from flangeway.problems import Body, Part


def main() -> Figure:
    """The largest pressure is Hertz's to 5 %."""
    arc, cut = Arc((-1.0, 1.0), (1.0, 1.0), (0.0, 1.0), True), Line((1.0, 1.0), (-1.0, 1.0))
    disc, steel = Outline.from_segments([arc, cut], ["arc", "cut"]), fw.Elastic(210e3, 0.3)
    fine, parts = Refinement(np.array([[-0.06, 0.0], [0.06, 0.0]]), 0.003, 0.3), []
    for name, outline, held in (("disc", disc, "cut"), ("block", rectangle(2.0, 1.0, (0.0, -0.5)), "bottom")):
        mesh = dual(triangulate(outline, size=0.25, refinements=[fine]))
        parts.append(Part(name, Body(name, mesh, fw.Virtual(2), steel, held)))
    surfaces = []
    for part, side in zip(parts, ("arc", "top"), strict=True):
        edges = part.body.space.mesh.edge_set(side)
        ends = part.body.space.mesh.points[edges]
        surfaces.append(Surface(part, edges[(np.hypot(*np.moveaxis(ends, 2, 0)) < 0.1).all(axis=1)]))
    contact = Contact(surfaces[0], surfaces[1], SegmentToSegment(), Multiplier())
    found = press([contact], motion={parts[0]: Placement(0.0, (0.0, -3e-3))})
    (patch,) = fw.post.pressure_patches(found.system, found.state)
    hertz = LineContact(float(found.forces[0, 1]), 1.0, steel.plane_modulus / 2.0)
    print(f"largest pressure {patch.pressures.max():.0f} MPa, Hertz {hertz.max_pressure:.0f} MPa")
    assert abs(patch.pressures.max() / hertz.max_pressure - 1.0) < 0.05
    x = np.linspace(-hertz.half_width, hertz.half_width, 50)
    theory = hertz.max_pressure * np.sqrt(1.0 - (x / hertz.half_width) ** 2)
    return curves((patch.points[:, 0], patch.pressures, "computed"), (x, theory, "Hertz"), axes=("x", "pressure"))
