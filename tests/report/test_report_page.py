"""The HTML report, and all files of a run."""

import base64
import re
from html.parser import HTMLParser

import pytest

from flangeway.report import write_case
from flangeway.report.figures.drawing import png
from flangeway.report.page import html_page
from flangeway.report.wheelset import wheelset_page as outputs
from flangeway.report.wheelset.wheelset_page import PLANE_PICTURES as PICTURES

VOID = {"meta", "img", "br", "link", "input"}


class Page(HTMLParser):
    """Open tags, images, text, and whether tags are closed in order."""

    def __init__(self, text):
        super().__init__()
        self.open, self.images, self.words, self.tags = [], [], [], []
        self.feed(text)
        assert self.open == []

    def handle_starttag(self, tag, attrs):
        self.tags.append(tag)
        if tag == "img":
            self.images.append(dict(attrs))
        if tag not in VOID:
            self.open.append(tag)

    def handle_endtag(self, tag):
        assert self.open.pop() == tag

    def handle_data(self, data):
        if not {"style", "script"} & set(self.open):
            self.words.append(data)


@pytest.fixture(scope="module")
def folder(runs, tmp_path_factory):
    out = tmp_path_factory.mktemp("out") / "vem"
    with pytest.MonkeyPatch.context() as patched:
        patched.setattr(html_page, "png", lambda figure: png(figure, 20))
        write_case(runs["vem"], out)
    return out


@pytest.fixture(scope="module")
def text(folder):
    return (folder / "report.html").read_text(encoding="utf-8")


def test_a_run_leaves_its_files_and_no_others(folder):
    """The folder holds exactly the named files, none of them empty."""
    assert {path.name for path in folder.iterdir()} == {
        *(f"{part}.vtu" for part in outputs.PLANE_PARTS),
        *(name for name, *_ in PICTURES),
        *("contact.vtu", "wheelset.pvd", "report.html", "summary.json"),
    }
    assert all(path.stat().st_size > 0 for path in folder.iterdir())


def test_the_page_needs_no_network(text):
    """The page refers to no address and to no other file; its pictures and its program are inside."""
    bare = re.sub(r'base64,[^"]*"', '"', text)
    bare = re.sub(r"(<script[^>]*>).*?</script>", r"\1", bare, flags=re.S)
    assert not re.search(r"https?:|//|<script[^>]*src|<link|@import|url\(", bare)
    images = Page(text).images
    assert len(images) == len(PICTURES)
    for image in images:
        kind, data = image["src"].split(",")
        assert kind == "data:image/png;base64"
        assert base64.b64decode(data, validate=True)[:4] == b"\x89PNG"
        assert len(image["alt"]) > 40


def test_the_page_is_well_formed_and_in_order(text):
    """All tags are closed; the summary with the first picture comes first, the fields before the other pictures."""
    page = Page(text)
    assert {"header", "main", "footer", "figure", "figcaption", "table", "caption", "th"} <= set(page.tags)
    places = [
        text.index(f'id="{name}"')
        for name in ("summary", "fields", "pictures", "numbers", "assumptions", "inputs", "again")
    ]
    assert places == sorted(places)
    assert places[0] < text.index("<img") < places[1]
    assert "prefers-color-scheme: dark" in text
    assert "@media print" in text


def test_pictures_of_the_page_are_the_files(folder, text):
    """Each picture inside the page is one of the files, in their order."""
    inside = [base64.b64decode(image["src"].split(",")[1]) for image in Page(text).images]
    assert inside == [(folder / name).read_bytes() for name, *_ in PICTURES]
