"""Pages with the viewer of fields in a browser without a window, and what is asked of them."""

import io

import numpy as np
import pytest
from matplotlib.image import imread

from flangeway.report import part_fields, write_case
from flangeway.report.scenes import wheelset_scene
from flangeway.report.viewer import field_viewer

DRIVER_NOTE = "GL Driver Message"
"""Of Chromium's software drawing, when a picture of the page is taken."""


class Opened:
    """A page with the viewer, what the browser complained of, and what it asked for."""

    def __init__(self, browser, path, theme="light", width=1280, script=None, **more):
        self.context = browser.new_context(
            viewport={"width": width, "height": 900}, color_scheme=theme, reduced_motion="reduce", **more
        )
        self.context.set_default_timeout(180_000)  # a busy machine draws slowly
        self.page = self.context.new_page()
        self.complaints, self.requests = [], []
        self.page.on("console", lambda message: self.complaints.append(message.text))
        self.page.on("pageerror", lambda error: self.complaints.append(str(error)))
        self.page.on("request", lambda request: self.requests.append(request.url))
        if script:
            self.page.add_init_script(script)
        self.page.goto(path.as_uri())
        self.page.evaluate("document.querySelectorAll('section > details').forEach((fold) => (fold.open = true))")
        self.page.wait_for_selector("#viewer:not([data-state=loading])", state="attached")
        self.canvas = self.page.locator("#viewer-canvas")
        if self.canvas.is_visible():
            self.canvas.scroll_into_view_if_needed()

    def errors(self):
        return [text for text in self.complaints if DRIVER_NOTE not in text]

    def fields(self):
        return self.page.locator("#viewer-field option").evaluate_all("all => all.map(o => o.value)")

    def choose(self, key):
        self.page.select_option("#viewer-field", key)

    def fly(self, name):
        self.page.get_by_role("button", name=name, exact=True).click()

    def shot(self, selector="#viewer-canvas"):
        """Colours of an element's pixels, (height, width, 3) from 0 to 1."""
        self.page.mouse.move(1.0, 1.0)
        return imread(io.BytesIO(self.page.locator(selector).screenshot()))[:, :, :3]

    def until(self, condition):
        """Wait for what the page does in its own time, on a busy machine later; whether it has happened."""
        for _ in range(1000):
            if condition():
                return True
            self.page.wait_for_timeout(100)
        return False

    def changed(self, before):
        """Share of the picture's pixels that differ from those of an earlier one."""
        return (np.abs(before - self.shot()).max(axis=2) > 0.02).mean()

    def point(self, x, y):
        """Point at a pixel of the picture, and return what is read there by name, or nothing."""
        self.canvas.hover(position={"x": x, "y": y})
        return self.read()

    def read(self):
        script = "all => Object.fromEntries(all.map(e => [e.className.replace('reading-', ''), e.value]))"
        found = self.page.locator(".viewer-reading data").evaluate_all(script)
        return {name: value if name == "part" else float(value) for name, value in found.items()}

    def mm_per_pixel(self):
        bar = self.page.locator(".viewer-length")
        return float(bar.inner_text().removesuffix("mm")) / bar.bounding_box()["width"]


@pytest.fixture
def open_page(browser):
    """Opener of pages, which are closed after the test."""
    pages = []

    def opener(path, *given, **named):
        pages.append(Opened(browser, path, *given, **named))
        return pages[-1]

    yield opener
    for page in pages:
        page.context.close()


@pytest.fixture(scope="session")
def folder(runs, tmp_path_factory):
    """All files of the run with virtual elements, the report among them."""
    out = tmp_path_factory.mktemp("viewer") / "vem"
    write_case(runs["vem"], out)
    return out


@pytest.fixture(scope="session")
def viewer_page(runs, tmp_path_factory):
    """Page with nothing but the viewer, sooner there than a report, of the run with virtual elements."""
    result = runs["vem"].result
    return write_page(
        tmp_path_factory.mktemp("viewer") / "page.html", wheelset_scene(list(part_fields(result)), result.patches)
    )


@pytest.fixture
def opened(open_page, viewer_page):
    """That page, newly opened."""
    return open_page(viewer_page)


@pytest.fixture
def page_of(tmp_path):
    """Writer of such a page for other parts."""
    return lambda parts: write_page(tmp_path / "page.html", wheelset_scene(parts, []))


def write_page(path, scene):
    path.write_text(
        '<!DOCTYPE html>\n<html lang="en"><head><meta charset="utf-8"><title>Fields</title>\n'
        '<meta name="viewport" content="width=device-width, initial-scale=1"></head>\n'
        f"<body>\n{field_viewer(scene)}</body></html>\n",
        encoding="utf-8",
    )
    return path
