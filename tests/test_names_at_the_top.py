"""The names that scripts take from the package itself."""

import ast
import subprocess
import sys
from pathlib import Path

import pytest

import flangeway


def test_importing_loads_nothing_heavy():
    """Importing the package loads neither NumPy nor matplotlib, and its first names of mechanics no matplotlib."""
    code = (
        "import sys, flangeway; assert not {'numpy', 'scipy', 'matplotlib'} & set(sys.modules); "
        "flangeway.solve_elasticity; assert 'numpy' in sys.modules and 'matplotlib' not in sys.modules"
    )
    subprocess.run([sys.executable, "-c", code], check=True)


def test_every_name_is_there():
    """Every listed name is found, is listed by dir, and is the object of that name in its package."""
    assert set(flangeway.__all__) <= set(dir(flangeway))
    for name in flangeway.__all__:
        value = getattr(flangeway, name)
        assert value is getattr(sys.modules[f"flangeway.{flangeway._PACKAGE_OF[name]}"], name)
    for name in flangeway._PACKAGES:
        assert getattr(flangeway, name).__name__ == f"flangeway.{name}"


def test_names_are_few_and_explained():
    """There are not more than thirty-six names, and the package's own text speaks of each."""
    assert len(flangeway.__all__) <= 36
    assert [name for name in flangeway.__all__ if f"`{name}`" not in flangeway.__doc__] == []


def test_type_checkers_see_the_same_names():
    """What type checkers import is what is loaded when it is used, from the same packages."""
    tree = ast.parse(Path(flangeway.__file__).read_text(encoding="utf-8"))
    block = next(node for node in tree.body if isinstance(node, ast.If))
    imported = {}
    for node in (each for each in block.body if isinstance(each, ast.ImportFrom)):
        imported.setdefault(node.module, set()).update(alias.name for alias in node.names)
    wanted = {f"flangeway.{package}": set(names) for package, names in flangeway._HOMES.items()}
    assert imported == {"flangeway": set(flangeway._PACKAGES), **wanted}
    assert set(flangeway.__all__) == set().union(*flangeway._HOMES.values())


def test_unknown_names_are_an_attribute_error():
    """A name that there is not is an AttributeError that tells it."""
    with pytest.raises(AttributeError, match="no attribute 'solve_everything'"):
        _ = flangeway.solve_everything
