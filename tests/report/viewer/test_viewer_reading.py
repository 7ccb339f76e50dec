"""Values read from the viewer of fields, beside those in the files of the same run."""

from functools import cache

import meshio
import numpy as np
import pytest
from matplotlib.path import Path as Outline

from flangeway.mesh import PolyMesh
from flangeway.post import Stresses
from flangeway.report.figures.fields import PartFields

VALUES = {
    **{f"stress_{name}_MPa": lambda s, i=i: s.components[:, i] for i, name in enumerate(("xx", "yy", "xy", "zz"))},
    **{f"principal_{i}_MPa": lambda s, i=i: s.principal[:, i - 1] for i in (1, 2, 3)},
    "von_mises_MPa": lambda s: s.von_mises,
    "max_in_plane_shear_MPa": lambda s: s.in_plane_shear,
}
"""Fields of the page from the tensors of the files."""


@cache
def vtu(folder, part):
    """Points, cells in their own order, averages of the cells' stresses and displacements of a part's file."""
    read = meshio.read(folder / f"{part}.vtu")
    numbers = np.concatenate(read.cell_data["cell_number"]).astype(int)
    order = np.argsort(numbers)
    cells = [row for block in read.cells for row in block.data]
    cells = [cells[i] for i in order]
    # linear elements have one stress each
    stresses = Stresses(np.array([read.point_data["stress_MPa"][cell[0], [0, 1, 3, 2]] for cell in cells]))
    return read.points[:, :2], cells, stresses, read.point_data["displacement_mm"]


@pytest.mark.parametrize("method", ["fem", "vem"])
def test_values_under_the_pointer_are_those_of_the_vtu(open_page, viewer_pages, method):
    """For every field and places of both contacts, the value read is that of the same cell or point in the file."""
    page = viewer_pages(method)
    seen = set()
    opened = open_page(page)
    keys = opened.fields()
    assert len(keys) == 12
    box = opened.canvas.bounding_box()
    for name in ("left contact", "right contact"):
        opened.fly(name)
        for number, key in enumerate(keys):
            opened.choose(key)
            for share in (0.3, 0.7):
                found = opened.point(box["width"] * (0.35 + 0.02 * number), box["height"] * share)
                if found:
                    check_reading(page.parent, key, found)
                    seen.add((found["part"], key))
    assert len(seen) > 40
    assert {part for part, _ in seen} == {"wheel-left", "rail-left", "wheel-right", "rail-right"}


def check_reading(folder, key, found):
    points, cells, stresses, displacement = vtu(folder, found["part"])
    number = int(found["cell"])
    assert Outline(points[cells[number]]).contains_point((found["x"], found["y"]), radius=1e-4)
    if key.startswith("displacement_mm"):
        corners = cells[number]
        vector = displacement[corners[np.linalg.norm(points[corners] - (found["x"], found["y"]), axis=1).argmin()]]
        wanted = {"": np.linalg.norm(vector), "x": vector[0], "y": vector[1]}[key.partition(":")[2]]
        scale = np.linalg.norm(vector)
    else:
        wanted, scale = VALUES[key](stresses)[number], stresses.von_mises[number]
    assert found["value"] == pytest.approx(wanted, rel=1e-6, abs=1e-6 * scale)


def test_coordinates_are_those_of_the_pointer(opened, runs):
    """The contact is in the middle of its view, and pixels times the length of the scale bar are millimetres."""
    contact = next(c for c in runs["vem"].summary["patches"] if c["side"] == "right")
    opened.fly("right contact")
    box = opened.canvas.bounding_box()
    middle = np.array([box["width"] / 2.0, box["height"] / 2.0])
    scale = opened.mm_per_pixel()
    found = opened.point(middle[0], middle[1] + 3.0)
    drawn = np.array([found["x"], found["y"]])
    for axis, key in enumerate(("displacement_mm:x", "displacement_mm:y")):
        opened.choose(key)
        drawn[axis] += opened.point(middle[0], middle[1] + 3.0)["value"]
    assert np.allclose(drawn, np.array(contact["track_position_mm"]) - (0.0, 3.0 * scale), atol=0.03)
    below, beside = opened.point(*np.add(middle, (-100, 150))), opened.point(*np.add(middle, (100, 200)))
    moved = np.array([beside["x"] - below["x"], below["y"] - beside["y"]]) / scale
    assert np.allclose(moved, (200.0, 50.0), rtol=0.0, atol=5.0)  # strains and turns of the rail


def test_the_picture_has_the_colours_of_the_values(opened):
    """The colour at a place is that of the colour bar at the value which is read there."""
    box = opened.canvas.bounding_box()
    places = [(int(x * box["width"]), int(y * box["height"])) for x in np.linspace(0.2, 0.8, 7) for y in (0.25, 0.75)]
    opened.fly("right contact")
    for key in ("von_mises_MPa", "principal_3_MPa", "stress_xy_MPa"):
        opened.choose(key)
        picture, bar = opened.shot(), opened.shot(".viewer-colours")
        low, high = (float(opened.page.input_value(name)) for name in ("#viewer-low", "#viewer-high"))
        compared = 0
        for x, y in places:
            near = picture[y - 1 : y + 2, x - 1 : x + 2]
            if np.ptp(near, axis=(0, 1)).max() > 0.01:
                continue  # at an edge between cells colours mix
            found = opened.point(x + 0.5, y + 0.5)
            share = np.clip((found["value"] - low) / (high - low), 0.005, 0.995)
            wanted = bar[bar.shape[0] // 2, int(share * (bar.shape[1] - 2)) + 1]
            assert np.abs(picture[y, x] - wanted).max() < 0.05
            compared += 1
        assert compared > 5


def test_the_deformed_picture_is_read_where_it_is_drawn(opened, viewer_page):
    """With the motion drawn 100 times, the coordinates read are those of the cell before it moved."""
    opened.page.fill("#viewer-factor", "100")
    opened.fly("right side")
    box = opened.canvas.bounding_box()
    readings = [
        opened.point(x * box["width"], y * box["height"]) for x in (0.4, 0.45, 0.5, 0.55, 0.6) for y in (0.3, 0.6)
    ]
    readings = [found for found in readings if found]
    assert len(readings) > 2
    for found in readings:
        check_reading(viewer_page.parent, "von_mises_MPa", found)


def test_a_notch_belongs_to_no_cell(open_page, page_of):
    """A cell that is not convex is drawn and read exactly where its polygon is."""
    points = np.array(
        [[2.0, 0.0], [10.0, 0.0], [10.0, 10.0], [0.0, 10.0], [0.0, 0.0], [1.0, 0.0], [1.0, 9.0], [2.0, 9.0]]
    )
    mesh = PolyMesh(points, np.array([0, 8]), np.arange(8))
    stresses = Stresses(np.array([[1.0, 2.0, 3.0, 0.5]]))
    opened = open_page(page_of([PartFields("plate", "left", mesh, points, np.zeros((8, 2)), stresses)]))
    box = opened.canvas.bounding_box()
    centre, pixel = np.array([5.0, 5.0]), opened.mm_per_pixel()
    picture, page = opened.shot(), opened.shot("body")[2, 2]
    for place in [(0.5, 5.0), (1.5, 5.0), (1.5, 9.5), (2.5, 5.0), (9.0, 1.0), (-0.3, 5.0)]:
        inside = Outline(points).contains_point(place)
        right, up = (np.array(place) - centre) / pixel
        x, y = box["width"] / 2.0 + right, box["height"] / 2.0 - up
        found = opened.point(x, y)
        assert bool(found) == inside
        assert (np.abs(picture[int(y), int(x)] - page).max() > 0.1) == inside
        if inside:
            assert np.allclose((found["x"], found["y"]), place, atol=2.0 * pixel)
            assert found["value"] == pytest.approx(stresses.von_mises[0], rel=1e-6)
    assert opened.errors() == []
