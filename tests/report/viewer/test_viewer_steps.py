"""The chooser of load steps on the pages of bodies in contact."""

import re
from dataclasses import replace
from functools import cache
from xml.etree import ElementTree

import meshio
import numpy as np
import pytest

from flangeway.cases import CASES
from flangeway.post import Stresses, pressure_patches
from flangeway.report import scenes as body_steps
from flangeway.report.bodies_page import bodies_record
from flangeway.report.case_outputs import write_case
from flangeway.report.page.html_page import report_page
from flangeway.report.scenes import bodies_fields, bodies_scene, body_fields
from flangeway.report.viewer import packed_parts
from flangeway.solve import Status

SQUARE = {"rectangle": {"width_mm": 10.0, "height_mm": 10.0}}
CONTACT = {
    "secondary": "upper", "secondary_edges": "bottom", "primary": "lower", "primary_edges": "top",
    "enforcement": "multiplier",
}  # fmt: skip
N_STEPS = 4


def case(share=1.0, n_steps=N_STEPS, **changes):
    """Two bodies in contact under loads and motions, and one beside them under a load, all times a share."""
    values = {
        "thickness_mm": 2.0,
        "bodies": [
            {"name": "upper", **SQUARE, "shift_mm": (0.0, 10.02), "size_mm": 3.0, "order": 2},
            {"name": "lower", **SQUARE, "size_mm": 2.5, "method": "vem"},
            {"name": "post", **SQUARE, "shift_mm": (15.0, 0.0), "size_mm": 4.0},
        ],
        "supports": [{"body": "upper", "edges": "top"}, *({"body": b, "edges": "bottom"} for b in ("lower", "post"))],
        "motions": [{"body": "upper", "shift_mm": (0.0, -0.2 * share), "rotation_deg": 0.5 * share}],
        "loads": [
            {"body": "upper", "edges": "right", "traction_MPa": (300.0 * share, 0.0)},
            {"body": "post", "edges": "top", "traction_MPa": (500.0 * share, -900.0 * share)},
        ],
        "contacts": [CONTACT],
        "steps": {"number": n_steps},
    }
    return CASES["two-bodies"].from_values(values | changes)


@pytest.fixture(scope="module")
def run():
    """All bodies in four steps."""
    found = case().run()
    assert found.status.converged
    return found


@pytest.fixture(scope="module")
def page(run, tmp_path_factory):
    """Its page, with the VTU files of every step beside it."""
    folder = tmp_path_factory.mktemp("steps")
    last = list(bodies_fields(run))
    for number, step in enumerate(run.contact.steps):
        bodies = run.at_step(step)
        for each in last:
            body_fields(each.name, bodies[each.name], each.shown).write(folder / f"{each.name}-{number}.vtu")
    return write_page(folder / "report.html", run)


def steps_of(run):
    return body_steps.body_steps(run, list(bodies_fields(run)))


def write_page(path, run):
    path.write_text(report_page(bodies_record(run)), encoding="utf-8")
    return path


@cache
def values_in(path, key):
    """Values of a field at the points of a file, and the numbers of the points' cells in the problem."""
    read = meshio.read(path)
    if key == "displacement_mm:y":
        values = read.point_data["displacement_mm"][:, 1]
    elif key == "principal_3_MPa":
        values = Stresses(read.point_data["stress_MPa"][:, [0, 1, 3, 2]]).principal[:, 2]
    else:
        values = read.point_data[key]
    numbers = np.concatenate(read.cell_data["cell_number"]).astype(int)
    cell_of_point = np.empty(len(values), dtype=int)
    for number, cell in zip(numbers, (row for block in read.cells for row in block.data), strict=True):
        cell_of_point[cell] = number
    return values, cell_of_point


def choose(opened, step):
    opened.page.locator("#viewer-step").fill(str(step))


def test_a_step_has_what_its_share_of_all_loads_gives(run):
    """At half of all loads and motions every body has the displacements of a run with half of them, and its place."""
    step = next(step for step in run.contact.steps if step.share == 0.5)
    found, alone = run.at_step(step), case(0.5, 1).run().bodies
    for name, body in alone.items():
        size = np.abs(body.field.displacements).max()
        assert size > 1e-3
        assert np.allclose(found[name].field.displacements, body.field.displacements, rtol=0.0, atol=1e-7 * size)
        assert np.allclose(found[name].placement.translation, body.placement.translation)
        assert found[name].placement.rotation_rad == pytest.approx(body.placement.rotation_rad)
    for name, body in run.at_step(run.contact.steps[-1]).items():
        assert np.array_equal(body.field.displacements, run.bodies[name].field.displacements)


def test_the_slider_changes_picture_and_values(open_page, page):
    """At every step the picture is another one, and the values read in each body are those of that step's file."""
    opened = open_page(page)
    slider = opened.page.locator("#viewer-step")
    assert (slider.input_value(), slider.get_attribute("max")) == ("3", "3")
    box, last = opened.canvas.bounding_box(), opened.shot()
    seen = set()
    for number in range(N_STEPS):
        choose(opened, number)
        words = f"{number + 1} of 4: {25 * (number + 1)} % of loads and displacements"
        assert slider.get_attribute("aria-valuetext") == words
        assert opened.page.inner_text("#viewer-step-name") == f"Load step {words}"
        assert (opened.changed(last) > 0.05) == (number < N_STEPS - 1)
        for key in ("von_mises_MPa", "displacement_mm:y" if number % 2 else "principal_3_MPa"):
            opened.choose(key)
            for x, y in ((0.4, 0.25), (0.4, 0.75), (0.62, 0.75)):
                found = opened.point(x * box["width"], y * box["height"])
                values, cells = values_in(page.parent / f"{found['part']}-{number}.vtu", key)
                of = [int(found["point"])] if "point" in found else np.flatnonzero(cells == found["cell"])
                scale = np.abs(values).max()
                assert values[of] == pytest.approx(np.full(len(of), found["value"]), rel=2e-6, abs=2e-6 * scale)
                seen.add((found["part"], key, number))
        opened.choose("von_mises_MPa")
    assert len(seen) == 3 * 2 * N_STEPS
    assert opened.changed(last) < 0.005
    assert opened.errors() == []


def test_the_deformation_is_that_of_the_step(open_page, page, run):
    """The upper body's side is drawn where its motion at the step takes it, for the last step and an earlier one."""
    opened = open_page(page)
    opened.page.uncheck(".viewer-parts input[value=post]")
    opened.page.uncheck(".viewer-parts input[value=lower]")
    opened.page.fill("#viewer-factor", "20")
    choose(opened, 0)
    opened.fly("whole")
    scale, tops = opened.mm_per_pixel(), []
    for number in (0, N_STEPS - 1):
        choose(opened, number)
        middle = opened.shot()[5:, 200:-200]  # without frame and scale bar
        tops.append(np.flatnonzero((np.abs(middle - 1.0) > 0.1).any(axis=(1, 2)))[0])
    wanted = []
    for step in (run.contact.steps[0], run.contact.steps[-1]):
        body = run.at_step(step)["upper"]
        mesh = body.field.problem.space.mesh
        motion = body.moved(mesh.points, body.field.displacements[: mesh.n_points])
        wanted.append((mesh.points + 20.0 * motion)[:, 1].max())
    assert (tops[1] - tops[0]) * scale == pytest.approx(wanted[0] - wanted[1], abs=2.5 * scale)
    assert abs(tops[1] - tops[0]) > 20


def test_buttons_keys_and_play_choose_steps(open_page, page):
    """A button beside the slider, its own keys, S in the picture and play go through the steps, each announced."""
    # slow at first: a busy machine may take seconds from play to pause
    slow = "window.slow = 100; const own = setInterval; window.setInterval = (act, ms) => own(act, ms * window.slow)"
    opened = open_page(page, script=slow)
    slider, told = opened.page.locator("#viewer-step"), "document.querySelector('.viewer-live').textContent"
    button = {
        name: opened.page.get_by_role("button", name=name, exact=True)
        for name in ("Next load step", "Previous load step", "play", "pause")
    }
    assert button["Next load step"].get_attribute("aria-disabled") == "true"
    button["Previous load step"].click()
    assert slider.input_value() == "2"
    opened.page.wait_for_function(f"{told}.startsWith('Load step 3 of 4: 75 %')")
    slider.focus()
    opened.page.keyboard.press("Home")
    assert slider.input_value() == "0"
    opened.canvas.focus()
    opened.page.keyboard.press("s")
    assert slider.input_value() == "1"
    opened.page.keyboard.press("Shift+S")
    assert slider.input_value() == "0"
    button["play"].click()
    button["pause"].click()
    assert int(slider.input_value()) < 3
    opened.page.evaluate("window.slow = 1; document.querySelector('#viewer-play').click()")
    button["play"].wait_for()
    assert slider.input_value() == "3"
    opened.page.wait_for_function(f"{told}.startsWith('Load step 4 of 4')")
    assert opened.errors() == []


def test_one_scale_for_all_steps_or_one_for_each(open_page, page):
    """The colours reach over all steps, whichever is shown, until a scale of each step is asked for."""
    opened = open_page(page)
    opened.page.select_option("#viewer-range", "full")
    common, own = [], []
    for number in range(N_STEPS):
        choose(opened, number)
        opened.page.check("#viewer-common")
        common.append(float(opened.page.input_value("#viewer-high")))
        assert "In all load steps the shown parts have" in opened.page.inner_text(".viewer-scale-note")
        opened.page.uncheck("#viewer-common")
        own.append(float(opened.page.input_value("#viewer-high")))
        assert "In this load step the shown parts have" in opened.page.inner_text(".viewer-scale-note")
        maximum = max(
            np.abs(values_in(page.parent / f"{name}-{number}.vtu", "von_mises_MPa")[0]).max()
            for name in ("upper", "lower", "post")
        )
        assert own[-1] == pytest.approx(maximum, rel=1e-4)
    assert own == sorted(own)
    assert own[0] < 0.5 * own[-1]
    assert set(common) == {own[-1]}


def test_the_files_have_every_load_step(run, page, tmp_path):
    """A case's collection for ParaView has one file of each body for each load step, in order, with its fields."""
    files = write_case(run, tmp_path)
    collection = ElementTree.parse(tmp_path / "bodies.pvd").getroot().findall("Collection/DataSet")
    found = [(float(entry.get("timestep")), entry.get("name"), entry.get("file")) for entry in collection]
    names = (*run.bodies, "contact")
    assert [entry[:2] for entry in found] == [(n, name) for n in range(1, N_STEPS + 1) for name in names]
    assert {tmp_path / entry[2] for entry in found} == {file for file in files if file.suffix == ".vtu"}
    for time, name, file in found:
        if name == "contact":
            pressures = meshio.read(tmp_path / file).point_data["pressure_MPa"]
            wanted = pressure_patches(run.contact.system, run.contact.steps[int(time) - 1].state)
            assert pressures.max() == max(patch.pressures.max() for patch in wanted)
            continue
        expected = meshio.read(page.parent / f"{name}-{int(time) - 1}.vtu")
        assert np.array_equal(
            meshio.read(tmp_path / file).point_data["von_mises_MPa"], expected.point_data["von_mises_MPa"]
        )


def test_too_many_steps_are_thinned_out_evenly(run, monkeypatch):
    """A page keeps to its largest number of values: it has some steps evenly, the last among them, and says so."""

    def n_packed(scene):
        headers, _ = packed_parts(scene.parts)
        return sum(entry[2] for header in headers for entry in header["arrays"] if len(entry) > 3)

    whole = bodies_scene(run, steps_of(run))
    assert len(whole.steps) == N_STEPS
    assert whole.steps_note == ""
    monkeypatch.setattr(body_steps, "MAX_VALUES", n_packed(whole) // 2)
    scene = bodies_scene(run, steps_of(run))
    assert n_packed(scene) <= body_steps.MAX_VALUES
    assert [name.split(":")[0] for name in scene.steps] == ["1 of 4", "4 of 4"]
    for part, complete in zip(scene.parts, whole.parts, strict=True):
        assert np.array_equal(part.point_arrays["stresses"], complete.point_arrays["stresses"][[0, 3]])
    assert "2 of the 4 load steps are shown" in scene.steps_note
    monkeypatch.setattr(body_steps, "MAX_VALUES", 1)
    only = bodies_scene(run, steps_of(run))
    assert only.steps == ()
    assert only.steps_note.startswith("Of the 4 load steps only the last is shown")
    for number, most in ((7, 3), (10, 4), (100, 7)):
        chosen = body_steps.evenly(number, most)
        assert (len(chosen), chosen[-1]) == (most, number - 1)
        assert np.ptp(np.diff(chosen)) <= 1


def test_where_a_run_ended_without_success_is_its_last_step(run):
    """After the steps that converged comes the state in which a run ended, named as such."""
    status = Status(False, "stopped", 3)
    failed = replace(run.contact, state=replace(run.contact.state, status=status), steps=run.contact.steps[:2])
    ended = replace(run, contact=failed, status=status)
    scene = bodies_scene(ended, steps_of(ended))
    assert [re.sub(r".*: ", "", name) for name in scene.steps] == [
        "25 % of loads and displacements", "50 % of loads and displacements", "not converged",
    ]  # fmt: skip
