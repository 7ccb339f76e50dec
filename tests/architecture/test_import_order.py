"""Imports go one way, between sub-packages too, and without circles; two sub-packages call the compiled core."""

import re

import pytest

from tests.architecture.conftest import IMPORTS, MODULES, PACKAGE

ORDER = (
    "errors",
    "types",
    "checks",
    "results",
    "quantities",
    "system",
    "exact",
    "geometry",
    "mesh",
    "formats",
    "elements",
    "space",
    "materials",
    "problems",
    "solve",
    "contact",
    "rolling",
    "post",
    "forms",
    "railway.profiles",
    "railway.track",
    "railway.rigid",
    "railway.wheelset",
    "railway.damage",
    "railway",
    "cases",
    "campaign",
    "tables",
    "report",
    "live",
    "cli",
    "__main__",
)


def level(name: str) -> int:
    """Return the place in the order of the sub-package that a module belongs to."""
    return next(number for number, folder in enumerate(ORDER) if f"{name}.".startswith(f"{folder}."))


@pytest.mark.parametrize("name", MODULES)
def test_a_module_imports_only_from_folders_before_its_own(name: str) -> None:
    """A module imports only from its own sub-package and from those above it in the list."""
    known = {each for each in IMPORTS[name] if each != "_core"}
    assert not {each for each in known if level(each) > level(name)}


def test_there_are_no_circles_between_files() -> None:
    """No module imports itself, however many files lie between."""
    files = {name for name, path in MODULES.items() if path.stem != "__init__"}
    left = {name: IMPORTS[name] & files for name in files}
    while free := [name for name, needed in left.items() if not needed]:
        for name in free:
            del left[name]
        left = {name: needed - set(free) for name, needed in left.items()}
    assert not left


def test_only_space_and_solve_use_the_compiled_core() -> None:
    """The sparse machinery is called from two folders, so that it can be replaced."""
    users = {name.partition(".")[0] for name, found in IMPORTS.items() if "_core" in found}
    assert users <= {"space", "solve"}


def test_the_guide_for_contributors_shows_this_order() -> None:
    """The tree in CONTRIBUTING.md has each sub-package once, in the order of imports."""
    text = (PACKAGE.parents[1] / "CONTRIBUTING.md").read_text(encoding="utf-8")
    tree = text.partition("src/flangeway/\n")[2].partition("core/")[0]
    assert re.match(r"  (\w+)\.py (\w+)\.py (\w+)\.py (\w+)\.py (\w+)\.py ", tree).groups() == ORDER[:5]
    folders, above = [], ""
    for indent, folder in re.findall(r"^( +)(\w+)/", tree, flags=re.MULTILINE):
        above = above if len(indent) == 4 else folder
        folders.append(folder if len(indent) == 2 else f"{above}.{folder}")
    shown = [folder for folder in dict.fromkeys(folders) if folder != "railway"]
    assert shown == [folder for folder in ORDER[5:-1] if folder != "railway"]


def test_only_the_command_knows_the_studies():
    """No module of the package imports `studies` but the command that runs them."""
    users = {name for name, path in MODULES.items() if re.search(r"(from|import) studies\b", path.read_text("utf-8"))}
    assert users == {"cli.reproduce_command"}
