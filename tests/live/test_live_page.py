"""The live page in a browser: files are dropped, the wheelset is dragged, and numbers are those of a run."""

import base64
import io
import shutil
import statistics
import tomllib

import numpy as np
import pytest
import scipy.ndimage
from matplotlib.image import imread

from flangeway.cases import load_case
from flangeway.report.wheelset.wheelset_page import results_table
from tests.live.conftest import STANDS


def test_dropped_profiles_dragged_give_the_numbers_of_a_run(page, served, profiles):
    """Two files are dropped and the wheelset is dragged: the table is that of the case with the same inputs."""
    page.set_input_files("#files", [profiles / "my-wheel.whl", profiles / "my-rail.ban"])
    page.wait_for_function("$('wheel').value === 'my-wheel.whl' && $('rail').value === 'my-rail.ban'", timeout=60_000)
    assert all("MiniProf" in page.inner_text(f"#read-{kind}") for kind in ("wheel", "rail"))
    page.wait_for_function(STANDS, timeout=120_000)
    box = page.locator("#view").bounding_box()
    page.mouse.move(box["x"] + 200, box["y"] + 100)
    page.mouse.down()
    page.mouse.move(box["x"] + 215, box["y"] + 100, steps=5)
    page.mouse.up()
    page.wait_for_function(
        f"state.lateral > 1 && state.elastic.lateral_mm === state.lateral && {STANDS}", timeout=60_000
    )
    lateral = page.evaluate("state.lateral")
    files = {"wheel": str(profiles / "my-wheel.whl"), "rail": str(profiles / "my-rail.ban")}
    run = load_case("wheelset", size_scale=3.0, lateral_mm=lateral, **files).run()
    cells = page.locator("#tables tr").evaluate_all(
        "rows => rows.slice(1).map(row => [...row.children].map(c => c.textContent))"
    )
    assert [tuple(row) for row in cells] == [tuple(row) for row in results_table(run).rows]
    assert "lateral_mm" in page.inner_text("#command")


@pytest.mark.parametrize("served", ["us"], indirect=True)
def test_the_page_in_us_units(page):
    """Inputs, table and rigid numbers are in US units, the same as those of the run with ``--units us``."""
    page.fill("[id='input-load.axle_load_kip']", "40")
    page.keyboard.press("Tab")
    page.wait_for_function("inputsNow()['load.axle_load_kip'] === '40' && !loading", timeout=60_000)
    page.evaluate("shift(3)")
    page.wait_for_function(f"state.elastic?.lateral_mm === 3 && {STANDS}", timeout=120_000)
    run = load_case("wheelset", units="us", size_scale=3.0, lateral_mm=3.0, axle_load_kip=40.0).run()
    cells = page.locator("#tables tr").evaluate_all(
        "rows => rows.slice(1).map(row => [...row.children].map(c => c.textContent))"
    )
    assert [tuple(row) for row in cells] == [tuple(row) for row in results_table(run).rows]
    assert page.inner_text("#lateral-text") == "0.118 in"
    difference = page.evaluate("positionAt(state.rigid, 3).difference") / 25.4
    assert f"{difference:.4f} in" in page.inner_text("#rigid")
    assert page.evaluate("document.body.innerText.match(/\\d (mm|MPa|kN)\\b/)") is None


def test_options_of_a_file_are_forgotten_with_it(page, profiles, tmp_path):
    """A rail that is mirrored on the page is mirrored in the case, until another rail is chosen; the wheel stays."""
    files = [shutil.copy(profiles / f"my-{name}", tmp_path / f"other-{name}") for name in ("wheel.whl", "rail.ban")]
    page.set_input_files("#files", files)
    page.wait_for_function("$('rail').value === 'other-rail.ban' && !loading", timeout=60_000)
    page.select_option("#read-rail .mirror", "true")
    page.click("#read-rail button")
    page.wait_for_function("inputsNow()['track.rail.mirror'] === 'true' && !loading", timeout=60_000)
    assert page.input_value("#read-rail .mirror") == "true"
    page.select_option("#rail", "60E1")
    page.wait_for_function("!('track.rail.mirror' in inputsNow()) && !loading", timeout=60_000)
    assert page.is_visible("#read-wheel")
    assert page.is_hidden("#read-rail")
    assert page.is_hidden("#error")


def test_fifty_quick_changes_leave_the_last_one(page, served):
    """After fifty moves in a row the page shows the last position, and nothing else is computed."""
    page.wait_for_function(STANDS, timeout=120_000)
    page.evaluate("for (let k = 0; k <= 50; k += 1) setTimeout(() => shift(0.04 * k), 15 * k)")
    page.wait_for_function(f"state.lateral === 2 && state.elastic.lateral_mm === 2 && {STANDS}", timeout=120_000)
    assert not served.engine.computing


def test_the_slider_follows_and_no_request_leaves_this_machine(page):
    """The rigid numbers follow each of 100 positions of the slider; all requests go to the loopback address."""
    page.evaluate("state.frames = []")
    for number in range(100):
        page.evaluate(f"$('lateral').value = {-5 + 0.1 * number}; $('lateral').dispatchEvent(new Event('input'))")
        page.evaluate("new Promise(done => requestAnimationFrame(() => requestAnimationFrame(done)))")
    shown = page.inner_text("#rigid")
    expected = page.evaluate("positionAt(state.rigid, state.lateral).difference.toFixed(3)")
    assert expected in shown
    frames = page.evaluate("state.frames")
    print(f"time of a frame, ms: median {statistics.median(frames):.1f}, of {len(frames)}")
    assert len(frames) >= 90
    assert all(url.startswith(("http://127.0.0.1:", "data:", "blob:")) for url in page.requested)


def test_a_bad_file_shows_its_message(page, tmp_path):
    """What is wrong with a dropped file stands below it, and the profile stays."""
    (tmp_path / "bad.whl").write_text("no numbers here\n")
    chosen = page.input_value("#wheel")
    page.set_input_files("#files", tmp_path / "bad.whl")
    page.wait_for_function("!$('file-error').hidden", timeout=60_000)
    assert page.inner_text("#file-error").startswith("bad.whl: a file without points\n")
    assert page.input_value("#wheel") == chosen


def test_the_stress_below_the_patches_is_shown(page):
    """The chooser has the fields of the report's viewer, and the picture has their maximum."""
    page.wait_for_function(STANDS, timeout=120_000)
    page.select_option("#shown", label="von Mises stress, largest at any depth")
    pixels = "$('patches').toDataURL()"
    largest = page.evaluate(pixels)
    page.select_option("#shown", label="von Mises stress, at a depth of 3 mm")
    assert page.evaluate(pixels) != largest
    most = page.evaluate(
        "Math.max(...state.elastic.patches.left.stresses['von Mises stress, largest at any depth'].flat())"
    )
    rows = page.locator("#tables tr").evaluate_all("rows => rows.map(row => [...row.children].map(c => c.textContent))")
    stated = next(float(row[1]) for row in rows if row[0].strip() == "maximum von Mises stress, MPa")
    assert most == pytest.approx(stated, rel=0.02)


def drawn_pixels(page):
    """Colours (height, width, 4) of the picture of patches without its words and scales."""
    nothing = "CanvasRenderingContext2D.prototype.fillText = CanvasRenderingContext2D.prototype.fillRect = scaleBar"
    page.evaluate(f"{nothing} = () => {{}}; drawPatches()")
    data = page.evaluate("$('patches').toDataURL().split(',')[1]")
    return imread(io.BytesIO(base64.b64decode(data)))


@pytest.mark.parametrize("width", [1400, 390])
def test_patches_on_the_screen_are_the_cells_of_a_run(page, width):
    """Each pixel that is drawn lies on a cell under pressure of a run, and each such cell is drawn, to a pixel.

    The right rail has two patches and graded rows of 0.07, 0.39 and 0.84 mm. Both sides have one scale, and the
    darkest cell is that of the maximum pressure.
    """
    page.set_viewport_size({"width": width, "height": 900})
    page.evaluate("shift(6)")
    page.wait_for_function(f"state.elastic?.lateral_mm === 6 && {STANDS}", timeout=120_000)
    picture = drawn_pixels(page)
    height, wide = picture.shape[:2]
    run = load_case("wheelset", size_scale=3.0, lateral_mm=6.0).run()
    states = run.result.equilibrium.state.sides
    assert np.ptp(states["right"].cells.grid.widths) > 0.7
    scales = []
    for side, sign, part in (("left", -1.0, picture[:, : wide // 2]), ("right", 1.0, picture[:, wide // 2 :])):
        cells, loaded = states[side].cells, states[side].forces > 0.0
        # lengths along the surface run to the gauge side
        across, ahead = -sign * cells.grid.bounds, cells.grid.strip_bounds
        rows, strips = np.nonzero(loaded)
        left, right = np.sort(np.stack((across[rows], across[rows + 1])), axis=0)
        low, high = ahead[strips], ahead[strips + 1]
        inked = part[..., 3] > 0.9  # without the outer half of the outline
        columns, lines = (np.flatnonzero(inked.any(axis=axis)) for axis in (0, 1))
        drawn = np.array([np.ptp(columns) + 1.0, np.ptp(lines) + 1.0])
        size = np.array([right.max() - left.min(), high.max() - low.min()])
        scale = float(drawn @ size / (size @ size))
        scales.append(scale)
        assert drawn == pytest.approx(scale * size, abs=1.0)
        x = left.min() + (np.arange(part.shape[1]) + 0.5 - columns[0]) / scale
        y = high.max() - (np.arange(height) + 0.5 - lines[0]) / scale
        expected = np.zeros_like(inked)
        for ends in zip(left, right, low, high, strict=True):
            expected |= ((y >= ends[2]) & (y <= ends[3]))[:, None] & (x >= ends[0]) & (x <= ends[1])
        square = np.ones((3, 3), dtype=bool)
        assert not (inked & ~scipy.ndimage.binary_dilation(expected, square)).any()
        assert not (scipy.ndimage.binary_erosion(expected, square) & ~inked).any()
        if side == "right":
            darkest = np.where(inked & scipy.ndimage.binary_erosion(expected, square), part[..., 0], 2.0).min(axis=0)
            highest = cells.pressures[loaded].argmax()
            assert left[highest] - 1.0 / scale <= x[darkest.argmin()] <= right[highest] + 1.0 / scale
    assert scales[0] == pytest.approx(scales[1], rel=0.02)


def test_moved_while_curves_fill_in_is_computed_afterwards(page):
    """A sweep that is stopped leaves the position of the slider, not an old one."""
    page.wait_for_function(STANDS, timeout=120_000)
    page.click("#sweep")
    page.wait_for_function("state.sweep.length > 0", timeout=120_000)
    page.evaluate("shift(1.5)")
    page.click("#sweep")
    page.wait_for_function(f"state.elastic.lateral_mm === 1.5 && {STANDS}", timeout=120_000)
    assert "of 25 positions computed" in page.inner_text("#progress-text")


def test_keys_move_the_wheelset(page):
    """Arrow keys on the picture move by 0.1 mm, with Shift by 1 mm."""
    page.focus("#view")
    page.keyboard.press("ArrowRight")
    page.keyboard.press("Shift+ArrowLeft")
    assert page.evaluate("state.lateral") == pytest.approx(-0.9)


def test_a_report_asked_for_at_once_leaves_the_position_of_the_slider(page):
    """A report begins before the patches of a new position are there: both come, one after the other."""
    page.wait_for_function(STANDS, timeout=120_000)
    page.evaluate("shift(1)")
    with page.expect_download(timeout=120_000):
        page.click("#report")
    page.wait_for_function(f"state.elastic.lateral_mm === 1 && {STANDS}", timeout=120_000)


def test_the_keyboard_alone_is_enough(page, profiles, tmp_path):
    """Files, positions, yaw, a comparison, inputs, curves that are stopped, case and report, by keys; focus is seen."""
    files = [shutil.copy(profiles / f"my-{name}", tmp_path / f"keyed-{name}") for name in ("wheel.whl", "rail.ban")]
    page.on("filechooser", lambda chooser: chooser.set_files(files))

    def press(name, *keys):
        """Go on by Tab to an element, and press keys there."""
        for _ in range(90):
            page.keyboard.press("Tab")
            if page.evaluate("document.activeElement.id") == name:
                break
        seen = "const drawn = getComputedStyle(document.activeElement); return [drawn.outlineStyle, drawn.outlineWidth]"
        assert page.evaluate(f"(() => {{ {seen} }})()") == ["solid", "2px"], name
        for key in keys:
            page.keyboard.press(key)

    press("drop", "Enter")
    page.wait_for_function("$('rail').value === 'keyed-rail.ban' && !loading", timeout=60_000)
    press("other-wheel", "A")
    page.wait_for_function("state.other !== null", timeout=60_000)
    press("lateral", "ArrowRight", "ArrowRight")
    press("view", "ArrowRight", "ArrowUp", "ArrowUp")
    page.wait_for_function(f"state.elastic?.lateral_mm === 0.12 && {STANDS}", timeout=120_000)
    press("sweep", "Enter")
    page.wait_for_function("state.sweep.length > 0", timeout=120_000)
    page.keyboard.press("Enter")
    page.wait_for_function("!lasting", timeout=60_000)
    assert page.evaluate("document.activeElement.id") == "sweep"
    press("input-load.axle_load_kN", *"150")
    meaning = "getComputedStyle(document.activeElement.parentElement, '::after').content"
    assert "axle load, weight on both rails" in page.evaluate(meaning)
    with page.expect_download(timeout=60_000) as download:
        press("save", "Enter")
    saved = tomllib.loads(download.value.path().read_text())
    assert saved["wheelset"]["wheel"] == "keyed-wheel.whl"
    assert saved["position"] == {"lateral_mm": 0.12, "yaw_mrad": 0.2}
    assert saved["load"] == {"axle_load_kN": 150.0}
    with page.expect_download(timeout=120_000) as download:
        press("report", "Enter")
    assert "150 kN" in download.value.path().read_text()
    press("copy", "Enter")
    page.wait_for_function("$('command').textContent.includes('axle_load_kN=150')", timeout=60_000)


@pytest.mark.parametrize("width", [1400, 390])
def test_the_page_fits_its_window(page, width):
    """Nothing is wider than the window."""
    page.set_viewport_size({"width": width, "height": 900})
    page.wait_for_function(STANDS, timeout=120_000)
    assert page.evaluate("document.documentElement.scrollWidth") <= width
