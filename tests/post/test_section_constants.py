"""Constants of cross-sections against closed forms and books."""

import numpy as np
import pytest

from flangeway.elements import Lagrange, Virtual
from flangeway.exact import Rectangle
from flangeway.geometry import Arc, Line, Outline, Placement, polygon, rectangle
from flangeway.mesh import dual, triangulate
from flangeway.post import section_constants
from flangeway.space import Space

HALF_DISC = Outline.from_segments(
    [Line((0, 0), (1, 0)), Arc((1, 0), (-1, 0), (0, 0), True), Line((-1, 0), (0, 0))], ["base", "arc", "base"]
)
HALF_DISC_MESH = triangulate(HALF_DISC, size=0.05)
CHANNEL = polygon([(0, 0), (4, 0), (4, 0.1), (0.1, 0.1), (0.1, 7.9), (4, 7.9), (4, 8), (0, 8)])
ANGLE = polygon([(0, 0), (6, 0), (6, 0.2), (0.2, 0.2), (0.2, 4), (0, 4)])


def constants(outline, size, element=None, **options):
    return section_constants(Space(triangulate(outline, size=size), element or Lagrange(2)), **options)


def test_rectangle():
    """A rectangle off the origin: area, centroid, second moments, torsion constant, shear centre at the centroid."""
    found = constants(rectangle(3.0, 1.0, (5.0, 2.0)), 0.2)
    assert found.area == pytest.approx(3.0)
    assert found.centroid == pytest.approx((5.0, 2.0))
    assert found.second_moments == pytest.approx((3.0 / 12.0, 27.0 / 12.0, 0.0), abs=1e-10)
    assert found.principal_moments == pytest.approx((2.25, 0.25))
    assert abs(found.principal_angle) == pytest.approx(np.pi / 2.0)
    lower, upper = found.torsion_bounds
    assert found.bounds_certain
    assert lower < Rectangle(3.0, 1.0).torsion_constant < upper
    assert found.torsion_constant == pytest.approx(Rectangle(3.0, 1.0).torsion_constant, rel=1e-4)
    assert found.shear_centre == pytest.approx((5.0, 2.0), abs=1e-5)


@pytest.mark.parametrize("poisson", [0.0, 0.3, 0.5])
@pytest.mark.parametrize("element", [Lagrange(2), Virtual(2)], ids=["triangles", "polygons"])
def test_shear_centre_of_the_half_disc(element, poisson):
    """The half disc's shear centre is Timoshenko and Goodier's (article 123), for every Poisson's ratio.

    Their ``8 a (3 + 4 nu) / (15 pi (1 + nu))`` is for no twist at the middle of the diameter; no mean twist, at the
    centroid, takes ``nu J yc / (2 (1 + nu) Iyy)`` away.
    """
    mesh = HALF_DISC_MESH if isinstance(element, Lagrange) else dual(HALF_DISC_MESH)
    found = section_constants(Space(mesh, element), poisson=poisson)
    book = 8.0 * (3.0 + 4.0 * poisson) / (15.0 * np.pi * (1.0 + poisson))
    twist = poisson * 0.297557 * 4.0 / (3.0 * np.pi) / (2.0 * (1.0 + poisson) * np.pi / 8.0)
    assert found.shear_centre == pytest.approx((0.0, book - twist), abs=3e-4)
    assert found.shear_centre_trefftz == pytest.approx((0.0, 8.0 / (5.0 * np.pi)), abs=3e-4)


def test_thin_channel():
    """A thin channel: shear centre and warping constant within 2 % of the thin-walled theory."""
    found = constants(CHANNEL, 0.1)
    b, h, t = 3.95, 7.9, 0.1
    eccentricity = 3.0 * b**2 / (6.0 * b + h)
    warping = t * b**3 * h**2 / 12.0 * (3.0 * b + 2.0 * h) / (6.0 * b + h)
    x, y = found.shear_centre_trefftz
    assert 0.05 - x == pytest.approx(eccentricity, rel=0.02)
    assert y == pytest.approx(4.0, abs=1e-3)
    assert found.warping_constant == pytest.approx(warping, rel=0.02)


def test_principal_axes_turn_with_the_section():
    """A section turned by 25 degrees has its principal angle turned by as much, and all else unchanged."""
    still = constants(ANGLE, 0.1)
    turned = constants(ANGLE.transformed(Placement(rotation_rad=np.radians(25.0))), 0.1)
    change = turned.principal_angle - still.principal_angle
    assert np.degrees(change) % 180.0 == pytest.approx(25.0, abs=1e-6)
    assert turned.principal_moments == pytest.approx(still.principal_moments)
    assert turned.warping_constant == pytest.approx(still.warping_constant, rel=1e-2)
