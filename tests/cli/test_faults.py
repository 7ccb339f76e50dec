"""What the machine, defects and hostile inputs do to a run: full disks, no memory, interruption, tracebacks."""

import errno
import os
import signal
import sys
import time
from pathlib import Path

import pytest

from flangeway.campaign import Row
from flangeway.campaign.campaign_run import RowTask, compute
from flangeway.cases.case_file import read_case
from flangeway.elements import Lagrange
from flangeway.errors import InputError, UnforeseenError
from flangeway.mesh import rectangle_grid
from flangeway.space import Space
from flangeway.system.own_process import in_own_process
from tests.processes import MAIN, started

RUN = ("run", "hertz", "--set", "size_mm=0.5", "--no-pictures")


def everything(folder):
    return sorted(str(path.relative_to(folder)) for path in folder.rglob("*"))


def full_disk(after):
    """Return a replacement of ``Path.write_text`` and others that has room for a number of files."""
    left = [after]

    def write(path, data, *_, **__):
        left[0] -= 1
        half = data[: len(data) // 2]
        with path.open("wb" if isinstance(data, bytes) else "w") as file:
            file.write(data if left[0] >= 0 else half)
        if left[0] < 0:
            raise OSError(errno.ENOSPC, os.strerror(errno.ENOSPC))

    return write


def test_a_full_disk_leaves_no_half_file(call, monkeypatch, tmp_path):
    """If the disk is full after a file, the status is 2, the system's reason is printed, and no file stays."""
    write = full_disk(1)
    monkeypatch.setattr(Path, "write_text", write)
    monkeypatch.setattr(Path, "write_bytes", write)
    status, out, err = call(*RUN, "--out", "results")
    assert status == 2
    assert "results, which cannot be written: No space left on device" in err
    assert "what to do: choose another folder with --out" in err
    assert "Traceback" not in err
    assert "Report:" not in out
    assert everything(tmp_path) == []


def test_no_memory_is_told(call, monkeypatch, tmp_path):
    """If memory ends in a run, status 1, a sentence with what to do, and nothing written."""
    text = "Unable to allocate 74.5 GiB for an array"

    def fail(*_, **__):
        raise MemoryError(text)

    monkeypatch.setattr("flangeway.cases.bodies.bodies_run.press", fail)
    status, out, err = call(*RUN)
    assert status == 1
    assert "flangeway: out of memory" in err
    assert text in err
    assert "nothing was written" in err
    assert "make the elements larger" in err
    assert "Traceback" not in err
    assert out == ""
    assert everything(tmp_path) == []


@pytest.mark.ci
def test_a_real_limit_of_memory_is_told(tmp_path):
    """Under a limit of the address space that the run needs more than, status 1 and no traceback."""
    if sys.platform != "linux":
        pytest.skip("limits of the address space are those of Linux")
    # what is loaded already, and little more
    code = (
        "import re, resource, flangeway.report.case_outputs, flangeway.cases, gmsh\n"
        "used = int(re.search(r'VmSize:\\s+(\\d+)', open('/proc/self/status').read())[1]) * 1024\n"
        "resource.setrlimit(resource.RLIMIT_AS, (used + 40 * 2**20,) * 2)\n" + MAIN
    )
    process = started(tmp_path, "run", "cook", "--set", "bodies.membrane.size_mm=0.2", code=code, FLANGEWAY_CACHE="off")
    out, err = process.communicate(timeout=300)
    assert process.returncode == 1, err
    assert "flangeway: out of memory" in err
    assert "Traceback" not in err
    assert "Report:" not in out
    assert everything(tmp_path) == []


@pytest.mark.parametrize("arguments", [RUN, ("init", "hertz")])
def test_interruption_while_files_are_moved(call, monkeypatch, tmp_path, arguments):
    """Ctrl-C before the first file is at its place: status 130, a sentence, no file and no temporary folder."""

    def stop(*_):
        raise KeyboardInterrupt

    monkeypatch.setattr("flangeway.system.output_folder.os.replace", stop)
    status, out, err = call(*arguments)
    assert status == 130
    assert "interrupted; nothing was written" in err
    assert "Traceback" not in err
    assert "Report:" not in out
    assert [path for path in tmp_path.rglob("*") if path.is_file()] == []
    assert list(tmp_path.glob(".flangeway-*")) == []


def test_very_many_unknown_keys_are_refused_at_once(tmp_path):
    """Of 10,000 unknown keys the first few are told, and how many more there are, within seconds of computing."""
    rows = "".join(f"key{number} = 1\n" for number in range(10_000))
    for text in (f'case = "hertz"\n{rows}', f'case = "two-bodies"\n[[bodies]]\nname = "a"\n{rows}'):
        (tmp_path / "case.toml").write_text(text, encoding="utf-8")
        begun = time.process_time()
        with pytest.raises(InputError) as caught:
            read_case(tmp_path / "case.toml")
        assert time.process_time() - begun < 20.0
        assert "there is no input called 'key0'" in caught.value.given
        assert caught.value.given.endswith("; and 9995 more")
        assert len(str(caught.value)) < 4000


@pytest.mark.parametrize("number", ["257", "many"])
def test_far_too_many_threads_are_refused(number, call, monkeypatch):
    """Numbers of threads that would take minutes to start, or are none, are refused by commands and by spaces."""
    monkeypatch.setenv("RAYON_NUM_THREADS", number)
    status, out, err = call("run", "hertz")
    assert (status, out) == (2, "")
    assert "RAYON_NUM_THREADS" in err
    assert "a whole number from 0 up to 256" in err
    with pytest.raises(InputError, match="RAYON_NUM_THREADS"):
        Space(rectangle_grid(1.0, 1.0, 1, 1), Lagrange(1))


PATIENT = """
import builtins, signal, sys, time
signal.signal(signal.SIGINT, signal.default_int_handler)
find = builtins.__import__
def slow(name, *rest):
    if name == {module!r}:
        builtins.__import__ = find
        print("here", file=sys.stderr, flush=True)
        time.sleep(30.0)
    return find(name, *rest)
builtins.__import__ = slow
from flangeway.cli import main
main()
"""


@pytest.mark.parametrize("module", ["typer", "numpy"])
def test_an_early_interruption_is_told(module, tmp_path, interruptible):
    """Ctrl-C while the program is still loading: status 130 and the usual words, no traceback."""
    process = started(tmp_path, "run", "hertz", code=PATIENT.format(module=module))
    assert process.stderr.readline() == "here\n"
    process.send_signal(signal.SIGINT)
    out, err = process.communicate(timeout=300)
    assert process.returncode in (130, -signal.SIGINT)  # the latter if Python's exec was interrupted; a shell says 130
    assert err == "flangeway: interrupted; nothing was written\n"
    assert out == ""


def test_work_in_another_process_heeds_an_ignored_interruption(tmp_path):
    """Begun in the background, where Ctrl-C is ignored, neither the program nor its mesher ends by it."""
    code = (
        "import signal\nsignal.signal(signal.SIGINT, signal.SIG_IGN)\n"
        "from flangeway.system.own_process import in_own_process\n"
        "print(in_own_process(signal.raise_signal, signal.SIGINT))\n"
    )
    process = started(tmp_path, code=code)
    out, err = process.communicate(timeout=300)
    assert (process.returncode, out) == (0, "None\n"), err


FORESEEN = ("internal error", "Traceback")


def defect(*_, **__):
    raise ZeroDivisionError("one over nothing")


def test_an_internal_error_is_one_sentence_with_the_place_to_report_it(call, monkeypatch, tmp_path):
    """Each command ends with status 2 and one line; ``--debug``, before or behind the command, shows the traceback."""
    for place in (
        "flangeway.cases.bodies.bodies_run.TwoBodiesCase.run",
        "flangeway.cases.rigid_run.run_geometry",
        "flangeway.cases.section_run.run_section",
        "flangeway.cases.profile_run.run_profile",
        "flangeway.campaign.Campaign.from_file",
        "flangeway.cases.case_file.schema",
        "flangeway_studies.study.Study.compute",
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
        assert said.startswith("flangeway: internal error, ZeroDivisionError (one over nothing) in ")
        assert "please report it as an issue of the project flangeway" in said
    for words in (("--debug", "run", "cook"), ("run", "cook", "--debug")):
        assert "Traceback" in call(*words)[2]
        assert "FLANGEWAY_DEBUG" not in os.environ


def test_processes_that_work_for_others_tell_one_sentence(monkeypatch):
    """A row of a campaign and a process of the mesher store or raise the same sentence, with the traceback if asked."""
    monkeypatch.setattr("flangeway.cases.bodies.bodies_run.TwoBodiesCase.run", defect)
    case = read_case("cook")
    result = compute(RowTask(Row(1, {}, case))).result
    assert result.status == "failed"
    assert result.message.startswith("internal error, ZeroDivisionError (one over nothing) in ")
    assert "\n" not in result.message
    monkeypatch.setenv("FLANGEWAY_DEBUG", "1")
    assert "Traceback" in compute(RowTask(Row(1, {}, case))).result.message
    monkeypatch.delenv("FLANGEWAY_DEBUG")
    with pytest.raises(UnforeseenError) as caught:
        in_own_process(divmod, 1, 0)
    assert str(caught.value).startswith("internal error, ZeroDivisionError (")
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
