"""The command line, as users and programs call it."""

import importlib
import json
import signal
import subprocess
import sys
import time

import meshio
import numpy as np
import pytest
import typer
from matplotlib.image import imread

from flangeway import cli
from flangeway.cases import CASES, load_case
from flangeway.cases.case_file import CASE_FILES, file_title
from flangeway.railway.profiles.bundled import SECTIONS
from flangeway.records import paths_of
from flangeway.report import command_line
from tests.processes import started


def test_the_main_job_end_to_end(call, tmp_path):
    """A run ends with status 0, progress on stderr, results on stdout, and the options in its case."""
    status, said, shown = call(
        "run", "wheelset-tangent", "--method", "vem", "--size-scale", 4, "--primary", "wheel", "--rail", "136RE-14",
        "--set", "axle_load_kN=200", "--out", "x", "--no-pictures",
    )  # fmt: skip
    assert status == 0, shown
    assert "meshing the rail" in shown
    assert said.startswith("wheelset: converged")
    summary = json.loads((tmp_path / "x" / "summary.json").read_text(encoding="utf-8"))
    assert summary["status"]["converged"] is True
    case = summary["case"]
    assert (case["mesh"]["method"], case["mesh"]["size_scale"], case["contact"]["primary"]) == ("vem", 4.0, "wheel")
    assert (case["track"]["rail"], case["load"]["axle_load_kN"]) == ("136RE-14", 200.0)


def test_a_run_that_does_not_converge_has_status_1_and_says_why(call, tmp_path):
    """Without equilibrium the status is 1, the reason is printed, and the files show the last position."""
    lifted = ("--size-scale", 8, "--set", "vertical_mm=30", "--set", "contact=plane", "--no-pictures")
    status, out, _ = call("run", "wheelset", *lifted, "--out", ".")
    assert status == 1
    assert "NOT converged" in out
    summary = json.loads((tmp_path / "summary.json").read_text(encoding="utf-8"))
    assert summary["status"]["converged"] is False
    assert len(summary["status"]["message"]) > 20
    assert "NOT converged" in (tmp_path / "report.html").read_text(encoding="utf-8")


def test_converge_compares_two_meshes(call, tmp_path):
    """The command runs two meshes, prints the changes, and writes them as JSON under the stem of the case file."""
    file = tmp_path / "cases" / "mine.toml"
    file.parent.mkdir()
    file.write_text('case = "wheelset"\nmesh.size_scale = 8.0\ncontact = "plane"\n', encoding="utf-8")
    status, out, err = call("converge", file)
    assert status == 0, err
    found = json.loads((tmp_path / "out" / "mine-converge" / "converge.json").read_text(encoding="utf-8"))
    assert found["sizes"] == {"mesh.size_scale": {"value": 8.0, "with_half_the_sizes": 4.0}}
    for key, number in found["numbers"].items():
        assert number["change"] == number["with_half_the_sizes"] - number["value"]
        assert key in out


def test_interrupting_leaves_nothing(tmp_path, interruptible):
    """Ctrl-C while it works: status 130, a sentence, no traceback, no file."""
    process = started(tmp_path, "run", "wheelset-tangent")
    first = process.stderr.readline()
    time.sleep(0.05)
    process.send_signal(signal.SIGINT)
    out, err = process.communicate(timeout=300)
    assert first == "meshing the wheel\n"
    assert process.returncode == 130
    assert "interrupted; nothing was written" in err
    assert "Traceback" not in err
    assert out == ""
    assert list(tmp_path.iterdir()) == []


def test_a_missing_library_is_told(call, monkeypatch, tmp_path):
    """If Gmsh lacks a shared library, the message names its packages and the status is 1."""
    import_module = importlib.import_module

    def missing(name, package=None):
        if name == "gmsh":
            raise OSError("libGLU.so.1: cannot open shared object file")
        return import_module(name, package)

    monkeypatch.setattr(importlib, "import_module", missing)
    status, _, err = call("run", "wheelset-tangent")
    assert status == 1
    assert "libglu1-mesa" in err
    assert list(tmp_path.iterdir()) == []


class NoStudies:
    """A finder that does not find the studies."""

    @staticmethod
    def find_spec(name, *_):
        """Refuse the studies, and leave other modules to the finders behind it."""
        if name == "flangeway_studies":
            raise ModuleNotFoundError(name=name)


def test_reproduce_says_how_to_install_the_studies(call, monkeypatch, tmp_path):
    """Without the package of studies the message has the command that installs it, and the status is 1."""
    for name in [name for name in sys.modules if name.partition(".")[0] == "flangeway_studies"]:
        monkeypatch.delitem(sys.modules, name)
    monkeypatch.setattr(sys, "meta_path", [NoStudies, *sys.meta_path])
    status, _, error = call("reproduce", "torsion")
    assert status == 1
    assert "flangeway-studies" in error
    assert "pip install ./studies" in error
    assert list(tmp_path.iterdir()) == []


def test_cases_are_listed_with_their_inputs(call):
    """The list has a line for each case; the name of one gives all its inputs."""
    status, said, _ = call("cases")
    assert status == 0
    assert [line.split()[0] for line in said.splitlines()[:-1]] == [*CASES, *CASE_FILES]
    status, said, _ = call("cases", "wheelset")
    assert status == 0
    assert all(key in said for path in paths_of(CASES["wheelset"]) for key in path)


def test_version_and_help(call):
    """Version and help are printed with status 0; help names the commands."""
    status, said, _ = call("--version")
    assert status == 0
    assert said.startswith("flangeway ")
    helps = [call(*words) for words in (("--help",), ("-h",), ())]
    assert helps[0] == helps[1] == helps[2]
    status, said, _ = helps[0]
    assert status == 0
    commands = typer.main.get_command(cli.app).commands
    assert all(command in said for command in commands)
    for command in commands:
        assert call(command, "-h")[0] == 0


def test_the_package_runs_as_a_module():
    """``python -m flangeway`` is the command."""
    done = subprocess.run([sys.executable, "-m", "flangeway", "--version"], capture_output=True, text=True, check=True)
    assert done.stdout.startswith("flangeway ")


def test_json_is_alone_on_stdout_and_quiet_is_short(call, tmp_path):
    """``--json`` prints the summary and nothing else; ``-q`` how it ended and the report; no pictures where asked."""
    run = ("run", "cook", "--no-pictures")
    status, said, shown = call(*run, "--json")
    assert status == 0
    assert json.loads(said) == json.loads((tmp_path / "out" / "cook" / "summary.json").read_text(encoding="utf-8"))
    assert shown
    assert not [*(tmp_path / "out").rglob("*.png")]
    assert "<img" not in (tmp_path / "out" / "cook" / "report.html").read_text(encoding="utf-8")
    status, said, shown = call(*run, "-q")
    assert (status, shown) == (0, "")
    first, *_, last = said.splitlines()
    assert first.startswith("two-bodies: ")
    assert last == "Report: out/cook/report.html"
    assert len(said.splitlines()) <= 3


@pytest.mark.parametrize("name", CASE_FILES)
def test_a_bundled_case_file_is_listed_and_written(name, call, tmp_path):
    """`cases` has the first line of each bundled file, and what `init` writes is the case of its name."""
    _, out, _ = call("cases")
    assert any(line.split()[0] == name and line.endswith(file_title(name)) for line in out.splitlines())
    status, _, err = call("init", name, "--to", "mine.toml")
    assert status == 0, err
    assert load_case(tmp_path / "mine.toml") == load_case(name)


@pytest.mark.parametrize(
    ("typed", "completed"),
    [
        ("run wheelset-", "wheelset-curve wheelset-tangent"),
        ("run wheelset --set axle_", "axle_load_kN="),
        ("run wheelset --set load.ax", "load.axle_load_kN="),
        ("run wheelset --set wheel=S", "wheel=S1002"),
        ("run wheelset --set track.support=s", "track.support=sleepers"),
        ("geometry s1002-60e1 --set maximum_l", "maximum_lateral_mm="),
        ("geometry en", "en15302"),
        ("section 6", "60E1 60E2"),
        ("profile S", "S-519-A S1002"),
        ("run cook --units u", "us"),
    ],
)
def test_names_are_completed(typed, completed, call, monkeypatch):
    """The shell gets cases, profiles, sections, keys of the case and choices that begin with what is typed."""
    words = f"flangeway {typed}"
    monkeypatch.setenv("_FLANGEWAY_COMPLETE", "complete_bash")
    monkeypatch.setenv("COMP_WORDS", words)
    monkeypatch.setenv("COMP_CWORD", str(words.count(" ")))
    assert call()[1].split() == completed.split()


BOX = """
title = "Box girder"
unit = "mm"
[outer]
points = [[0, 0], [0, 60], [100, 60], [100, 0]]
[[holes]]
points = [[10, 10, 5], [90, 10, 5], [90, 50, 5], [10, 50, 5]]
"""
FILES = {
    "mesh.png", "warping.png", "prandtl.png", "shear_stress.png", "section.vtu", "report.html", "section.json",
}  # fmt: skip


def test_section_of_a_file(call, tmp_path):
    """A clockwise outline in TOML gives a notice, the constants with units, and all files, whose numbers agree."""
    (tmp_path / "box.toml").write_text(BOX)
    status, out, err = call("section", "box.toml", "--size", 4)
    assert status == 0, err
    assert "Note: outer boundary: drawn clockwise" in out
    for words in ("Box girder", "torsion constant J, cm⁴", "shear centre x, mm", "warping constant, cm⁶"):
        assert words in out
    folder = tmp_path / "out" / "section-box"
    assert {path.name for path in folder.iterdir()} == FILES
    summary = json.loads((folder / "section.json").read_text(encoding="utf-8"))
    assert summary["area_mm2"] == pytest.approx(6000.0 - 3200.0 + (4.0 - np.pi) * 25.0)
    assert summary["centroid_mm"] == pytest.approx([50.0, 30.0])
    assert summary["torsion_bounds_certain"] is True
    assert summary["torsion_constant_prandtl_mm4"] == pytest.approx(summary["torsion_constant_warping_mm4"], rel=2e-3)
    fields = meshio.read(folder / "section.vtu")
    assert {"warping_mm2", "prandtl_mm2"} <= set(fields.point_data)
    assert fields.point_data["prandtl_mm2"].min() == pytest.approx(0.0, abs=1e-6)
    for name in FILES:
        if name.endswith(".png"):
            assert min(imread(folder / name).shape[:2]) > 400


@pytest.mark.parametrize(
    ("key", "first"),
    [("theor", "rolling.theory"), ("wheell", "wheelset.wheel"), ("zzzqq", None), ("cells", "contact.patch_cells")],
)
def test_an_unknown_input_names_similar_ones(call, key, first):
    """Of nearly 200 inputs a message has at most five, those with the word first, and the command that lists all."""
    status, _, error = call("run", "wheelset", "--set", f"{key}=1")
    assert status == 2
    line = next(line for line in error.splitlines() if line.strip().startswith("allowed"))
    names = line.partition("inputs of wheelset: ")[2].split(", ")
    assert names[-1].startswith("`flangeway cases wheelset`")
    assert len(names) <= 6
    if first:
        assert names[0] == first
        assert f"did you mean {first}?" in error


@pytest.mark.parametrize(("file", "option"), [("w.whl", "--wheel"), ("w.prw", "--wheel"), ("r.ban", "--rail")])
def test_run_of_a_profile_advises_the_command_that_runs_it(call, tmp_path, file, option):
    """The advised command, with a profile that exists, is a case in three dimensions with this wheel or rail."""
    status, _, error = call("run", file)
    assert status == 2
    assert f"flangeway run wheelset {option} {file}" in error
    name = {"--wheel": "wheel", "--rail": "rail"}[option]
    status = call("run", "wheelset", option, "nonsense", "--out", "out")[0]
    assert status == 2
    assert not (tmp_path / "out").exists()
    assert command_line(load_case("wheelset", **{name: "60E2" if name == "rail" else "AAR-1B"})).startswith(
        f"flangeway run wheelset {option} "
    )


def test_help_of_sections_names_all_bundled_ones(call):
    """Every section that is bundled is in the help."""
    help_text = call("section", "--help")[1]
    for name in SECTIONS:
        assert name in help_text


def test_compare_shows_what_differs_between_two_runs(call, tmp_path):
    """The input that was changed and the results that follow it, each with its change; what is the same is left out."""
    for name, order in (("one", 1), ("two", 2)):
        setting = f"bodies.membrane.order={order}"
        assert call("run", "cook", "--set", setting, "--no-pictures", "-q", "--out", name)[0] == 0
    status, out, err = call("compare", "one", "two", "--no-pictures")
    assert status == 0, err
    found = json.loads((tmp_path / "out" / "compare" / "compare.json").read_text(encoding="utf-8"))
    assert found["case.bodies[1].order"] == {"first": 1, "second": 2}
    summaries = [json.loads((tmp_path / name / "summary.json").read_text(encoding="utf-8")) for name in ("one", "two")]
    stress = "bodies[1].max_von_mises_MPa"
    values = [summary["bodies"][0]["max_von_mises_MPa"] for summary in summaries]
    assert list(found[stress].values()) == values
    assert "case.name" not in found
    assert not any(key.startswith("timings_s") for key in found)
    (line,) = (line for line in out.splitlines() if line.startswith(stress))
    assert line.split()[-1] == f"{100.0 * (values[1] - values[0]) / abs(values[0]):+.2f}"


def test_compare_refuses_what_is_no_run_or_another_kind(call, tmp_path):
    """Folders without a summary, and runs of different cases, are an error that says what to give."""
    assert call("run", "cook", "--no-pictures", "-q", "--out", "one")[0] == 0
    (tmp_path / "no").mkdir()
    assert call("compare", "one", "no")[0] == 2
    (tmp_path / "no" / "summary.json").write_text("[1]", encoding="utf-8")
    status, _, err = call("compare", "one", "no")
    assert status == 2
    assert "without case and status" in err
    (tmp_path / "no" / "summary.json").write_text('{"case": {"name": "stack"}, "status": {}}', encoding="utf-8")
    assert "a run of two-bodies and one of stack" in call("compare", "one", "no")[2]
