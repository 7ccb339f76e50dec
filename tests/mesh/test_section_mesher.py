"""Meshes of sections of one part and of several."""

import numpy as np
import pytest

from flangeway.errors import InputError
from flangeway.geometry import Region, Section, circle, rectangle, square
from flangeway.mesh import Refinement, check, dual_section, triangulate_section


def test_one_part_with_holes_has_its_cell_set_and_names():
    """A square with a square hole: the mesh has the region's area, one cell set, and the loops' edge sets."""
    section = Section({"box": Region(square(4.0), (square(2.0),))})
    mesh = triangulate_section(section, size=0.5)
    check(mesh)
    assert mesh.cell_areas.sum() == pytest.approx(12.0, rel=1e-12)
    np.testing.assert_array_equal(mesh.cell_set("box"), np.arange(mesh.n_cells))
    assert set(mesh.edge_sets) == {"bottom", "right", "top", "left"}


def test_parts_that_touch_share_their_points():
    """A flange on a wider web, joined along a part of a side, is one connected mesh with both parts' areas."""
    web = Region(rectangle(2.0, 6.0, (0.0, -3.0)))
    flange = Region(rectangle(6.0, 1.0, (0.0, 0.5)))
    mesh = triangulate_section(Section({"web": web, "flange": flange}), size=0.5)
    check(mesh)
    areas = [mesh.cell_areas[mesh.cell_set(name)].sum() for name in ("web", "flange")]
    np.testing.assert_allclose(areas, (12.0, 6.0), rtol=1e-12)
    lengths = np.hypot(*np.diff(mesh.points[mesh.boundary_edges], axis=1)[:, 0].T)
    assert lengths.sum() == pytest.approx(2.0 + 2 * 6.0 + 4.0 + 6.0 + 2 * 1.0, rel=1e-9)


def test_an_inclusion_fills_a_hole():
    """A disc in a hole of the same arcs, refined about a point: no boundary is left between them."""
    core = Region(circle(1.0))
    shell = Region(square(4.0), (circle(1.0),))
    near = Refinement(np.array([[1.0, 0.0]]), 0.05, 0.3)
    mesh = triangulate_section(Section({"shell": shell, "core": core}), size=0.4, refinements=[near])
    check(mesh)
    assert mesh.cell_areas.sum() == pytest.approx(16.0, rel=1e-12)
    assert np.abs(mesh.points[mesh.boundary_edges]).max(axis=2) == pytest.approx(2.0)
    assert np.hypot(*np.diff(mesh.points[mesh.edges], axis=1)[:, 0].T).min() < 0.06


def test_overlapping_parts_are_refused_with_the_place():
    """Two squares that overlap in one of side 1 about (1.5, 1.5) are refused by name and place."""
    parts = {"a": Region(square(2.0, (1.0, 1.0))), "b": Region(square(2.0, (2.0, 2.0)))}
    with pytest.raises(InputError, match=r"parts a and b, which overlap about \(1.5, 1.5\)"):
        triangulate_section(Section(parts), size=0.5)


def test_duals_of_parts_are_glued_where_they_touch():
    """Polygons of three parts, two of which meet at a point of the third, keep areas, sets and boundary length."""
    section = Section(
        {
            "base": Region(rectangle(4.0, 1.0, (0.0, -0.5))),
            "left": Region(rectangle(2.0, 1.0, (-1.0, 0.5))),
            "right": Region(rectangle(2.0, 1.0, (1.0, 0.5))),
        }
    )
    triangles = triangulate_section(section, size=0.3)
    polygons = dual_section(triangles)
    check(polygons)
    for name, area in (("base", 4.0), ("left", 2.0), ("right", 2.0)):
        assert polygons.cell_areas[polygons.cell_set(name)].sum() == pytest.approx(area, rel=1e-12)
    lengths = np.hypot(*np.diff(polygons.points[polygons.boundary_edges], axis=1)[:, 0].T)
    assert lengths.sum() == pytest.approx(12.0, rel=1e-12)
    assert {name: len(pairs) for name, pairs in polygons.edge_sets.items()} == {
        name: 2 * len(pairs) for name, pairs in triangles.edge_sets.items()
    }
