"""A clamped plate under pressure, with an element of class C1 (scikit-fem, example 2; dune-vem's biharmonic)."""

from gallery_drawing import draw
from matplotlib.figure import Figure

from flangeway import triangulate
from flangeway.forms import Plate, solve
from flangeway.geometry import square
from flangeway.mesh import dual


def main() -> Figure:
    """The deflection of the middle of the clamped square is 0.001265 p a^4 / D (Timoshenko, table 35: 0.00126)."""
    mesh = dual(triangulate(square(1.0), size=0.08))
    plate = Plate(mesh, 3)
    w = solve(plate.stiffness(), plate.load(1.0), plate.boundary_dofs("clamped"))
    largest = plate.at_quadrature(w, 6)[2].max()
    print(f"largest deflection {largest:.6f}")
    assert abs(largest - 0.001265) < 5e-6
    return draw(mesh, w[0 : 3 * mesh.n_points : 3])
