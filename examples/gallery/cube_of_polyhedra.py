"""A cube of Voronoi cells in space is pulled: virtual elements on polyhedra give a uniform stress exactly."""

import numpy as np
from matplotlib.figure import Figure

import flangeway as fw
from flangeway.mesh import PolyhedralMesh
from flangeway.problems import PrescribedDisplacement, Traction


def main() -> Figure:
    """Displacements are linear, and their stretch is that of Hooke's law, to 1e-9."""
    seeds = np.random.default_rng(4).uniform(0.02, 0.98, (60, 3))
    mesh = PolyhedralMesh.voronoi(seeds, (0.0, 0.0, 0.0, 1.0, 1.0, 1.0))
    symmetric = [PrescribedDisplacement(f"{axis}-", **{axis: 0.0}) for axis in "xyz"]
    steel = fw.Elastic(210e3, 0.3)
    pulled = [Traction("z+", (0.0, 0.0, 210.0))]
    cube = fw.Elasticity(fw.Space(mesh, fw.Virtual(1)), steel, supports=symmetric, loads=pulled)
    found = fw.solve_elasticity(cube)
    exact = cube.space.nodes * (-0.3e-3, -0.3e-3, 1e-3)  # 210 MPa over 210 GPa
    error = np.abs(found.displacements - exact).max() / 1e-3
    print(f"{mesh.n_cells} cells with {mesh.n_faces} faces; largest error {error:.0e} of the stretch")
    assert error < 1e-9
    return mesh.plot()
