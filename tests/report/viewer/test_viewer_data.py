"""What the viewer of fields packs into a page, unpacked again without the viewer's program."""

import base64
import json
import re
import zlib
from dataclasses import replace

import numpy as np
import pytest

from flangeway.errors import InputError
from flangeway.report import part_fields
from flangeway.report.scenes import wheelset_scene
from flangeway.report.viewer import Scene, View, field_viewer, packed_parts
from flangeway.report.viewer.packing import json_in_script
from flangeway.report.viewer.scene_model import DISPLACEMENT

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
