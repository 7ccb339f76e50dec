"""Nearly incompressible bodies: what is reported to lock is too stiff, and what is not reported does not."""

from functools import cache

import pytest

from flangeway.contact import Contact, Multiplier, SegmentToSegment, Surface, press
from flangeway.elements import Lagrange, StabilisationFree, Virtual
from flangeway.geometry import Placement
from flangeway.materials import Elastic, J2Plasticity, NeoHooke
from flangeway.mesh import dual, rectangle_grid
from flangeway.problems import Body, Elasticity, Part, PrescribedDisplacement
from flangeway.solve import solve_elasticity, solve_nonlinear
from flangeway.space import Space

TRIANGLES = rectangle_grid(4.0, 2.0, 16, 8)
QUADRILATERALS = rectangle_grid(4.0, 2.0, 16, 8, cells="quadrilaterals")
ELEMENTS = {
    "triangles, order 1": (TRIANGLES, Lagrange(1), True),
    "virtual triangles, order 1": (TRIANGLES, Virtual(1), True),
    "polygons, order 1": (dual(TRIANGLES), Virtual(1), False),
    "quadrilaterals, order 1": (QUADRILATERALS, Virtual(1), False),
    "polygons without stabilisation": (dual(TRIANGLES), StabilisationFree(1), True),
    "triangles, order 2": (TRIANGLES, Lagrange(2), False),
    "quadrilaterals, order 2": (QUADRILATERALS, Virtual(2), False),
}


def _compressed(mesh, element, material):
    """A block whose ends are clamped is compressed by 0.01; about an axis it is a cylinder."""
    supports = [PrescribedDisplacement("bottom", x=0.0, y=0.0), PrescribedDisplacement("top", x=0.0, y=-0.01)]
    if material.hypothesis == "axisymmetric":
        supports.append(PrescribedDisplacement("left", x=0.0))
    return solve_elasticity(Elasticity(Space(mesh, element), material, supports=supports))


@cache
def _exact(poisson, hypothesis):
    return _compressed(rectangle_grid(4.0, 2.0, 20, 10), Lagrange(3), Elastic(5.0, poisson, hypothesis)).energy


@pytest.mark.parametrize("hypothesis", ["plane_strain", "axisymmetric", "plane_stress"])
@pytest.mark.parametrize("poisson", [0.3, 0.45, 0.49, 0.4999])
@pytest.mark.parametrize("name", ELEMENTS)
def test_locking_is_reported_where_it_is_measured(name, poisson, hypothesis):
    """Beside order 3 on a finer mesh: errors of energy above 10 % are reported, and no error below 4 %."""
    mesh, element, locks = ELEMENTS[name]
    solution = _compressed(mesh, element, Elastic(5.0, poisson, hypothesis))
    error = solution.energy / _exact(poisson, hypothesis) - 1.0
    reported = "locks" in solution.status.message
    assert reported == (locks and poisson > 0.48 and hypothesis != "plane_stress")
    assert error > 0.04 if reported else error < 0.1


def test_a_contact_names_the_part_that_locks():
    """A pad of rubber under a plate of steel: the force of order 1 is a fifth too large, and its status says so."""
    forces = {}
    for order in (1, 2):
        pad = Body("pad", rectangle_grid(8.0, 4.0, 16, 8), Lagrange(order), Elastic(5.0, 0.4999), "bottom")
        plate = Body(
            "plate", rectangle_grid(12.0, 2.0, 4, 1, origin=(-2.0, 4.0)), Lagrange(2), Elastic(2e5, 0.3), "top"
        )
        parts = [Part(body.name, body) for body in (pad, plate)]
        sides = [
            Surface(part, part.body.mesh.edge_sets[name]) for part, name in zip(parts, ("top", "bottom"), strict=True)
        ]
        solution = press([Contact(*sides, SegmentToSegment(), Multiplier())], {parts[1]: Placement(0.0, (0.0, -0.05))})
        assert solution.status.converged
        assert ("pad locks" in solution.status.message) == (order == 1)
        assert "plate locks" not in solution.status.message
        forces[order] = abs(solution.forces[0, 1])
    assert forces[1] > 1.2 * forces[2]


@cache
def _cantilever(name, material):
    """Mean prescribed force and the message; the end of a beam is displaced by 0.05."""
    cells, element = name.split(", order ")
    mesh = rectangle_grid(4.0, 2.0, 6, 4, cells=cells)
    space = Space(mesh, (Lagrange if cells == "triangles" else Virtual)(int(element)))
    supports = [PrescribedDisplacement("left", x=0.0, y=0.0), PrescribedDisplacement("right", y=-0.05)]
    problem = Elasticity(space, material.elastic, supports=supports)
    solution = solve_nonlinear(problem, material)[-1]
    assert solution.status.converged
    on_right = space.nodes[:, 0] > 4.0 - 1e-9
    return solution.nodal_forces[on_right[: space.n_nodes], 1].sum(), solution.status.message


@pytest.mark.parametrize(
    "material", [NeoHooke(Elastic(5.0, 0.4999)), J2Plasticity(Elastic(200.0, 0.3), 0.2, isotropic=2.0)]
)
@pytest.mark.parametrize("name", ["triangles, order 1", "quadrilaterals, order 1", "quadrilaterals, order 2"])
def test_locking_of_nonlinear_bodies_is_reported_where_it_is_measured(name, material):
    """Nearly incompressible neo-Hooke, and perfect plasticity, whose flow keeps the volume, beside order 2."""
    force, message = _cantilever(name, material)
    error = force / _cantilever("triangles, order 2", material)[0] - 1.0
    assert ("locks" in message) == (error > 0.3), error
