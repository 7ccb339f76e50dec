"""The house's plan: imports go one way, between sub-packages too, without circles; compiled code has two doors."""

import pytest

from tests.architecture.conftest import IMPORTS, MODULES

ORDER = (
    "errors",
    "types",
    "checks",
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
    "post",
    "railway.profiles",
    "railway.track",
    "railway.rigid",
    "railway.wheelset",
    "railway.positions",
    "railway.spatial",
    "cases",
    "campaign",
    "report",
    "validation",
    "cli",
    "__main__",
)


def floor(name: str) -> int:
    """Number of the folder in the order that a module belongs to."""
    return next(number for number, folder in enumerate(ORDER) if f"{name}.".startswith(f"{folder}."))


@pytest.mark.parametrize("name", MODULES)
def test_a_module_imports_only_from_folders_before_its_own(name: str) -> None:
    """Imports follow the order of the design: nothing reaches up the list."""
    known = {each for each in IMPORTS[name] if each != "_core"}
    assert not {each for each in known if floor(each) > floor(name)}


def test_only_space_and_solve_use_the_compiled_core() -> None:
    """The sparse machinery is called from two folders, so that it can be replaced."""
    users = {name.partition(".")[0] for name, found in IMPORTS.items() if "_core" in found}
    assert users <= {"space", "solve"}
