"""Stresses in an I section under all forces at once (sectionproperties)."""

import numpy as np
from gallery_drawing import draw
from matplotlib.figure import Figure

from flangeway import Lagrange, Space, triangulate
from flangeway.forms import BeamSection
from flangeway.geometry import i_section


def main() -> Figure:
    """IPE 200 (EN 10365): 28.5 cm2, 1943 cm4; the plastic modulus is 220.6 cm3."""
    outline = i_section(200.0, 100.0, 8.5, 5.6, 12.0)
    mesh = triangulate(outline, size=3.0)
    section = BeamSection(Space(mesh, Lagrange(2)), poisson=0.3)
    area, inertia, modulus = section.axial / 1e2, section.bending[0] / 1e4, section.plastic()[1] / 1e3
    print(f"area {area:.2f} cm2, second moment {inertia:.0f} cm4, plastic modulus {modulus:.1f} cm3")
    assert abs(inertia / 1943.0 - 1.0) < 5e-3
    assert abs(modulus / 220.6 - 1.0) < 5e-3
    stress = section.stresses(mesh.cell_centroids, force=50e3, moments=(20e6, 0.0), shear=(0.0, 60e3), torque=1e5)
    return draw(mesh, np.sqrt(stress[:, 0] ** 2 + 3.0 * (stress[:, 1:] ** 2).sum(axis=1)), colours="turbo")
