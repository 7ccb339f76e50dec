"""The live page's tools in a browser: address, undo, units, values at the pointer, comparison, files."""

import csv
import io
from xml.etree import ElementTree

import numpy as np
import pytest

from flangeway.cases import load_case
from flangeway.report.case_outputs import case_record
from flangeway.report.wheelset.wheelset_page import results_table
from flangeway.system.output_folder import write_together
from tests.live.conftest import STANDS


def stands_at(page, lateral):
    """Move the wheelset, and wait until its patches are there."""
    page.evaluate(f"shift({lateral})")
    page.wait_for_function(f"state.elastic?.lateral_mm === {lateral} && !state.stale && {STANDS}", timeout=120_000)


def cells(page):
    """Texts of the table of results, without differences."""
    rows = "rows => rows.slice(1).map(row => [...row.children].map(cell => cell.firstChild?.data ?? ''))"
    return [tuple(row) for row in page.locator("#tables tr").evaluate_all(rows)]


def test_a_reload_shows_the_same_wheelset(page):
    """Inputs, profiles and positions are in the address: after a reload the table and the address are the same."""
    page.select_option("#other-wheel", "AAR-1B")
    page.fill("[id='input-load.axle_load_kN']", "150")
    page.keyboard.press("Tab")
    page.evaluate("turn(2)")
    stands_at(page, 2.5)
    before, address = cells(page), page.url
    assert "load.axle_load_kN=150" in address
    page.reload()
    page.evaluate("started")
    page.wait_for_function(f"state.elastic?.lateral_mm === 2.5 && !state.stale && {STANDS}", timeout=120_000)
    assert cells(page) == before
    assert page.url == address
    assert page.input_value("[id='input-load.axle_load_kN']") == "150"
    assert page.input_value("#other-wheel") == "AAR-1B"
    assert page.inner_text("#yaw-text") == "2.0 mrad"


def test_undo_and_redo_go_through_what_was_computed(page):
    """Undo brings back position and inputs one by one, redo the later ones; a new change forgets those."""
    stands_at(page, 0)
    stands_at(page, 1)
    page.fill("[id='input-load.axle_load_kN']", "120")
    page.keyboard.press("Tab")
    page.wait_for_function("past.at(-1).includes('120') && !state.stale", timeout=120_000)
    page.click("#undo")
    page.wait_for_function("!state.inputs['load.axle_load_kN'] && state.lateral === 1 && !state.stale", timeout=120_000)
    assert page.input_value("[id='input-load.axle_load_kN']") == ""
    page.click("#undo")
    page.wait_for_function("state.lateral === 0 && !state.stale", timeout=120_000)
    page.click("#redo")
    page.wait_for_function("state.lateral === 1 && !state.stale", timeout=120_000)
    stands_at(page, 2)
    assert page.is_disabled("#redo")


def test_a_switch_of_units_converts_inputs_and_numbers(page):
    """150 kN become 33.72 kip and back; in between the table is that of the run in US units."""
    page.fill("[id='input-load.axle_load_kN']", "150")
    page.keyboard.press("Tab")
    page.evaluate("shift(1)")
    page.select_option("#units", "us")
    page.wait_for_function(
        f"state.units === 'us' && state.elastic?.lateral_mm === 1 && !state.stale && {STANDS}", timeout=120_000
    )
    load = page.input_value("[id='input-load.axle_load_kip']")
    assert float(load) == pytest.approx(150.0 / 4.4482216, rel=1e-6)
    run = load_case("wheelset", units="us", size_scale=3.0, lateral_mm=1.0, axle_load_kip=float(load)).run()
    assert cells(page) == [tuple(row) for row in results_table(run).rows]
    page.select_option("#units", "metric")
    page.wait_for_function("state.units === 'metric' && !state.stale", timeout=120_000)
    assert float(page.input_value("[id='input-load.axle_load_kN']")) == pytest.approx(150.0, rel=1e-6)


def test_a_preset_sets_profiles_and_inputs(page):
    """Heavy haul: its wheel on a 136RE under 320 kN; the lateral position follows from the load."""
    page.select_option("#preset", label="heavy haul")
    page.wait_for_function("$('wheel').value === 'heavy-haul' && !loading", timeout=60_000)
    inputs = page.evaluate("inputsNow()")
    assert inputs["track.rail"] == "136RE"
    assert inputs["load.axle_load_kN"] == "320"
    assert "position.lateral_mm" not in inputs


def test_values_at_the_pointer_are_those_that_are_drawn(page):
    """At the cell of the maximum the pointer shows the maximum pressure of the run; on a curve, its value there."""
    stands_at(page, 3)
    place = page.evaluate(
        """(() => {
            const { polygons, pressures } = state.elastic.patches.right;
            const one = places.patches.find(place => place.side === "right");
            const [x, y] = middle(polygons[pressures.indexOf(Math.max(...pressures))]), [x0, y0] = one.back(0, 0);
            const scale = one.back(1, 0)[0] - x0;
            return [(x - x0) / scale, (y0 - y) / scale];
        })()"""
    )
    page.locator("#patches").hover(position={"x": place[0], "y": place[1]})
    run = load_case("wheelset", size_scale=3.0, lateral_mm=3.0).run()
    (patch,) = (patch for patch in run.result.patches if patch.side == "right")
    pressure = float(page.inner_text("#tip").split(": ")[1].split(" MPa")[0])
    assert pressure == pytest.approx(patch.state.cells.pressures.max(), abs=0.06)
    assert page.inner_text("#tip").startswith("right crown")
    page.locator("#curves canvas").first.hover(position={"x": 150, "y": 60})
    across, value = (float(part.split(" ")[-2]) for part in page.inner_text("#tip").split(": "))
    assert value == pytest.approx(page.evaluate(f"positionAt(state.rigid, {across}).difference"), abs=1e-3)


def test_one_wheelset_is_drawn_computed_or_rigid(page):
    """While it is computed, the picture says that it is rigid; then a dot stands where each patch of the run is."""
    page.evaluate("shift(6)")
    page.evaluate("new Promise(done => requestAnimationFrame(() => requestAnimationFrame(done)))")
    assert "rigid contact" in page.inner_text("#drawn")
    stands_at(page, 6)
    assert page.inner_text("#drawn").startswith("computed")
    case = load_case("wheelset", size_scale=3.0, lateral_mm=6.0)
    patches = case.run().result.patches
    assert len(patches) == 3
    dot = page.evaluate("getComputedStyle(document.documentElement).getPropertyValue('--pressure').trim()")
    for patch in patches:
        x, y = case.track.placement(patch.side).points(patch.rail_point_mm[None])[0]
        colour = page.evaluate(
            f"""(() => {{
                const {{ back }} = places.view.find(one => one.side === "{patch.side}"), ratio = devicePixelRatio;
                const [x0, y0] = back(0, 0), scale = back(1, 0)[0] - x0;
                const at = [({x} - x0) / scale, (y0 - {y}) / scale].map(v => Math.round(v * ratio));
                const [r, g, b] = $("view").getContext("2d").getImageData(...at, 1, 1).data;
                return "#" + [r, g, b].map(v => v.toString(16).padStart(2, "0")).join("");
            }})()"""
        )
        assert colour == dot


def test_two_elastic_results_are_compared(page):
    """What is kept stays beside the next result: each number has its difference, of the kept and the new table."""
    stands_at(page, 0)
    before = cells(page)
    page.click("#keep")
    page.select_option("#wheel", "heavy-haul")
    chosen = "inputsNow()['wheelset.wheel'] === 'heavy-haul' && !loading && !state.stale"
    page.wait_for_function(f"{chosen} && {STANDS}", timeout=120_000)
    after = cells(page)
    row = next(i for i, row in enumerate(after) if row[0] == "maximum pressure, MPa")
    shown = page.locator("#tables tr").nth(row + 1).locator("small").first.inner_text()
    assert float(shown) == pytest.approx(float(after[row][1]) - float(before[row][1]), abs=0.051)
    assert float(shown) != 0.0
    page.click("#keep")
    assert page.locator("#tables small").count() == 0


def test_files_of_what_is_seen(page, tmp_path):
    """CSV of patches is that of ``flangeway run``, that of results has the table's cells; pictures are SVG and PNG."""
    stands_at(page, 3)
    run = load_case("wheelset", size_scale=3.0, lateral_mm=3.0).run()

    def downloaded(what):
        page.select_option("#what", what)
        with page.expect_download(timeout=60_000) as download:
            page.click("#export")
        return download.value.path().read_bytes()

    (file,) = write_together(tmp_path, {"patches.csv": case_record(run).files()["patches.csv"]})
    assert downloaded("table:patches.csv") == file.read_bytes()
    results = list(csv.reader(io.StringIO(downloaded("results:").decode())))
    assert [tuple(row) for row in results[1:]] == [tuple(row) for row in results_table(run).rows]
    curves = list(csv.reader(io.StringIO(downloaded("curves:").decode())))
    lateral, difference = np.array([row[:2] for row in curves[1:] if row[0]], dtype=float).T
    assert difference[-1] == pytest.approx(
        page.evaluate(f"positionAt(state.rigid, {lateral[-1]}).difference"), abs=1e-3
    )
    drawing = ElementTree.fromstring(downloaded("svg:patches"))
    paths = [path for path in drawing.iter("{http://www.w3.org/2000/svg}path") if path.get("fill") != "none"]
    assert len(paths) == page.evaluate("Object.values(state.elastic.patches).flatMap(side => side.polygons).length")
    assert downloaded("png:wheelset").startswith(b"\x89PNG")


def test_a_finger_that_moves_up_scrolls_the_page(page):
    """A vertical swipe over the picture of the wheelset scrolls the page and leaves the wheelset in its place."""
    page.set_viewport_size({"width": 390, "height": 700})
    stands_at(page, 1)
    page.evaluate("$('view').scrollIntoView()")
    box, before = page.locator("#view").bounding_box(), page.evaluate("scrollY")
    session = page.context.new_cdp_session(page)
    session.send("Emulation.setTouchEmulationEnabled", {"enabled": True})
    x, y = box["x"] + 100, box["y"] + 220
    session.send("Input.dispatchTouchEvent", {"type": "touchStart", "touchPoints": [{"x": x, "y": y}]})
    for step in range(1, 11):
        moved = [{"x": x, "y": y - 20 * step}]
        session.send("Input.dispatchTouchEvent", {"type": "touchMove", "touchPoints": moved})
    session.send("Input.dispatchTouchEvent", {"type": "touchEnd", "touchPoints": []})
    page.wait_for_timeout(300)
    assert page.evaluate("scrollY") > before + 100
    assert page.evaluate("state.lateral") == 1
