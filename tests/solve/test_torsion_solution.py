"""Solutions of St. Venant's torsion, and constants of cross-sections against closed forms and books."""

import numpy as np
import pytest

from flangeway.elements import Lagrange, NoStabilisation, Virtual
from flangeway.errors import InputError
from flangeway.geometry import Arc, Line, Outline, Placement, circle, polygon, rectangle, square
from flangeway.mesh import PolyMesh, dual, rectangle_grid, triangulate
from flangeway.post import corner_shear_stresses, error_norms, section_constants, shear_stresses
from flangeway.problems import Torsion
from flangeway.solve import solve_torsion
from flangeway.space import Space, interpolate
from flangeway_studies.torsion_bars import Ellipse, EquilateralTriangle, Rectangle

TRIANGLE = EquilateralTriangle(1.5)
TRIANGLE_MESH = triangulate(polygon(TRIANGLE.corners), size=0.3)
SQUARE_MESH = triangulate(square(1.0), size=0.1)


def constants(mesh, element, **options):
    """Torsion constants from the warping and from Prandtl's function."""
    space = Space(mesh, element)
    return [
        solve_torsion(Torsion(space, formulation=formulation, **options)).torsion_constant
        for formulation in ("warping", "prandtl")
    ]


@pytest.mark.parametrize("formulation", ["warping", "prandtl"])
@pytest.mark.parametrize(
    ("mesh", "element"),
    [(TRIANGLE_MESH, Lagrange(3)), (TRIANGLE_MESH, Virtual(3)), (dual(TRIANGLE_MESH), Virtual(3))],
    ids=["Lagrange", "virtual triangles", "polygons"],
)
def test_cubic_solution_of_the_triangle_is_exact(mesh, element, formulation):
    """The equilateral triangle's functions are cubic: elements of order 3 give them to rounding."""
    space = Space(mesh, element)
    solution = solve_torsion(Torsion(space, formulation=formulation))
    assert solution.status.converged
    assert "the residual is" in solution.status.message
    exact = TRIANGLE.warping if formulation == "warping" else TRIANGLE.stress_function
    assert solution.function == pytest.approx(interpolate(space, exact), abs=1e-10)
    assert solution.torsion_constant == pytest.approx(TRIANGLE.torsion_constant, rel=1e-10)


@pytest.mark.parametrize("formulation", ["warping", "prandtl"])
def test_stresses_of_the_triangle_are_exact(formulation):
    """On polygons of order 3 the shear stresses, which are quadratic, are exact; their resultant is zero."""
    mesh = dual(TRIANGLE_MESH)
    solution = solve_torsion(Torsion(Space(mesh, Virtual(3)), formulation=formulation))
    exact = TRIANGLE.shear_stress(mesh.points[mesh.cell_points])
    assert corner_shear_stresses(solution) == pytest.approx(exact, abs=1e-9)
    torque = mesh.cell_areas @ shear_stresses(solution)
    assert torque == pytest.approx([0.0, 0.0], abs=1e-10)


@pytest.mark.parametrize("order", [1, 2, 3])
@pytest.mark.parametrize(
    ("outline", "exact"),
    [(square(1.0), Rectangle(1.0, 1.0)), (rectangle(1.0, 0.2), Rectangle(1.0, 0.2))],
    ids=["square", "flat"],
)
def test_lagrange_elements_bracket_the_exact_constant(order, outline, exact):
    """Lagrange elements: Prandtl's function below, the warping function above."""
    upper, lower = constants(triangulate(outline, size=0.1), Lagrange(order))
    assert lower < exact.torsion_constant < upper


@pytest.mark.parametrize("element", [Lagrange(2), Virtual(2)], ids=["Lagrange", "virtual"])
def test_hollow_circle(element):
    """A hollow circle: both formulations within 0.1 % of the closed form, the hole's value (R^2 - r^2) / 2."""
    mesh = triangulate(circle(1.0), size=0.05, holes=[circle(0.5)])
    exact = Ellipse.circle(1.0, 0.5)
    assert constants(mesh, element) == pytest.approx([exact.torsion_constant] * 2, rel=1e-3)
    solution = solve_torsion(Torsion(Space(mesh, element), formulation="prandtl"))
    assert solution.hole_values == pytest.approx([0.375], rel=1e-3)
    space = Space(mesh, element)
    assert (
        error_norms(space, solution.function, exact.stress_function, exact.stress_function_gradient).relative_h1 < 5e-3
    )


@pytest.mark.parametrize(("order", "width"), [(1, 2e-2), (2, 3e-5), (3, 1e-6)])
def test_both_formulations_enclose_the_constant_of_an_annulus_on_curved_meshes(order, width):
    """Prandtl's constant is below that of the warping function, both within the discretisation's error of 7.5 pi."""
    outer, bore = circle(2.0), circle(1.0)
    mesh = triangulate(outer, size=0.5, holes=[bore], outline=[outer, bore])
    upper, lower = constants(mesh, Lagrange(order))
    assert lower < upper < (1.0 + width) * lower
    assert lower == pytest.approx(7.5 * np.pi, rel=1.5 * width)


def test_two_holes_carry_equal_values_by_symmetry():
    """A symmetric pair of holes has one common value, and a wall between them that carries no shear at mid length."""
    holes = [square(0.5, (-0.5, 0.0)), square(0.5, (0.5, 0.0))]
    mesh = triangulate(rectangle(2.0, 1.0), size=0.1, holes=holes)
    solution = solve_torsion(Torsion(Space(mesh, Lagrange(2)), formulation="prandtl"))
    assert len(solution.hole_values) == 2
    assert solution.hole_values[0] == pytest.approx(solution.hole_values[1], rel=1e-3)
    upper = solve_torsion(Torsion(Space(mesh, Lagrange(2)))).torsion_constant
    assert solution.torsion_constant < upper < 1.01 * solution.torsion_constant


def test_composite_of_equal_materials_is_the_homogeneous_section():
    """Two materials with one modulus are one material; both scaled by ten have ten times the rigidity."""
    mesh = halves()
    for formulation in ("warping", "prandtl"):
        space = Space(mesh, Lagrange(2))
        one = solve_torsion(Torsion(space, 3.0, formulation))
        two = solve_torsion(Torsion(space, {"left": 3.0, "right": 3.0}, formulation))
        ten = solve_torsion(Torsion(space, 30.0, formulation))
        assert two.torsional_rigidity == pytest.approx(one.torsional_rigidity, rel=1e-12)
        assert ten.torsional_rigidity == pytest.approx(10.0 * one.torsional_rigidity, rel=1e-12)
        assert one.torsion_constant == pytest.approx(ten.torsion_constant, rel=1e-12)


def halves():
    mesh = rectangle_grid(1.0, 0.5, 8, 4, origin=(3.0, 7.0))
    left = mesh.cell_centroids[:, 0] < 3.5
    return mesh.with_cell_set("left", left).with_cell_set("right", ~left)


def test_result_does_not_depend_on_place_or_unit():
    """Moved by 1e5 diameters the constant keeps 9 digits; in another unit it scales with the fourth power."""
    mesh = dual(SQUARE_MESH)
    moved = PolyMesh(mesh.points + 1e5, mesh.cell_offsets, mesh.cell_points)
    scaled = PolyMesh(1e3 * mesh.points, mesh.cell_offsets, mesh.cell_points)
    base = constants(mesh, Virtual(2))
    assert constants(moved, Virtual(2)) == pytest.approx(base, rel=1e-9)
    assert constants(scaled, Virtual(2)) == pytest.approx(1e12 * np.array(base), rel=1e-9)


def test_separate_parts_twist_about_their_own_centres():
    """Two squares that do not touch have twice the constant of one, and a warping function of mean zero on each."""
    first = rectangle_grid(1.0, 1.0, 8, 8)
    both = first.merged(rectangle_grid(1.0, 1.0, 8, 8, origin=(3.0, 1.0)))
    single = constants(first, Lagrange(2))
    assert constants(both, Lagrange(2)) == pytest.approx(2.0 * np.array(single), rel=1e-10)


@pytest.mark.parametrize(
    ("options", "message"),
    [
        ({"shear_modulus": 0.0}, "positive"),
        ({"shear_modulus": {"left": 1.0}}, "in 0 of the given cell sets"),
        ({"shear_modulus": {"nowhere": 1.0}}, "nowhere"),
        ({"formulation": "stress"}, "warping or prandtl"),
        ({"load": "vertex_mean"}, "order 1"),
    ],
)
def test_wrong_problems_are_refused(options, message):
    """Moduli that are not positive or do not cover the mesh, and unknown choices, are refused by name."""
    with pytest.raises(InputError, match=message):
        Torsion(Space(halves(), Lagrange(2)), **options)


def test_missing_stabilisation_is_reported():
    """Squares of order 1 without a stabilisation have a free hourglass: the error says what to do."""
    mesh = rectangle_grid(1.0, 1.0, 4, 4, cells="quadrilaterals")
    with pytest.raises(InputError, match="stabilisation"):
        solve_torsion(Torsion(Space(mesh, Virtual(1, NoStabilisation()))))


HALF_DISC = Outline.from_segments(
    [Line((0, 0), (1, 0)), Arc((1, 0), (-1, 0), (0, 0), True), Line((-1, 0), (0, 0))], ["base", "arc", "base"]
)
HALF_DISC_MESH = triangulate(HALF_DISC, size=0.05)
CHANNEL = polygon([(0, 0), (4, 0), (4, 0.1), (0.1, 0.1), (0.1, 7.9), (4, 7.9), (4, 8), (0, 8)])
ANGLE = polygon([(0, 0), (6, 0), (6, 0.2), (0.2, 0.2), (0.2, 4), (0, 4)])


def of_outline(outline, size, element=None, **options):
    return section_constants(Space(triangulate(outline, size=size), element or Lagrange(2)), **options)


def test_rectangle():
    """A rectangle off the origin: area, centroid, second moments, torsion constant, shear centre at the centroid."""
    found = of_outline(rectangle(3.0, 1.0, (5.0, 2.0)), 0.2)
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
    found = of_outline(CHANNEL, 0.1)
    b, h, t = 3.95, 7.9, 0.1
    eccentricity = 3.0 * b**2 / (6.0 * b + h)
    warping = t * b**3 * h**2 / 12.0 * (3.0 * b + 2.0 * h) / (6.0 * b + h)
    x, y = found.shear_centre_trefftz
    assert 0.05 - x == pytest.approx(eccentricity, rel=0.02)
    assert y == pytest.approx(4.0, abs=1e-3)
    assert found.warping_constant == pytest.approx(warping, rel=0.02)


def test_principal_axes_turn_with_the_section():
    """A section turned by 25 degrees has its principal angle turned by as much, and all else unchanged."""
    still = of_outline(ANGLE, 0.1)
    turned = of_outline(ANGLE.transformed(Placement(rotation_rad=np.radians(25.0))), 0.1)
    change = turned.principal_angle - still.principal_angle
    assert np.degrees(change) % 180.0 == pytest.approx(25.0, abs=1e-6)
    assert turned.principal_moments == pytest.approx(still.principal_moments)
    assert turned.warping_constant == pytest.approx(still.warping_constant, rel=1e-2)
