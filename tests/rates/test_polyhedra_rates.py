"""Rates of convergence on polyhedra: Lame's hollow ball and an inclusion that is hot."""

import numpy as np
import pytest

from flangeway.elements import Virtual
from flangeway.materials import Elastic
from flangeway.problems import Elasticity, Pressure
from flangeway.solve import solve_elasticity
from flangeway.space import Space
from flangeway_studies.polyhedra import SYMMETRY, ball_octant, radial


@pytest.mark.parametrize(("poisson", "inner", "outer"), [(0.3, 0.8, 0.3), (0.4999, 0.8571142857, 0.2143285714)])
def test_a_hollow_ball_under_pressure_converges_with_the_square_of_the_cells(poisson, inner, outer):
    """Radial displacements of Lame's ball (radii 1 and 2, E = 1) have a quarter of the error on cells of half the size.

    Also where the material is nearly incompressible: nothing locks.
    """
    errors = []
    for n in (3, 6):
        mesh = ball_octant(np.linspace(1.0, 2.0, n + 1), n)
        material, load = Elastic(1.0, poisson), Pressure("inside", 1.0)
        solution = solve_elasticity(Elasticity(Space(mesh, Virtual(1)), material, loads=[load], supports=SYMMETRY))
        errors.append(max(abs(radial(solution, 1.0) / inner - 1.0), abs(radial(solution, 2.0) / outer - 1.0)))
    assert errors[1] < 0.016
    assert 1.7 < np.log2(errors[0] / errors[1]) < 2.5
