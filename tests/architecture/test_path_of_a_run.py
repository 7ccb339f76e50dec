"""The path of a run, from the command to the solution, is short and in the guide for contributors."""

import re
import sys
import traceback

import pytest

from flangeway import cli
from tests.architecture.conftest import PACKAGE

MAX_FUNCTIONS = 9
MAX_FILES = 6


class Reached(BaseException):
    """The solution was called."""


def test_the_path_to_the_solution_is_the_one_of_the_guide(monkeypatch, tmp_path) -> None:
    """From the command `run` to `solve_contact` there are at most 9 functions in 6 files, which the guide lists."""
    found = []

    def watch(frame, event, _):
        if event == "call" and frame.f_code.co_name == "solve_contact":
            sys.setprofile(None)
            calls = [call for call in traceback.extract_stack(frame) if str(PACKAGE) in call.filename]
            found.extend((call.filename.removeprefix(f"{PACKAGE}/"), call.name) for call in calls)
            raise Reached

    words = ["run", "wheelset-tangent", "--order", "1", "--size-scale", "8", "--out", str(tmp_path)]
    monkeypatch.setattr(sys, "argv", ["flangeway", *words])
    sys.setprofile(watch)
    try:
        with pytest.raises((Reached, SystemExit)):
            cli.main()
    finally:
        sys.setprofile(None)
    found = found[[name for _, name in found].index("command") :]  # before it the arguments are read
    assert len(found) <= MAX_FUNCTIONS
    assert len({file for file, _ in found}) <= MAX_FILES
    text = (PACKAGE.parents[1] / "CONTRIBUTING.md").read_text(encoding="utf-8")
    rows = re.findall(r"^\| `([\w/]+\.py)` \| (.+?):", text, flags=re.MULTILINE)
    listed = {(file, name.split(".")[-1]) for file, names in rows for name in re.findall(r"`([\w.]+)`", names)}
    assert listed == set(found)
