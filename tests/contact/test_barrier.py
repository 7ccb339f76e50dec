"""The barrier: its law in closed form, with friction and free bodies, and that it tends to multipliers at its rate."""

import numpy as np
import pytest
from scipy.optimize import brentq

from flangeway.contact import Barrier, Contact, Multiplier, NodeToSegment, SegmentToSegment, press
from flangeway.elements import Lagrange
from flangeway.geometry import Placement
from flangeway.materials import Elastic
from flangeway.mesh import rectangle_grid
from flangeway.post import pressure_patches
from flangeway.problems import Body, Part
from tests.contact.steel_boxes import BoxDiscretisation, pressed_boxes, surface_of

YOUNG, HEIGHT, APPROACH, VALUE, REACH = 210e3, 20.0, 0.01, 0.05, 0.02


def column(name: str, n_edges: int, held: str, bottom: float) -> Part:
    """A block without contraction."""
    mesh = rectangle_grid(40.0, HEIGHT, n_edges, 3, origin=(0.0, bottom))
    return Part(name, Body(name, mesh, Lagrange(1), Elastic(YOUNG, 0.0), held))


def pressed(enforcement, approach: float = APPROACH, path=None):
    """Two columns pressed together."""
    upper, lower = column("upper", 5, "top", 0.0), column("lower", 5, "bottom", -HEIGHT)
    contact = Contact(surface_of(upper, "bottom"), surface_of(lower, "top"), SegmentToSegment(), enforcement)
    return press([contact], {upper: Placement(0.0, (0.0, -approach))}, path=path)


@pytest.mark.parametrize("path", ["condensed", "sparse"])
@pytest.mark.parametrize("approach", [APPROACH, 0.1 * APPROACH, -0.5 * REACH])
def test_columns_have_the_pressure_of_the_law(approach: float, path) -> None:
    """The root of p = w (1 / g - 1 / r) and p = E (d + g) / 2 h; it is refused where g is above half of d."""
    solution = pressed(Barrier(VALUE, REACH), approach, path)
    gap = brentq(lambda g: YOUNG * (approach + g) / (2.0 * HEIGHT) - VALUE * (1.0 / g - 1.0 / REACH), 1e-9, REACH)
    assert solution.status.converged == (gap <= 0.5 * approach), solution.status.message
    assert solution.status.checks.force_error == pytest.approx(gap / approach if approach > 0.0 else np.inf, rel=1e-6)
    assert solution.status.iterations <= 4
    patch = pressure_patches(solution.system, solution.state)[0]
    assert patch.pressures == pytest.approx(VALUE * (1.0 / gap - 1.0 / REACH), rel=1e-9)
    assert solution.state.linearisation.gaps == pytest.approx(gap, rel=1e-9)


def test_beyond_the_reach_there_is_no_force() -> None:
    """Columns further apart than the reach do not touch."""
    solution = pressed(Barrier(VALUE, REACH), -1.01 * REACH)
    assert solution.status.converged
    assert not solution.state.nodal_forces.any()


@pytest.mark.parametrize("pairing", [SegmentToSegment(), NodeToSegment()])
def test_it_tends_to_the_multipliers_in_proportion_to_its_value(pairing) -> None:
    """Boxes of different meshes: the difference of the force is ten times smaller for a value ten times smaller."""
    meshes = BoxDiscretisation(0.5, "fem", 1), BoxDiscretisation(0.37, "vem", 1)
    exact = pressed_boxes(*meshes, pairing, Multiplier(), approach=0.01).solve()
    apart = []
    for value in (1e-3, 1e-4, 1e-5):
        found = pressed_boxes(*meshes, pairing, Barrier(value, 0.01), approach=0.01).solve()
        assert found.status.converged, found.status.message
        assert (found.state.linearisation.gaps > 0.0).all()
        apart.append(np.abs(found.forces - exact.forces).max() / np.abs(exact.forces).max())
    assert apart[0] < 0.01
    assert np.array(apart[:-1]) / apart[1:] == pytest.approx(10.0, rel=0.05)


def test_with_friction_it_tends_to_the_multipliers_too() -> None:
    """Columns pressed and pushed until some nodes slip: both forces, ten times nearer for a value ten times smaller."""
    found = {}
    for value in (None, 1e-2, 1e-3, 1e-4):
        upper, lower = column("upper", 5, "top", 0.0), column("lower", 7, "bottom", -HEIGHT)
        law = Multiplier() if value is None else Barrier(value, 0.01)
        contact = Contact(surface_of(upper, "bottom"), surface_of(lower, "top"), SegmentToSegment(), law, 0.2)
        path = [{upper: Placement(0.0, at)} for at in ((0.0, -APPROACH), (APPROACH, -APPROACH))]
        solution = press([contact], path)
        assert solution.status.converged, solution.status.message
        found[value] = solution.forces[0], np.array(solution.friction_table.columns["sticks"])
    forces, sticks = found.pop(None)
    assert sticks.any()
    assert not sticks.all()
    apart = [np.abs(each - forces) for each, _ in found.values()]
    assert (apart[0] < 5e-3 * np.abs(forces[1])).all()
    assert np.linalg.norm(apart[:-1], axis=1) / np.linalg.norm(apart[1:], axis=1) == pytest.approx(10.0, rel=0.1)


def test_a_barrier_beside_multipliers() -> None:
    """Three columns: each contact has its own law, the lower one the barrier's gap under the pressure of both."""
    parts = [
        column(*each) for each in (("upper", 5, "top", 0.0), ("middle", 5, None, -20.0), ("lower", 5, "bottom", -40.0))
    ]
    laws = Multiplier(), Barrier(VALUE, REACH)
    contacts = [
        Contact(surface_of(above, "bottom"), surface_of(below, "top"), SegmentToSegment(), law)
        for above, below, law in zip(parts[:-1], parts[1:], laws, strict=True)
    ]
    solution = press(contacts, {parts[0]: Placement(0.0, (0.0, -APPROACH))})
    gap = brentq(lambda g: YOUNG * (APPROACH + g) / (3.0 * HEIGHT) - VALUE * (1.0 / g - 1.0 / REACH), 1e-9, REACH)
    assert solution.status.converged, solution.status.message
    assert solution.forces[:, 1] == pytest.approx(40.0 * VALUE * (1.0 / gap - 1.0 / REACH), rel=1e-9)
