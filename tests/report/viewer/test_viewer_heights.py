"""A picture with heights: it can be turned, and what is in front is read."""

import numpy as np
import pytest

from flangeway.mesh import PolyMesh
from flangeway.report.viewer import Scene, ShownField, ShownPart
from flangeway.types import Floats

from .conftest import write_page

FIELD = "pressure_MPa"


def plate(name, low, high, height, value):
    """A square cell at a height."""
    points: Floats = np.array([[low, low], [high, low], [high, high], [low, high]], dtype=float)
    mesh = PolyMesh(points, np.array([0, 4], dtype=np.int32), np.arange(4, dtype=np.int32))
    return ShownPart(name, mesh, cell_arrays={FIELD: np.array([[value]])}, heights=np.full(4, height))


@pytest.fixture
def opened(open_page, tmp_path):
    """A small plate 20 mm above a large one."""
    scene = Scene(
        [plate("above", 40.0, 60.0, 20.0, 700.0), plate("below", 0.0, 100.0, 0.0, 5.0)],
        [ShownField(FIELD, "contact pressure", "MPa", "Contact", FIELD, "value")],
        axes=("x", "z", "y"),
    )
    return open_page(write_page(tmp_path / "page.html", scene))


def test_what_is_in_front_is_read_from_above_and_tilted(opened):
    """Tilted, the upper plate stands higher in the picture than from above; each view reads the plate in front."""
    box = opened.canvas.bounding_box()
    middle = box["width"] / 2, box["height"] / 2

    def heights_of_the_upper():
        rows = [middle[1] + step for step in range(-200, 201, 4)]
        found = [opened.point(middle[0], row) for row in rows]
        return [row for row, each in zip(rows, found, strict=True) if each.get("part") == "above"], found

    tilted, found = heights_of_the_upper()
    assert {each["value"] for each in found if each.get("part") == "above"} == {700.0}
    assert {round(each["y"], 6) for each in found if each.get("part") == "below"} == {0.0}
    before = opened.shot()
    opened.page.get_by_role("button", name="from above").click()
    assert opened.changed(before) > 0.05
    above, _ = heights_of_the_upper()
    assert np.mean(tilted) < np.mean(above) - 20.0
    assert np.mean(above) == pytest.approx(middle[1], abs=4.0)
    read = opened.point(*middle)
    assert (read["part"], read["x"], read["z"], read["y"]) == pytest.approx(("above", 50.0, 50.0, 20.0), abs=0.3)
    opened.canvas.press("t")
    assert opened.page.get_by_role("button", name="from above").is_visible()
    assert opened.errors() == []
