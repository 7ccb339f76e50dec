"""The structure of the package: its size, the number of files in a folder, and one name for one thing."""

import ast
from collections import Counter

import pytest

from tests.architecture.conftest import MODULES, PACKAGE, TREES

MAX_FILES = 20
"""Modules in one folder, ``__init__.py`` not counted."""

MAX_LINES = {
    "": 746,
    "system": 788,
    "exact": 1106,
    "geometry": 1353,
    "mesh": 3610,
    "formats": 2003,
    "elements": 1948,
    "space": 916,
    "materials": 398,
    "problems": 2922,
    "solve": 4400,
    "contact": 7454,
    "post": 2045,
    "forms": 366,
    "railway.profiles": 3756,
    "railway.track": 583,
    "railway.rigid": 1913,
    "railway.wheelset": 1760,
    "railway.positions": 2499,
    "railway.spatial": 4234,
    "cases": 8008,
    "campaign": 1944,
    "tables": 1456,
    "report": 8855,
    "validation": 8868,
    "cli": 1467,
}
"""Lines of Python of each package, ``""`` for the modules beside the packages. Whoever needs more raises a number."""

MAX_LINES_OF_ALL = 75_398
MAX_FILES_OF_ALL = 390
"""What there is now; the plan of the design is 42,000 lines and 270 files before three dimensions."""


def paths_of(package: str) -> list:
    """Return the modules of a package with those of its folders, or of those beside the packages for an empty name."""
    return sorted((PACKAGE / package.replace(".", "/")).rglob("*.py")) if package else sorted(PACKAGE.glob("*.py"))


def lines_of(package: str) -> int:
    """Return the number of lines of a package."""
    return sum(len(path.read_text(encoding="utf-8").splitlines()) for path in paths_of(package))


@pytest.mark.parametrize("package", MAX_LINES)
def test_a_package_has_at_most_its_number_of_lines(package: str) -> None:
    """Growth of a package is a decision: its number in the table must be changed."""
    assert lines_of(package) <= MAX_LINES[package]


def test_every_module_belongs_to_one_package_of_the_table() -> None:
    """The table is complete, so that no new folder escapes it, and counts nothing twice."""
    listed = [path for package in MAX_LINES for path in paths_of(package)]
    assert sorted(listed) == sorted(PACKAGE.rglob("*.py"))


def test_the_whole_does_not_grow() -> None:
    """Neither the lines of the table nor the number of files grow unnoticed."""
    assert sum(MAX_LINES.values()) <= MAX_LINES_OF_ALL
    assert len([*PACKAGE.rglob("*.py")]) <= MAX_FILES_OF_ALL


def test_a_folder_has_at_most_20_modules() -> None:
    """A reader can overlook each folder."""
    counts = Counter(str(path.parent.relative_to(PACKAGE)) for path in MODULES.values() if path.stem != "__init__")
    assert {folder: count for folder, count in counts.items() if count > MAX_FILES} == {}


def test_base_names_of_modules_are_unique() -> None:
    """Two modules of one name would be two things that a reader has to distinguish."""
    counts = Counter(path.stem for path in MODULES.values() if path.stem != "__init__")
    assert [name for name, count in counts.items() if count > 1] == []


def test_public_class_names_are_unique() -> None:
    """A public class is the only one of its name."""
    counts = Counter(
        node.name
        for tree in TREES.values()
        for node in ast.walk(tree)
        if isinstance(node, ast.ClassDef) and not node.name.startswith("_")
    )
    assert [name for name, count in counts.items() if count > 1] == []
