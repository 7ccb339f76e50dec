"""A steel roller on a steel block: mesh both, press them together by a force, and see how far the roller sinks.

Run it with ``python examples/first_contact.py``. Lengths are in mm, forces in N per mm of length, stresses in MPa.
"""

from flangeway.contact import Contact, Surface, press
from flangeway.elements import Lagrange
from flangeway.geometry import half_disc, rectangle
from flangeway.materials import Elastic
from flangeway.mesh import Refinement, triangulate
from flangeway.problems import Body

FORCE = 2000.0


def main() -> None:
    """Press the roller on the block, and print the force and the displacement."""
    # shapes, with small elements where they touch
    drawn_roller, drawn_block = half_disc(50.0, centre=(0.0, 50.0)), rectangle(100.0, 60.0, centre=(0.0, -30.0))
    zone = [(-1.5, 0.0), (1.5, 0.0)]
    roller_mesh = triangulate(drawn_roller, size=8.0, refinements=[Refinement(zone, 0.08, 0.25)])
    block_mesh = triangulate(drawn_block, size=8.0, refinements=[Refinement(zone, 0.09, 0.25)])

    # bodies, held along a side, and the surfaces where they may touch
    steel, element = Elastic(young=210e3, poisson=0.3), Lagrange(2)
    roller = Body("roller", roller_mesh, element, steel, held="cut").part
    block = Body("block", block_mesh, element, steel, held="bottom").part
    near = (-1.5, -0.5, 1.5, 0.5)
    contact = Contact(Surface(roller, "rim", drawn_roller, within=near), Surface(block, "top", within=near))

    # the force acts on the held side of the roller, which moves along y only
    solution = press([contact], loads={roller: (None, -FORCE, None)})
    print(solution.status.message)
    print(solution.table)
    print(f"the roller moves by {solution.placement(roller).translation[1]:.5f} mm")
    assert solution.status.converged
    assert abs(solution.forces[0, 1] / FORCE - 1.0) < 1e-6


if __name__ == "__main__":
    main()
