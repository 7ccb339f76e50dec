"""Bending of axles, beside closed forms of beams."""

import numpy as np

from flangeway.railway.wheelset.axle import Axle

PLACES = np.array([-750.0, 750.0])
DIAMETER, YOUNG = 173.0, 210e3
RIGIDITY = YOUNG * np.pi * DIAMETER**4 / 64.0
UNIFORM = Axle(2000.0, ((0.0, DIAMETER), (1100.0, DIAMETER)), YOUNG)


def test_outside_journals_bend_the_middle_up() -> None:
    """Equal wheel forces: bending Q (L - b) / 2 between the wheels, whose lower parts come closer."""
    force = 112.5e3
    expected = force * 250.0 * 750.0 / RIGIDITY
    found = UNIFORM.tilts(PLACES, np.array([[force, 0.0], [force, 0.0]]))
    np.testing.assert_allclose(found, [expected, -expected], rtol=1e-12)


def test_inside_journals_bend_the_middle_down() -> None:
    """Four-point bending: the slope at the ends is Q a (b - a) / (2 E I) with a from the wheel to the journal."""
    inside = Axle(1100.0, UNIFORM.diameters_mm, YOUNG)
    force, arm = 100e3, 200.0
    expected = force * arm * (1500.0 - arm) / 2.0 / RIGIDITY
    found = inside.tilts(PLACES, np.array([[force, 0.0], [force, 0.0]]))
    np.testing.assert_allclose(found, [-expected, expected], rtol=1e-10)


def test_a_moment_on_one_wheel_bends_a_supported_beam() -> None:
    """A moment at the end of a beam whose journals are in the wheels: M l / 3 E I there, - M l / 6 E I at the other."""
    found = Axle(1500.0, UNIFORM.diameters_mm, YOUNG).tilts(PLACES, np.array([[0.0, 0.0], [0.0, 20e6]]))
    slope = 20e6 * 1500.0 / RIGIDITY
    np.testing.assert_allclose(found, [-slope / 6.0, slope / 3.0], rtol=1e-10)


def test_forces_superpose_and_mirror() -> None:
    """Tilts are linear in the forces; exchanged sides exchange them with the sign of rotations."""
    rng = np.random.default_rng(3)
    one, two = rng.normal(size=(2, 2, 2)) * [1e5, 1e7]
    axle = Axle()
    np.testing.assert_allclose(
        axle.tilts(PLACES, 2.0 * one - two), 2.0 * axle.tilts(PLACES, one) - axle.tilts(PLACES, two), rtol=1e-10
    )
    mirrored = axle.tilts(PLACES, one[::-1] * [1.0, -1.0])
    np.testing.assert_allclose(mirrored, -axle.tilts(PLACES, one)[::-1], rtol=1e-10)
