"""Contact of bodies of nonlinear materials: a block under a hard plate is the block with its top pushed down."""

import numpy as np
import pytest

from flangeway.contact import Contact, Multiplier, SegmentToSegment, Surface
from flangeway.contact.press_nonlinear import press_nonlinear
from flangeway.elements import Lagrange, Virtual
from flangeway.geometry import Placement
from flangeway.materials import Elastic, J2Plasticity, NeoHooke
from flangeway.mesh import dual, rectangle_grid
from flangeway.problems import Body, Elasticity, Part, PrescribedDisplacement, fixed
from flangeway.solve import solve_nonlinear
from flangeway.space import Space

SOFT = Elastic(10.0, 0.3)


@pytest.mark.parametrize(
    ("material", "depth", "make", "element"),
    [
        (NeoHooke(SOFT), 0.1, dual, Virtual(1)),
        (J2Plasticity(SOFT, 0.2, isotropic=1.0), 0.04, lambda mesh: mesh, Lagrange(2)),
    ],
)
def test_a_block_under_a_hard_plate(material, depth, make, element):
    """Displacements are those of the block alone to 0.3 %, the force to 1e-5: segments touch on average."""
    mesh = make(rectangle_grid(1.0, 1.0, 4, 4))
    block = Part("block", Body("block", mesh, element, SOFT, "bottom"))
    wide = rectangle_grid(2.0, 1.0, 5, 3)
    plate = Part("plate", Body("plate", wide, Lagrange(1), Elastic(1e8, 0.3), "top"), Placement(0.0, (-0.5, 1.0)))
    surfaces = Surface(block, mesh.edge_sets["top"]), Surface(plate, wide.edge_sets["bottom"])
    contact = Contact(*surfaces, SegmentToSegment(), Multiplier())
    solution, fields, converged = press_nonlinear([contact], {plate: Placement(0.0, (0.0, -depth))}, {block: material})
    assert converged
    supports = [fixed("bottom"), PrescribedDisplacement("top", y=-depth)]
    (alone,) = solve_nonlinear(Elasticity(Space(mesh, element), SOFT, supports=supports), material)
    np.testing.assert_allclose(fields[block], alone.displacements, atol=3e-3 * depth)
    top = np.unique(Space(mesh, element).edge_nodes(mesh.edge_set("top")))
    force = alone.nodal_forces[top, 1].sum()
    assert solution.resultants[0, 1, 1] == pytest.approx(-force, rel=1e-5)  # that of the block on the plate
