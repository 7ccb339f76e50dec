"""Meshes and readings of Moherdaui's (2021) Tables 4 to 7; their numbers are in `flangeway reproduce torsion`."""

import pytest

from studies.torsion import SECTIONS, solve_code, torsion_mesh


@pytest.mark.parametrize("formulation", ["warping", "prandtl"])
@pytest.mark.parametrize("section", SECTIONS)
def test_linear_virtual_triangles_are_linear_triangles(formulation, section):
    """The rows VD and FD of order 1 coincide, as published."""
    virtual, finite = (solve_code(f"{method}D{section}M2O1", formulation).torsion_constant for method in "VF")
    assert virtual == pytest.approx(finite, rel=1e-12)


@pytest.mark.parametrize(("level", "error", "published"), [(1, 9.35e-3, 0.0152), (4, 6.29e-4, 0.00102)])
def test_projected_load_is_more_accurate_than_the_published_reading(level, error, published):
    """With the load as written in (3.81), VVSO1 of Prandtl's function has 0.6 times the published error."""
    constant = solve_code(f"VVSM{level}O1", "prandtl").torsion_constant
    assert abs(constant / SECTIONS["S"][1].torsion_constant - 1.0) == pytest.approx(error, rel=0.05)
    assert error < 0.7 * published


@pytest.mark.parametrize(("section", "edges"), [("S", [40, 56, 80, 160]), ("T", [48, 63, 93, 183])])
def test_triangulations_have_the_published_edges_on_the_sides(section, edges):
    """Each triangulation has the published number of edges on its boundary."""
    assert [len(torsion_mesh(section, "D", level).boundary_edges) for level in (1, 2, 3, 4)] == edges
