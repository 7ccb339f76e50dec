"""The built site, opened from the disk in a browser: search finds, formulas are shown, nothing is fetched."""

import os
import subprocess
import sys
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[2]
pytestmark = pytest.mark.ci


@pytest.fixture(scope="module")
def site(tmp_path_factory):
    """Build the site; a warning, such as of a broken link, is an error."""
    pytest.importorskip("material")
    folder = tmp_path_factory.mktemp("site")
    command = [sys.executable, "-m", "mkdocs", "build", "--strict", "--quiet", "--site-dir", str(folder)]
    subprocess.run(command, cwd=ROOT, check=True, env=os.environ | {"NO_MKDOCS_2_WARNING": "1"})
    return folder


@pytest.fixture
def opened(site, browser):
    """Open pages of the site; what they ask for that is not on the disk is kept."""
    pages = []

    def open_page(name, width=1400):
        page = browser.new_page(viewport={"width": width, "height": 900})
        page.set_default_timeout(180_000)  # a busy machine draws slowly
        pages.append(page)
        page.elsewhere = []
        page.on("request", lambda request: page.elsewhere.append(request.url))
        page.goto((site / name).as_uri())
        page.wait_for_load_state("load")
        return page

    yield open_page
    for page in pages:
        assert [url for url in page.elsewhere if not url.startswith(("file:", "data:", "blob:"))] == []
        page.close()


def test_search_works_from_the_disk(opened):
    """Words of one page, typed into the search, lead to that page."""
    page = opened("index.html")
    page.click(".md-search__input")
    page.keyboard.type("wavenumber")
    page.wait_for_selector(".md-search-result__item", state="attached")
    links = page.eval_on_selector_all(".md-search-result__link", "links => links.map(link => link.href)")
    assert any("theory/three-dimensions.html" in link for link in links), links


@pytest.mark.parametrize("width", [1400, 390])
@pytest.mark.parametrize("name", ["theory/contact.html", "theory/rolling.html", "theory/elasticity.html"])
def test_formulas_are_shown_without_a_script_and_none_is_wider_than_the_page(opened, name, width):
    """Formulas are MathML of some size, no TeX is left in the text, and the page does not scroll sideways."""
    page = opened(name, width)
    heights = page.eval_on_selector_all("math", "all => all.map(each => each.getBoundingClientRect().height)")
    assert len(heights) > 15
    assert min(heights) > 4.0
    assert "\\" not in page.inner_text(".md-content")
    assert "$" not in page.inner_text(".md-content")
    assert page.evaluate("document.documentElement.scrollWidth") <= width


def test_no_page_is_longer_than_fifteen_thousand_pixels(site, opened):
    """Each page of the site can be read: of the forty longest files none is higher than 15,000 pixels."""
    page, heights = opened("index.html"), {}
    files = sorted(site.rglob("*.html"), key=lambda file: -file.stat().st_size)
    assert len(files) > 200
    for file in files[:40]:
        page.goto(file.as_uri(), wait_until="domcontentloaded")
        heights[file.relative_to(site).as_posix()] = page.evaluate("document.documentElement.scrollHeight")
    assert {name: height for name, height in heights.items() if height > 15_000} == {}


def test_signatures_have_types_and_each_module_has_a_page(opened):
    """The page of `press` shows the types of its arguments; the page of its package leads to it."""
    page = opened("reference/contact.html")
    page.click(".md-content a[href='contact/press.html']")
    assert "loads: Mapping[Part, Load]" in page.inner_text("#flangeway\\.contact\\.press\\.press + .doc-signature")
