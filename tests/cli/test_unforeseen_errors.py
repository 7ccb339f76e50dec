"""Tracebacks that reached a user."""

import os

import pytest

from flangeway.campaign import Row
from flangeway.campaign.chunk import Chunk, compute
from flangeway.cases import find_case
from flangeway.errors import UnforeseenError
from flangeway.system.own_process import in_own_process
from tests.processes import started

FORESEEN = ("foresaw", "Traceback")


def defect(*_, **__):
    raise ZeroDivisionError("one over nothing")


def test_what_nobody_foresaw_is_one_sentence_with_the_place_to_report_it(call, monkeypatch, tmp_path):
    """Each command ends with status 2 and one line; ``--debug``, before or behind the command, shows the traceback."""
    for place in (
        "flangeway.cases.bodies.cook.CookCase.run",
        "flangeway.cases.rigid.rigid_run.run_geometry",
        "flangeway.cases.section.section_run.run_section",
        "flangeway.cases.profile.profile_run.run_profile",
        "flangeway.campaign.Campaign.from_file",
        "flangeway.cases.case_template.schema",
        "studies.study.Study.compute",
    ):
        monkeypatch.setattr(place, defect)
    commands = (
        "run cook",
        "geometry",
        "section 136RE",
        "profile S1002",
        "campaign c.toml",
        "schema",
        "reproduce torsion",
    )
    (tmp_path / "c.toml").write_text('case = "hertz"\n')
    for command in commands:
        status, out, err = call(*command.split())
        said = err.splitlines()[-1]
        assert (status, out) == (2, ""), command
        assert "Traceback" not in err
        assert said.startswith("flangeway: an error that nobody foresaw, ZeroDivisionError (one over nothing) in ")
        assert "please report it as an issue of the project flangeway" in said
    for words in (("--debug", "run", "cook"), ("run", "cook", "--debug")):
        assert "Traceback" in call(*words)[2]
        assert "FLANGEWAY_DEBUG" not in os.environ


def test_processes_that_work_for_others_tell_one_sentence(monkeypatch):
    """A row of a campaign and a process of the mesher store or raise the same sentence, with the traceback if asked."""
    monkeypatch.setattr("flangeway.cases.bodies.cook.CookCase.run", defect)
    case = find_case("cook").from_values({})
    (result,) = compute(Chunk((Row(1, {}, case),))).results
    assert result.status == "failed"
    assert result.message.startswith("an error that nobody foresaw, ZeroDivisionError (one over nothing) in ")
    assert "\n" not in result.message
    monkeypatch.setenv("FLANGEWAY_DEBUG", "1")
    assert "Traceback" in compute(Chunk((Row(1, {}, case),))).results[0].message
    monkeypatch.delenv("FLANGEWAY_DEBUG")
    with pytest.raises(UnforeseenError) as caught:
        in_own_process(divmod, 1, 0)
    assert str(caught.value).startswith("an error that nobody foresaw, ZeroDivisionError (")
    assert "\n" not in str(caught.value)


@pytest.mark.parametrize(
    ("text", "told"),
    [
        ('case = "hertz"\n' + ".".join(["a"] * 3000) + " = 1\n", "lists or tables too deep inside of each other"),
        (
            'case = "two-bodies"\n[[bodies]]\nname = "a"\noutline = { points = ' + "[" * 60 + "]" * 60 + " }\n",
            "too deep",
        ),
    ],
)
def test_deep_tables_are_refused(text, told, call, tmp_path):
    """Tables and lists far inside of each other are refused by case files and by --set."""
    (tmp_path / "deep.toml").write_text(text, encoding="utf-8")
    status, out, err = call("check", "deep.toml")
    assert (status, out) == (2, "")
    assert told in err
    assert not any(word in err for word in FORESEEN)
    status, _, err = call("check", "hertz", "--set", ".".join(["a"] * 3000) + "=1")
    assert status == 2
    assert not any(word in err for word in FORESEEN)


def test_names_that_no_file_can_have_are_refused(call, tmp_path):
    """Folders and files with names of 300 letters, none at all, or no text in UTF-8 are refused; nothing is written."""
    long = "x" * 300
    for words in (
        ("run", "cook", "--out", long),
        ("init", "hertz", "--to", f"{long}.toml"),
        ("schema", "--to", long),
        ("section", "136RE", "--out", f"{long}/inner"),
        ("run", "cook", "--out", ""),
        ("init", "cook", "--to", " "),
        ("run", "cook", "--out", "\udcff"),
    ):
        status, out, err = call(*words)
        assert (status, out) == (2, ""), words
        assert "allowed: " in err
        assert not any(word in err for word in FORESEEN), err
        assert list(tmp_path.iterdir()) == []


def test_a_wrong_backend_of_matplotlib_does_not_matter(tmp_path):
    """Pictures go to files: a backend for windows that does not exist is not looked for."""
    code = "import flangeway.cli, matplotlib.figure; matplotlib.figure.Figure().savefig('a.png')"
    process = started(tmp_path, code=code, MPLBACKEND="nonsense")
    _, err = process.communicate(timeout=300)
    assert process.returncode == 0, err
    assert (tmp_path / "a.png").exists()


def test_a_reader_that_has_seen_enough_is_no_error(tmp_path):
    """``flangeway cases | head -1`` ends without a word."""
    process = started(tmp_path, "cases")
    process.stdout.readline()
    process.stdout.close()
    assert process.stderr.read() == ""
    process.stderr.close()
    assert process.wait(timeout=300) in (0, 1)
