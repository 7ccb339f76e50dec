"""What the reports of all cases say, and the arrays behind their interactive pictures."""

import re
import shlex
from dataclasses import replace
from html import unescape

import numpy as np
import pytest

from flangeway.cases import CASES
from flangeway.cases.case import GivenText
from flangeway.cases.case_file import read_case
from flangeway.cases.section.section_run import TorsionCase
from flangeway.post import corner_stresses
from flangeway.report import scenes
from flangeway.report.bodies.bodies_page import bodies_record
from flangeway.report.bodies.body_fields import bodies_fields, body_fields, body_steps
from flangeway.report.figures.display import shown_cells
from flangeway.report.figures.newton_history import load_steps, newton_figure, steps_table
from flangeway.report.page.case_text import case_text, command_line
from flangeway.report.page.html_page import report_page
from flangeway.report.section.section_page import section_record
from flangeway.solve import Status

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
    contents = re.findall(r'<a href="#(\w+)">(.*?)</a>', hertz_text)
    assert [heading for _, heading in contents] == HEADINGS
    assert all(f'<h2 id="{name}">' in hertz_text for name, _ in contents)
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
        ("cook", {"poisson": 0.1 + 0.2, "method": "mixed", "level": 2}),
        ("hertz", {"force_N": 1e5 / 3.0, "lower": "block"}),
        ("wheelset-tangent", {"size_scale": 0.1 + 0.2, "rail_inclination": 1 / 30, "crown_radius_in": 14.0}),
        ("torsion", {"size": 1.0 / 3.0, "half": True, "poisson": 0.25}),
        ("two-bodies", CASES["two-bodies"].example),
    ],
)
def test_the_command_and_the_case_file_give_the_same_case(tmp_path, name, values):
    """Command and case file of the page hold every input to the last digit; tables have no room in a command."""
    case = CASES[name].from_values(values)
    file = tmp_path / "case.toml"
    file.write_text(case_text(case), encoding="utf-8")
    assert read_case(file) == case
    if name == "two-bodies":
        return
    words = shlex.split(command_line(case))
    assert words[:3] == ["flangeway", "run", name]
    keys = {"--method": "method", "--order": "order", "--size-scale": "size_scale", "--crown-radius": "crown_radius_in"}
    pairs = zip(words[3::2], words[4::2], strict=True)
    given = dict(value.split("=") if option == "--set" else (keys[option], value) for option, value in pairs)
    assert CASES[name].from_values({key: GivenText(text) for key, text in given.items()}) == case


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
