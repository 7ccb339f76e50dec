"""Inputs with which the program hung, and ends of which it said nothing."""

import signal
import time

import pytest

from flangeway.cases.case_file import read_case
from flangeway.elements import Lagrange
from flangeway.errors import InputError
from flangeway.mesh import rectangle_grid
from flangeway.space import Space
from tests.processes import started


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
