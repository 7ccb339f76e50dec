"""Neo-Hooke bodies in contact beside closed forms, and wrong input of `press_nonlinear`."""

import numpy as np
import pytest
from scipy.optimize import brentq

from flangeway.contact import Contact, Multiplier, SegmentToSegment, Surface, press_nonlinear
from flangeway.elements import Lagrange, Virtual
from flangeway.errors import InputError
from flangeway.geometry import Placement
from flangeway.materials import Elastic, J2Plasticity, NeoHooke
from flangeway.mesh import rectangle_grid
from flangeway.problems import Body, Part
from flangeway.solve import StepSettings

RUBBER = Elastic(1.0, 0.3)
SHEAR, LAME = RUBBER.shear_modulus, float(RUBBER.matrix[0, 1])


def pressed_block(element, cells):
    """A block 2 x 1 that nothing holds between smooth plates, as (block, upper plate, contacts)."""
    mesh = rectangle_grid(2.0, 1.0, 6, 3, cells=cells)
    block = Part("block", Body("block", mesh, element, RUBBER))
    contacts, plates = [], []
    for side, y, held, edges in (("top", 1.0, "top", "bottom"), ("bottom", -0.5, "bottom", "top")):
        plate = rectangle_grid(6.0, 0.5, 7, 1, origin=(-2.0, y))
        plates.append(Part(side, Body(side, plate, Lagrange(1), Elastic(1e6, 0.3), held)))
        surfaces = Surface(block, mesh.edge_set(side)), Surface(plates[-1], plate.edge_set(edges))
        contacts.append(Contact(*surfaces, SegmentToSegment(), Multiplier()))
    return block, plates[0], contacts


@pytest.mark.parametrize(("element", "cells"), [(Virtual(1), "quadrilaterals"), (Lagrange(2), "triangles")])
@pytest.mark.parametrize("strain", [0.2, 0.4])
def test_a_block_between_plates_has_the_force_of_the_homogeneous_deformation(element, cells, strain):
    """``P_x = 0`` gives the lateral stretch a, ``P_y = G (s - 1 / s) + L ln(a s) / s`` the force, to 1e-5.

    From 20 % on the tangent of the block alone is not definite: contact holds it.
    """
    block, upper, contacts = pressed_block(element, cells)
    result = press_nonlinear(contacts, {upper: Placement(0.0, (0.0, -strain))}, {block: NeoHooke(RUBBER)})
    s = 1.0 - strain
    a = brentq(lambda a: SHEAR * (a - 1.0 / a) + LAME * np.log(a * s) / a, 0.5, 5.0)
    assert result.status.converged
    exact = -2.0 * (SHEAR * (s - 1.0 / s) + LAME * np.log(a * s) / s)
    np.testing.assert_allclose(result.contact.resultants[:, 1, 1], [exact, -exact], rtol=1e-5)
    assert result.status.stabilisation < 1e-6


def wrong(words, **changes):
    block, upper, contacts = pressed_block(Lagrange(1), "triangles")
    arguments = {
        "contacts": contacts,
        "motion": {upper: Placement(0.0, (0.0, -0.1))},
        "materials": {block: NeoHooke(RUBBER)},
    }
    changed = {name: change(block, upper) for name, change in changes.items()}
    with pytest.raises(InputError, match=words):
        press_nonlinear(**(arguments | changed))


WRONG = {
    "one motion": {"motion": lambda block, upper: [{upper: Placement()}]},
    "a NonlinearMaterial": {"materials": lambda block, upper: {block: RUBBER}},
    "materials": {"materials": lambda block, upper: {}},
    "no contact": {"materials": lambda block, upper: {"block": NeoHooke(RUBBER)}},
    "states of the motion before": {"start": lambda block, upper: {upper: None}},
    "StepSettings": {"steps": lambda block, upper: 4},
    "tolerance": {"tolerance": lambda block, upper: 0.0},
    "max_iterations": {"max_iterations": lambda block, upper: 0},
}


@pytest.mark.parametrize("words", WRONG)
def test_wrong_input_of_press_nonlinear_is_named(words):
    """Each error names the argument, or what it should be."""
    wrong(words, **WRONG[words])


def test_a_perfectly_plastic_block_pressed_by_a_plate_has_a_status_and_its_limit_pressure():
    """Without hardening, at three times the strain at yield: 2 / sqrt(3) of the yield stress on its width to 0.5 %."""
    block, upper, contacts = pressed_block(Virtual(1), "quadrilaterals")
    result = press_nonlinear(
        contacts,
        {upper: Placement(0.0, (0.0, -0.03))},
        {block: J2Plasticity(RUBBER, 0.01)},
        steps=StepSettings(smallest=1 / 8),
    )
    assert result.status.converged
    assert result.contact.resultants[0, 1, 1] == pytest.approx(2.0 * 2.0 / np.sqrt(3.0) * 0.01, rel=5e-3)
