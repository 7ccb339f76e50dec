"""Contact of bodies of nonlinear materials: a block under a hard plate is the block with its top pushed down."""

import numpy as np
import pytest

from flangeway.contact import Contact, Multiplier, SegmentToSegment, Surface, press_nonlinear
from flangeway.elements import Lagrange, Virtual
from flangeway.geometry import Placement
from flangeway.materials import Elastic, J2Plasticity, NeoHooke
from flangeway.mesh import dual, rectangle_grid
from flangeway.problems import Body, Elasticity, Part, PrescribedDisplacement, fixed
from flangeway.solve import solve_nonlinear
from flangeway.space import Space

SOFT = Elastic(10.0, 0.3)


def pressed(mesh, element, material, depths):
    """A block under a hard plate that moves down by depths: the solutions."""
    block = Part("block", Body("block", mesh, element, SOFT, "bottom"))
    wide = rectangle_grid(2.0, 1.0, 5, 3)
    plate = Part("plate", Body("plate", wide, Lagrange(1), Elastic(1e8, 0.3), "top"), Placement(0.0, (-0.5, 1.0)))
    surfaces = Surface(block, mesh.edge_sets["top"]), Surface(plate, wide.edge_sets["bottom"])
    contact = Contact(*surfaces, SegmentToSegment(), Multiplier())
    start = None
    for depth in depths:
        motion = {plate: Placement(0.0, (0.0, -depth))}
        found = press_nonlinear([contact], motion, {block: material}, start=start)
        start = found.states
        yield found.contact, found.displacements[block], found.converged


@pytest.mark.parametrize(
    ("material", "depths", "make", "element"),
    [
        (NeoHooke(SOFT), [0.1], dual, Virtual(1)),
        (J2Plasticity(SOFT, 0.2, isotropic=1.0), [0.04, 0.035], lambda mesh: mesh, Lagrange(2)),
        (J2Plasticity(SOFT, 0.2, kinematic=1.0), [0.04, 0.035], dual, Virtual(3)),
    ],
)
def test_a_block_under_a_hard_plate(material, depths, make, element):
    """Displacements are those of the block alone to 0.3 %, the force to 1e-5: segments touch on average."""
    mesh = make(rectangle_grid(1.0, 1.0, 4, 4))
    supports = [fixed("bottom"), PrescribedDisplacement("top", y=-depths[0])]
    factors = [depth / depths[0] for depth in depths]
    path = solve_nonlinear(Elasticity(Space(mesh, element), SOFT, supports=supports), material, factors)
    top = np.unique(Space(mesh, element).edge_nodes(mesh.edge_set("top")))
    for alone, (contact, field, converged) in zip(path, pressed(mesh, element, material, depths), strict=True):
        assert converged
        np.testing.assert_allclose(field, alone.displacements, atol=3e-3 * depths[0])
        force = alone.nodal_forces[top, 1].sum()
        assert contact.resultants[0, 1, 1] == pytest.approx(-force, rel=1e-5)  # that of the block on the plate
