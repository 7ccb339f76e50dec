"""Contact laws of one's own beside the root of the equation of two columns, and steps that halving does not help."""

from dataclasses import dataclass
from types import SimpleNamespace

import numpy as np
import pytest
from scipy.optimize import brentq

from flangeway.contact import Contact, Enforcement, SegmentToSegment, Surface, press
from flangeway.elements import Lagrange
from flangeway.geometry import Placement
from flangeway.materials import Elastic
from flangeway.mesh import rectangle_grid
from flangeway.post import pressure_patches
from flangeway.problems import Body, Part
from flangeway.solve import Status, follow

YOUNG, HEIGHT, APPROACH = 210e3, 20.0, 0.01


@dataclass(frozen=True)
class Stiffening(Enforcement):
    """Pressure ``a g + b g^3``."""

    a: float
    b: float

    def compliances(self, pairs):
        """Derivative of the penetration by the force."""
        g = np.maximum(-pairs.gaps, 0.0)
        return 1.0 / (pairs.areas * (self.a + 3.0 * self.b * g**2))

    def offsets(self, pairs):
        """Penetration at which the tangent has no force."""
        g = np.maximum(-pairs.gaps, 0.0)
        return 2.0 * self.b * g**3 / (self.a + 3.0 * self.b * g**2)


def column(name, n_edges, held, bottom):
    mesh = rectangle_grid(40.0, HEIGHT, n_edges, 2, origin=(0.0, bottom))
    supports = {(float(x), float(y)): "xy" for x, y in mesh.points if y == held}
    part = Part(name, Body(name, mesh, Lagrange(1), Elastic(YOUNG, 0.0), supports))
    edges = mesh.boundary_edges
    return part, Surface(part, edges[(mesh.points[edges][:, :, 1] == 0.0).all(axis=1)])


@pytest.mark.parametrize("law", [Stiffening(2e3, 1e8), Stiffening(2e3, 1e12), Stiffening(20.0, 1e10)])
def test_a_stiffening_law_converges_quadratically_to_the_root_of_two_columns(law):
    """``E (d - g) / (2 h) = a g + b g^3`` gives the pressure to 1e-9, if the law is far stiffer too."""
    (upper, below), (_, above) = column("upper", 4, HEIGHT, 0.0), column("lower", 3, -HEIGHT, -HEIGHT)
    contact = Contact(below, above, SegmentToSegment(), law)
    solution = press([contact], {upper: Placement(0.0, (0.0, -APPROACH))})
    g = brentq(lambda g: YOUNG * (APPROACH - g) / 2.0 / HEIGHT - law.a * g - law.b * g**3, 0.0, APPROACH, xtol=1e-16)
    assert solution.status.converged
    np.testing.assert_allclose(
        pressure_patches(solution.system, solution.state)[0].pressures, law.a * g + law.b * g**3, rtol=1e-9
    )
    residuals = [iteration.residual for iteration in solution.state.history]
    assert len(residuals) <= 14
    assert residuals[-1] < 1e-4 * residuals[-2]


def test_steps_are_not_halved_for_iterations_that_halving_does_not_save():
    """A problem that needs 20 iterations at any length of the step is solved in four steps at most."""
    lengths = []

    def solve_at(position, _):
        lengths.append(position)
        failed = position > 0.5 and len(lengths) == 1
        return SimpleNamespace(status=Status(not failed, "", 20), nodal_forces=np.zeros((1, 2)))

    assert follow(solve_at, None).status.converged
    assert len(lengths) <= 4


@pytest.mark.parametrize(("falls", "converges"), [(False, False), (True, True)])
def test_steps_are_halved_as_long_as_that_lowers_the_residual(falls, converges):
    """A step that fails with one residual at any length is tried five times; if the residual falls, until it works."""
    lengths = []

    def solve_at(position, reached):
        length = position - (reached.position if reached else 0.0)
        lengths.append(length)
        status = Status(length <= 0.01, "", 20, residual=length if falls else 1.0)
        return SimpleNamespace(status=status, nodal_forces=np.zeros((1, 2)), position=position)

    assert follow(solve_at, None).status.converged == converges
    assert converges or len(lengths) == 5
