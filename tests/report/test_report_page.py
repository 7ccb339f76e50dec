"""The HTML report, and all files of a run, also in three dimensions."""

import base64
import re
from html.parser import HTMLParser

import meshio
import numpy as np
import pytest

from flangeway.cases import load_case
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


@pytest.fixture(scope="module")
def run():
    """A cylinder across another one, on coarse elements."""
    return load_case("crossed-cylinders", order=1, angle_deg=60.0, upper_radius_mm=30.0).run()


def test_files_hold_the_force_and_the_stresses(run, tmp_path):
    """All files are there; pressure times area is the force, also on the surface in space; stresses are Hertz's."""
    files = write_case(run, tmp_path)
    page = (tmp_path / "report.html").read_text(encoding="utf-8")
    assert f"{run.summary['patches'][0]['max_pressure_MPa']:.1f}" in page
    assert {file.name for file in files} == {
        *("patch.png", "depth.png", "surface.vtu", "section-lower.vtu", "section-upper.vtu"),
        *("bodies.pvd", "report.html", "summary.json"),
    }
    surface = meshio.read(tmp_path / "surface.vtu")
    corners = surface.points[surface.cells[0].data]
    one, other = corners[:, 1] - corners[:, 0], corners[:, 3] - corners[:, 0]
    normals = -np.cross(one, other)
    pressures, gaps = (surface.point_data[name][surface.cells[0].data] for name in ("pressure_MPa", "gap_mm"))
    assert not np.ptp(pressures, axis=1).any()
    pressures, gaps = pressures[:, 0], gaps[:, 0]
    assert np.abs(pressures @ normals)[1] == pytest.approx(10e3, rel=2e-3)
    assert np.ptp(surface.points[:, 2]) == pytest.approx(
        run.contact.pair.grid.strip * pressures.size / len(run.contact.pair.grid.widths)
    )
    assert (gaps[pressures > 0.0] < 1e-8).all()
    for number, (name, body) in enumerate(zip(("lower", "upper"), run.bodies, strict=True)):
        section = meshio.read(tmp_path / f"section-{name}.vtu")
        assert np.unique(section.cell_data["body_id"]).tolist() == [number]
        mises = section.point_data["von_mises_MPa"]
        assert mises.max() == pytest.approx(body.von_mises[0], rel=0.1)
        assert section.point_data["stress_MPa"][:, 1].min() == pytest.approx(-pressures.max(), rel=0.1)


def test_the_patch_is_that_of_hertz(run):
    """Maximum pressure and semi-axes are within 1 %."""
    patch = run.summary["patches"][0]
    assert patch["max_pressure_MPa"] == pytest.approx(patch["hertz_pressure_MPa"], rel=1e-2)
    np.testing.assert_allclose(patch["semi_axes_mm"], patch["hertz_semi_axes_mm"], rtol=1e-2)
