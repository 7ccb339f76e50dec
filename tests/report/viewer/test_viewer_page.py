"""The report and the viewer's controls in a browser: each does what it says, by mouse, fingers and keys."""

import numpy as np
import pytest


def test_without_webgl_a_sentence_says_where_to_look(open_page, folder):
    """A browser without WebGL shows no empty frame but the reason and where the pictures are, and no error."""
    script = "HTMLCanvasElement.prototype.getContext = () => null"
    opened = open_page(folder / "report.html", script=script)
    message = opened.page.locator(".viewer-message")
    assert message.is_visible()
    assert "WebGL" in message.inner_text()
    assert "pictures" in message.inner_text()
    assert not opened.page.locator(".viewer-body").is_visible()
    assert opened.page.locator("figure img").first.is_visible()
    assert opened.errors() == []


@pytest.mark.parametrize(("theme", "width"), [("light", 1280), ("dark", 400)])
def test_it_fits_the_window_in_both_themes(open_page, folder, theme, width):
    """The page does not scroll sideways; its ground follows the theme, the colours of values do not."""
    opened = open_page(folder / "report.html", theme, width)
    assert opened.page.evaluate("document.documentElement.scrollWidth") <= width
    assert opened.canvas.bounding_box()["width"] > 0.8 * min(width, 1000)

    def is_right(theme):
        ground = opened.shot("header")[2, 2].mean()
        return ground > 0.6 if theme == "light" else ground < 0.4

    assert is_right(theme)
    colours = opened.shot(".viewer-colours")[5, 3:-3]
    assert colours[5].mean() > 0.6
    assert colours[-5].mean() < 0.4
    other = "dark" if theme == "light" else "light"
    opened.page.get_by_role("button", name=f"Show {other}").click()
    assert opened.until(lambda: is_right(other))
    assert np.array_equal(opened.shot(".viewer-colours")[5, 3:-3], colours)
    assert opened.errors() == []


def test_it_prints(open_page, folder):
    """A printed page has the picture and the colour bar, without controls and buttons, from a dark page too."""
    opened = open_page(folder / "report.html")
    page = opened.page
    page.get_by_role("button", name="Show dark").click()
    assert len(page.pdf()) > 20_000
    page.emulate_media(media="print")
    assert opened.canvas.is_visible()
    assert page.locator(".viewer-colours").is_visible()
    assert opened.shot("header")[2, 2].mean() > 0.99
    for control in ("#viewer-field", "#theme", ".copy"):
        assert not page.locator(control).first.is_visible()


def test_tables_copy_as_text_with_tabs(open_page, folder):
    """The button of each table copies its rows as lines and its cells between tabs; that of the command copies it."""
    opened = open_page(folder / "report.html", permissions=["clipboard-read", "clipboard-write"])
    page = opened.page
    page.evaluate("document.querySelectorAll('details').forEach((each) => (each.open = true))")
    tables = page.locator("table")
    assert page.locator("caption .copy").count() == tables.count() > 4
    for i in range(tables.count()):
        tables.nth(i).locator(".copy").click()
        page.wait_for_function("i => document.querySelectorAll('.copy')[i].textContent === 'Copied'", arg=i)
        copied = page.evaluate("navigator.clipboard.readText()").replace("\r\n", "\n")
        rows = tables.nth(i).locator("tr")
        assert copied.count("\n") == rows.count()
        last = [text.strip().replace("–", "") for text in rows.last.locator("th, td").all_text_contents()]
        assert copied.splitlines()[-1].split("\t") == last
    for name, start in (("the command", "flangeway run wheelset "), ("the case file", "flangeway = 1\ncase = ")):
        button = page.get_by_role("button", name=f"Copy: {name}")
        button.click()
        page.wait_for_function(
            "name => document.querySelector('#announcement').textContent === `Copied: ${name}`", arg=name
        )
        assert page.evaluate("navigator.clipboard.readText()").replace("\r\n", "\n").startswith(start)
    assert opened.errors() == []


def test_fields_parts_lines_and_deformation_change_the_picture(opened):
    """Each control changes the pixels, and back again gives the first picture."""
    page, first = opened.page, opened.shot()
    opened.choose("stress_xy_MPa")
    assert opened.changed(first) > 0.05
    opened.choose("von_mises_MPa")
    assert opened.changed(first) == 0.0
    page.fill("#viewer-factor", "150")
    assert opened.changed(first) > 0.01
    assert float(page.input_value("#viewer-slider")) > 600
    page.locator("#viewer-slider").evaluate("s => { s.value = 0; s.dispatchEvent(new Event('input')); }")
    assert float(page.input_value("#viewer-factor")) == 0.0
    page.get_by_role("button", name="true", exact=True).click()
    assert opened.changed(first) == 0.0
    for control in ("#viewer-lines", "#viewer-smooth"):
        page.check(control)
        assert opened.changed(first) > 0.01
        page.uncheck(control)
    page.uncheck(".viewer-parts input[value=rail-left]")
    assert opened.changed(first) > 0.03
    page.check(".viewer-parts input[value=rail-left]")
    page.uncheck("#viewer-closer")
    assert opened.changed(first) > 0.1
    page.check("#viewer-closer")
    assert opened.changed(first) == 0.0


def test_the_range_of_colours_can_be_chosen(opened):
    """The full range ends at the largest value, an own one is kept, and one that makes no sense is marked."""
    page = opened.page
    robust = float(page.input_value("#viewer-high"))
    page.select_option("#viewer-range", "full")
    assert float(page.input_value("#viewer-high")) > robust
    first = opened.shot()
    page.fill("#viewer-high", "123")
    page.keyboard.press("Enter")
    assert page.input_value("#viewer-range") == "own"
    assert opened.changed(first) > 0.03
    page.fill("#viewer-high", "-5")
    page.keyboard.press("Enter")
    assert page.get_attribute("#viewer-high", "aria-invalid") == "true"


def test_mouse_moves_and_zooms(opened):
    """Dragging takes the part along with the pointer; the wheel with Ctrl zooms and keeps what is under it."""
    opened.fly("right contact")
    box = opened.canvas.bounding_box()
    place = np.array([0.5 * box["width"], 0.75 * box["height"]])
    before, scale = opened.point(*place), opened.mm_per_pixel()
    opened.page.keyboard.down("Control")
    opened.page.mouse.wheel(0, -400)
    opened.page.keyboard.up("Control")
    assert opened.until(lambda: opened.mm_per_pixel() < 0.9 * scale)
    near = opened.point(*place)
    assert np.allclose((near["x"], near["y"]), (before["x"], before["y"]), atol=scale)
    opened.page.mouse.down()
    opened.page.mouse.move(box["x"] + place[0] + 60, box["y"] + place[1] + 20, steps=4)
    opened.page.mouse.up()
    after = opened.point(*np.add(place, (60, 20)))
    assert np.allclose((after["x"], after["y"]), (near["x"], near["y"]), atol=scale)
    opened.fly("whole")
    assert opened.mm_per_pixel() > 3.0 * scale


def test_the_wheel_alone_scrolls_the_page(open_page, folder):
    """Without Ctrl the wheel over the picture scrolls the page, the picture stays as it is, and a hint says how."""
    opened = open_page(folder / "report.html")
    box, scale = opened.canvas.bounding_box(), opened.mm_per_pixel()
    opened.page.mouse.move(box["x"] + 0.5 * box["width"], box["y"] + 0.5 * box["height"])
    before = opened.page.evaluate("scrollY")
    opened.page.mouse.wheel(0, 300)
    opened.page.wait_for_function("before => scrollY > before + 200", arg=before)
    assert opened.page.locator(".viewer-hint").is_visible()
    assert opened.mm_per_pixel() == pytest.approx(scale, rel=1e-3)


def test_keys_do_what_the_mouse_does(opened):
    """Arrows move, plus and minus zoom, 0 shows all, F goes to the next field, and the value at the cross is shown."""
    page = opened.page
    opened.fly("right contact")
    opened.canvas.focus()
    page.keyboard.press("ArrowDown")
    page.keyboard.press("ArrowDown")
    first, scale = opened.read(), opened.mm_per_pixel()
    assert first["part"] == "rail-right"
    page.keyboard.press("ArrowRight")
    assert opened.read()["x"] > first["x"]
    page.keyboard.press("ArrowLeft")
    page.keyboard.press("+")
    assert opened.mm_per_pixel() < scale
    page.keyboard.press("-")
    assert opened.read() == pytest.approx(first)
    page.keyboard.press("f")
    assert page.input_value("#viewer-field") == "principal_1_MPa"
    assert opened.read()["value"] != first["value"]
    page.keyboard.press("Shift+F")
    assert page.input_value("#viewer-field") == "von_mises_MPa"
    page.keyboard.press("m")
    assert page.is_checked("#viewer-lines")
    page.wait_for_function("document.querySelector('.viewer-live').textContent.includes('rail-right')")
    page.keyboard.press("0")
    assert opened.mm_per_pixel() > 3.0 * scale


def test_controls_have_names(opened):
    """Every control has a name for screen readers, and the picture says what it shows and which keys it takes."""
    nameless = opened.page.locator("#viewer :is(button, select, input)").evaluate_all(
        "all => all.filter(e => !(e.ariaLabel || e.textContent.trim() || e.closest('label')?.textContent.trim()))"
        ".map(e => e.outerHTML)"
    )
    assert nameless == []
    assert "von Mises" in opened.canvas.get_attribute("aria-label")
    keys = opened.page.locator(f"#{opened.canvas.get_attribute('aria-describedby')}")
    assert "arrows" in keys.text_content()
