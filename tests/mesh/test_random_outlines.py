"""Random outlines of lines and arcs through triangulation and dual polygons."""

import numpy as np
import pytest
from hypothesis import assume, given, settings
from hypothesis import strategies as st

from flangeway.errors import InputError
from flangeway.geometry import Arc, Line, Outline
from flangeway.mesh import check, dual, triangulate


@st.composite
def outlines(draw):
    """Star of 3 to 9 sides about a point, some of them arcs of up to half of their chord in height."""
    n = draw(st.integers(3, 9))
    radii = np.array(draw(st.lists(st.floats(0.3, 1.0), min_size=n, max_size=n)))
    bulges = draw(st.lists(st.sampled_from([0.0, 0.0, 0.02, -0.02, 0.15, -0.15, 0.4]), min_size=n, max_size=n))
    size = draw(st.sampled_from([1e-2, 1.0, 1e3]))
    angles = draw(st.floats(0.0, 6.0)) + 2.0 * np.pi * np.arange(n) / n
    corners = size * radii[:, None] * np.column_stack((np.cos(angles), np.sin(angles)))
    corners += size * np.array(draw(st.tuples(st.floats(-20.0, 20.0), st.floats(-20.0, 20.0))))
    ends = np.roll(corners, -1, axis=0)
    return [side(*each) for each in zip(corners, ends, bulges, strict=True)]


def side(start, end, bulge):
    """Line, or the arc whose height over its chord is `bulge` chords, outwards if positive."""
    if bulge == 0.0:
        return Line(tuple(start), tuple(end))
    chord = end - start
    outwards = np.array([chord[1], -chord[0]])
    height = abs(bulge)
    to_centre = (0.25 / height - height) / 2.0
    centre = (start + end) / 2.0 - np.sign(bulge) * to_centre * outwards
    return Arc(tuple(start), tuple(end), tuple(centre), counter_clockwise=bulge > 0.0)


def drawn(segments):
    """Outline, or None where the arcs of a star meet each other, which must be reported in three parts."""
    refused = None
    try:
        return Outline.from_segments(segments, [f"side {i}" for i in range(len(segments))])
    except InputError as error:
        refused = error
    assert refused.given
    assert refused.allowed
    assert refused.advice
    return None


@settings.get_profile("costly")
@given(segments=outlines(), fineness=st.sampled_from([2.0, 5.0, 12.0]))
def test_meshes_of_random_outlines_keep_the_area(segments, fineness):
    """Triangles and their dual fill the polygon of the boundary points; these are on the outline, names and all.

    The area is the outline's up to what chords cut off its arcs.
    """
    outline = drawn(segments)
    assume(outline is not None)  # too many refusals fail Hypothesis' health check
    size = outline.size / fineness
    mesh = triangulate(outline, size=size)
    assert (mesh.cell_areas > 0.0).all()
    assert set(mesh.edge_sets) == set(outline.names)
    rim = mesh.points[mesh.boundary_edges]
    rim = rim - mesh.points[0]  # the area keeps its digits
    within = float(np.sum(rim[:, 0, 0] * rim[:, 1, 1] - rim[:, 1, 0] * rim[:, 0, 1])) / 2.0
    polygons = dual(mesh)
    check(mesh, region_area=within)
    check(polygons, region_area=within)
    assert polygons.cell_areas.sum() == pytest.approx(mesh.cell_areas.sum(), rel=1e-10)
    assert polygons.n_cells == mesh.n_points
    _, _, distances = outline.closest(mesh.points[mesh.boundary_edges[:, 0]])
    assert np.abs(distances).max() < 1e-9 * outline.size
    sides = zip(outline.segments, outline.names, strict=True)
    cut_off = sum(maximum_cut(segment, mesh, name) for segment, name in sides)
    assert abs(within - outline.area) <= cut_off + 1e-9 * outline.area


def maximum_cut(segment, mesh, name):
    """Area between an arc and the chords of its edges, (r^2 / 2) (t - sin t) of each."""
    if isinstance(segment, Line):
        return 0.0
    edges = mesh.points[mesh.edge_sets[name]]
    radius = np.hypot(*np.subtract(segment.start, segment.centre))
    lengths = np.hypot(*(edges[:, 1] - edges[:, 0]).T)
    turns = 2.0 * np.arcsin(np.minimum(lengths / (2.0 * radius), 1.0))
    return float(np.sum(radius**2 / 2.0 * (turns - np.sin(turns))) * (1.0 + 1e-6))
