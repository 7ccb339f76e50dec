"""Vibration of an elastic bracket that is held at one side (scikit-fem, example 21)."""

import numpy as np
from gallery_drawing import draw
from matplotlib.figure import Figure

from flangeway import Elastic, Space, Virtual
from flangeway.forms import mass, modes, stiffness
from flangeway.geometry import rectangle
from flangeway.mesh import voronoi


def main() -> Figure:
    """The lowest frequency of the strip is that of Euler's beam, 1.875^2 sqrt(EI / m L^4), less its shear."""
    length, height, young = 10.0, 1.0, 1.0
    mesh = voronoi(rectangle(length, height), 240)
    space = Space(mesh, Virtual(2))
    tensor = Elastic(young, 0.0, "plane_stress").stiffness
    squares, shapes = modes(space, stiffness(space, tensor), mass(space, np.eye(2)), 4, space.boundary_dofs("left"))
    beam = 1.8751**2 * np.sqrt(young * height**2 / 12.0) / length**2
    print("frequencies", *np.round(np.sqrt(squares), 5), f"Euler's beam {beam:.5f}")
    assert 0.97 < np.sqrt(squares[0]) / beam < 1.0
    shape = shapes[1] / np.abs(shapes[1]).max()
    return draw(mesh, np.hypot(*shape[: mesh.n_points].T), moved=shape)
