"""A wire with its insulation: two conductivities and cooling at the surface (scikit-fem, example 17)."""

import numpy as np
from gallery_drawing import draw
from matplotlib.figure import Figure

from flangeway import Lagrange, Space
from flangeway.forms import Field, mass, solve, stiffness
from flangeway.geometry import Region, Section, circle
from flangeway.mesh import curved, triangulate_section

RADII, CONDUCTIVITY, COOLING, HEAT = (2.0, 3.0), {"wire": 101.0, "insulation": 11.0}, 5.0, 5.0


def main() -> Figure:
    """The temperature in the middle is that of the closed form of a wire heated by a current."""
    inner, outer = (circle(radius) for radius in RADII)
    section = Section({"wire": Region(inner), "insulation": Region(outer, (inner,))})
    mesh = curved(triangulate_section(section, size=0.3), section)
    space = Space(mesh, Lagrange(2))
    matrix = stiffness(space, CONDUCTIVITY) + COOLING * sum(mass(space, on=name) for name in mesh.edge_sets)
    heated = np.zeros(mesh.n_cells)
    heated[mesh.cell_set("wire")] = HEAT
    source = mass(space, np.maximum(heated, 1e-12)) @ np.ones(space.n_dofs)
    u = solve(matrix, source)
    a, b = RADII
    exact = HEAT * a**2 * (1.0 / (2.0 * b * COOLING) + np.log(b / a) / (2.0 * CONDUCTIVITY["insulation"]))
    exact += HEAT * a**2 / (4.0 * CONDUCTIVITY["wire"])
    middle = float(Field(space, u).at([[0.0, 0.0]])[0])
    print(f"temperature in the middle {middle:.6f}, exact {exact:.6f}")
    assert abs(middle - exact) < 1e-5 * exact
    return draw(mesh, u[: mesh.n_points], colours="inferno")
