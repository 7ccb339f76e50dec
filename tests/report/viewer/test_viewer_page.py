"""The report as a whole, in a browser."""

import numpy as np
import pytest


def test_without_webgl_a_sentence_says_where_to_look(open_page, folder):
    """A browser without WebGL shows no empty frame but the reason and where the pictures are, and no error."""
    script = "HTMLCanvasElement.prototype.getContext = () => null"
    opened = open_page(folder / "report.html", script=script)
    message = opened.page.locator(".viewer-message")
    assert message.is_visible()
    assert "WebGL" in message.inner_text()
    assert "figures below" in message.inner_text()
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
    for name, start in (("the command", "flangeway run wheelset-tangent"), ("the case file", "flangeway = 1\ncase = ")):
        button = page.get_by_role("button", name=f"Copy: {name}")
        button.click()
        page.wait_for_function(
            "name => document.querySelector('#announcement').textContent === `Copied: ${name}`", arg=name
        )
        assert page.evaluate("navigator.clipboard.readText()").replace("\r\n", "\n").startswith(start)
    assert opened.errors() == []
