"""Cook's membrane of a compressible neo-Hooke material; the published one is in `flangeway reproduce forms`."""

import numpy as np

from flangeway.elements import Lagrange, Virtual
from flangeway.materials import Elastic, NeoHooke
from flangeway.problems import Elasticity, Traction, fixed
from flangeway.solve import solve_nonlinear
from flangeway.space import Space
from studies.forms import mapped, membrane

CELLS = (
    ("triangles", 16, Lagrange(2)),
    ("duals", 10, Virtual(2)),
    ("not convex", 7, Virtual(2)),
    ("duals", 6, Virtual(3)),
)


def test_kinds_of_cells_agree_on_a_membrane_at_finite_strain():
    """With G = 40 and Lame's constant 100, kinds of cells agree to 0.5 % on a displacement of 9.7; forces balance."""
    rubber, found = NeoHooke(Elastic(800.0 / 7.0, 5.0 / 14.0)), []
    for kind, n, element in CELLS:
        loads, supports = [Traction("right", (0.0, 4.0))], [fixed("left")]
        problem = Elasticity(
            Space(mapped(kind, n, n, membrane), element), rubber.elastic, loads=loads, supports=supports
        )
        (solution,) = solve_nonlinear(problem, rubber)
        assert solution.status.converged
        np.testing.assert_allclose(solution.nodal_forces.sum(axis=0), [0.0, -64.0], atol=4e-5)
        found.append(solution.displacements[problem.node_at((48.0, 60.0)), 1])
    assert np.ptp(found) < 5e-3 * np.mean(found)
