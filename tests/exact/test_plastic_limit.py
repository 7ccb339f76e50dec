"""A perfectly plastic thick cylinder beside the solution of R. Hill (1950, The Mathematical Theory of Plasticity)."""

import numpy as np
import pytest

from flangeway.elements import Lagrange, Virtual
from flangeway.geometry import Arc, Line, Outline
from flangeway.materials import Elastic, J2Plasticity
from flangeway.mesh import dual, triangulate
from flangeway.problems import Elasticity, PrescribedDisplacement, Pressure
from flangeway.solve import StepSettings, solve_nonlinear
from flangeway.space import Space

INNER, OUTER, STEEL, YIELD = 100.0, 200.0, Elastic(210e3, 0.3), 240.0
SHEAR_YIELD = YIELD / np.sqrt(3.0)
LIMIT = 2.0 * SHEAR_YIELD * np.log(OUTER / INNER)


@pytest.fixture(scope="module")
def triangles():
    lines = (
        Line((INNER, 0.0), (OUTER, 0.0)),
        Arc((OUTER, 0.0), (0.0, OUTER), (0.0, 0.0), counter_clockwise=True),
        Line((0.0, OUTER), (0.0, INNER)),
        Arc((0.0, INNER), (INNER, 0.0), (0.0, 0.0), counter_clockwise=False),
    )
    outline = Outline(lines, ("bottom", "outer", "left", "inner"))
    return triangulate(outline, size=25.0, outline=outline)


@pytest.mark.parametrize(
    ("element", "beyond"),
    [(Lagrange(2), 1.01), (Virtual(1), 1.02), pytest.param(Virtual(2), 1.01, marks=pytest.mark.ci)],
)
def test_a_thick_cylinder_carries_its_limit_pressure_and_no_more(triangles, element, beyond):
    """At 93 % the rim moves by 2 (1 - nu^2) k c^2 / (E b) within 3 %; beyond the limit no pressure is carried.

    The elastic and plastic parts meet at the radius c, ``p = k (2 ln(c / a) + 1 - c^2 / b^2)``.
    """
    mesh = triangles if isinstance(element, Lagrange) else dual(triangles)
    supports = [PrescribedDisplacement("bottom", y=0.0), PrescribedDisplacement("left", x=0.0)]
    problem = Elasticity(Space(mesh, element), STEEL, loads=[Pressure("inner", 1.0)], supports=supports)
    steps = solve_nonlinear(
        problem, J2Plasticity(STEEL, YIELD), [0.93 * LIMIT, beyond * LIMIT], steps=StepSettings(smallest=0.25)
    )
    assert [step.status.converged for step in steps] == [True, False]
    radii = np.linspace(INNER, OUTER, 10001)
    pressures = SHEAR_YIELD * (2.0 * np.log(radii / INNER) + 1.0 - radii**2 / OUTER**2)
    radius = np.interp(0.93 * LIMIT, pressures, radii)
    exact = 2.0 * (1.0 - 0.3**2) * SHEAR_YIELD * radius**2 / (STEEL.young * OUTER)
    assert steps[0].displacements[problem.node_at((OUTER, 0.0)), 0] == pytest.approx(exact, rel=0.03)
    assert steps[0].status.stabilisation < 0.02
