"""Rails on their supports in three dimensions, as problems: stiffnesses, bases, and what is refused."""

import numpy as np
import pytest

from flangeway.elements import Lagrange, Virtual
from flangeway.errors import InputError
from flangeway.geometry import circle
from flangeway.materials import Elastic
from flangeway.mesh import dual, triangulate
from flangeway.problems import Elasticity, Harmonic
from flangeway.railway.profiles.bundled import rail
from flangeway.railway.wheelset.supported_rail import RailSupport, rail_problem
from flangeway.space import Space

STEEL = Elastic(210e3, 0.3)
SUPPORT = RailSupport(spacing_mm=500.0, vertical_kN_per_mm=30.0, lateral_kN_per_mm=20.0, roll_kNm_per_rad=90.0)


@pytest.mark.parametrize("element", [Lagrange(2), Virtual(1)])
def test_a_rigid_motion_meets_the_stiffness_of_the_seats_over_their_spacing(element) -> None:
    """Translations and the rotation about the middle of the base have the given energies to 1e-9."""
    mesh = triangulate(rail("60E1").outline, size=15.0)
    space = Space(dual(mesh) if isinstance(element, Virtual) else mesh, element)
    problem = rail_problem(space, STEEL, "base", SUPPORT)
    dofs = np.zeros((4, space.n_dofs, 3))
    free = Harmonic(Elasticity(space, STEEL))
    nodes = space.nodes
    dofs[0, :, 0] = dofs[1, :, 1] = dofs[2, :, 2] = 1.0
    dofs[3, :, 0], dofs[3, :, 1] = -nodes[:, 1], nodes[:, 0]
    for motion, expected in zip(dofs, (20e3 / 500.0, 30e3 / 500.0, 10e3 / 500.0, 90e6 / 500.0), strict=True):
        energies = [motion.ravel() @ each.stiffness(0.0).times(motion.ravel()) for each in (problem, free)]
        assert energies[0] == pytest.approx(expected, rel=1e-9)
        assert abs(energies[1]) < 1e-6 * expected


def test_the_support_covers_the_whole_base() -> None:
    """A base of some of its edges, or of others too, and a round body without one are refused."""
    mesh = triangulate(rail("136RE").outline, size=15.0)
    base = mesh.edge_set("base")
    for edges in (base[1:], np.unique(np.vstack((base, mesh.boundary_edges[:40])), axis=0)):
        with pytest.raises(InputError, match="as the base of"):
            rail_problem(Space(mesh.with_edge_set("some", edges), Lagrange(1)), STEEL, "some", SUPPORT)
    bar = triangulate(circle(10.0), size=3.0)
    bar = bar.with_edge_set("low", bar.boundary_edges[:2])
    with pytest.raises(InputError, match="flat base"):
        rail_problem(Space(bar, Lagrange(1)), STEEL, "low", SUPPORT)


def test_sleepers_lie_about_the_wheel() -> None:
    """The last sleeper is behind the wheel by its position, as many are before as behind, none if continuous."""
    places = RailSupport(position=0.25, n_sleepers=5).sleepers_mm
    np.testing.assert_allclose(places, [-1350.0, -750.0, -150.0, 450.0, 1050.0])
    np.testing.assert_allclose(RailSupport(position=0.75, n_sleepers=5).sleepers_mm, -places[::-1])
    assert len(RailSupport("continuous").sleepers_mm) == 0
