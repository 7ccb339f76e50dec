"""The structure of the package: files in a folder, one name for one thing, no record twice, a short path of a run."""

import ast
import re
import sys
import traceback
from collections import Counter
from collections.abc import Callable

import pytest

from flangeway import cli
from flangeway.cases import Wheelset
from tests.architecture.conftest import MODULES, PACKAGE, TREES

MAX_FILES = 20
"""Modules in one folder, ``__init__.py`` not counted."""
SHARED_FIELDS, MAX_ALIKE = 5, 16
"""Fields of one name that make two dataclasses the same record, and pairs of such records that are left (goal: 0)."""


def test_a_folder_has_at_most_20_modules() -> None:
    """A reader can overlook each folder."""
    counts = Counter(str(path.parent.relative_to(PACKAGE)) for path in MODULES.values() if path.stem != "__init__")
    assert {folder: count for folder, count in counts.items() if count > MAX_FILES} == {}


def test_base_names_of_modules_are_unique() -> None:
    """Two modules of one name would be two things that a reader has to distinguish."""
    counts = Counter(path.stem for path in MODULES.values() if path.stem != "__init__")
    assert [name for name, count in counts.items() if count > 1] == []


def test_scripts_of_ci_name_files_that_exist() -> None:
    """A test file that moved would leave the step with the lowest versions without its tests."""
    root = PACKAGE.parents[1]
    named = {name for path in (root / ".ci").iterdir() for name in re.findall(r"tests/[\w/]+\.py", path.read_text())}
    assert named
    assert [name for name in sorted(named) if not (root / name).exists()] == []


def test_public_class_names_are_unique() -> None:
    """A public class is the only one of its name."""
    counts = Counter(
        node.name
        for tree in TREES.values()
        for node in ast.walk(tree)
        if isinstance(node, ast.ClassDef) and not node.name.startswith("_")
    )
    assert [name for name, count in counts.items() if count > 1] == []


def test_no_further_dataclasses_share_five_fields() -> None:
    """Two records with five fields of the same name would be one thing written twice."""
    fields = {
        f"{module}.{node.name}": {
            item.target.id
            for item in node.body
            if isinstance(item, ast.AnnAssign) and isinstance(item.target, ast.Name)
        }
        for module, tree in TREES.items()
        for node in ast.walk(tree)
        if isinstance(node, ast.ClassDef) and any("dataclass" in ast.unparse(each) for each in node.decorator_list)
    }
    names = sorted(fields)
    shared = {
        (first, second): sorted(fields[first] & fields[second])
        for number, first in enumerate(names)
        for second in names[:number]
        if len(fields[first] & fields[second]) >= SHARED_FIELDS
    }
    assert len(shared) <= MAX_ALIKE, shared


MAX_FUNCTIONS = 9
MAX_FILES_OF_A_RUN = 6


class Reached(BaseException):
    """The solution was called."""


def run_watched(monkeypatch, words: list[str], watch: Callable[..., None]) -> None:
    """Run the program with these words; `watch` sees each call and return, and raises `Reached` to end the run."""
    monkeypatch.setattr(sys, "argv", ["flangeway", *words])
    sys.setprofile(watch)
    try:
        with pytest.raises((Reached, SystemExit)):
            cli.main()
    finally:
        sys.setprofile(None)


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
    run_watched(monkeypatch, words, watch)
    found = found[[name for _, name in found].index("command") :]  # before it the arguments are read
    assert len(found) <= MAX_FUNCTIONS
    assert len({file for file, _ in found}) <= MAX_FILES_OF_A_RUN
    text = (PACKAGE.parents[1] / "CONTRIBUTING.md").read_text(encoding="utf-8")
    rows = re.findall(r"^\| `([\w/]+\.py)` \| (.+?):", text, flags=re.MULTILINE)
    listed = {(file, name.split(".")[-1]) for file, names in rows for name in re.findall(r"`([\w.]+)`", names)}
    assert listed == set(found)


MAX_RETURNS = 24
"""Returns of functions that take the problem, up to the first residual; nesting it anew would add to them."""


def test_the_main_job_passes_one_problem_from_the_command_to_the_residual(monkeypatch, tmp_path) -> None:
    """From `run wheelset` to the first residual there are at most 9 functions, and the problem is the case itself."""
    problems, functions, returns = {}, [], Counter()

    def watch(frame, event, _):
        if not frame.f_code.co_filename.startswith(str(PACKAGE)):
            return
        if (frame.f_code.co_name, event) == ("linearised", "call"):
            sys.setprofile(None)
            on_stack = [call for call in traceback.extract_stack(frame) if str(PACKAGE) in call.filename]
            functions.extend(call.name for call in on_stack)
            raise Reached
        # parameters alone, without that of a method's own object
        given = frame.f_code.co_varnames[: frame.f_code.co_argcount + frame.f_code.co_kwonlyargcount]
        values = [frame.f_locals.get(name) for name in given if name not in ("self", "cls")]
        passed = [value for value in values if isinstance(value, Wheelset)]
        problems.update({id(value): value for value in passed})
        if passed and event == "return":
            returns[frame.f_code.co_qualname] += 1

    words = ["run", "wheelset", "--order", "1", "--size-scale", "8", "--set", "patch_cells=10", "--out", str(tmp_path)]
    run_watched(monkeypatch, words, watch)
    functions = functions[functions.index("command") :]
    assert functions[-1] == "linearised"
    assert len(functions) <= MAX_FUNCTIONS
    assert len(problems) == 1
    assert 0 < sum(returns.values()) <= MAX_RETURNS, returns
