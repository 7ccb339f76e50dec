"""Tension of a plate with a hole, on curved edges (VEMLAB; FElupe's example of the same name)."""

import numpy as np
from gallery_drawing import draw
from matplotlib.figure import Figure

import flangeway as fw
from flangeway.geometry import circle, square
from flangeway.mesh import Refinement, dual, triangulate
from flangeway.post import corner_stresses
from flangeway.problems import Elasticity, PrescribedDisplacement
from flangeway_studies.hole import PlateWithHole


def main() -> Figure:
    """Kirsch's displacements along the rim: the stress beside the hole is three times the tension."""
    hole, outer = circle(1.0), square(8.0)
    triangles = triangulate(
        outer, size=0.6, refinements=[Refinement(hole.sampled(spacing=0.2), 0.12, 0.3)], holes=[hole]
    )
    mesh = dual(triangles, outline=[outer, hole])
    exact, steel = PlateWithHole(1.0, 100.0), fw.Elastic(210e3, 0.3)
    kolosov = 3.0 - 4.0 * 0.3

    sides = [
        PrescribedDisplacement(
            side,
            x=lambda p: exact.displacements(p, steel.shear_modulus, kolosov)[:, 0],
            y=lambda p: exact.displacements(p, steel.shear_modulus, kolosov)[:, 1],
        )
        for side in outer.names
    ]
    solution = fw.solve_elasticity(Elasticity(fw.Space(mesh, fw.Virtual(2)), steel, supports=sides))
    stress = corner_stresses(solution.problem, solution.displacements).components[:, 0]
    print(f"largest stress {stress.max():.1f}, Kirsch 300")
    assert abs(stress.max() / 300.0 - 1.0) < 0.03
    means = np.add.reduceat(stress, mesh.cell_offsets[:-1]) / mesh.cell_sizes
    return draw(mesh, means, colours="turbo")
