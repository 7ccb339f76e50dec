"""A cantilever of polygons under a shear load (VEMLAB's first example)."""

from gallery_drawing import draw
from matplotlib.figure import Figure

import flangeway as fw
from flangeway.geometry import rectangle
from flangeway.mesh import voronoi
from flangeway.problems import Elasticity, Traction, fixed


def main() -> Figure:
    """The tip sinks by F L^3 / 3 EI, and by its shear F L / (5/6 G A)."""
    length, height, young, poisson, force = 8.0, 2.0, 1e4, 0.3, 10.0
    mesh = voronoi(rectangle(length, height), 150)
    space, steel = fw.Space(mesh, fw.Virtual(2)), fw.Elastic(young, poisson, "plane_stress")
    loads = [Traction("right", (0.0, -force / height))]
    solution = fw.solve_elasticity(Elasticity(space, steel, loads=loads, supports=[fixed("left")]))
    tip = solution.displacements[space.boundary_dofs("right"), 1].mean()
    beam = (
        force * length**3 / (3.0 * young * height**3 / 12.0) + 2.4 * (1.0 + poisson) * force * length / young / height
    )
    print(f"the tip sinks by {-tip:.4f}, Timoshenko's beam by {beam:.4f}")
    assert abs(-tip / beam - 1.0) < 0.02
    stress = fw.post.cell_stresses(solution.problem, solution.displacements).components[:, 0]
    return draw(mesh, stress, moved=5.0 * solution.displacements, colours="RdBu_r")
