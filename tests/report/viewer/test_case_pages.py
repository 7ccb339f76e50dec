"""The reports of cases of bodies and of sections in a browser, beside the files of the same runs."""

from functools import cache

import meshio
import numpy as np
import pytest
from matplotlib.path import Path as Outline

from flangeway.cases import CASES, load_case
from flangeway.post import Stresses
from flangeway.report.case_outputs import write_case

SQUARE = {"rectangle": {"width_mm": 10.0, "height_mm": 10.0}}
STACK = {
    "thickness_mm": 2.0,
    "bodies": [
        {"name": "upper", **SQUARE, "shift_mm": (0.0, 10.1), "size_mm": 3.0, "order": 2},
        {"name": "lower", **SQUARE, "size_mm": 2.5, "method": "vem"},
    ],
    "supports": [{"body": "upper", "edges": "top"}, {"body": "lower", "edges": "bottom"}],
    "motions": [{"body": "upper", "push_N": (0.0, -3000.0)}],
    "contacts": [
        {"secondary": "upper", "secondary_edges": "bottom", "primary": "lower", "primary_edges": "top"},
    ],
    "steps": {"number": 2},
}
INPUTS = {
    "cook": {},
    "torsion": {"size": 12.0},
    "two-bodies": STACK,
    "rolling-patch": {
        "patch": {"cells_along": 12, "cells_across": 10},
        "motion": {"lateral_creepage": 5e-4, "curve_points": 3},
    },
}
FILES = {
    "cook": {"membrane": "membrane.vtu"},
    "torsion": {"section": "section.vtu"},
    "two-bodies": {"upper": "1-upper.vtu", "lower": "2-lower.vtu"},
    "rolling-patch": {"patch": "patch.vtu"},
}
N_FIELDS = {"cook": 12, "torsion": 5, "two-bodies": 12, "rolling-patch": 5}
STRESS = {
    **{f"stress_{name}_MPa": lambda s, i=i: s.components[:, i] for i, name in enumerate(("xx", "yy", "xy", "zz"))},
    "max_in_plane_shear_MPa": lambda s: s.in_plane_shear,
    **{f"principal_{i}_MPa": lambda s, i=i: s.principal[:, i - 1] for i in (1, 2, 3)},
}
"""Stresses that the files do not hold, from those that they do."""


@pytest.fixture(scope="module")
def folders(tmp_path_factory):
    """Folder of a run's files by the name of the case."""

    @cache
    def folder(name):
        run = (CASES[name].from_values(INPUTS[name]) if name in CASES else load_case(name)).run()
        assert run.status.converged
        out = tmp_path_factory.mktemp(name)
        write_case(run, out)
        return out

    return folder


@cache
def vtu(path):
    """Points, cells, number of each cell in the problem, and arrays of a file."""
    read = meshio.read(path)
    cells = [row for block in read.cells for row in block.data]
    data = {name: np.concatenate(values) for name, values in read.cell_data.items()}
    numbers = data["cell_number"].astype(int)
    arrays = dict(read.point_data)
    for name in [name for name in arrays if name.startswith("shear_stress")]:
        # the page shows averages: of what is linear in triangles, the means of the corners
        at_corners = arrays.pop(name)
        data[name] = np.array([at_corners[cell].mean(axis=0) for cell in cells])
    return read.points[:, :2], cells, numbers, arrays, data


def wanted_values(arrays, key):
    """Values of a field by its key, from the arrays of a file."""
    if key in STRESS:
        return STRESS[key](Stresses(arrays["stress_MPa"][:, [0, 1, 3, 2]]))
    name, _, component = key.partition(":")
    values = arrays[name]
    if values.ndim == 1:
        return values
    return {"": np.linalg.norm(values, axis=1), "x": values[:, 0], "y": values[:, 1]}[component]


def check_reading(path, key, found):
    """The value read at a place is that of the file: at the nearest point of the cell there, or in that cell."""
    points, cells, numbers, at_points, at_cells = vtu(path)
    place = np.array([found["x"], found["y"]])
    there = [cells[i] for i in np.flatnonzero(numbers == int(found["cell"]))]
    mine = [cell for cell in there if Outline(points[cell]).contains_point(place, radius=1e-3)]
    assert mine
    on_cells = key.partition(":")[0] in at_cells
    values = wanted_values(at_cells if on_cells else at_points, key)
    scale = np.abs(values).max()
    if on_cells:
        wanted = values[np.flatnonzero(numbers == int(found["cell"]))]
    elif "point" in found:
        corners = np.concatenate(there)
        wanted = values[[corners[np.linalg.norm(points[corners] - place, axis=1).argmin()]]]
    else:
        wanted = values[np.concatenate(there)]
    assert wanted == pytest.approx(np.full(len(wanted), found["value"]), rel=2e-6, abs=2e-6 * scale)


@pytest.mark.parametrize("name", INPUTS)
def test_the_page_of_a_case_shows_what_its_files_hold(open_page, folders, name):
    """Every field reads as in the VTU files and others look otherwise, without complaints and without network."""
    folder = folders(name)
    opened = open_page(folder / "report.html", width=1152)
    assert opened.page.locator("#viewer").get_attribute("data-state") == "ready"
    box, first, seen = opened.canvas.bounding_box(), opened.shot(), set()
    keys = opened.fields()
    assert len(keys) == N_FIELDS[name]
    for number, key in enumerate(keys):
        opened.choose(key)
        for y in (0.2, 0.8) if name == "two-bodies" else (0.5,):
            found = opened.point((0.49 + 0.002 * number) * box["width"], y * box["height"])
            check_reading(folder / FILES[name][found["part"]], key, found)
            seen.add((found["part"], key))
    assert seen == {(part, key) for part in FILES[name] for key in keys}
    assert opened.changed(first) > 0.02
    assert opened.errors() == []
    assert [url for url in opened.requests if not url.startswith(("data:", "blob:"))] == [
        (folder / "report.html").as_uri()
    ]
    # a section does not move in its plane, nor do half-spaces
    for control in ("#viewer-slider", "#viewer-true"):
        assert opened.page.locator(control).is_visible() == (name in ("cook", "two-bodies"))
    assert opened.page.locator(".viewer-parts").is_visible() == (name == "two-bodies")
