"""Prandtl's function of a square bar in torsion, and its torsion constant."""

from gallery_drawing import draw
from matplotlib.figure import Figure

import flangeway as fw
from flangeway.geometry import square
from flangeway.mesh import dual, triangulate
from flangeway.post import section_constants


def main() -> Figure:
    """The torsion constant is 0.140577 a^4 (Timoshenko and Goodier, art. 109)."""
    mesh = dual(triangulate(square(1.0), size=0.08))
    constants = section_constants(fw.Space(mesh, fw.Virtual(2)))
    print(f"torsion constant {constants.torsion_constant:.6f}")
    assert abs(constants.torsion_constant - 0.140577) < 1e-5
    return draw(mesh, constants.prandtl.function[: mesh.n_points])
