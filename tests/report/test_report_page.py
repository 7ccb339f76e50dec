"""The HTML report: what it says and holds of each case, and all files of a run, also in three dimensions."""

import base64
import re
import shlex
from dataclasses import replace
from html import unescape
from html.parser import HTMLParser

import meshio
import numpy as np
import pytest

from flangeway.cases import CASES, load_case
from flangeway.cases.case_file import read_case, write_case_file
from flangeway.cases.section_run import TorsionCase
from flangeway.post import corner_stresses
from flangeway.records import GivenText
from flangeway.report import scenes, write_case
from flangeway.report.bodies_page import bodies_record
from flangeway.report.figures import drawing
from flangeway.report.figures.display import shown_cells
from flangeway.report.figures.drawing import newton_figure, png
from flangeway.report.page.html_page import command_line, report_page
from flangeway.report.scenes import bodies_fields, body_fields, body_steps, load_steps, steps_table
from flangeway.report.section_page import section_record
from flangeway.report.wheelset import wheelset_page as outputs
from flangeway.report.wheelset.wheelset_figures import PLANE_PICTURES as PICTURES
from flangeway.solve import Status

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
        patched.setattr(drawing, "png", lambda figure: png(figure, 20))
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
        *("patch.png", "depth.png", "cells.csv", "surface.vtu", "section-lower.vtu", "section-upper.vtu"),
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


COARSE = {"size_mm": 1.5, "body_size_mm": 15.0, "indentation_mm": 1.0, "n_steps": 2, "order": 2}
HEADINGS = ["Summary", "Fields", "Numbers", "Assumptions", "Inputs", "Run it again"]


@pytest.fixture(scope="module")
def hertz():
    """Two half discs of order 2, pressed in two steps."""
    return CASES["hertz"].from_values(COARSE).run()


@pytest.fixture(scope="module")
def hertz_steps(hertz):
    return body_steps(hertz, list(bodies_fields(hertz)))


@pytest.fixture(scope="module")
def hertz_text(hertz):
    return report_page(bodies_record(hertz))


def headings(text):
    return re.findall(r"<h2[^>]*>(.*?)</h2>", text)


def test_a_page_has_what_there_is_and_no_empty_places(hertz, hertz_text):
    """Sections come in order, one without contents is left out, and notices, results and versions are shown."""
    assert headings(hertz_text) == HEADINGS
    assert re.findall(r"<details>\s*<summary><h2[^>]*>(.*?)</h2>", hertz_text) == HEADINGS[1:]
    words = unescape(hertz_text)
    assert all(text in words for text in hertz.summary["notices"])
    assert f"{hertz.summary['results']['hertz_max_pressure_MPa']:.6g} MPa" in words


def test_a_failure_and_notices_are_marked(hertz):
    """A run that did not converge says so at the top, and names cannot bring HTML into the page."""
    status = replace(hertz.status, converged=False, message="a <b> & c")
    page = report_page(bodies_record(replace(hertz, status=status, notices=["x < y"])))
    assert 'class="status failed"' in page
    assert "a &lt;b&gt; &amp; c" in page
    assert "<li>x &lt; y</li>" in page


@pytest.mark.parametrize(
    ("name", "values"),
    [
        ("crane-wheel", {"poisson": 0.1 + 0.2, "method": "vem", "yaw_deg": 1.0 / 3.0}),
        ("hertz", {"force_N": 1e5 / 3.0, "lower": "block"}),
        ("wheelset", {"size_scale": 0.1 + 0.2, "inclination": 1 / 30, "rail": "136RE-14", "support": "fixed"}),
        ("torsion", {"size": 1.0 / 3.0, "half": True, "poisson": 0.25}),
        ("two-bodies", CASES["two-bodies"].example),
    ],
)
def test_the_command_and_the_case_file_give_the_same_case(tmp_path, name, values):
    """Command and case file of the page hold every input to the last digit; tables have no room in a command."""
    case = load_case(name, **values)
    file = tmp_path / "case.toml"
    file.write_text(write_case_file(case), encoding="utf-8")
    assert read_case(file) == case
    if name == "two-bodies":
        return
    words = shlex.split(command_line(case))
    assert words[:3] == ["flangeway", "run", name]
    keys = {"--method": "method", "--order": "order", "--size-scale": "size_scale", "--rail": "rail"}
    pairs = zip(words[3::2], words[4::2], strict=True)
    given = dict(value.split("=", 1) if option == "--set" else (keys[option], value) for option, value in pairs)
    assert load_case(name, **{key: GivenText(text) for key, text in given.items()}) == case


def test_the_history_has_every_iteration_of_every_step(hertz):
    """The picture draws the errors of all iterations in a row, the table counts them; a failed end is named."""
    steps = load_steps(hertz.contact)
    assert [name for name, _ in steps] == ["50 %", "100 %"]
    axes = newton_figure(load_steps(hertz.contact)).axes[0]
    drawn = np.concatenate(
        [line.get_ydata() for line in axes.lines if line.get_linestyle() == "-" and line.get_marker() == "o"]
    )
    errors = [iteration.residual for _, state in steps for iteration in state.history]
    assert np.array_equal(drawn, np.maximum(errors, 1e-17))
    assert [row[1] for row in steps_table(hertz.contact).rows] == [str(len(state.history)) for _, state in steps]
    failed = replace(hertz.contact, state=replace(hertz.contact.state, status=Status(False, "stopped", 1)))
    assert load_steps(failed)[-1][0] == "not converged"


def test_very_many_points_are_shown_as_whole_cells(hertz, hertz_steps, monkeypatch):
    """Beyond the largest number of points the page shows each cell once, with the values at its corners."""
    assert all(part.cells is not None for part in scenes.bodies_scene(hertz, hertz_steps).parts)
    monkeypatch.setattr(scenes, "MAX_POINTS", sum(each.shown.mesh.n_points for each in hertz_steps.fields[-1]) - 1)
    scene = scenes.bodies_scene(hertz, hertz_steps)
    for part in scene.parts:
        body = hertz.bodies[part.name]
        mesh = body.field.problem.space.mesh
        assert np.array_equal(part.mesh.cell_offsets, mesh.cell_offsets)
        assert np.array_equal(part.places, mesh.cell_points)
        corners = corner_stresses(body.field.problem, body.field.displacements).components
        assert part.point_arrays["stresses"][-1] == pytest.approx(corners)
    assert "corners" in scene.notes[-1]
    upper = hertz.bodies["upper"]
    with_points = body_fields("upper", upper, shown_cells(upper.field.problem.space, 2))
    at_corners = body_fields("upper", upper, shown_cells(upper.field.problem.space, 1))
    assert with_points.stresses.von_mises.max() >= at_corners.stresses.von_mises.max() * (1.0 - 1e-9)


def test_a_section_in_another_unit(tmp_path):
    """The page of a section in inches has inches everywhere, and its outline's notices."""
    (tmp_path / "bar.toml").write_text(
        'title = "Bar"\nunit = "in"\n[outer]\npoints = [[0, 0], [0, 1], [2, 1], [2, 0]]\n', encoding="utf-8"
    )
    run = TorsionCase(section=str(tmp_path / "bar.toml"), size=0.2).run()
    page = section_record(run, "flangeway x")
    scene = page.scene()
    assert scene.unit == "in"
    assert {field.unit for field in scene.fields} == {"in²", "1/in³"}
    assert page.facts[0] == ("2 in²", "area")
    assert any("clockwise" in note for note in page.notes)
    # 2 in² of steel, 7850 kg/m³
    assert run.summary["mass_per_metre_kg_m"] == pytest.approx(2.0 * 0.0254**2 * 7850.0)
    assert "<code>flangeway x</code>" in report_page(page)
