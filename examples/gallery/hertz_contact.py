"""A half disc of polygons is pressed on a block: contact and Hertz's pressure (scikit-fem, example 4)."""

import numpy as np
from gallery_drawing import curves
from matplotlib.figure import Figure

import flangeway as fw
from flangeway.contact import Contact, Surface, press
from flangeway.exact import LineContact
from flangeway.geometry import Placement, half_disc, rectangle
from flangeway.mesh import Refinement, dual, triangulate
from flangeway.problems import Body


def main() -> Figure:
    """The largest pressure is Hertz's to 5 %."""
    disc, block = half_disc(1.0, (0.0, 1.0)), rectangle(2.0, 1.0, (0.0, -0.5))
    fine, steel = Refinement([(-0.06, 0.0), (0.06, 0.0)], 0.003, 0.3), fw.Elastic(210e3, 0.3)
    surfaces = []
    for name, outline, held, side in (("disc", disc, "cut", "rim"), ("block", block, "bottom", "top")):
        mesh = dual(triangulate(outline, size=0.25, refinements=[fine]))
        part = Body(name, mesh, fw.Virtual(2), steel, held).part
        surfaces.append(Surface(part, side, within=(-0.1, -0.1, 0.1, 0.1)))
    contact = Contact(surfaces[0], surfaces[1])
    found = press([contact], motion={surfaces[0].part: Placement(0.0, (0.0, -3e-3))})
    (patch,) = fw.post.pressure_patches(found.system, found.state)
    hertz = LineContact(float(found.forces[0, 1]), 1.0, steel.plane_modulus / 2.0)
    print(f"largest pressure {patch.pressures.max():.0f} MPa, Hertz {hertz.max_pressure:.0f} MPa")
    assert abs(patch.pressures.max() / hertz.max_pressure - 1.0) < 0.05
    x = np.linspace(-hertz.half_width, hertz.half_width, 50)
    theory = hertz.max_pressure * np.sqrt(1.0 - (x / hertz.half_width) ** 2)
    return curves((patch.points[:, 0], patch.pressures, "computed"), (x, theory, "Hertz"), axes=("x", "pressure"))
