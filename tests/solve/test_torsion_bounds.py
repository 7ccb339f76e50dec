"""The two formulations of torsion enclose the torsion constant on curved meshes."""

import math

import pytest

from flangeway import Lagrange, Space, Torsion, solve_torsion, triangulate
from flangeway.geometry import circle


@pytest.mark.parametrize(("order", "width"), [(1, 2e-2), (2, 3e-5), (3, 1e-6)])
def test_an_annulus(order: int, width: float) -> None:
    """Prandtl's constant is below that of the warping function, and both are within the discretisation's error."""
    outer, bore = circle(2.0), circle(1.0)
    mesh = triangulate(outer, size=0.5, holes=[bore], outline=[outer, bore])
    lower, upper = (
        solve_torsion(Torsion(Space(mesh, Lagrange(order)), formulation=formulation)).torsion_constant
        for formulation in ("prandtl", "warping")
    )
    assert lower < upper
    assert lower / (7.5 * math.pi) == pytest.approx(1.0, abs=1.5 * width)
    assert upper - lower < width * upper


def test_holes_of_order_1_are_polygons() -> None:
    """At order 1 a curved and a straight mesh have one geometry, and so the same constants."""
    outer, bore = circle(2.0), circle(1.0)
    mesh = triangulate(outer, size=0.6, holes=[bore], outline=[outer, bore])
    problems = [Torsion(Space(each, Lagrange(1)), formulation="prandtl") for each in (mesh, mesh.straight())]
    curved, straight = (solve_torsion(each).torsion_constant for each in problems)
    assert curved == straight
    n = len(problems[0].boundary.holes[0])
    inscribed = n / 2.0 * math.sin(2.0 * math.pi / n)
    assert problems[0].boundary.hole_areas == pytest.approx([inscribed], rel=1e-3)
