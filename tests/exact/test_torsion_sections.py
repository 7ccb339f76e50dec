"""Torsion in closed form: equation, boundary condition, constant and warping of every section."""

import numpy as np
import pytest

from flangeway.elements import polygon_quadrature
from flangeway.errors import InputError
from flangeway_studies.torsion_bars import (
    CircularSector,
    Ellipse,
    EquilateralTriangle,
    Rectangle,
    thin_closed_torsion_constant,
    thin_open_torsion_constant,
)

STEP = 1e-4


def ray(section, n):
    """A boundary point in every direction from the origin (n, 2), with the ellipse's, sector's and polygons' shapes."""
    if isinstance(section, Ellipse):
        angles = np.linspace(0.0, 2.0 * np.pi, n, endpoint=False)
        return np.column_stack((section.half_width * np.cos(angles), section.half_height * np.sin(angles)))
    if isinstance(section, CircularSector):
        half = section.angle / 2.0
        angles = np.linspace(-half, half, n)
        arc = section.radius * np.column_stack((np.cos(angles), np.sin(angles)))
        radii = np.linspace(0.0, section.radius, n)[1:-1, None]
        return np.vstack(
            (radii * [np.cos(half), -np.sin(half)], arc, radii[::-1] * [np.cos(half), np.sin(half)], [[0, 0]])
        )
    if isinstance(section, EquilateralTriangle):
        corners = section.corners
    else:
        corners = np.array([[-1, -1], [1, -1], [1, 1], [-1, 1]]) * [section.width / 2.0, section.height / 2.0]
    t = np.linspace(0.0, 1.0, n, endpoint=False)[:, None]
    return np.vstack([a + t * (b - a) for a, b in zip(corners, np.roll(corners, -1, axis=0), strict=True)])


SECTIONS = [
    Ellipse(1.0, 0.6),
    Ellipse.circle(0.7),
    EquilateralTriangle(1.5),
    Rectangle(1.0, 1.0),
    Rectangle(1.3, 0.5),
    Rectangle(0.5, 1.3),
    CircularSector(1.2, np.pi),
    CircularSector(1.0, np.pi / 2.0),
    CircularSector(1.0, 1.5 * np.pi),
    CircularSector(1.0, 0.8),
    CircularSector(0.9, 2.5),
]


def inner_points(section):
    rim = ray(section, 40)
    points, _ = polygon_quadrature(rim[:, :, None], 2)
    points = points[:, :, 0]
    size = np.ptp(rim, axis=0).max()
    away = np.min(np.linalg.norm(points[:, None] - rim[None], axis=2), axis=1) > 0.06 * size
    return points[away]


def differences(function, points):
    shifts = STEP * np.eye(2)
    return np.column_stack([(function(points + s) - function(points - s)) / (2.0 * STEP) for s in shifts])


@pytest.mark.parametrize("section", SECTIONS, ids=str)
def test_gradients_are_those_of_the_functions(section):
    """Both gradients agree with central differences."""
    points = inner_points(section)
    assert differences(section.stress_function, points) == pytest.approx(
        section.stress_function_gradient(points), abs=1e-5
    )
    assert differences(section.warping, points) == pytest.approx(section.warping_gradient(points), abs=1e-5)


@pytest.mark.parametrize("section", SECTIONS, ids=str)
def test_prandtls_function_obeys_its_equation(section):
    """The Laplacian of Prandtl's function is -2."""
    points = inner_points(section)
    shifts = STEP * np.eye(2)
    slope = section.stress_function_gradient
    laplacian = sum((slope(points + s)[:, i] - slope(points - s)[:, i]) / (2.0 * STEP) for i, s in enumerate(shifts))
    assert laplacian == pytest.approx(-2.0 * np.ones(len(points)), abs=1e-5)


@pytest.mark.parametrize("section", SECTIONS, ids=str)
def test_prandtls_function_vanishes_on_the_outline(section):
    """Prandtl's function is zero on the outline, to the series' truncation."""
    assert section.stress_function(ray(section, 25)) == pytest.approx(0.0, abs=2e-6)


@pytest.mark.parametrize("section", [SECTIONS[each] for each in (0, 2, 4, 8)], ids=str)
def test_torsion_constant_is_twice_the_volume_under_prandtls_function(section):
    """J and the area equal integrals over a fine polygon of the outline."""
    rim = ray(section, 200)
    points, weights = polygon_quadrature(rim[:, :, None], 12)
    volume = 2.0 * weights[:, 0] @ section.stress_function(points[:, :, 0])
    assert volume == pytest.approx(section.torsion_constant, rel=4e-4)
    assert weights.sum() == pytest.approx(section.area, rel=4e-4)


@pytest.mark.parametrize(
    ("section", "expected"),
    [
        (Rectangle(1.0, 1.0), 0.14057701495515),  # Timoshenko and Goodier, article 109: 0.1406
        (Rectangle(2.0, 1.0), 2.0 * 0.228682),  # 0.229 there
        (Rectangle(1.0, 10.0), 10.0 * 0.312325),  # 0.312 there
        (CircularSector(1.0, np.pi), 0.297557),  # half circle: 0.296 in article 111, from fewer terms
        (EquilateralTriangle(2.0 / 3.0**0.25), np.sqrt(3.0) / 15.0),
        (Ellipse.circle(1.0), np.pi / 2.0),
        (Ellipse.circle(1.0, 0.5), np.pi / 2.0 * (1.0 - 0.5**4)),
    ],
    ids=str,
)
def test_torsion_constants_are_the_known_ones(section, expected):
    """Torsion constants of the books, to their digits or better."""
    assert section.torsion_constant == pytest.approx(expected, rel=2e-6)


def test_thin_walled_formulas():
    """A thin ring: Bredt's formula is within (t/r)^2 of the exact constant, and cut open it falls to 2 pi r t^3 / 3."""
    radius, thickness = 1.0, 0.02
    exact = Ellipse.circle(radius + thickness / 2.0, radius - thickness / 2.0).torsion_constant
    closed = thin_closed_torsion_constant(np.pi * radius**2, [2.0 * np.pi * radius], [thickness])
    assert closed == pytest.approx(exact, rel=(thickness / radius) ** 2)
    opened = thin_open_torsion_constant([2.0 * np.pi * radius], [thickness])
    assert opened == pytest.approx(2.0 * np.pi * radius * thickness**3 / 3.0)
    assert thin_open_torsion_constant([1.0], [0.01]) == pytest.approx(Rectangle(1.0, 0.01).torsion_constant, rel=0.01)


@pytest.mark.parametrize(
    "make",
    [
        lambda: Rectangle(0.0, 1.0),
        lambda: Ellipse(1.0, -1.0),
        lambda: Ellipse(1.0, 1.0, 1.0),
        lambda: EquilateralTriangle(np.nan),
        lambda: CircularSector(1.0, 2.0 * np.pi),
        lambda: Rectangle(1.0, 1.0).warping([1.0, 2.0]),
    ],
)
def test_wrong_sections_are_refused(make):
    """Sizes that make no section and points of a wrong shape are refused."""
    with pytest.raises(InputError):
        make()
