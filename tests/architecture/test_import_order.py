"""The house's plan: imports go one way, and compiled code has two doors."""

import ast
from pathlib import Path

import pytest

PACKAGE = Path(__file__).parents[2] / "src" / "flangeway"
ORDER = (
    "errors",
    "checks",
    "exact",
    "geometry",
    "mesh",
    "elements",
    "space",
    "materials",
    "problems",
    "solve",
    "contact",
    "post",
    "railway",
    "study",
    "report",
    "cli",
    "__main__",
)
MODULES = sorted(path for path in PACKAGE.rglob("*.py") if path != PACKAGE / "__init__.py")


def folder(path: Path) -> str:
    return path.relative_to(PACKAGE).parts[0].removesuffix(".py")


def imported(path: Path) -> set[str]:
    """First parts below flangeway of everything that a module imports, inside functions too."""
    names = set()
    for node in ast.walk(ast.parse(path.read_text())):
        if isinstance(node, ast.Import):
            names |= {alias.name for alias in node.names}
        elif isinstance(node, ast.ImportFrom):
            assert node.level == 0, f"{path}: relative import"
            names |= {f"{node.module}.{alias.name}" for alias in node.names}
    parts = [name.split(".") for name in names]
    return {part[1] for part in parts if part[0] == "flangeway" and len(part) > 1}


@pytest.mark.parametrize("path", MODULES, ids=lambda path: str(path.relative_to(PACKAGE)))
def test_a_module_imports_only_from_folders_before_its_own(path: Path) -> None:
    """Imports follow the order of the design: nothing reaches up the list."""
    own = ORDER.index(folder(path))
    above = {name for name in imported(path) & set(ORDER) if ORDER.index(name) > own}
    assert not above


def test_every_folder_has_its_place() -> None:
    """A new folder must be given a place in the order before it can be used."""
    assert {folder(path) for path in MODULES} <= set(ORDER)


def test_only_space_and_solve_use_the_compiled_core() -> None:
    """The sparse machinery is called from two folders, so that it can be replaced."""
    users = {folder(path) for path in MODULES if "_core" in imported(path)}
    assert users <= {"space", "solve"}
