"""Imports go one way, between sub-packages too, and without circles; two sub-packages call the compiled core."""

import ast
import re

import pytest

from tests.architecture.conftest import IMPORTS, MODULES, PACKAGE, TOP, TREES, imports_in

ORDER = (
    "errors",
    "types",
    "checks",
    "units",
    "views",
    "results",
    "quantities",
    "system",
    "records",
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
    TOP,
)
FILES_AT_THE_TOP = (*ORDER[: ORDER.index("system")], "records")
FOLDERS = tuple(name for name in ORDER[: ORDER.index("__main__")] if name not in FILES_AT_THE_TOP)


def level(name: str) -> int:
    """Return the place in the order of the sub-package that a module belongs to."""
    return next(number for number, folder in enumerate(ORDER) if f"{name}.".startswith(f"{folder}."))


@pytest.mark.parametrize("name", MODULES)
def test_a_module_imports_only_from_folders_before_its_own(name: str) -> None:
    """A module imports only from its own sub-package and from those above it in the list."""
    known = {each for each in IMPORTS[name] if each != "_core"}
    assert not {each for each in known if level(each) > level(name)}


def test_modules_name_what_they_import_in_full() -> None:
    """No module has a relative import."""
    nodes = [(name, node) for name, tree in TREES.items() for node in ast.walk(tree)]
    assert {name for name, node in nodes if isinstance(node, ast.ImportFrom) and node.level} == set()


def test_there_are_no_circles_between_files() -> None:
    """No module and no package imports itself, however many files lie between, and by a text neither."""
    left = {name: found - {"_core"} for name, found in IMPORTS.items()}
    while free := [name for name, needed in left.items() if not needed]:
        for name in free:
            del left[name]
        left = {name: needed - set(free) for name, needed in left.items()}
    assert left == {}


@pytest.mark.parametrize(
    ("text", "modules"),
    [
        ("from flangeway.report import plot_result", {"report"}),
        ("def f():\n    from flangeway import report", {"report"}),
        ("import flangeway\nflangeway.report.plot_result(1)", {TOP}),
        ("importlib.import_module('flangeway.report').plot_result(1)", {"report"}),
        ("import_module('..report', __package__)", {"report"}),
        ("__import__('flangeway.mesh.refine')", {"mesh.refine"}),
        ("TABLE = {'plot': 'flangeway.report.figures.plots:plot_result'}", {"report.figures.plots"}),
        ("lazy_loader.attach(__name__, submod_attrs={'.mesh_repair': ['repaired']})", {"formats.mesh_repair"}),
        ("files('flangeway.formats'), versions()['flangeway'], '.csv', 'report', 'flangeway.toml'", set()),
    ],
)
def test_imports_by_texts_are_seen(text: str, modules: set[str]) -> None:
    """A module of `formats` that names another one in a text imports it, whatever function takes the text."""
    assert imports_in(ast.parse(text), "flangeway.formats") == modules


def test_only_space_and_solve_use_the_compiled_core() -> None:
    """The sparse machinery is called from two folders, so that it can be replaced."""
    users = {name.partition(".")[0] for name, found in IMPORTS.items() if "_core" in found}
    assert users <= {"space", "solve"}


def test_the_guide_for_contributors_shows_this_order() -> None:
    """The tree in CONTRIBUTING.md has each sub-package once, in the order of imports."""
    text = (PACKAGE.parents[1] / "CONTRIBUTING.md").read_text(encoding="utf-8")
    tree = text.partition("src/flangeway/\n")[2].partition("core/")[0]
    assert re.findall(r"(\w+)\.py ", tree) == [*FILES_AT_THE_TOP]
    folders, above = [], ""
    for indent, folder in re.findall(r"^( +)(\w+)/", tree, flags=re.MULTILINE):
        above = above if len(indent) == 4 else folder
        folders.append(folder if len(indent) == 2 else f"{above}.{folder}")
    shown = [folder for folder in dict.fromkeys(folders) if folder != "railway"]
    assert shown == [folder for folder in FOLDERS if folder != "railway"]


def test_only_the_command_knows_the_studies():
    """No module of the package names `flangeway_studies` but the command that runs them."""
    users = {name for name, path in MODULES.items() if "flangeway_studies" in path.read_text("utf-8")}
    assert users == {"cli.reproduce_command"}
