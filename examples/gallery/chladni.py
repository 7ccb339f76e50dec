"""Chladni's figures: vibration of a free square plate."""

import numpy as np
from gallery_drawing import draw
from matplotlib.figure import Figure

from flangeway import triangulate
from flangeway.forms import Plate, modes
from flangeway.geometry import square
from flangeway.mesh import dual


def main() -> Figure:
    """Behind three rigid motions the lowest frequency is 13.49 sqrt(D / m) / a^2 for Poisson's ratio 0.3."""
    mesh = dual(triangulate(square(1.0), size=0.06))
    plate = Plate(mesh, 3, poisson=0.3)
    squares, shapes = modes(plate, plate.stiffness(), plate.mass(), 9)
    frequencies = np.sqrt(np.maximum(squares, 0.0))
    print("frequencies", *np.round(frequencies, 2))
    assert frequencies[2] < 0.1
    assert abs(frequencies[3] - 13.49) < 0.05
    shape = shapes[5][0 : 3 * mesh.n_points : 3]
    return draw(mesh, np.abs(shape) < 0.15 * np.abs(shape).max(), colours="gray")
