"""Values read from the viewer of fields, in the picture's colours, in front where heights differ; its data."""

import base64
import json
import re
import zlib
from dataclasses import replace

import numpy as np
import pytest
from matplotlib.path import Path as Outline

from flangeway.errors import InputError
from flangeway.mesh import PolyMesh
from flangeway.post import Stresses
from flangeway.report import part_fields
from flangeway.report.scenes import wheelset_scene
from flangeway.report.viewer import Scene, ShownField, View, field_viewer, packed_parts
from flangeway.report.viewer.packing import json_in_script
from flangeway.report.viewer.scene_model import DISPLACEMENT, ShownPart
from flangeway.types import Floats

from .conftest import write_page


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


def test_a_notch_belongs_to_no_cell(open_page, page_of):
    """A cell that is not convex is drawn and read exactly where its polygon is."""
    points = np.array(
        [[2.0, 0.0], [10.0, 0.0], [10.0, 10.0], [0.0, 10.0], [0.0, 0.0], [1.0, 0.0], [1.0, 9.0], [2.0, 9.0]]
    )
    mesh = PolyMesh(points, np.array([0, 8]), np.arange(8))
    stresses = Stresses(np.array([[1.0, 2.0, 3.0, 0.5]]))
    part = ShownPart("plate", mesh, {DISPLACEMENT: np.zeros((8, 2))}, {"stresses": stresses.components})
    opened = open_page(page_of([part]))
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


FIELD = "pressure_MPa"


def plate(name, low, high, height, value):
    """A square cell at a height."""
    points: Floats = np.array([[low, low], [high, low], [high, high], [low, high]], dtype=float)
    mesh = PolyMesh(points, np.array([0, 4], dtype=np.int32), np.arange(4, dtype=np.int32))
    return ShownPart(name, mesh, cell_arrays={FIELD: np.array([[value]])}, heights=np.full(4, height))


@pytest.fixture
def plates(open_page, tmp_path):
    """A small plate 20 mm above a large one."""
    scene = Scene(
        [plate("above", 40.0, 60.0, 20.0, 700.0), plate("below", 0.0, 100.0, 0.0, 5.0)],
        [ShownField(FIELD, "contact pressure", "MPa", "Contact", FIELD, "value")],
        axes=("x", "z", "y"),
    )
    return open_page(write_page(tmp_path / "page.html", scene))


def test_what_is_in_front_is_read_from_above_and_tilted(plates):
    """Tilted, the upper plate stands higher in the picture than from above; each view reads the plate in front."""
    box = plates.canvas.bounding_box()
    middle = box["width"] / 2, box["height"] / 2

    def heights_of_the_upper():
        rows = [middle[1] + step for step in range(-200, 201, 4)]
        found = [plates.point(middle[0], row) for row in rows]
        return [row for row, each in zip(rows, found, strict=True) if each.get("part") == "above"], found

    tilted, found = heights_of_the_upper()
    assert {each["value"] for each in found if each.get("part") == "above"} == {700.0}
    assert {round(each["y"], 6) for each in found if each.get("part") == "below"} == {0.0}
    before = plates.shot()
    plates.page.get_by_role("button", name="from above").click()
    assert plates.changed(before) > 0.05
    above, _ = heights_of_the_upper()
    assert np.mean(tilted) < np.mean(above) - 20.0
    assert np.mean(above) == pytest.approx(middle[1], abs=4.0)
    read = plates.point(*middle)
    assert (read["part"], read["x"], read["z"], read["y"]) == pytest.approx(("above", 50.0, 50.0, 20.0), abs=0.3)
    plates.canvas.press("t")
    assert plates.page.get_by_role("button", name="from above").is_visible()
    assert plates.errors() == []


EPS = np.finfo(np.float32).eps


def unpack(headers, text):
    """Arrays of each part by name."""
    data = zlib.decompress(base64.b64decode(text, validate=True))
    start, parts = 0, []
    for described in headers:
        arrays = {}
        for name, kind, count, *_ in described["arrays"]:
            planes = np.frombuffer(data, np.uint8, 4 * count, start).reshape(4, count)
            arrays[name] = np.ascontiguousarray(planes.T).view(f"<{kind}").ravel()
            start += 4 * count
        parts.append(arrays)
    assert start == len(data)
    return parts


def test_all_arrays_come_back_in_32_bits(runs):
    """Cells come back exactly; points, displacements and stresses to 32 bits."""
    parts = list(part_fields(runs["vem"].result))
    headers, text = packed_parts(wheelset_scene(parts, []).parts)
    assert [part["name"] for part in headers] == [part.name for part in parts]
    for part, described, arrays in zip(parts, headers, unpack(headers, text), strict=True):
        assert np.array_equal(arrays["sizes"], part.mesh.cell_sizes)
        assert np.array_equal(np.cumsum(arrays["corners"], dtype=np.uint32), part.mesh.cell_points)
        points = arrays["points"].reshape(-1, 2) + np.array(described["origin"])
        size = np.ptp(part.mesh.points, axis=0).max()
        assert np.abs(points - part.mesh.points).max() <= EPS * size
        displacement = arrays["displacement"].reshape(2, -1).T
        assert np.allclose(displacement, part.point_arrays[DISPLACEMENT], rtol=EPS, atol=0.0)
        assert np.allclose(arrays["stresses"].reshape(4, -1).T, part.cell_arrays["stresses"], rtol=EPS, atol=0.0)


def test_json_cannot_end_its_script():
    """Text that would end a script element is written otherwise and read as what it was."""
    value = {"name": "</script><b>"}
    text = json_in_script(value)
    assert "<" not in text
    assert json.loads(text) == value


def test_the_fragment_holds_all_it_needs(runs):
    """The fragment has its views, its data, the libraries with their licences, and ends each script once."""
    parts = list(part_fields(runs["vem"].result))
    scene = replace(wheelset_scene(parts, []), views=[View("left contact", (-1.0, 2.0), 30.0)])
    text = field_viewer(scene, "See <below>.")
    header = json.loads(re.search(r'id="viewer-header">(.*?)</script>', text, re.S)[1])
    assert header["views"] == [{"name": "left contact", "centre": [-1.0, 2.0], "width": 30.0}]
    data = re.search(r'id="viewer-data">(.*?)</script>', text, re.S)[1]
    assert len(unpack(header["parts"], data)) == len(parts)
    assert "See &lt;below&gt;." in text
    for words in ("three.js 0.187.0", "Flatbush 4.7.0", "The MIT License", "ISC License"):
        assert words in text
    assert text.count("</script") == text.count("<script") == 4
    assert len(text) < 3.5e6


def test_no_parts_are_refused():
    """A viewer of nothing is refused."""
    with pytest.raises(InputError, match="no parts"):
        field_viewer(Scene([], []))
